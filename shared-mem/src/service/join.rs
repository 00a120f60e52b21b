//! Joining a station and leaving it. An end is a process's set of open ports of a station
//! (`Controller`, `Host`, ...). The first end that joins removes the files that crashed processes
//! left. The last end that leaves removes all files of the station. Each end allocates all its
//! shared memory when it joins.

use std::path::Path;

use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::prelude::{LogLevel, SignalHandlingMode, ipc, set_log_level};

use super::memory::{self, MemoryError, Reservation};
use super::presence::{self, HeldName, Presence};
use super::{MAX_LOANS, QualityOfService, ServiceError, Station, folder};

/// Upper bound for the size of the files that iceoryx2 keeps for one service and one node, bytes.
/// The test `a_station_reserves_the_memory_that_it_uses` checks it.
const SERVICE_BYTES: u64 = 64 << 10;
/// Bytes of a connection between a publisher and a reader, without its queues and flags.
const CONNECTION_BYTES: u64 = 8 << 10;
/// Bytes of a sample's header.
const HEADER_BYTES: usize = 64;

/// Shared memory that an end needs for one service, bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct MemoryNeed(u64);

impl MemoryNeed {
    /// Upper bound for the command service, whose requests and replies are small.
    pub(super) const COMMANDS: Self = Self(512 << 10);

    pub(super) const fn bytes(self) -> u64 {
        self.0
    }

    /// A publisher needs memory for its samples and for the connections to all readers.
    pub(super) const fn publisher<T>(quality: QualityOfService) -> Self {
        let samples = Self::samples(quality) * (size_of::<T>() + HEADER_BYTES);
        let readers = quality.readers as u64;
        Self(samples as u64 + SERVICE_BYTES + readers * Self::connection(quality))
    }

    /// A reader needs memory for its connection, and for the files of the service, because it may
    /// be the first that opens the service.
    pub(super) const fn subscriber(quality: QualityOfService) -> Self {
        Self(SERVICE_BYTES + Self::connection(quality))
    }

    /// Number of samples that iceoryx2 allocates for a publisher.
    const fn samples(quality: QualityOfService) -> usize {
        quality.readers * (quality.buffer + 2) + quality.history + MAX_LOANS
    }

    /// Bytes of a connection: two queues of sample numbers, and a flag for every sample.
    const fn connection(quality: QualityOfService) -> u64 {
        let queues = 2 * (quality.buffer + MAX_LOANS + 4) * 8;
        CONNECTION_BYTES + (queues + Self::samples(quality)) as u64
    }
}

/// Exclusive claim to the name of a running station. It has no effect where abstract sockets do not
/// work. It needs no file, and the kernel releases it when the process ends.
#[derive(Debug)]
pub struct Claim {
    _held: Option<HeldName>,
}

/// An end that is joining: the memory for its ports was free. While it holds the turn (a lock), no
/// other end of the station joins or leaves. It has no turn if abstract sockets do not work or the
/// wait for the turn was too long.
pub(super) struct Joining<'a> {
    station: &'a Station,
    /// Dropped before `presence`, because leaving needs the turn.
    turn: Option<HeldName>,
    node: Node<ipc::Service>,
    presence: Leaving,
}

/// Membership of an end in a station. It is the last field of each end, so that it is dropped after
/// the end's iceoryx2 ports.
#[derive(Debug)]
pub(super) struct Member {
    /// Held name that shows that the end's services are open. It is dropped before the node, so
    /// that a process that sees this name also finds the node's files.
    _open: Option<HeldName>,
    node: Node<ipc::Service>,
    _presence: Leaving,
}

/// Presence of an end. Dropping it removes the station's files if no other end is present.
#[derive(Debug)]
struct Leaving {
    presence: Presence,
    station: Station,
}

impl Drop for Leaving {
    fn drop(&mut self) {
        let station = &self.station;
        self.presence
            .leave(|| memory::remove_files(&station.root, &station.prefix));
    }
}

impl Station {
    /// Stem of the names of the station's abstract sockets.
    fn base(&self) -> String {
        format!("calot-{}-{}", folder::user(), self.name)
    }

    /// Takes the station's name for the process that runs the station. If another process holds the
    /// name, `who` describes that process for the error. Its argument is the inode of the socket
    /// that holds the name, if the kernel reports one.
    ///
    /// # Errors
    /// [`ServiceError::RunsAlready`] if another process holds the name.
    pub fn claim(&self, who: impl FnOnce(Option<u64>) -> String) -> Result<Claim, ServiceError> {
        match HeldName::take(self.base()) {
            Ok(None) => Err(ServiceError::RunsAlready {
                station: self.name.clone(),
                by: who(presence::inode(&self.base())),
            }),
            Ok(Some(held)) => Ok(Claim { _held: Some(held) }),
            // Abstract sockets do not work here. Only the lock file in the user's folder shows that
            // the station runs.
            Err(_) => Ok(Claim { _held: None }),
        }
    }

