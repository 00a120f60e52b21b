//! The iceoryx2 services: names, quality of service, and the two ends. Nothing else sets QoS.
//!
//! A [`Station`] is a name; stations that run side by side, tests among them, do not see each
//! other. A controller holds the [`Controller`] end, any number of hosts up to [`MAX_HOSTS`] hold
//! a [`Host`] end. Either may come first, die, and come back.

use core::time::Duration;
use std::path::PathBuf;
use std::time::Instant;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::client::Client;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections as _;
use iceoryx2::prelude::{
    BackpressureStrategy, FileName, LogLevel, Path, SemanticString, SignalHandlingMode,
    ZeroCopySend, ipc, set_log_level,
};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenOrCreateError;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::inputs::InputBatch;
use crate::message::{CommandMsg, EventMsg, HandMsg, ReplyMsg, StateFrame, TimingBatch, ToolFrame};
use crate::task::TaskMsg;

/// Hosts (displays, reports) that can watch one station at once.
pub const MAX_HOSTS: usize = 8;
/// Samples that the controller may hold loaned: the handover's slots, and one in hand.
pub const MAX_LOANS: usize = 6;
/// Version of the messages; part of every service's name.
const VERSION: &str = "v2";
/// Events that a host can fall behind before the gap in `sequence` tells it what it lost.
const EVENT_BUFFER: usize = 1024;
/// Timing batches that a host can fall behind: about 16 s at 1 kHz.
const TIMING_BUFFER: usize = 256;

/// What went wrong between the processes.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// The name cannot become a file name.
    #[error(
        "station name '{0}' is not usable: 1 to 40 characters of a-z, A-Z, 0-9, '-' and '_' are"
    )]
    StationName(String),
    /// Somebody else controls this station.
    #[error(
        "station '{0}' already has a controller; stop it (its `calot run` or `calot rt`), or \
         choose another name with --station"
    )]
    SecondController(String),
    /// Somebody else leads the emulated hand.
    #[error("station '{0}': another display has the instrument in hand; let go of it there (M)")]
    SecondHand(String),
    /// Another host tells how this station's task stands.
    #[error("station '{0}': another `calot run` assesses its task; end it first")]
    SecondTask(String),
    /// Somebody speaks another version, or holds the service with another layout.
    #[error("station '{station}', service '{service}': a process of another version runs; end it")]
    OtherVersion {
        /// Station.
        station: String,
        /// Service.
        service: &'static str,
    },
    /// The folder of the user's stations cannot be trusted.
    #[error("{path}: {problem}; remove it, or name another temporary folder with TMPDIR")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// No permission, no shared memory, ….
    #[error("station '{station}', {doing}: {detail}; is /dev/shm there, writable, and not full?")]
    Transport {
        /// Station.
        station: String,
        /// What was being done.
        doing: &'static str,
        /// iceoryx2's own words.
        detail: String,
    },
    /// No controller answered.
    #[error("station '{station}': no controller answered within {waited_ms} ms")]
    NoAnswer {
        /// Station.
        station: String,
        /// How long was waited.
        waited_ms: u128,
    },
}

/// A station: the name that its processes meet under.
#[derive(Debug, Clone)]
pub struct Station {
    name: String,
    config: Config,
}

impl Station {
    /// A station by name.
    ///
    /// # Errors
    /// When the name is not 1 to 40 plain characters.
    pub fn new(name: &str) -> Result<Self, ServiceError> {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if name.is_empty() || name.len() > 40 || !name.chars().all(plain) {
            return Err(ServiceError::StationName(name.to_owned()));
        }
        let unusable = || ServiceError::StationName(name.to_owned());
        let mut config = Config::default();
        let prefix = format!("calot_{name}_");
        config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|_| unusable())?;
        let root = user_folder()?;
        let root = Path::new(root.as_os_str().as_encoded_bytes()).map_err(|_| unusable())?;
        config.global.set_root_path(&root);
        // A process that died is forgotten by whoever comes next.
        config.global.node.cleanup_dead_nodes_on_creation = true;
        Ok(Self {
            name: name.to_owned(),
            config,
        })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Takes from others what iceoryx2 leaves open to them: the folder to their group, and some of its
    /// files in /dev/shm, which no folder of ours can close, to everybody.
    fn close_to_others(&self) {
        let prefix = format!("calot_{}_", self.name);
        let files = std::fs::read_dir("/dev/shm")
            .into_iter()
            .flatten()
            .flatten();
        files
            .filter(|file| file.file_name().to_string_lossy().starts_with(&prefix))
            .map(|file| file.path())
            .chain(user_folder().ok())
            .for_each(|path| close(&path));
    }

