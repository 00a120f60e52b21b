//! Adjusts the quality to the cost of frames, judged in windows of 40 frames, or of 2 s if frames
//! are slow. One window that costs too much lowers the quality. Several cheap windows in a row
//! raise it; each step up that was wrong doubles their number. If the graphics device has no clock,
//! or is the processor itself, the cost is the time between frames.

use super::gpu::Gpu;
use super::quality::Quality;

/// Allowed cost of a picture on a graphics device, ms. It leaves time for the window at 60 a
/// second.
const MAY_COST_MS: f32 = 13.0;
/// Desired interval between pictures, ms.
const PERIOD_MS: f32 = 1000.0 / 60.0;
/// Desired interval between pictures on a software driver, ms: 12 a second. The quality falls if
/// fewer than 10 a second appear.
const SOFTWARE_PERIOD_MS: f32 = 1000.0 / 12.0;
/// Number of frames in a window, which is judged by its median cost.
const FRAMES: usize = 40;
/// Least number of frames in a window that is judged early.
const FRAMES_MIN: usize = 5;
/// Sum of the costs after which a window is judged early, ms.
const EARLY_MS: f32 = 2000.0;
/// Cost that counts as too high, as a share of the allowed cost.
const TOO_MUCH: f32 = 1.05;
/// Cost, as a share of the allowed cost, below which a better tier may be tried.
const LITTLE: f32 = 0.55;
/// Frame interval that counts as too long, as a share of the screen's own interval or of the
/// desired one, whichever is longer.
const LATE: f32 = 1.2;
/// Frame interval, as a share of the screen's own interval, below which a better tier may be tried.
/// An interval below `LITTLE` of the desired one allows this, too. No frame is shown sooner than
/// the screen's interval, so only a trial of the better tier can show whether there is room.
const IN_TIME: f32 = 1.1;
/// Number of cheap windows in a row before a step up, at first.
const PATIENCE: u32 = 6;
/// Largest number of cheap windows in a row before a step up.
const PATIENCE_MAX: u32 = 384;
/// A step down within this many windows after a step up means that the step up was wrong.
const SOON: u32 = 6;

/// Watches frames and selects the quality of the next ones.
#[derive(Debug, Clone)]
pub struct Governor {
    tiers: Vec<Quality>,
    /// Index of the tier in use.
    at: usize,
    /// Cost above which the quality falls, ms.
    too_much_ms: f32,
    /// Cost below which a window is cheap, ms.
    little_ms: f32,
    /// Costs of the frames of the present window, ms.
    costs_ms: Vec<f32>,
    /// Number of cheap windows in a row so far.
    calm: u32,
    /// Number of cheap windows in a row before a step up.
    patience: u32,
    /// Number of windows since the last step up.
    since_up: u32,
}

impl Governor {
    /// Governs a window on this device. A software driver begins with the cheapest tier. Its cost
    /// is the time between frames, which includes all work of the processor. `screen_ms` is the
    /// screen's interval, or 0 if it is unknown.
    #[must_use]
    pub fn of(gpu: &Gpu, screen_ms: f32) -> Self {
        let tiers = Quality::tiers(gpu);
        if gpu.is_software() {
            Self::by_period(tiers, SOFTWARE_PERIOD_MS, screen_ms).from_below()
        } else if gpu.has_clock() {
            Self::new(tiers, MAY_COST_MS)
        } else {
            Self::by_period(tiers, PERIOD_MS, screen_ms)
        }
    }

    /// Starts with the first of the tiers, the best one; `may_cost_ms` is the allowed time of the
    /// graphics device, ms.
    #[must_use]
    pub fn new(tiers: Vec<Quality>, may_cost_ms: f32) -> Self {
        Self::between(tiers, TOO_MUCH * may_cost_ms, LITTLE * may_cost_ms)
    }

    /// Starts with frame intervals as the cost. The allowed interval is `period_ms`, or the
    /// screen's (`screen_ms`) if that is longer.
    #[must_use]
    pub fn by_period(tiers: Vec<Quality>, period_ms: f32, screen_ms: f32) -> Self {
        let late_ms = LATE * period_ms.max(screen_ms);
        Self::between(
            tiers,
            late_ms,
            (LITTLE * period_ms).max(IN_TIME * screen_ms),
        )
    }

    /// Starts with the last of the tiers, the cheapest one, and rises from there.
    #[must_use]
    pub fn from_below(mut self) -> Self {
        self.at = self.tiers.len().saturating_sub(1);
        self
    }

    fn between(tiers: Vec<Quality>, too_much_ms: f32, little_ms: f32) -> Self {
        Self {
            tiers,
            at: 0,
            too_much_ms,
            little_ms,
            costs_ms: Vec::with_capacity(FRAMES),
            calm: 0,
            patience: PATIENCE,
            since_up: u32::MAX,
        }
    }

    /// Index of the tier in use, 0 for the best, and the number of tiers.
    #[must_use]
    pub fn tier(&self) -> [usize; 2] {
        [self.at, self.tiers.len()]
    }

