//! Watches for the causes of late ticks during a turn of the station.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::AtomicU32;

use shared_mem::message::TimingBatch;

use super::coarse::Counters;
use super::course::Course;
use super::switches::Switches;
use super::tracer::Tracer;
use super::{Causes, LATE_NS, Source, losses};
use crate::blackbox::{BlackBox, Tick};
use crate::report::Report;

/// Largest number of ticks that wait until the source covers their time: four seconds of ticks. If
/// the source lags further behind, the oldest ticks are dropped.
const WAITING_MAX: usize = 4000;
/// Largest number of slices kept of an incident. Its 33 ticks usually have some ten slices each.
const SLICES_MAX: usize = 660;

/// Source of the causes.
#[derive(Debug)]
enum From {
    Events(Tracer),
    Switches(Switches),
    Counters(Counters),
    Nothing,
}

/// Causes of the late ticks of a turn.
#[derive(Debug)]
pub struct Watch {
    from: From,
    missing: String,
    waiting: VecDeque<Tick>,
    causes: Causes,
    virtual_machine: bool,
}

impl Watch {
    /// Begins to watch a core. It reads the kernel's events if this user may, else context
    /// switches, else counters. `process` is the process of the tick's thread, 0 until it is known.
    pub fn begin(core: usize, virtual_machine: bool, process: Arc<AtomicU32>) -> Self {
        Self::with(Tracer::begin(core), core, virtual_machine, process)
    }

    fn with(
        tracer: Result<Tracer, String>,
        core: usize,
        virtual_machine: bool,
        process: Arc<AtomicU32>,
    ) -> Self {
        let (from, missing) = match tracer {
            Ok(tracer) => (From::Events(tracer), String::new()),
            Err(missing) => match Switches::begin(core) {
                Ok(switches) => (From::Switches(switches), missing),
                Err(refused) => {
                    let missing = format!("{missing}; {refused}");
                    match Counters::begin(core, process) {
                        Ok(counters) => (From::Counters(counters), missing),
                        Err(error) => (From::Nothing, format!("{missing}; {error}")),
                    }
                }
            },
        };
        Self {
            from,
            missing,
            waiting: VecDeque::new(),
            causes: Causes::default(),
            virtual_machine,
        }
    }

    /// Takes a batch of ticks.
    pub fn take(&mut self, batch: &TimingBatch) {
        for record in batch.records().unwrap_or_default() {
            if self.waiting.len() >= WAITING_MAX {
                self.waiting.pop_front();
            }
            self.waiting.push_back(Tick::from(record));
        }
    }

    /// Finds the causes of the ticks whose time the source covers, and gives new incidents their
    /// slices.
    pub fn settle(&mut self, black_box: &mut BlackBox) {
        let Self {
            from,
            waiting,
            causes,
            virtual_machine,
            ..
        } = self;
        match from {
            From::Events(tracer) => {
                explain(
                    &tracer.course(),
                    waiting,
                    causes,
                    black_box,
                    *virtual_machine,
                );
            }
            From::Switches(switches) => {
                explain(
                    &switches.course(),
                    waiting,
                    causes,
                    black_box,
                    *virtual_machine,
                );
            }
            From::Counters(counters) => counters.with(|rises| {
                for tick in known(waiting, rises.known_to_ns()) {
                    let lost_ns = u64::from(tick.wake_latency_ns);
                    if lost_ns >= LATE_NS {
                        let cause = rises.cause(tick.scheduled_ns, lost_ns);
                        causes.take(cause.as_slice());
                    }
                }
            }),
            From::Nothing => waiting.clear(),
        }
    }

    /// Ends the turn: adds its causes to the report.
    pub fn end(mut self, black_box: &mut BlackBox, report: &mut Report) {
        black_box.interrupt();
        // Meanwhile the source is read once more, and so covers the last ticks.
        std::thread::sleep(std::time::Duration::from_millis(100));
        self.settle(black_box);
        let (name, events, lost_events) = match &self.from {
            From::Events(tracer) => {
                let course = tracer.course();
                ("events", course.events, course.lost_events)
            }
            From::Switches(switches) => {
                let course = switches.course();
                ("switches", course.events, course.lost_events)
            }
            From::Counters(_) => ("counters", 0, 0),
            From::Nothing => ("nothing", 0, 0),
        };
        let source = Source {
            name: name.to_owned(),
            is_coarse: !matches!(name, "events" | "switches"),
            missing: self.missing,
            events,
            lost_events,
            late_ticks: self.causes.late_ticks,
        };
        report.explained(source, self.causes.table());
    }
}

