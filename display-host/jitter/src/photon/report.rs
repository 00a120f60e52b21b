//! The report of `calot photon`, and its file `photon.json`.

use core::fmt::Write as _;

use figures::{Machine, PresentationSummary};
use serde::Serialize;

use super::pair::Pairs;

/// Name of the file in the folder of a run.
pub const FILE: &str = "photon.json";
/// Fewest changes for a meaningful median.
const FEW: u64 = 10;

/// Figures of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Program and version.
    pub program: String,
    /// Command line of the run.
    pub command: String,
    /// Name of the scene.
    pub scene: String,
    /// True if every place was measured for its full time.
    pub complete: bool,
    /// The light sensor.
    pub sensor: Light,
    /// Screen and driver.
    pub screen: Screen,
    /// Light that comes later than this after a change does not count as its light, ms.
    pub longest_ms: f64,
    /// Figures by place, in the order of measurement.
    pub places: Vec<Figures>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// The machine at the start of the run.
    pub machine: Machine,
}

/// The light sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Light {
    /// `pin`, `sound`, `board` or `button`.
    pub kind: &'static str,
    /// Line and pin as typed.
    pub name: String,
    /// True if it says dark where the square is bright.
    pub inverted: bool,
    /// Uncertainty of a time of the sensor, ms: half of the span in which the median edge was seen.
    pub within_ms: Option<f64>,
    /// Known delay of the sensor, which all times to light leave out, ms.
    pub delay_ms: f64,
}

/// Screen and driver.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Screen {
    /// Size of the window, pixels.
    pub size: [u32; 2],
    /// True if the window covered the screen.
    pub full_screen: bool,
    /// Refresh rate, Hz; null if the window system does not tell.
    pub refresh_hz: Option<f64>,
    /// Rule by which the driver takes pictures.
    pub present_mode: String,
    /// Graphics adapter and driver.
    pub adapter: String,
    /// Times from the handing over of the picture to its presentation by the window system.
    pub presentation_ms: Option<Spread>,
    /// Way of the pictures to the screen, or the reason why it is not known.
    pub presentation: PresentationSummary,
}

/// Times of one kind, ms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Number of times.
    pub count: usize,
    /// Least.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// 90 % quantile.
    pub p90: f64,
    /// Greatest.
    pub max: f64,
}

/// Figures of one place of the screen and one cause, `from`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// `top`, `middle` or `bottom`.
    pub place: &'static str,
    /// `tick`: from the tick's reading of the devices. `motion`: from the sample's arrival.
    pub from: &'static str,
    /// Changes of the square that count.
    pub changes: u64,
    /// Changes whose light was not seen.
    pub unseen: u64,
    /// Changes left out, because another came within the longest time.
    pub crowded: u64,
    /// Times from the cause to the handing over of the picture.
    pub to_picture_ms: Option<Spread>,
    /// Times from the cause to the presentation of the picture by the window system.
    pub to_presentation_ms: Option<Spread>,
    /// Times from the cause to the light.
    pub to_light_ms: Option<Spread>,
    /// Times from the handing over to the light.
    pub picture_to_light_ms: Option<Spread>,
    /// Times from the presentation to the light.
    pub presentation_to_light_ms: Option<Spread>,
}

impl Spread {
    /// Summary of times in ns; `None` if there are none.
    #[must_use]
    pub fn of(ns: impl IntoIterator<Item = i64>) -> Option<Self> {
        let mut all: Vec<i64> = ns.into_iter().collect();
        all.sort_unstable();
        // The division gives ms and keeps every ns.
        let at = |share: f64| {
            let index = (share * (all.len() - 1) as f64).round() as usize;
            all.get(index).map(|&ns| ns as f64 / 1e6)
        };
        let (first, last) = (*all.first()?, *all.last()?);
        Some(Self {
            count: all.len(),
            min: first as f64 / 1e6,
            median: at(0.5)?,
            p90: at(0.9)?,
            max: last as f64 / 1e6,
        })
    }
}

impl Figures {
    /// Figures of a place, without the sensor's known delay.
    #[must_use]
    pub fn of(place: &'static str, from: &'static str, pairs: &Pairs, delay_ms: f64) -> Self {
        let delay_ns = (delay_ms * 1e6) as i64;
        let times = |ns: &[u64], less: i64| Spread::of(ns.iter().map(|&ns| ns as i64 - less));
        let since = |ns: &[i64]| Spread::of(ns.iter().map(|ns| ns - delay_ns));
        Self {
            place,
            from,
            changes: pairs.count(),
            unseen: pairs.unseen,
            crowded: pairs.crowded,
            to_picture_ms: times(&pairs.to_picture_ns, 0),
            to_presentation_ms: times(&pairs.to_presentation_ns, 0),
            to_light_ms: times(&pairs.to_light_ns, delay_ns),
            picture_to_light_ms: since(&pairs.picture_to_light_ns),
            presentation_to_light_ms: since(&pairs.presentation_to_light_ns),
        }
    }

    /// True if more than a twentieth of the changes were not seen. The maximum may then be cut off.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        20 * self.unseen > self.changes
    }

    /// True if there are too few changes for a median.
    #[must_use]
    pub fn is_few(&self) -> bool {
        self.changes < FEW
    }
}

