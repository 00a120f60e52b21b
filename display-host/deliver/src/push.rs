//! A push: first the centre forgets whom the store forgot, then it gets the results that it lacks.

use std::collections::BTreeSet;

use serde::Serialize;
use store::{Delivery, Outgoing, Store};

use crate::address::{Destination, Kind};
use crate::centre::{Centre, Receipt};
use crate::database::Database;
use crate::error::DeliverError;
use crate::xapi::Records;

/// Number of sessions whose outcomes are noted together. After a program has died, at most so many
/// are sent again.
const PART: usize = 32;

/// Result of a push.
#[derive(Debug, Default, Serialize)]
pub struct Pushed {
    /// Address of the centre, without user and password.
    pub to: String,
    /// Sessions that arrived.
    pub sent: u64,
    /// Sessions that the centre had already.
    pub known: u64,
    /// Sessions that the centre has with other contents, which it keeps.
    pub differing: Vec<String>,
    /// Sessions that this kind of centre does not take: a record store takes none of a scripted
    /// hand.
    pub left_out: u64,
    /// Trainees who are here and were forgotten at the centre after their sessions began.
    pub forgotten_there: BTreeSet<String>,
    /// Forgotten people whom the centre has forgotten now.
    pub withdrawn: u64,
    /// Sessions that the centre refuses.
    pub refused: Vec<Refusal>,
    /// Sessions, and forgotten people, that wait in the store.
    pub waiting: u64,
    /// Other addresses that still have to forget somebody. One may be another spelling of this
    /// centre.
    pub owed_elsewhere: Vec<String>,
    /// Reason for which the push ended early.
    pub problem: Option<String>,
}

/// A session that a centre refuses.
#[derive(Debug, Serialize)]
pub struct Refusal {
    /// Id of the session.
    pub session: String,
    /// Answer of the centre.
    pub problem: String,
}

/// Delivers the results that a centre lacks, and makes it forget whom the store forgot. Results
/// that do not arrive wait in the store; the outcome gives their number and the reason.
///
/// # Errors
/// [`DeliverError::Store`], when the store cannot be read or written.
pub fn push(store: &mut Store, to: &Destination) -> Result<Pushed, DeliverError> {
    store.respell(&to.spelled, to.name())?;
    let destination = store.destination(to.name())?;
    let mut pushed = Pushed {
        to: to.name().to_owned(),
        ..Pushed::default()
    };
    let ended = connect(to).and_then(|mut centre| {
        let centre = centre.as_mut();
        withdraw(store, destination, centre, &mut pushed)?;
        for part in store.outgoing(destination)?.chunks(PART) {
            deliver(store, destination, centre, part, &mut pushed)?;
        }
        // Somebody may have been forgotten in the meantime.
        withdraw(store, destination, centre, &mut pushed)
    });
    match ended {
        Err(DeliverError::Store(error)) => return Err(error.into()),
        Err(error) => pushed.problem = Some(error.to_string()),
        Ok(()) => {}
    }
    let waiting = store.outgoing(destination)?.len() + store.withdrawals(destination)?.len();
    pushed.waiting = waiting as u64;
    pushed.owed_elsewhere = store.owed()?;
    pushed.owed_elsewhere.retain(|it| it != to.name());
    Ok(pushed)
}

fn connect(to: &Destination) -> Result<Box<dyn Centre>, DeliverError> {
    Ok(match &to.kind {
        Kind::Database(config) => Box::new(Database::connect(to, config)?),
        Kind::Records(key) => Box::new(Records::connect(to, key)?),
    })
}

fn withdraw(
    store: &mut Store,
    destination: i64,
    centre: &mut dyn Centre,
    pushed: &mut Pushed,
) -> Result<(), DeliverError> {
    for it in store.withdrawals(destination)? {
        centre.forget(&it)?;
        store.note_withdrawn(destination, &it)?;
        pushed.withdrawn += 1;
    }
    Ok(())
}

/// Delivers sessions and notes their outcomes together, including those before one that failed.
fn deliver(
    store: &mut Store,
    destination: i64,
    centre: &mut dyn Centre,
    part: &[Outgoing],
    pushed: &mut Pushed,
) -> Result<(), DeliverError> {
    let mut notes = Vec::new();
    let mut failed = Ok(());
    for it in part {
        let id = it.session.id.as_str();
        match centre.deliver(it) {
            Ok(receipt) => notes.push((it, count(pushed, it, receipt))),
            Err(DeliverError::Rejected { problem, .. }) => pushed.refused.push(Refusal {
                session: id.to_owned(),
                problem,
            }),
            Err(error) => {
                failed = Err(error);
                break;
            }
        }
    }
    let lost = store.note_deliveries(destination, &notes)?;
    for it in part.iter().filter(|it| lost.contains(&it.session.id)) {
        let session = &it.session;
        store.withdraw(destination, &it.person, &session.id, session.began_unix_s)?;
    }
    failed
}

/// Counts a receipt, and says what to note.
fn count(pushed: &mut Pushed, it: &Outgoing, receipt: Receipt) -> Delivery {
    match receipt {
        Receipt::New => {
            pushed.sent += 1;
            Delivery::There
        }
        Receipt::Known => {
            pushed.known += 1;
            Delivery::There
        }
        Receipt::Differs => {
            pushed.differing.push(it.session.id.clone());
            Delivery::Differs
        }
        Receipt::Forgotten => {
            pushed.forgotten_there.insert(it.name.clone());
            Delivery::Forgotten
        }
        Receipt::LeftOut => {
            pushed.left_out += 1;
            Delivery::LeftOut
        }
    }
}
