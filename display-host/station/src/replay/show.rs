//! `calot replay --show`, `--at` and `--frames`: shows a session in a window, or draws pictures.

use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use display_host::headless::{self, HeadlessConfig, Observed};
use display_host::ui::{ActsReader, ActsView, ReplayView};
use display_host::window::{self, WindowConfig};
use rt_process::replay::{Pace, Replay, Replayed, Shown, length_ns, show};
use session::{EntryContent, Operation, Session};
use shared_mem::inputs::InputRecord;
use shared_mem::message::ActMsg;
use shared_mem::scene::SceneFile;
use shared_mem::service::Station;

use super::args::ReplayArgs;
use super::judge::Judge;
use super::recorded::{LeftOut, next_in_order};
use crate::folder::Folder;
use crate::problem::Problem;
use crate::say;
use crate::settings;
use crate::stop;

/// Longest wait of the display for a state. After a seek, the ticks in between must run first.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(600);

/// Stack of a thread that runs a simulation, bytes. The simulation's state is built on the stack.
pub(super) const STACK_BYTES: usize = 16 << 20;

/// Plays the session in a window, or draws `--frames` pictures into `out`.
pub(super) fn run(
    args: &ReplayArgs,
    session: &Session,
    scene: &SceneFile,
    out: &Path,
) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    let station = Station::new(&args.station)?;
    let folder = Folder::open(&args.station, false)?;
    let path = folder.scene();
    std::fs::write(&path, scene.bytes()).map_err(|error| format!("{}: {error}", path.display()))?;
    folder.announce_scene(&path)?;
    let replay = Replay::new(scene, &session.setup)?;
    let pace = Pace {
        speed: args.speed,
        from_s: args.start_s(),
    };
    let played = session.path();
    // With a window, the replay starts at once. For pictures, it waits until the renderer exists.
    let begun = AtomicBool::new(args.frames.is_none());
    let view = Arc::new(Mutex::new(ReplayView::default()));
    let length = AtomicU64::new(0);
    let acts_of_session = Mutex::new(Vec::new());
    let acts = Arc::new(Mutex::new(ActsView::default()));
    let player = Player {
        replay: &replay,
        session: played,
        station: &station,
        pace,
        begun: &begun,
        stop: &stop,
        length_ns: &length,
        view: &view,
        acts_of_session: &acts_of_session,
        acts: &acts,
    };
    let (shown, watched) = std::thread::scope(|scope| {
        // Measuring the length of an hour-long session takes seconds, so a thread does it.
        scope.spawn(|| {
            *lock(&acts_of_session) = acts_of(played, &stop);
            if let Ok(session) = Session::open(played) {
                let ticks = in_order(session).take_while(|_| !stop.load(Relaxed));
                length.store(length_ns(ticks), Relaxed);
            }
        });
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
        let playing = thread.spawn_scoped(scope, || {
            let shown = player.play();
            if shown.is_err() {
                stop.store(true, Relaxed);
            }
            shown
        });
        let mut observe = |observed: Observed<'_>| match observed {
            Observed::Begun => begun.store(true, Relaxed),
            Observed::Warning(text) => say::note(format_args!("warning: {text}")),
            Observed::Settings(changed) => settings::keep(&changed),
            _ => {}
        };
        let watched = match args.frames {
            Some(frames) => {
                let seconds = args.pictures_s(length_s(player.session));
                say::note(format_args!(
                    "{frames} pictures over {seconds:.0} s of playing; --speed and --seconds shorten it"
                ));
                let config = headless_config((frames, seconds), out, &station, &path);
                headless::run(&config, &stop, &mut observe)
            }
            None => window::run(
                &WindowConfig {
                    acts: Some(acts.clone()),
                    replayed_task: task_of(played),
                    ..window_config(args, &station, &path, &view)
                },
                &stop,
                &mut observe,
            ),
        };
        stop.store(true, Relaxed);
        (playing.map(std::thread::ScopedJoinHandle::join), watched)
    });
    shown?.map_err(|_| "the replay panicked; please report this")??;
    let outcome = watched?;
    if args.frames.is_some() {
        say::note(format_args!(
            "{} pictures in {}",
            outcome.frames.len(),
            out.display()
        ));
    }
    Ok(ExitCode::SUCCESS)
}

/// Settings for pictures of the session.
fn headless_config(
    (frames, seconds): (u32, f64),
    out: &Path,
    station: &Station,
    path: &Path,
) -> HeadlessConfig {
    HeadlessConfig {
        station: station.clone(),
        scene: path.to_owned(),
        seconds,
        out_dir: out.to_owned(),
        size: None,
        frames,
        patience: PATIENCE,
        tick_cpu: None,
        task_over: None,
        task: None,
        need_pictures: false,
    }
}

