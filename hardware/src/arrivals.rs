//! Recognises, from the times at which samples arrive, that a serial adapter or the USB delays
//! them. Names the setting that ends the delay.

use std::path::Path;

/// Samples that are judged together.
const WINDOW: u64 = 500;
/// Fewest batches for a verdict.
const BATCHES_MIN: usize = 20;
/// Longest window, ns. A slower device is judged by as many samples as came.
const WINDOW_NS: u64 = 4_000_000_000;
/// Shortest gap that ends a batch, ns. The parts of a batch arrive within one poll of 200 µs; the
/// scheduler may add a delay.
const BATCH_GAP_NS: u64 = 300_000;
/// Frame of full-speed USB, ns (USB 2.0, 7.1.12).
const FRAME_NS: u64 = 1_000_000;
/// Largest difference between a gap and the nearest whole number of frames, ns.
const FRAME_TOLERANCE_NS: u64 = 150_000;
/// Default of an FTDI adapter's latency timer, ms (FTDI AN232B-04). The adapter collects bytes
/// until this timer expires.
const FTDI_MS: u64 = 16;
/// Share of the gaps, in percent, that must fit the timer or the frames. A busy computer lengthens
/// a few gaps.
const FITTING_PERCENT: usize = 80;
/// Share of the gaps, in percent, that must have another number of frames than the median gap. If
/// all gaps have the same number, the device itself may send once per millisecond.
const DIFFERING_PERCENT: usize = 5;

/// Pattern of arrivals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pattern {
    /// An FTDI adapter's timer at its default.
    Ftdi,
    /// Regular batches of samples.
    Batches {
        /// Samples in a batch, in tenths.
        tenths: u64,
        /// Time from batch to batch, µs.
        every_us: u64,
    },
    /// Frames of full-speed USB.
    Frames,
}

impl Pattern {
    /// Key in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ftdi => "ftdi-timer",
            Self::Batches { .. } => "batches",
            Self::Frames => "usb-frames",
        }
    }

    /// The pattern, and the setting that ends it on the line `tty`.
    #[must_use]
    pub fn in_words(self, tty: &Path) -> String {
        let tty = tty.canonicalize().unwrap_or_else(|_| tty.to_owned());
        let tty = tty
            .file_name()
            .map_or("ttyUSB0".into(), |name| name.to_string_lossy());
        let timer = format!("/sys/bus/usb-serial/devices/{tty}/latency_timer");
        match self {
            Self::Ftdi => format!(
                "samples wait up to {FTDI_MS} ms in an FTDI adapter's timer; as root: echo 1 > {timer}"
            ),
            Self::Batches { tenths, every_us } => format!(
                "samples come in batches of {:.1} every {:.1} ms; with an FTDI adapter, as root: echo 1 > \
                 {timer}; otherwise let the device send each sample at once (flush after each frame)",
                tenths as f64 / 10.0,
                every_us as f64 / 1e3
            ),
            Self::Frames => "samples wait up to 1 ms for the frames of full-speed USB, which no \
                             setting of this computer shortens; use a high-speed device (frames of \
                             125 µs) at a port without a full-speed hub, or sample in step with the \
                             frames"
                .to_owned(),
        }
    }
}

/// Samples that arrived together.
#[derive(Debug, Clone, Copy)]
struct Batch {
    first_ns: u64,
    last_ns: u64,
    samples: u64,
}

/// Arrivals of a line's samples.
#[derive(Debug, Default)]
pub struct Arrivals {
    batches: Vec<Batch>,
    samples: u64,
    found: Option<Pattern>,
}

impl Arrivals {
    /// Takes `samples` that arrived at `at_ns`.
    pub fn take(&mut self, samples: u64, at_ns: u64) {
        if samples == 0 {
            return;
        }
        self.samples += samples;
        match self.batches.last_mut() {
            Some(last) if at_ns.saturating_sub(last.last_ns) < BATCH_GAP_NS => {
                last.last_ns = at_ns;
                last.samples += samples;
            }
            _ => self.batches.push(Batch {
                first_ns: at_ns,
                last_ns: at_ns,
                samples,
            }),
        }
        let first_ns = self.batches.first().map_or(at_ns, |batch| batch.first_ns);
        let is_long = at_ns.saturating_sub(first_ns) >= WINDOW_NS;
        let is_full = self.samples >= WINDOW && self.batches.len() > BATCHES_MIN;
        if is_full || is_long {
            self.found = pattern(&self.batches);
            self.batches.clear();
            self.samples = 0;
        }
    }

    /// Pattern of the last window.
    #[must_use]
    pub const fn found(&self) -> Option<Pattern> {
        self.found
    }
}

