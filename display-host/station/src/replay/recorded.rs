//! A recorded session as `calot replay` reads it: its scene, its ticks in order, its missing parts.

use std::cell::Cell;

use serde::Serialize;
use session::{End, Session, hex, printable};
use shared_mem::inputs::InputRecord;
use shared_mem::scene::SceneFile;

use crate::problem::Problem;

/// Parts of a session that are missing or are not run again.
#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct LeftOut {
    /// First missing tick. Ticks after it are not run.
    pub(crate) gap_at_tick: Option<u64>,
    /// Place where the session breaks off before its end (a kill, a full disk).
    pub(crate) broken_off: Option<String>,
    /// Place and kind of damage. Ticks after it are not run.
    pub(crate) damaged: Option<String>,
    /// Messages and spans that the session lost before it was repaired. Ticks after the first of
    /// them are not run.
    pub(crate) lost: Option<String>,
    /// Ticks that ran and were not recorded.
    pub(crate) missing: u64,
    /// True if the controller reported its end. `None` if the session could not be read to its end.
    pub(crate) controller_ended: Option<bool>,
}

impl LeftOut {
    pub(crate) fn of(session: &Session, gap_at_tick: Option<u64>) -> Self {
        let (mut broken_off, mut damaged, mut lost) = (None, None, None);
        match session.end() {
            Some(End::BrokenOff(why)) => broken_off = Some(why.clone()),
            Some(End::Damaged(why)) => damaged = Some(why.clone()),
            Some(End::Lost(what)) => lost = Some(what.clone()),
            Some(End::Whole) | None => {}
        }
        let finish = session.finish();
        Self {
            gap_at_tick,
            broken_off,
            damaged,
            lost,
            missing: finish.map_or(0, |finish| finish.missing),
            controller_ended: finish.map(|finish| finish.ran.is_some()),
        }
    }

    /// True if ticks are known to be missing from the session.
    pub(crate) fn is_known(&self) -> bool {
        let has_hole = self.gap_at_tick.is_some() || self.lost.is_some();
        has_hole || self.damaged.is_some() || self.missing > 0
    }

    /// One warning per part.
    pub(crate) fn in_words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if let Some(tick) = self.gap_at_tick {
            words.push(format!(
                "tick {tick} and maybe others are missing in the session; the result does not cover what comes \
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
                "the session is damaged {why}; the result does not cover what comes after"
            ));
        }
        if let Some(what) = &self.lost {
            words.push(format!("the session was damaged: {what}"));
        }
        if let Some(why) = &self.broken_off {
            words.push(format!(
                "the session breaks off ({why}), as when its recorder is killed; the result does not cover what \
                 came after"
            ));
        }
        if self.controller_ended == Some(false) {
            words.push(
                "the controller did not report its end (it was killed, or continued), so ticks may have \
                 followed"
                    .to_owned(),
            );
        }
        words
    }
}

/// The scene at `named`, or the session's own if none is named. Fails if the session ran on another
/// scene.
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

/// The session's ticks up to the first missing one. `gap` gets the number of the missing tick, and
/// `done` the share of the session that has been read.
pub(crate) fn without_gap<'a>(
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

/// The next tick, or `None` at the session's end. `Err` holds the number of the expected tick if
/// another one comes.
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
