//! The square that `calot photon` watches. The number of the tick that a picture shows makes the
//! square bright or dark; the place of the handle can do so instead. A light sensor on the square
//! then measures at which time a tick, or a motion, became visible.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use shared_mem::message::ToolFrame;

use crate::presentation::{Presented, Way};

/// Side of the cubes into which space is divided, m. The square changes when the handle passes from
/// one cube into the next.
const CELL_M: f32 = 0.02;
/// Side of the square, as a share of the window's height, and its least side, points.
const SIDE: (f32, f32) = (0.12, 60.0);

/// Cause of a change of the square.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// The number of the tick.
    Tick,
    /// The handle's place.
    Motion,
}

/// Place of the square at the left edge of the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In the upper corner.
    Top,
    /// Half way down.
    Middle,
    /// In the lower corner.
    Bottom,
}

impl Place {
    /// All places, from above.
    pub const ALL: [Self; 3] = [Self::Top, Self::Middle, Self::Bottom];

    /// Name in documents.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Top => "top",
            Self::Middle => "middle",
            Self::Bottom => "bottom",
        }
    }
}

/// A picture that changed the square.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Changed {
    /// True if the square is bright from this picture on.
    pub bright: bool,
    /// Time at which the picture was handed to the screen, ns.
    pub handed_ns: u64,
}

/// A picture that changed the square, once it came to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrived {
    /// True if the square is bright from this picture on.
    pub bright: bool,
    /// Time of its handing over, ns.
    pub handed_ns: u64,
    /// Time at which the screen got it, ns.
    pub at_ns: u64,
}

/// The window's screen and driver.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Size of the window, pixels.
    pub size: [u32; 2],
    /// True if the window covers the screen.
    pub full_screen: bool,
    /// Refresh rate of the screen, Hz; `None` if the window system does not report it.
    pub refresh_hz: Option<f64>,
    /// Rule by which the driver takes pictures.
    pub present_mode: String,
    /// Graphics adapter and driver.
    pub adapter: String,
}

/// The square, shared by the window and the program that measures.
#[derive(Debug)]
pub struct Patch {
    /// True if the window shall cover the screen.
    pub full_screen: bool,
    /// Ticks between two changes by the tick.
    every_ticks: u64,
    /// Numbers of `By` and `Place`.
    setting: [AtomicU8; 2],
    findings: Mutex<Findings>,
}

/// Findings of the window.
#[derive(Debug, Default)]
struct Findings {
    last: Option<bool>,
    changed: Vec<Changed>,
    arrived_last: Option<bool>,
    arrived: Vec<Arrived>,
    surface: Option<Surface>,
}

/// The square in one picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lit {
    place: Place,
    bright: bool,
}

impl Patch {
    /// A square in the upper corner that changes every `every_ticks` ticks.
    #[must_use]
    pub fn new(full_screen: bool, every_ticks: u64) -> Self {
        Self {
            full_screen,
            every_ticks: every_ticks.max(1),
            setting: Default::default(),
            findings: Mutex::default(),
        }
    }

    /// Sets the square's place, and the cause that changes the square.
    pub fn set(&self, place: Place, by: By) {
        let [to_by, to_place] = &self.setting;
        to_by.store(by as u8, Ordering::Relaxed);
        to_place.store(place as u8, Ordering::Relaxed);
    }

    /// True if the square is bright in a picture of this tick with the handle at this place, world
    /// frame, m.
    #[must_use]
    pub fn is_bright(&self, by: By, tick: u64, handle_m: [f32; 3]) -> bool {
        match by {
            By::Tick => (tick / self.every_ticks) % 2 == 1,
            By::Motion => {
                let cells = handle_m.map(|x| (x / CELL_M).floor() as i64);
                cells.iter().sum::<i64>().rem_euclid(2) == 1
            }
        }
    }

    /// The changes since the last call.
    pub fn take_changed(&self) -> Vec<Changed> {
        std::mem::take(&mut self.findings().changed)
    }

    /// The changes that came to the screen since the last call.
    pub fn take_arrived(&self) -> Vec<Arrived> {
        std::mem::take(&mut self.findings().arrived)
    }

    /// Screen and driver, once the window is open.
    pub fn surface(&self) -> Option<Surface> {
        self.findings().surface.clone()
    }

    /// The square as it belongs to a picture of these tools.
    pub(crate) fn lit(&self, tools: &ToolFrame) -> Lit {
        let [by, place] = &self.setting;
        let by = match by.load(Ordering::Relaxed) {
            0 => By::Tick,
            _ => By::Motion,
        };
        let place = usize::from(place.load(Ordering::Relaxed));
        Lit {
            place: Place::ALL.get(place).copied().unwrap_or(Place::Top),
            bright: self.is_bright(by, tools.tick, tools.world_from_handle.position_m),
        }
    }

