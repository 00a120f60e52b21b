//! The publishing thread. It owns every iceoryx2 object, sends the tick's frames and passes
//! commands to the tick. It sleeps until late in each period, when the tick should be done.

use core::mem::MaybeUninit;
use core::ptr::NonNull;
use core::sync::atomic::Ordering::{Acquire, Relaxed};
use std::collections::VecDeque;

use bytemuck::{Pod, Zeroable};
use heapless::spsc::{Consumer, Producer};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{ZeroCopySend, ipc};
use iceoryx2::sample_mut_uninit::SampleMutUninit;
use rt_core::sim::{Command, Complication, Task};
use shared_mem::inputs::{INPUT_BATCH, InputBatch, InputRecord};
use shared_mem::message::{
    CommandMsg, EventMsg, ReplyMsg, StateFrame, TIMING_BATCH, TickRecord, TimingBatch, ToolFrame,
};
use shared_mem::service::{Controller, Request};

use crate::handover::{Lender, SenderEnds};
use crate::inputs::instrument;
use crate::shared::Shared;
use crate::summary::Ended;
use crate::time_driver::{monotonic_ns, sleep_until};

/// Size of the queue for events. A queue of size `N` holds `N − 1` entries: here 1024, the most
/// events of 32 ticks.
pub(crate) const EVENT_QUEUE: usize = 1025;
/// Size of the queue for timing records, and of that for inputs: 1024 ticks, about a second.
pub(crate) const RECORD_QUEUE: usize = 1025;
/// Size of the queue for commands: it holds eight. The tick takes at most one in each period.
pub(crate) const COMMAND_QUEUE: usize = 9;
/// Interval at which the remains of hosts that died are cleared, ns.
const FORGET_DEAD_NS: u64 = 1_000_000_000;

/// The publishing thread's ends of all queues.
pub(crate) struct Ends {
    pub(crate) state: SenderEnds<StateFrame>,
    pub(crate) tools: SenderEnds<ToolFrame>,
    pub(crate) events: Consumer<'static, EventMsg>,
    pub(crate) records: Consumer<'static, TickRecord>,
    pub(crate) inputs: Consumer<'static, InputRecord>,
    pub(crate) commands: Producer<'static, Command>,
    /// Tick that took each command, in the order of the commands.
    pub(crate) accepted: Consumer<'static, u64>,
}

/// Publishes until the tick's thread has ended, then sends what is left in the queues.
pub(crate) fn publish(controller: &Controller, ends: Ends, shared: &Shared, period_ns: u64) {
    let mut state = ends.state.lend(Samples(&controller.state));
    let mut tools = ends.tools.lend(Samples(&controller.tools));
    let mut events = ends.events;
    let mut timing = Timing::new(ends.records);
    let mut inputs = Inputs::new(ends.inputs);
    let mut command_server = CommandServer {
        commands: ends.commands,
        accepted: ends.accepted,
        waiting: VecDeque::with_capacity(COMMAND_QUEUE),
    };
    let mut forget_at_ns = monotonic_ns() + FORGET_DEAD_NS;
    loop {
        // The flag is read before the queues. If the tick has ended, this round sends all that the
        // tick left in them.
        let last_round = shared.tick_ended.load(Acquire);
        state.send_filled();
        tools.send_filled();
        while let Some(event) = events.dequeue() {
            // An event that cannot be sent is dropped. Readers see the gap in the numbers.
            let _ = controller.events.send_copy(event);
        }
        controller.greet();
        timing.send_full(controller, shared);
        inputs.send_full(controller, shared);
        command_server.serve(controller, shared);
        if last_round {
            break;
        }
        if monotonic_ns() > forget_at_ns {
            controller.forget_dead();
            forget_at_ns = monotonic_ns() + FORGET_DEAD_NS;
        }
        sleep_until(next_round_ns(shared, period_ns), 0);
    }
    timing.send_rest(controller, shared);
    inputs.send_rest(controller, shared);
    state.finish();
    tools.finish();
}

/// Time of the next round, ns: eight tenths of a period after a period's start. The frames of that
/// period should be complete then.
fn next_round_ns(shared: &Shared, period_ns: u64) -> u64 {
    let now = monotonic_ns();
    let phase = shared.scheduled_ns.load(Relaxed) + period_ns / 10 * 8;
    let behind = now.saturating_sub(phase);
    if now < phase && phase - now <= period_ns {
        return phase;
    }
    now + period_ns - behind % period_ns
}

