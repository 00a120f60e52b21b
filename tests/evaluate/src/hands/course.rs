//! Samples the course of a trial at a rate, adds noise, and assesses it as the course of a session.

use assess::{Anatomy, Assessment, Difficulty, Metric, Rules, Task, Values};
use session::{Entry, EntryContent, Movement};
use shared_mem::message::PoseMsg;

use super::trial::Trial;

/// Longest time between two rows that are interpolated, s. Longer times stay gaps, as in a session.
const GAP_S: f64 = 0.25;
/// Nominal rate of the recorded rows in tables, Hz.
const NATIVE_HZ: f64 = 10.0;

/// Rate of samples, and noise that is added to them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Condition {
    /// Rate at which the rows are interpolated, Hz; `None`: the rows themselves.
    resampled_hz: Option<f64>,
    /// Standard deviation per axis, mm.
    pub(super) noise_mm: f64,
}

impl Condition {
    /// All conditions: each rate with each noise.
    pub(super) const ALL: [Self; 12] = {
        let rates = [None, Some(30.0), Some(100.0), Some(1000.0)];
        let noise = [0.0, 0.1, 0.3];
        let mut all = [Self {
            resampled_hz: None,
            noise_mm: 0.0,
        }; 12];
        let mut index = 0;
        while index < all.len() {
            all[index] = Self {
                resampled_hz: rates[index / 3],
                noise_mm: noise[index % 3],
            };
            index += 1;
        }
        all
    };
    /// Index of the condition of a session: 100 Hz, no noise added.
    pub(super) const SESSION: usize = 6;

    pub(super) fn rate_hz(self) -> f64 {
        self.resampled_hz.unwrap_or(NATIVE_HZ)
    }
}

/// A measure of both hands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    Time,
    Path,
    Movements,
    Smoothness,
    Economy,
    Idle,
    IdleShare,
    BothMoving,
    PathRatio,
}

impl Measure {
    pub(super) const ALL: [Self; 9] = [
        Self::Time,
        Self::Path,
        Self::Movements,
        Self::Smoothness,
        Self::Economy,
        Self::Idle,
        Self::IdleShare,
        Self::BothMoving,
        Self::PathRatio,
    ];

    /// Name in the CSV file: that of the session's metric, if it has one.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Time => Metric::Time.name(),
            Self::Path => Metric::Path.name(),
            Self::Movements => Metric::Movements.name(),
            Self::Smoothness => Metric::Smoothness.name(),
            Self::Economy => Metric::Economy.name(),
            Self::Idle => Metric::Idle.name(),
            Self::IdleShare => "idle_share",
            Self::BothMoving => Metric::BothMoving.name(),
            Self::PathRatio => "path_ratio",
        }
    }

    /// Meaning, for a reader of the page.
    pub(super) fn meaning(self) -> &'static str {
        match self {
            Self::Time => "time of the trial, s",
            Self::Path => "path of both instruments, m",
            Self::Movements => "movements of both instruments",
            Self::Smoothness => "smoothness (SPARC), mean of both",
            Self::Economy => "straightness of movements, mean of both",
            Self::Idle => "time in which both rested for 1 s or more, s",
            Self::IdleShare => "that time as a share of the trial",
            Self::BothMoving => "share of the moving time in which both moved",
            Self::PathRatio => "shorter path over longer path",
        }
    }

    /// The value, computed from the metrics of the trial and of the trial with exchanged hands.
    fn of(self, [one, other]: &[Values; 2]) -> f64 {
        let hands = |metric: Metric| [one.get(metric), other.get(metric)];
        let sum = |metric: Metric| hands(metric).iter().sum::<f64>();
        let [first_m, second_m] = hands(Metric::Path);
        match self {
            Self::Time => one.get(Metric::Time),
            Self::Path => first_m + second_m,
            Self::Movements => sum(Metric::Movements),
            Self::Smoothness => 0.5 * sum(Metric::Smoothness),
            Self::Economy => 0.5 * sum(Metric::Economy),
            Self::Idle => one.get(Metric::Idle),
            Self::IdleShare => one.get(Metric::Idle) / one.get(Metric::Time),
            Self::BothMoving => one.get(Metric::BothMoving),
            Self::PathRatio => first_m.min(second_m) / first_m.max(second_m),
        }
    }
}

