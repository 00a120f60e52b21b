//! The live connection of a page: states as JSON, pictures as they come, requests of the
//! instructor.
//!
//! Each page takes the newest picture of a station when its connection is free, so a slow page gets
//! fewer pictures and delays nobody.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use axum::body::Bytes;
use axum::extract::State;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use serde::Deserialize;
use serde_json::{Value, json};

use super::Web;
use super::login::Who;
use crate::board::{Known, Picture};
use crate::roster::Instructor;

/// Interval between two looks at the board.
const LOOK_EVERY: Duration = Duration::from_millis(15);
/// Longest message of a page, bytes.
const MESSAGE_MAX: usize = 4096;
/// Interval at which the person's rights are looked up again.
const RIGHT_EVERY: Duration = Duration::from_secs(1);

/// A request of the page.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Asked {
    /// Enlarge this station, or none.
    Enlarge(Option<String>),
    /// Send a remark to a station.
    Remark { station: String, text: String },
}

/// Numbers of the newest state and pictures that a page has received.
#[derive(Default)]
struct Had {
    version: Option<u64>,
    tile: u64,
    view: u64,
}

pub(super) async fn live(State(web): State<Web>, who: Who, upgrade: WebSocketUpgrade) -> Response {
    let upgrade = upgrade.max_message_size(MESSAGE_MAX);
    upgrade.on_upgrade(async move |socket| {
        web.hall.board.watch_tiles(true);
        // Small pictures of all stations are watched, too.
        web.hall.log.note("looks", &who.name, "", &Value::Null);
        let since = Instant::now();
        let mut visit = Visit::new(&web, who);
        visit.show(socket).await;
        visit.enlarge(None);
        let detail = json!({"seconds": since.elapsed().as_secs()});
        web.hall.log.note("looked", &visit.who.name, "", &detail);
        web.hall.board.watch_tiles(false);
    })
}

/// An open page.
struct Visit<'a> {
    web: &'a Web,
    who: Who,
    had: BTreeMap<String, Had>,
    /// The enlarged station, and when it was enlarged.
    large: Option<(String, Instant)>,
}

impl<'a> Visit<'a> {
    fn new(web: &'a Web, who: Who) -> Self {
        Self {
            web,
            who,
            had: BTreeMap::new(),
            large: None,
        }
    }

    /// Shows the stations until the page is closed or the person's right has ended.
    async fn show(&mut self, mut socket: WebSocket) {
        let mut looks = tokio::time::interval(LOOK_EVERY);
        looks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut right: Option<(Instructor, Instant)> = None;
        loop {
            let is_old = |it: &(Instructor, Instant)| it.1.elapsed() > RIGHT_EVERY;
            if right.as_ref().is_none_or(is_old) {
                let Some(person) = self.right().await else {
                    return;
                };
                right = Some((person, Instant::now()));
            }
            let Some((person, _)) = &right else { return };
            tokio::select! {
                heard = socket.recv() => {
                    let Some(Ok(message)) = heard else { return };
                    if let Message::Text(text) = message
                        && let Ok(asked) = serde_json::from_str(&text)
                    {
                        let answer = self.answer(asked, person).await;
                        if let Some(answer) = answer
                            && socket.send(text_of(&answer)).await.is_err()
                        {
                            return;
                        }
                    }
                }
                _ = looks.tick() => {
                    for message in self.news(person) {
                        if socket.send(message).await.is_err() {
                            return;
                        }
                    }
                }
            }
        }
    }

    /// Rights of the person, while the login holds and the list has the name.
    async fn right(&self) -> Option<Instructor> {
        let who = self.web.logins.who(&self.who.token, Instant::now())?;
        let roster = self.web.hall.roster.read().await;
        roster.instructors.get(&who).cloned()
    }

    async fn answer(&mut self, asked: Asked, person: &Instructor) -> Option<Value> {
        match asked {
            Asked::Enlarge(station) => {
                self.enlarge(station.filter(|it| person.may_see(it)));
                None
            }
            Asked::Remark { station, text } => {
                let outcome = match person.may_see(&station) {
                    true => self.web.hall.remark(&self.who.name, &station, &text).await,
                    false => "there is no such station".to_owned(),
                };
                Some(json!({"remark": {"station": station, "outcome": outcome}}))
            }
        }
    }

