//! Ends of a station's services, one type per kind of process.

use core::time::Duration;
use std::time::Instant;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::client::Client;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections as _;
use iceoryx2::prelude::{ZeroCopySend, ipc};

use super::join::{Member, Need};
use super::{EVENTS, INPUTS, NEWEST, ServiceError, Station, TIMING};
use crate::inputs::InputBatch;
use crate::message::{CommandMsg, EventMsg, HandMsg, ReplyMsg, StateFrame, TimingBatch, ToolFrame};
use crate::task::TaskMsg;

/// A controller's needs of shared memory.
const CONTROLLER: [Need; 6] = [
    Need::publisher::<StateFrame>(NEWEST),
    Need::publisher::<ToolFrame>(NEWEST),
    Need::publisher::<EventMsg>(EVENTS),
    Need::publisher::<TimingBatch>(TIMING),
    Need::publisher::<InputBatch>(INPUTS),
    Need::COMMANDS,
];
/// A host's.
const HOST: [Need; 5] = [
    Need::subscriber(NEWEST),
    Need::subscriber(NEWEST),
    Need::subscriber(EVENTS),
    Need::subscriber(TIMING),
    Need::COMMANDS,
];

impl Station {
    /// Checks that shared memory has room for a controller, a recorder and a display. Each of them
    /// takes its part when it joins; this tells before any work is done.
    ///
    /// # Errors
    /// [`ServiceError::NoRoom`] and its like.
    pub fn check_room(&self) -> Result<(), ServiceError> {
        self.room_for(&[&CONTROLLER[..], &HOST, &HOST].concat())
    }

    /// Shared memory for them, bytes.
    #[must_use]
    pub fn room_needed() -> u64 {
        let all = CONTROLLER.iter().chain(&HOST).chain(&HOST);
        all.map(|need| need.bytes()).sum()
    }
}

/// The controller's end. Owned by the publishing thread: creating, loaning and sending allocate.
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

    /// Answers. The host may be gone by now.
    pub fn reply(self, reply: ReplyMsg) {
        let _ = self.0.send_copy(reply);
    }
}

impl Controller {
    /// Takes control of a station.
    ///
    /// # Errors
    /// [`ServiceError::SecondController`] if another process has it, or what failed.
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

    /// Gives new hosts the last events now. Else they would get them with the next event. Cheap if
    /// no host is new.
    pub fn greet(&self) {
        // What cannot be connected now is tried again with the next event.
        let _ = self.events.update_connections();
    }

    /// The next command, if any.
    pub fn next_request(&self) -> Option<Request> {
        self.commands.receive().ok().flatten().map(Request)
    }

    /// Forgets hosts that died. Not needed often; takes up to milliseconds.
    pub fn forget_dead(&self) {
        self.member.forget_dead();
    }
}

/// The sender's end of the service `hand`: a display whose mouse and keyboard lead the hand.
#[derive(Debug)]
pub struct HandSender {
    hand: Publisher<ipc::Service, HandMsg, ()>,
    member: Member,
}

impl HandSender {
    /// Takes the hand.
    ///
    /// # Errors
    /// [`ServiceError::SecondHand`] if another display has it.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[Need::publisher::<HandMsg>(NEWEST)])?;
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

    /// Sends; returns whether an emulated hand listens. A real device's hand cannot be led.
    pub fn send(&self, message: HandMsg) -> bool {
        self.hand.send_copy(message).is_ok_and(|heard| heard > 0)
    }

    /// Forgets emulators that died.
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
    /// Listens, whether anybody leads the hand yet or not.
    ///
    /// # Errors
    /// As they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[Need::subscriber(NEWEST)])?;
        Ok(Self {
            hand: station.subscriber(joining.node(), "hand", NEWEST)?,
            _member: joining.finish()?,
        })
    }

    /// The newest message, if a newer one came.
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
    /// Begins to tell, whether anybody listens yet or not.
    ///
    /// # Errors
    /// [`ServiceError::SecondTask`] if another host does; others as they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[Need::publisher::<TaskMsg>(NEWEST)])?;
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

    /// Tells how it stands; returns whether that could be sent.
    pub fn send(&self, message: &TaskMsg) -> bool {
        self.task.send_copy(*message).is_ok()
    }
}

/// The end of whoever watches a task.
#[derive(Debug)]
pub struct TaskReceiver {
    task: Subscriber<ipc::Service, TaskMsg, ()>,
    _member: Member,
}

