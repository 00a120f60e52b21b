//! Window of the station: picture and panel, frame after frame.

mod apart;
mod canvas;
mod frames;
mod free_view;
mod messenger;
mod operate;
mod page;
mod pending;
mod presented;
mod refusal;
mod screen;
mod server;
mod session;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use shared_mem::scene::SceneFile;
use shared_mem::service::{Host, Station};
use winit::application::ApplicationHandler;
use winit::event::{DeviceEvent, DeviceId, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::WindowId;

pub use self::apart::{run_apart, show_page_apart};
pub use self::page::{Page, show_page};
use self::screen::{Kept, Screen, Shown};
pub use self::server::answers;
use self::session::Session;
use crate::DisplayError;
use crate::headless::{Ended, Observed, RunOutcome};
use crate::patch::Patch;
use crate::render::camera::Scope;
use crate::render::lens::Lens;
use crate::sound::Sound;
use crate::ui::{ActsView, RecordingView, ReplayView, Settings, TaskView};

/// Pause between the frames of an invisible window.
const UNSEEN: Duration = Duration::from_millis(50);
/// Largest number of losses of the graphics device that a run survives.
const LOSSES_MAX: u32 = 3;

/// Configuration of a window.
#[derive(Debug, Clone)]
pub struct WindowConfig {
    /// Station to watch.
    pub station: Station,
    /// Path of the compiled scene.
    pub scene: PathBuf,
    /// Inner size to start with, pixels.
    pub size: [u32; 2],
    /// Angle between the endoscope's view and its shaft, rad.
    pub scope_angle: f32,
    /// True to disable sound.
    pub muted: bool,
    /// True if the endoscope's lens starts cold and fogs.
    pub cold_lens: bool,
    /// Time after which the window ends, s. `None` if it ends only when the user closes it.
    pub seconds: Option<f64>,
    /// Fault injection: loses the graphics device once, after this many frames.
    pub lose_device_after: Option<u64>,
    /// Core of the realtime thread, which the display avoids.
    pub tick_cpu: Option<usize>,
    /// Settings of the interface at the start. Each change is observed.
    pub settings: Settings,
    /// State of the task, updated by its assessor.
    pub task: Option<Arc<Mutex<TaskView>>>,
    /// Folder for pictures of the critical view, taken when it was held.
    pub pictures: Option<PathBuf>,
    /// True for an instructor's window: it shows the assessor's bulletins, sends no commands to the
    /// controller, and asks the station for the instructor's acts.
    pub instructor: bool,
    /// True if the scripted expert leads the instrument.
    pub watched: bool,
    /// For haptic device, tracker and pedal: true if it is simulated.
    pub simulated: [bool; 3],
    /// Name of the task of a replayed session, if known.
    pub replayed_task: Option<String>,
    /// Acts of instructors, updated by the station or by a replay's player.
    pub acts: Option<Arc<Mutex<ActsView>>>,
    /// State of a replay, updated by its player.
    pub replay: Option<Arc<Mutex<ReplayView>>>,
    /// State of the recording, updated by the recorder.
    pub recording: Option<Arc<Mutex<RecordingView>>>,
    /// The square of `calot photon`.
    pub patch: Option<Arc<Patch>>,
}

/// Opens the window and runs it until it is closed, `stop` is set, or the time is up. Call it once
/// per process, and on systems other than Linux from the main thread only. No controller is needed:
/// the window waits for one, and waits for the next one when a controller ends.
///
/// # Errors
/// See [`DisplayError`].
pub fn run(
    config: &WindowConfig,
    stop: &AtomicBool,
    observer: &mut dyn FnMut(Observed<'_>),
) -> Result<RunOutcome, DisplayError> {
    if let Some(seconds) = config.seconds
        && !(seconds > 0.0 && seconds <= 86_400.0)
    {
        return Err(DisplayError::Seconds(seconds));
    }
    let scene = SceneFile::open(&config.scene)?;
    let host = Host::open(&config.station)?;
    crate::priority::step_aside(config.tick_cpu);
    let event_loop = event_loop()?;
    let mut app = App {
        size: config.size,
        losses_left: LOSSES_MAX,
        lose_device_after: config.lose_device_after,
        session: Session::new(
            &scene,
            host,
            &config.station,
            (!config.muted).then(|| Sound::start(config.tick_cpu)),
            config.task.clone(),
            config.settings,
        )
        .showing(config.replay.clone(), config.recording.clone())
        .with_patch(config.patch.clone())
        .of_player(config.watched, config.simulated)
        .of_replayed_task(config.replayed_task.clone())
        .with_acts(config.acts.clone())
        .keeping(config.pictures.as_deref())
        .watched_by_instructor(config.instructor.then_some(&config.station))?,
        scene,
        stop,
        observer,
        proxy: event_loop.create_proxy(),
        end: config
            .seconds
            .map(|s| Instant::now() + Duration::from_secs_f64(s)),
        screen: None,
        first: Some(Kept {
            scope: Scope {
                angle: config.scope_angle,
                ..Scope::default()
            },
            lens: match config.cold_lens {
                true => Lens::cold(),
                false => Lens::warm(),
            },
            is_full: config.patch.as_ref().is_some_and(|patch| patch.full_screen),
            ..Kept::default()
        }),
        ended: Ended::Stopped,
        error: None,
    };
    event_loop
        .run_app(&mut app)
        .map_err(|error| no_window(&error))?;
    if let Some(error) = app.error {
        return Err(error);
    }
    let (adapter, software_adapter) = match &app.screen {
        Some(screen) => (Some(screen.adapter()), screen.is_software()),
        None => (None, false),
    };
    let fluids = app.screen.as_ref().map(|screen| screen.fluids());
    let mut outcome = app.session.outcome(adapter, software_adapter, app.ended);
    outcome.fluids = fluids;
    Ok(outcome)
}

fn event_loop() -> Result<EventLoop<accesskit_winit::Event>, DisplayError> {
    let mut builder = EventLoop::<accesskit_winit::Event>::with_user_event();
    #[cfg(target_os = "linux")]
    {
        use winit::platform::{wayland, x11};
        // Linux allows an event loop on any thread, and tests run on threads of their own.
        wayland::EventLoopBuilderExtWayland::with_any_thread(&mut builder, true);
        x11::EventLoopBuilderExtX11::with_any_thread(&mut builder, true);
    }
    builder.build().map_err(|error| no_window(&error))
}

/// The window system's error, without the place in winit's source code.
fn no_window(error: &winit::error::EventLoopError) -> DisplayError {
    let said = error.to_string();
    let words = said.split_once(".rs:").map_or(&*said, |(_, place)| {
        place.trim_start_matches(|it: char| it.is_ascii_digit() || it == ':' || it == ' ')
    });
    DisplayError::NoWindow {
        detail: words.to_owned(),
    }
}

struct App<'a> {
    size: [u32; 2],
    /// Number of further losses of the graphics device that are tolerated.
    losses_left: u32,
    lose_device_after: Option<u64>,
    scene: SceneFile,
    session: Session,
    stop: &'a AtomicBool,
    observer: &'a mut dyn FnMut(Observed<'_>),
    proxy: EventLoopProxy<accesskit_winit::Event>,
    end: Option<Instant>,
    screen: Option<Screen>,
    /// Initial state of the screen, until it is open.
    first: Option<Kept>,
    ended: Ended,
    error: Option<DisplayError>,
}