    /// Enlarges a station, or none, and logs who watched which station and for how long.
    fn enlarge(&mut self, station: Option<String>) {
        let hall = &self.web.hall;
        if let Some((old, since)) = self.large.take() {
            hall.board.watch_large(&old, false);
            let detail = json!({"seconds": since.elapsed().as_secs()});
            hall.log.note("watched", &self.who.name, &old, &detail);
        }
        if let Some(station) = station {
            hall.board.watch_large(&station, true);
            hall.log
                .note("watches", &self.who.name, &station, &Value::Null);
            self.had.entry(station.clone()).or_default().view = 0;
            self.large = Some((station, Instant::now()));
        }
    }

    /// Messages about what is new on the board.
    fn news(&mut self, person: &Instructor) -> Vec<Message> {
        let (mut states, mut pictures, mut names) = (Vec::new(), Vec::new(), Vec::new());
        let large = self.large.as_ref().map(|it| it.0.as_str());
        let had = &mut self.had;
        self.web.hall.board.each(|name, known| {
            if !person.may_see(name) {
                return;
            }
            names.push(name.to_owned());
            let had = had.entry(name.to_owned()).or_default();
            if had.version != Some(known.version) {
                had.version = Some(known.version);
                states.push(told(name, known));
            }
            let small = known.tile.as_ref();
            pictures.extend(newer(name, b't', small, &mut had.tile));
            if large == Some(name) {
                pictures.extend(newer(name, b'v', known.view.as_ref(), &mut had.view));
            }
        });
        let is_gone = |name: &String| !names.contains(name);
        let gone: Vec<String> = had.keys().filter(|it| is_gone(it)).cloned().collect();
        had.retain(|name, _| !is_gone(name));
        let mut messages = Vec::new();
        if !states.is_empty() || !gone.is_empty() {
            messages.push(text_of(&json!({"states": states, "gone": gone})));
        }
        messages.extend(pictures);
        messages
    }
}

fn told(name: &str, known: &Known) -> Value {
    json!({
        "name": name, "present": known.present, "since_unix_ms": known.since_unix_ms,
        "state": known.state, "lost_alarms": known.lost,
    })
}

/// A picture that the page does not have yet: its kind, the length of the name, the name, JPEG.
fn newer(name: &str, kind: u8, picture: Option<&Picture>, had: &mut u64) -> Option<Message> {
    let (number, bytes) = picture.filter(|it| it.0 != *had)?;
    *had = *number;
    let length = u8::try_from(name.len()).ok()?;
    let message = [&[kind, length], name.as_bytes(), bytes].concat();
    Some(Message::Binary(Bytes::from(message)))
}

fn text_of(value: &Value) -> Message {
    Message::Text(value.to_string().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_sent_once_with_its_station() {
        let picture: Picture = (3, vec![0xff, 0xd8].into());
        let mut had = 0;
        let sent = newer("left", b't', Some(&picture), &mut had);
        assert_eq!(
            sent,
            Some(Message::Binary(Bytes::from_static(b"t\x04left\xff\xd8")))
        );
        assert_eq!(newer("left", b't', Some(&picture), &mut had), None);
    }

    #[test]
    fn requests_are_told_apart() {
        let asked = |text: &str| serde_json::from_str::<Asked>(text);
        let enlarge = asked(r#"{"enlarge": "left"}"#);
        assert!(matches!(enlarge, Ok(Asked::Enlarge(Some(name))) if name == "left"));
        assert!(matches!(
            asked(r#"{"enlarge": null}"#),
            Ok(Asked::Enlarge(None))
        ));
        let remark = asked(r#"{"remark": {"station": "left", "text": "Well done"}}"#);
        assert!(matches!(remark, Ok(Asked::Remark { .. })));
        assert!(asked(r#"{"pause": "left"}"#).is_err());
    }
}
