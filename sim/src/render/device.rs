//! The graphics adapter: how it is chosen, and how its errors and hung waits become a `RenderError`.

use std::{
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{Receiver, RecvTimeoutError},
    },
    time::Duration,
};

use bytemuck::Pod;
use wgpu::{Adapter, Backends, DeviceType};

use super::RenderError;

/// Environment variable that chooses an adapter by a part of its name, driver or backend.
const ADAPTER_VARIABLE: &str = "WHEREIN_ADAPTER";

/// Time after which a silent driver counts as hung; the pictures of a tick take milliseconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// Receives the driver's answer whether the processor may read a staging buffer (its mapping); the answer comes when the device is polled.
pub(super) type Mapping = Receiver<Result<(), wgpu::BufferAsyncError>>;

/// An open graphics device, and the first error that its driver reported. Clones share the device.
#[derive(Clone, Debug)]
pub(super) struct Graphics {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    /// Time that the graphics driver may be silent before it counts as hung.
    patience: Duration,
    reported: Arc<Mutex<Option<String>>>,
}

impl Graphics {
    /// Opens the adapter that [`choose`] picks, with the highest limits that it offers.
    pub(super) fn open(wanted: Option<&str>) -> Result<Graphics, RenderError> {
        let wanted = wanted.map(str::to_owned).or_else(|| std::env::var(ADAPTER_VARIABLE).ok());
        let adapter = choose(wanted)?;
        let info = adapter.get_info();
        let unusable = |reason: String| RenderError::Unusable { adapter: describe(&info), reason };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("wherein"),
            required_features: NEEDED,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| unusable(error.to_string()))?;
        let reported = Arc::new(Mutex::new(None));
        let on_error = Arc::clone(&reported);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            keep_first(&on_error, error.to_string());
        }));
        let on_loss = Arc::clone(&reported);
        // The callback for a lost device is also called when the renderer itself closes the device; its message is then never read.
        device.set_device_lost_callback(move |_, message| keep_first(&on_loss, format!("device lost: {message}")));
        Ok(Graphics { device, queue, info, patience: PATIENCE, reported })
    }

    /// Access to the graphics device for another thread, or `None` if the driver does not allow several threads. It is the same device, or a
    /// device of its own for a software adapter, because one instance of a software driver draws for one thread after the other.
    pub(super) fn for_another_thread(&self) -> Result<Option<Graphics>, RenderError> {
        match (self.info.backend, self.info.device_type) {
            // OpenGL contexts abort when several threads use them.
            (wgpu::Backend::Gl, _) => Ok(None),
            (_, DeviceType::Cpu) => Graphics::open(Some(&self.adapter_name())).map(Some),
            _ => Ok(Some(self.clone())),
        }
    }

    /// Name, driver and backend of the adapter.
    pub(super) fn adapter_name(&self) -> String {
        describe(&self.info)
    }

    /// Checks that the device is not lost and that its driver has reported no error, as far as that is known without giving it work.
    pub(super) fn check_alive(&self) -> Result<(), RenderError> {
        // The loss of a device is reported only when the device is polled; whatever else polling may fail of is reported through the
        // callback, too.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.check()
    }

    /// The first error that the driver reported, as an error; success if there is none.
    pub(super) fn check(&self) -> Result<(), RenderError> {
        let reported = self.reported.lock().unwrap_or_else(PoisonError::into_inner);
        reported.as_ref().map_or(Ok(()), |message| Err(RenderError::Device(message.clone())))
    }

    /// The driver's answer whether the processor may read a staging buffer (its mapping). If threads share the device, the answer may arrive
    /// while another thread polls the device, so that it is waited for.
    pub(super) fn answer(&self, mapping: &Mapping) -> Result<(), RenderError> {
        match mapping.recv_timeout(self.patience) {
            Ok(outcome) => outcome.map_err(|error| RenderError::Device(error.to_string())),
            Err(RecvTimeoutError::Timeout) => Err(self.hung()),
            Err(error) => Err(RenderError::Device(error.to_string())),
        }
    }

    /// A buffer that holds `content`; it has at least 256 bytes, even if `content` is empty.
    pub(super) fn buffer<T: Pod>(&self, label: &str, usage: wgpu::BufferUsages, content: &[T]) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (bytes.len() as u64).next_multiple_of(4).max(256),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    fn hung(&self) -> RenderError {
        RenderError::Hung { waited_s: self.patience.as_secs_f64() }
    }

    /// Waits until the device has done the submitted work and the driver has answered the requests to read staging buffers (the mappings).
    pub(super) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), RenderError> {
        let outcome =
            self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(self.patience) });
        self.check()?;
        match outcome {
            Ok(_) => Ok(()),
            Err(wgpu::PollError::Timeout) => Err(self.hung()),
            Err(error) => Err(RenderError::Device(error.to_string())),
        }
    }
}

/// Features that the renderer needs to blend and filter radiances, which are floating-point textures.
const NEEDED: wgpu::Features = wgpu::Features::FLOAT32_BLENDABLE.union(wgpu::Features::FLOAT32_FILTERABLE);

