//! Ends of the service `acts`: instructors ask, and the station answers.

use core::time::Duration;
use std::time::Instant;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::client::Client;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::ipc;

use super::join::{Member, MemoryNeed};
use super::{ServiceError, Station};
use crate::message::{ActMsg, ActReply};

/// Time within which a station's [`ActDesk`] answers an act.
pub const ACT_PATIENCE: Duration = Duration::from_millis(1500);

/// The station's end: it receives the acts of instructors.
#[derive(Debug)]
pub struct ActDesk {
    acts: Server<ipc::Service, ActMsg, (), ActReply, ()>,
    _member: Member,
}

/// An act that waits for its reply.
#[derive(Debug)]
pub struct ActRequest(ActiveRequest<ipc::Service, ActMsg, (), ActReply, ()>);

impl ActRequest {
    /// The act.
    #[must_use]
    pub fn act(&self) -> ActMsg {
        *self.0.payload()
    }

    /// Answers. If the instructor is gone by now, the answer is dropped.
    pub fn reply(self, outcome: u32) {
        let _ = self.0.send_copy(ActReply { outcome });
    }
}

impl ActDesk {
    /// Begins to receive acts.
    ///
    /// # Errors
    /// [`ServiceError::SecondDesk`] if another process answers instructors, or the error of the
    /// step that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[MemoryNeed::COMMANDS])?;
        let acts = station.acts(joining.node())?.server_builder().create();
        let acts = acts.map_err(|error| match format!("{error:?}").as_str() {
            "ExceedsMaxSupportedServers" => ServiceError::SecondDesk(station.name.clone()),
            _ => station.transport("serving acts", &error),
        })?;
        Ok(Self {
            acts,
            _member: joining.finish()?,
        })
    }

    /// The next act, if any.
    pub fn next_request(&self) -> Option<ActRequest> {
        self.acts.receive().ok().flatten().map(ActRequest)
    }
}

/// An instructor's end.
#[derive(Debug)]
pub struct ActSender {
    station: Station,
    acts: Client<ipc::Service, ActMsg, (), ActReply, ()>,
    _member: Member,
}

impl ActSender {
    /// Joins the station. Its [`ActDesk`] may be opened later.
    ///
    /// # Errors
    /// The `ServiceError` of the step that failed.
    pub fn open(station: &Station) -> Result<Self, ServiceError> {
        let joining = station.join(&[MemoryNeed::COMMANDS])?;
        let acts = station.acts(joining.node())?.client_builder().create();
        Ok(Self {
            acts: acts.map_err(|error| station.transport("creating a client of acts", &error))?,
            station: station.clone(),
            _member: joining.finish()?,
        })
    }

    /// Asks for an act, and waits for the outcome: a constant of [`ActReply`].
    ///
    /// # Errors
    /// [`ServiceError::NoAnswer`] after `patience`, or the error of sending.
    pub fn ask(&self, act: ActMsg, patience: Duration) -> Result<u32, ServiceError> {
        let start = Instant::now();
        let pending = (self.acts.send_copy(act))
            .map_err(|error| self.station.transport("sending an act", &error))?;
        while pending.number_of_server_connections() > 0 && start.elapsed() < patience {
            // `over` is computed before the reply is read: a desk that replies and then closes must
            // not end the loop with its reply unread.
            let over = !pending.is_connected();
            if let Ok(Some(reply)) = pending.receive() {
                return Ok(reply.payload().outcome);
            }
            if over {
                break;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        Err(ServiceError::NoAnswer {
            station: self.station.name.clone(),
            waited_ms: start.elapsed().as_millis(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::ActKind;

    #[test]
    fn act_is_answered_by_the_only_desk_and_times_out_without_a_desk() {
        let name = format!("u{}-acts", std::process::id());
        let station = Station::new(&name).expect("a name");
        let act = ActMsg::of(ActKind::Fog);
        let sender = ActSender::open(&station).expect("a sender");
        let message = sender
            .ask(act, Duration::from_millis(50))
            .expect_err("nobody");
        assert!(
            message.to_string().contains("nobody answered within"),
            "{message}"
        );
        let (ready, is_ready) = std::sync::mpsc::channel();
        let desk = std::thread::spawn({
            move || {
                let desk = ActDesk::open(&station).expect("a desk");
                let second = ActDesk::open(&station).expect_err("a second desk");
                ready.send(second.to_string()).expect("the test waits");
                loop {
                    if let Some(request) = desk.next_request() {
                        let act = request.act();
                        request.reply(ActReply::EXAM);
                        return act;
                    }
                    std::thread::sleep(Duration::from_millis(1));
                }
            }
        });
        let second = is_ready.recv().expect("a desk");
        assert!(
            second.contains("answers its instructors; end it first"),
            "{second}"
        );
        let patience = Duration::from_secs(20);
        assert_eq!(sender.ask(act, patience).ok(), Some(ActReply::EXAM));
        assert_eq!(desk.join().ok(), Some(act));
    }
}