/// All measures of a trial under a condition.
pub(super) fn measure(trial: &Trial, condition: Condition) -> Vec<f64> {
    let mut course = match condition.resampled_hz {
        Some(hz) => curve(trial, hz),
        None => {
            let [first, second] = &trial.hands;
            let places = first.iter().zip(second).map(|(a, b)| [*a, *b]);
            trial.times_s.iter().copied().zip(places).collect()
        }
    };
    let mut noise = Noise::of(&trial.name);
    for (_, places) in &mut course {
        for x in places.iter_mut().flatten() {
            *x += 1e-3 * condition.noise_mm * noise.next();
        }
    }
    // A session measures path, movements, smoothness and economy of one hand only, so the trial is
    // assessed twice, with exchanged hands.
    let metrics = [[0, 1], [1, 0]].map(|order| assess(&course, order));
    let values = Measure::ALL.iter().map(|it| it.of(&metrics));
    values.collect()
}

/// Times, s, and positions of both hands, m.
type Course = Vec<(f64, [[f64; 3]; 2])>;

/// Metrics of free practice. `tip` is the hand with the instrument, `lens` the one with the
/// endoscope.
fn assess(course: &Course, [tip, lens]: [usize; 2]) -> Values {
    let nothing = Anatomy::new(&[], &[]);
    let (task, difficulty) = (Task::Free, Difficulty::Trainee);
    let mut assessment = Assessment::new(task, difficulty, Rules::default(), nothing);
    let began_s = course.first().map_or(0.0, |(at_s, _)| *at_s);
    for (at_s, places) in course {
        let [tip_m, lens_m] = [tip, lens].map(|hand| places[hand].map(|x| x as f32));
        let world_from_camera = PoseMsg {
            position_m: lens_m,
            ..PoseMsg::IDENTITY
        };
        let movement = Movement {
            world_from_handle: PoseMsg::IDENTITY,
            world_from_instrument: PoseMsg::IDENTITY,
            world_from_camera,
            tip_m,
            force_n: [0.0; 3],
            jaw: 0.0,
            instrument: 0,
            switches: 0,
            live: 0,
            contacts: 0,
        };
        let at_ns = ((at_s - began_s) * 1e9) as u64;
        assessment.take(&Entry {
            tick: at_ns / 1_000_000,
            at_ns,
            what: EntryContent::Moved(movement),
        });
    }
    assessment.end().metrics
}

/// Positions at a rate, on cubic Hermite curves through the rows. The slope at a row is that
/// between its neighbours.
fn curve(trial: &Trial, hz: f64) -> Course {
    let times = &trial.times_s;
    let (Some(began_s), Some(ended_s)) = (times.first(), times.last()) else {
        return Vec::new();
    };
    let mut course = Vec::new();
    let mut row = 0;
    for step in 0..=((ended_s - began_s) * hz) as u32 {
        let at_s = began_s + f64::from(step) / hz;
        while row + 2 < times.len() && times[row + 1] <= at_s {
            row += 1;
        }
        let long_s = times[row + 1] - times[row];
        if long_s > GAP_S {
            continue;
        }
        let share = (at_s - times[row]) / long_s;
        let places = trial.hands.each_ref().map(|hand| {
            let [from, to] = [row, row + 1].map(|index| (hand[index], slope(times, hand, index)));
            [0, 1, 2].map(|axis| {
                let value =
                    |(place, slope): ([f64; 3], [f64; 3])| (place[axis], slope[axis] * long_s);
                hermite(value(from), value(to), share)
            })
        });
        course.push((at_s, places));
    }
    course
}

/// Slope of the straight line between a row's neighbours, m/s.
fn slope(times: &[f64], hand: &[[f64; 3]], index: usize) -> [f64; 3] {
    let (before, after) = (index.saturating_sub(1), (index + 1).min(times.len() - 1));
    let seconds = times[after] - times[before];
    [0, 1, 2].map(|axis| (hand[after][axis] - hand[before][axis]) / seconds)
}

