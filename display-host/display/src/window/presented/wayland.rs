//! Asks the Wayland compositor when it presents the window's pictures (`wp_presentation`).
//!
//! A request concerns the picture that the driver hands over next. The events have a queue of their
//! own. winit and the driver read the connection, and this module takes only the events that they
//! have read. Each event carries its time, so it may be taken late.

use std::collections::VecDeque;

use rustix::time::{ClockId, clock_gettime};
use wayland_client::globals::{GlobalListContents, registry_queue_init};
use wayland_client::protocol::wl_registry::{self, WlRegistry};
use wayland_client::{Connection, Dispatch, EventQueue, QueueHandle, WEnum};
use wayland_protocols::wp::presentation_time::client::wp_presentation::{self, WpPresentation};
use wayland_protocols::wp::presentation_time::client::wp_presentation_feedback::{
    self, Kind, WpPresentationFeedback,
};

use super::foreign::Objects;
use crate::latency::now_ns;
use crate::presentation::{Missing, Presented, ScreenTime, WAITING_MAX, Way, is_this_clock};

/// A window's compositor, and the pictures on their way. `T` holds the data that are kept of a
/// picture. The fields are dropped in this order: the window's objects go last.
pub(super) struct Compositor<T> {
    presentation: WpPresentation,
    queue: EventQueue<Reports>,
    reports: Reports,
    clock: ClockId,
    /// Number of the last picture for which a report was requested.
    asked: u64,
    /// Pictures that were not reported yet, with their numbers.
    waiting: VecDeque<(u64, T)>,
    window: Objects,
}

/// Events of the compositor.
#[derive(Default)]
struct Reports {
    /// Number of the clock of all times.
    clock: Option<u32>,
    /// Numbers of pictures, and their ends.
    ends: Vec<(u64, End)>,
}

/// End of a picture's way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// It was presented, at this time of the compositor's clock.
    Shown {
        at_ns: u64,
        way: Way,
        screen: ScreenTime,
    },
    /// The user never saw it.
    Discarded,
}

impl<T> Compositor<T> {
    /// Connects to the compositor of a window.
    pub(super) fn of(window: Objects) -> Result<Self, Missing> {
        let refused = |error: &dyn std::fmt::Display| Missing::Refused(error.to_string());
        let begun = registry_queue_init::<Reports>(&window.connection);
        let (globals, mut queue) = begun.map_err(|error| refused(&error))?;
        let presentation: Result<WpPresentation, _> = globals.bind(&queue.handle(), 1..=2, ());
        let presentation = presentation.map_err(|_| Missing::NoProtocol)?;
        let mut reports = Reports::default();
        queue
            .roundtrip(&mut reports)
            .map_err(|error| refused(&error))?;
        let clock = reports.clock.ok_or(Missing::UnknownClock(None))?;
        Ok(Self {
            presentation,
            queue,
            reports,
            clock: named(clock).ok_or(Missing::UnknownClock(Some(clock)))?,
            asked: 0,
            waiting: VecDeque::new(),
            window,
        })
    }

    /// Requests a report about the picture that is handed over next.
    pub(super) fn ask(&mut self) {
        self.asked += 1;
        let (surface, handle) = (&self.window.surface, self.queue.handle());
        self.presentation.feedback(surface, &handle, self.asked);
    }

    /// Notes that the picture of the last request was handed over.
    pub(super) fn hand(&mut self, picture: T) {
        // The compositor reports nothing about the pictures of a hidden window.
        if self.waiting.len() == WAITING_MAX {
            self.waiting.pop_front();
        }
        self.waiting.push_back((self.asked, picture));
    }

    /// Calls `each` for each picture that the compositor reported since the last call.
    pub(super) fn take(
        &mut self,
        handed_ns: impl Fn(&T) -> u64,
        mut each: impl FnMut(T, Presented),
    ) -> Result<(), Missing> {
        let taken = self.queue.dispatch_pending(&mut self.reports);
        taken.map_err(|error| Missing::Refused(error.to_string()))?;
        for (number, end) in self.reports.ends.drain(..) {
            let at = self.waiting.iter().position(|it| it.0 == number);
            let Some((_, picture)) = at.and_then(|at| self.waiting.remove(at)) else {
                continue;
            };
            let presented = presented(end, self.clock);
            let at_ns = presented.at_ns;
            if presented.way != Way::Skip && !is_this_clock(at_ns, handed_ns(&picture), now_ns()) {
                return Err(Missing::OtherClock);
            }
            each(picture, presented);
        }
        Ok(())
    }
}

/// The end of a picture's way, with its time on the controller's clock.
fn presented(end: End, clock: ClockId) -> Presented {
    match end {
        End::Shown { at_ns, way, screen } => Presented {
            at_ns: monotonic_ns(clock, at_ns),
            way,
            screen: Some(screen),
        },
        End::Discarded => Presented {
            at_ns: 0,
            way: Way::Skip,
            screen: None,
        },
    }
}

/// The clock of this number, if it measures the time of day or the time since the start of the
/// computer. `None` for any other, such as a clock of CPU time.
fn named(number: u32) -> Option<ClockId> {
    let known = [
        ClockId::Realtime,
        ClockId::RealtimeCoarse,
        ClockId::Monotonic,
        ClockId::MonotonicCoarse,
        ClockId::MonotonicRaw,
        ClockId::Boottime,
    ];
    known.into_iter().find(|&clock| clock as u32 == number)
}

