//! Plays one recording of `calot tell` as many stations, to try out a centre.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until};
use zenoh::Session;
use zenoh::qos::CongestionControl;

use crate::error::{CentreError, network};
use crate::frame::{Kind, read};
use crate::keys::Keys;
use crate::log::now_ms;
use crate::state::State;
use crate::topic::Topic;

/// Ticks in a second of the simulation.
const TICKS_PER_S: f64 = 1000.0;

/// A recorded frame, and its time since the beginning.
struct Frame {
    at: Duration,
    kind: Kind,
    body: Vec<u8>,
    state: Option<State>,
}

/// Reads a recording. The simulation's ticks give the times of its frames.
async fn recording(path: &PathBuf) -> Result<Vec<Frame>, CentreError> {
    let unreadable = |problem: String| CentreError::File {
        path: path.clone(),
        problem,
    };
    let bytes = std::fs::read(path).map_err(|error| unreadable(error.to_string()))?;
    let (mut rest, mut frames, mut first) = (bytes.as_slice(), Vec::new(), None);
    let mut at = Duration::ZERO;
    while let Some((kind, body)) = read(&mut rest).await? {
        let state = match kind {
            Kind::State => State::parse(&body),
            _ => None,
        };
        if let Some(state) = state.as_ref().filter(|it| it.ticks > 0) {
            let first = *first.get_or_insert(state.ticks);
            at = Duration::from_secs_f64(state.ticks.saturating_sub(first) as f64 / TICKS_PER_S);
        }
        frames.push(Frame {
            at,
            kind,
            body,
            state,
        });
    }
    match frames.is_empty() {
        true => Err(unreadable("it holds no frames".to_owned())),
        false => Ok(frames),
    }
}

/// Plays a recording as a station for each folder of keys, over and over. When an alarm is sent,
/// prints it as a JSON object on a line.
///
/// # Errors
/// If the recording cannot be read, or the centre is not reached.
pub async fn rehearse(
    path: &PathBuf,
    address: &str,
    folders: &[PathBuf],
) -> Result<(), CentreError> {
    let frames = Arc::new(recording(path).await?);
    let mut playing = Vec::new();
    for (number, folder) in folders.iter().enumerate() {
        let keys = Keys::read(folder)?;
        let session = crate::network::join(address, &keys).await?;
        let frames = frames.clone();
        playing.push(tokio::spawn(async move {
            let played = play(&session, &keys.name, number, &frames).await;
            if let Err(error) = played {
                eprintln!("calot-centre: {}: {error}", keys.name);
            }
        }));
    }
    for it in playing {
        let _ = it.await;
    }
    Ok(())
}

async fn play(
    session: &Session,
    name: &str,
    number: usize,
    frames: &[Frame],
) -> Result<(), CentreError> {
    let failed = || network("rehearsing a station");
    let token = session.liveliness();
    let token = token.declare_token(Topic::Presence.of(name));
    let _token = token.await.map_err(failed())?;
    let (wish, wanted) = watch::channel([false; 2]);
    let wants = session.declare_subscriber(Topic::Want.of(name));
    let wants = wants.callback(move |sample| {
        let told: Value = serde_json::from_slice(&sample.payload().to_bytes()).unwrap_or_default();
        let is_wanted = |what: &str| told[what].as_f64().is_some_and(|it| it > 0.0);
        let _ = wish.send(["tile_hz", "view_hz"].map(is_wanted));
    });
    wants.background().await.map_err(failed())?;
    // Each station begins at another place of the recording, so that they do not all do the same at
    // once.
    let length = frames.last().map_or(Duration::ZERO, |it| it.at);
    let mut skip = length.mul_f64(number as f64 * 0.382 % 1.0);
    loop {
        let (start, operation, mut said) = (Instant::now(), now_ms(), 0);
        for frame in frames.iter().filter(|it| it.at >= skip) {
            sleep_until(start + (frame.at - skip)).await;
            let (topic, body) = match (frame.kind, &frame.state) {
                (Kind::State, Some(state)) => {
                    let mut state = state.clone();
                    (state.operation, state.trainee) =
                        (operation, Some(format!("trainee {number}")));
                    for alarm in state.newest_alarms.iter().filter(|it| it.number > said) {
                        let number = alarm.number;
                        let line = json!({"station": name, "operation": operation, "number": number,
                            "sent_unix_ms": now_ms()});
                        println!("{line}");
                    }
                    said = state.alarms;
                    (Topic::State, serde_json::to_vec(&state).unwrap_or_default())
                }
                (Kind::Tile, _) if wanted.borrow()[0] => (Topic::Tile, frame.body.clone()),
                (Kind::View, _) if wanted.borrow()[1] => (Topic::View, frame.body.clone()),
                _ => continue,
            };
            let put = session.put(topic.of(name), body);
            let put = put.congestion_control(CongestionControl::Drop);
            let _ = put.express(true).await;
        }
        skip = Duration::ZERO;
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}