/// Cubic with these values and slopes at 0 and 1.
fn hermite(from: (f64, f64), to: (f64, f64), at: f64) -> f64 {
    let rest = 1.0 - at;
    from.0 * rest * rest * (1.0 + 2.0 * at)
        + to.0 * at * at * (3.0 - 2.0 * at)
        + at * rest * (from.1 * rest - to.1 * at)
}

/// Nearly normal random numbers of standard deviation 1: sums of twelve uniform numbers. Equal
/// names give equal numbers.
struct Noise(u64);

impl Noise {
    fn of(name: &str) -> Self {
        let mix = |sum: u64, byte: u8| (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        Self(name.bytes().fold(0xcbf2_9ce4_8422_2325, mix))
    }

    fn next(&mut self) -> f64 {
        let mut uniform = || {
            let next = self.0.wrapping_mul(6_364_136_223_846_793_005);
            self.0 = next.wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::trial::Group;
    use super::*;

    /// A trial of one minute. The first hand moves to and fro, the second rests.
    fn trial() -> Trial {
        let times_s: Vec<f64> = (0..=600).map(|step| f64::from(step) * 0.1).collect();
        let swing = |at_s: &f64| [0.05 * (at_s * std::f64::consts::TAU / 4.0).cos(), 0.0, 0.0];
        let hands = [
            times_s.iter().map(swing).collect(),
            vec![[0.1; 3]; times_s.len()],
        ];
        Trial {
            name: "Peg/E1/01".to_owned(),
            task: "Peg".to_owned(),
            person: "E1".to_owned(),
            group: Group::Expert,
            times_s,
            hands,
        }
    }

    #[test]
    fn a_swing_measures_the_same_under_every_condition() {
        let trial = trial();
        for condition in Condition::ALL {
            let values = super::measure(&trial, condition);
            let of = |measure: Measure| {
                let index = Measure::ALL.iter().position(|it| *it == measure);
                values[index.unwrap()]
            };
            // Fifteen cycles of 20 cm. At each of the thirty reversals, the metric's dead band of
            // 0.8 mm shortens the path.
            let path_m = of(Measure::Path);
            assert!((2.8..3.1).contains(&path_m), "{path_m} m {condition:?}");
            assert!((of(Measure::Time) - 60.0).abs() < 0.01);
            assert!(of(Measure::PathRatio) < 0.02, "{condition:?}");
            assert!(of(Measure::BothMoving) < 1e-9);
        }
    }

    #[test]
    fn a_curve_passes_through_the_rows_and_not_through_a_gap() {
        let mut trial = trial();
        let course = curve(&trial, 30.0);
        assert_eq!(course.len(), 1801);
        let (at_s, [place, _]) = course[300];
        assert!((at_s - 10.0).abs() < 1e-9 && (place[0] - trial.hands[0][100][0]).abs() < 1e-9);
        trial.times_s.drain(100..150);
        for hand in &mut trial.hands {
            hand.drain(100..150);
        }
        let within = curve(&trial, 30.0);
        assert!(within.iter().all(|(at_s, _)| !(10.0..14.9).contains(at_s)));
        assert!(within.len() > 1600);
    }

    #[test]
    fn noise_is_normal_and_the_same_for_the_same_name() {
        let mut noise = Noise::of("a");
        let drawn: Vec<f64> = (0..20_000).map(|_| noise.next()).collect();
        let mean = drawn.iter().sum::<f64>() / 2e4;
        let square = drawn.iter().map(|it| it * it).sum::<f64>() / 2e4;
        assert!(
            mean.abs() < 0.03 && (square - 1.0).abs() < 0.05,
            "{mean} {square}"
        );
        assert!((Noise::of("a").next() - drawn[0]).abs() < 1e-15);
        assert!((Noise::of("b").next() - drawn[0]).abs() > 1e-9);
    }

    #[test]
    fn the_sessions_condition_is_that_of_a_session() {
        let session = Condition::ALL[Condition::SESSION];
        assert!((session.rate_hz() - 100.0).abs() < 1e-12 && session.noise_mm < 1e-12);
    }
}
