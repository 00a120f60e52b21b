//! The present state of all stations, for all viewers.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use crate::log::now_ms;
use crate::state::{Heard, State};

/// Alarms of a station that are kept for the page.
const ALARMS_KEPT: usize = 500;
/// Largest picture, bytes.
const PICTURE_MAX: usize = 2_000_000;

/// A picture and its number.
pub type Picture = (u64, Arc<[u8]>);

/// A station as the centre knows it.
#[derive(Debug, Clone, Default)]
pub struct Known {
    /// The station is connected.
    pub present: bool,
    /// Time since which the station is present or absent, ms since 1970; 0: it was never present.
    pub since_unix_ms: u64,
    /// Its last state.
    pub state: Option<State>,
    /// Grows with each change of the fields above.
    pub version: u64,
    /// Its last small picture.
    pub tile: Option<Picture>,
    /// Its last large picture.
    pub view: Option<Picture>,
    /// Operation and number of the last alarm.
    last: (u64, u64),
    /// Number of alarms that never arrived.
    pub lost: u64,
    alarms: VecDeque<Heard>,
}

impl Known {
    fn keep(&mut self, alarms: impl IntoIterator<Item = Heard>) {
        self.alarms.extend(alarms);
        let spare = self.alarms.len().saturating_sub(ALARMS_KEPT);
        self.alarms.drain(..spare);
    }
}

/// Number of viewers of something.
#[derive(Debug, Default)]
struct Viewers {
    tiles: usize,
    large: BTreeMap<String, usize>,
}

/// The board of all stations, by name.
#[derive(Debug, Default)]
pub struct Board {
    stations: Mutex<BTreeMap<String, Known>>,
    viewers: Mutex<Viewers>,
    /// Somebody began or ceased to watch.
    pub asked: Notify,
}

