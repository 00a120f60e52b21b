mod basics;
mod clips;
mod complications;
mod course;
mod endoscope;
mod errors;
mod hand;
mod injuries;
mod phantom;
mod stones;
mod views;

use bytemuck::Zeroable as _;
use proptest::prelude::*;
use session::identity::{ORGANS_MAX, OrganSeen, Seen};
use session::{Entry, EntryContent, Movement};
use shared_mem::message::{EventMsg, PoseMsg};
use shared_mem::scene::OrganKind;
use shared_mem::words::{EventKind, Fault};

use crate::*;
use hand::circle;

const LIVER: u32 = 0;
const DUCT: u32 = 1;
const ARTERY: u32 = 2;
const BILE_DUCT: u32 = 3;
const FAT: u32 = 4;
/// Number of an organ that does not exist.
const NOTHING: u32 = u32::MAX;

fn anatomy() -> Anatomy {
    let organs = [
        ("liver", OrganKind::Liver),
        ("cystic duct", OrganKind::CysticDuct),
        ("cystic artery", OrganKind::CysticArtery),
        ("bile duct", OrganKind::BileDuct),
        ("fat", OrganKind::Fat),
    ];
    let regions = [Region::Triangle, Region::LowerBed, Region::UpperBed];
    let cells: Vec<Region> = regions.into_iter().flat_map(|it| [it; 10]).collect();
    Anatomy::new(&organs, &cells)
}

fn begin(task: Task) -> Assessment {
    Assessment::new(task, Difficulty::Trainee, Rules::default(), anatomy())
}

fn here(tip_m: [f32; 3]) -> Movement {
    Movement {
        world_from_handle: PoseMsg::IDENTITY,
        world_from_instrument: PoseMsg::IDENTITY,
        world_from_camera: PoseMsg::IDENTITY,
        tip_m,
        force_n: [0.0; 3],
        jaw: 1.0,
        instrument: 0,
        switches: 16,
        live: 7,
        contacts: 0,
    }
}

fn moved(at_s: f64, movement: Movement) -> Entry {
    let at_ns = 1_000_000_000 + (at_s * 1e9) as u64;
    Entry {
        tick: at_ns / 1_000_000,
        at_ns,
        what: EntryContent::Moved(movement),
    }
}

/// An identity image that shows nothing.
fn nothing_seen() -> Seen {
    Seen {
        side_rad: 0.0,
        triangle: 0.0,
        lower_bed: 0.0,
        organs: [OrganSeen::default(); ORGANS_MAX],
    }
}

/// A good critical view from this side.
fn good_view(side: ViewSide) -> Seen {
    let mut seen = Seen {
        side_rad: if side == ViewSide::Front { 0.3 } else { -0.3 },
        triangle: 0.5,
        lower_bed: 0.3,
        ..nothing_seen()
    };
    for organ in [DUCT, ARTERY] {
        seen.organs[organ as usize] = OrganSeen::new(1.0, 0.75, 0.01, 0.2);
    }
    seen
}

/// Holds a picture from this time on, with five identity images a second.
fn hold(assessment: &mut Assessment, from_s: f64, seconds: f64, seen: &Seen) {
    for step in 0..=(seconds * 5.0).round() as u32 {
        let at_s = from_s + f64::from(step) * 0.2;
        assessment.take(&moved(at_s, here([0.0, 0.0, -0.1])));
        let entry = moved(at_s, here([0.0; 3]));
        let what = EntryContent::Seen(*seen);
        assessment.take(&Entry { what, ..entry });
    }
}

/// Shows the critical view from both sides in five seconds.
fn hold_views(assessment: &mut Assessment, from_s: f64) {
    for (number, side) in [0.0, 2.5].into_iter().zip(ViewSide::BOTH) {
        hold(assessment, from_s + number, 2.2, &good_view(side));
    }
}

fn event(at_s: f64, kind: u32, organ: u32, x_m: f32, value: f32) -> Entry {
    let at_ns = 1_000_000_000 + (at_s * 1e9) as u64;
    let event = EventMsg {
        at_ns,
        kind,
        organ,
        at_m: [x_m, 0.0, 0.0],
        value,
        ..EventMsg::zeroed()
    };
    Entry {
        tick: 0,
        at_ns,
        what: EntryContent::Event(event),
    }
}

fn unclamped(organ: &str) -> Reason {
    let organ = organ.to_owned();
    Reason::Unclamped { organ }
}

/// Keeps the hands at rest between two times, with ten entries a second.
fn rest(assessment: &mut Assessment, from_s: f64, to_s: f64) {
    let steps = ((to_s - from_s) * 10.0).round() as u32;
    for step in 0..=steps {
        let at_s = from_s + f64::from(step) * 0.1;
        assessment.take(&moved(at_s, here([0.0, 0.0, -0.1])));
    }
}

/// Closes the clip of this number on an organ, at `x_m` on the x axis.
fn clip(assessment: &mut Assessment, at_s: f64, organ: u32, x_m: f32, number: f32) {
    assessment.take(&event(at_s, EventKind::Clip.number(), organ, x_m, number));
}

fn clip_both(assessment: &mut Assessment) {
    clip(assessment, 0.1, DUCT, -0.01, 0.0);
    clip(assessment, 0.2, DUCT, 0.01, 1.0);
    clip(assessment, 0.3, ARTERY, -0.01, 2.0);
    clip(assessment, 0.4, ARTERY, 0.01, 3.0);
}

