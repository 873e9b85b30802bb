//! Pictures of the world as a camera's sensor gives them, drawn headlessly by wgpu.
//!
//! ```text
//! View ─> floor pass (rasterised faces, then bands)     ─> plate in cd/m² ─> lens and photons, one pass ─> GrayImage
//!      or room pass (faces, lamps, people; then edges)
//! ```
//!
//! All views of a tick go in one submit. Same world, views and adapter: same bytes. A further camera is a further
//! [`View`]; a further kind of surface is a further pass onto the same plate.

use image::GrayImage;
use nalgebra::Isometry3;
use thiserror::Error;

use crate::{
    building::{Building, UprightBody},
    drawn::Drawn,
    light::{FloorField, bake},
    optics::Lens,
    scene::{BitDepth, MAX_LAMPS, Scene, SensorModel},
};

mod device;
mod exposure;
mod floor;
mod lens;
mod light;
mod photons;
mod room;
mod target;

pub use light::FloorLight;

use device::Graphics;
use floor::{Floor, FloorPass};
use photons::PhotonPass;
use room::{RoomPass, RoomWorld};
use target::{Levels, Target};

/// Targets that are kept though a tick does not need them: those of other cameras, whose turn comes again.
const MOST_SPARE_TARGETS: usize = 8;

/// Grey levels of more than eight bits.
pub type DeepImage = image::ImageBuffer<image::Luma<u16>, Vec<u16>>;

/// One picture to take. Camera frame: x right, y down, z forward.
#[derive(Clone, Debug)]
pub struct View {
    /// What of the world it shows.
    pub shows: Shows,
    /// The lens through which it does.
    pub lens: Lens,
    /// What turns light into grey levels.
    pub sensor: SensorModel,
    /// Camera poses at equal steps of time, from the start of the first row's exposure to the end of the last row's; one pose if nothing moves.
    pub world_from_camera: Vec<Isometry3<f64>>,
    /// Length of the exposure.
    pub exposure_s: f64,
    /// Grey levels of the sensor's own depth per electron.
    pub gain_levels_per_electron: f64,
    /// Mean illuminance over the room's floor.
    pub illuminance_at_floor_lux: f64,
    /// Where the noise of this picture comes from.
    pub noise: NoiseKey,
}

/// What of the world a view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// The floor alone, from near: joints, wear, strays, what is printed on tiles.
    Floor,
    /// All that stands in the building and moves in it.
    Room,
}

/// Names the noise of one picture: another seed or another number gives independent noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NoiseKey {
    /// Seed of the run, mixed with the name of the camera if there are several.
    pub seed: u64,
    /// Number of the picture since the start.
    pub image: u32,
}

/// A world as it is drawn, made by [`Renderer::upload`].
#[derive(Debug)]
pub struct RenderedWorld {
    floor: Floor,
    room: Option<RoomWorld>,
    lamps_at_floor_lux: Option<f64>,
    graphics: Graphics,
}

impl RenderedWorld {
    /// Mean illuminance at the floor of the robot's room as the scene's lamps give it; `None` where it has none and only
    /// the floor was uploaded.
    pub fn illuminance_at_floor_lux(&self) -> Option<f64> {
        self.lamps_at_floor_lux
    }

    /// Puts people where the next pictures show them when their exposure ends; until then they walk. Their shadows are worked out here,
    /// once for all views.
    pub fn place_bodies(&mut self, bodies: &[UprightBody]) {
        let Some(room) = &mut self.room else { return };
        if let Some(nodes) = room.place_bodies(&self.graphics, bodies)
            && self.floor.lamplight.is_some()
        {
            self.floor.lamplight = room.floor_field(&nodes);
        }
    }
}

/// Why no picture came.
#[derive(Debug, Error)]
pub enum RenderError {
    /// No graphics adapter, real or software, that could be used.
    #[error(
        "find a graphics adapter{}; `make driver` installs a software one{}",
        wanted.as_ref().map(|name| format!(" whose name contains \"{name}\" (--adapter or WHEREIN_ADAPTER)")).unwrap_or_default(),
        if found.is_empty() { String::new() } else { format!("; found: {}", found.join(", ")) }
    )]
    NoAdapter {
        /// What was asked for.
        wanted: Option<String>,
        /// Adapters that are there.
        found: Vec<String>,
    },
    /// The adapter cannot do what the renderer needs.
    #[error("open the graphics adapter {adapter}: {reason}")]
    Unusable {
        /// Name of the adapter.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The world or the picture does not fit on the device.
    #[error("draw {what}: it takes {needed}, where the graphics adapter allows {limit}")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// What it takes, with its unit.
        needed: String,
        /// What there is.
        limit: String,
    },
    /// A view that cannot be drawn.
    #[error("draw a view: {0}")]
    BadView(&'static str),
    /// The driver reported an error or lost the device.
    #[error("draw a picture: the graphics driver reported: {0}")]
    Device(String),
    /// The driver did not finish in time.
    #[error("draw a picture: the graphics driver did not answer within {waited_s} s")]
    Hung {
        /// Time waited.
        waited_s: f64,
    },
}

