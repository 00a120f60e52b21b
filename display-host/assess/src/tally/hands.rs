//! Statistics of hand movements: paths, movements, rest.

use crate::vector::{Vec3, distance};

/// Shorter steps do not count as path, m: they are tremor and noise.
const RULER_M: f64 = 1e-3;
/// Window over which speed is measured, s.
const WINDOW_S: f64 = 0.05;
/// Speed above which a movement begins, m/s.
const MOVES_M_S: f64 = 0.02;
/// Speed below which a movement ends, m/s.
const RESTS_M_S: f64 = 0.005;
/// Shortest rest that counts as idle, s.
const IDLE_S: f64 = 1.0;

/// The track of one hand.
#[derive(Debug, Clone, Default)]
pub(crate) struct Track {
    pub(crate) path_m: f64,
    pub(crate) movements: u32,
    /// Start points of the ruler and of the window; `None` after a gap.
    ruler: Option<Vec3>,
    window: Option<Vec3>,
    moving_from: Option<Vec3>,
    /// Straight distances and path lengths of the finished movements.
    straight_m: f64,
    moved_m: f64,
    path_at_begin_m: f64,
    newest: Option<Vec3>,
}

impl Track {
    /// Takes the hand's present position.
    fn at(&mut self, place: Vec3) {
        self.newest = Some(place);
        let from = *self.ruler.get_or_insert(place);
        self.window.get_or_insert(place);
        let step = distance(from, place);
        if step >= RULER_M {
            self.path_m += step;
            self.ruler = Some(place);
        }
    }

    /// Closes a window of this duration. Returns true if the hand rested in it.
    fn window(&mut self, place: Vec3, seconds: f64) -> bool {
        let from = self.window.replace(place).unwrap_or(place);
        let speed = distance(from, place) / seconds;
        match self.moving_from {
            None if speed > MOVES_M_S => {
                self.movements += 1;
                self.moving_from = Some(from);
                self.path_at_begin_m = self.path_m - distance(from, place).min(self.path_m);
            }
            Some(begin) if speed < RESTS_M_S => self.end_movement(begin, place),
            _ => {}
        }
        speed < RESTS_M_S
    }

    fn end_movement(&mut self, begin: Vec3, end: Vec3) {
        self.moving_from = None;
        let path_m = self.path_m - self.path_at_begin_m;
        self.straight_m += distance(begin, end).min(path_m);
        self.moved_m += path_m;
    }

    /// Begins anew at another position, after a gap.
    fn gap(&mut self) {
        if let (Some(begin), Some(end)) = (self.moving_from, self.newest) {
            self.end_movement(begin, end);
        }
        (self.ruler, self.window) = (None, None);
    }

    /// Straight distance over path length, for all movements.
    pub(crate) fn economy(&self) -> f64 {
        let mut whole = self.clone();
        whole.gap();
        match whole.moved_m > 0.0 {
            true => whole.straight_m / whole.moved_m,
            false => f64::NAN,
        }
    }
}

/// Both hands: instrument and endoscope.
#[derive(Debug, Clone, Default)]
pub(crate) struct Hands {
    pub(crate) tracks: [Track; 2],
    window_s: f64,
    rest_s: f64,
    idle_s: f64,
}

impl Hands {
    /// Takes both positions, after this time.
    pub(crate) fn step(&mut self, places: [Vec3; 2], seconds: f64) {
        self.window_s += seconds;
        for (track, place) in self.tracks.iter_mut().zip(places) {
            track.at(place);
        }
        if self.window_s < WINDOW_S {
            return;
        }
        let seconds = core::mem::take(&mut self.window_s);
        let [tip, lens] = &mut self.tracks;
        let rests = [
            tip.window(places[0], seconds),
            lens.window(places[1], seconds),
        ];
        match rests {
            [true, true] => self.rest_s += seconds,
            _ => self.end_rest(),
        }
    }

    fn end_rest(&mut self) {
        let rest_s = core::mem::take(&mut self.rest_s);
        if rest_s >= IDLE_S {
            self.idle_s += rest_s;
        }
    }

    /// Marks a time without records.
    pub(crate) fn gap(&mut self) {
        self.end_rest();
        self.window_s = 0.0;
        for track in &mut self.tracks {
            track.gap();
        }
    }

    pub(crate) fn idle_s(&self) -> f64 {
        let mut whole = self.clone();
        whole.end_rest();
        whole.idle_s
    }
}
