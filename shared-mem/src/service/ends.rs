//! Ends of a station. Each type opens the services that a process needs for one purpose.

use core::time::Duration;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::client::Client;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections as _;
use iceoryx2::prelude::{ZeroCopySend, ipc};

use super::command::command_through;
use super::join::{Member, MemoryNeed};
use super::{EVENTS, INPUTS, NEWEST, ServiceError, Station, TIMING};
use crate::inputs::InputBatch;
use crate::message::{CommandMsg, EventMsg, HandMsg, ReplyMsg, StateFrame, TimingBatch, ToolFrame};
use crate::task::TaskMsg;

/// Shared memory that a controller needs, per service.
const CONTROLLER: [MemoryNeed; 6] = [
    MemoryNeed::publisher::<StateFrame>(NEWEST),
    MemoryNeed::publisher::<ToolFrame>(NEWEST),
    MemoryNeed::publisher::<EventMsg>(EVENTS),
    MemoryNeed::publisher::<TimingBatch>(TIMING),
    MemoryNeed::publisher::<InputBatch>(INPUTS),
    MemoryNeed::COMMANDS,
];
/// Shared memory that a host needs, per service.
const HOST: [MemoryNeed; 5] = [
    MemoryNeed::subscriber(NEWEST),
    MemoryNeed::subscriber(NEWEST),
    MemoryNeed::subscriber(EVENTS),
    MemoryNeed::subscriber(TIMING),
    MemoryNeed::COMMANDS,
];

impl Station {
    /// Checks that shared memory has room for a controller, a display and a recorder. (The recorder
    /// is counted as a host.) Each process checks its own need again when it joins. This check
    /// finds a lack before any work is done.
    ///
    /// # Errors
    /// [`ServiceError::NoRoom`], or another error about shared memory.
    pub fn check_room(&self) -> Result<(), ServiceError> {
        self.room_for(&[&CONTROLLER[..], &HOST, &HOST].concat())
    }

    /// Shared memory that [`Station::check_room`] requires, bytes.
    #[must_use]
    pub fn room_needed() -> u64 {
        let all = CONTROLLER.iter().chain(&HOST).chain(&HOST);
        all.map(|need| need.bytes()).sum()
    }
}

/// The controller's end. The publishing thread owns it, not the realtime thread, because creating
/// ports, loaning and sending samples allocate memory.
#[derive(Debug)]
pub struct Controller {
    /// Sphere states.
    pub state: Publisher<ipc::Service, StateFrame, ()>,
    /// Tool states.
    pub tools: Publisher<ipc::Service, ToolFrame, ()>,
    /// Events.
    pub events: Publisher<ipc::Service, EventMsg, ()>,
    /// Timing.
    pub timing: Publisher<ipc::Service, TimingBatch, ()>,
    /// Inputs of the ticks.
    pub inputs: Publisher<ipc::Service, InputBatch, ()>,
    commands: Server<ipc::Service, CommandMsg, (), ReplyMsg, ()>,
    member: Member,
}

/// A command that waits for its reply.
#[derive(Debug)]
pub struct Request(ActiveRequest<ipc::Service, CommandMsg, (), ReplyMsg, ()>);

impl Request {
    /// The command.
    #[must_use]
    pub fn command(&self) -> CommandMsg {
        *self.0.payload()
    }

    /// Answers the command. If the host is gone, the answer is dropped.
    pub fn reply(self, reply: ReplyMsg) {
        let _ = self.0.send_copy(reply);
    }
}

impl Controller {
    /// Takes control of a station.
    ///
    /// # Errors
    /// [`ServiceError::SecondController`] if another process controls the station, or the error of
    /// the step that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&CONTROLLER)?;
        let node = joining.node();
        Ok(Self {
            state: station.publisher(node, "state", NEWEST)?,
            tools: station.publisher(node, "tools", NEWEST)?,
            events: station.publisher(node, "events", EVENTS)?,
            timing: station.publisher(node, "timing", TIMING)?,
            inputs: station.publisher(node, "inputs", INPUTS)?,
            commands: station
                .commands(node)?
                .server_builder()
                .create()
                .map_err(|error| station.transport("serving commands", &error))?,
            member: joining.finish()?,
        })
    }

    /// Sends the last events to new hosts. Without this call, new hosts would get them only with
    /// the next event. The call is cheap if no host is new.
    pub fn greet(&self) {
        // If a host cannot be connected now, the next event connects it.
        let _ = self.events.update_connections();
    }

    /// The next command, if any.
    pub fn next_request(&self) -> Option<Request> {
        self.commands.receive().ok().flatten().map(Request)
    }

    /// Removes the iceoryx2 resources of hosts that died. This may take milliseconds and is rarely
    /// needed.
    pub fn forget_dead(&self) {
        self.member.forget_dead();
    }
}

