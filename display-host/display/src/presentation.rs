//! Times at which the screen got the window's pictures, if the window system reports them.
//!
//! On X11 the screen begins to show a flipped picture at the reported time. A copied picture is in
//! the window at that time, and a compositor may still show it a frame later. A Wayland compositor
//! reports when the screen began to show the picture, copied or not.

use std::collections::VecDeque;

use figures::{Distribution, PresentationSummary};

use crate::latency::FrameRecord;

/// Largest number of pictures that wait for the report of their time. A driver has at most a few
/// under way.
pub(crate) const WAITING_MAX: usize = 64;
/// Tolerance of the check that a reported time is of this computer's clock, ns: the time lies at
/// most this long before its picture was handed over, and at most this long after now.
const CLOCK_NS: u64 = 60_000_000_000;

/// Way of a picture to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// The screen shows the picture's own memory.
    Flip,
    /// It was copied: on X11 into the window, on Wayland into the screen's picture.
    Copy,
    /// A later picture was shown in its place.
    Skip,
}

/// Interface of the window system that reports the times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The X server's extension Present.
    X11Present,
    /// Wayland's `wp_presentation`.
    WpPresentation,
}

impl Source {
    /// Name in documents.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::X11Present => "x11_present",
            Self::WpPresentation => "wp_presentation",
        }
    }
}

/// Further data of a Wayland compositor about a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScreenTime {
    /// Time between two refreshes of the screen, ns; `None` if the compositor does not know.
    pub refresh_ns: Option<u32>,
    /// True if the screen's hardware measured the time, false if the compositor read a clock.
    pub by_hardware: bool,
}

/// The end of a picture's way to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presented {
    /// Time, `CLOCK_MONOTONIC`, ns; 0 for a skipped picture of a Wayland window.
    pub at_ns: u64,
    /// Its way.
    pub way: Way,
    /// Origin of the time, and the screen's refresh time; `None` on X11.
    pub screen: Option<ScreenTime>,
}

/// Reason for which no times are reported.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Missing {
    /// No window was opened.
    #[default]
    NoWindow,
    /// The X server lacks the extension Present.
    NoExtension,
    /// The Wayland compositor lacks `wp_presentation`.
    NoProtocol,
    /// The window system cannot be asked.
    Refused(String),
    /// No time was reported although pictures were handed over: the driver shows them in another
    /// way.
    Driver,
    /// The Wayland compositor reported nothing although pictures were handed over.
    Compositor,
    /// The Wayland compositor's times are of a clock with this number, which Calot does not know.
    /// `None`: the compositor named no clock.
    UnknownClock(Option<u32>),
    /// The times are of another clock: the window system runs on another computer.
    OtherClock,
}

impl std::fmt::Display for Missing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoWindow => f.write_str("no window was opened"),
            Self::NoExtension => f.write_str(
                "the X server lacks the extension Present (`xdpyinfo -ext all | grep Present`)",
            ),
            Self::NoProtocol => f.write_str(
                "the Wayland compositor lacks wp_presentation (`wayland-info | grep wp_presentation`)",
            ),
            Self::Refused(why) => write!(f, "the window system did not answer: {why}"),
            Self::Driver => f.write_str(
                "the graphics driver does not provide the times: it shows pictures without the X \
                 server's extension Present",
            ),
            Self::Compositor => f.write_str(
                "the Wayland compositor reported nothing about the pictures: the window was hidden, or \
                 open too briefly",
            ),
            Self::UnknownClock(Some(number)) => write!(
                f,
                "the Wayland compositor's times are of clock {number}, which Calot does not know"
            ),
            Self::UnknownClock(None) => {
                f.write_str("the Wayland compositor does not say of which clock its times are")
            }
            Self::OtherClock => f.write_str(
                "the window system's times are of another clock: the window system runs on another \
                 computer",
            ),
        }
    }
}

