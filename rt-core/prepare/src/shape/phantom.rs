//! A phantom for basic drills: a board that faces the endoscope, and on it three balls to touch, a
//! rope to grasp and carry, a tube to clip and cut, and fat around a bar for the hook.

use super::primitive::{Tube, ball, carve};
use crate::Vec3;

/// Middle of the phantom, m: the point that the endoscope looks at.
const MIDDLE: [f64; 3] = [-0.046, 0.288, -0.050];
/// Distance from that middle to the front of the board, towards the head, m.
const FRONT_M: f64 = 0.010;
/// Half of the board's width, depth and height, m, and the radius of its edges.
const BOARD: ([f64; 3], f64) = ([0.056, 0.009, 0.044], 0.006);
/// Gap between the board and what stands on it, m.
const GAP_M: f64 = 0.0008;
const BALL_M: f64 = 0.007;
const TUBE_M: f64 = 0.0018;
const ROPE_M: f64 = 0.0040;
const CORE_M: f64 = 0.0028;
const FAT_M: f64 = 0.0068;

/// A part of the phantom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Board,
    UpperLeftBall,
    RightBall,
    LowerLeftBall,
    Rope,
    Tube,
    Core,
    Fat,
}

/// A place on the board: to the right and up in the picture, and the distance from the board, m.
fn at([right, up, out]: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = MIDDLE;
    [x + right, y + FRONT_M - out, z + up]
}

fn through(points: &[[f64; 3]], radius: f64) -> Tube {
    let points: Vec<_> = points.iter().map(|it| (at(*it), radius)).collect();
    Tube::new(&points, 6)
}

impl Part {
    /// A function that gives the distance to the part. It captures the data that it needs, so that
    /// it is cheap to call for many points.
    pub(super) fn distance(self) -> Box<dyn Fn(&Vec3) -> f64 + Sync> {
        match self {
            Self::Board => Box::new(board),
            Self::UpperLeftBall | Self::RightBall | Self::LowerLeftBall => {
                let middle = self.middle();
                Box::new(move |p| ball(p, middle, BALL_M))
            }
            Self::Rope | Self::Tube | Self::Core => {
                let tube = self.tube();
                Box::new(move |p| on_board(tube.distance(p), p))
            }
            Self::Fat => {
                let (fat, core) = (self.tube(), Self::Core.tube());
                Box::new(move |p| carve(fat.distance(p), core.distance(p) - GAP_M, 0.0004))
            }
        }
    }

    /// A box around the part, and the length of a triangle's side, m.
    pub(super) fn extent(self) -> ([Vec3; 2], f64) {
        let around = |middle: [f64; 3], half: [f64; 3]| {
            let (middle, half) = (Vec3::from(middle), Vec3::from(half));
            let half = half.add_scalar(0.004);
            [middle - half, middle + half]
        };
        match self {
            Self::Board => (around(at([0.0, 0.0, -BOARD.0[1]]), BOARD.0), 0.004),
            Self::UpperLeftBall | Self::RightBall | Self::LowerLeftBall => {
                (around(self.middle(), [BALL_M; 3]), 0.0016)
            }
            Self::Rope | Self::Tube | Self::Core | Self::Fat => {
                let tube = self.tube();
                let [low, high] = tube.bounds();
                let edge = match self {
                    Self::Tube => 0.45 * TUBE_M,
                    Self::Rope => 0.0016,
                    _ => 0.0012,
                };
                ([low.add_scalar(-0.004), high.add_scalar(0.004)], edge)
            }
        }
    }

    fn middle(self) -> [f64; 3] {
        let out = BALL_M + GAP_M;
        match self {
            Self::UpperLeftBall => at([-0.036, 0.026, out]),
            Self::RightBall => at([0.036, -0.002, out]),
            _ => at([-0.036, -0.008, out]),
        }
    }

    fn tube(self) -> Tube {
        match self {
            Self::Rope => through(
                &[
                    [-0.014, 0.032, 0.002],
                    [-0.013, 0.032, 0.009],
                    [-0.006, 0.031, 0.013],
                    [0.010, 0.030, 0.014],
                    [0.026, 0.029, 0.014],
                ],
                ROPE_M,
            ),
            Self::Tube => through(
                &[
                    [-0.026, 0.002, 0.001],
                    [-0.025, 0.002, 0.007],
                    [-0.018, 0.002, 0.011],
                    [-0.006, 0.001, 0.013],
                    [0.006, 0.000, 0.013],
                    [0.014, -0.001, 0.011],
                    [0.020, -0.001, 0.007],
                    [0.021, -0.001, 0.001],
                ],
                TUBE_M,
            ),
            Self::Core => through(
                &[
                    [-0.030, -0.024, 0.002],
                    [-0.029, -0.024, 0.008],
                    [-0.022, -0.024, 0.011],
                    [0.000, -0.024, 0.012],
                    [0.022, -0.024, 0.011],
                    [0.029, -0.024, 0.008],
                    [0.030, -0.024, 0.002],
                ],
                CORE_M,
            ),
            _ => through(
                &[
                    [-0.012, -0.024, 0.0118],
                    [0.000, -0.024, 0.0120],
                    [0.012, -0.024, 0.0118],
                ],
                FAT_M,
            ),
        }
    }
}

/// A board with round edges.
fn board(p: &Vec3) -> f64 {
    let (half, round) = BOARD;
    let middle = Vec3::from(at([0.0, 0.0, -half[1]]));
    let off = (p - middle).abs() - Vec3::from(half).add_scalar(-round);
    off.map(|it| it.max(0.0)).norm() + off.max().min(0.0) - round
}

/// A part that ends just in front of the board.
fn on_board(part: f64, p: &Vec3) -> f64 {
    match part > 0.003 {
        true => part,
        false => carve(part, board(p) - GAP_M, 0.0006),
    }
}
