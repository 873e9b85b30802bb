//! Pictures of the world as a camera's sensor gives them, drawn by wgpu without a window.
//!
//! ```text
//! View ─> floor pass (rasterised faces, then bands)     ─> plate in cd/m² ─> lens and photons, one pass ─> GrayImage
//!      or room pass (faces, lamps, people; then edges)
//! ```
//!
//! The plate is the image that a pinhole camera would take; the lens pass looks up in it where each pixel of the sensor takes its light from. All
//! views of a tick are submitted to the device at once. The same world, views and adapter give the same bytes. A further camera is added as a
//! further [`View`], a further kind of surface as a further pass onto the same plate.

use image::GrayImage;
use nalgebra::Isometry3;
use thiserror::Error;

use crate::{
    optics::Lens,
    place::{building::UprightBody, light::FloorField},
    scene::{BitDepth, MAX_LAMPS, Scene, SensorModel},
    world::Drawn,
};

mod device;
mod exposure;
mod floor;
mod lens;
mod light;
mod photons;
mod rendered_world;
mod room;
mod target;
mod texels;

pub use light::FloorLight;
pub use rendered_world::RenderedWorld;

use device::Graphics;
use floor::{Floor, FloorPass};
use photons::{PhotonPass, PictureMemory};
use rendered_world::Lamps;
use room::RoomPass;
use target::{Levels, Target};

/// Number of targets (device memory of views) that are kept although the present tick does not need them: those of other cameras will be
/// needed again.
const MOST_SPARE_TARGETS: usize = 8;

/// An image with grey levels of more than eight bits.
pub type DeepImage = image::ImageBuffer<image::Luma<u16>, Vec<u16>>;

/// Description of one picture to take. Camera frame: x right, y down, z forward.
#[derive(Clone, Debug)]
pub struct View {
    /// The part of the world that the picture shows.
    pub shows: Shows,
    /// The lens through which the picture is taken.
    pub lens: Lens,
    /// The sensor that turns light into grey levels.
    pub sensor: SensorModel,
    /// Camera poses at equal steps of time, from the start of the first row's exposure to the end of the last row's; a single pose if the
    /// camera does not move.
    pub world_from_camera: Vec<Isometry3<f64>>,
    /// Length of the exposure of each row.
    pub exposure_s: f64,
    /// Gain of the sensor: grey levels, at its own bit depth, per electron.
    pub gain_levels_per_electron: f64,
    /// Mean illuminance over the room's floor.
    pub illuminance_at_floor_lux: f64,
    /// Key of the random noise of this picture.
    pub noise: NoiseKey,
}

/// The part of the world that a picture (view) shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// The floor alone, seen from near: joints, wear, stray wires and tape, and the pattern of tiles.
    Floor,
    /// The whole room: everything that stands in the building or moves in it.
    Room,
}

/// Key of the noise of one picture: another seed or another number gives independent noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NoiseKey {
    /// Seed of the run, mixed with the name of the camera if there are several.
    pub seed: u64,
    /// Number of the picture since the start of the run.
    pub image: u32,
}

/// Reason why no picture could be drawn.
#[derive(Debug, Error)]
pub enum RenderError {
    /// There is no graphics adapter, real or software, that can be used.
    #[error(
        "find a graphics adapter{}; `make driver` installs a software one{}",
        wanted.as_ref().map(|name| format!(" whose name contains \"{name}\" (--adapter or WHEREIN_ADAPTER)")).unwrap_or_default(),
        if found.is_empty() { String::new() } else { format!("; found: {}", found.join(", ")) }
    )]
    NoAdapter {
        /// Name of the adapter that was asked for.
        wanted: Option<String>,
        /// Names of the adapters that were found.
        found: Vec<String>,
    },
    /// The adapter lacks something that the renderer needs.
    #[error("open the graphics adapter {adapter}: {reason}")]
    Unusable {
        /// Name of the adapter.
        adapter: String,
        /// Message of the graphics driver.
        reason: String,
    },
    /// The world or the picture does not fit on the graphics device.
    #[error("draw {what}: it takes {needed}, where the graphics adapter allows {limit}")]
    TooLarge {
        /// Name of the thing that is too large.
        what: &'static str,
        /// Size that the thing needs, with its unit.
        needed: String,
        /// Greatest size that the adapter allows, with its unit.
        limit: String,
    },
    /// The view cannot be drawn.
    #[error("draw a view: {0}")]
    BadView(&'static str),
    /// The graphics driver reported an error or lost the device.
    #[error("draw a picture: the graphics driver reported: {0}")]
    Device(String),
    /// The graphics driver did not finish in time.
    #[error("draw a picture: the graphics driver did not answer within {waited_s} s")]
    Hung {
        /// Time for which the driver's answer was awaited, in seconds.
        waited_s: f64,
    },
}

