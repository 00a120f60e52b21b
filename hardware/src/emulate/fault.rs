//! Seeded faults of a line: the effects of cables, adapters and firmware on bytes.

use super::random::Random;

/// Faults of one device's line, from device to controller unless stated otherwise. The default has
/// none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Faults {
    /// Share of bytes that are lost.
    pub lost: f32,
    /// Share of bytes that arrive twice.
    pub duplicated: f32,
    /// Share of bytes with one flipped bit.
    pub corrupted: f32,
    /// Share of writes that are split: a part arrives at once, the rest with the next write.
    pub split: f32,
    /// Share of writes that arrive together with the next write.
    pub merged: f32,
    /// Interval between two batches of bytes, ms (an FTDI adapter's default is 16); 0: no batches.
    pub batch_ms: u32,
    /// Share of samples with a rotation of length zero. Code that normalises it unchecked gets NaN.
    pub degenerate: f32,
    /// Time after which every write repeats the last write before that time, s.
    pub stuck_from_s: Option<f32>,
    /// Time at which the line hangs up, s.
    pub hang_up_at_s: Option<f32>,
    /// Time after the hang-up at which the line comes back, s. `None`: never.
    pub back_after_s: Option<f32>,
    /// Share of milliseconds in which a few random bytes are added.
    pub babble: f32,
    /// Share of the controller's bytes with one flipped bit.
    pub corrupted_to_device: f32,
    /// Interval at which the device takes 16 bytes, ms; 0: all at once.
    pub slow_reader_ms: u32,
    /// Start of all faults except the hang-up, s.
    pub from_s: f32,
    /// End of all faults except the hang-up, s. `None`: never.
    pub until_s: Option<f32>,
}

/// Bytes that a slow device takes at once.
const SLOW_BYTES: usize = 16;

impl Faults {
    /// Faults that are active at `at_s`.
    fn now(&self, at_s: f32) -> Self {
        let over = self.until_s.is_some_and(|until_s| at_s >= until_s);
        if at_s < self.from_s || over {
            Self {
                hang_up_at_s: self.hang_up_at_s,
                back_after_s: self.back_after_s,
                ..Self::default()
            }
        } else {
            *self
        }
    }
}

/// A line to which faults are applied.
#[derive(Debug)]
pub(super) struct FaultyLine {
    configured: Faults,
    /// Faults that are active now.
    faults: Faults,
    random: Random,
    queued: Vec<u8>,
    last: Vec<u8>,
}

/// Largest number of bytes that are held back: more than the buffer of a pty. Beyond this number
/// the oldest bytes are lost.
const HELD_LIMIT: usize = 8192;

impl FaultyLine {
    pub(super) fn new(faults: Faults, random: Random) -> Self {
        Self {
            configured: faults,
            faults: faults.now(0.0),
            random,
            queued: Vec::new(),
            last: Vec::new(),
        }
    }

    pub(super) fn faults(&self) -> &Faults {
        &self.faults
    }

    /// Starts a millisecond and chooses the faults that are active in it.
    pub(super) fn begin(&mut self, at_s: f32) {
        self.faults = self.configured.now(at_s);
    }

    /// Number of the controller's bytes that the device takes now.
    pub(super) fn bytes_taken(&self, tick: u64) -> usize {
        match u64::from(self.faults.slow_reader_ms) {
            0 => usize::MAX,
            slow if tick.is_multiple_of(slow) => SLOW_BYTES,
            _ => 0,
        }
    }

    /// Damages the controller's bytes on their way to the device.
    pub(super) fn arrive_at_device(&mut self, bytes: &mut [u8]) {
        if self.faults.corrupted_to_device > 0.0 {
            for byte in bytes {
                if self.random.chance(self.faults.corrupted_to_device) {
                    *byte ^= 1 << (self.random.next() % 8);
                }
            }
        }
    }

    /// True if this sample's rotation gets length zero.
    pub(super) fn degenerate(&mut self) -> bool {
        self.faults.degenerate > 0.0 && self.random.chance(self.faults.degenerate)
    }