/// Finds the causes of the ticks whose time a course covers, and gives new incidents their slices.
fn explain(
    course: &Course,
    waiting: &mut VecDeque<Tick>,
    causes: &mut Causes,
    black_box: &mut BlackBox,
    virtual_machine: bool,
) {
    for tick in known(waiting, course.known_to_ns) {
        let slices = course.between(tick.scheduled_ns, tick.end_ns());
        causes.take(&losses(&tick, &slices, virtual_machine));
    }
    black_box.explain(course.known_to_ns, |from_ns, to_ns| {
        let mut slices = course.between(from_ns, to_ns);
        slices.truncate(SLICES_MAX);
        slices
    });
}

/// Takes the ticks that ended before `known_to_ns` out of the queue.
fn known(waiting: &mut VecDeque<Tick>, known_to_ns: u64) -> Vec<Tick> {
    let count = waiting.partition_point(|tick| tick.end_ns() < known_to_ns);
    waiting.drain(..count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;
    use crate::why::What;
    use crate::why::course::Event;
    use crate::why::tests::tick;

    #[test]
    fn ticks_wait_until_the_source_has_come_up_to_them() {
        let mut waiting: VecDeque<Tick> = (0..5).map(|i| tick(i * 1000, 10, 100)).collect();
        assert!(known(&mut waiting, 100).is_empty());
        assert_eq!(known(&mut waiting, 3000).len(), 3);
        assert_eq!(waiting.len(), 2);
    }

    #[test]
    fn a_turn_gives_the_report_its_causes_and_each_incident_its_slices() {
        let mut course = crate::why::course::Course::default();
        course.take(
            Event::Switch {
                next: "kworker/1:0",
            },
            900_000,
        );
        course.take(Event::Switch { next: "calot-tick" }, 1_200_000);
        course.take(Event::Switch { next: "swapper/1" }, 1_300_000);
        course.known_to_ns = 2_000_000;
        let mut watch = Watch {
            from: From::Events(Tracer::of(course)),
            missing: String::new(),
            waiting: VecDeque::from([tick(1_000_000, 200_000, 100_000)]),
            causes: Causes::default(),
            virtual_machine: false,
        };
        let (mut black_box, mut report) = (BlackBox::default(), sample());
        black_box.note(tick(1_000_000, 200_000, 100_000), 0);
        watch.settle(&mut black_box);
        watch.end(&mut black_box, &mut report);
        let cause = &report.causes[0];
        assert_eq!(
            (cause.what, cause.name.as_str()),
            (What::Thread, "kworker/1:0")
        );
        assert_eq!((cause.lost_us, cause.ticks), (200, 1));
        let source = report.why.expect("a source");
        assert_eq!((source.name.as_str(), source.late_ticks), ("events", 1));
        let incidents = black_box.incidents();
        let names: Vec<&str> = incidents[0]
            .slices
            .iter()
            .map(|it| it.name.as_str())
            .collect();
        assert_eq!(names, ["kworker/1:0", "calot-tick"]);
    }

    #[test]
    fn a_source_that_never_comes_keeps_four_seconds() {
        let mut watch = Watch {
            from: From::Nothing,
            missing: "nothing".to_owned(),
            waiting: VecDeque::new(),
            causes: Causes::default(),
            virtual_machine: false,
        };
        let mut batch: Box<TimingBatch> = bytemuck::allocation::zeroed_box();
        batch.count = 4;
        for _ in 0..WAITING_MAX {
            watch.take(&batch);
        }
        assert_eq!(watch.waiting.len(), WAITING_MAX);
        let (mut black_box, mut report) = (BlackBox::default(), sample());
        watch.end(&mut black_box, &mut report);
        assert!(report.causes.is_empty() && report.why.is_some_and(|why| why.is_coarse));
    }

    #[test]
    fn without_tracefs_switches_are_read_or_the_missing_permission_is_told() {
        let no_tracefs = Err("tracefs is not mounted".to_owned());
        let mut watch = Watch::with(no_tracefs, 0, true, Arc::default());
        let (mut black_box, mut report) = (BlackBox::default(), sample());
        watch.settle(&mut black_box);
        watch.end(&mut black_box, &mut report);
        let source = report.why.expect("a source");
        assert!(
            source.missing.starts_with("tracefs is not mounted"),
            "{source:?}"
        );
        let says_more = source.missing.contains("perf_event_open on core 0");
        match source.name.as_str() {
            "switches" => assert!(!source.is_coarse && !says_more, "{source:?}"),
            "counters" => assert!(source.is_coarse && says_more, "{source:?}"),
            name => panic!("{name}"),
        }
    }
}