impl App<'_> {
    fn fail(&mut self, events: &ActiveEventLoop, error: DisplayError) {
        self.error.get_or_insert(error);
        events.exit();
    }

    /// Does one frame: receives messages, shows the picture, and carries out requests.
    fn frame(&mut self, events: &ActiveEventLoop) {
        self.session.receive(self.observer);
        let Some(screen) = &mut self.screen else {
            return;
        };
        if self
            .lose_device_after
            .is_some_and(|after| self.session.drawn() >= after)
        {
            self.lose_device_after = None;
            screen.lose_device();
        }
        match screen.show(&self.scene, &mut self.session) {
            Ok(Shown::Frame { asked, quit }) => {
                (self.observer)(Observed::Scope(screen.scope_rad()));
                self.session.carry_out(&asked, &self.scene, self.observer);
                screen.hold_mouse(self.session.operate.is_on());
                if quit {
                    self.ended = Ended::Stopped;
                    events.exit();
                }
                events.set_control_flow(ControlFlow::Poll);
                screen.redraw();
            }
            Ok(Shown::Unseen) => {
                events.set_control_flow(ControlFlow::wait_duration(UNSEEN));
            }
            Err(error) => self.mend(events, error),
        }
    }

    /// Reopens a lost graphics device, with all its resources, in a new window. Another error, or
    /// one loss too many, ends the run.
    fn mend(&mut self, events: &ActiveEventLoop, error: DisplayError) {
        let warning = match &error {
            DisplayError::Device { doing, detail } => Some(format!(
                "the display failed while {doing}: {detail}; it opens the graphics device again"
            )),
            _ => None,
        };
        let screen = self.screen.take().filter(|_| self.losses_left > 0);
        match screen.zip(warning) {
            Some((screen, warning)) => {
                self.losses_left -= 1;
                (self.session).warn(warning, self.observer);
                // A key that is released meanwhile reaches no window, so the instrument is
                // released.
                self.session.operate.let_go();
                self.open(events, screen.close());
            }
            None => self.fail(events, error),
        }
    }

    fn open(&mut self, events: &ActiveEventLoop, kept: Kept) {
        let title = format!("Calot: {}", self.scene.name());
        let (size, scene) = (kept.size.unwrap_or(self.size), &self.scene);
        match Screen::open(events, &self.proxy, &title, size, kept, scene) {
            Ok(screen) => {
                self.session.set_adapter(screen.adapter());
                self.screen = Some(screen);
            }
            Err(error) => self.fail(events, error),
        }
    }
}