    /// Takes bytes that the device sends at `time_s`.
    pub(super) fn send(&mut self, bytes: &[u8], time_s: f64) {
        if self
            .faults
            .stuck_from_s
            .is_some_and(|from| time_s >= f64::from(from))
        {
            self.queued.extend_from_slice(&self.last);
            return;
        }
        self.last.clear();
        self.last.extend_from_slice(bytes);
        for &byte in bytes {
            if self.random.chance(self.faults.lost) {
                continue;
            }
            let byte = if self.random.chance(self.faults.corrupted) {
                byte ^ 1 << (self.random.next() % 8)
            } else {
                byte
            };
            self.queued.push(byte);
            if self.random.chance(self.faults.duplicated) {
                self.queued.push(byte);
            }
        }
    }

    /// Passes on the bytes that arrive in this millisecond.
    pub(super) fn arrive(&mut self, tick: u64, mut write: impl FnMut(&[u8])) {
        if self.random.chance(self.faults.babble) {
            for _ in 0..1 + self.random.next() % 32 {
                self.queued.push(self.random.next() as u8);
            }
        }
        if self.queued.len() > HELD_LIMIT {
            self.queued.drain(..self.queued.len() - HELD_LIMIT);
        }
        if self.faults.batch_ms > 0 && !tick.is_multiple_of(self.faults.batch_ms.into()) {
            return;
        }
        if self.queued.is_empty() || self.random.chance(self.faults.merged) {
            return;
        }
        let count = if self.random.chance(self.faults.split) {
            self.random.next() as usize % self.queued.len()
        } else {
            self.queued.len()
        };
        write(&self.queued[..count]);
        self.queued.drain(..count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(faults: Faults, seed: u64) -> Vec<u8> {
        let mut line = FaultyLine::new(faults, Random::new(seed, 0));
        let mut arrived = Vec::new();
        for tick in 0..1000 {
            line.send(&[1, 2, 3, 4], tick as f64 * 1e-3);
            line.arrive(tick, |bytes| arrived.extend_from_slice(bytes));
        }
        arrived
    }

    #[test]
    fn without_faults_everything_arrives() {
        assert_eq!(through(Faults::default(), 1), [1, 2, 3, 4].repeat(1000));
    }

    #[test]
    fn faults_occur_in_their_periods() {
        let faults = Faults {
            lost: 1.0,
            slow_reader_ms: 4,
            from_s: 0.1,
            until_s: Some(0.2),
            ..Faults::default()
        };
        let mut line = FaultyLine::new(faults, Random::new(1, 0));
        let mut arrived = 0;
        for tick in 0..300u64 {
            line.begin(tick as f32 * 1e-3);
            line.send(&[1], tick as f64 * 1e-3);
            line.arrive(tick, |bytes| arrived += bytes.len());
            let ill = (100..200).contains(&tick);
            let takes = if !ill {
                usize::MAX
            } else if tick % 4 == 0 {
                SLOW_BYTES
            } else {
                0
            };
            assert_eq!(line.bytes_taken(tick), takes, "{tick}");
        }
        assert_eq!(arrived, 200);
    }

    #[test]
    fn the_same_seed_gives_the_same_damage() {
        let faults = Faults {
            lost: 0.01,
            corrupted: 0.01,
            split: 0.3,
            merged: 0.3,
            ..Faults::default()
        };
        assert_eq!(through(faults, 5), through(faults, 5));
        assert_ne!(through(faults, 5), through(faults, 6));
    }

    #[test]
    fn splitting_merging_and_batching_lose_only_the_last_bytes() {
        let faults = Faults {
            split: 0.5,
            merged: 0.5,
            batch_ms: 16,
            ..Faults::default()
        };
        let arrived = through(faults, 3);
        assert!([1, 2, 3, 4].repeat(1000).starts_with(&arrived));
        assert!(arrived.len() > 3500, "{}", arrived.len());
    }

    #[test]
    fn each_fault_damages_the_stream() {
        let clean = 4000;
        assert!(
            through(
                Faults {
                    lost: 0.1,
                    ..Faults::default()
                },
                1
            )
            .len()
                < clean - 200
        );
        assert!(
            through(
                Faults {
                    duplicated: 0.1,
                    ..Faults::default()
                },
                1
            )
            .len()
                > clean + 200
        );
        assert!(
            through(
                Faults {
                    babble: 0.1,
                    ..Faults::default()
                },
                1
            )
            .len()
                > clean + 200
        );
        let corrupted = through(
            Faults {
                corrupted: 0.1,
                ..Faults::default()
            },
            1,
        );
        assert!(corrupted.iter().any(|byte| !(1..=4).contains(byte)));
    }
}