/// The sender's end of the service `hand`: a display whose mouse and keyboard move the emulated
/// hand.
#[derive(Debug)]
pub struct HandSender {
    hand: Publisher<ipc::Service, HandMsg, ()>,
    member: Member,
}

impl HandSender {
    /// Takes control of the emulated hand.
    ///
    /// # Errors
    /// [`ServiceError::SecondHand`] if another display controls the hand, or the error of the step
    /// that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[MemoryNeed::publisher::<HandMsg>(NEWEST)])?;
        let hand = station.publisher(joining.node(), "hand", NEWEST);
        let hand = hand.map_err(|error| match error {
            ServiceError::SecondController(name) => ServiceError::SecondHand(name),
            other => other,
        })?;
        Ok(Self {
            hand,
            member: joining.finish()?,
        })
    }

    /// Sends the message. Returns true if an emulated hand received it; with real devices there is
    /// no receiver.
    pub fn send(&self, message: HandMsg) -> bool {
        self.hand.send_copy(message).is_ok_and(|heard| heard > 0)
    }

    /// Removes the iceoryx2 resources of emulators that died.
    pub fn forget_dead(&self) {
        self.member.forget_dead();
    }
}

/// The emulator's end of the service `hand`.
#[derive(Debug)]
pub struct HandReceiver {
    hand: Subscriber<ipc::Service, HandMsg, ()>,
    _member: Member,
}

impl HandReceiver {
    /// Begins to receive. The sender may start later.
    ///
    /// # Errors
    /// The `ServiceError` of the step that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[MemoryNeed::subscriber(NEWEST)])?;
        Ok(Self {
            hand: station.subscriber(joining.node(), "hand", NEWEST)?,
            _member: joining.finish()?,
        })
    }

    /// The newest message, if one came since the last call.
    pub fn newest(&self) -> Option<HandMsg> {
        let mut newest_msg = None;
        newest(&self.hand, |message| newest_msg = Some(*message));
        newest_msg
    }
}

/// The sender's end of the service `task`: the host that assesses.
#[derive(Debug)]
pub struct TaskSender {
    task: Publisher<ipc::Service, TaskMsg, ()>,
    _member: Member,
}

impl TaskSender {
    /// Begins to publish the state of a task. Receivers may join later.
    ///
    /// # Errors
    /// [`ServiceError::SecondTask`] if another host publishes the task, or the error of the step
    /// that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[MemoryNeed::publisher::<TaskMsg>(NEWEST)])?;
        let task = station.publisher(joining.node(), "task", NEWEST);
        let task = task.map_err(|error| match error {
            ServiceError::SecondController(name) => ServiceError::SecondTask(name),
            other => other,
        })?;
        Ok(Self {
            task,
            _member: joining.finish()?,
        })
    }

    /// Publishes the state of the task. Returns true if it could be sent.
    pub fn send(&self, message: &TaskMsg) -> bool {
        self.task.send_copy(*message).is_ok()
    }
}

/// The receiver's end of the service `task`: a host that watches a task.
#[derive(Debug)]
pub struct TaskReceiver {
    task: Subscriber<ipc::Service, TaskMsg, ()>,
    _member: Member,
}

impl TaskReceiver {
    /// Begins to receive. The task may begin later.
    ///
    /// # Errors
    /// The `ServiceError` of the step that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[MemoryNeed::subscriber(NEWEST)])?;
        Ok(Self {
            task: station.subscriber(joining.node(), "task", NEWEST)?,
            _member: joining.finish()?,
        })
    }

    /// Copies the newest message into `into`. Returns true if one came since the last call.
    /// [`TaskMsg::text`] checks the message.
    pub fn newest(&self, into: &mut TaskMsg) -> bool {
        newest(&self.task, |message| *into = *message)
    }
}

/// A recorder's end. If it is opened before the controller starts and does not fall behind, it gets
/// all inputs, events and timing batches. Of the tools it gets only the newest frame.
#[derive(Debug)]
pub struct Tap {
    inputs: Subscriber<ipc::Service, InputBatch, ()>,
    state: Subscriber<ipc::Service, StateFrame, ()>,
    tools: Subscriber<ipc::Service, ToolFrame, ()>,
    events: Subscriber<ipc::Service, EventMsg, ()>,
    timing: Subscriber<ipc::Service, TimingBatch, ()>,
    _member: Member,
}

