//! `calot replay`: runs a recorded session again and compares every tick.

mod show;
mod what_if;

use std::cell::Cell;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use rt_process::replay::{Difference, Replay, Replayed};
use serde::Serialize;
use session::{End, Session, hex};
use shared_mem::inputs::InputRecord;
use shared_mem::scene::SceneFile;

use crate::build::build;
use crate::cli::ReplayArgs;
use crate::say;
use crate::scene::Problem;

/// After tools have differed, the organ that is behind it shows within as many ticks: by then each
/// sphere had its turn (`rt_core::sim::Digest`).
const UNTIL_EVERY_SPHERE: u64 = 80;
/// How often a waiting user is told how far it is.
const PROGRESS: Duration = Duration::from_secs(1);

/// What a replay came to.
#[derive(Debug, Serialize)]
struct Outcome {
    session: std::path::PathBuf,
    scene: String,
    scene_id: String,
    recorded_by: String,
    replayed_by: String,
    /// Ticks that were run.
    ticks: u64,
    /// Time in the session that they are.
    session_s: f64,
    /// Time that it took.
    took_s: f64,
    /// Whether every tick of the session was run and came out the same.
    same: bool,
    first_difference: Option<Different>,
    /// First tick that is missing; what comes after it is not compared.
    gap_at_tick: Option<u64>,
    /// Why the session ends before its end, if it does (a kill, a full disk).
    broken_off: Option<String>,
}

/// The first tick that differs.
#[derive(Debug, Clone, Serialize)]
struct Different {
    tick: u64,
    /// Time of it in the session, s.
    at_s: f64,
    /// `tools` or `organ`.
    what: &'static str,
    /// The first organ that differs: within 80 ticks, in which every sphere is looked at once.
    organ: Option<String>,
}

