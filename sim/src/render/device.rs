//! The graphics adapter: which one, and how errors and hung waits come back as `RenderError`.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use wgpu::{Adapter, Backends, DeviceType};

use super::RenderError;

/// Environment variable that picks an adapter by a part of its name, driver or backend.
const ADAPTER_VARIABLE: &str = "WHEREIN_ADAPTER";

/// A tick of pictures takes milliseconds; a driver that is silent this long does not come back.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);

/// An open device and the first error its driver reported. Clones share the device.
#[derive(Clone, Debug)]
pub(super) struct Graphics {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    reported: Arc<Mutex<Option<String>>>,
}

impl Graphics {
    /// Opens the adapter that [`choose`] picks, with all that it offers.
    pub(super) fn open(wanted: Option<&str>) -> Result<Graphics, RenderError> {
        let wanted = wanted.map(str::to_owned).or_else(|| std::env::var(ADAPTER_VARIABLE).ok());
        let adapter = choose(wanted)?;
        let info = adapter.get_info();
        let unusable = |reason: String| RenderError::Unusable { adapter: describe(&info), reason };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("wherein"),
            required_features: wgpu::Features::FLOAT32_BLENDABLE,
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
        device.set_device_lost_callback(move |reason, message| {
            // The renderer's own end is no error.
            if reason != wgpu::DeviceLostReason::Destroyed {
                keep_first(&on_loss, format!("device lost: {message}"));
            }
        });
        Ok(Graphics { device, queue, info, reported })
    }

    /// Name, driver and backend.
    pub(super) fn adapter_name(&self) -> String {
        describe(&self.info)
    }

    /// Whether several threads may use the device at once: contexts of OpenGL abort.
    pub(super) fn allows_threads(&self) -> bool {
        self.info.backend != wgpu::Backend::Gl
    }

    /// The first error that the driver reported, if any.
    pub(super) fn check(&self) -> Result<(), RenderError> {
        let reported = self.reported.lock().unwrap_or_else(PoisonError::into_inner);
        reported.as_ref().map_or(Ok(()), |message| Err(RenderError::Device(message.clone())))
    }

    /// Waits until the submission is done and its mappings are answered.
    pub(super) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), RenderError> {
        let outcome =
            self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(PATIENCE) });
        self.check()?;
        match outcome {
            Ok(_) => Ok(()),
            Err(wgpu::PollError::Timeout) => Err(RenderError::Hung { waited_s: PATIENCE.as_secs() }),
            Err(error) => Err(RenderError::Device(error.to_string())),
        }
    }
}

/// The adapter to use: a real one before a software one, and the system's own interface before OpenGL.
///
/// OpenGL is asked last and apart, because its contexts abort when several threads share an instance.
fn choose(wanted: Option<String>) -> Result<Adapter, RenderError> {
    let mut found = Vec::new();
    for backends in [Backends::PRIMARY, Backends::GL] {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends;
        let instance = wgpu::Instance::new(descriptor);
        let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
        adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
        let pick = adapters.iter().position(|adapter| {
            let name = describe(&adapter.get_info()).to_lowercase();
            wanted.as_ref().is_none_or(|part| name.contains(&part.to_lowercase()))
        });
        found.extend(adapters.iter().map(|adapter| describe(&adapter.get_info())));
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
