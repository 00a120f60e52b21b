//! A window with a surface for egui, used by the display's and the launcher's windows.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::time::Instant;

use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::window::Window;

use crate::DisplayError;
use crate::patch::Surface;
use crate::render::gpu::Gpu;

/// A window to paint on.
pub(super) struct Canvas {
    pub(super) window: Arc<Window>,
    pub(super) gpu: Gpu,
    surface: wgpu::Surface<'static>,
    surface_config: wgpu::SurfaceConfiguration,
    painter: egui_wgpu::Renderer,
    input: egui_winit::State,
    /// Time from which egui counts.
    start: Instant,
    /// True if the driver was told to begin a new swapchain since the last picture.
    pub(super) is_renewed: bool,
}

/// A frame of egui, laid out but not painted.
pub(super) struct Laid {
    shapes: Vec<egui::ClippedPrimitive>,
    pixels_per_point: f32,
    textures: egui::TexturesDelta,
    /// True if the frame is animated, so that the next one must follow at once.
    pub(super) goes_on: bool,
}

impl Canvas {
    /// Opens a window, hidden until [`show`](Self::show).
    pub(super) fn open(
        events: &ActiveEventLoop,
        proxy: &EventLoopProxy<accesskit_winit::Event>,
        title: &str,
        [width, height]: [u32; 2],
    ) -> Result<Self, DisplayError> {
        let no_window = |detail: String| DisplayError::NoWindow { detail };
        // The window is invisible until the accessibility tree is attached.
        let attributes = Window::default_attributes()
            .with_title(title)
            .with_visible(false)
            .with_inner_size(PhysicalSize::new(width, height));
        let window = events
            .create_window(attributes)
            .map_err(|error| no_window(error.to_string()))?;
        let window = Arc::new(window);
        let display = Box::new(events.owned_display_handle());
        let choice = wgpu::InstanceDescriptor::new_without_display_handle_from_env()
            .with_display_handle(display);
        let instance = wgpu::Instance::new(choice);
        let surface = instance
            .create_surface(window.clone())
            .map_err(|error| no_window(error.to_string()))?;
        let gpu = Gpu::from_instance(instance, Some(&surface))?;
        let surface_config = configure(&surface, &gpu, window.inner_size())
            .ok_or_else(|| no_window("the adapter cannot draw on this screen".into()))?;
        let painter = egui_wgpu::Renderer::new(
            &gpu.device,
            surface_config.format,
            egui_wgpu::RendererOptions::default(),
        );
        let context = egui::Context::default();
        context.set_theme(egui::Theme::Dark);
        crate::fonts::add(&context);
        let mut input = egui_winit::State::new(
            context,
            egui::ViewportId::ROOT,
            &*window,
            Some(window.scale_factor() as f32),
            None,
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        input.init_accesskit(events, &window, proxy.clone());
        Ok(Self {
            window,
            gpu,
            surface,
            surface_config,
            painter,
            input,
            start: Instant::now(),
            is_renewed: false,
        })
    }

    /// Size of the window, pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.surface_config.width, self.surface_config.height]
    }

    /// Screen and driver of the window.
    pub(super) fn surface(&self) -> Surface {
        let monitor = self.window.current_monitor();
        let millihertz = (monitor.as_ref()).and_then(|it| it.refresh_rate_millihertz());
        let modes = self
            .surface
            .get_capabilities(&self.gpu.adapter)
            .present_modes;
        // `AutoVsync` stands for `FifoRelaxed` if the driver has it, else for `Fifo`.
        let mode = match modes.contains(&wgpu::PresentMode::FifoRelaxed) {
            true => wgpu::PresentMode::FifoRelaxed,
            false => wgpu::PresentMode::Fifo,
        };
        Surface {
            size: self.size(),
            // Without a window manager, a window that asked for the whole screen may not get it.
            full_screen: self.window.fullscreen().is_some()
                && monitor.is_some_and(|it| <[u32; 2]>::from(it.size()) == self.size()),
            refresh_hz: millihertz.map(|it| f64::from(it) / 1e3),
            present_mode: format!("{mode:?}"),
            adapter: self.gpu.describe(),
        }
    }

    /// Makes the window visible.
    pub(super) fn show(&self) {
        self.window.set_visible(true);
        self.window.request_redraw();
    }

    /// Registers a texture for egui's pictures.
    pub(super) fn register(&mut self, view: &wgpu::TextureView) -> egui::TextureId {
        let filter = wgpu::FilterMode::Linear;
        self.painter
            .register_native_texture(&self.gpu.device, view, filter)
    }

    /// Replaces the texture of an id.
    pub(super) fn replace(&mut self, id: egui::TextureId, view: &wgpu::TextureView) {
        let filter = wgpu::FilterMode::Linear;
        self.painter
            .update_egui_texture_from_wgpu_texture(&self.gpu.device, view, filter, id);
    }

    pub(super) fn take_event(&mut self, event: &WindowEvent) {
        let _ = self.input.on_window_event(&self.window, event);
        if let WindowEvent::Resized(size) = event
            && size.width > 0
            && size.height > 0
        {
            self.surface_config.width = size.width;
            self.surface_config.height = size.height;
            self.renew();
        }
    }

    /// Lets the driver begin a new swapchain.
    fn renew(&mut self) {
        self.is_renewed = true;
        self.surface
            .configure(&self.gpu.device, &self.surface_config);
    }