/// Presentation of a run's pictures.
#[derive(Debug, Clone, Default)]
pub struct Presentation {
    /// Interface that was asked, if a window was opened.
    pub source: Option<Source>,
    /// Reason for which the window system cannot be asked, if it cannot.
    pub refused: Option<Missing>,
    /// Number of pictures handed over.
    pub handed: u64,
    /// Number of pictures that came to the screen by a flip.
    pub flips: u64,
    /// Number of pictures that came to the screen by a copy.
    pub copies: u64,
    /// Number of pictures that did not come to the screen.
    pub skips: u64,
    /// Number of pictures whose time the screen's hardware measured.
    pub by_hardware: u64,
    /// Newest time between two refreshes of the screen, ns.
    pub refresh_ns: Option<u32>,
    /// Time from the sample's arrival to the presentation, for pictures of the newest state.
    pub motion: Distribution,
}

impl Presentation {
    /// Takes the end of a picture's way.
    pub fn note(&mut self, frame: Option<&FrameRecord>, presented: Presented) {
        match presented.way {
            Way::Flip => self.flips += 1,
            Way::Copy => self.copies += 1,
            Way::Skip => self.skips += 1,
        }
        if let Some(screen) = presented.screen {
            self.by_hardware += u64::from(screen.by_hardware);
            self.refresh_ns = screen.refresh_ns.or(self.refresh_ns);
        }
        let live = frame.filter(|it| it.live && it.sample_ns > 0 && presented.way != Way::Skip);
        if let Some(frame) = live {
            self.motion
                .record(presented.at_ns.saturating_sub(frame.sample_ns));
        }
    }

    /// Reason for which no presentation was reported. `None`: presentations were reported.
    #[must_use]
    pub fn missing(&self) -> Option<Missing> {
        let silent = match self.source {
            _ if self.handed == 0 => Missing::NoWindow,
            Some(Source::WpPresentation) => Missing::Compositor,
            _ => Missing::Driver,
        };
        match self.flips + self.copies + self.skips {
            0 => Some(self.refused.clone().unwrap_or(silent)),
            _ => None,
        }
    }

    /// Summary for documents.
    #[must_use]
    pub fn summary(&self) -> PresentationSummary {
        let missing = self.missing();
        let source = self.source.filter(|_| missing.is_none());
        let on_wayland = source == Some(Source::WpPresentation);
        PresentationSummary {
            source: source.map(Source::name),
            // The window system may have stopped answering after its first reports.
            missing: missing.or(self.refused.clone()).map(|it| it.to_string()),
            flips: self.flips,
            copies: self.copies,
            skips: self.skips,
            by_hardware: on_wayland.then_some(self.by_hardware),
            refresh_ns: self.refresh_ns,
        }
    }
}

/// Pictures on their way, in the order of handing over. The drivers of Mesa number the pictures of
/// a swapchain from 1 on, and begin anew in the next swapchain. If no picture has the reported
/// number, the difference from the last reported number decides.
#[derive(Debug)]
pub(crate) struct Order<T> {
    /// Pictures, with the number of their swapchain and their own number in it, from 1 on.
    waiting: VecDeque<(u64, u32, T)>,
    swapchain: u64,
    /// Number of pictures of this swapchain.
    count: u32,
    /// Swapchain and serial number of the last picture that was reported.
    last: Option<(u64, u32)>,
}

impl<T> Default for Order<T> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            swapchain: 0,
            count: 0,
            last: None,
        }
    }
}

impl<T> Order<T> {
    /// From now on pictures are of a new swapchain.
    pub(crate) fn renew(&mut self) {
        self.swapchain += 1;
        self.count = 0;
    }

    /// Notes that a picture was handed over. It may never be reported.
    pub(crate) fn hand(&mut self, picture: T) {
        if self.waiting.len() == WAITING_MAX {
            self.waiting.pop_front();
        }
        self.count = self.count.wrapping_add(1);
        self.waiting
            .push_back((self.swapchain, self.count, picture));
    }

