//! Times at which the screen got the window's pictures, if the window system tells them.
//!
//! In a flip, the screen begins to show the picture at the time that is told. In a copy, the server
//! copies the picture into the window at that time. A compositor may still show it a frame later.

use std::collections::VecDeque;

use figures::{Distribution, PresentationSummary};

use crate::latency::FrameRecord;

/// Largest number of pictures whose times are not told yet. A driver has at most a few under way.
const WAITING_MAX: usize = 64;
/// Largest difference of a told time from the present, ns. A time with a larger difference comes
/// from another computer's clock.
const CLOCK_NS: u64 = 60_000_000_000;

/// Way of a picture to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// The screen shows the picture's own memory.
    Flip,
    /// It was copied into the window.
    Copy,
    /// A later picture was shown in its place.
    Skip,
}

/// The end of a picture's way to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presented {
    /// Time, `CLOCK_MONOTONIC`, ns.
    pub at_ns: u64,
    /// Its way.
    pub way: Way,
}

/// Reason for which nothing is told.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Missing {
    /// No window was opened.
    #[default]
    NoWindow,
    /// The window is on a Wayland compositor.
    Wayland,
    /// The X server lacks the extension Present.
    NoExtension,
    /// The X server cannot be asked.
    Refused(String),
    /// Nothing was told although pictures were handed over: the driver shows them in another way.
    Driver,
    /// The times are of another clock: the X server runs on another computer.
    OtherClock,
}

impl std::fmt::Display for Missing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoWindow => f.write_str("no window was opened"),
            Self::Wayland => f.write_str(
                "the window is on Wayland, whose wp_presentation is not read: start with \
                 WAYLAND_DISPLAY unset to use X11 (XWayland)",
            ),
            Self::NoExtension => f.write_str(
                "the X server lacks the extension Present (`xdpyinfo -ext all | grep Present`)",
            ),
            Self::Refused(why) => write!(f, "the X server did not answer: {why}"),
            Self::Driver => f.write_str(
                "the graphics driver does not provide them: it shows pictures without the X \
                 server's extension Present",
            ),
            Self::OtherClock => f.write_str(
                "the X server's times are of another clock: it runs on another computer",
            ),
        }
    }
}

/// Presentation of a run's pictures.
#[derive(Debug, Clone, Default)]
pub struct Presentation {
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
        let live = frame.filter(|it| it.live && it.sample_ns > 0 && presented.way != Way::Skip);
        if let Some(frame) = live {
            self.motion
                .record(presented.at_ns.saturating_sub(frame.sample_ns));
        }
    }

    /// Reason for which nothing was told. `None`: presentations were told.
    #[must_use]
    pub fn missing(&self) -> Option<Missing> {
        match self.flips + self.copies + self.skips {
            0 if self.handed > 0 => Some(self.refused.clone().unwrap_or(Missing::Driver)),
            0 => Some(self.refused.clone().unwrap_or_default()),
            _ => None,
        }
    }

    /// Summary for documents.
    #[must_use]
    pub fn summary(&self) -> PresentationSummary {
        let missing = self.missing();
        PresentationSummary {
            source: missing.is_none().then_some("x11_present"),
            missing: missing.map(|it| it.to_string()),
            flips: self.flips,
            copies: self.copies,
            skips: self.skips,
        }
    }
}

/// Pictures on their way, in the order of handing over. The driver numbers the pictures of a
/// swapchain one after the other, and begins anew in the next swapchain.
#[derive(Debug)]
pub(crate) struct Order<T> {
    /// Pictures with the number of their swapchain.
    waiting: VecDeque<(u64, T)>,
    swapchain: u64,
    /// Swapchain and serial number of the last picture that was told.
    last: Option<(u64, u32)>,
}

impl<T> Default for Order<T> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            swapchain: 0,
            last: None,
        }
    }
}

impl<T> Order<T> {
    /// From now on pictures are of a new swapchain.
    pub(crate) fn renew(&mut self) {
        self.swapchain += 1;
    }