    pub(super) fn take_accessibility(&mut self, event: accesskit_winit::Event) {
        match event.window_event {
            accesskit_winit::WindowEvent::InitialTreeRequested => {
                self.input.egui_ctx().enable_accesskit();
            }
            accesskit_winit::WindowEvent::ActionRequested(request) => {
                self.input.on_accesskit_action_request(request);
            }
            accesskit_winit::WindowEvent::AccessibilityDeactivated => {
                self.input.egui_ctx().disable_accesskit();
            }
        }
        self.window.request_redraw();
    }

    /// Next frame of the surface. `None` if the window is not visible or was just resized.
    pub(super) fn next_frame(&mut self) -> Result<Option<wgpu::SurfaceTexture>, DisplayError> {
        use wgpu::CurrentSurfaceTexture as Current;
        match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => Ok(Some(texture)),
            Current::Outdated | Current::Lost => {
                // The size of the last `Resized` still holds. A window that is gone panics when it
                // is asked for its size.
                self.renew();
                Ok(None)
            }
            Current::Timeout | Current::Occluded => Ok(None),
            Current::Validation => {
                self.gpu.check("taking a frame of the window")?;
                Ok(None)
            }
        }
    }

    /// Lays a frame out.
    pub(super) fn lay_out(&mut self, add: impl FnMut(&mut egui::Ui)) -> Laid {
        let context = self.input.egui_ctx().clone();
        let input = self.take_input();
        let output = context.run_ui(input, add);
        self.input
            .handle_platform_output(&self.window, output.platform_output);
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        Laid {
            shapes: context.tessellate(output.shapes, output.pixels_per_point),
            pixels_per_point: output.pixels_per_point,
            textures: output.textures_delta,
            goes_on: root.is_some_and(|it| it.repaint_delay.is_zero()),
        }
    }

    /// Input for egui, as `egui_winit::State::take_egui_input` takes it. But this function does not
    /// ask the window for its size, because that panics once the window is gone.
    fn take_input(&mut self) -> egui::RawInput {
        let native = self.window.scale_factor() as f32;
        let points = native * self.input.egui_ctx().zoom_factor();
        let [width, height] = self.size().map(|pixels| pixels as f32 / points);
        let input = self.input.egui_input_mut();
        input.time = Some(self.start.elapsed().as_secs_f64());
        let size = egui::vec2(width, height);
        input.screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size));
        input.viewport_id = egui::ViewportId::ROOT;
        let viewport = input.viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.native_pixels_per_point = Some(native);
        input.take()
    }

    /// Paints a laid out frame and presents it.
    pub(super) fn present(
        &mut self,
        frame: wgpu::SurfaceTexture,
        mut laid: Laid,
    ) -> Result<(), DisplayError> {
        // egui's painter panics on a lost device.
        if let Err(lost) = self.gpu.check("drawing a picture") {
            laid.textures.clear();
            give_up(frame);
            return Err(lost);
        }
        self.paint(&frame, laid);
        self.window.pre_present_notify();
        self.gpu.queue.present(frame);
        self.gpu.check("drawing a frame")
    }

    fn paint(&mut self, surface: &wgpu::SurfaceTexture, laid: Laid) {
        let Laid {
            shapes,
            pixels_per_point,
            mut textures,
            ..
        } = laid;
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: [self.surface_config.width, self.surface_config.height],
            pixels_per_point,
        };
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.painter.update_texture(device, queue, id, &delta);
            }
        }
        let mut encoder = device.create_command_encoder(&Default::default());
        let before = self
            .painter
            .update_buffers(device, queue, &mut encoder, &shapes, &screen);
        let view = surface.texture.create_view(&Default::default());
        {
            let mut pass = encoder
                .begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("window"),
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &view,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations {
                            load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                            store: wgpu::StoreOp::Store,
                        },
                    })],
                    ..Default::default()
                })
                .forget_lifetime();
            self.painter.render(&mut pass, &shapes, &screen);
        }
        queue.submit(before.into_iter().chain([encoder.finish()]));
        for id in textures.free.drain() {
            self.painter.free_texture(&id);
        }
    }
}

/// Drops a frame of a lost device. In wgpu 30 (its issue 8243) a plain drop panics, unless the
/// thread is unwinding already.
fn give_up(frame: wgpu::SurfaceTexture) {
    let unwinds = move || {
        let _frame = frame;
        resume_unwind(Box::new(()))
    };
    let _: Result<(), _> = catch_unwind(AssertUnwindSafe(unwinds));
}

fn configure(
    surface: &wgpu::Surface<'_>,
    gpu: &Gpu,
    size: PhysicalSize<u32>,
) -> Option<wgpu::SurfaceConfiguration> {
    let capabilities = surface.get_capabilities(&gpu.adapter);
    let mut config =
        surface.get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))?;
    // egui blends colours in gamma space, so it needs a format without sRGB conversion.
    let plain = capabilities.formats.iter().find(|format| !format.is_srgb());
    config.format = *plain.or(capabilities.formats.first())?;
    config.present_mode = wgpu::PresentMode::AutoVsync;
    config.desired_maximum_frame_latency = 1;
    surface.configure(&gpu.device, &config);
    Some(config)
}