/// Divides a vessel with clips closed on both sides.
fn cut(assessment: &mut Assessment, at_s: f64, organ: u32) {
    cut_open(assessment, at_s, organ, 0.0);
}

/// Divides a vessel, with this share of one side open.
fn cut_open(assessment: &mut Assessment, at_s: f64, organ: u32, open: f32) {
    assessment.take(&event(at_s, EventKind::Cut.number(), organ, 0.0, 0.001));
    assessment.take(&event(at_s, EventKind::Divided.number(), organ, 0.0, open));
}

/// Asserts that two numbers are equal, apart from rounding.
#[track_caller]
fn is(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
}

/// Kinds of the alarms, in order.
fn kinds(assessed: &Assessed) -> Vec<AlarmKind> {
    assessed.alarms.iter().map(|alarm| alarm.kind).collect()
}

fn remove(assessment: &mut Assessment, cells: core::ops::Range<u32>) {
    for cell in cells {
        assessment.take(&event(
            1.0,
            EventKind::Removed.number(),
            FAT,
            0.0,
            cell as f32,
        ));
    }
}

#[test]
fn definitions_are_complete_and_their_names_differ() {
    let mut names: Vec<&str> = Metric::ALL.iter().map(|metric| metric.name()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), Metric::ALL.len());
    for metric in Metric::ALL {
        assert!(metric.definition().ends_with('.'), "{}", metric.name());
        assert!(!metric.source().is_empty());
        assert_eq!(Metric::from_name(metric.name()), Some(metric));
        let unit = metric.unit();
        let last = unit.to_lowercase().replace('/', "_");
        let told = unit == "n" || unit == "1" || metric.name().ends_with(&last);
        assert!(told, "{} in {unit}", metric.name());
    }
}

proptest! {
    #[test]
    fn a_path_does_not_depend_on_how_often_it_is_looked_at(hz in 20.0f64..250.0, seconds in 2.0f64..9.0) {
        let path_m = circle(hz, seconds, 0.0).get(Metric::Path);
        let true_m = 0.05 * std::f64::consts::TAU / 4.0 * (hz * seconds).floor() / hz;
        prop_assert!((path_m - true_m).abs() < 0.02 * true_m + 0.006, "{} {}", path_m, true_m);
        is(circle(hz, seconds, 0.0).get(Metric::Movements), 1.0);
    }

    #[test]
    fn tremor_is_no_path(amplitude in 0.0f64..0.0003) {
        let calm = circle(100.0, 4.0, 0.0).get(Metric::Path);
        let shaky = circle(100.0, 4.0, amplitude).get(Metric::Path);
        prop_assert!((shaky - calm).abs() < 0.06 * calm, "{} {}", calm, shaky);
    }

    #[test]
    fn times_of_parts_sum_to_the_whole(
        steps in prop::collection::vec((0.001f64..0.2, any::<bool>()), 2..80),
        split in 0.0f64..1.0,
    ) {
        let mut entries = Vec::new();
        let mut at_s = 0.0;
        for (seconds, on) in &steps {
            at_s += seconds;
            let switches = if *on { 17 } else { 16 };
            entries.push(moved(at_s, Movement { instrument: 1, switches, ..here([0.0; 3]) }));
        }
        let middle = ((split * entries.len() as f64) as usize).min(entries.len() - 1);
        let over = |entries: &[Entry]| {
            let mut assessment = begin(Task::Free);
            entries.iter().for_each(|entry| assessment.take(entry));
            assessment.end().metrics
        };
        // The entry in the middle ends one part and begins the next.
        let [one, two, whole] =
            [&entries[..=middle], &entries[middle..], &entries[..]].map(over);
        for metric in [Metric::Time, Metric::CauteryOn, Metric::CauteryAir] {
            let sum = one.get(metric) + two.get(metric);
            prop_assert!((sum - whole.get(metric)).abs() < 1e-6);
        }
    }

    /// The assessment of any file ends, has a score in range, and is reproducible.
    #[test]
    fn hostile_entries_are_assessed(
        raw in prop::collection::vec((0u8..5, any::<u64>(), any::<[f32; 4]>(), 0u32..24, 0u32..7), 0..200),
        task in 0..Task::ALL.len(),
    ) {
        let entries: Vec<Entry> = raw.iter().map(|&(kind, at_ns, [x, y, z, value], event, organ)| {
            let what = match kind {
                0 if event == 0 => EntryContent::Start { task: organ as u8 },
            0 => EntryContent::Reset,
                1 => EntryContent::Device { force_max_n: value },
                2 => EntryContent::Moved(Movement { force_n: [x, y, z], ..here([x, y, z]) }),
                _ => EntryContent::Event(EventMsg {
                    kind: event,
                    organ,
                    at_m: [x, y, z],
                    value,
                    ..EventMsg::zeroed()
                }),
            };
            Entry { tick: 0, at_ns, what }
        }).collect();
        let run = || {
            let mut assessment = begin(Task::ALL[task]);
            for entry in &entries {
                assessment.take(entry);
                let _ = assessment.status();
            }
            assessment.end()
        };
        let assessed = run();
        prop_assert!((0.0..=100.0).contains(&assessed.score));
        prop_assert_ne!(assessed.outcome, Outcome::Running);
        prop_assert_eq!(run().metrics, assessed.metrics);
    }
}
