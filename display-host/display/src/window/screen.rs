//! The display's window: picture and panel.

use std::time::Instant;

use shared_mem::scene::SceneFile;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::window::{CursorGrabMode, Fullscreen, WindowId};

use super::canvas::Canvas;
use super::pending::{parts, played_s};
use super::presented::{Handed, Watch};
use super::session::Session;
use crate::DisplayError;
use crate::effects::Effects;
use crate::effects::fluid::Balance;
use crate::latency::{FrameRecord, now_ns};
use crate::render::camera::Scope;
use crate::render::governor::Governor;
use crate::render::inside::Inside;
use crate::render::lens::Lens;
use crate::render::{Quality, Renderer};
use crate::ui::{Asked, ui};

/// Largest picture, pixels; a larger area shows it stretched.
const PICTURE_MAX: [u32; 2] = [2560, 1440];
/// Least relative change of the picture's size that recreates the picture.
const RESIZE_SHARE: f32 = 0.02;
/// Time constant of the automatic exposure, s.
const EXPOSURE_S: f32 = 0.4;

/// Turn of the endoscope about its shaft per request, degrees.
const TURN_DEGREES: f32 = 15.0;

/// Result of a frame.
pub(super) enum Shown {
    /// The frame is on the screen. `asked` are the user's requests; `quit` is true if one is to
    /// quit.
    Frame { asked: Vec<Asked>, quit: bool },
    /// No frame: the window is not visible or was just resized.
    Unseen,
}

/// State that outlasts a lost graphics device.
#[derive(Default)]
pub(super) struct Kept {
    pub(super) scope: Scope,
    pub(super) lens: Lens,
    pub(super) effects: Option<Effects>,
    pub(super) is_full: bool,
    /// Inner size of the window, pixels.
    pub(super) size: Option<[u32; 2]>,
    pub(super) drawn_tick: Option<u64>,
}

pub(super) struct Screen {
    canvas: Canvas,
    presented: Watch<Handed>,
    renderer: Renderer,
    picture: egui::TextureId,
    last_frame: Option<Instant>,
    /// Time between the last two pictures, s. `None` once the governor has taken it.
    since_last_s: Option<f32>,
    governor: Governor,
    /// Newest tick drawn.
    drawn_tick: Option<u64>,
    mouse_held: bool,
    /// Fault injection: loses the device during the next frame.
    loses_device: bool,
}

impl Screen {
    pub(super) fn open(
        events: &ActiveEventLoop,
        proxy: &EventLoopProxy<accesskit_winit::Event>,
        title: &str,
        size: [u32; 2],
        kept: Kept,
        scene: &SceneFile,
    ) -> Result<Self, DisplayError> {
        let mut canvas = Canvas::open(events, proxy, title, size)?;
        let presented = Watch::of(&canvas.window, events.owned_display_handle());
        let gpu = &canvas.gpu;
        let governor = governor(&canvas);
        let mut renderer = Renderer::new(gpu, scene, Quality::live(gpu))?;
        *renderer.scope_mut() = kept.scope;
        *renderer.lens_mut() = kept.lens;
        if let Some(effects) = kept.effects {
            *renderer.effects_mut() = effects;
        }
        let full = Fullscreen::Borderless(None);
        canvas.window.set_fullscreen(kept.is_full.then_some(full));
        let picture = canvas.register(renderer.picture());
        canvas.show();
        Ok(Self {
            canvas,
            presented,
            renderer,
            picture,
            last_frame: None,
            since_last_s: None,
            governor,
            drawn_tick: kept.drawn_tick,
            mouse_held: false,
            loses_device: false,
        })
    }

    /// Closes the screen. Returns the state to keep.
    pub(super) fn close(self) -> Kept {
        Kept {
            scope: *self.renderer.scope(),
            lens: *self.renderer.lens(),
            effects: Some(self.renderer.effects().clone()),
            is_full: self.canvas.window.fullscreen().is_some(),
            size: Some(self.canvas.size()),
            drawn_tick: self.drawn_tick,
        }
    }

    /// Injects a fault: loses the graphics device during the next frame.
    pub(super) fn lose_device(&mut self) {
        self.loses_device = true;
    }

    pub(super) fn adapter(&self) -> String {
        self.canvas.gpu.describe()
    }

    pub(super) fn is_software(&self) -> bool {
        self.canvas.gpu.is_software()
    }

    pub(super) fn window_id(&self) -> WindowId {
        self.canvas.window.id()
    }

    pub(super) fn redraw(&self) {
        self.canvas.window.request_redraw();
    }

    pub(super) fn take_event(&mut self, event: &WindowEvent) {
        self.canvas.take_event(event);
    }

    /// Captures the mouse in the window and hides it, or releases it.
    pub(super) fn hold_mouse(&mut self, hold: bool) {
        if hold == self.mouse_held {
            return;
        }
        self.mouse_held = hold;
        let window = &self.canvas.window;
        window.set_cursor_visible(!hold);
        // If both calls fail, the mouse still leads the hand, but only within the screen.
        let _ = if hold {
            window
                .set_cursor_grab(CursorGrabMode::Locked)
                .or_else(|_| window.set_cursor_grab(CursorGrabMode::Confined))
        } else {
            window.set_cursor_grab(CursorGrabMode::None)
        };
    }

