//! Sends results from a station's store to the centre's. A result waits in the station's store
//! until a note there says that it arrived, so a station that is offline for weeks loses nothing.

use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use store::{Delivery, Outgoing, Store, Withdrawal};
use zenoh::Session;

use crate::error::CentreError;
use crate::log::now_ms;
use crate::topic::Topic;

/// Longest wait for the centre's answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// Message of a station.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Sent {
    /// A session with its person.
    Session(Box<Outgoing>),
    /// A person to be forgotten.
    Forget(Withdrawal),
}

/// Puts a received result into the centre's store. The answer says what became of it.
pub fn take(store: &Path, sent: &[u8]) -> Value {
    let sent: Sent = match serde_json::from_slice(sent) {
        Ok(sent) => sent,
        Err(error) => return json!({"problem": error.to_string()}),
    };
    let taken = Store::open(store).and_then(|mut store| match &sent {
        Sent::Session(it) => store.receive(it),
        Sent::Forget(it) => {
            let now_s = i64::try_from(now_ms() / 1000).unwrap_or(i64::MAX);
            store.forget_person(it, now_s).map(|()| Delivery::There)
        }
    });
    match (taken, sent) {
        (Ok(fate), Sent::Session(it)) => json!({"session": it.session.id, "fate": fate}),
        (Ok(fate), Sent::Forget(it)) => json!({"forgotten": it.person, "fate": fate}),
        (Err(error), _) => json!({"problem": error.to_string()}),
    }
}

/// Sends the results that the centre lacks. Returns how many arrived.
///
/// # Errors
/// If the store cannot be read, or the centre does not answer.
pub async fn send(store: &Path, session: &Session, own: &str) -> Result<usize, CentreError> {
    if !store.is_file() {
        return Ok(0);
    }
    let mut store = Store::open(store)?;
    let destination = store.destination(&format!("calot-centre/{own}"))?;
    let mut arrived = 0;
    for errand in store.withdrawals(destination)? {
        ask(session, own, &Sent::Forget(errand.clone())).await?;
        store.note_withdrawn(destination, &errand)?;
        arrived += 1;
    }
    for it in store.outgoing(destination)? {
        let mut bare = it.clone();
        // The path of a recording names a user of the station.
        bare.session.file = None;
        let fate = ask(session, own, &Sent::Session(Box::new(bare))).await?;
        let lost = store.note_deliveries(destination, &[(&it, fate)])?;
        for id in lost {
            store.withdraw(destination, &it.person, &id, it.session.began_unix_s)?;
        }
        arrived += 1;
    }
    Ok(arrived)
}

async fn ask(session: &Session, own: &str, sent: &Sent) -> Result<Delivery, CentreError> {
    let failed = |problem: String| CentreError::Network {
        doing: "sending a result",
        problem,
    };
    let text = serde_json::to_string(sent).map_err(|error| failed(error.to_string()))?;
    let asked = session.get(Topic::Result.of(own)).payload(text);
    let replies = asked.timeout(PATIENCE).await;
    let replies = replies.map_err(|error| failed(error.to_string()))?;
    let reply = replies.recv_async().await;
    let reply = reply.map_err(|_| failed("the centre does not answer".to_owned()))?;
    let answer = reply
        .result()
        .map(|it| it.payload().to_bytes().into_owned());
    let answer = answer.map_err(|_| failed("the centre does not answer".to_owned()))?;
    let answer: Value =
        serde_json::from_slice(&answer).map_err(|error| failed(error.to_string()))?;
    let fate = serde_json::from_value(answer["fate"].clone());
    fate.map_err(|_| failed(format!("the centre says {answer}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_store_that_is_none_is_told_in_its_own_words() {
        let folder = tempfile::tempdir().unwrap();
        let error = CentreError::from(Store::open(folder.path()).unwrap_err());
        assert!(matches!(error, CentreError::Store(_)));
        assert!(error.to_string().contains("Is a directory"), "{error}");
    }

    #[test]
    fn nonsense_is_answered_and_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("store.sqlite");
        let answer = take(&store, b"nonsense");
        assert!(answer["problem"].as_str().is_some(), "{answer}");
        assert!(!store.exists());
        let forget = Sent::Forget(Withdrawal {
            person: store::person_id("Ada"),
            at_unix_s: 5,
            sessions: Vec::new(),
        });
        let answer = take(&store, &serde_json::to_vec(&forget).unwrap());
        assert_eq!(answer["fate"], "there");
    }
}