/// Converts a recent time of this clock to `CLOCK_MONOTONIC`, ns.
fn monotonic_ns(clock: ClockId, at_ns: u64) -> u64 {
    // A coarse clock has the time that the fine clock had at the last timer interrupt.
    if matches!(clock, ClockId::Monotonic | ClockId::MonotonicCoarse) {
        return at_ns;
    }
    let read = match clock {
        ClockId::RealtimeCoarse => ClockId::Realtime,
        clock => clock,
    };
    let before_ns = now_ns();
    let theirs = clock_gettime(read);
    let now_ns = before_ns.midpoint(now_ns());
    let theirs_ns = theirs.tv_sec as u64 * 1_000_000_000 + theirs.tv_nsec as u64;
    // The difference may wrap below zero; the sum wraps back.
    now_ns.wrapping_add(at_ns.wrapping_sub(theirs_ns))
}

impl Dispatch<WlRegistry, GlobalListContents> for Reports {
    fn event(
        _: &mut Self,
        _: &WlRegistry,
        _: wl_registry::Event,
        _: &GlobalListContents,
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
    }
}

impl Dispatch<WpPresentation, ()> for Reports {
    fn event(
        reports: &mut Self,
        _: &WpPresentation,
        event: wp_presentation::Event,
        (): &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let wp_presentation::Event::ClockId { clk_id } = event {
            reports.clock = Some(clk_id);
        }
    }
}

impl Dispatch<WpPresentationFeedback, u64> for Reports {
    fn event(
        reports: &mut Self,
        _: &WpPresentationFeedback,
        event: wp_presentation_feedback::Event,
        number: &u64,
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let Some(end) = end(&event) {
            reports.ends.push((*number, end));
        }
    }
}

/// The end of a picture's way that an event reports.
fn end(event: &wp_presentation_feedback::Event) -> Option<End> {
    use wp_presentation_feedback::Event;
    match *event {
        Event::Presented {
            tv_sec_hi,
            tv_sec_lo,
            tv_nsec,
            refresh,
            flags,
            ..
        } => {
            let seconds = u64::from(tv_sec_hi) << 32 | u64::from(tv_sec_lo);
            let kind = match flags {
                WEnum::Value(kind) => kind,
                WEnum::Unknown(bits) => Kind::from_bits_truncate(bits),
            };
            Some(End::Shown {
                at_ns: seconds.saturating_mul(1_000_000_000) + u64::from(tv_nsec),
                way: match kind.contains(Kind::ZeroCopy) {
                    true => Way::Flip,
                    false => Way::Copy,
                },
                screen: ScreenTime {
                    refresh_ns: (refresh > 0).then_some(refresh),
                    by_hardware: kind.contains(Kind::HwClock),
                },
            })
        }
        Event::Discarded => Some(End::Discarded),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end_of(at: [u32; 3], refresh: u32, flags: WEnum<Kind>) -> Option<End> {
        let [tv_sec_hi, tv_sec_lo, tv_nsec] = at;
        end(&wp_presentation_feedback::Event::Presented {
            tv_sec_hi,
            tv_sec_lo,
            tv_nsec,
            refresh,
            seq_hi: 0,
            seq_lo: 0,
            flags,
        })
    }

    #[test]
    fn an_event_has_time_way_refresh_time_and_clock() {
        let shown = |at_ns, way, refresh_ns, by_hardware| {
            let screen = ScreenTime {
                refresh_ns,
                by_hardware,
            };
            Some(End::Shown { at_ns, way, screen })
        };
        let plain = end_of([0, 3, 500], 16_666_666, WEnum::Value(Kind::empty()));
        let composed = shown(3_000_000_500, Way::Copy, Some(16_666_666), false);
        assert_eq!(plain, composed);
        let direct = Kind::Vsync | Kind::HwClock | Kind::HwCompletion | Kind::ZeroCopy;
        let far = end_of([1, 0, 0], 0, WEnum::Value(direct));
        assert_eq!(far, shown((1 << 32) * 1_000_000_000, Way::Flip, None, true));
        // A bit that this program does not know hides none of the others.
        let newer = end_of([0, 0, 1], 0, WEnum::Unknown(0x102));
        assert_eq!(newer, shown(1, Way::Copy, None, true));
        let discarded = end(&wp_presentation_feedback::Event::Discarded);
        assert_eq!(discarded, Some(End::Discarded));
        assert_eq!(presented(End::Discarded, ClockId::Monotonic).way, Way::Skip);
    }

    #[test]
    fn times_of_other_clocks_become_times_of_this_one() {
        let read_ns = |clock| {
            let time = clock_gettime(clock);
            time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
        };
        for clock in [
            ClockId::Realtime,
            ClockId::Monotonic,
            ClockId::MonotonicRaw,
            ClockId::Boottime,
        ] {
            let before_ns = now_ns();
            let at_ns = monotonic_ns(clock, read_ns(clock));
            let after_ns = now_ns();
            // A pause between two readings shifts the outcome by up to half of the pause.
            let pause_ns = after_ns - before_ns;
            assert!(at_ns + pause_ns >= before_ns, "{clock:?}");
            assert!(at_ns <= after_ns + pause_ns, "{clock:?}");
        }
    }

    #[test]
    fn clocks_are_known_by_the_kernels_numbers() {
        assert_eq!(named(1), Some(ClockId::Monotonic));
        assert_eq!(named(4), Some(ClockId::MonotonicRaw));
        assert_eq!(named(0), Some(ClockId::Realtime));
        // The time that this process has used, and no clock at all.
        assert_eq!((named(2), named(77)), (None, None));
    }
}