    /// The picture with this serial number, which the window system reports now. Earlier pictures
    /// are forgotten.
    pub(crate) fn take_reported(&mut self, serial: u32) -> Option<T> {
        let exact = self.waiting.iter().position(|it| it.1 == serial);
        let left_out = match self.last {
            _ if exact.is_some() => exact.unwrap_or_default() as u32,
            Some((swapchain, last)) if serial < last => {
                // The driver began to count anew. It reports no more pictures of the old swapchain.
                while self.waiting.front().is_some_and(|it| it.0 <= swapchain) {
                    self.waiting.pop_front();
                }
                0
            }
            Some((_, last)) => (serial - last).saturating_sub(1),
            None => 0,
        };
        for _ in 0..left_out.min(self.waiting.len() as u32) {
            self.waiting.pop_front();
        }
        let (swapchain, _, picture) = self.waiting.pop_front()?;
        self.last = Some((swapchain, serial));
        Some(picture)
    }
}

/// True if a reported time may be one of this computer's clock: it lies between the handing over of
/// its picture and now. The report may be read long after it came.
pub(crate) const fn is_this_clock(at_ns: u64, handed_ns: u64, now_ns: u64) -> bool {
    at_ns.saturating_add(CLOCK_NS) > handed_ns && at_ns < now_ns.saturating_add(CLOCK_NS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(sample_ns: u64, live: bool) -> FrameRecord {
        FrameRecord {
            tick: 1,
            sample_ns,
            state_ns: 0,
            submitted_ns: 0,
            shown_ns: 0,
            live,
            path: None,
        }
    }

    #[test]
    fn reports_go_to_their_pictures_in_order_and_skip_lost_ones() {
        let mut order = Order::default();
        for picture in 'a'..='f' {
            order.hand(picture);
        }
        // The third picture was never reported.
        let reported: Vec<_> = [1, 2, 4, 5]
            .map(|serial| order.take_reported(serial))
            .into();
        assert_eq!(reported, [Some('a'), Some('b'), Some('d'), Some('e')]);
        // The window was resized: the driver counts anew, and 'f' is never reported.
        order.renew();
        for picture in 'x'..='z' {
            order.hand(picture);
        }
        assert_eq!(
            [1, 2].map(|it| order.take_reported(it)),
            [Some('x'), Some('y')]
        );
        assert_eq!([3, 4].map(|it| order.take_reported(it)), [Some('z'), None]);
    }

    #[test]
    fn a_resize_after_one_picture_is_noticed() {
        let mut order = Order::default();
        for picture in ['a', 'b', 'c'] {
            order.hand(picture);
        }
        assert_eq!(order.take_reported(1), Some('a'));
        // 'b' and 'c' are never reported.
        order.renew();
        order.hand('x');
        order.hand('y');
        assert_eq!(
            [1, 2].map(|it| order.take_reported(it)),
            [Some('x'), Some('y')]
        );
    }

    #[test]
    fn a_driver_with_numbers_of_its_own_is_followed() {
        let mut order = Order::default();
        for picture in 'a'..='e' {
            order.hand(picture);
        }
        let reported = [700, 701, 703].map(|serial| order.take_reported(serial));
        assert_eq!(reported, [Some('a'), Some('b'), Some('d')]);
    }

    #[test]
    fn the_memory_is_bounded_if_a_driver_reports_nothing() {
        let mut order = Order::default();
        for picture in 0..100_000 {
            order.hand(picture);
        }
        assert_eq!(order.waiting.len(), WAITING_MAX);
    }

    #[test]
    fn motion_is_measured_only_for_shown_pictures_of_the_newest_state() {
        let mut presentation = Presentation {
            source: Some(Source::X11Present),
            ..Presentation::default()
        };
        let at = |at_ns, way| Presented {
            at_ns,
            way,
            screen: None,
        };
        presentation.note(Some(&frame(1_000_000, true)), at(21_000_000, Way::Flip));
        presentation.note(Some(&frame(1_000_000, false)), at(99_000_000, Way::Copy));
        presentation.note(Some(&frame(1_000_000, true)), at(99_000_000, Way::Skip));
        presentation.note(None, at(99_000_000, Way::Copy));
        assert_eq!(
            (presentation.flips, presentation.copies, presentation.skips),
            (1, 2, 1)
        );
        let motion = presentation.motion.quantiles();
        assert!(motion.count == 1 && motion.max.abs_diff(20_000_000) < 100_000);
        assert_eq!(presentation.missing(), None);
        let summary = presentation.summary();
        assert_eq!((summary.source, summary.copies), (Some("x11_present"), 2));
        assert_eq!((summary.missing, summary.by_hardware), (None, None));
        // Then the server ended.
        presentation.refused = Some(Missing::Refused("gone".into()));
        let summary = presentation.summary();
        assert_eq!(summary.source, Some("x11_present"));
        assert!(summary.missing.is_some_and(|it| it.contains("gone")));
    }

    #[test]
    fn a_compositors_refresh_time_and_clock_are_kept() {
        let mut presentation = Presentation {
            source: Some(Source::WpPresentation),
            ..Presentation::default()
        };
        let screen = |refresh_ns, by_hardware| Presented {
            at_ns: 21_000_000,
            way: Way::Flip,
            screen: Some(ScreenTime {
                refresh_ns,
                by_hardware,
            }),
        };
        presentation.note(None, screen(Some(16_666_666), true));
        presentation.note(None, screen(None, false));
        let summary = presentation.summary();
        assert_eq!(summary.source, Some("wp_presentation"));
        assert_eq!((summary.flips, summary.by_hardware), (2, Some(1)));
        assert_eq!(summary.refresh_ns, Some(16_666_666));
    }

    #[test]
    fn each_reason_says_what_is_missing() {
        let mut presentation = Presentation::default();
        assert_eq!(presentation.missing(), Some(Missing::NoWindow));
        presentation.handed = 3;
        assert_eq!(presentation.missing(), Some(Missing::Driver));
        presentation.source = Some(Source::WpPresentation);
        assert_eq!(presentation.missing(), Some(Missing::Compositor));
        assert_eq!(presentation.summary().source, None);
        let said = |missing: Missing, words: &str| {
            let presentation = Presentation {
                refused: Some(missing),
                handed: 3,
                ..Presentation::default()
            };
            let text = presentation.missing().map(|it| it.to_string());
            assert!(text.is_some_and(|it| it.contains(words)), "{words}");
        };
        said(Missing::NoWindow, "no window was opened");
        said(Missing::NoProtocol, "lacks wp_presentation");
        said(Missing::Compositor, "reported nothing about the pictures");
        said(Missing::UnknownClock(Some(11)), "clock 11, which");
        said(Missing::UnknownClock(None), "of which clock");
        said(Missing::NoExtension, "lacks the extension Present");
        said(Missing::Refused("gone".into()), "did not answer: gone");
        said(Missing::Driver, "driver does not provide the times");
        said(Missing::OtherClock, "runs on another computer");
    }

    #[test]
    fn a_time_of_another_computer_is_noticed() {
        let now_ns = 9_000_000_000_000;
        assert!(is_this_clock(now_ns - 20_000_000, now_ns, now_ns));
        assert!(is_this_clock(now_ns + 20_000_000, now_ns, now_ns));
        assert!(!is_this_clock(1_000_000, now_ns, now_ns));
        assert!(!is_this_clock(now_ns * 2, now_ns, now_ns));
        // The program was paused for five minutes before it read the time.
        let handed_ns = now_ns - 300_000_000_000;
        assert!(is_this_clock(handed_ns + 20_000_000, handed_ns, now_ns));
    }
}