    pub(super) fn take_accessibility(&mut self, event: accesskit_winit::Event) {
        self.canvas.take_accessibility(event);
    }

    /// Draws and shows a frame.
    pub(super) fn show(
        &mut self,
        scene: &SceneFile,
        session: &mut Session,
    ) -> Result<Shown, DisplayError> {
        let Some(surface) = self.canvas.next_frame()? else {
            return Ok(Shown::Unseen);
        };
        let drawn = self.draw_picture(session);
        if core::mem::take(&mut self.loses_device) {
            self.canvas.gpu.lose();
        }
        if let Some(path) = drawn.as_ref().and_then(|_| session.picture_due()) {
            let picture = self.renderer.read(&self.canvas.gpu)?;
            // A picture that cannot be written does not stop the operation.
            if let Err(error) = crate::kept::write(&picture, &path) {
                session.warn_later(error.to_string());
            }
        }
        let [width, height] = self.renderer.quality().size;
        let aspect = width as f32 / height as f32;
        session.ui.picture = drawn.as_ref().map(|_| (self.picture, aspect));

        session.update_overlay(scene, self.renderer.scope());
        let (mut asked, mut covered) = (Vec::new(), None);
        let patch = session.patch();
        let laid = self.canvas.lay_out(|area| {
            (asked, covered) = ui(area, &session.ui);
            if let Some((_, lit)) = &patch {
                lit.paint(area.ctx());
            }
        });
        let submitted_ns = now_ns();
        self.presented.ask();
        self.canvas.present(surface, laid)?;
        let handed_ns = now_ns();
        let lit = patch.map(|(patch, lit)| {
            patch.handed(lit, handed_ns, || self.canvas.surface());
            lit
        });
        let frame = drawn.map(|frame| FrameRecord {
            submitted_ns,
            shown_ns: handed_ns,
            ..frame
        });
        if let Some(frame) = &frame {
            session.note_frame(frame.clone());
        }
        self.watch_presentation(
            Handed {
                frame,
                lit,
                handed_ns,
            },
            session,
        );
        self.fit_picture(covered)?;
        self.watch_cost(session)?;
        self.turn_scope(&asked, session);
        if asked.contains(&Asked::ToggleFullScreen) {
            let window = &self.canvas.window;
            let full = window.fullscreen().is_none();
            window.set_fullscreen(full.then_some(Fullscreen::Borderless(None)));
        }
        let quit = asked.contains(&Asked::Quit);
        Ok(Shown::Frame { asked, quit })
    }

    /// Follows a picture on its way to the screen, and notes those that have come there.
    fn watch_presentation(&mut self, handed: Handed, session: &mut Session) {
        if core::mem::take(&mut self.canvas.is_renewed) {
            self.presented.renew();
        }
        self.presented.hand(handed);
        session.note_handed(self.presented.source(), self.presented.refused());
        self.presented.take(
            |handed| handed.handed_ns,
            |handed, presented| session.note_presented(&handed, presented),
        );
    }