    fn node(&self) -> Result<Node<ipc::Service>, ServiceError> {
        // A peer that died is everyday here; its warning is a page long.
        set_log_level(LogLevel::Error);
        NodeBuilder::new()
            .config(&self.config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| self.transport("joining", &error))
            .inspect(|_| self.close_to_others())
    }

    fn transport(&self, doing: &'static str, error: &dyn core::fmt::Debug) -> ServiceError {
        let station = self.name.clone();
        ServiceError::Transport {
            station,
            doing,
            detail: format!("{error:?}"),
        }
    }

    fn topic<T>(
        &self,
        node: &Node<ipc::Service>,
        service: &'static str,
        quality: Quality,
    ) -> Result<PortFactory<ipc::Service, T, ()>, ServiceError>
    where
        T: core::fmt::Debug + ZeroCopySend + 'static,
    {
        let name = format!("calot/{service}/{VERSION}");
        let name = name
            .as_str()
            .try_into()
            .map_err(|e| self.transport("naming", &e))?;
        node.service_builder(&name)
            .publish_subscribe::<T>()
            .enable_safe_overflow(true)
            .subscriber_max_buffer_size(quality.buffer)
            .subscriber_max_borrowed_samples(2)
            .history_size(quality.history)
            .max_publishers(1)
            .max_subscribers(quality.readers)
            .max_nodes(MAX_HOSTS + 2)
            .open_or_create()
            .map_err(|error| match error {
                PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(inner)
                    if format!("{inner:?}").contains("Incompatible")
                        || format!("{inner:?}").contains("DoesNotSupport") =>
                {
                    ServiceError::OtherVersion {
                        station: self.name.clone(),
                        service,
                    }
                }
                other => self.transport("opening a topic", &other),
            })
    }

    fn commands(&self, node: &Node<ipc::Service>) -> Result<Commands, ServiceError> {
        let name = format!("calot/command/{VERSION}");
        let name = name
            .as_str()
            .try_into()
            .map_err(|e| self.transport("naming", &e))?;
        node.service_builder(&name)
            .request_response::<CommandMsg, ReplyMsg>()
            .max_servers(1)
            .max_clients(MAX_HOSTS)
            .max_nodes(MAX_HOSTS + 2)
            .max_active_requests_per_client(4)
            .open_or_create()
            .map_err(|error| self.transport("opening the command service", &error))
    }

    fn publisher<T>(
        &self,
        node: &Node<ipc::Service>,
        service: &'static str,
        quality: Quality,
    ) -> Result<Publisher<ipc::Service, T, ()>, ServiceError>
    where
        T: core::fmt::Debug + ZeroCopySend + 'static,
    {
        self.topic(node, service, quality)?
            .publisher_builder()
            .max_loaned_samples(MAX_LOANS)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|error| match format!("{error:?}").as_str() {
                "ExceedsMaxSupportedPublishers" => {
                    ServiceError::SecondController(self.name.clone())
                }
                _ => self.transport("creating a publisher", &error),
            })
    }

    fn subscriber<T>(
        &self,
        node: &Node<ipc::Service>,
        service: &'static str,
        quality: Quality,
    ) -> Result<Subscriber<ipc::Service, T, ()>, ServiceError>
    where
        T: core::fmt::Debug + ZeroCopySend + 'static,
    {
        self.topic(node, service, quality)?
            .subscriber_builder()
            .history_request(quality.history)
            .create()
            .map_err(|error| self.transport("subscribing (more than 8 hosts?)", &error))
    }
}

