//! A station's end: starts `calot tell`, sends its frames to the centre, and passes the centre's
//! requests on to it.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::path::PathBuf;
use std::time::Duration;

use serde_json::{Value, json};
use tokio::process::{Child, ChildStdin, ChildStdout};
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::mpsc;
use tokio::time::{Instant, interval, sleep};
use zenoh::Session;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::Query;

use crate::error::{CentreError, network};
use crate::frame::{Kind, read};
use crate::keys::Keys;
use crate::results;
use crate::teller::{self, write};
use crate::topic::Topic;

/// Wait before the next try to reach the centre.
const AGAIN: Duration = Duration::from_secs(2);
/// Time after which a request for pictures is forgotten, unless it is repeated.
const WISH_HOLDS: Duration = Duration::from_secs(3);
/// Interval at which results that wait are sent.
const RESULTS_EVERY: Duration = Duration::from_secs(20);
/// Longest wait for the last results when the station ends.
const LAST_RESULTS: Duration = Duration::from_secs(10);

/// A station that joins a centre.
#[derive(Debug, Clone)]
pub struct Member {
    /// Name of the station on this computer.
    pub station: String,
    /// Name that the trainee chose.
    pub trainee: Option<String>,
    /// Address of the centre.
    pub address: String,
    /// Keys; the certificate's name is the station's name at the centre.
    pub keys: Keys,
    /// Store whose results go to the centre.
    pub store: Option<PathBuf>,
    /// The program `calot`.
    pub program: PathBuf,
}

/// Something that the loop waits for.
enum News {
    Frame(Kind, Vec<u8>),
    Over(Option<CentreError>),
    Want(Vec<u8>),
    Act(Query),
}

/// Publishers of a station.
struct Line<'a> {
    state: Publisher<'a>,
    tile: Publisher<'a>,
    view: Publisher<'a>,
}

impl Member {
    /// Reports the station to the centre until the station ends, or this process is asked to end.
    ///
    /// # Errors
    /// When `calot tell` does not start, or sends invalid frames.
    pub async fn run(&self) -> Result<(), CentreError> {
        let stop = signal(SignalKind::terminate());
        let mut stop = stop.map_err(|error| CentreError::Network {
            doing: "waiting to be ended",
            problem: error.to_string(),
        })?;
        let session = tokio::select! {
            session = self.reach() => session,
            _ = stop.recv() => return Ok(()),
        };
        let token = session.liveliness();
        let token = token.declare_token(Topic::Presence.of(&self.keys.name));
        let _token = token
            .await
            .map_err(network("telling that the station is here"))?;
        let mut child = teller::start(&self.program, &self.station, self.trainee.as_deref())?;
        let told = tokio::select! {
            told = self.tell(&session, &mut child) => told,
            never = self.deliver(&session) => match never {},
            _ = stop.recv() => Ok(()),
        };
        let _ = child.start_kill();
        if let Some(store) = &self.store {
            let last = results::send(store, &session, &self.keys.name);
            match tokio::time::timeout(LAST_RESULTS, last).await {
                Ok(Ok(_)) => {}
                Ok(Err(error)) => eprintln!("calot-centre: results wait in the store: {error}"),
                Err(_) => eprintln!("calot-centre: results wait in the store: no answer in time"),
            }
        }
        let _ = session.close().await;
        told
    }

    /// Sends waiting results at intervals, while reports go on. Results that do not arrive wait in
    /// the store.
    async fn deliver(&self, session: &Session) -> Infallible {
        let Some(store) = &self.store else {
            return std::future::pending().await;
        };
        let mut sends = interval(RESULTS_EVERY);
        loop {
            sends.tick().await;
            let _ = results::send(store, session, &self.keys.name).await;
        }
    }

    /// Tries until the centre is reached. Prints the reason of a failure once.
    async fn reach(&self) -> Session {
        let mut said = false;
        loop {
            match crate::network::join(&self.address, &self.keys).await {
                Ok(session) => {
                    if said {
                        eprintln!("calot-centre: the centre is reached now");
                    }
                    return session;
                }
                Err(error) if !said => {
                    eprintln!("calot-centre: {error}; trying again, the station goes on");
                    said = true;
                }
                Err(_) => {}
            }
            sleep(AGAIN).await;
        }
    }

