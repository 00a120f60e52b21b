//! `calot replay`: runs a recorded session again and compares every tick.

pub(crate) mod args;
mod show;
mod what_if;

use std::cell::Cell;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use rt_process::replay::{Difference, Replay, Replayed};
use serde::Serialize;
use session::{End, Session, hex, printable};
use shared_mem::inputs::InputRecord;
use shared_mem::scene::SceneFile;

use crate::build::build;
use crate::say;
use crate::scene::Problem;
use args::ReplayArgs;

/// After tools alone have differed, an organ is looked for in as many ticks.
const LOOKED_ON: u64 = 1000;
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
    /// Whether every tick that is known to have run was run again, and came out the same. What comes
    /// after the end of a session that breaks off, or whose controller was killed, is not known.
    same: bool,
    first_difference: Option<Different>,
    #[serde(flatten)]
    left_out: LeftOut,
}

/// What of a session is not run again.
#[derive(Debug, Clone, Default, Serialize)]
struct LeftOut {
    /// First tick that is missing; what comes after it is not run.
    gap_at_tick: Option<u64>,
    /// Where the session ends before its end, if it does (a kill, a full disk).
    broken_off: Option<String>,
    /// Where it is damaged, and how; what comes after is not run.
    damaged: Option<String>,
    /// Ticks that ran and were not recorded.
    missing: u64,
    /// Whether the controller said that it ended; not known of a session that is not read to its end.
    controller_ended: Option<bool>,
}

impl LeftOut {
    fn of(session: &Session, gap_at_tick: Option<u64>) -> Self {
        let (broken_off, damaged) = match session.end() {
            Some(End::BrokenOff(why)) => (Some(why.clone()), None),
            Some(End::Damaged(why)) => (None, Some(why.clone())),
            Some(End::Whole) | None => (None, None),
        };
        let finish = session.finish();
        Self {
            gap_at_tick,
            broken_off,
            damaged,
            missing: finish.map_or(0, |finish| finish.missing),
            controller_ended: finish.map(|finish| finish.ran.is_some()),
        }
    }

    /// Whether ticks are known to be missing among those that the session should hold.
    fn is_known(&self) -> bool {
        self.gap_at_tick.is_some() || self.damaged.is_some() || self.missing > 0
    }

    /// A warning for each.
    fn in_words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if let Some(tick) = self.gap_at_tick {
            words.push(format!(
                "tick {tick} and maybe others are missing in the session; nothing is said of what comes \
                 after"
            ));
        } else if self.missing > 0 {
            words.push(format!(
                "{} ticks ran and are missing at the end of the session",
                self.missing
            ));
        }
        if let Some(why) = &self.damaged {
            words.push(format!(
                "the session is damaged {why}; nothing is said of what comes after"
            ));
        }
        if let Some(why) = &self.broken_off {
            words.push(format!(
                "the session breaks off ({why}), as when its recorder is killed; nothing is said of what \
                 came after"
            ));
        }
        if self.controller_ended == Some(false) {
            words.push(
                "the controller did not say that it ended (it was killed, or ran on), so ticks may have \
                 followed"
                    .to_owned(),
            );
        }
        words
    }
}

/// The first tick in which the runs differ.
#[derive(Debug, Clone, Serialize)]
struct Different {
    tick: u64,
    /// Time of it in the session, s.
    at_s: f64,
    /// `tools` or `organ`.
    what: &'static str,
    /// The organ that differs then, or first after the tools did.
    organ: Option<String>,
    /// In which tick the organ does.
    organ_tick: Option<u64>,
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
pub(crate) fn scene_of(
    session: &mut Session,
    named: Option<&std::path::Path>,
) -> Result<SceneFile, Problem> {
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
            printable(scene.name())
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
        scene: printable(replay.scene_name()),
        scene_id: hex(replay.scene_id()),
        recorded_by: session.info.build.clone(),
        replayed_by: running,
        ticks: 0,
        session_s: 0.0,
        took_s: 0.0,
        same: false,
        first_difference: None,
        left_out: LeftOut::default(),
    };
    let done = Cell::new(0.0);
    let gap = Cell::new(None);
    let mut first_ns = None;
    let mut judge = Judge::default();
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
        judge.look(replayed, outcome.session_s, replay.organs())
    })?;
    outcome.took_s = start.elapsed().as_secs_f64();
    outcome.first_difference = judge.first;
    outcome.left_out = LeftOut::of(session, gap.get());
    outcome.same =
        outcome.ticks > 0 && outcome.first_difference.is_none() && !outcome.left_out.is_known();
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
        let next = next_in_order(session, &mut expected);
        done.set(session.done());
        next.unwrap_or_else(|missing| {
            gap.set(Some(missing));
            None
        })
    })
}

/// The next tick, none at the session's end; `Err`: the one that is missing.
pub(crate) fn next_in_order(
    session: &mut Session,
    expected: &mut u64,
) -> Result<Option<InputRecord>, u64> {
    let Some(record) = session.next() else {
        return Ok(None);
    };
    if record.tick != *expected {
        return Err(*expected);
    }
    *expected += 1;
    Ok(Some(record))
}

