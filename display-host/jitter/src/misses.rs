//! Compares missed periods of the station with those of a bare loop whose work takes as long.
//! Counts the misses by cause, and estimates how certain the difference is.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Number of bootstrap samples of the rounds. Their spread shows how large a difference chance can
/// make.
const DRAWS: usize = 4000;

/// Periods missed in one turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Missed {
    /// Ticks that ran.
    pub ticks: u64,
    /// Periods missed although the previous tick ended in time: the machine woke the loop too late.
    pub woken_late: u64,
    /// Periods missed while the previous tick was still at work.
    pub at_work: u64,
    /// Ticks before which one period or more was missed.
    pub occasions: u64,
    /// Ticks that ended after their deadline. Most of them cause no missed period.
    #[serde(rename = "overruns")]
    pub late_ticks: u64,
}

impl Missed {
    /// Periods missed.
    pub fn periods(self) -> u64 {
        self.woken_late.saturating_add(self.at_work)
    }

    /// Counts a tick of the station. `missed` periods were missed before it. The flags are true if
    /// the previous tick or this one ended after its deadline.
    pub fn note_tick(&mut self, missed: u32, last_overran: bool, overran: bool) {
        self.ticks += 1;
        self.late_ticks += u64::from(overran);
        self.occasions += u64::from(missed > 0);
        match last_overran {
            true => self.at_work += u64::from(missed),
            false => self.woken_late += u64::from(missed),
        }
    }

    fn add(&mut self, other: Self) {
        self.ticks += other.ticks;
        self.woken_late += other.woken_late;
        self.at_work += other.at_work;
        self.occasions += other.occasions;
        self.late_ticks += other.late_ticks;
    }
}

/// One turn of one program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Number of the round, from 0. Programs of one round ran one after the other.
    pub round: u32,
    /// Program that ran: `station`, `cyclictest`, ….
    pub program: String,
    /// Median wake-up latency, ns.
    pub p50: u64,
    /// 99 % of the wake-up latencies are at most this, ns.
    pub p99: u64,
    /// Greatest wake-up latency, ns.
    pub max: u64,
    /// Periods missed; `None` for cyclictest.
    #[serde(default)]
    pub missed: Option<Missed>,
    /// Time that the hypervisor took from the tick's core during the turn, ms, if it reports it.
    #[serde(default)]
    pub stolen_ms: Option<u64>,
}

/// Selects one count of a turn.
type Count = fn(Missed) -> u64;

/// Kinds of misses: key in JSON, label, function that selects the count.
const KINDS: [(&str, &str, Count); 5] = [
    ("periods", "periods missed", Missed::periods),
    (
        "woken_late",
        "  program asleep, woken too late by the machine",
        |m| m.woken_late,
    ),
    ("at_work", "  program still at work on its last tick", |m| {
        m.at_work
    }),
    ("occasions", "occasions of one missed period or more", |m| {
        m.occasions
    }),
    ("overruns", "ticks that ended too late", |m| m.late_ticks),
];

/// One kind of miss, per million periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Key in JSON.
    pub key: &'static str,
    /// Label.
    pub words: &'static str,
    /// Misses of the station.
    pub station: f64,
    /// Misses of `burn`, the bare loop.
    pub burn: f64,
    /// Interval that holds station − burn in 95 % of the bootstrap samples.
    pub difference: [f64; 2],
}

/// Compares the station's misses with those of `burn` over the rounds that both ran. Empty if no
/// round has both.
pub fn compare(rounds: &[Round]) -> Vec<Line> {
    let pairs = pairs(rounds);
    if pairs.is_empty() {
        return Vec::new();
    }
    let [station, burn] = sums(pairs.iter());
    let mut draws = Vec::with_capacity(DRAWS);
    let mut chance = Chance(1);
    for _ in 0..DRAWS {
        // Draw as many rounds as there were, with replacement.
        let drawn = (0..pairs.len()).filter_map(|_| pairs.get(chance.below(pairs.len())));
        draws.push(sums(drawn));
    }
    KINDS
        .map(|(key, words, of)| {
            let share = |missed: Missed| in_a_million(missed, of);
            let mut differences: Vec<f64> =
                draws.iter().map(|[a, b]| share(*a) - share(*b)).collect();
            differences.sort_by(f64::total_cmp);
            let at = |part: f64| {
                let place = (part * (DRAWS - 1) as f64).round() as usize;
                differences.get(place).copied().unwrap_or(0.0)
            };
            Line {
                key,
                words,
                station: share(station),
                burn: share(burn),
                difference: [at(0.025), at(0.975)],
            }
        })
        .to_vec()
}

/// Says whether chance could explain the difference.
pub fn verdict(line: &Line) -> &'static str {
    match line.difference {
        [low, _] if low > 0.0 => "the station's are more",
        [_, high] if high < 0.0 => "the station's are fewer",
        _ => "no difference beyond chance",
    }
}

