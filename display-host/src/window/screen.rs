//! The window itself: surface, picture, panel.

use std::sync::Arc;
use std::time::Instant;

use shared_mem::scene::SceneFile;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::window::{CursorGrabMode, Fullscreen, Window};

use super::session::Session;
use crate::DisplayError;
use crate::latency::{FrameRecord, now_ns};
use crate::render::governor::Governor;
use crate::render::gpu::Gpu;
use crate::render::inside::Inside;
use crate::render::lens::Lens;
use crate::render::{Quality, Renderer};
use crate::ui::{Asked, ui};

/// Pictures larger than this are stretched, pixels.
const PICTURE_MAX: [u32; 2] = [2560, 1440];
/// A new picture size must differ by this share before the picture is made anew.
const RESIZE_SHARE: f32 = 0.02;
/// Time that auto exposure takes for most of its way, s.
const EXPOSURE_S: f32 = 0.4;

/// A step of the endoscope's light cable about its shaft, degrees.
const TURN_DEGREES: f32 = 15.0;

/// What became of a frame.
pub(super) enum Shown {
    /// It is on the screen; the user asked for this.
    Frame { asked: Vec<Asked>, quit: bool },
    /// The window cannot be seen.
    Unseen,
}

pub(super) struct Screen {
    window: Arc<Window>,
    gpu: Gpu,
    surface: wgpu::Surface<'static>,
    surface_config: wgpu::SurfaceConfiguration,
    renderer: Renderer,
    painter: egui_wgpu::Renderer,
    input: egui_winit::State,
    picture: egui::TextureId,
    last_frame: Option<Instant>,
    governor: Governor,
    /// The newest tick that was drawn.
    drawn_tick: Option<u64>,
    mouse_held: bool,
}

