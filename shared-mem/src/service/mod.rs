//! iceoryx2 services and their ends. This module alone sets the services' names and quality of
//! service.
//!
//! A [`Station`] is the name under which the processes of one simulator meet. Stations that run at
//! the same time, such as those of tests, do not see each other. One process, the controller, holds
//! the [`Controller`] end. Up to [`MAX_HOSTS`] other processes, the hosts, each hold a [`Host`] end
//! or, as a recorder, a [`Tap`]. They may start in any order, die, and start again.

mod acts;
mod command;
mod ends;
mod error;
mod folder;
mod join;
mod memory;
mod presence;

use std::path::{Path as StdPath, PathBuf};

use iceoryx2::config::Config;
use iceoryx2::node::Node;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{BackpressureStrategy, FileName, Path, SemanticString, ZeroCopySend, ipc};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenOrCreateError;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::message::{ActMsg, ActReply, CommandMsg, ReplyMsg};

pub use acts::{ACT_PATIENCE, ActDesk, ActRequest, ActSender};
pub use command::Commander;
pub use ends::{
    Controller, HandReceiver, HandSender, Host, Request, Tap, TaskReceiver, TaskSender,
};
pub use error::ServiceError;
pub use folder::{owner, user_folder};
pub use join::Claim;

/// Largest number of readers (displays, recorders, links, scripted surgeons) of one station at
/// once.
pub const MAX_HOSTS: usize = 8;
/// Largest number of samples of one service that the controller may have on loan from iceoryx2: one
/// more than the tick uses (`SLOTS` in `handover.rs` of `rt-process`).
pub const MAX_LOANS: usize = 6;
/// Version of the messages. It is part of every service's name.
const VERSION: &str = "v3";
/// Largest number of unread events of a host. A host that falls behind further loses events and
/// sees a gap in `sequence`.
const EVENT_BUFFER: usize = 1024;
/// Largest number of unread timing batches of a host: about 16 s at 1 kHz.
const TIMING_BUFFER: usize = 256;

/// A station: the name under which its processes meet.
#[derive(Debug, Clone)]
pub struct Station {
    name: String,
    config: Config,
    /// Prefix of the names of the station's iceoryx2 files. It contains the uid, because one user
    /// cannot open the files of another. It ends in a dot, which no station's name contains. So it
    /// matches no file of a station with a longer name.
    prefix: String,
    root: PathBuf,
}

