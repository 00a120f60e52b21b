//! Commands to the controller.

use core::time::Duration;
use std::time::Instant;

use iceoryx2::port::client::Client;
use iceoryx2::prelude::ipc;

use super::join::{Member, MemoryNeed};
use super::{ServiceError, Station};
use crate::message::{CommandMsg, ReplyMsg};

/// Sends a command to the controller and waits for the reply.
pub(super) fn command_through(
    commands: &Client<ipc::Service, CommandMsg, (), ReplyMsg, ()>,
    station: &Station,
    command: CommandMsg,
    patience: Duration,
) -> Result<ReplyMsg, ServiceError> {
    let start = Instant::now();
    while start.elapsed() < patience {
        // The command is sent again while no controller is connected, so that a controller that
        // starts meanwhile gets it.
        let pending = commands
            .send_copy(command)
            .map_err(|error| station.transport("sending a command", &error))?;
        let connected = pending.number_of_server_connections() > 0;
        loop {
            // `over` is computed before the reply is read: a controller that replies and then
            // disconnects must not end the loop with its reply unread.
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
        station: station.name.clone(),
        waited_ms,
    })
}

/// End of a process that only commands the controller.
#[derive(Debug)]
pub struct Commander {
    station: Station,
    commands: Client<ipc::Service, CommandMsg, (), ReplyMsg, ()>,
    _member: Member,
}

impl Commander {
    /// Joins a station. Its controller may start later.
    ///
    /// # Errors
    /// The `ServiceError` of the step that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[MemoryNeed::COMMANDS])?;
        let commands = station.commands(joining.node())?.client_builder().create();
        Ok(Self {
            commands: commands
                .map_err(|error| station.transport("creating a command client", &error))?,
            station: station.clone(),
            _member: joining.finish()?,
        })
    }

    /// Sends a command to the controller and waits for the reply.
    ///
    /// # Errors
    /// [`ServiceError::NoAnswer`] after `patience`, or the error of sending.
    pub fn command(
        &self,
        command: CommandMsg,
        patience: Duration,
    ) -> Result<ReplyMsg, ServiceError> {
        command_through(&self.commands, &self.station, command, patience)
    }
}