type Commands = iceoryx2::service::port_factory::request_response::PortFactory<
    ipc::Service,
    CommandMsg,
    (),
    ReplyMsg,
    (),
>;

#[derive(Clone, Copy)]
struct Quality {
    buffer: usize,
    history: usize,
    readers: usize,
}

/// The newest wins; a host that joins gets it at once.
const NEWEST: Quality = Quality {
    buffer: 2,
    history: 1,
    readers: MAX_HOSTS,
};
const EVENTS: Quality = Quality {
    buffer: EVENT_BUFFER,
    history: 64,
    readers: MAX_HOSTS,
};
const TIMING: Quality = Quality {
    buffer: TIMING_BUFFER,
    history: 1,
    readers: MAX_HOSTS,
};

/// A recorder that is kept from the processor for 8 s loses nothing. Few may listen: what is kept for
/// each is memory that the controller locks.
const INPUTS: Quality = Quality {
    buffer: 128,
    history: 0,
    readers: 2,
};

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
    /// What the ticks took in.
    pub inputs: Publisher<ipc::Service, InputBatch, ()>,
    commands: Server<ipc::Service, CommandMsg, (), ReplyMsg, ()>,
    node: Node<ipc::Service>,
}

/// A command that waits for its reply.
#[derive(Debug)]
pub struct Request(ActiveRequest<ipc::Service, CommandMsg, (), ReplyMsg, ()>);

impl Request {
    /// What is asked.
    #[must_use]
    pub fn command(&self) -> CommandMsg {
        *self.0.payload()
    }

    /// Answers. A host that is gone by now does not mind.
    pub fn reply(self, reply: ReplyMsg) {
        let _ = self.0.send_copy(reply);
    }
}

impl Controller {
    /// Takes control of a station.
    ///
    /// # Errors
    /// [`ServiceError::SecondController`] if somebody has it; others as they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let node = station.node()?;
        Ok(Self {
            state: station.publisher(&node, "state", NEWEST)?,
            tools: station.publisher(&node, "tools", NEWEST)?,
            events: station.publisher(&node, "events", EVENTS)?,
            timing: station.publisher(&node, "timing", TIMING)?,
            inputs: station.publisher(&node, "inputs", INPUTS)?,
            commands: station
                .commands(&node)?
                .server_builder()
                .create()
                .map_err(|error| station.transport("serving commands", &error))?,
            node,
        })
    }

    /// Gives hosts that have come the last events, which they would get with the next one otherwise. Takes
    /// next to nothing when none came.
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
        self.node.try_cleanup_dead_nodes();
    }
}

/// The sender's end of the service `hand`: a display whose mouse and keyboard lead the hand.
#[derive(Debug)]
pub struct HandSender {
    hand: Publisher<ipc::Service, HandMsg, ()>,
    node: Node<ipc::Service>,
}

impl HandSender {
    /// Takes the hand.
    ///
    /// # Errors
    /// [`ServiceError::SecondHand`] if another display has it.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let node = station.node()?;
        let hand = station.publisher(&node, "hand", NEWEST);
        let hand = hand.map_err(|error| match error {
            ServiceError::SecondController(name) => ServiceError::SecondHand(name),
            other => other,
        })?;
        Ok(Self { hand, node })
    }

    /// Sends; returns whether an emulated hand listens. A real device's hand cannot be led.
    pub fn send(&self, message: HandMsg) -> bool {
        self.hand.send_copy(message).is_ok_and(|heard| heard > 0)
    }

    /// Forgets emulators that died.
    pub fn forget_dead(&self) {
        self.node.try_cleanup_dead_nodes();
    }
}

/// The emulator's end of the service `hand`.
#[derive(Debug)]
pub struct HandReceiver {
    hand: Subscriber<ipc::Service, HandMsg, ()>,
    _node: Node<ipc::Service>,
}