impl Board {
    fn stations(&self) -> MutexGuard<'_, BTreeMap<String, Known>> {
        self.stations.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn viewers(&self) -> MutexGuard<'_, Viewers> {
        self.viewers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps exactly these stations: adds the new ones and removes the others.
    pub fn set_stations<'a>(&self, names: impl Iterator<Item = &'a String>) {
        let mut stations = self.stations();
        let mut old = std::mem::take(&mut *stations);
        for name in names {
            let known = old.remove(name).unwrap_or_default();
            stations.insert(name.clone(), known);
        }
    }

    /// Notes that a station is present or absent. Returns true if this has changed.
    pub fn set_present(&self, name: &str, present: bool) -> bool {
        let mut stations = self.stations();
        let Some(known) = stations.get_mut(name) else {
            return false;
        };
        if known.present == present {
            return false;
        }
        (known.present, known.since_unix_ms) = (present, now_ms());
        known.version += 1;
        true
    }

    /// Takes a state, and returns the alarms that are new.
    pub fn take_state(&self, name: &str, state: State) -> Vec<Heard> {
        let mut stations = self.stations();
        let Some(known) = stations.get_mut(name) else {
            return Vec::new();
        };
        let mut last = match known.last {
            (operation, number) if operation == state.operation && number <= state.alarms => number,
            _ => 0,
        };
        let at_unix_ms = now_ms();
        let mut new = Vec::new();
        for alarm in &state.newest_alarms {
            if alarm.number <= last {
                continue;
            }
            known.lost = known.lost.saturating_add(alarm.number - last - 1);
            last = alarm.number;
            new.push(Heard {
                at_unix_ms,
                operation: state.operation,
                trainee: state.trainee.clone(),
                alarm: alarm.clone(),
            });
        }
        known.last = (state.operation, last);
        known.keep(new.iter().cloned());
        known.state = Some(state);
        known.version += 1;
        new
    }

    /// Takes an alarm from the log, from before this program started.
    pub fn remember(&self, name: &str, alarm: Heard) {
        if let Some(known) = self.stations().get_mut(name) {
            known.last = (alarm.operation, alarm.alarm.number);
            known.keep([alarm]);
        }
    }

    /// Takes a picture.
    pub fn take_picture(&self, name: &str, is_large: bool, picture: &[u8]) {
        // Only data that begin as a JPEG does are a picture. The browser reads them as nothing
        // else.
        if picture.len() > PICTURE_MAX || !picture.starts_with(&[0xff, 0xd8]) {
            return;
        }
        let mut stations = self.stations();
        if let Some(known) = stations.get_mut(name) {
            let place = match is_large {
                true => &mut known.view,
                false => &mut known.tile,
            };
            let number = place.as_ref().map_or(0, |it| it.0) + 1;
            *place = Some((number, picture.into()));
        }
    }

    /// Calls `each` with every station.
    pub fn each(&self, mut each: impl FnMut(&str, &Known)) {
        for (name, known) in &*self.stations() {
            each(name, known);
        }
    }

    /// Alarms of a station, the newest first.
    #[must_use]
    pub fn alarms(&self, name: &str) -> Vec<Heard> {
        let stations = self.stations();
        let known = stations.get(name);
        known.map_or_else(Vec::new, |it| it.alarms.iter().rev().cloned().collect())
    }

    /// Adds a viewer of the tiles if `begins`, else removes one.
    pub fn watch_tiles(&self, begins: bool) {
        let mut viewers = self.viewers();
        viewers.tiles = match begins {
            true => viewers.tiles + 1,
            false => viewers.tiles.saturating_sub(1),
        };
        drop(viewers);
        self.asked.notify_one();
    }

    /// Adds a viewer of a station's large picture if `begins`, else removes one.
    pub fn watch_large(&self, station: &str, begins: bool) {
        let mut viewers = self.viewers();
        let count = viewers.large.entry(station.to_owned()).or_default();
        *count = match begins {
            true => *count + 1,
            false => count.saturating_sub(1),
        };
        drop(viewers);
        self.asked.notify_one();
    }

    /// Viewers of the tiles, and of a station's large picture.
    #[must_use]
    pub fn watched(&self, station: &str) -> (usize, usize) {
        let viewers = self.viewers();
        let large = viewers.large.get(station).copied().unwrap_or(0);
        (viewers.tiles, large)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::tests::state;

    fn board() -> Board {
        let board = Board::default();
        board.set_stations(["left".to_owned()].iter());
        board
    }

    fn numbers(heard: &[Heard]) -> Vec<u64> {
        heard.iter().map(|it| it.alarm.number).collect()
    }

    #[test]
    fn each_alarm_counts_once_and_a_lost_one_is_counted() {
        let board = board();
        assert_eq!(numbers(&board.take_state("left", state(7, 2))), [1, 2]);
        assert!(board.take_state("left", state(7, 2)).is_empty());
        // States were lost in between. The next state repeats their alarms.
        assert_eq!(board.take_state("left", state(7, 30)).len(), 28);
        let late = board.take_state("left", state(7, 70));
        assert_eq!(numbers(&late), (39..=70).collect::<Vec<_>>());
        let mut lost = 0;
        board.each(|_, known| lost = known.lost);
        assert_eq!(lost, 8);
        // A new operation, and a new task in one, count from 1.
        assert_eq!(numbers(&board.take_state("left", state(8, 1))), [1]);
        assert!(board.take_state("left", state(8, 0)).is_empty());
        assert_eq!(numbers(&board.take_state("left", state(8, 1))), [1]);
        assert_eq!(board.alarms("left")[0].operation, 8);
        assert!(board.take_state("stranger", state(1, 1)).is_empty());
    }

    #[test]
    fn alarms_from_before_do_not_come_again() {
        let (old, new) = (board(), board());
        for heard in old.take_state("left", state(7, 3)) {
            new.remember("left", heard);
        }
        assert_eq!(numbers(&new.alarms("left")), [3, 2, 1]);
        assert_eq!(numbers(&new.take_state("left", state(7, 4))), [4]);
    }

    #[test]
    fn stations_that_leave_the_list_go_and_others_stay_as_they_are() {
        let board = board();
        assert!(board.set_present("left", true) && !board.set_present("left", true));
        assert!(!board.set_present("right", true), "it is not on the list");
        board.set_stations(["left".to_owned(), "right".to_owned()].iter());
        let mut seen = Vec::new();
        board.each(|name, known| seen.push((name.to_owned(), known.present)));
        assert_eq!(
            seen,
            [("left".to_owned(), true), ("right".to_owned(), false)]
        );
        board.set_stations(["right".to_owned()].iter());
        assert!(board.alarms("left").is_empty());
    }

    #[test]
    fn only_pictures_are_taken_and_viewers_are_counted() {
        let board = board();
        board.take_picture("left", false, b"<svg>");
        board.take_picture("left", false, &[0xff, 0xd8, 1]);
        board.take_picture("left", false, &[0xff, 0xd8, 2]);
        board.each(|_, known| {
            assert_eq!(known.tile.as_ref().map(|it| it.0), Some(2));
            assert!(known.view.is_none());
        });
        board.watch_tiles(true);
        board.watch_large("left", true);
        board.watch_large("left", true);
        board.watch_large("left", false);
        assert_eq!(board.watched("left"), (1, 1));
        board.watch_tiles(false);
        assert_eq!(board.watched("right"), (0, 0));
    }
}
