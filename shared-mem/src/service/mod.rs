//! The iceoryx2 services: names and quality of service, which nothing else sets, and their ends.
//!
//! A [`Station`] is a name; stations that run side by side, tests among them, do not see each
//! other. A controller holds the [`Controller`] end, any number of hosts up to [`MAX_HOSTS`] hold
//! a [`Host`] end. Either may come first, die, and come back.

mod ends;
mod folder;

use std::path::PathBuf;

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{
    BackpressureStrategy, FileName, LogLevel, Path, SemanticString, SignalHandlingMode,
    ZeroCopySend, ipc, set_log_level,
};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenOrCreateError;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::message::{CommandMsg, ReplyMsg};

pub use ends::{
    Controller, HandReceiver, HandSender, Host, Request, Tap, TaskReceiver, TaskSender,
};
pub use folder::user_folder;

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

/// An error between the processes.
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
        /// Its problem.
        problem: String,
    },
    /// No permission, no shared memory, ….
    #[error("station '{station}', {doing}: {detail}; is /dev/shm there, writable, and not full?")]
    Transport {
        /// Station.
        station: String,
        /// The step that failed.
        doing: &'static str,
        /// iceoryx2's own words.
        detail: String,
    },
    /// No controller answered.
    #[error("station '{station}': no controller answered within {waited_ms} ms")]
    NoAnswer {
        /// Station.
        station: String,
        /// Time that was waited, ms.
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

    /// Takes access away from other users. iceoryx2 leaves the folder open to the user's group, and
    /// some of its files in /dev/shm open to everybody.
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
            .for_each(|path| folder::close(&path));
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

/// A recorder that gets no processor time for 8 s loses nothing. Few may listen: the controller
/// locks the memory of each one's buffer.
const INPUTS: Quality = Quality {
    buffer: 128,
    history: 0,
    readers: 2,
};
