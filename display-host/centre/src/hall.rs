//! The centre's end of the network: takes what stations send, and asks them for pictures and acts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};
use tokio::sync::RwLock;
use zenoh::Session;
use zenoh::sample::SampleKind;

use crate::board::Board;
use crate::error::{CentreError, network};
use crate::keys::Keys;
use crate::log::{ALARM, Log};
use crate::results;
use crate::roster::Roster;
use crate::state::State;
use crate::topic::Topic;

/// Interval at which the centre repeats to stations which pictures it wants. A station forgets such
/// a request after a while.
const WANT_EVERY: Duration = Duration::from_millis(500);
/// Interval between two looks at the list of stations.
const LIST_EVERY: Duration = Duration::from_secs(1);
/// Longest wait for a station's answer to an act.
const ACT_PATIENCE: Duration = Duration::from_secs(4);
/// Pictures a second of a tile, and of an enlarged station.
const TILE_HZ: f64 = 2.0;
const VIEW_HZ: f64 = 30.0;

/// The centre, for all its tasks.
#[derive(Debug)]
pub struct Hall {
    /// The stations as the centre knows them.
    pub board: Board,
    /// Rights of stations and instructors.
    pub roster: RwLock<Roster>,
    /// The log.
    pub log: Log,
    /// File of the store.
    pub store: PathBuf,
    /// File of the list.
    pub list: PathBuf,
    /// Address for stations.
    pub address: String,
    /// Keys of the centre.
    pub keys: Keys,
    session: RwLock<Option<Session>>,
}

impl Hall {
    /// Opens the centre for the stations of its list.
    ///
    /// # Errors
    /// If the list or the address is wrong.
    pub async fn open(
        list: PathBuf,
        store: PathBuf,
        log: &Path,
        address: String,
        keys: Keys,
    ) -> Result<Arc<Self>, CentreError> {
        let roster = Roster::read(&list)?;
        let known = Log::alarms(log);
        let log = Log::open(log)?;
        let hall = Arc::new(Self {
            board: Board::default(),
            roster: RwLock::new(Roster::default()),
            log,
            store,
            list,
            address,
            keys,
            session: RwLock::new(None),
        });
        hall.board.set_stations(roster.stations.values());
        for (station, alarm) in known {
            hall.board.remember(&station, alarm);
        }
        hall.clone().admit(roster).await?;
        tokio::spawn(hall.clone().want());
        tokio::spawn(hall.clone().follow_list());
        Ok(hall)
    }

    /// Adopts a list. Rights are checked when a connection begins, so all connections are cut and
    /// made anew.
    async fn admit(self: Arc<Self>, roster: Roster) -> Result<(), CentreError> {
        let mut session = self.session.write().await;
        if let Some(old) = session.take() {
            let _ = old.close().await;
        }
        let mut names: Vec<&String> = roster.stations.values().collect();
        names.sort();
        self.board.set_stations(names.iter().copied());
        // Stations that are still there announce themselves again.
        for name in names {
            self.board.set_present(name, false);
        }
        let new = crate::network::listen(&self.address, &self.keys, &roster).await?;
        for (certificate, name) in &roster.stations {
            self.clone().hear(&new, certificate, name).await?;
        }
        *session = Some(new);
        *self.roster.write().await = roster;
        Ok(())
    }

    /// Takes everything that one station sends.
    async fn hear(
        self: Arc<Self>,
        session: &Session,
        certificate: &str,
        name: &str,
    ) -> Result<(), CentreError> {
        let hearing = || network("listening to a station");
        let (hall, name_) = (self.clone(), name.to_owned());
        let presence = session.liveliness();
        let presence = presence.declare_subscriber(Topic::Presence.of(certificate));
        presence
            .history(true)
            .callback(move |sample| {
                let present = sample.kind() == SampleKind::Put;
                if hall.board.set_present(&name_, present) {
                    let what = if present { "came" } else { "went" };
                    hall.log.note(what, "", &name_, &Value::Null);
                    hall.board.asked.notify_one();
                }
            })
            .background()
            .await
            .map_err(hearing())?;
        for topic in [Topic::State, Topic::Tile, Topic::View] {
            let (hall, name) = (self.clone(), name.to_owned());
            session
                .declare_subscriber(topic.of(certificate))
                .callback(move |sample| {
                    let bytes = sample.payload().to_bytes();
                    hall.take(topic, &name, &bytes);
                })
                .background()
                .await
                .map_err(hearing())?;
        }
        let (hall, name) = (self.clone(), name.to_owned());
        let results = session
            .declare_queryable(Topic::Result.of(certificate))
            .await
            .map_err(hearing())?;
        tokio::spawn(async move {
            while let Ok(query) = results.recv_async().await {
                let asked = query.payload().map(|it| it.to_bytes().into_owned());
                let (store, name) = (hall.store.clone(), name.clone());
                let taking = move || results::take(&store, &asked.unwrap_or_default());
                let answer = tokio::task::spawn_blocking(taking).await;
                let answer = answer.unwrap_or_else(|error| json!({"problem": error.to_string()}));
                hall.log.note("result", "", &name, &answer);
                let key = query.key_expr().clone();
                let _ = query.reply(key, answer.to_string()).await;
            }
        });
        Ok(())
    }

