//! A replay that displays watch: it takes the controller's place at a station.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use core::time::Duration;

use rt_core::port::LineCounters;
use shared_mem::inputs::InputRecord;
use shared_mem::message::{CommandMsg, ReplyMsg, StateFrame, ToolFrame};
use shared_mem::service::{Controller, Station};

use super::{Replay, Replayed};
use crate::error::RtError;
use crate::frames;
use crate::time_driver::monotonic_ns;

/// A frame for so many ticks, as the controller does.
const FRAME_EVERY: u64 = 4;
/// Bit of [`ToolFrame::switches`]: it stands still.
const PAUSED: u32 = 8;
/// A display that sees nothing for longer takes its controller for gone.
const STILL_ALIVE_NS: u64 = 100_000_000;
/// Longest time between two ticks: what a damaged session says may be hundreds of years.
const STEP_MAX_NS: u64 = 1_000_000_000;
/// How often commands are looked for while nothing else is to be done.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// How a session is shown.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// So many times as fast as it was.
    pub speed: f64,
    /// What comes before is run, but not shown, s.
    pub from_s: f64,
}

/// Shows the ticks that `open` gives on `station`, from when `begun` is set (until then the first stands
/// still) until `stop` is set; the last one stands. A display's commands pause it, or begin anew (reset).
/// `each` sees all that are run, as soon as they are.
///
/// # Errors
/// When somebody controls the station, the core refuses the scene, or no tick is as late as
/// [`Pace::from_s`].
pub fn show<I: Iterator<Item = InputRecord>>(
    replay: &Replay,
    station: &Station,
    pace: Pace,
    begun: &AtomicBool,
    stop: &AtomicBool,
    mut open: impl FnMut() -> Option<I>,
    mut each: impl FnMut(&Replayed<'_>),
) -> Result<(), RtError> {
    let mut stage = Stage {
        controller: Controller::open(station)?,
        scene_id: replay.scene_id(),
        pace,
        state: bytemuck::zeroed_box(),
        tools: bytemuck::zeroed_box(),
        next_event: 0,
        paused: false,
        again: true,
        time: SessionTime::default(),
        start_ns: None,
        sent_ns: 0,
    };
    while stage.again && !stop.load(Relaxed) {
        let Some(ticks) = open() else { break };
        stage.again = false;
        stage.time = SessionTime::default();
        stage.start_ns = None;
        replay.run(ticks, |tick| {
            each(tick);
            stage.play(tick, begun, stop)
        })?;
        if stage.start_ns.is_none() && !stage.again && !stop.load(Relaxed) {
            return Err(RtError::NothingToShow {
                from_s: pace.from_s,
                length_s: stage.time.passed_ns as f64 / 1e9,
            });
        }
        while !stage.again && !stop.load(Relaxed) {
            stage.serve(stop);
            stage.send_again_if_due();
            std::thread::sleep(LOOK_EVERY);
        }
    }
    Ok(())
}

/// Time that has passed in a session.
#[derive(Debug, Default)]
struct SessionTime {
    newest_ns: Option<u64>,
    passed_ns: u64,
}

impl SessionTime {
    /// Goes on to a tick's time.
    fn pass(&mut self, now_ns: u64) -> u64 {
        let before_ns = self.newest_ns.replace(now_ns).unwrap_or(now_ns);
        let step_ns = now_ns.saturating_sub(before_ns).min(STEP_MAX_NS);
        self.passed_ns = self.passed_ns.saturating_add(step_ns);
        self.passed_ns
    }
}

struct Stage {
    controller: Controller,
    scene_id: [u8; 16],
    pace: Pace,
    state: Box<StateFrame>,
    tools: Box<ToolFrame>,
    next_event: u64,
    paused: bool,
    /// From the beginning, as a display asked.
    again: bool,
    time: SessionTime,
    /// When the first tick that is shown was, or would have been without pauses.
    start_ns: Option<u64>,
    sent_ns: u64,
}

impl Stage {
    /// Shows a tick when its time has come; whether to go on.
    fn play(&mut self, tick: &Replayed<'_>, begun: &AtomicBool, stop: &AtomicBool) -> bool {
        let passed_ns = self.time.pass(tick.record.now_ns);
        let from_ns = (self.pace.from_s * 1e9) as u64;
        let Some(shown_ns) = passed_ns.checked_sub(from_ns) else {
            return !stop.load(Relaxed);
        };
        let due_ns = (shown_ns as f64 / self.pace.speed) as u64;
        if self.start_ns.is_none() {
            self.show(tick);
        }
        let mut start_ns = *self
            .start_ns
            .get_or_insert_with(|| monotonic_ns().saturating_sub(due_ns));
        loop {
            self.serve(stop);
            if self.again || stop.load(Relaxed) {
                return false;
            }
            let now = monotonic_ns();
            let at_ns = start_ns.saturating_add(due_ns);
            if self.paused || !begun.load(Relaxed) {
                // As much later as it stands.
                start_ns = now.saturating_sub(due_ns);
                self.start_ns = Some(start_ns);
                self.send_again_if_due();
            } else if now >= at_ns {
                break;
            }
            let left = at_ns.saturating_sub(now);
            std::thread::sleep(LOOK_EVERY.min(Duration::from_nanos(left.max(100_000))));
        }
        for event in tick.view.events {
            let event = frames::event(event, self.next_event, tick.view.tick, monotonic_ns());
            self.next_event += 1;
            let _ = self.controller.events.send_copy(event);
        }
        if tick.view.tick.is_multiple_of(FRAME_EVERY) {
            self.show(tick);
        }
        true
    }

    fn show(&mut self, tick: &Replayed<'_>) {
        let now = monotonic_ns();
        let lines = [Some(LineCounters::default()); 3];
        frames::fill_state(&mut self.state, tick.view, self.scene_id, now);
        frames::fill_tools(&mut self.tools, tick.view, lines, self.scene_id, now);
        self.send();
    }

    /// What stands still is shown again, for whoever joins and whoever waits for it.
    fn send_again_if_due(&mut self) {
        let now = monotonic_ns();
        if now.saturating_sub(self.sent_ns) > STILL_ALIVE_NS {
            (self.state.at_ns, self.tools.at_ns) = (now, now);
            let paused = u32::from(self.paused) * PAUSED;
            self.tools.switches = self.tools.switches & !PAUSED | paused;
            self.send();
        }
    }

    fn send(&mut self) {
        self.sent_ns = monotonic_ns();
        // Each fails only when the service is gone.
        let _ = self.controller.state.send_copy(*self.state);
        let _ = self.controller.tools.send_copy(*self.tools);
    }

    fn serve(&mut self, stop: &AtomicBool) {
        while let Some(request) = self.controller.next_request() {
            let CommandMsg { kind, argument } = request.command();
            let mut outcome = ReplyMsg::DONE;
            match kind {
                CommandMsg::PAUSE => self.paused = argument != 0,
                CommandMsg::RESET => self.again = true,
                CommandMsg::STOP => stop.store(true, Relaxed),
                // Force and instrument are as they were.
                _ => outcome = ReplyMsg::UNKNOWN,
            }
            request.reply(ReplyMsg {
                outcome,
                reserved: 0,
                tick: self.state.tick,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on_by_a_second_at_most_and_never_back() {
        let mut time = SessionTime::default();
        let at = [u64::MAX - 5, 7, 9, u64::MAX, 3, 4].map(|now_ns| time.pass(now_ns));
        let second = STEP_MAX_NS;
        assert_eq!(at, [0, 0, 2, second + 2, second + 2, second + 3]);
    }
}