/// Chooses the adapter to use: a real one before a software one, and the system's own interface before OpenGL.
///
/// OpenGL is tried last and on its own, because its contexts abort when several threads share an instance.
fn choose(wanted: Option<String>) -> Result<Adapter, RenderError> {
    let mut found = Vec::new();
    for backends in [Backends::PRIMARY, Backends::GL] {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends;
        let instance = wgpu::Instance::new(descriptor);
        let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
        adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
        let serves = |adapter: &Adapter| adapter.features().contains(NEEDED);
        let pick = adapters.iter().position(|adapter| {
            let name = describe(&adapter.get_info()).to_lowercase();
            wanted.as_ref().map_or_else(|| serves(adapter), |part| name.contains(&part.to_lowercase()))
        });
        found.extend(adapters.iter().map(|adapter| {
            let lacks = if serves(adapter) { "" } else { ", which cannot blend and filter floating-point textures" };
            describe(&adapter.get_info()) + lacks
        }));
        if let Some(index) = pick {
            return Ok(adapters.swap_remove(index));
        }
    }
    Err(RenderError::NoAdapter { wanted, found })
}

fn rank(kind: DeviceType) -> u8 {
    match kind {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Cpu => 3,
        DeviceType::Other => 4,
    }
}

fn describe(info: &wgpu::AdapterInfo) -> String {
    let driver = format!("{} {}", info.driver, info.driver_info);
    format!("{} ({}, {})", info.name, driver.trim(), info.backend)
}

fn keep_first(slot: &Mutex<Option<String>>, message: String) {
    slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::time::Instant;

    use localizer::{Pose, reading::Camera};

    use super::*;
    use crate::{render::Renderer, run::sensors::still::views_at, scene::Scene, world::Drawn};

    /// A shader with a long loop. Software drivers end a loop after 65 535 rounds; many workgroups make it last all the same: 0.7 s on two
    /// cores.
    const SLOW: &str = "
        @group(0) @binding(0) var<storage, read_write> words: array<u32>;
        @compute @workgroup_size(64)
        fn count(@builtin(global_invocation_id) id: vec3<u32>) {
            var word = id.x;
            for (var round = 0u; round < 30000000u; round++) {
                word = word * 1664525u + words[(word + round) % 64u];
            }
            words[id.x % 64u] = word;
        }";

    #[test]
    fn a_driver_that_does_not_answer_ends_in_an_error_in_time() {
        let graphics = Graphics { patience: Duration::from_millis(1), ..Graphics::open(None).unwrap() };
        let device = &graphics.device;
        let source = wgpu::ShaderSource::Wgsl(SLOW.into());
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source }),
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let words = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 256,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: words.as_entire_binding() }],
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.dispatch_workgroups(256, 1, 1);
        drop(pass);
        let submission = graphics.queue.submit([encoder.finish()]);
        let began = Instant::now();
        let outcome = graphics.wait(submission);
        assert!(began.elapsed() < Duration::from_secs(5), "{:?}", began.elapsed());
        let message = outcome.unwrap_err().to_string();
        assert_eq!(message, "draw a picture: the graphics driver did not answer within 0.001 s");
    }

    fn empty_room() -> (Scene, Drawn) {
        let text = "duration_s = 1.0\n[room]\nwidth_m = 3.0\ndepth_m = 3.0\n[start]\nx_m = 1.0\ny_m = 1.0\nheading_deg = 0\n\
            [[route.waypoint]]\nx_m = 2.0\ny_m = 1.0\n";
        let scene = Scene::parse(text, "gone.toml").unwrap();
        let drawn = Drawn::draw(&scene, 0);
        (scene, drawn)
    }

    #[test]
    fn a_device_that_is_gone_ends_in_an_error() {
        let (scene, drawn) = empty_room();
        let mut renderer = Renderer::new().unwrap();
        let world = renderer.upload(&scene, &drawn).unwrap();
        let pose = Pose { x_m: 1.0, y_m: 1.0, heading_rad: 0.0 };
        let views = views_at(&scene, &drawn, pose, 300.0, &[Camera::Floor], 0);
        renderer.draw(&world, &views).unwrap();
        renderer.graphics.device.destroy();
        let began = Instant::now();
        let error = renderer.draw(&world, &views).unwrap_err();
        assert!(began.elapsed() < Duration::from_secs(5), "{:?}", began.elapsed());
        assert!(matches!(&error, RenderError::Device(_)), "{error}");
    }

    #[test]
    fn no_world_is_uploaded_to_a_device_that_is_gone() {
        let (scene, drawn) = empty_room();
        for whole_room in [false, true] {
            let mut renderer = Renderer::new().unwrap();
            renderer.graphics.device.destroy();
            let outcome =
                if whole_room { renderer.upload_room(&scene, &drawn) } else { renderer.upload(&scene, &drawn) };
            let message = outcome.unwrap_err().to_string();
            assert!(message.starts_with("draw a picture: the graphics driver reported: device lost"), "{message}");
        }
    }
}