/// The graphics device with its pipelines. A process should make one renderer, and siblings of it for further threads, because OpenGL
/// contexts abort when threads share them.
pub struct Renderer {
    graphics: Graphics,
    floor_pass: FloorPass,
    room_pass: RoomPass,
    photon_pass: PhotonPass,
    /// Targets (device memory) for the pictures of the present tick, followed by those for pictures of some earlier ticks. They are kept because
    /// a lens's map takes a while to compute.
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

    /// Opens the adapter that has `adapter` in its name, driver or backend; without a name it does the same as [`Renderer::new`].
    ///
    /// # Errors
    /// If there is no such adapter or it cannot be opened.
    pub fn on_adapter(adapter: Option<&str>) -> Result<Renderer, RenderError> {
        Renderer::on(Graphics::open(adapter)?)
    }

    /// Another renderer for another thread, on the same device or, with a software driver, on a device of its own; `None` if the driver
    /// does not allow several threads.
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

    /// Name, driver and backend of the adapter: pictures have the same bytes only on the same adapter.
    pub fn adapter(&self) -> String {
        self.graphics.adapter_name()
    }

    /// Prepares a world on the graphics device for pictures of its floor.
    ///
    /// # Errors
    /// If the driver reported an error earlier, or lost the device.
    pub fn upload(&mut self, scene: &Scene, drawn: &Drawn) -> Result<RenderedWorld, RenderError> {
        self.graphics.check_alive()?;
        let (mut lamplight, mut lamps) = (None, None);
        if !scene.lamps.is_empty() {
            let (lit, (_, map)) = Lamps::of(scene, drawn);
            lamplight = FloorField::new(&lit.building, &map, &map.nodes);
            lamps = Some(lit);
        }
        Ok(RenderedWorld {
            floor: Floor::new(scene, drawn, lamplight),
            room: None,
            lamps,
            graphics: self.graphics.clone(),
        })
    }

    /// Prepares a world on the graphics device for pictures of whole rooms and of the floor, with people where they start. The world's light is
    /// computed here, which takes up to a second.
    ///
    /// # Errors
    /// If the driver reported an error earlier, or lost the device.
    pub fn upload_room(&mut self, scene: &Scene, drawn: &Drawn) -> Result<RenderedWorld, RenderError> {
        self.graphics.check_alive()?;
        let (lamps, light) = Lamps::of(scene, drawn);
        let room = self.room_pass.upload(&self.graphics, lamps.building.clone(), light);
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
            lamps: Some(lamps),
            room: Some(room),
            graphics: self.graphics.clone(),
        };
        world.place_bodies(&scene.people.iter().filter_map(UprightBody::at_start).collect::<Vec<_>>());
        Ok(world)
    }

    /// Takes the pictures that `views` describe, all at once and in their order, with the eight most significant bits of each grey level.
    ///
    /// # Errors
    /// If a view has no pose or is larger than the device allows, or if the driver reports an error or does not answer.
    pub fn draw(&mut self, world: &RenderedWorld, views: &[View]) -> Result<Vec<GrayImage>, RenderError> {
        let together: Vec<(&RenderedWorld, &View)> = views.iter().map(|view| (world, view)).collect();
        self.draw_together(&together)
    }

    /// Takes pictures like [`Renderer::draw`], but each picture is of a world of its own; all are still submitted at once.
    ///
    /// # Errors
    /// As for [`Renderer::draw`].
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

    /// Takes the same pictures as [`Renderer::draw`], but with all bits that the sensors give.
    ///
    /// # Errors
    /// As for [`Renderer::draw`].
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
            let Target { floor, room, lens, photons, levels, .. } = target;
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
            let of = PictureMemory { lens, room: room.as_ref(), photons, levels };
            self.photon_pass.draw(&self.graphics, &mut encoder, (&world.floor, view), of);
        }
        // The pictures' grey levels are copied to readable buffers last, because a software driver waits at each copy for everything that was
        // drawn before.
        self.targets.iter().take(views.len()).for_each(|target| target.stage(&mut encoder));
        let submission = self.graphics.queue.submit([encoder.finish()]);
        let mappings: Vec<_> = self.targets.iter().take(views.len()).map(Target::map).collect();
        self.graphics.wait(submission)?;
        mappings.iter().try_for_each(|mapping| self.graphics.answer(mapping))?;
        self.targets.iter().take(views.len()).map(Target::read).collect()
    }

    /// Puts the targets (device memory) that suit the pictures to take first, in the order of `views`, and makes those that are missing.
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