/// Replays, and says whether all came out the same.
pub(crate) fn run(args: &ReplayArgs) -> Result<ExitCode, Problem> {
    let mut session = Session::open(&args.session)?;
    let scene = scene_of(&mut session, args.scene.as_deref())?;
    let running = build();
    if running != session.info.build {
        say::note(format_args!(
            "calot: recorded by {}, replayed by {running}; the same bits are expected all the same",
            session.info.build
        ));
    }
    if args.what_if.is_some() || args.what_if_iterations.is_some() {
        return what_if::run(args, &session, &scene);
    }
    if args.show || args.frames.is_some() {
        return show::run(args, &session, &scene);
    }
    let replay = Replay::new(&scene, &session.setup)?;
    let outcome = compare(&replay, &mut session, running)?;
    if args.json {
        say::answer(format_args!("{}", serde_json::to_string_pretty(&outcome)?));
    }
    say::note(in_words(&outcome));
    Ok(match outcome.same {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

/// The scene that the session ran on.
fn scene_of(session: &mut Session, named: Option<&std::path::Path>) -> Result<SceneFile, Problem> {
    let scene = match (named, session.scene.take()) {
        (Some(path), _) => SceneFile::open(path)?,
        (None, Some(bytes)) => SceneFile::from_bytes(&bytes)?,
        (None, None) => {
            return Err("the session does not hold its scene; name it with --scene".into());
        }
    };
    if scene.short_id() != session.setup.scene_id {
        return Err(format!(
            "the session ran on scene {} ('{}'), this one is {} ('{}'); leave --scene out, or name \
             the same compiled scene",
            hex(session.setup.scene_id),
            session.info.scene,
            hex(scene.short_id()),
            scene.name()
        )
        .into());
    }
    Ok(scene)
}

fn compare(replay: &Replay, session: &mut Session, running: String) -> Result<Outcome, Problem> {
    let start = Instant::now();
    let mut said = start;
    let mut outcome = Outcome {
        session: session.path().to_owned(),
        scene: replay.scene_name().to_owned(),
        scene_id: hex(replay.scene_id()),
        recorded_by: session.info.build.clone(),
        replayed_by: running,
        ticks: 0,
        session_s: 0.0,
        took_s: 0.0,
        same: false,
        first_difference: None,
        gap_at_tick: None,
        broken_off: None,
    };
    let done = Cell::new(0.0);
    let gap = Cell::new(None);
    let mut first_ns = None;
    replay.run(without_gap(session, &gap, &done), |replayed| {
        let record = replayed.record;
        let began_ns = *first_ns.get_or_insert(record.now_ns);
        outcome.ticks += 1;
        outcome.session_s = record.now_ns.saturating_sub(began_ns) as f64 / 1e9;
        if said.elapsed() >= PROGRESS {
            said = Instant::now();
            say::note(format_args!(
                "replaying {:3.0} %, {:.1} times as fast as it was",
                done.get() * 100.0,
                outcome.session_s / start.elapsed().as_secs_f64()
            ));
        }
        note_difference(&mut outcome, replay.organs(), replayed)
    })?;
    outcome.took_s = start.elapsed().as_secs_f64();
    outcome.gap_at_tick = gap.get();
    if let Some(End::BrokenOff(why)) = session.end() {
        outcome.broken_off = Some(why.clone());
    }
    outcome.same = outcome.first_difference.is_none() && outcome.gap_at_tick.is_none();
    Ok(outcome)
}

/// The session's ticks up to the first that is missing.
fn without_gap<'a>(
    session: &'a mut Session,
    gap: &'a Cell<Option<u64>>,
    done: &'a Cell<f64>,
) -> impl Iterator<Item = InputRecord> + 'a {
    let mut expected = 0;
    core::iter::from_fn(move || {
        let record = session.next()?;
        done.set(session.done());
        if record.tick != expected {
            gap.set(Some(expected));
            return None;
        }
        expected += 1;
        Some(record)
    })
}

/// Whether to go on: after a difference only until its organ is known.
fn note_difference(outcome: &mut Outcome, organs: &[String], replayed: &Replayed<'_>) -> bool {
    let tick = replayed.record.tick;
    match (&mut outcome.first_difference, replayed.differs()) {
        (None, None) => true,
        (None, Some(difference)) => {
            let organ = organ(difference, organs);
            outcome.first_difference = Some(Different {
                tick,
                at_s: outcome.session_s,
                what: match difference {
                    Difference::Organ(_) => "organ",
                    Difference::Tools => "tools",
                },
                organ: organ.clone(),
            });
            organ.is_none()
        }
        (Some(first), found) => {
            first.organ = found.and_then(|it| organ(it, organs));
            first.organ.is_none() && tick < first.tick + UNTIL_EVERY_SPHERE
        }
    }
}

fn organ(difference: Difference, organs: &[String]) -> Option<String> {
    match difference {
        Difference::Organ(organ) => organs.get(organ?).cloned(),
        Difference::Tools => None,
    }
}

fn in_words(outcome: &Outcome) -> String {
    let ticks = outcome.ticks;
    let mut words = match (&outcome.first_difference, outcome.gap_at_tick) {
        (Some(first), _) => {
            let organ = first.organ.as_deref().unwrap_or("no organ");
            let what = match first.what {
                "tools" => format!("tools and force differ, and then {organ}"),
                _ => format!("{organ} differs"),
            };
            format!(
                "tick {} ({:.3} s): {what}. {ticks} ticks were compared; what was recorded is not \
                 what this program computes",
                first.tick, first.at_s
            )
        }
        (None, Some(tick)) => format!(
            "{ticks} ticks came out the same; tick {tick} and others are missing in the session, and \
             nothing is said of what comes after"
        ),
        (None, None) => format!(
            "all {ticks} ticks came out the same, {:.1} times as fast as they were",
            outcome.session_s / outcome.took_s.max(1e-9)
        ),
    };
    if let Some(why) = &outcome.broken_off {
        words += &format!(" (the session breaks off: {why})");
    }
    words
}