/// Finds the first tick that differs.
#[derive(Debug, Default)]
struct Judge {
    first: Option<Different>,
    is_done: bool,
}

impl Judge {
    /// Whether to go on: after a difference only until its organ is known.
    fn look(&mut self, replayed: &Replayed<'_>, at_s: f64, organs: &[String]) -> bool {
        if self.is_done {
            return false;
        }
        let tick = replayed.record.tick;
        match (&mut self.first, replayed.differs()) {
            (None, None) => {}
            (None, Some(difference)) => {
                let organ = organ(difference, organs);
                self.is_done = organ.is_some();
                let what = match difference {
                    Difference::Organ(_) => "organ",
                    Difference::Tools => "tools",
                };
                self.first = Some(Different {
                    tick,
                    at_s,
                    what,
                    organ_tick: organ.is_some().then_some(tick),
                    organ,
                });
            }
            (Some(first), found) => {
                first.organ = found.and_then(|it| organ(it, organs));
                first.organ_tick = first.organ.is_some().then_some(tick);
                self.is_done =
                    first.organ.is_some() || tick >= first.tick.saturating_add(LOOKED_ON);
            }
        }
        !self.is_done
    }
}

impl Different {
    fn in_words(&self) -> String {
        let organ = self.organ.as_deref().map(printable);
        let what = match (self.what, organ, self.organ_tick) {
            ("tools", Some(organ), Some(tick)) => {
                format!("tools or force differ, and in tick {tick} {organ}")
            }
            ("tools", ..) => "tools or force differ, and no organ soon after".to_owned(),
            (_, Some(organ), _) => format!("{organ} differs"),
            (_, None, _) => "an organ differs".to_owned(),
        };
        format!("tick {} ({:.3} s): {what}", self.tick, self.at_s)
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
    let words = match &outcome.first_difference {
        Some(first) => format!(
            "{}. {ticks} ticks were compared; what was recorded is not what this program computes",
            first.in_words()
        ),
        None if ticks == 0 => {
            "no tick was compared: the session holds none that can be run".to_owned()
        }
        None if outcome.left_out.is_known() => {
            format!(
                "{ticks} ticks were compared and came out the same, but they are not the whole session"
            )
        }
        None => format!(
            "all {ticks} ticks came out the same, {:.1} times as fast as they were",
            outcome.session_s / outcome.took_s.max(1e-9)
        ),
    };
    let all = [words].into_iter().chain(outcome.left_out.in_words());
    all.collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(left_out: LeftOut) -> Outcome {
        Outcome {
            session: "x.mcap".into(),
            scene: String::new(),
            scene_id: String::new(),
            recorded_by: String::new(),
            replayed_by: String::new(),
            ticks: 5,
            session_s: 1.0,
            took_s: 1.0,
            same: false,
            first_difference: None,
            left_out,
        }
    }

    #[test]
    fn a_difference_is_told_with_its_tick_and_organ() {
        let told = |what, organ: Option<&str>, organ_tick| {
            let different = Different {
                tick: 7,
                at_s: 0.007,
                what,
                organ: organ.map(str::to_owned),
                organ_tick,
            };
            different.in_words()
        };
        assert_eq!(
            told("organ", Some("liver"), Some(7)),
            "tick 7 (0.007 s): liver differs"
        );
        assert!(told("tools", Some("liver"), Some(9)).ends_with("in tick 9 liver"));
        assert!(told("tools", None, None).ends_with("no organ soon after"));
    }

    #[test]
    fn what_is_left_out_is_said() {
        let whole = LeftOut {
            controller_ended: Some(true),
            ..LeftOut::default()
        };
        let words = in_words(&outcome(whole));
        assert!(
            words.starts_with("all 5 ticks") && !words.contains(';'),
            "{words}"
        );
        let damaged = LeftOut {
            damaged: Some("at byte 7: x".to_owned()),
            ..LeftOut::default()
        };
        let missing = LeftOut {
            missing: 3,
            ..LeftOut::default()
        };
        let gap = LeftOut {
            gap_at_tick: Some(4),
            missing: 3,
            ..LeftOut::default()
        };
        for (left_out, said) in [(damaged, "byte 7"), (missing, "3 ticks"), (gap, "tick 4 ")] {
            assert!(left_out.is_known());
            let words = in_words(&outcome(left_out));
            assert!(
                words.starts_with("5 ticks") && words.contains(said),
                "{words}"
            );
        }
        let cut = LeftOut {
            broken_off: Some("byte 9".to_owned()),
            ..LeftOut::default()
        };
        let killed = LeftOut {
            controller_ended: Some(false),
            ..LeftOut::default()
        };
        for (left_out, said) in [(cut, "byte 9"), (killed, "killed")] {
            assert!(!left_out.is_known());
            let words = in_words(&outcome(left_out));
            assert!(
                words.starts_with("all 5 ticks") && words.contains(said),
                "{words}"
            );
        }
    }
}
