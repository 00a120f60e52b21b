//! Draws pictures of alarms and of the critical view of safety from the recording. The simulation
//! runs again and draws at each of these moments.

use std::path::Path;
use std::time::{Duration, Instant};

use assess::{Alarm, Assessment};
use display_host::album::Album;
use display_host::kept::VIEWS;
use display_host::words::Words;
use rt_process::replay::Replay;
use session::Session;
use shared_mem::inputs::InputRecord;
use shared_mem::message::CommandMsg;

use crate::problem::Problem;
use crate::replay::recorded::{next_in_order, scene_of};
use crate::say;

/// Largest number of pictures of a session.
const PICTURES_MAX: usize = 16;
/// Size of a picture, pixels.
const SIZE: [u32; 2] = [640, 480];
/// Ticks per step of smoke, blood and sparks.
const EFFECTS_EVERY: u64 = 20;
/// Duration of a tick, s.
const TICK_S: f32 = 0.001;
/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(1);

/// A moment to draw.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Wanted {
    tick: u64,
    /// Time of the task, as minutes and seconds.
    at: String,
    shows: Shows,
}

/// Content of a picture.
#[derive(Debug, Clone, PartialEq)]
enum Shows {
    /// An error.
    Alarm(Alarm),
    /// A critical view that was held; the message names the side.
    View(&'static str),
}

/// Messages that name the sides of a critical view, in the order of [`VIEWS`].
const SIDES: [&str; 2] = ["picture-cvs-front", "picture-cvs-behind"];

impl Wanted {
    fn kept_in(&self) -> Option<&'static str> {
        let Shows::View(id) = &self.shows else {
            return None;
        };
        let mut sides = SIDES.into_iter().zip(VIEWS);
        sides.find_map(|(side, file)| (side == *id).then_some(file))
    }

    fn caption(&self, words: &Words) -> String {
        match &self.shows {
            Shows::Alarm(alarm) => {
                let id = format!("alarm-{}", alarm.kind.name().replace('_', "-"));
                let organ = words.organ(alarm.organ.as_deref().unwrap_or("?"));
                let text = words.say_with(&id, &[("organ", organ.into())]);
                format!("{}: {text}", self.at)
            }
            Shows::View(id) => words.say_with(id, &[("at", self.at.as_str().into())]),
        }
    }
}

/// A picture of a moment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Picture {
    /// Host time, ns.
    pub(crate) at_ns: u64,
    pub(crate) caption: String,
    pub(crate) png: Vec<u8>,
    /// File next to the session in which the run kept a picture of this view, if it did.
    pub(crate) kept_in: Option<&'static str>,
}

/// Notes the moments to draw while a session is assessed.
#[derive(Debug, Default)]
pub(super) struct Watch {
    wanted: Vec<Wanted>,
    alarms: usize,
    views_held: [bool; 2],
}

impl Watch {
    /// Looks at the assessment after an entry of this tick.
    pub(super) fn look(&mut self, tick: u64, assessment: &Assessment) {
        let (alarms, held) = (assessment.alarms(), assessment.views_held());
        let mut views = self.views_held.into_iter().zip(held);
        if alarms.len() < self.alarms || views.any(|(before, now)| before && !now) {
            // The task restarted, so the earlier moments do not count.
            *self = Self::default();
        }
        let at = clock(assessment.time_s());
        for alarm in alarms.iter().skip(self.alarms) {
            self.want(tick, &at, Shows::Alarm(alarm.clone()));
        }
        self.alarms = alarms.len();
        for ((id, held), before) in SIDES.into_iter().zip(held).zip(self.views_held) {
            if held && !before {
                self.want(tick, &at, Shows::View(id));
            }
        }
        self.views_held = held;
    }

    fn want(&mut self, tick: u64, at: &str, shows: Shows) {
        self.wanted.push(Wanted {
            tick,
            at: at.to_owned(),
            shows,
        });
    }

    /// The moments in order of time. Of many alarms, an even selection.
    pub(super) fn end(self) -> Vec<Wanted> {
        let is_view = |it: &Wanted| matches!(it.shows, Shows::View(_));
        let (views, alarms): (Vec<_>, Vec<_>) = self.wanted.into_iter().partition(is_view);
        let room = PICTURES_MAX.saturating_sub(views.len()).max(1);
        let every = alarms.len().div_ceil(room).max(1);
        let mut wanted: Vec<_> = alarms.into_iter().step_by(every).chain(views).collect();
        wanted.sort_by_key(|it| it.tick);
        wanted
    }
}

/// Minutes and seconds.
fn clock(seconds: f64) -> String {
    let seconds = seconds.max(0.0);
    format!("{}:{:04.1}", (seconds / 60.0) as u64, seconds % 60.0)
}

