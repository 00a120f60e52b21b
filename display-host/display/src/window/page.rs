//! A window that shows widgets and no picture, such as the launcher's. It is drawn on events and
//! idle otherwise.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::event::{ElementState, KeyEvent, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, NamedKey};
use winit::window::WindowId;

use super::canvas::Canvas;
use super::{event_loop, no_window};
use crate::DisplayError;

/// Usual polling period of an idle page.
const LOOK_ABOUT: Duration = Duration::from_millis(100);

/// Content of a window that shows widgets and no picture.
pub trait Page {
    /// Present title of the window, which a screen reader says first.
    fn title(&self) -> String;

    /// Shows the widgets and carries out requests.
    fn show(&mut self, ui: &mut egui::Ui);

    /// Polls, at least once in each [`period`](Self::period). Returns true if the content has
    /// changed.
    fn look_about(&mut self) -> bool;

    /// Period of the polls.
    fn period(&self) -> Duration {
        LOOK_ABOUT
    }

    /// Handles Esc before the next picture is drawn, because a picture may be late.
    fn escape(&mut self) {}

    /// True if the window is to close.
    fn is_over(&self) -> bool;
}

/// Opens a window with an inner size of `size` pixels and runs it until it is closed, its page is
/// over or `stop` is set. Call it once per process, and on systems other than Linux from the main
/// thread only. The thread keeps its priority, because processes that the page starts inherit it.
///
/// # Errors
/// There is no screen, no driver can draw on it, or the window or its graphics device is lost.
pub fn show_page(
    size: [u32; 2],
    stop: &AtomicBool,
    page: &mut dyn Page,
) -> Result<(), DisplayError> {
    let event_loop = event_loop()?;
    let mut app = App {
        size,
        stop,
        page,
        proxy: event_loop.create_proxy(),
        canvas: None,
        title: String::new(),
        missed: None,
        error: None,
    };
    event_loop
        .run_app(&mut app)
        .map_err(|error| no_window(&error))?;
    app.error.map_or(Ok(()), Err)
}

struct App<'a> {
    size: [u32; 2],
    stop: &'a AtomicBool,
    page: &'a mut dyn Page,
    proxy: EventLoopProxy<accesskit_winit::Event>,
    canvas: Option<Canvas>,
    title: String,
    /// Time of the last failed attempt to acquire a frame; `None` after a success.
    missed: Option<Instant>,
    error: Option<DisplayError>,
}

impl App<'_> {
    fn fail(&mut self, events: &ActiveEventLoop, error: DisplayError) {
        self.error.get_or_insert(error);
        events.exit();
    }

    fn draw(&mut self) -> Result<(), DisplayError> {
        let Some(canvas) = &mut self.canvas else {
            return Ok(());
        };
        let Some(frame) = canvas.next_frame()? else {
            self.missed = Some(Instant::now());
            return Ok(());
        };
        self.missed = None;
        let laid = canvas.lay_out(|ui| self.page.show(ui));
        let goes_on = laid.goes_on;
        canvas.present(frame, laid)?;
        let title = self.page.title();
        if title != self.title {
            canvas.window.set_title(&title);
            self.title = title;
        }
        if goes_on {
            canvas.window.request_redraw();
        }
        Ok(())
    }
}

impl ApplicationHandler<accesskit_winit::Event> for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.canvas.is_some() {
            return;
        }
        self.title = self.page.title();
        match Canvas::open(events, &self.proxy, &self.title, self.size) {
            Ok(canvas) => {
                canvas.show();
                self.canvas = Some(canvas);
            }
            Err(error) => self.fail(events, error),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(canvas) = &mut self.canvas else {
            return;
        };
        canvas.take_event(&event);
        if is_escape(&event) {
            self.page.escape();
        }
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Destroyed => {
                let detail = "another program closed it".to_owned();
                self.canvas = None;
                self.fail(events, DisplayError::WindowLost { detail });
            }
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw() {
                    self.fail(events, error);
                }
            }
            _ => canvas.window.request_redraw(),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, event: accesskit_winit::Event) {
        if let Some(canvas) = &mut self.canvas {
            canvas.take_accessibility(event);
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if self.stop.load(Ordering::Relaxed) || self.page.is_over() {
            events.exit();
        }
        // A missed frame is requested again only after a delay. Without the delay, a hidden window
        // would request frames endlessly.
        let missed = self.missed.is_some_and(|it| it.elapsed() >= LOOK_ABOUT);
        if (self.page.look_about() || missed)
            && let Some(canvas) = &self.canvas
        {
            canvas.window.request_redraw();
        }
        events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + self.page.period()));
    }
}

fn is_escape(event: &WindowEvent) -> bool {
    let WindowEvent::KeyboardInput { event, .. } = event else {
        return false;
    };
    let KeyEvent {
        logical_key, state, ..
    } = event;
    *logical_key == Key::Named(NamedKey::Escape) && *state == ElementState::Pressed
}