impl Tap {
    /// Begins to receive. The station's controller may start later.
    ///
    /// # Errors
    /// The `ServiceError` of the step that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining =
            station.join(&[INPUTS, NEWEST, NEWEST, EVENTS, TIMING].map(MemoryNeed::subscriber))?;
        let node = joining.node();
        Ok(Self {
            inputs: station.subscriber(node, "inputs", INPUTS)?,
            state: station.subscriber(node, "state", NEWEST)?,
            tools: station.subscriber(node, "tools", NEWEST)?,
            events: station.subscriber(node, "events", EVENTS)?,
            timing: station.subscriber(node, "timing", TIMING)?,
            _member: joining.finish()?,
        })
    }

    /// Calls `each` with every batch of inputs since the last call, oldest first.
    pub fn drain_inputs(&self, mut each: impl FnMut(&InputBatch)) {
        drain(&self.inputs, &mut each);
    }

    /// Copies the newest state into `into`. Returns true if one came since the last call.
    pub fn newest_state(&self, into: &mut StateFrame) -> bool {
        newest(&self.state, |frame| *into = *frame)
    }

    /// Copies the newest frame of the tools into `into` and returns true, if one came since the
    /// last call.
    pub fn newest_tools(&self, into: &mut ToolFrame) -> bool {
        newest(&self.tools, |frame| *into = *frame)
    }

    /// Calls `each` with every event since the last call, oldest first.
    pub fn drain_events(&self, mut each: impl FnMut(&EventMsg)) {
        drain(&self.events, &mut each);
    }

    /// Calls `each` with every timing batch since the last call, oldest first.
    pub fn drain_timing(&self, mut each: impl FnMut(&TimingBatch)) {
        drain(&self.timing, &mut each);
    }
}

/// End of a host: a display, a report or a test.
#[derive(Debug)]
pub struct Host {
    station: Station,
    state: Subscriber<ipc::Service, StateFrame, ()>,
    tools: Subscriber<ipc::Service, ToolFrame, ()>,
    events: Subscriber<ipc::Service, EventMsg, ()>,
    timing: Subscriber<ipc::Service, TimingBatch, ()>,
    commands: Client<ipc::Service, CommandMsg, (), ReplyMsg, ()>,
    member: Member,
}

impl Host {
    /// Begins to receive from a station. Its controller may start later.
    ///
    /// # Errors
    /// The `ServiceError` of the step that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&HOST)?;
        let node = joining.node();
        Ok(Self {
            state: station.subscriber(node, "state", NEWEST)?,
            tools: station.subscriber(node, "tools", NEWEST)?,
            events: station.subscriber(node, "events", EVENTS)?,
            timing: station.subscriber(node, "timing", TIMING)?,
            commands: station
                .commands(node)?
                .client_builder()
                .create()
                .map_err(|error| station.transport("creating a command client", &error))?,
            station: station.clone(),
            member: joining.finish()?,
        })
    }

    /// Copies the newest frame of the tissue into `into`. Returns true if one came since the last
    /// call. The content is not checked here; [`StateFrame`]'s methods check it.
    pub fn newest_state(&self, into: &mut StateFrame) -> bool {
        newest(&self.state, |frame| *into = *frame)
    }

    /// Copies the newest frame of the tools into `into` and returns true, if one came since the
    /// last call.
    pub fn newest_tools(&self, into: &mut ToolFrame) -> bool {
        newest(&self.tools, |frame| *into = *frame)
    }

    /// Calls `each` with every event since the last call, oldest first.
    pub fn drain_events(&self, mut each: impl FnMut(&EventMsg)) {
        drain(&self.events, &mut each);
    }

    /// Calls `each` with every timing batch since the last call, oldest first.
    pub fn drain_timing(&self, mut each: impl FnMut(&TimingBatch)) {
        drain(&self.timing, &mut each);
    }

    /// Sends a command to the controller and waits for the reply.
    ///
    /// # Errors
    /// [`ServiceError::NoAnswer`] after `timeout`, or the error of sending.
    pub fn command(
        &self,
        command: CommandMsg,
        timeout: Duration,
    ) -> Result<ReplyMsg, ServiceError> {
        command_through(&self.commands, &self.station, command, timeout)
    }

    /// Removes the iceoryx2 resources of processes that died.
    pub fn forget_dead(&self) {
        self.member.forget_dead();
    }
}

fn newest<T>(subscriber: &Subscriber<ipc::Service, T, ()>, mut take: impl FnMut(&T)) -> bool
where
    T: core::fmt::Debug + ZeroCopySend + 'static,
{
    let mut last = None;
    while let Ok(Some(sample)) = subscriber.receive() {
        last = Some(sample);
    }
    last.is_some_and(|sample| {
        take(sample.payload());
        true
    })
}

fn drain<T>(subscriber: &Subscriber<ipc::Service, T, ()>, each: &mut impl FnMut(&T))
where
    T: core::fmt::Debug + ZeroCopySend + 'static,
{
    while let Ok(Some(sample)) = subscriber.receive() {
        each(sample.payload());
    }
}
