//! Keeps what ran on one core in the last seconds, from the kernel's events.

use std::collections::VecDeque;

use super::{Slice, What};
use crate::kernel::TICK_THREAD;

/// Largest number of segments kept: a few seconds of a busy core, which makes some ten a tick.
const SEGMENTS_MAX: usize = 60_000;
/// Largest number of names kept. Later ones count as `others`, so memory is constant.
const LABELS_MAX: usize = 1000;
/// Deepest nesting of interrupts and softirqs. Linux nests four levels.
const DEPTH_MAX: usize = 8;

/// Something that the kernel did on the core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event<'a> {
    /// Another thread runs from now on.
    Switch {
        /// Its name.
        next: &'a str,
    },
    /// An interrupt or softirq begins.
    Enter(What, &'a str),
    /// It ends.
    Leave(What),
    /// An interrupt has ended: its name, and its duration, ns.
    Over(&'a str, u64),
    /// The kernel dropped this number of events.
    Lost(u64),
}

#[derive(Debug, Clone, Copy)]
struct Segment {
    label: u16,
    from_ns: u64,
    to_ns: u64,
}

/// Course of one core.
#[derive(Debug, Default)]
pub struct Course {
    labels: Vec<(What, String)>,
    segments: VecDeque<Segment>,
    thread: Option<u16>,
    /// Interrupts and softirqs that run on top of the thread, innermost last.
    above: Vec<u16>,
    since_ns: u64,
    /// All events before this time were taken.
    pub known_to_ns: u64,
    /// Events taken.
    pub events: u64,
    /// Events that the kernel dropped.
    pub lost_events: u64,
}

impl Course {
    /// Takes an event. Events come in the order of their times.
    pub fn take(&mut self, event: Event<'_>, at_ns: u64) {
        self.events += 1;
        self.close(at_ns);
        match event {
            Event::Switch { next } => {
                let what = match next {
                    TICK_THREAD => What::Tick,
                    _ if next.starts_with("swapper/") => What::Idle,
                    _ => What::Thread,
                };
                self.thread = Some(self.label(what, next));
                // A switch happens outside of interrupts, so the end of anything left was lost.
                self.above.clear();
            }
            Event::Enter(what, name) => {
                let label = self.label(what, name);
                if self.above.len() < DEPTH_MAX {
                    self.above.push(label);
                }
            }
            Event::Leave(what) => {
                let is_it =
                    |&label: &u16| self.labels.get(usize::from(label)).map(|l| l.0) == Some(what);
                if let Some(place) = self.above.iter().rposition(is_it) {
                    self.above.truncate(place);
                }
            }
            Event::Over(name, for_ns) => {
                let label = self.label(What::Interrupt, name);
                self.push(label, at_ns.saturating_sub(for_ns), at_ns);
            }
            Event::Lost(count) => {
                self.lost_events += count;
                self.thread = None;
                self.above.clear();
            }
        }
    }

    /// Slices that overlap a span of time, in order. The one that runs now is included.
    pub fn between(&self, from_ns: u64, to_ns: u64) -> Vec<Slice> {
        let first = self.segments.partition_point(|it| it.to_ns <= from_ns);
        let ended = self.segments.iter().skip(first);
        let running = self.top().map(|label| Segment {
            label,
            from_ns: self.since_ns,
            to_ns: self.known_to_ns.max(self.since_ns),
        });
        ended
            .copied()
            .chain(running)
            .take_while(|it| it.from_ns < to_ns)
            .filter_map(|it| {
                let (what, name) = self.labels.get(usize::from(it.label))?;
                Some(Slice {
                    what: *what,
                    name: name.clone(),
                    from_ns: it.from_ns,
                    for_ns: it.to_ns - it.from_ns,
                })
            })
            .collect()
    }

    fn top(&self) -> Option<u16> {
        self.above.last().copied().or(self.thread)
    }

    fn close(&mut self, at_ns: u64) {
        if let Some(label) = self.top() {
            self.push(label, self.since_ns, at_ns);
        }
        self.since_ns = at_ns;
    }

    fn push(&mut self, label: u16, from_ns: u64, to_ns: u64) {
        if to_ns <= from_ns {
            return;
        }
        if self.segments.len() >= SEGMENTS_MAX {
            self.segments.pop_front();
        }
        self.segments.push_back(Segment {
            label,
            from_ns,
            to_ns,
        });
    }

    /// Number of a name. The table is short in practice: a core meets a few dozen names.
    fn label(&mut self, what: What, name: &str) -> u16 {
        let same = |label: &(What, String)| label.0 == what && label.1 == name;
        let place = self.labels.iter().position(same).unwrap_or_else(|| {
            let name = match self.labels.len() < LABELS_MAX {
                true => name,
                false => "others",
            };
            if self.labels.len() <= LABELS_MAX {
                self.labels.push((what, name.to_owned()));
            }
            self.labels.len() - 1
        });
        u16::try_from(place).unwrap_or(u16::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::why::tests::slice;

    #[test]
    fn the_innermost_runs_and_what_it_interrupted_goes_on() {
        let mut course = Course::default();
        let switch = |next| Event::Switch { next };
        for (event, at_ns) in [
            (switch("swapper/1"), 100),
            (Event::Enter(What::Interrupt, "local_timer"), 200),
            (Event::Leave(What::Interrupt), 230),
            (Event::Enter(What::Softirq, "TIMER"), 240),
            (Event::Enter(What::Interrupt, "eth0"), 250),
            (Event::Leave(What::Interrupt), 270),
            (Event::Leave(What::Softirq), 300),
            (switch(TICK_THREAD), 320),
            (switch("bash"), 400),
        ] {
            course.take(event, at_ns);
        }
        course.known_to_ns = 500;
        let idle = |from, length| slice(What::Idle, "swapper/1", from, length);
        let expected = [
            idle(100, 100),
            slice(What::Interrupt, "local_timer", 200, 30),
            idle(230, 10),
            slice(What::Softirq, "TIMER", 240, 10),
            slice(What::Interrupt, "eth0", 250, 20),
            slice(What::Softirq, "TIMER", 270, 30),
            idle(300, 20),
            slice(What::Tick, TICK_THREAD, 320, 80),
            slice(What::Thread, "bash", 400, 100),
        ];
        assert_eq!(course.between(0, 1000), expected);
        assert_eq!(course.between(235, 260), expected[2..5]);
        assert!(course.between(0, 50).is_empty());
    }

    #[test]
    fn lost_events_leave_a_gap_instead_of_a_guess() {
        let mut course = Course::default();
        course.take(Event::Switch { next: "bash" }, 100);
        course.take(Event::Enter(What::Softirq, "SCHED"), 150);
        course.take(Event::Lost(7), 200);
        course.take(Event::Leave(What::Softirq), 300);
        course.take(Event::Switch { next: "sh" }, 400);
        course.take(Event::Over("nmi_handler", 10), 450);
        course.known_to_ns = 500;
        assert_eq!(course.lost_events, 7);
        let names: Vec<(String, u64)> = course
            .between(0, 1000)
            .into_iter()
            .map(|it| (it.name, it.for_ns))
            .collect();
        let expected = [
            ("bash", 50),
            ("SCHED", 50),
            ("sh", 50),
            ("nmi_handler", 10),
            ("sh", 50),
        ];
        assert_eq!(names, expected.map(|(name, ns)| (name.to_owned(), ns)));
    }

    #[test]
    fn memory_is_constant() {
        let mut course = Course::default();
        for i in 0..(2 * SEGMENTS_MAX as u64) {
            let name = format!("thread {}", i % 5000);
            course.take(Event::Switch { next: &name }, 100 * i);
        }
        assert_eq!(course.segments.len(), SEGMENTS_MAX);
        assert!(course.labels.len() <= LABELS_MAX + 1);
        for _ in 0..100 {
            course.take(Event::Enter(What::Interrupt, "x"), 1 << 40);
        }
        assert_eq!(course.above.len(), DEPTH_MAX);
    }
}