impl HandReceiver {
    /// Listens, whether anybody leads the hand yet or not.
    ///
    /// # Errors
    /// As they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let node = station.node()?;
        let hand = station.subscriber(&node, "hand", NEWEST)?;
        Ok(Self { hand, _node: node })
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
    _node: Node<ipc::Service>,
}

impl TaskSender {
    /// Begins to tell, whether anybody listens yet or not.
    ///
    /// # Errors
    /// [`ServiceError::SecondTask`] if another host does; others as they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let node = station.node()?;
        let task = station.publisher(&node, "task", NEWEST);
        let task = task.map_err(|error| match error {
            ServiceError::SecondController(name) => ServiceError::SecondTask(name),
            other => other,
        })?;
        Ok(Self { task, _node: node })
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
    _node: Node<ipc::Service>,
}

impl TaskReceiver {
    /// Begins to watch, whether there is a task yet or not.
    ///
    /// # Errors
    /// As they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let node = station.node()?;
        let task = station.subscriber(&node, "task", NEWEST)?;
        Ok(Self { task, _node: node })
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
    _node: Node<ipc::Service>,
}

impl Tap {
    /// Begins to listen, whether the station's controller runs yet or not.
    ///
    /// # Errors
    /// As they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let node = station.node()?;
        Ok(Self {
            inputs: station.subscriber(&node, "inputs", INPUTS)?,
            tools: station.subscriber(&node, "tools", NEWEST)?,
            events: station.subscriber(&node, "events", EVENTS)?,
            timing: station.subscriber(&node, "timing", TIMING)?,
            _node: node,
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
    node: Node<ipc::Service>,
}

impl Host {
    /// Begins to watch a station, whether its controller runs yet or not.
    ///
    /// # Errors
    /// As they say.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let node = station.node()?;
        Ok(Self {
            state: station.subscriber(&node, "state", NEWEST)?,
            tools: station.subscriber(&node, "tools", NEWEST)?,
            events: station.subscriber(&node, "events", EVENTS)?,
            timing: station.subscriber(&node, "timing", TIMING)?,
            commands: station
                .commands(&node)?
                .client_builder()
                .create()
                .map_err(|error| station.transport("creating a command client", &error))?,
            station: station.clone(),
            node,
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
        self.node.try_cleanup_dead_nodes();
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

/// Leaves a file to its owner, if that is this user. What a name points to is not followed: anybody can
/// put a link into /dev/shm. One that another process has just removed needs no closing.
fn close(path: &std::path::Path) {
    use rustix::fs::{Mode, OFlags};
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let Ok(file) = rustix::fs::open(path, flags, Mode::empty()).map(std::fs::File::from) else {
        return;
    };
    let Ok(meta) = file.metadata() else { return };
    let mode = meta.permissions().mode();
    let is_ours = meta.uid() == user() && (meta.is_file() || meta.is_dir());
    if is_ours && mode & 0o077 != 0 {
        let _ = file.set_permissions(std::fs::Permissions::from_mode(mode & 0o700));
    }
}

/// Whom this process runs as.
fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// The folder of this user's stations: made private, and refused if somebody else could have
/// put things into it (a name in the temporary folder can be guessed).
///
/// # Errors
/// [`ServiceError::Folder`] says what is wrong with it.
pub fn user_folder() -> Result<PathBuf, ServiceError> {
    use std::os::unix::fs::{DirBuilderExt, MetadataExt};
    let user = user();
    let path = std::env::temp_dir().join(format!("calot-{user}"));
    let refused = |problem: String| ServiceError::Folder {
        path: path.clone(),
        problem,
    };
    match std::fs::DirBuilder::new().mode(0o700).create(&path) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
            return Err(refused(error.to_string()));
        }
        _ => {}
    }
    let meta = std::fs::symlink_metadata(&path).map_err(|error| refused(error.to_string()))?;
    if !meta.is_dir() || meta.uid() != user || meta.mode() & 0o022 != 0 {
        return Err(refused(
            "it is not a folder that only this user can write to".into(),
        ));
    }
    Ok(path)
}