/// Draws the moments. Omits moments after a gap in the session.
pub(crate) fn draw(
    session: &Path,
    wanted: &[Wanted],
    words: &Words,
) -> Result<Vec<Picture>, Problem> {
    let Some(last) = wanted.last() else {
        return Ok(Vec::new());
    };
    let mut session = Session::open(session)?;
    let scene = scene_of(&mut session, None)?;
    let replay = Replay::new(&scene, &session.setup)?;
    let mut album = Album::open(&scene, SIZE)?;
    let (mut state, mut tools) = (bytemuck::zeroed_box(), bytemuck::zeroed_box());
    let mut pictures = Vec::new();
    let mut problem = None;
    let mut events = Vec::new();
    let mut left = wanted.iter().peekable();
    let mut said = Instant::now();
    // Ticks outside of pauses since the effects were last played. In a pause nothing bleeds.
    let mut passed = 0;
    let mut expected = 0;
    let ticks = core::iter::from_fn(|| next_in_order(&mut session, &mut expected).ok().flatten());
    replay.run(ticks, |tick| {
        let record = tick.record;
        if is_restart(record) {
            album.clear();
            events.clear();
        }
        events.extend(tick.events());
        passed += u32::from(!tick.view.tool.switches.paused);
        let is_due = left.peek().is_some_and(|it| it.tick <= record.tick);
        if is_due || record.tick.is_multiple_of(EFFECTS_EVERY) {
            tick.fill(replay.scene_id(), &mut state, &mut tools);
            album.pass(&state, &tools, &events, TICK_S * passed as f32);
            events.clear();
            passed = 0;
        }
        while let Some(it) = left.next_if(|it| it.tick <= record.tick) {
            match album.draw(&state, &tools) {
                Ok(png) => pictures.push(Picture {
                    at_ns: record.now_ns,
                    caption: it.caption(words),
                    png,
                    kept_in: it.kept_in(),
                }),
                Err(error) => problem = Some(error),
            }
        }
        if said.elapsed() >= PROGRESS {
            said = Instant::now();
            let share = 100.0 * record.tick as f64 / last.tick.max(1) as f64;
            say::note(format_args!("drawing pictures: {share:.0} %"));
        }
        record.tick < last.tick && problem.is_none()
    })?;
    match problem {
        Some(problem) => Err(problem.into()),
        None => Ok(pictures),
    }
}

/// True if this tick returns the organs to rest or to the start of a task.
fn is_restart(record: &InputRecord) -> bool {
    let command = u32::from(record.command & 15);
    matches!(command, CommandMsg::RESET | CommandMsg::START)
}

#[cfg(test)]
mod tests {
    use assess::AlarmKind;
    use display_host::words::Language;

    use super::*;

    fn burnt() -> Shows {
        Shows::Alarm(Alarm {
            at_s: 1.0,
            session_s: 2.0,
            kind: AlarmKind::Burnt,
            organ: Some("liver".to_owned()),
            at_m: [0.0; 3],
        })
    }

    #[test]
    fn captions_are_in_the_language() {
        let mut watch = Watch::default();
        watch.want(1, "0:01.0", burnt());
        watch.want(2, "0:02.0", Shows::View("picture-cvs-front"));
        let words = Words::new(Language::German);
        let captions = watch.end().into_iter().map(|it| it.caption(&words));
        let captions: Vec<_> = captions.collect();
        assert_eq!(captions[0], "0:01.0: verbrannt: Leber");
        assert!(captions[1].starts_with("0:02.0: der Critical View"));
    }

    #[test]
    fn of_many_moments_few_are_drawn_and_the_first_is_among_them() {
        let mut watch = Watch::default();
        for tick in 0..100 {
            watch.want(tick, "", burnt());
        }
        for id in ["picture-cvs-front", "picture-cvs-behind"] {
            watch.want(33, "0:33.0", Shows::View(id));
        }
        let wanted = watch.end();
        let both = wanted
            .iter()
            .filter(|it| it.tick == 33 && matches!(it.shows, Shows::View(_)));
        assert_eq!(both.count(), 2, "the view is seen from two sides");
        assert!(wanted.len() <= PICTURES_MAX && wanted.len() > PICTURES_MAX / 2);
        assert_eq!(wanted[0].tick, 0);
        assert!(wanted.windows(2).all(|it| it[0].tick <= it[1].tick));
    }

    #[test]
    fn a_clock_has_minutes() {
        assert_eq!([clock(5.25), clock(125.0)], ["0:05.2", "2:05.0"]);
    }
}