/// Lends the memory of iceoryx2 samples.
struct Samples<'a, T: core::fmt::Debug + ZeroCopySend + 'static>(
    &'a Publisher<ipc::Service, T, ()>,
);

#[expect(
    unsafe_code,
    reason = "iceoryx2's loans have the properties that `Lender` demands"
)]
// SAFETY: a loaned sample is memory that is mapped from a file, so it is initialised. It stays
// where it is, and nobody else uses it until it is sent or dropped. Any thread may write it.
unsafe impl<T: Pod + core::fmt::Debug + ZeroCopySend> Lender<T> for Samples<'_, T> {
    type Loan = SampleMutUninit<ipc::Service, MaybeUninit<T>, ()>;

    fn loan(&mut self) -> Option<Self::Loan> {
        self.0.loan_uninit().ok()
    }

    fn memory(loan: &mut Self::Loan) -> NonNull<T> {
        NonNull::from(loan.payload_mut()).cast()
    }

    fn send(&mut self, loan: Self::Loan) {
        // SAFETY: the memory is initialised (see above), and any content is valid (`Pod`).
        let sample = unsafe { loan.assume_init() };
        // A frame that cannot be sent is dropped. The next frame replaces it.
        let _ = sample.send();
    }
}

/// Collects timing records into batches.
struct Timing {
    records: Consumer<'static, TickRecord>,
    batch: Box<TimingBatch>,
    next_sequence: u64,
}

impl Timing {
    fn new(records: Consumer<'static, TickRecord>) -> Self {
        Self {
            records,
            batch: Box::new(TimingBatch::zeroed()),
            next_sequence: 0,
        }
    }

    fn send_full(&mut self, controller: &Controller, shared: &Shared) {
        while let Some(record) = self.records.dequeue() {
            if let Some(place) = self.batch.records.get_mut(self.batch.count as usize) {
                *place = record;
                self.batch.count += 1;
            }
            if self.batch.count as usize == TIMING_BATCH {
                self.send(controller, shared);
            }
        }
    }

    fn send_rest(&mut self, controller: &Controller, shared: &Shared) {
        self.send_full(controller, shared);
        self.send(controller, shared);
    }

    fn send(&mut self, controller: &Controller, shared: &Shared) {
        let batch = &mut *self.batch;
        batch.sequence = self.next_sequence;
        self.next_sequence += 1;
        batch.allocations = shared.allocations.load(Relaxed);
        batch.page_faults = shared.page_faults.load(Relaxed);
        batch.involuntary_switches = shared.involuntary_switches.load(Relaxed);
        batch.blocks = shared.blocks.load(Relaxed);
        batch.ticks = shared.ticks.load(Relaxed);
        batch.missed_periods = shared.missed_periods.load(Relaxed);
        batch.late_ticks = shared.late_ticks.load(Relaxed);
        batch.realtime = shared.realtime.load(Relaxed);
        batch.contact_ticks = shared.contact_ticks.load(Relaxed);
        for (counts, shared) in [
            (&mut batch.faults, &shared.faults),
            (&mut batch.held_ticks, &shared.held_ticks),
            (&mut batch.held_times, &shared.held_times),
        ] {
            for (to, from) in counts.iter_mut().zip(shared) {
                *to = from.load(Relaxed);
            }
        }
        let _ = controller.timing.send_copy(*batch);
        *batch = TimingBatch::zeroed();
    }
}

/// Collects inputs into batches.
struct Inputs {
    records: Consumer<'static, InputRecord>,
    batch: Box<InputBatch>,
}

impl Inputs {
    fn new(records: Consumer<'static, InputRecord>) -> Self {
        Self {
            records,
            batch: bytemuck::zeroed_box(),
        }
    }

    fn send_full(&mut self, controller: &Controller, shared: &Shared) {
        while let Some(record) = self.records.dequeue() {
            if let Some(place) = self.batch.records.get_mut(self.batch.count as usize) {
                *place = record;
                self.batch.count += 1;
            }
            if self.batch.count as usize == INPUT_BATCH {
                self.send(controller, shared);
            }
        }
    }

    /// Sends what is left. The last batch gives the number of ticks, which marks the end of the
    /// run.
    fn send_rest(&mut self, controller: &Controller, shared: &Shared) {
        self.send_full(controller, shared);
        self.batch.ran = u32::try_from(shared.ticks.load(Relaxed)).unwrap_or(u32::MAX);
        self.send(controller, shared);
    }