    /// True if a process holds the station's name, even if its files are in another folder.
    #[must_use]
    pub fn is_claimed(&self) -> bool {
        let base = self.base();
        presence::held(&base).is_some_and(|names| names.contains(&base))
    }

    /// Joins the station. `needs` lists the shared memory that the end's services need.
    pub(super) fn join(&self, needs: &[MemoryNeed]) -> Result<Joining<'_>, ServiceError> {
        // At a lower level, iceoryx2 prints a page of warnings for each process that was killed.
        set_log_level(LogLevel::Error);
        let base = self.base();
        let turn = presence::turn(&base);
        let leaving = Leaving {
            presence: Presence::enter(&base),
            station: self.clone(),
        };
        if turn.is_some() && leaving.presence.is_alone() {
            leaving.presence.remove_dead();
            memory::remove_files(&self.root, &self.prefix);
        }
        let node = self
            .check_files(&leaving.presence)
            .and_then(|()| self.room_for(needs))
            .and_then(|()| self.node());
        match node {
            Ok(node) => Ok(Joining {
                station: self,
                turn,
                node,
                presence: leaving,
            }),
            Err(error) => {
                drop(turn);
                Err(error)
            }
        }
    }

    /// Checks that the memory is free: reserves it and frees it again. An end that holds the turn
    /// then allocates the memory before another end of the station can take it.
    pub(super) fn room_for(&self, needs: &[MemoryNeed]) -> Result<(), ServiceError> {
        let sizes: Vec<u64> = needs.iter().map(|need| need.bytes()).collect();
        let reserved: Result<Reservation, _> = memory::reserve(&self.prefix, &sizes);
        reserved.map(drop).map_err(|error| self.memory_error(error))
    }

    /// Refuses a station that other processes have open but whose files this process does not find.
    fn check_files(&self, presence: &Presence) -> Result<(), ServiceError> {
        let are_in = |folder: &Path| !memory::files(folder, &self.prefix).is_empty();
        let shared = Path::new(memory::SHARED);
        let is_there = || are_in(shared) && are_in(&self.root.join("services"));
        if presence.open_processes().is_empty() || is_there() {
            return Ok(());
        }
        // The last member may have left between the two checks, so both are repeated.
        let processes = presence.open_processes();
        if processes.is_empty() || is_there() {
            return Ok(());
        }
        let (place, why) = match are_in(shared) {
            false => (
                memory::SHARED.to_owned(),
                "either logind's RemoveIPC (at a log-out) or a clean-up removed them: restart the \
                 station. Or this process sees another /dev/shm (a container): run it where the \
                 station runs",
            ),
            true => (
                self.root.display().to_string(),
                "either it was started with another TMPDIR: give this program the same one. Or a \
                 clean-up (systemd-tmpfiles) removed them: restart the station",
            ),
        };
        let processes: Vec<String> = processes.iter().map(u32::to_string).collect();
        Err(ServiceError::Gone {
            station: self.name.clone(),
            processes: processes.join(", "),
            place,
            why,
        })
    }

    fn node(&self) -> Result<Node<ipc::Service>, ServiceError> {
        NodeBuilder::new()
            .config(&self.config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| self.transport("joining", &error))
            .inspect(|_| self.close_to_others())
    }

    /// Removes the access of other users. iceoryx2 gives the user's group access to the folder, and
    /// everybody access to some of its files in /dev/shm.
    fn close_to_others(&self) {
        memory::files(Path::new(memory::SHARED), &self.prefix)
            .iter()
            .chain([&self.root])
            .for_each(|path| folder::close(path));
    }

    fn memory_error(&self, error: MemoryError) -> ServiceError {
        let station = self.name.clone();
        match error {
            MemoryError::Room { need, free } => ServiceError::NoRoom {
                station,
                need,
                free,
            },
            MemoryError::FileSize { need, limit } => ServiceError::FileSize {
                station,
                need,
                limit,
            },
            MemoryError::Folder(problem) => ServiceError::SharedMemory { station, problem },
        }
    }
}

impl Joining<'_> {
    /// The node that the ports belong to.
    pub(super) fn node(&self) -> &Node<ipc::Service> {
        &self.node
    }

    /// Allocates all pages of the station's files, shows that the services are open, and releases
    /// the turn.
    pub(super) fn finish(self) -> Result<Member, ServiceError> {
        let Self {
            station,
            turn,
            node,
            presence,
        } = self;
        let filled = memory::fill(&station.prefix).map_err(|error| station.memory_error(error));
        let open = presence.presence.show_open();
        drop(turn);
        if let Err(error) = filled {
            drop((open, node));
            return Err(error);
        }
        Ok(Member {
            _open: open,
            node,
            _presence: presence,
        })
    }
}

impl Member {
    /// Removes the iceoryx2 resources of processes that died.
    pub(super) fn forget_dead(&self) {
        self.node.try_cleanup_dead_nodes();
    }
}