/// Returns the comparison as `jitter.json` holds it.
pub fn to_json(lines: &[Line]) -> Value {
    let one = |line: &Line| {
        let figures = json!({
            "station": line.station,
            "burn": line.burn,
            "difference_low": line.difference[0],
            "difference_high": line.difference[1],
        });
        (line.key.to_owned(), figures)
    };
    Value::Object(lines.iter().map(one).collect())
}

fn pairs(rounds: &[Round]) -> Vec<[Missed; 2]> {
    let of = |program: &str, round: u32| {
        let mut all = rounds.iter();
        let found = all.find(|r| r.round == round && r.program == program);
        found.and_then(|r| r.missed)
    };
    let mut numbers: Vec<u32> = rounds.iter().map(|r| r.round).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let pair = |round: u32| Some([of("station", round)?, of("burn", round)?]);
    numbers.into_iter().filter_map(pair).collect()
}

fn sums<'a>(pairs: impl Iterator<Item = &'a [Missed; 2]>) -> [Missed; 2] {
    pairs.fold(Default::default(), |[mut station, mut burn], pair| {
        station.add(pair[0]);
        burn.add(pair[1]);
        [station, burn]
    })
}

fn in_a_million(missed: Missed, of: Count) -> f64 {
    match missed.ticks.saturating_add(missed.periods()) {
        0 => 0.0,
        periods => of(missed) as f64 * 1e6 / periods as f64,
    }
}

/// Turns of a program, each with cyclictest's turn of the same round.
pub fn paired<'a>(rounds: &'a [Round], program: &str) -> Vec<(&'a Round, &'a Round)> {
    let of = |round: u32| {
        let mut all = rounds.iter();
        all.find(|r| r.program == "cyclictest" && r.round == round)
    };
    let own = rounds.iter().filter(|r| r.program == program);
    own.filter_map(|r| Some((r, of(r.round)?))).collect()
}

impl Round {
    /// Misses per million periods, if known.
    pub fn misses_per_million(&self) -> Option<f64> {
        let missed = self.missed?;
        Some(per_million(missed.periods(), missed.ticks))
    }
}

/// Random numbers from a fixed seed (splitmix64), so that a report is reproducible.
struct Chance(u64);

impl Chance {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % count.max(1) as u64) as usize
    }
}

/// Misses per million periods.
pub fn per_million(missed: u64, ticks: u64) -> f64 {
    match ticks.saturating_add(missed) {
        0 => 0.0,
        periods => missed as f64 * 1e6 / periods as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounds(of: impl Fn(u32) -> [u64; 2]) -> Vec<Round> {
        let turn = |round, program: &str, missed| Round {
            round,
            program: program.to_owned(),
            p50: 1,
            p99: 2,
            max: 3,
            missed: Some(Missed {
                ticks: 30_000 - missed,
                woken_late: missed,
                occasions: missed.min(1),
                ..Missed::default()
            }),
            stolen_ms: None,
        };
        let both = |round| {
            let [station, burn] = of(round);
            [turn(round, "burn", burn), turn(round, "station", station)]
        };
        (0..10).flat_map(both).collect()
    }

    #[test]
    fn a_rare_standstill_proves_nothing_and_a_steady_excess_does() {
        // One stall of 54 ms in one turn of ten.
        let lines = compare(&rounds(|round| [if round == 3 { 54 } else { 0 }, 0]));
        let (station, burn) = (lines[0].station, lines[0].burn);
        assert!(
            (station - 180.0).abs() < 1e-9 && burn < 1e-9,
            "{station} {burn}"
        );
        assert!(
            lines[0].difference[0] < 1e-9,
            "most likely not drawn at all"
        );
        assert_eq!(verdict(&lines[0]), "no difference beyond chance");
        let lines = compare(&rounds(|round| [50 + u64::from(round % 3), 20]));
        let [low, high] = lines[0].difference;
        assert!(low > 900.0 && high < 1200.0, "{low} {high}");
        assert_eq!(verdict(&lines[0]), "the station's are more");
        assert!(lines[2].station < 1e-9, "the station missed none at work");
        let lines = compare(&rounds(|_| [20, 50]));
        assert_eq!(verdict(&lines[0]), "the station's are fewer");
    }

    #[test]
    fn rounds_without_a_partner_are_left_out() {
        let mut one_missing = rounds(|_| [1, 1]);
        one_missing.retain(|r| r.round != 9 || r.program == "burn");
        assert_eq!(pairs(&one_missing).len(), 9);
        one_missing.retain(|r| r.program == "station");
        assert!(compare(&one_missing).is_empty());
        assert!(compare(&[]).is_empty());
    }

    #[test]
    fn periods_are_missed_asleep_or_at_work() {
        let mut missed = Missed::default();
        for (periods, last_overran, overran) in
            [(0, false, true), (3, true, false), (2, false, false)]
        {
            missed.note_tick(periods, last_overran, overran);
        }
        assert_eq!((missed.at_work, missed.woken_late), (3, 2));
        assert_eq!(
            (missed.occasions, missed.late_ticks, missed.ticks),
            (2, 1, 3)
        );
    }
}