    fn take(&self, topic: Topic, name: &str, bytes: &[u8]) {
        if topic != Topic::State {
            self.board.take_picture(name, topic == Topic::View, bytes);
            return;
        }
        let Some(state) = State::parse(bytes) else {
            return;
        };
        for it in self.board.take_state(name, state) {
            let detail = serde_json::to_value(&it).unwrap_or_default();
            self.log.note(ALARM, "", name, &detail);
        }
    }

    /// Tells stations which pictures somebody watches.
    async fn want(self: Arc<Self>) {
        loop {
            tokio::select! {
                () = self.board.asked.notified() => {}
                () = tokio::time::sleep(WANT_EVERY) => {}
            }
            let stations: BTreeMap<String, String> = self.roster.read().await.stations.clone();
            let session = self.session.read().await.clone();
            let Some(session) = session else { continue };
            for (certificate, name) in &stations {
                let (tiles, large) = self.board.watched(name);
                let rate = |viewers: usize, hz: f64| if viewers > 0 { hz } else { 0.0 };
                let wanted =
                    json!({"tile_hz": rate(tiles, TILE_HZ), "view_hz": rate(large, VIEW_HZ)});
                let _ = session
                    .put(Topic::Want.of(certificate), wanted.to_string())
                    .await;
            }
        }
    }

    /// Adopts a changed list while the centre runs. A name that is no longer on it loses its
    /// rights.
    async fn follow_list(self: Arc<Self>) {
        let changed = |path: &PathBuf| std::fs::metadata(path).and_then(|it| it.modified()).ok();
        let mut known = changed(&self.list);
        loop {
            tokio::time::sleep(LIST_EVERY).await;
            let now = changed(&self.list);
            if now == known || now.is_none() {
                continue;
            }
            known = now;
            let taken = match Roster::read(&self.list) {
                Ok(roster) => self.take_list(roster).await,
                Err(error) => {
                    eprintln!("calot-centre: the list is not taken: {error}");
                    continue;
                }
            };
            match taken {
                Ok(()) => self.log.note("list", "", "", &Value::Null),
                Err(error) => {
                    eprintln!("calot-centre: the list is tried again: {error}");
                    known = None;
                }
            }
        }
    }

    /// Adopts a changed list. Connections are cut only if the list names other stations.
    async fn take_list(self: &Arc<Self>, new: Roster) -> Result<(), CentreError> {
        let is_open = self.session.read().await.is_some();
        let mut roster = self.roster.write().await;
        if is_open && roster.stations == new.stations {
            *roster = new;
            return Ok(());
        }
        drop(roster);
        self.clone().admit(new).await
    }

    /// Asks a station to take an instructor's remark. The answer is `done`, or the reason of a
    /// refusal.
    pub async fn remark(&self, who: &str, station: &str, text: &str) -> String {
        let roster = self.roster.read().await;
        let found = roster.stations.iter().find(|(_, name)| *name == station);
        let certificate = found.map(|(certificate, _)| certificate.clone());
        drop(roster);
        let session = self.session.read().await.clone();
        let (Some(certificate), Some(session)) = (certificate, session) else {
            return "there is no such station".to_owned();
        };
        let act = json!({"remark": text}).to_string();
        let asked = session.get(Topic::Act.of(&certificate)).payload(act);
        let answer = match asked.timeout(ACT_PATIENCE).await {
            Ok(replies) => match replies.recv_async().await {
                Ok(reply) => reply
                    .result()
                    .ok()
                    .and_then(|it| outcome(&it.payload().to_bytes())),
                Err(_) => None,
            },
            Err(_) => None,
        };
        let answer = answer.unwrap_or_else(|| "the station does not answer".to_owned());
        let detail = json!({"text": text, "answer": answer});
        self.log.note("remark", who, station, &detail);
        answer
    }
}

fn outcome(answer: &[u8]) -> Option<String> {
    let answer: Value = serde_json::from_slice(answer).ok()?;
    let outcome = answer["outcome"].as_str()?;
    Some(
        outcome
            .chars()
            .filter(|it| !it.is_control())
            .take(200)
            .collect(),
    )
}
