//! `calot replay`: runs a recorded session again and compares every tick.

pub(crate) mod args;
mod close;
pub(crate) mod judge;
pub(crate) mod recorded;
mod show;
mod video;
mod what_if;

use std::cell::Cell;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use rt_process::replay::Replay;
use serde::Serialize;
use session::{Session, hex, printable};

use self::args::ReplayArgs;
use self::judge::{Different, Judge};
use self::recorded::{LeftOut, scene_of, without_gap};
use crate::build::build;
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::report::recording;
use crate::say;
use crate::sessions;

/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(1);

/// Result of a replay.
#[derive(Debug, Serialize)]
struct ReplayOutcome {
    session: std::path::PathBuf,
    scene: String,
    scene_id: String,
    recorded_by: String,
    replayed_by: String,
    /// Ticks that were run.
    ticks: u64,
    /// Time that these ticks cover in the session, s.
    session_s: f64,
    /// Time that the replay took, s.
    took_s: f64,
    /// True if every recorded tick was run again and came out equal. Ticks that may have followed
    /// in a session that breaks off, or whose controller was killed, do not count.
    same: bool,
    first_difference: Option<Different>,
    #[serde(flatten)]
    left_out: LeftOut,
}

/// Compares every tick, or, as the options say, repairs, shows or varies the session.
pub(crate) fn run(args: &ReplayArgs) -> Result<ExitCode, Problem> {
    let args = &ReplayArgs {
        session: sessions::find(&args.session)?,
        ..args.clone()
    };
    let file = recording(&args.session);
    if args.repair {
        let scene = args.scene.as_deref();
        return close::run(&file, scene, args.overwrite, args.json);
    }
    let mut session = Session::open(&file)?;
    let scene = scene_of(&mut session, args.scene.as_deref())?;
    let running = build();
    if running != session.info.build {
        say::note(format_args!(
            "calot: recorded by {}, replayed by {running}; equal bits are still expected",
            session.info.build
        ));
    }
    let named = args.out.as_deref();
    let out = || output::folder(named, "out", Format::of_result, args.overwrite);
    if args.what_if.is_some() || args.what_if_iterations.is_some() {
        return what_if::run(args, &session, &scene, &out()?);
    }
    if let Some(video) = &args.video {
        return video::run(args, &mut session, &scene, video);
    }
    if args.is_shown() {
        return show::run(args, &session, &scene, std::path::Path::new(""));
    }
    if args.frames.is_some() {
        return show::run(args, &session, &scene, &out()?);
    }
    let replay = Replay::new(&scene, &session.setup)?;
    let outcome = compare(&replay, &mut session, running)?;
    if args.json {
        document::REPLAY.answer(&outcome)?;
    }
    say::note(in_words(&outcome));
    if outcome.ticks > 0 {
        say::note(to_see(&args.session));
    }
    Ok(match outcome.same {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

fn compare(
    replay: &Replay,
    session: &mut Session,
    running: String,
) -> Result<ReplayOutcome, Problem> {
    let start = Instant::now();
    let mut said = start;
    let mut outcome = ReplayOutcome {
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
                "replaying {:3.0} %, {:.1} times as fast as recorded",
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

/// Says how to look at a session, because a comparison of its ticks shows nothing of it.
fn to_see(session: &std::path::Path) -> String {
    let session = assess::report::in_shell(&session.display().to_string());
    format!("`calot replay {session} --show` shows the operation in a window")
}

fn in_words(outcome: &ReplayOutcome) -> String {
    let ticks = outcome.ticks;
    let words = match &outcome.first_difference {
        Some(first) => format!(
            "{}. {ticks} ticks were compared; this program does not compute what was recorded",
            first.in_words()
        ),
        None if ticks == 0 => {
            "no tick was compared: the session holds no tick that can be run".to_owned()
        }
        None if outcome.left_out.is_known() => {
            format!(
                "{ticks} ticks were compared and came out equal, but they are not the whole session"
            )
        }
        None => format!(
            "all {ticks} ticks came out equal, {:.1} times as fast as recorded",
            outcome.session_s / outcome.took_s.max(1e-9)
        ),
    };
    let all = [words].into_iter().chain(outcome.left_out.in_words());
    all.collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(left_out: LeftOut) -> ReplayOutcome {
        ReplayOutcome {
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
    fn a_difference_is_reported_with_its_tick_and_organ() {
        let words = |what, organ: Option<&str>, organ_tick| {
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
            words("organ", Some("liver"), Some(7)),
            "tick 7 (0.007 s): liver differs"
        );
        assert!(words("tools", Some("liver"), Some(9)).ends_with("in tick 9 liver"));
        assert!(words("tools", None, None).ends_with("no organ soon after"));
    }

    #[test]
    fn a_comparison_ends_with_the_command_that_shows_the_operation() {
        let words = to_see("my out/session.mcap".as_ref());
        assert!(words.contains("calot replay 'my out/session.mcap' --show"));
    }

    #[test]
    fn omissions_are_reported() {
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
        let lost = LeftOut {
            lost: Some("before its repair lost 9 messages".to_owned()),
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
        for (left_out, said) in [
            (damaged, "byte 7"),
            (lost, "9 messages"),
            (missing, "3 ticks"),
            (gap, "tick 4 "),
        ] {
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
