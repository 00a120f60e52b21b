//! A replay that displays watch; it replaces the controller of a station.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use core::time::Duration;

use bytemuck::Zeroable as _;
use rt_core::port::LineCounters;
use shared_mem::inputs::InputRecord;
use shared_mem::message::{CommandMsg, EventMsg, ReplyMsg, StateFrame, ToolFrame};
use shared_mem::service::{Controller, Station};
use shared_mem::words::EventKind;
use shared_mem::words::Switches;

use super::leaks::{Leaks, puts_back};
use super::player::Player;
use super::{Replay, Replayed};
use crate::error::RtError;
use crate::storage::Storage;
use crate::time_driver::monotonic_ns;
use crate::{frames, inputs};

/// Ticks per frame, as in the controller.
const FRAME_EVERY: u64 = 4;
/// Bit of [`ToolFrame::switches`]: the show is paused.
const PAUSED: u32 = Switches::PAUSED.bits();
/// Longest time between two frames, ns. After it the last frame is sent again, because a display
/// that receives no frame reports its controller as gone.
const STILL_ALIVE_NS: u64 = 100_000_000;
/// Interval at which commands are read while idle.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// Number of ticks between two reads of commands while ticks run without being shown.
const LOOK_EVERY_TICKS: u64 = 16;
/// Number of records that are skipped before commands are read again.
const READ_AT_ONCE: u64 = 4096;

/// Speed and start of a show.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// Speed relative to the session.
    pub speed: f64,
    /// Start time, s; earlier ticks run without being shown.
    pub from_s: f64,
}

/// State of a show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Time in the session, s.
    pub at_s: f64,
    /// Speed relative to the session.
    pub speed: f64,
    /// Moment that the show is seeking, s.
    pub seeks_s: Option<f64>,
    /// Length of the session, s, once its end was reached.
    pub length_s: Option<f64>,
}