    fn send(&mut self, controller: &Controller, shared: &Shared) {
        let Some(setup) = shared.setup.get() else {
            return; // no tick ran
        };
        self.batch.setup = *setup;
        self.batch.lost = shared.inputs_lost.load(Relaxed);
        // Without a recorder, this costs only a copy of the batch.
        let _ = controller.inputs.send_copy(*self.batch);
        self.batch.count = 0;
    }
}

/// Receives commands from hosts and sends replies.
struct CommandServer {
    commands: Producer<'static, Command>,
    accepted: Consumer<'static, u64>,
    waiting: VecDeque<Request>,
}

impl CommandServer {
    fn serve(&mut self, controller: &Controller, shared: &Shared) {
        while let Some(tick) = self.accepted.dequeue() {
            if let Some(request) = self.waiting.pop_front() {
                request.reply(reply(ReplyMsg::DONE, tick));
            }
        }
        while let Some(request) = controller.next_request() {
            let tick = shared.ticks.load(Relaxed);
            match parse(request.command()) {
                Ok(Parsed::Stop) => {
                    request.reply(reply(ReplyMsg::DONE, tick));
                    shared.ask_to_end(Ended::Commanded);
                }
                Ok(Parsed::Tick(command)) => match self.commands.enqueue(command) {
                    Ok(()) => self.waiting.push_back(request),
                    Err(_) => request.reply(reply(ReplyMsg::BUSY, tick)),
                },
                Err(outcome) => request.reply(reply(outcome, tick)),
            }
        }
    }
}

#[derive(Debug, PartialEq)]
enum Parsed {
    Stop,
    Tick(Command),
}

fn reply(outcome: u32, tick: u64) -> ReplyMsg {
    ReplyMsg {
        outcome,
        reserved: 0,
        tick,
    }
}

/// Parses a command. The error is the outcome for the reply that refuses it.
fn parse(message: CommandMsg) -> Result<Parsed, u32> {
    let flag = match message.argument {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(ReplyMsg::OUT_OF_RANGE),
    };
    Ok(match message.kind {
        CommandMsg::PAUSE => Parsed::Tick(Command::Pause(flag?)),
        CommandMsg::RESET => Parsed::Tick(Command::Reset),
        CommandMsg::ENABLE_FORCE => Parsed::Tick(Command::EnableForce(flag?)),
        CommandMsg::INSTRUMENT => Parsed::Tick(Command::Instrument(
            instrument(message.argument).ok_or(ReplyMsg::OUT_OF_RANGE)?,
        )),
        CommandMsg::START => Parsed::Tick(Command::Start(
            Task::from_number(message.argument).ok_or(ReplyMsg::OUT_OF_RANGE)?,
        )),
        CommandMsg::COMPLICATION => Parsed::Tick(Command::Complication(
            Complication::from_number(message.argument).ok_or(ReplyMsg::OUT_OF_RANGE)?,
        )),
        CommandMsg::STOP => Parsed::Stop,
        _ => return Err(ReplyMsg::UNKNOWN),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn any_message_is_understood_or_refused() {
        for kind in 0..=11 {
            for argument in 0..=8 {
                let outcome = parse(CommandMsg { kind, argument });
                let (known, in_range) = match kind {
                    CommandMsg::PAUSE | CommandMsg::ENABLE_FORCE | CommandMsg::COMPLICATION => {
                        (true, argument <= 1)
                    }
                    CommandMsg::INSTRUMENT => (true, argument <= 4),
                    CommandMsg::START => (true, argument <= 4),
                    CommandMsg::RESET | CommandMsg::STOP => (true, true),
                    _ => (false, false),
                };
                let refusal = match (known, in_range) {
                    (_, true) => None,
                    (true, false) => Some(ReplyMsg::OUT_OF_RANGE),
                    (false, false) => Some(ReplyMsg::UNKNOWN),
                };
                assert_eq!(outcome.err(), refusal, "kind {kind}, argument {argument}");
            }
        }
    }

    proptest! {
        #[test]
        fn the_next_round_is_within_a_period_and_in_phase(ago in 0u64..50_000_000) {
            let shared = Shared::default();
            let period = 1_000_000;
            let scheduled = monotonic_ns() - ago;
            shared.scheduled_ns.store(scheduled, Relaxed);
            let before = monotonic_ns();
            let next = next_round_ns(&shared, period);
            prop_assert!(next > before && next <= monotonic_ns() + period);
            prop_assert_eq!((next - scheduled) % period, 800_000);
        }
    }
}
