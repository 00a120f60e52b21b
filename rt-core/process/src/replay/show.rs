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
///
/// # Errors
/// When somebody controls the station, or the core refuses the scene.
pub fn show<I: Iterator<Item = InputRecord>>(
    replay: &Replay,
    station: &Station,
    pace: Pace,
    begun: &AtomicBool,
    stop: &AtomicBool,
    mut open: impl FnMut() -> Option<I>,
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
        first_ns: None,
        start_ns: 0,
        sent_ns: 0,
    };
    while stage.again && !stop.load(Relaxed) {
        let Some(ticks) = open() else { break };
        stage.again = false;
        stage.first_ns = None;
        replay.run(ticks, |tick| stage.play(tick, begun, stop))?;
        while !stage.again && !stop.load(Relaxed) {
            stage.serve(stop);
            stage.send_again_if_due();
            std::thread::sleep(LOOK_EVERY);
        }
    }
    Ok(())
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
    /// Time of the session's first tick.
    first_ns: Option<u64>,
    /// When the first tick that is shown was, or would have been without pauses.
    start_ns: u64,
    sent_ns: u64,
}

impl Stage {
    /// Shows a tick when its time has come; whether to go on.
    fn play(&mut self, tick: &Replayed<'_>, begun: &AtomicBool, stop: &AtomicBool) -> bool {
        let now_ns = tick.record.now_ns;
        let first_ns = *self.first_ns.get_or_insert(now_ns);
        let from_ns = (self.pace.from_s * 1e9) as u64;
        let Some(shown_ns) = now_ns.saturating_sub(first_ns).checked_sub(from_ns) else {
            return !stop.load(Relaxed);
        };
        let due_ns = (shown_ns as f64 / self.pace.speed) as u64;
        if self.start_ns == 0 {
            self.show(tick);
            self.start_ns = monotonic_ns().saturating_sub(due_ns);
        }
        loop {
            self.serve(stop);
            if self.again || stop.load(Relaxed) {
                self.start_ns = 0;
                return false;
            }
            let now = monotonic_ns();
            if self.paused || !begun.load(Relaxed) {
                // As much later as it stands.
                self.start_ns = now.saturating_sub(due_ns);
                self.send_again_if_due();
            } else if now >= self.start_ns + due_ns {
                break;
            }
            let left = (self.start_ns + due_ns).saturating_sub(now);
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