    async fn tell(&self, session: &Session, child: &mut Child) -> Result<(), CentreError> {
        let (Some(output), Some(mut input)) = (child.stdout.take(), child.stdin.take()) else {
            return Ok(());
        };
        let name = &self.keys.name;
        let publish = async |topic: Topic, priority| {
            let publisher = session.declare_publisher(topic.of(name));
            let publisher = publisher.congestion_control(CongestionControl::Drop);
            let publisher = publisher.priority(priority).express(true).await;
            publisher.map_err(network("offering what the station tells"))
        };
        // A dropped state does no harm, because the next one replaces it. Pictures give way to
        // states.
        let line = Line {
            state: publish(Topic::State, Priority::InteractiveHigh).await?,
            tile: publish(Topic::Tile, Priority::DataLow).await?,
            view: publish(Topic::View, Priority::Background).await?,
        };
        let (news, mut heard) = mpsc::channel(16);
        tokio::spawn(frames(output, news.clone()));
        self.listen(session, news).await?;
        let mut wish = Instant::now();
        let mut asked: BTreeMap<u64, Query> = BTreeMap::new();
        let (mut number, mut looks) = (0, interval(Duration::from_secs(1)));
        loop {
            tokio::select! {
                it = heard.recv() => match it {
                    Some(News::Frame(Kind::Answer, body)) => answer(&mut asked, &body).await,
                    Some(News::Frame(kind, body)) => line.put(kind, body).await,
                    Some(News::Want(wanted)) => {
                        wish = Instant::now();
                        write(&mut input, &wanted).await;
                    }
                    Some(News::Act(query)) => {
                        number += 1;
                        hand_over(&mut input, number, &query).await;
                        asked.insert(number, query);
                        // Acts that nobody answers are given up.
                        asked.retain(|id, _| id + 64 > number);
                    }
                    Some(News::Over(Some(error))) => return Err(error),
                    Some(News::Over(None)) | None => return Ok(()),
                },
                _ = looks.tick() => {
                    if wish.elapsed() > WISH_HOLDS {
                        write(&mut input, b"{\"tile_hz\":0,\"view_hz\":0}").await;
                    }
                }
            }
        }
    }

    /// Receives requests of the centre.
    async fn listen(&self, session: &Session, news: mpsc::Sender<News>) -> Result<(), CentreError> {
        let failed = || network("listening to the centre");
        let name = &self.keys.name;
        let wants = session.declare_subscriber(Topic::Want.of(name)).await;
        let wants = wants.map_err(failed())?;
        let acts = session.declare_queryable(Topic::Act.of(name)).await;
        let acts = acts.map_err(failed())?;
        let to = news.clone();
        tokio::spawn(async move {
            while let Ok(sample) = wants.recv_async().await {
                let wanted = sample.payload().to_bytes().into_owned();
                if to.send(News::Want(wanted)).await.is_err() {
                    return;
                }
            }
        });
        tokio::spawn(async move {
            while let Ok(query) = acts.recv_async().await {
                if news.send(News::Act(query)).await.is_err() {
                    return;
                }
            }
        });
        Ok(())
    }
}

impl Line<'_> {
    async fn put(&self, kind: Kind, body: Vec<u8>) {
        let publisher = match kind {
            Kind::State => &self.state,
            Kind::Tile => &self.tile,
            Kind::View => &self.view,
            Kind::Answer => return,
        };
        // While the connection is lost, sending fails. The next message may arrive.
        let _ = publisher.put(body).await;
    }
}

/// Takes frames until the program ends.
async fn frames(mut output: ChildStdout, news: mpsc::Sender<News>) {
    loop {
        let next = match read(&mut output).await {
            Ok(Some((kind, body))) => News::Frame(kind, body),
            Ok(None) => News::Over(None),
            Err(error) => News::Over(Some(error)),
        };
        let is_over = matches!(next, News::Over(_));
        if news.send(next).await.is_err() || is_over {
            return;
        }
    }
}

async fn hand_over(input: &mut ChildStdin, number: u64, query: &Query) {
    let asked = query.payload().map(|it| it.to_bytes().into_owned());
    let asked: Value = serde_json::from_slice(&asked.unwrap_or_default()).unwrap_or_default();
    let remark = asked["remark"].as_str().unwrap_or_default();
    let line = json!({"id": number, "remark": remark}).to_string();
    write(input, line.as_bytes()).await;
}

async fn answer(asked: &mut BTreeMap<u64, Query>, body: &[u8]) {
    let told: Value = serde_json::from_slice(body).unwrap_or_default();
    if let Some(query) = told["id"].as_u64().and_then(|id| asked.remove(&id)) {
        let key = query.key_expr().clone();
        let _ = query.reply(key, body.to_vec()).await;
    }
}
