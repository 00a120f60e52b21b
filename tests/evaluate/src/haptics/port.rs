//! Strokes of a shaft through a trocar, as the emulated Touch renders them to a firm hand.

use rt_core::math::Vec3;
use rt_core::scene::{Room, Scene, Trocar};
use rt_core::state::State;

use super::device::{Device, Hand, Loop};
use super::law::{Law, Product, START_M, stated};
use super::scene::room;

/// Length of a stroke, m.
const STROKE_M: f64 = 0.05;
/// Speed of the hand, m/s.
const SPEED_M_S: f64 = 0.05;
/// Ticks for which the hand rests before and after each stroke.
const REST_TICKS: u32 = 1000;
/// Delay of the device, s.
const DELAY_S: f64 = 0.001;
/// Share of a stroke, from its end, in which the shaft slides evenly.
const SLIDING: f64 = 0.3;

/// Forces of two strokes, one inwards and one outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Strokes {
    /// Mean friction while the shaft slides, N.
    pub(crate) sliding_n: f64,
    /// Largest friction when the resting shaft starts, less the sliding friction, N.
    pub(crate) start_n: f64,
    /// Largest friction after the reversal, less the sliding friction, N.
    pub(crate) reversal_n: f64,
    /// Swing of the resting handle, m.
    pub(crate) swing_m: f64,
    /// Net work of the motors on the handle, J. A passive trocar does negative work.
    pub(crate) given_j: f64,
}

/// Moves a shaft in and out through `trocar`, away from tissue.
///
/// # Errors
/// The message of the scene's check.
pub(crate) fn strokes(trocar: Trocar) -> Result<Strokes, String> {
    let room = Room {
        trocar: Trocar {
            axis: Vec3::new(0.0, 0.0, -1.0),
            ..trocar
        },
        ..room()
    };
    let scene = Scene::new(&[], &[], &[], room).map_err(|e| e.to_string())?;
    let device = Device {
        delay_s: DELAY_S,
        ..Device::TOUCH
    };
    let mut state = Box::new(State::new());
    let mut law = Product::new(scene, &mut state, stated(&device), 0.0);
    let mut handle = Loop::new(device, Hand::FIRM, START_M);
    let mut tick = |target_m: f64| {
        let sample = handle.sample();
        let force_n = law.force_n(sample);
        handle.tick(force_n, target_m, 0.0);
        (force_n, handle.x_m, handle.motor_j)
    };
    let inside_m = START_M - STROKE_M;
    let ticks = (STROKE_M / SPEED_M_S * 1e3) as u32;
    let mut forces_n = [Vec::new(), Vec::new()];
    let (mut swing_m, mut given_j) = (0.0_f64, 0.0);
    let ways = [(START_M, inside_m), (inside_m, START_M)];
    for ((from_m, to_m), forces_n) in ways.into_iter().zip(&mut forces_n) {
        let (mut low_m, mut high_m) = (f64::MAX, f64::MIN);
        for resting in 0..REST_TICKS {
            let (_, x_m, _) = tick(from_m);
            if resting >= REST_TICKS / 2 {
                (low_m, high_m) = (low_m.min(x_m), high_m.max(x_m));
            }
        }
        swing_m = swing_m.max(high_m - low_m);
        for moving in 1..=ticks {
            let share = f64::from(moving) / f64::from(ticks);
            let (force_n, _, motor_j) = tick(from_m + (to_m - from_m) * share);
            // Friction pushes against the motion: outwards on the way in.
            forces_n.push(force_n * (from_m - to_m).signum());
            given_j = motor_j;
        }
    }
    let even = |all: &[f64]| {
        let last = &all[all.len() - (SLIDING * all.len() as f64) as usize..];
        last.iter().sum::<f64>() / last.len() as f64
    };
    let [inwards, outwards] = &forces_n;
    let jump = |all: &[f64]| all.iter().copied().fold(f64::MIN, f64::max) - even(all);
    Ok(Strokes {
        sliding_n: f64::midpoint(even(inwards), even(outwards)),
        start_n: jump(inwards),
        reversal_n: jump(outwards),
        swing_m,
        given_j,
    })
}