    /// Submits the endoscope's picture of the newest moment. Returns the picture's record, whose
    /// times of submission and display are not known yet.
    fn draw_picture(&mut self, session: &mut Session) -> Option<FrameRecord> {
        session.moment()?;
        let now = Instant::now();
        let last = self.last_frame.replace(now);
        self.since_last_s = last.map(|last| (now - last).as_secs_f32());
        let step_s = self.since_last_s.unwrap_or(f32::INFINITY);
        self.renderer.exposure_mut().adapt = 1.0 - (-step_s / EXPOSURE_S).exp();
        // Effects follow the record's time, so that a replay of any speed, and every observer,
        // shows as much blood as the run did.
        let tick = session.moment().map_or(0, |(state, _)| state.tick);
        let before = self.drawn_tick.filter(|_| !session.ui.is_paused());
        let before = before.unwrap_or(tick);
        let wall_s = self.since_last_s.unwrap_or_default();
        let mut played = played_s(before, tick, wall_s, session.most_speed());
        if session.take_reset() {
            self.renderer.effects_mut().clear();
            played = 0.0;
        }
        let effects = session.take_effects(played);
        let (state, tools) = session.moment()?;
        let tools = session.seen_tools(tools);
        let spheres = state.spheres().unwrap_or(&[]);
        self.renderer.scope_mut().is_free_eye = session.ui.is_view_free;
        for (begin, seconds) in parts(&effects, before, played) {
            self.renderer.play(spheres, &begin, seconds);
        }
        let cells = state.cells().unwrap_or(&[]);
        self.renderer.set_cells(&self.canvas.gpu, cells);
        let inside = session.ui.inside.then_some(Inside::VIEW);
        self.renderer.set_inside(&self.canvas.gpu, inside);
        self.renderer.set_sutures(state.sutures());
        if let Some(parted) = state.parted() {
            self.renderer.set_parted(&self.canvas.gpu, parted);
        }
        (self.renderer).set_clips(state.clips().unwrap_or(&[]), spheres);
        (self.renderer).set_stones(state.stones().unwrap_or(&[]));
        self.renderer
            .render(&self.canvas.gpu, spheres, &tools, session.time_s());
        // A tick that is drawn again gives no latency.
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

    /// Takes the cost of the last picture, and adapts the quality to it.
    fn watch_cost(&mut self, session: &mut Session) -> Result<(), DisplayError> {
        let times = self.renderer.take_pass_times();
        session.ui.pass_times = times.or(session.ui.pass_times);
        let gpu = &self.canvas.gpu;
        let cost_ms = if gpu.has_clock() && !gpu.is_software() {
            times.map(|it| it.iter().sum())
        } else {
            self.since_last_s.take().map(|since_s| since_s * 1e3)
        };
        let Some(cost_ms) = cost_ms else {
            return Ok(());
        };
        if let Some(quality) = self.governor.note(cost_ms) {
            self.renderer.set_quality(&self.canvas.gpu, quality)?;
            self.show_picture_anew();
        }
        session.ui.quality = self.governor.tier();
        Ok(())
    }

    /// Angle between the endoscope's view and its shaft, and its turn about the shaft, rad.
    pub(super) fn scope_rad(&self) -> [f32; 2] {
        let scope = self.renderer.scope();
        [scope.angle, scope.turned]
    }

    /// Carries out requests for the endoscope.
    fn turn_scope(&mut self, asked: &[Asked], session: &mut Session) {
        for asked in asked {
            let scope = self.renderer.scope_mut();
            match *asked {
                Asked::NextScope => scope.angle = next_angle(scope.angle),
                Asked::TurnScope(way) => {
                    let turned = scope.turned.to_degrees() + TURN_DEGREES * f32::from(way);
                    scope.turned = ((turned + 180.0).rem_euclid(360.0) - 180.0).to_radians();
                }
                Asked::TurnFocus(steps) => scope.turn_focus(steps),
                Asked::WipeLens => self.renderer.lens_mut().wipe(),
                Asked::ToggleSuction => {
                    let is_on = self.renderer.effects().is_drawn_off();
                    self.renderer.draw_off_smoke(!is_on);
                }
                _ => {}
            }
        }
        if session.takes_fog() {
            self.renderer.lens_mut().fog_up();
        }
        let scope = self.renderer.scope();
        session.ui.scope_degrees = [scope.angle, scope.turned].map(|a| a.to_degrees().round());
        session.ui.focus_mm = scope.focus_m * 1e3;
        let lens = self.renderer.lens_mut();
        session.ui.lens_veil = lens.fog.max(lens.soot);
        let effects = self.renderer.effects();
        session.ui.haze_per_m = effects.haze_per_m();
        session.ui.is_smoke_drawn_off = effects.is_drawn_off();
        let (jar_ml, full_share) = effects.fluids().jar();
        (session.ui.jar_ml, session.ui.jar_is_full) = (jar_ml as f32, full_share >= 1.0);
    }

    /// Blood, bile and water since the last reset.
    pub(super) fn fluids(&self) -> Balance {
        self.renderer.effects().fluids().balance()
    }

    /// Gives the picture's new texture to egui.
    fn show_picture_anew(&mut self) {
        self.canvas.replace(self.picture, self.renderer.picture());
    }

    /// With a graphics card, fits the picture's size to the area `covered`, pixels. A software
    /// driver keeps its small picture.
    fn fit_picture(&mut self, covered: Option<[u32; 2]>) -> Result<(), DisplayError> {
        let Some(covered) = covered.filter(|_| !self.canvas.gpu.is_software()) else {
            return Ok(());
        };
        let wanted = [0, 1].map(|i| covered[i].clamp(64, PICTURE_MAX[i]));
        let now = self.renderer.quality().size;
        let differs = (0..2).any(|i| {
            let share = wanted[i] as f32 / now[i] as f32 - 1.0;
            share.abs() > RESIZE_SHARE
        });
        if differs {
            self.renderer.resize(&self.canvas.gpu, wanted)?;
            self.show_picture_anew();
        }
        Ok(())
    }
}

/// Governs the quality of the pictures on the window's screen.
fn governor(canvas: &Canvas) -> Governor {
    let monitor = canvas.window.current_monitor();
    let millihertz = monitor.and_then(|it| it.refresh_rate_millihertz());
    let screen_ms = millihertz.map_or(0.0, |it| 1e6 / it as f32);
    Governor::of(&canvas.gpu, screen_ms)
}

/// Angle of the next endoscope, rad: 0°, 30°, 45°, then 0° again.
fn next_angle(angle: f32) -> f32 {
    let angles = [0.0f32, 30.0, 45.0];
    let next = angles.into_iter().find(|a| *a > angle.to_degrees() + 1.0);
    next.unwrap_or(0.0).to_radians()
}