    /// Takes the cost of a frame, ms. Returns the new quality if the tier changes. The caller keeps
    /// the size of its picture.
    pub fn note(&mut self, cost_ms: f32) -> Option<Quality> {
        if !cost_ms.is_finite() {
            return None;
        }
        self.costs_ms.push(cost_ms);
        let count = self.costs_ms.len();
        let is_early = count >= FRAMES_MIN && self.costs_ms.iter().sum::<f32>() >= EARLY_MS;
        if count < FRAMES && !is_early {
            return None;
        }
        self.costs_ms.sort_by(f32::total_cmp);
        let median = self.costs_ms[count / 2];
        self.costs_ms.clear();
        self.since_up = self.since_up.saturating_add(1);
        let before = self.at;
        if median > self.too_much_ms {
            self.calm = 0;
            if self.at + 1 < self.tiers.len() {
                self.at += 1;
                if self.since_up <= SOON {
                    self.patience = (self.patience * 2).min(PATIENCE_MAX);
                }
            }
        } else if median < self.little_ms && self.at > 0 {
            self.calm += 1;
            if self.calm >= self.patience {
                self.at -= 1;
                self.calm = 0;
                self.since_up = 0;
            }
        } else {
            self.calm = 0;
        }
        if self.at == before {
            None
        } else {
            self.tiers.get(self.at).copied()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(governor: &mut Governor, frames: usize, cost: impl Fn(usize) -> f32) -> usize {
        let note = |governor: &mut Governor| {
            let cost_ms = cost(governor.tier()[0]);
            usize::from(governor.note(cost_ms).is_some())
        };
        (0..frames).map(|_| note(governor)).sum()
    }

    #[test]
    fn a_slow_device_gets_less_until_it_keeps_up() {
        let mut governor = Governor::new(Quality::GPU_TIERS.to_vec(), 14.0);
        run(&mut governor, 400, |tier| 30.0 - 9.0 * tier as f32);
        assert_eq!(governor.tier()[0], 2);
        // A single hitch changes nothing.
        assert_eq!(run(&mut governor, 3, |_| 500.0), 0);
        assert_eq!(run(&mut governor, 2000, |_| 12.0), 0);
    }

    #[test]
    fn governor_does_not_swing_between_two_tiers() {
        let mut governor = Governor::new(Quality::GPU_TIERS.to_vec(), 14.0);
        // The best tier costs too much, and the next one seems to have plenty of room.
        let cost = |tier: usize| if tier == 0 { 20.0 } else { 5.0 };
        let changes = run(&mut governor, 20_000, cost);
        assert!(changes < 16, "{changes} changes in 20000 frames");
    }

    #[test]
    fn device_that_has_become_quick_gets_more_again() {
        let mut governor = Governor::new(Quality::GPU_TIERS.to_vec(), 14.0);
        run(&mut governor, 400, |_| 40.0);
        let [at, tiers] = governor.tier();
        assert_eq!(at, tiers - 1);
        run(&mut governor, 4000, |_| 3.0);
        assert_eq!(governor.tier()[0], 0);
    }

    #[test]
    fn without_a_clock_the_time_between_frames_governs() {
        // A screen of 60 Hz shows a frame at its next refresh, even if the frame was ready long
        // before.
        let screen_ms = 1000.0 / 60.0;
        let period = |cost_ms: f32| screen_ms * (cost_ms / screen_ms).ceil().max(1.0);
        let new = || Governor::by_period(Quality::GPU_TIERS.to_vec(), screen_ms, screen_ms);
        let mut slow = new();
        run(&mut slow, 400, |tier| period(30.0 - 9.0 * tier as f32));
        assert_eq!(slow.tier()[0], 2, "12 ms fit, 21 do not");
        let changes = run(&mut slow, 20_000, |tier| period(30.0 - 9.0 * tier as f32));
        assert!(changes < 16, "{changes} changes in 20000 frames");
        // Frames that keep up with the screen allow a step up after a while.
        let mut quick = new();
        run(&mut quick, 400, |_| period(40.0));
        run(&mut quick, 4000, |_| period(3.0));
        assert_eq!(quick.tier()[0], 0);
        // Frames that are slow only because the screen is slow cause no step down.
        let mut screen_of_30 = Governor::by_period(Quality::GPU_TIERS.to_vec(), screen_ms, 33.3);
        assert_eq!(run(&mut screen_of_30, 4000, |_| 33.3), 0);
        // A software driver is judged against 83 ms, a much longer interval than the screen's.
        let mut software = Governor::by_period(Quality::SOFTWARE_TIERS.to_vec(), 83.0, screen_ms);
        assert_eq!(run(&mut software, 400, |_| 90.0), 0);
        assert_eq!(run(&mut software, 17, |_| 120.0), 1);
        assert_eq!(run(&mut software, 4000, |_| 60.0), 0, "no room for more");
        assert_eq!(run(&mut software, 400, |_| 20.0), 1);
    }

    #[test]
    fn slow_frames_are_judged_after_two_seconds_and_a_quick_start_is_from_below() {
        let tiers = Quality::SOFTWARE_TIERS.to_vec();
        let last = tiers.len() - 1;
        // Two pictures a second: five of them suffice to lower the quality.
        let mut slow = Governor::by_period(tiers.clone(), 83.0, 16.7);
        assert_eq!(run(&mut slow, 4, |_| 500.0), 0);
        assert_eq!(run(&mut slow, 1, |_| 500.0), 1);
        let mut cheap = Governor::by_period(tiers.clone(), 83.0, 16.7).from_below();
        assert_eq!(cheap.tier(), [last, tiers.len()]);
        assert_eq!(run(&mut cheap, 400, |_| 70.0), 0, "12 a second are enough");
        assert_eq!(run(&mut cheap, 300, |_| 30.0), 1, "33 leave room");
    }

    #[test]
    fn nonsensical_times_are_not_counted() {
        let mut governor = Governor::new(Quality::GPU_TIERS.to_vec(), 14.0);
        assert_eq!(run(&mut governor, 500, |_| f32::NAN), 0);
        let mut none = Governor::new(Vec::new(), 14.0);
        assert_eq!(run(&mut none, 500, |_| 99.0), 0);
    }
}