impl Screen {
    pub(super) fn open(
        events: &ActiveEventLoop,
        proxy: &EventLoopProxy<accesskit_winit::Event>,
        title: &str,
        [width, height]: [u32; 2],
        (scope_angle, cold_lens): (f32, bool),
        scene: &SceneFile,
    ) -> Result<Self, DisplayError> {
        let no_window = |detail: String| DisplayError::NoWindow { detail };
        // Invisible until the accessibility tree is attached.
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
        let (tiers, may_cost_ms) = Quality::tiers(&gpu);
        let mut renderer = Renderer::new(&gpu, scene, Quality::live(&gpu))?;
        renderer.scope_mut().angle = scope_angle;
        if cold_lens {
            *renderer.lens_mut() = Lens::cold();
        }
        let mut painter = egui_wgpu::Renderer::new(
            &gpu.device,
            surface_config.format,
            egui_wgpu::RendererOptions::default(),
        );
        let context = egui::Context::default();
        context.set_theme(egui::Theme::Dark);
        let mut input = egui_winit::State::new(
            context,
            egui::ViewportId::ROOT,
            &*window,
            Some(window.scale_factor() as f32),
            None,
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        input.init_accesskit(events, &window, proxy.clone());
        window.set_visible(true);
        let filter = wgpu::FilterMode::Linear;
        let picture = painter.register_native_texture(&gpu.device, renderer.picture(), filter);
        window.request_redraw();
        Ok(Self {
            window,
            gpu,
            surface,
            surface_config,
            renderer,
            painter,
            input,
            picture,
            last_frame: None,
            governor: Governor::new(tiers, may_cost_ms),
            drawn_tick: None,
            mouse_held: false,
        })
    }

    pub(super) fn adapter(&self) -> String {
        self.gpu.describe()
    }

    pub(super) fn is_software(&self) -> bool {
        self.gpu.is_software()
    }

    pub(super) fn redraw(&self) {
        self.window.request_redraw();
    }

    pub(super) fn take_event(&mut self, event: &WindowEvent) {
        let _ = self.input.on_window_event(&self.window, event);
        if let WindowEvent::Resized(size) = event
            && size.width > 0
            && size.height > 0
        {
            self.surface_config.width = size.width;
            self.surface_config.height = size.height;
            self.surface
                .configure(&self.gpu.device, &self.surface_config);
        }
    }

    /// Keeps the mouse in the window, unseen, or lets it out.
    pub(super) fn hold_mouse(&mut self, hold: bool) {
        if hold == self.mouse_held {
            return;
        }
        self.mouse_held = hold;
        self.window.set_cursor_visible(!hold);
        // Where neither can be had the mouse leads the hand all the same, as far as the screen goes.
        let _ = if hold {
            self.window
                .set_cursor_grab(CursorGrabMode::Locked)
                .or_else(|_| self.window.set_cursor_grab(CursorGrabMode::Confined))
        } else {
            self.window.set_cursor_grab(CursorGrabMode::None)
        };
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
        self.redraw();
    }

    /// Draws and shows one frame.
    pub(super) fn show(
        &mut self,
        scene: &SceneFile,
        session: &mut Session,
    ) -> Result<Shown, DisplayError> {
        use wgpu::CurrentSurfaceTexture as Current;
        let surface = match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => texture,
            Current::Outdated | Current::Lost => {
                let size = self.window.inner_size();
                self.surface_config.width = size.width.max(1);
                self.surface_config.height = size.height.max(1);
                self.surface
                    .configure(&self.gpu.device, &self.surface_config);
                return Ok(Shown::Unseen);
            }
            Current::Timeout | Current::Occluded => return Ok(Shown::Unseen),
            Current::Validation => {
                self.gpu.check("taking a frame of the window")?;
                return Ok(Shown::Unseen);
            }
        };
        let drawn = self.draw_picture(session);
        let [width, height] = self.renderer.quality().size;
        let aspect = width as f32 / height as f32;
        session.ui.picture = drawn.as_ref().map(|_| (self.picture, aspect));

        session.update_overlay(scene, self.renderer.scope());
        let context = self.input.egui_ctx().clone();
        let input = self.input.take_egui_input(&self.window);
        let (mut asked, mut covered) = (Vec::new(), None);
        let output = context.run_ui(input, |area| (asked, covered) = ui(area, &session.ui));
        self.input
            .handle_platform_output(&self.window, output.platform_output);
        let shapes = context.tessellate(output.shapes, output.pixels_per_point);
        self.paint(
            &surface,
            &shapes,
            output.pixels_per_point,
            output.textures_delta,
        );
        let submitted_ns = now_ns();
        self.window.pre_present_notify();
        self.gpu.queue.present(surface);
        self.gpu.check("drawing a frame")?;
        if let Some(frame) = drawn {
            session.note_frame(FrameRecord {
                submitted_ns,
                shown_ns: now_ns(),
                ..frame
            });
        }
        self.fit_picture(covered)?;
        self.watch_cost(session)?;
        self.turn_scope(&asked, session);
        if asked.contains(&Asked::ToggleFullScreen) {
            let full = self.window.fullscreen().is_none();
            self.window
                .set_fullscreen(full.then_some(Fullscreen::Borderless(None)));
        }
        let quit = asked.contains(&Asked::Quit);
        Ok(Shown::Frame { asked, quit })
    }

    /// Submits the endoscope's picture of the newest moment; its record, times still open.
    fn draw_picture(&mut self, session: &mut Session) -> Option<FrameRecord> {
        session.moment()?;
        let now = Instant::now();
        let step_s = self
            .last_frame
            .replace(now)
            .map_or(f32::INFINITY, |last| (now - last).as_secs_f32());
        self.renderer.exposure_mut().adapt = 1.0 - (-step_s / EXPOSURE_S).exp();
        let played_s = if step_s.is_finite() && !session.ui.is_paused() {
            step_s
        } else {
            0.0
        };
        if session.take_reset() {
            self.renderer.effects_mut().clear();
        }
        let effects = session.take_effects(played_s);
        let (state, tools) = session.moment()?;
        let spheres = state.spheres().unwrap_or(&[]);
        self.renderer.play(spheres, &effects, played_s);
        let cells = state.cells().unwrap_or(&[]);
        self.renderer.set_cells(&self.gpu, cells);
        let inside = session.ui.inside.then_some(Inside::VIEW);
        self.renderer.set_inside(&self.gpu, inside);
        (self.renderer).set_clips(state.clips().unwrap_or(&[]), spheres);
        self.renderer
            .render(&self.gpu, spheres, tools, session.time_s());
        // What is drawn again has no motion to be late with.
        let is_new = self.drawn_tick.replace(state.tick) != Some(state.tick);
        Some(FrameRecord {
            tick: state.tick,
            sample_ns: state.sample_ns,
            state_ns: state.at_ns,
            submitted_ns: 0,
            shown_ns: 0,
            live: is_new && session.is_live(),
            path: None,
        })
    }