    /// Notes that the picture with this square was handed to the screen.
    pub(crate) fn handed(&self, lit: Lit, handed_ns: u64, surface: impl FnOnce() -> Surface) {
        let mut findings = self.findings();
        if findings.last.replace(lit.bright) != Some(lit.bright) {
            findings.changed.push(Changed {
                bright: lit.bright,
                handed_ns,
            });
            findings.surface = Some(surface());
        }
    }

    /// Notes that the picture with this square came to the screen.
    pub(crate) fn presented(&self, lit: Lit, handed_ns: u64, presented: Presented) {
        if presented.way == Way::Skip {
            return;
        }
        let mut findings = self.findings();
        if findings.arrived_last.replace(lit.bright) != Some(lit.bright) {
            findings.arrived.push(Arrived {
                bright: lit.bright,
                handed_ns,
                at_ns: presented.at_ns,
            });
        }
    }

    fn findings(&self) -> MutexGuard<'_, Findings> {
        self.findings.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Lit {
    /// Paints the square over everything else, on a dark ground that hides what moves below.
    pub(crate) fn paint(self, context: &egui::Context) {
        let area = context.content_rect();
        let side = (SIDE.0 * area.height()).max(SIDE.1);
        let rest = (area.height() - side).max(0.0);
        let down = match self.place {
            Place::Top => 0.0,
            Place::Middle => rest / 2.0,
            Place::Bottom => rest,
        };
        let corner = area.left_top() + egui::vec2(0.0, down);
        let square = egui::Rect::from_min_size(corner, egui::Vec2::splat(side));
        let layer = egui::LayerId::new(egui::Order::Debug, egui::Id::unique("photon"));
        let painter = context.layer_painter(layer);
        let color = match self.bright {
            true => egui::Color32::WHITE,
            false => egui::Color32::BLACK,
        };
        painter.rect_filled(square, 0.0, color);
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;

    use super::*;

    #[test]
    fn the_square_changes_after_its_number_of_ticks() {
        let patch = Patch::new(true, 499);
        let bright = |tick| patch.is_bright(By::Tick, tick, [0.0; 3]);
        let changes: Vec<u64> = (1..2000).filter(|&n| bright(n) != bright(n - 1)).collect();
        assert_eq!(changes, [499, 998, 1497, 1996]);
    }

    #[test]
    fn the_square_changes_where_the_handle_passes_from_cell_to_cell() {
        let patch = Patch::new(true, 499);
        for axis in 0..3 {
            let at = |mm: f32| {
                let mut place = [0.001; 3];
                place[axis] = mm * 1e-3;
                patch.is_bright(By::Motion, 0, place)
            };
            let steps = (-45..45).filter(|&mm| at(mm as f32 + 0.5) != at(mm as f32 - 0.5));
            assert_eq!(steps.collect::<Vec<_>>(), [-40, -20, 0, 20, 40], "{axis}");
        }
    }

    #[test]
    fn only_pictures_that_change_the_square_are_reported_with_their_screen() {
        let patch = Patch::new(true, 499);
        let surface = || Surface {
            size: [640, 480],
            full_screen: true,
            refresh_hz: Some(60.0),
            present_mode: "Fifo".to_owned(),
            adapter: "none".to_owned(),
        };
        let mut tools = ToolFrame::zeroed();
        for tick in [1, 2, 500, 501, 999] {
            tools.tick = tick;
            patch.handed(patch.lit(&tools), tick * 1_000_000, surface);
        }
        let changed = patch.take_changed();
        let brights: Vec<bool> = changed.iter().map(|it| it.bright).collect();
        assert_eq!(brights, [false, true, false]);
        assert!(changed.is_sorted_by_key(|it| it.handed_ns));
        assert!(patch.take_changed().is_empty() && patch.surface() == Some(surface()));
        patch.set(Place::Bottom, By::Motion);
        tools.world_from_handle.position_m = [0.03, 0.001, 0.001];
        let lit = patch.lit(&tools);
        assert!(lit.bright && lit.place == Place::Bottom);
    }

    #[test]
    fn a_skipped_picture_changes_nothing_on_the_screen() {
        let patch = Patch::new(true, 499);
        let mut tools = ToolFrame::zeroed();
        for (tick, way) in [
            (1, Way::Copy),
            (500, Way::Skip),
            (501, Way::Flip),
            (502, Way::Flip),
        ] {
            tools.tick = tick;
            let handed_ns = tick * 1_000_000;
            let at_ns = handed_ns + 7_000_000;
            patch.presented(
                patch.lit(&tools),
                handed_ns,
                Presented {
                    at_ns,
                    way,
                    screen: None,
                },
            );
        }
        let arrived = patch.take_arrived();
        let findings: Vec<_> = arrived.iter().map(|it| (it.bright, it.at_ns)).collect();
        assert_eq!(findings, [(false, 8_000_000), (true, 508_000_000)]);
        assert_eq!(arrived[1].handed_ns, 501_000_000);
        assert!(patch.take_arrived().is_empty());
    }
}