/// Shows the ticks from `open` on `station` until `stop` is set. The first frame stands still until
/// `begun` is set. At the end the last frame stands still. Commands of a display pause the show,
/// change its speed, seek any moment, restart it (reset) or end it. `open` is called again after
/// each jump to a checkpoint. `each` sees every tick once, as soon as it has run; `tell` receives
/// the state of the show. The calling thread needs a stack of several megabytes.
///
/// # Errors
/// When the station has a controller, the core refuses the scene, or the session ends before
/// [`Pace::from_s`].
#[expect(
    clippy::too_many_arguments,
    reason = "each is one thing that the caller owns"
)]
pub fn show<I: Iterator<Item = InputRecord>>(
    replay: &Replay,
    station: &Station,
    pace: Pace,
    begun: &AtomicBool,
    stop: &AtomicBool,
    mut open: impl FnMut() -> Option<I>,
    mut each: impl FnMut(&Replayed<'_>),
    mut tell: impl FnMut(Shown),
) -> Result<(), RtError> {
    let mut stage = Stage {
        controller: Controller::open(station)?,
        scene_id: replay.scene_id(),
        start_ns: (pace.from_s * 1e9) as u64,
        speed: pace.speed,
        state: bytemuck::zeroed_box(),
        tools: bytemuck::zeroed_box(),
        next_event: 0,
        paused: false,
        seek_ns: Some((pace.from_s * 1e9) as u64),
        asked_ns: None,
        length_ns: None,
        at_ns: 0,
        anchor: None,
        sent_ns: 0,
        has_shown: false,
        leaks: Leaks::default(),
        shown_tick: 0,
        again_ns: None,
    };
    let mut storage = Storage::new(replay.setup.paper_iterations);
    let (device, parameters) = (
        inputs::capabilities(&replay.setup),
        inputs::parameters(&replay.setup),
    );
    let sim = storage.sim(replay.scene.scene()?, device, parameters);
    let mut player = Player::new(sim);
    let Some(mut ticks) = open() else {
        return Ok(());
    };
    while !stop.load(Relaxed) {
        if let Some(asked_ns) = stage.asked_ns.take() {
            let at_ns = asked_ns.min(stage.length_ns.unwrap_or(asked_ns));
            if let Some(before) = player.go_before(at_ns) {
                let Some(again) = open() else { break };
                ticks = again;
                // Skip the ticks before the checkpoint: the file is read from its start, without
                // simulation.
                let mut left = before;
                while let Some(last) = left.min(READ_AT_ONCE).checked_sub(1) {
                    if stop.load(Relaxed) || ticks.nth(last as usize).is_none() {
                        break;
                    }
                    left -= last + 1;
                    stage.serve(stop);
                    stage.send_again_if_due();
                }
            }
            stage.seek_ns = Some(at_ns);
            stage.anchor = None;
        }
        match ticks.next() {
            Some(record) => player.tick(&record, |tick, passed_ns, is_new| {
                if is_new {
                    each(tick);
                    stage.leaks.keep(tick.view.tick, tick.record, tick.events());
                }
                stage.play(tick, passed_ns, begun, stop, &mut tell);
            }),
            None if !stage.has_shown && stage.seek_ns == Some(stage.start_ns) => {
                return Err(RtError::NothingToShow {
                    from_s: pace.from_s,
                    length_s: player.passed_ns() as f64 / 1e9,
                });
            }
            None => {
                let end_ns = *stage.length_ns.insert(player.passed_ns());
                if stage.seek_ns.is_some() {
                    // The session is shorter than the asked moment, so show its last moment.
                    stage.asked_ns = Some(end_ns);
                    continue;
                }
                stage.serve(stop);
                stage.send_again_if_due();
                tell(stage.shown());
                std::thread::sleep(LOOK_EVERY);
            }
        }
    }
    Ok(())
}

/// A running show: its controller end, its place in the session, and the commands that it received.
struct Stage {
    controller: Controller,
    scene_id: [u8; 16],
    /// Start of the show in the session, also after a restart, ns.
    start_ns: u64,
    speed: f64,
    state: Box<StateFrame>,
    tools: Box<ToolFrame>,
    next_event: u64,
    paused: bool,
    /// Ticks before this time run without being shown.
    seek_ns: Option<u64>,
    /// Moment of the session that a display asked for, ns.
    asked_ns: Option<u64>,
    length_ns: Option<u64>,
    at_ns: u64,
    /// A moment of the session, and the clock's time at which it was shown, ns. Later ticks are
    /// timed from this pair.
    anchor: Option<(u64, u64)>,
    sent_ns: u64,
    has_shown: bool,
    leaks: Leaks,
    /// Tick that is being played or whose frame stands still.
    shown_tick: u64,
    /// Time at which the leaks are sent again after a jump.
    again_ns: Option<u64>,
}

impl Stage {
    /// Shows a tick when its time has come, unless a seek goes beyond it.
    fn play(
        &mut self,
        tick: &Replayed<'_>,
        passed_ns: u64,
        begun: &AtomicBool,
        stop: &AtomicBool,
        tell: &mut dyn FnMut(Shown),
    ) {
        self.at_ns = passed_ns;
        if self.seek_ns.is_some_and(|seek_ns| passed_ns < seek_ns) {
            if tick.view.tick.is_multiple_of(LOOK_EVERY_TICKS) {
                self.serve(stop);
                self.send_again_if_due();
                tell(self.shown());
            }
            return;
        }
        let before = core::mem::replace(&mut self.shown_tick, tick.view.tick);
        if self.seek_ns.take().is_some() {
            self.show(tick);
            // If the jump passes a reset of the organs, displays must receive a reset.
            if self.leaks.were_put_back(before, self.shown_tick) {
                self.tell(EventMsg {
                    kind: EventKind::Reset.number(),
                    organ: u32::MAX,
                    ..EventMsg::zeroed()
                });
            }
            self.tell_leaks();
            // A display that receives these events before it notices the jump drops them with all
            // earlier events. So they are sent once more.
            self.again_ns = Some(monotonic_ns().saturating_add(STILL_ALIVE_NS));
        }
        tell(self.shown());
        loop {
            self.serve(stop);
            if self.asked_ns.is_some() || stop.load(Relaxed) {
                return;
            }
            let now = monotonic_ns();
            if self.paused || !begun.load(Relaxed) {
                // The ticks that follow are delayed by the duration of the pause.
                self.anchor = None;
                self.send_again_if_due();
                std::thread::sleep(LOOK_EVERY);
                continue;
            }
            let (from_ns, shown_ns) = *self.anchor.get_or_insert((passed_ns, now));
            let due_ns = (passed_ns.saturating_sub(from_ns) as f64 / self.speed) as u64;
            let left_ns = shown_ns.saturating_add(due_ns).saturating_sub(now);
            if left_ns == 0 {
                break;
            }
            std::thread::sleep(LOOK_EVERY.min(Duration::from_nanos(left_ns.max(100_000))));
        }
        self.tell_again_if_due();
        if puts_back(tick.record) {
            self.tell_leaks();
        }
        for event in tick.view.events {
            let event = frames::event(event, self.next_event, tick.view.tick, monotonic_ns());
            self.next_event += 1;
            let _ = self.controller.events.send_copy(event);
        }
        if tick.view.tick.is_multiple_of(FRAME_EVERY) {
            self.show(tick);
        }
    }

    /// Sends the state of all leaks at this moment. Closed leaks are sent too, because a new
    /// display first receives earlier events, in which they may be open.
    fn tell_leaks(&mut self) {
        for event in self.leaks.at(self.shown_tick) {
            self.tell(event);
        }
    }

    /// Sends an event with the number of the shown tick.
    fn tell(&mut self, event: EventMsg) {
        let event = EventMsg {
            sequence: self.next_event,
            tick: self.shown_tick,
            at_ns: monotonic_ns(),
            ..event
        };
        self.next_event += 1;
        let _ = self.controller.events.send_copy(event);
    }

    fn tell_again_if_due(&mut self) {
        if self.again_ns.is_some_and(|at| monotonic_ns() >= at) {
            self.again_ns = None;
            self.tell_leaks();
        }
    }

    fn show(&mut self, tick: &Replayed<'_>) {
        let now = monotonic_ns();
        let lines = [Some(LineCounters::default()); 3];
        frames::fill_state(&mut self.state, tick.view, self.scene_id, now);
        frames::fill_tools(&mut self.tools, tick.view, lines, self.scene_id, now);
        self.has_shown = true;
        self.send();
    }

    /// Sends the frame that stands still again, for displays that join or wait for a frame.
    fn send_again_if_due(&mut self) {
        let now = monotonic_ns();
        if self.has_shown && now.saturating_sub(self.sent_ns) > STILL_ALIVE_NS {
            (self.state.at_ns, self.tools.at_ns) = (now, now);
            self.send();
        }
        self.tell_again_if_due();
    }

    fn send(&mut self) {
        self.sent_ns = monotonic_ns();
        let paused = u32::from(self.paused) * PAUSED;
        self.tools.switches = self.tools.switches & !PAUSED | paused;
        // A frame that cannot be sent is dropped. The next frame replaces it.
        let _ = self.controller.state.send_copy(*self.state);
        let _ = self.controller.tools.send_copy(*self.tools);
        self.controller.greet();
    }

    fn shown(&self) -> Shown {
        let seconds = |ns: u64| ns as f64 / 1e9;
        Shown {
            at_s: seconds(self.at_ns),
            speed: self.speed,
            seeks_s: self.seek_ns.map(seconds),
            length_s: self.length_ns.map(seconds),
        }
    }

    fn serve(&mut self, stop: &AtomicBool) {
        while let Some(request) = self.controller.next_request() {
            let CommandMsg { kind, argument } = request.command();
            let mut outcome = ReplyMsg::DONE;
            match kind {
                CommandMsg::PAUSE => self.paused = argument != 0,
                CommandMsg::RESET => self.asked_ns = Some(self.start_ns),
                CommandMsg::SEEK => self.asked_ns = Some(u64::from(argument) * 1_000_000),
                CommandMsg::SPEED if (10..=100_000).contains(&argument) => {
                    self.speed = f64::from(argument) / 1e3;
                    self.anchor = None;
                }
                CommandMsg::SPEED => outcome = ReplyMsg::OUT_OF_RANGE,
                CommandMsg::STOP => stop.store(true, Relaxed),
                // A recorded run's force and instrument cannot change.
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