/// The graphics device with its pipelines. Make one per process, and siblings of it for further threads: contexts of OpenGL abort when
/// threads share them.
pub struct Renderer {
    graphics: Graphics,
    floor_pass: FloorPass,
    room_pass: RoomPass,
    photon_pass: PhotonPass,
    /// One per view of a tick and those of some ticks before, kept as a lens's map takes a while.
    targets: Vec<Target>,
}

impl Renderer {
    /// Opens the best adapter, or the one that `WHEREIN_ADAPTER` names by a part of its name, driver or backend.
    ///
    /// # Errors
    /// If there is no such adapter or it cannot be opened.
    pub fn new() -> Result<Renderer, RenderError> {
        Renderer::on_adapter(None)
    }

    /// Opens the adapter that has `adapter` in its name, driver or backend; without one, as [`Renderer::new`].
    ///
    /// # Errors
    /// If there is no such adapter or it cannot be opened.
    pub fn on_adapter(adapter: Option<&str>) -> Result<Renderer, RenderError> {
        Renderer::on(Graphics::open(adapter)?)
    }

    /// Another renderer for another thread: on the same device, or with a software driver on one of its own; none when the driver does not
    /// allow several threads.
    ///
    /// # Errors
    /// If the driver reported an error.
    pub fn sibling(&self) -> Result<Option<Renderer>, RenderError> {
        self.graphics.for_another_thread()?.map(Renderer::on).transpose()
    }

    fn on(graphics: Graphics) -> Result<Renderer, RenderError> {
        let floor_pass = FloorPass::new(&graphics.device);
        let room_pass = RoomPass::new(&graphics.device);
        let photon_pass = PhotonPass::new(&graphics.device);
        graphics.check()?;
        Ok(Renderer { graphics, floor_pass, room_pass, photon_pass, targets: Vec::new() })
    }

    /// Name, driver and backend of the adapter: pictures are the same bytes only on the same one.
    pub fn adapter(&self) -> String {
        self.graphics.adapter_name()
    }

    /// Prepares a world for views of its floor.
    ///
    /// # Errors
    /// If the driver reported an error since, or lost the device.
    pub fn upload(&mut self, scene: &Scene, drawn: &Drawn) -> Result<RenderedWorld, RenderError> {
        self.graphics.check_alive()?;
        let (mut lamplight, mut lamps_at_floor_lux) = (None, None);
        if !scene.lamps.is_empty() {
            let building = Building::new(scene, drawn);
            let (lighting, map) = bake(scene, &building);
            lamps_at_floor_lux = Some(map.mean_at_floor.lux * lighting.dimming);
            lamplight = FloorField::new(&building, &map, &map.nodes);
        }
        let floor = Floor::new(scene, drawn, lamplight);
        Ok(RenderedWorld { floor, room: None, lamps_at_floor_lux, graphics: self.graphics.clone() })
    }

    /// Prepares a world for all views, its people at the start; its light is worked out here, which takes up to a second.
    ///
    /// # Errors
    /// If the driver reported an error since, or lost the device.
    pub fn upload_room(&mut self, scene: &Scene, drawn: &Drawn) -> Result<RenderedWorld, RenderError> {
        self.graphics.check_alive()?;
        let room = self.room_pass.upload(&self.graphics, scene, drawn);
        if room.lamp_count as usize > MAX_LAMPS {
            return Err(RenderError::TooLarge {
                what: "a room",
                needed: format!("{} lamps", room.lamp_count),
                limit: format!("{MAX_LAMPS}"),
            });
        }
        let lamplight = if scene.lamps.is_empty() { None } else { room.floor_field(room.still_nodes()) };
        let mut world = RenderedWorld {
            floor: Floor::new(scene, drawn, lamplight),
            lamps_at_floor_lux: Some(room.mean_at_floor_lux()),
            room: Some(room),
            graphics: self.graphics.clone(),
        };
        world.place_bodies(&scene.people.iter().filter_map(UprightBody::at_start).collect::<Vec<_>>());
        Ok(world)
    }