/// Pattern of a window of batches; `None` if no pattern shows.
fn pattern(batches: &[Batch]) -> Option<Pattern> {
    // The last batch may not be whole.
    let whole = batches.split_last()?.1;
    if whole.len() < BATCHES_MIN {
        return None;
    }
    let samples: u64 = whole.iter().map(|batch| batch.samples).sum();
    let tenths = 10 * samples / whole.len() as u64;
    let pairs = batches.windows(2);
    let gaps: Vec<u64> = pairs
        .filter_map(|pair| match pair {
            [a, b] => Some(b.first_ns - a.first_ns),
            _ => None,
        })
        .collect();
    let mut sorted = gaps.clone();
    sorted.sort_unstable();
    let median_ns = *sorted.get(sorted.len() / 2)?;
    let fits = |is_it: &dyn Fn(u64) -> bool| {
        let count = gaps.iter().filter(|&&gap| is_it(gap)).count();
        100 * count >= FITTING_PERCENT * gaps.len()
    };
    let is_regular = fits(&|gap| gap.abs_diff(median_ns) <= median_ns / 4);
    let timer_ns = FTDI_MS * FRAME_NS;
    // A device slower than the timer has one sample in some batches and two in others.
    if tenths >= 13 && is_regular && median_ns.abs_diff(timer_ns) <= FRAME_NS {
        return Some(Pattern::Ftdi);
    }
    let fits_frames = fits(&|gap| {
        let off = gap % FRAME_NS;
        gap >= FRAME_NS / 2 && off.min(FRAME_NS - off) <= FRAME_TOLERANCE_NS
    });
    let frames = |gap: u64| (gap + FRAME_NS / 2) / FRAME_NS;
    let others = gaps.iter().filter(|&&gap| frames(gap) != frames(median_ns));
    let differ = 100 * others.count() >= DIFFERING_PERCENT * gaps.len();
    let has_several_per_frame = tenths >= 12 && frames(median_ns) == 1;
    let has_frame_period = is_whole_frames(gaps.iter().sum::<u64>() / samples.max(1));
    if fits_frames && !has_frame_period && (differ || has_several_per_frame) {
        return Some(Pattern::Frames);
    }
    (tenths >= 18 && is_regular).then_some(Pattern::Batches {
        tenths,
        every_us: median_ns / 1000,
    })
}

/// True if the mean period is a whole number of frames. A device may then send at that period
/// itself, and samples that are read late look as if they had waited for frames.
fn is_whole_frames(period_ns: u64) -> bool {
    let frames = (period_ns + FRAME_NS / 2) / FRAME_NS;
    // A device's clock deviates by less than 1 %. A window may have one sample too many or too few.
    frames > 0 && 100 * period_ns.abs_diff(frames * FRAME_NS) <= 3 * frames * FRAME_NS
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pattern after six seconds of samples every `every_ns`. `arrival_ns` gives the arrival time
    /// of a sample. The line is polled every 200 µs, and arrivals have up to 20 µs of jitter.
    fn found(every_ns: u64, arrival_ns: impl Fn(u64) -> u64) -> Option<Pattern> {
        let mut arrivals = Arrivals::default();
        let mut waiting: Vec<u64> = Vec::new();
        let mut taken = 0;
        let mut state = 1u64;
        for poll in 0..30_000u64 {
            let now_ns = poll * 200_000;
            while taken * every_ns <= now_ns {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                waiting.push(arrival_ns(taken * every_ns) + (state >> 33) % 20_000);
                taken += 1;
            }
            let arrived: Vec<u64> = waiting.extract_if(.., |at_ns| *at_ns <= now_ns).collect();
            if let Some(&newest) = arrived.iter().max() {
                arrivals.take(arrived.len() as u64, newest);
            }
        }
        arrivals.found()
    }

    /// Arrival times of samples that wait for the next multiple of `interval_ns`.
    fn held(interval_ns: u64) -> impl Fn(u64) -> u64 {
        move |at_ns| at_ns.div_ceil(interval_ns) * interval_ns
    }

    #[test]
    fn ftdis_timer_is_recognised_at_the_rates_of_devices() {
        for every_us in [500, 1000, 2000, 4000, 10_000] {
            let found = found(every_us * 1000, held(16_000_000));
            assert_eq!(found, Some(Pattern::Ftdi), "{every_us} µs");
        }
    }

    #[test]
    fn other_batches_are_reported_with_their_size_and_interval() {
        let Some(Pattern::Batches { tenths, every_us }) = found(1_000_000, held(5_000_000)) else {
            panic!("no batches");
        };
        assert!((48..=52).contains(&tenths), "{tenths}");
        assert!(every_us.abs_diff(5000) < 250, "{every_us}");
    }

    #[test]
    fn frames_of_full_speed_usb_are_recognised_unless_the_device_sends_every_whole_millisecond() {
        for every_us in [300, 500, 700, 1400] {
            let found = found(every_us * 1000, held(1_000_000));
            assert_eq!(found, Some(Pattern::Frames), "{every_us} µs");
        }
        // A device that itself sends every second millisecond looks the same on any USB.
        assert_eq!(found(2_000_000, held(1_000_000)), None);
    }

    #[test]
    fn samples_that_arrive_without_delay_have_no_pattern() {
        for every_us in [700, 1000, 1300, 4000, 10_000] {
            let found = found(every_us * 1000, |at_ns| at_ns);
            assert_eq!(found, None, "{every_us} µs");
        }
        // A busy computer that reads every fifth sample late.
        let late = |at_ns: u64| match (at_ns / 1_000_000).is_multiple_of(5) {
            true => at_ns + 1_000_000,
            false => at_ns,
        };
        assert_eq!(found(1_000_000, late), None);
        // High-speed USB has frames of 125 µs.
        assert_eq!(found(700_000, held(125_000)), None);
        assert_eq!(Arrivals::default().found(), None);
    }

    #[test]
    fn each_pattern_names_its_setting() {
        let tty = Path::new("/dev/ttyUSB7");
        let words = |pattern: Pattern| pattern.in_words(tty);
        let timer = "echo 1 > /sys/bus/usb-serial/devices/ttyUSB7/latency_timer";
        assert!(words(Pattern::Ftdi).contains(timer));
        let batches = words(Pattern::Batches {
            tenths: 52,
            every_us: 5100,
        });
        assert!(batches.contains("batches of 5.2 every 5.1 ms") && batches.contains("ttyUSB7"));
        assert!(words(Pattern::Frames).contains("high-speed device"));
    }
}
