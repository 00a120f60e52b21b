//! The graphics device.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::DisplayError;

/// An open graphics device.
#[derive(Debug)]
pub struct Gpu {
    /// Instance that creates surfaces.
    pub instance: wgpu::Instance,
    /// The adapter.
    pub adapter: wgpu::Adapter,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Description of the adapter.
    pub info: wgpu::AdapterInfo,
    fault: Arc<Mutex<Option<String>>>,
    /// Buffer of the last reading. It is kept, because drivers take milliseconds to make a buffer
    /// of a picture's size.
    staging: Mutex<Option<wgpu::Buffer>>,
}

/// Time after which a frame counts as hung. It is long, because a software driver compiles its
/// shaders in the first frame.
const PATIENCE: Duration = Duration::from_secs(120);

impl Gpu {
    /// Opens the best adapter without a window. `WGPU_BACKEND` and the driver's environment
    /// variables select another adapter.
    ///
    /// # Errors
    /// [`DisplayError::NoAdapter`], [`DisplayError::Device`].
    pub fn open() -> Result<Self, DisplayError> {
        let mut choice = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        if std::env::var_os("WGPU_BACKEND").is_some() {
            return Self::from_instance(wgpu::Instance::new(choice), None);
        }
        // OpenGL is only a fallback, because probing it starts a second driver.
        choice.backends = wgpu::Backends::PRIMARY;
        Self::from_instance(wgpu::Instance::new(choice), None).or_else(|_| {
            let mut choice = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
            choice.backends = wgpu::Backends::SECONDARY;
            Self::from_instance(wgpu::Instance::new(choice), None)
        })
    }

    /// Opens the best adapter that can draw on `surface`.
    ///
    /// # Errors
    /// [`DisplayError::NoAdapter`], [`DisplayError::Device`].
    pub fn from_instance(
        instance: wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<Self, DisplayError> {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: surface,
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options)).map_err(|error| {
            DisplayError::NoAdapter {
                detail: error.to_string(),
            }
        })?;
        let info = adapter.get_info();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("calot"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .map_err(|error| DisplayError::Device {
            doing: "opening the graphics device",
            detail: error.to_string(),
        })?;
        let fault = Arc::new(Mutex::new(None));
        let (on_error, on_loss) = (fault.clone(), fault.clone());
        // Only the first fault is kept, because it is the cause. Later ones are consequences.
        device.on_uncaptured_error(Arc::new(move |error| note(&on_error, &error.to_string())));
        device.set_device_lost_callback(move |_, detail| {
            note(&on_loss, &format!("the graphics device is lost: {detail}"));
        });
        Ok(Self {
            instance,
            adapter,
            device,
            queue,
            info,
            fault,
            staging: Mutex::new(None),
        })
    }

    /// True if the adapter is a CPU.
    #[must_use]
    pub fn is_software(&self) -> bool {
        let name = self.info.name.to_lowercase();
        self.info.device_type == wgpu::DeviceType::Cpu
            || ["llvmpipe", "lavapipe", "softpipe", "swiftshader"]
                .iter()
                .any(|software| name.contains(software))
    }

    /// True if the device can time its own passes.
    #[must_use]
    pub fn has_clock(&self) -> bool {
        let features = self.device.features();
        features.contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Adapter and driver as text.
    #[must_use]
    pub fn describe(&self) -> String {
        let info = &self.info;
        format!("{} ({:?}, {})", info.name, info.backend, info.driver_info)
    }

    /// Returns the first fault of the device since it was opened, if any, as an error.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn check(&self, doing: &'static str) -> Result<(), DisplayError> {
        let fault = self.fault.lock().map_or(None, |fault| fault.clone());
        fault.map_or(Ok(()), |detail| Err(DisplayError::Device { doing, detail }))
    }

    /// Injects a fault: the device is lost, as when a driver restarts.
    pub fn lose(&self) {
        self.device.destroy();
        // The loss is reported at the next poll.
        let _ = self.device.poll(wgpu::PollType::Poll);
        note(&self.fault, "the graphics device is lost: on purpose");
    }

    /// Waits for all submitted work.
    ///
    /// # Errors
    /// [`DisplayError::Device`] if the device hangs or has had a fault.
    pub fn wait(&self, doing: &'static str) -> Result<(), DisplayError> {
        let all = wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(PATIENCE),
        };
        self.device
            .poll(all)
            .map_err(|error| DisplayError::Device {
                doing,
                detail: error.to_string(),
            })?;
        self.check(doing)
    }

    /// Content of a buffer with usage `COPY_SRC`.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn read_buffer(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, DisplayError> {
        let bytes = buffer.size();
        let staging = self.staging(bytes);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let mut content = Vec::new();
        self.map(staging, |all| content.extend_from_slice(all))?;
        Ok(content)
    }

    /// Pixels of an RGBA texture of four bytes a pixel, row by row from the top.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn read_texture(&self, texture: &wgpu::Texture) -> Result<Vec<u8>, DisplayError> {
        let (width, height) = (texture.width(), texture.height());
        let texel = texture.format().block_copy_size(None).unwrap_or(4);
        let used = (width * texel) as usize;
        let row = (width * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let staging = self.staging(u64::from(row) * u64::from(height));
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: Some(height),
                },
            },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        let mut pixels = Vec::with_capacity(used * height as usize);
        self.map(staging, |padded| {
            for padded in padded.chunks_exact(row as usize) {
                pixels.extend_from_slice(&padded[..used]);
            }
        })?;
        Ok(pixels)
    }

    fn staging(&self, size: u64) -> wgpu::Buffer {
        let kept = self.staging.lock().ok().and_then(|mut kept| kept.take());
        kept.filter(|kept| kept.size() == size).unwrap_or_else(|| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("readback"),
                size,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        })
    }

    /// Passes the content of `staging` to `take` once the device has written it.
    fn map(&self, staging: wgpu::Buffer, take: impl FnOnce(&[u8])) -> Result<(), DisplayError> {
        let doing = "reading a result back";
        staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.wait(doing)?;
        let range = staging
            .slice(..)
            .get_mapped_range()
            .map_err(|error| DisplayError::Device {
                doing,
                detail: error.to_string(),
            })?;
        take(&range);
        drop(range);
        staging.unmap();
        if let Ok(mut kept) = self.staging.lock() {
            *kept = Some(staging);
        }
        Ok(())
    }
}

fn note(fault: &Mutex<Option<String>>, detail: &str) {
    if let Ok(mut fault) = fault.lock() {
        fault.get_or_insert_with(|| detail.to_owned());
    }
}