impl TaskReceiver {
    /// Begins to watch, whether there is a task yet or not.
    ///
    /// # Errors
    /// As they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[Need::subscriber(NEWEST)])?;
        Ok(Self {
            task: station.subscriber(joining.node(), "task", NEWEST)?,
            _member: joining.finish()?,
        })
    }

    /// Copies the newest message into `into`, if a newer one came. [`TaskMsg::text`] checks it.
    pub fn newest(&self, into: &mut TaskMsg) -> bool {
        newest(&self.task, |message| *into = *message)
    }
}

/// A recorder's end. Opened before the controller starts, it misses nothing.
#[derive(Debug)]
pub struct Tap {
    inputs: Subscriber<ipc::Service, InputBatch, ()>,
    tools: Subscriber<ipc::Service, ToolFrame, ()>,
    events: Subscriber<ipc::Service, EventMsg, ()>,
    timing: Subscriber<ipc::Service, TimingBatch, ()>,
    _member: Member,
}

impl Tap {
    /// Begins to listen, whether the station's controller runs yet or not.
    ///
    /// # Errors
    /// As they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[INPUTS, NEWEST, EVENTS, TIMING].map(Need::subscriber))?;
        let node = joining.node();
        Ok(Self {
            inputs: station.subscriber(node, "inputs", INPUTS)?,
            tools: station.subscriber(node, "tools", NEWEST)?,
            events: station.subscriber(node, "events", EVENTS)?,
            timing: station.subscriber(node, "timing", TIMING)?,
            _member: joining.finish()?,
        })
    }

    /// Hands over every batch of inputs since last time, oldest first.
    pub fn drain_inputs(&self, mut each: impl FnMut(&InputBatch)) {
        drain(&self.inputs, &mut each);
    }

    /// Copies the newest tools into `into`, if there are newer ones than last time.
    pub fn newest_tools(&self, into: &mut ToolFrame) -> bool {
        newest(&self.tools, |frame| *into = *frame)
    }

    /// Hands over every event since last time, oldest first.
    pub fn drain_events(&self, mut each: impl FnMut(&EventMsg)) {
        drain(&self.events, &mut each);
    }

    /// Hands over every timing batch since last time, oldest first.
    pub fn drain_timing(&self, mut each: impl FnMut(&TimingBatch)) {
        drain(&self.timing, &mut each);
    }
}

/// A host's end: display, report, test.
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
    /// Begins to watch a station, whether its controller runs yet or not.
    ///
    /// # Errors
    /// As they say.
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

    /// Copies the newest state into `into`, if there is a newer one than last time. The content
    /// is as the controller wrote it: use [`StateFrame::spheres`], which checks.
    pub fn newest_state(&self, into: &mut StateFrame) -> bool {
        newest(&self.state, |frame| *into = *frame)
    }

    /// Copies the newest tools into `into`, if there are newer ones than last time.
    pub fn newest_tools(&self, into: &mut ToolFrame) -> bool {
        newest(&self.tools, |frame| *into = *frame)
    }

    /// Hands over every event since last time, oldest first.
    pub fn drain_events(&self, mut each: impl FnMut(&EventMsg)) {
        drain(&self.events, &mut each);
    }

    /// Hands over every timing batch since last time, oldest first.
    pub fn drain_timing(&self, mut each: impl FnMut(&TimingBatch)) {
        drain(&self.timing, &mut each);
    }

    /// Asks the controller for something and waits for its reply.
    ///
    /// # Errors
    /// [`ServiceError::NoAnswer`] after `patience`.
    pub fn command(
        &self,
        command: CommandMsg,
        patience: Duration,
    ) -> Result<ReplyMsg, ServiceError> {
        let start = Instant::now();
        while start.elapsed() < patience {
            // Sent again while no controller is connected: one that just started still gets it.
            let pending = self
                .commands
                .send_copy(command)
                .map_err(|error| self.station.transport("sending a command", &error))?;
            let connected = pending.number_of_server_connections() > 0;
            loop {
                // Asked before looking: a controller replies and hangs up in one go.
                let over = !connected || !pending.is_connected() || start.elapsed() >= patience;
                if let Ok(Some(reply)) = pending.receive() {
                    return Ok(*reply.payload());
                }
                std::thread::sleep(Duration::from_millis(2));
                if over {
                    break;
                }
            }
        }
        let waited_ms = start.elapsed().as_millis();
        Err(ServiceError::NoAnswer {
            station: self.station.name.clone(),
            waited_ms,
        })
    }

    /// Forgets processes that died.
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