    /// Takes what recent pictures cost, and changes the quality where they cost too much or little.
    fn watch_cost(&mut self, session: &mut Session) -> Result<(), DisplayError> {
        let Some(times) = self.renderer.take_pass_times() else {
            return Ok(());
        };
        session.ui.pass_times = Some(times);
        if let Some(quality) = self.governor.note(times.iter().sum()) {
            self.renderer.set_quality(&self.gpu, quality)?;
            self.show_picture_anew();
        }
        session.ui.quality = self.governor.tier();
        Ok(())
    }

    /// Does what was asked of the endoscope.
    fn turn_scope(&mut self, asked: &[Asked], session: &mut Session) {
        for asked in asked {
            let scope = self.renderer.scope_mut();
            match *asked {
                Asked::NextScope => scope.angle = next_angle(scope.angle),
                Asked::TurnScope(way) => {
                    let turned = scope.turned.to_degrees() + TURN_DEGREES * f32::from(way);
                    scope.turned = ((turned + 180.0).rem_euclid(360.0) - 180.0).to_radians();
                }
                Asked::WipeLens => self.renderer.lens_mut().wipe(),
                _ => {}
            }
        }
        let scope = self.renderer.scope();
        session.ui.scope_degrees = [scope.angle, scope.turned].map(|a| a.to_degrees().round());
        let lens = self.renderer.lens_mut();
        session.ui.lens_veil = lens.fog.max(lens.soot);
    }

    /// The picture's texture is another one.
    fn show_picture_anew(&mut self) {
        self.painter.update_egui_texture_from_wgpu_texture(
            &self.gpu.device,
            self.renderer.picture(),
            wgpu::FilterMode::Linear,
            self.picture,
        );
    }

    fn paint(
        &mut self,
        surface: &wgpu::SurfaceTexture,
        shapes: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
        mut textures: egui::TexturesDelta,
    ) {
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
            .update_buffers(device, queue, &mut encoder, shapes, &screen);
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
            self.painter.render(&mut pass, shapes, &screen);
        }
        queue.submit(before.into_iter().chain([encoder.finish()]));
        for id in textures.free.drain() {
            self.painter.free_texture(&id);
        }
    }

    /// On a graphics device the picture is as large as its place on the screen; a software driver
    /// keeps its small one.
    fn fit_picture(&mut self, covered: Option<[u32; 2]>) -> Result<(), DisplayError> {
        let Some(covered) = covered.filter(|_| !self.gpu.is_software()) else {
            return Ok(());
        };
        let wanted = [0, 1].map(|i| covered[i].clamp(64, PICTURE_MAX[i]));
        let now = self.renderer.quality().size;
        let differs = (0..2).any(|i| {
            let share = wanted[i] as f32 / now[i] as f32 - 1.0;
            share.abs() > RESIZE_SHARE
        });
        if differs {
            self.renderer.resize(&self.gpu, wanted)?;
            self.show_picture_anew();
        }
        Ok(())
    }
}

/// The endoscope that comes after one: 0°, 30°, 45°, and again.
fn next_angle(angle: f32) -> f32 {
    let angles = [0.0f32, 30.0, 45.0];
    let next = angles.into_iter().find(|a| *a > angle.to_degrees() + 1.0);
    next.unwrap_or(0.0).to_radians()
}

fn configure(
    surface: &wgpu::Surface<'_>,
    gpu: &Gpu,
    size: PhysicalSize<u32>,
) -> Option<wgpu::SurfaceConfiguration> {
    let capabilities = surface.get_capabilities(&gpu.adapter);
    let mut config =
        surface.get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))?;
    // egui mixes its colours without the screen's curve.
    let plain = capabilities.formats.iter().find(|format| !format.is_srgb());
    config.format = *plain.or(capabilities.formats.first())?;
    config.present_mode = wgpu::PresentMode::AutoVsync;
    config.desired_maximum_frame_latency = 1;
    surface.configure(&gpu.device, &config);
    Some(config)
}