impl Station {
    /// The station with this name.
    ///
    /// # Errors
    /// [`ServiceError::StationName`] unless the name is 1 to 40 characters of a-z, A-Z, 0-9, `-`
    /// and `_`; [`ServiceError::Folder`] if the user's folder cannot be used.
    pub fn new(name: &str) -> Result<Self, ServiceError> {
        Self::check_name(name)?;
        let unusable = || ServiceError::StationName(name.to_owned());
        let mut config = Config::default();
        let prefix = format!("calot_{}_{name}.", folder::user());
        config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|_| unusable())?;
        let root = user_folder()?;
        let path = Path::new(root.as_os_str().as_encoded_bytes());
        let path = path.map_err(|_| ServiceError::Folder {
            path: root.clone(),
            problem: "its name is too long, or not plain".to_owned(),
        })?;
        config.global.set_root_path(&path);
        // Each process that joins removes the iceoryx2 resources of dead processes.
        config.global.node.cleanup_dead_nodes_on_creation = true;
        Ok(Self {
            name: name.to_owned(),
            config,
            prefix,
            root,
        })
    }

    /// Checks a station's name without using any file.
    ///
    /// # Errors
    /// [`ServiceError::StationName`] unless it is 1 to 40 characters of a-z, A-Z, 0-9, `-` and `_`.
    pub fn check_name(name: &str) -> Result<(), ServiceError> {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        match !name.is_empty() && name.len() <= 40 && name.chars().all(plain) {
            true => Ok(()),
            false => Err(ServiceError::StationName(name.to_owned())),
        }
    }

    /// The station's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Prefix of the names of the station's iceoryx2 files in /dev/shm.
    #[must_use]
    pub fn file_prefix(&self) -> &str {
        &self.prefix
    }

    fn transport(&self, doing: &'static str, error: &dyn core::fmt::Debug) -> ServiceError {
        let station = self.name.clone();
        let services = self.root.join("services");
        let folders = [StdPath::new(memory::SHARED), services.as_path()];
        let files = folders.map(|it| memory::files(it, &self.prefix));
        if let Some((file, owner)) = files.iter().flatten().find_map(|it| folder::foreign(it)) {
            return ServiceError::Foreign {
                station,
                file,
                owner,
            };
        }
        ServiceError::Transport {
            station,
            doing,
            detail: format!("{error:?}"),
            files: folders
                .map(|it| format!("{}/{}*", it.display(), self.prefix))
                .join(" and "),
        }
    }

    fn topic<T>(
        &self,
        node: &Node<ipc::Service>,
        service: &'static str,
        quality: QualityOfService,
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

    fn commands(
        &self,
        node: &Node<ipc::Service>,
    ) -> Result<Asking<CommandMsg, ReplyMsg>, ServiceError> {
        self.asking(node, "command")
    }

    fn acts(&self, node: &Node<ipc::Service>) -> Result<Asking<ActMsg, ActReply>, ServiceError> {
        self.asking(node, "acts")
    }

    /// A service in which hosts ask and one process answers.
    fn asking<Q, A>(
        &self,
        node: &Node<ipc::Service>,
        service: &'static str,
    ) -> Result<Asking<Q, A>, ServiceError>
    where
        Q: core::fmt::Debug + ZeroCopySend + 'static,
        A: core::fmt::Debug + ZeroCopySend + 'static,
    {
        let name = format!("calot/{service}/{VERSION}");
        let name = name
            .as_str()
            .try_into()
            .map_err(|e| self.transport("naming", &e))?;
        node.service_builder(&name)
            .request_response::<Q, A>()
            .max_servers(1)
            // The station itself asks as well.
            .max_clients(MAX_HOSTS + 1)
            .max_nodes(MAX_HOSTS + 2)
            .max_active_requests_per_client(4)
            .open_or_create()
            .map_err(|error| self.transport("opening a service of requests", &error))
    }

    fn publisher<T>(
        &self,
        node: &Node<ipc::Service>,
        service: &'static str,
        quality: QualityOfService,
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
        quality: QualityOfService,
    ) -> Result<Subscriber<ipc::Service, T, ()>, ServiceError>
    where
        T: core::fmt::Debug + ZeroCopySend + 'static,
    {
        self.topic(node, service, quality)?
            .subscriber_builder()
            .history_request(quality.history)
            .create()
            .map_err(|error| match format!("{error:?}").as_str() {
                "ExceedsMaxSupportedSubscribers" => ServiceError::ManyHosts {
                    station: self.name.clone(),
                    max: quality.readers,
                    what: match service {
                        "inputs" => "recorders",
                        _ => "readers (every display, recorder, link and surgeon counts)",
                    },
                },
                _ => self.transport("subscribing", &error),
            })
    }
}

type Asking<Q, A> =
    iceoryx2::service::port_factory::request_response::PortFactory<ipc::Service, Q, (), A, ()>;

#[derive(Clone, Copy)]
struct QualityOfService {
    buffer: usize,
    history: usize,
    readers: usize,
}

/// For services of which readers need only the newest message. A reader that joins gets that
/// message at once.
const NEWEST: QualityOfService = QualityOfService {
    buffer: 2,
    history: 1,
    readers: MAX_HOSTS,
};
const EVENTS: QualityOfService = QualityOfService {
    buffer: EVENT_BUFFER,
    history: 64,
    readers: MAX_HOSTS,
};
const TIMING: QualityOfService = QualityOfService {
    buffer: TIMING_BUFFER,
    history: 1,
    readers: MAX_HOSTS,
};

/// For `inputs`: a recorder that gets no processor time for 8 s loses nothing at 1 kHz. Only two
/// readers are permitted, because the controller locks memory for each reader's buffer.
const INPUTS: QualityOfService = QualityOfService {
    buffer: 128,
    history: 0,
    readers: 2,
};

#[cfg(test)]
mod tests {
    use super::*;

    fn station(test: &str) -> Station {
        Station::new(&format!("u{}-{test}", std::process::id())).expect("a name")
    }

    #[test]
    fn another_layout_of_a_message_is_another_version() {
        let station = station("version");
        let joining = station.join(&[]).expect("it joins");
        let _other = station
            .topic::<u64>(joining.node(), "state", NEWEST)
            .expect("a topic");
        let _member = joining.finish().expect("a member");
        let message = Controller::open(&station)
            .expect_err("it differs")
            .to_string();
        let words = "': a process of another version runs; end it";
        assert!(message.contains(words), "{message}");
    }

    #[test]
    fn one_host_too_many_is_refused_with_the_number() {
        let station = station("many");
        let _controller = Controller::open(&station).expect("a controller");
        // A recorder counts as a reader, like a display.
        let _recorder = Tap::open(&station).expect("a recorder");
        let hosts: Result<Vec<Host>, _> = (0..MAX_HOSTS).map(|_| Host::open(&station)).collect();
        let message = hosts.expect_err("one is too many").to_string();
        let words =
            "has 8 readers (every display, recorder, link and surgeon counts) already; close one";
        assert!(message.contains(words), "{message}");
    }
}