    /// Notes that a picture was handed over. Nothing may ever be told of it.
    pub(crate) fn hand(&mut self, picture: T) {
        if self.waiting.len() == WAITING_MAX {
            self.waiting.pop_front();
        }
        self.waiting.push_back((self.swapchain, picture));
    }

    /// The picture with this serial number, which is told now. Earlier ones are forgotten.
    pub(crate) fn told(&mut self, serial: u32) -> Option<T> {
        let left_out = match self.last {
            Some((swapchain, last)) if serial < last => {
                // The driver began to count anew: nothing more comes of the old swapchain.
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
        let (swapchain, picture) = self.waiting.pop_front()?;
        self.last = Some((swapchain, serial));
        Some(picture)
    }
}

/// True if a told time may be one of this computer's clock.
pub(crate) const fn is_this_clock(at_ns: u64, now_ns: u64) -> bool {
    at_ns.abs_diff(now_ns) < CLOCK_NS
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
    fn pictures_are_told_in_their_order_and_lost_ones_are_left_out() {
        let mut order = Order::default();
        for picture in 'a'..='f' {
            order.hand(picture);
        }
        // The third was never told.
        let told: Vec<_> = [1, 2, 4, 5].map(|serial| order.told(serial)).into();
        assert_eq!(told, [Some('a'), Some('b'), Some('d'), Some('e')]);
        // The window was resized: the driver counts anew, and 'f' is never told.
        order.renew();
        for picture in 'x'..='z' {
            order.hand(picture);
        }
        assert_eq!([1, 2].map(|it| order.told(it)), [Some('x'), Some('y')]);
        assert_eq!([3, 4].map(|it| order.told(it)), [Some('z'), None]);
    }

    #[test]
    fn a_driver_that_tells_nothing_takes_no_memory() {
        let mut order = Order::default();
        for picture in 0..100_000 {
            order.hand(picture);
        }
        assert_eq!(order.waiting.len(), WAITING_MAX);
    }

    #[test]
    fn only_pictures_of_the_newest_state_that_were_shown_have_a_motion() {
        let mut told = Presentation::default();
        let at = |at_ns, way| Presented { at_ns, way };
        told.note(Some(&frame(1_000_000, true)), at(21_000_000, Way::Flip));
        told.note(Some(&frame(1_000_000, false)), at(99_000_000, Way::Copy));
        told.note(Some(&frame(1_000_000, true)), at(99_000_000, Way::Skip));
        told.note(None, at(99_000_000, Way::Copy));
        assert_eq!((told.flips, told.copies, told.skips), (1, 2, 1));
        let motion = told.motion.quantiles();
        assert!(motion.count == 1 && motion.max.abs_diff(20_000_000) < 100_000);
        assert_eq!(told.missing(), None);
        let summary = told.summary();
        assert_eq!((summary.source, summary.copies), (Some("x11_present"), 2));
    }

    #[test]
    fn each_reason_says_what_is_missing() {
        let mut told = Presentation::default();
        assert_eq!(told.missing(), Some(Missing::NoWindow));
        told.handed = 3;
        assert_eq!(told.missing(), Some(Missing::Driver));
        let said = |missing: Missing, words: &str| {
            let told = Presentation {
                refused: Some(missing),
                handed: 3,
                ..Presentation::default()
            };
            let text = told.missing().map(|it| it.to_string());
            assert!(text.is_some_and(|it| it.contains(words)), "{words}");
        };
        said(Missing::NoWindow, "no window was opened");
        said(Missing::Wayland, "wp_presentation is not read");
        said(Missing::NoExtension, "lacks the extension Present");
        said(Missing::Refused("gone".into()), "did not answer: gone");
        said(Missing::Driver, "driver does not provide them");
        said(Missing::OtherClock, "runs on another computer");
    }

    #[test]
    fn a_time_of_another_computer_is_noticed() {
        let now_ns = 9_000_000_000_000;
        assert!(is_this_clock(now_ns - 20_000_000, now_ns));
        assert!(is_this_clock(now_ns + 20_000_000, now_ns));
        assert!(!is_this_clock(1_000_000, now_ns));
    }
}