impl ApplicationHandler<accesskit_winit::Event> for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.screen.is_some() {
            return;
        }
        let first = self.first.take().unwrap_or_default();
        self.open(events, first);
    }

    fn window_event(&mut self, events: &ActiveEventLoop, window: WindowId, event: WindowEvent) {
        // Late events of a window that was closed with its graphics device are dropped.
        let own = |screen: &&mut Screen| screen.window_id() == window;
        let Some(screen) = self.screen.as_mut().filter(own) else {
            return;
        };
        if !self.session.operate.take_event(&event) {
            screen.take_event(&event);
        }
        match event {
            // A window without the focus does not see that keys are released, so the instrument is
            // released.
            WindowEvent::Focused(false) => {
                self.session.operate.let_go();
                screen.hold_mouse(false);
            }
            WindowEvent::CloseRequested => {
                self.ended = Ended::Stopped;
                events.exit();
            }
            WindowEvent::Destroyed => {
                let detail = "another program closed it".to_owned();
                self.screen = None;
                self.fail(events, DisplayError::WindowLost { detail });
            }
            WindowEvent::RedrawRequested => self.frame(events),
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta } = event {
            self.session.operate.mouse_moved(delta);
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, event: accesskit_winit::Event) {
        let own = |screen: &&mut Screen| screen.window_id() == event.window_id;
        if let Some(screen) = self.screen.as_mut().filter(own) {
            screen.take_accessibility(event);
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if self.stop.load(Ordering::Relaxed) {
            self.ended = Ended::Stopped;
            events.exit();
        } else if self.end.is_some_and(|end| Instant::now() >= end) {
            self.ended = Ended::TimeOver;
            events.exit();
        }
        self.session.operate.send_if_due();
        // A hidden window gets no redraw by itself. The session receives in a redraw, so one is
        // requested.
        if let Some(screen) = &self.screen {
            screen.redraw();
        }
    }
}