    /// Takes all pictures of a tick, in the order of `views`: the eight most significant bits of each level.
    ///
    /// # Errors
    /// If a view has no pose or is larger than the device allows, or the driver reports an error or does not answer.
    pub fn draw(&mut self, world: &RenderedWorld, views: &[View]) -> Result<Vec<GrayImage>, RenderError> {
        let together: Vec<(&RenderedWorld, &View)> = views.iter().map(|view| (world, view)).collect();
        self.draw_together(&together)
    }

    /// As [`Renderer::draw`], each view of a world of its own; still one submit.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn draw_together(&mut self, views: &[(&RenderedWorld, &View)]) -> Result<Vec<GrayImage>, RenderError> {
        let pictures = self.read_out(views)?.into_iter().zip(views).map(|(levels, (_, view))| {
            let pixels = match levels {
                Levels::Eight(levels) => levels,
                Levels::Deep(levels) => {
                    levels.into_iter().map(|level| view.sensor.bits.most_significant(level)).collect()
                }
            };
            let [width, height] = view.lens.size_px;
            GrayImage::from_raw(width, height, pixels).ok_or(RenderError::BadView("its picture has another size"))
        });
        pictures.collect()
    }

    /// The same pictures with all bits that the sensors give.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn draw_deep(&mut self, world: &RenderedWorld, views: &[View]) -> Result<Vec<DeepImage>, RenderError> {
        let together: Vec<(&RenderedWorld, &View)> = views.iter().map(|view| (world, view)).collect();
        let pictures = self.read_out(&together)?.into_iter().zip(views).map(|(levels, view)| {
            let pixels = match levels {
                Levels::Eight(levels) => levels.into_iter().map(u16::from).collect(),
                Levels::Deep(levels) => levels,
            };
            let [width, height] = view.lens.size_px;
            DeepImage::from_raw(width, height, pixels).ok_or(RenderError::BadView("its picture has another size"))
        });
        pictures.collect()
    }

    fn read_out(&mut self, views: &[(&RenderedWorld, &View)]) -> Result<Vec<Levels>, RenderError> {
        self.prepare_targets(views)?;
        let device = &self.graphics.device;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for ((world, view), target) in views.iter().zip(&mut self.targets) {
            let Target { floor, room, lens, .. } = target;
            match (view.shows, &world.room) {
                (Shows::Floor, _) => {
                    self.floor_pass.draw(&self.graphics, &mut encoder, &world.floor, view, floor, lens)?
                }
                (Shows::Room, Some(seen)) => {
                    let through = (&self.photon_pass.lens_layout, &*lens);
                    self.room_pass.draw(&self.graphics, &mut encoder, seen, view, through, room)?
                }
                (Shows::Room, None) => return Err(RenderError::BadView("only the world's floor was uploaded")),
            }
            self.photon_pass.draw(&self.graphics, &mut encoder, (&world.floor, view), target);
        }
        // Copies last: a software driver waits with each for all that was drawn before.
        self.targets.iter().take(views.len()).for_each(|target| target.stage(&mut encoder));
        let submission = self.graphics.queue.submit([encoder.finish()]);
        let mappings: Vec<_> = self.targets.iter().take(views.len()).map(Target::map).collect();
        self.graphics.wait(submission)?;
        mappings.iter().try_for_each(|mapping| self.graphics.answer(mapping))?;
        self.targets.iter().take(views.len()).map(Target::read).collect()
    }

    /// Puts first, in the order of the views, targets that suit them.
    fn prepare_targets(&mut self, views: &[(&RenderedWorld, &View)]) -> Result<(), RenderError> {
        for (index, (_, view)) in views.iter().enumerate() {
            let spare = (index..self.targets.len()).find(|spare| self.targets[*spare].suits(view));
            let suiting = match spare {
                Some(spare) => spare,
                None => {
                    self.targets.push(self.target_for(view)?);
                    self.targets.len() - 1
                }
            };
            self.targets.swap(index, suiting);
        }
        self.targets.truncate(views.len() + MOST_SPARE_TARGETS);
        Ok(())
    }

    fn target_for(&self, view: &View) -> Result<Target, RenderError> {
        let size_px = view.lens.size_px;
        let limit_px = self.graphics.device.limits().max_texture_dimension_2d;
        if size_px[0].max(size_px[1]) > limit_px {
            return Err(RenderError::TooLarge {
                what: "a view",
                needed: format!("{} × {} px", size_px[0], size_px[1]),
                limit: format!("{limit_px} px"),
            });
        }
        let deep = view.sensor.bits != BitDepth::Eight;
        Target::new(&self.graphics, &self.floor_pass, &self.photon_pass, &view.lens, deep)
    }
}