/// Settings for a window on the session.
fn window_config(
    args: &ReplayArgs,
    station: &Station,
    path: &Path,
    view: &Arc<Mutex<ReplayView>>,
) -> WindowConfig {
    WindowConfig {
        station: station.clone(),
        scene: path.to_owned(),
        size: [1280, 720],
        scope_angle: 0.0,
        muted: false,
        cold_lens: false,
        seconds: None,
        lose_device_after: None,
        tick_cpu: None,
        settings: args.look.settings(args.language),
        task: None,
        pictures: None,
        instructor: false,
        watched: false,
        simulated: [false; 3],
        replayed_task: None,
        acts: None,
        replay: Some(view.clone()),
        recording: None,
        patch: None,
    }
}

/// Runs the session again for a display, at the requested speed.
struct Player<'a> {
    replay: &'a Replay,
    session: &'a Path,
    station: &'a Station,
    pace: Pace,
    /// True once the replay may start.
    begun: &'a AtomicBool,
    stop: &'a AtomicBool,
    /// Length of the session, ns, once known.
    length_ns: &'a AtomicU64,
    view: &'a Mutex<ReplayView>,
    /// Acts of instructors in the session, with their times, s, once known.
    acts_of_session: &'a Mutex<Vec<(f64, ActMsg)>>,
    /// View of these acts for the display.
    acts: &'a Mutex<ActsView>,
}

impl Player<'_> {
    fn play(&self) -> Result<(), String> {
        // Report missing parts once, however often the user seeks back.
        let mut has_warned = false;
        let open = || {
            let first = !core::mem::replace(&mut has_warned, true);
            let session = Session::open(self.session).ok()?;
            Some(warned(session, first))
        };
        let mut judge = Judge::default();
        let mut first_ns = None;
        let each = |tick: &Replayed<'_>| {
            let now_ns = tick.record.now_ns;
            let passed_ns = now_ns.saturating_sub(*first_ns.get_or_insert(now_ns));
            let was_done = judge.is_done;
            judge.look(tick, passed_ns as f64 / 1e9, self.replay.organs());
            if let (false, true, Some(first)) = (was_done, judge.is_done, &judge.first) {
                say::note(format_args!(
                    "warning: {}; from there on the show differs from the recording",
                    first.in_words()
                ));
            }
        };
        let tell = |shown: Shown| {
            let found_s = self.length_ns.load(Relaxed) as f64 / 1e9;
            *lock(self.acts) =
                ActsView::at(&lock(self.acts_of_session), shown.at_s, ActsReader::Replay);
            *lock(self.view) = ReplayView {
                at_s: shown.at_s,
                length_s: shown.length_s.unwrap_or(found_s),
                speed: shown.speed,
                seeks_s: shown.seeks_s,
            };
        };
        show(
            self.replay,
            self.station,
            self.pace,
            self.begun,
            self.stop,
            open,
            each,
            tell,
        )
        .map_err(|error| error.to_string())
    }
}

/// Length of a session, s, as the show counts it. 0 if the session cannot be read.
fn length_s(session: &Path) -> f64 {
    let ticks = Session::open(session).ok().map(in_order);
    ticks.map_or(0.0, |it| length_ns(it) as f64 / 1e9)
}

fn lock<T>(it: &Mutex<T>) -> MutexGuard<'_, T> {
    it.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Name of the task that the session belongs to. A session without a course has none.
fn task_of(session: &Path) -> Option<String> {
    Some(Operation::open(session).ok()?.assignment?.task)
}

/// Acts of instructors in a session, with their times from its start, s.
fn acts_of(session: &Path, stop: &AtomicBool) -> Vec<(f64, ActMsg)> {
    let mut first_ns = None;
    let entries = Operation::open(session).into_iter().flatten();
    let acts = entries
        .take_while(|_| !stop.load(Relaxed))
        .filter_map(|it| {
            let began_ns = *first_ns.get_or_insert(it.at_ns);
            let at_s = it.at_ns.saturating_sub(began_ns) as f64 * 1e-9;
            match it.what {
                EntryContent::Act(act) => Some((at_s, act)),
                _ => None,
            }
        });
    acts.collect()
}

/// The session's ticks up to the first missing one.
fn in_order(mut session: Session) -> impl Iterator<Item = InputRecord> {
    let mut expected = 0;
    core::iter::from_fn(move || next_in_order(&mut session, &mut expected).ok().flatten())
}

/// Returns the ticks as [`in_order`] does. If `says` is true, warns of missing parts after them.
fn warned(mut session: Session, says: bool) -> impl Iterator<Item = InputRecord> {
    let mut expected = 0;
    core::iter::from_fn(move || {
        let next = next_in_order(&mut session, &mut expected);
        if let (true, Ok(None) | Err(_)) = (says, next) {
            for warning in LeftOut::of(&session, next.err()).in_words() {
                say::note(format_args!("warning: {warning}"));
            }
        }
        next.ok().flatten()
    })
}