impl Report {
    /// True if every place was measured for its full time, and no maximum is cut off.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.complete && !self.places.iter().any(Figures::is_cut)
    }

    /// The result in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let of = |from: &str| {
            let mut all: Vec<(f64, f64)> = (self.places.iter())
                .filter(|it| it.from == from && (from == "tick" || !it.is_few()))
                .filter_map(|it| it.to_light_ms.map(|it| (it.median, it.max)))
                .collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            let worst = all.iter().map(|it| it.1).fold(f64::NAN, f64::max);
            all.get(all.len() / 2).map(|it| (it.0, worst))
        };
        match (of("motion"), of("tick")) {
            (Some((median, worst)), _) => format!(
                "A motion was seen {median:.1} ms after its sample had arrived, at the median, and \
                 {worst:.1} ms at most."
            ),
            (None, Some((median, worst))) => format!(
                "A tick was seen {median:.1} ms after it had begun, at the median, and {worst:.1} ms \
                 at most. Too few motions were seen."
            ),
            (None, None) => "No light was seen.".to_owned(),
        }
    }
}

/// The report as text.
#[must_use]
pub fn text(report: &Report) -> String {
    let mut text = format!("{}\n\n", report.sentence());
    let _ = writeln!(
        text,
        "{:<8} {:<8} {:>8} {:>8} {:>11} {:>9} {:>13} {:>15} {:>14}",
        "place",
        "from",
        "changes",
        "unseen",
        "light p50",
        "max",
        "picture p50",
        "presented p50",
        "then p50"
    );
    let ms = |spread: Option<Spread>, of: fn(Spread) -> f64| {
        spread.map_or_else(|| "-".to_owned(), |spread| format!("{:.1}", of(spread)))
    };
    for it in &report.places {
        let _ = writeln!(
            text,
            "{:<8} {:<8} {:>8} {:>8} {:>11} {:>9} {:>13} {:>15} {:>14}",
            it.place,
            it.from,
            it.changes,
            it.unseen,
            ms(it.to_light_ms, |s| s.median),
            ms(it.to_light_ms, |s| s.max),
            ms(it.to_picture_ms, |s| s.median),
            ms(it.to_presentation_ms, |s| s.median),
            ms(it.picture_to_light_ms, |s| s.median),
        );
    }
    let _ = writeln!(
        text,
        "ms. picture: until it is handed over; presented: until the window system presents it; then: \
         from the handing over to the light. Screen: {}.",
        screen(&report.screen)
    );
    for note in &report.notes {
        let _ = writeln!(text, "note: {note}");
    }
    text
}

/// Screen and driver in words.
pub(super) fn screen(screen: &Screen) -> String {
    let rate = screen.refresh_hz.map_or_else(
        || "unknown rate".to_owned(),
        |hz| format!("{hz:.2} Hz, {:.2} ms a frame", 1e3 / hz),
    );
    let [width, height] = screen.size;
    let full = if screen.full_screen {
        "full screen"
    } else {
        "in a window"
    };
    format!(
        "{width}x{height} {full}, {rate}, present mode {}, {}; {}",
        screen.present_mode,
        screen.adapter,
        screen.presentation.said()
    )
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::photon) fn pairs() -> Pairs {
        Pairs {
            to_picture_ns: vec![10_000_000, 12_000_000],
            to_light_ns: vec![31_000_000, 35_000_000],
            seen_at_ns: vec![5_000_000_000, 5_499_000_000],
            to_presentation_ns: vec![18_000_000],
            picture_to_presentation_ns: vec![8_000_000],
            presentation_to_light_ns: vec![13_000_000],
            picture_to_light_ns: vec![21_000_000, 23_000_000],
            unseen: 1,
            crowded: 4,
            inverted: false,
        }
    }

    pub(in crate::photon) fn sample() -> Report {
        let pairs = pairs();
        Report {
            program: "calot 0".to_owned(),
            command: "calot photon --pin <x>".to_owned(),
            scene: "built-in".to_owned(),
            complete: true,
            sensor: Light {
                kind: "pin",
                name: "CTS of /dev/ttyS0".to_owned(),
                inverted: false,
                within_ms: Some(0.05),
                delay_ms: 1.0,
            },
            screen: Screen {
                size: [1920, 1080],
                full_screen: true,
                refresh_hz: Some(60.0),
                present_mode: "Fifo".to_owned(),
                adapter: "none".to_owned(),
                presentation_ms: Spread::of([8_000_000]),
                presentation: PresentationSummary {
                    source: Some("x11_present"),
                    copies: 70,
                    ..PresentationSummary::default()
                },
            },
            longest_ms: 400.0,
            places: vec![
                Figures::of("top", "tick", &pairs, 1.0),
                Figures::of("top", "motion", &Pairs::default(), 1.0),
            ],
            notes: vec!["the handle did not move".to_owned()],
            machine: Machine::read(),
        }
    }

    #[test]
    fn a_known_delay_of_the_sensor_is_left_out_of_the_light_alone() {
        let report = sample();
        let tick = &report.places[0];
        let spread = |it: Option<Spread>| it.map(|it| [it.min, it.median, it.max]);
        assert_eq!(spread(tick.to_light_ms), Some([30.0, 34.0, 34.0]));
        assert_eq!(spread(tick.to_picture_ms), Some([10.0, 12.0, 12.0]));
        assert_eq!(spread(tick.picture_to_light_ms), Some([20.0, 22.0, 22.0]));
        assert_eq!(spread(tick.to_presentation_ms), Some([18.0; 3]));
        assert_eq!(spread(tick.presentation_to_light_ms), Some([12.0; 3]));
        assert_eq!((tick.changes, tick.unseen, tick.crowded), (3, 1, 4));
        assert!(tick.is_few() && tick.is_cut());
        assert_eq!(report.places[1].to_light_ms, None);
    }

    #[test]
    fn the_text_says_what_was_seen_and_what_the_driver_does_not_tell() {
        let text = text(&sample());
        for told in [
            "A tick was seen 34.0 ms after it had begun",
            "Too few motions were seen",
            "60.00 Hz, 16.67 ms a frame",
            "70 by a copy into the window",
            "18.0",
            "note: the handle did not move",
        ] {
            assert!(text.contains(told), "{told} in {text}");
        }
    }
}
