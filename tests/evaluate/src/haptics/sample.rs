//! Calot's contact in a few of the tests, kept ready to be repeated.

use rt_core::state::State;

use super::device::{Device, Hand};
use super::scene::{Meets, liver};
use super::{Bench, LawKind, SPHERES, Test};
use crate::methods::Parts;

/// Modulus of the liver, Pa.
const YOUNG_PA: f64 = 5e3;
/// Delays, s.
const DELAYS_S: [f64; 2] = [0.0, 0.003];
/// Stiffness of the wall into which a stroke runs, N/m.
const STROKE_N_M: f64 = 1000.0;

/// A liver, and the top of it.
pub(crate) struct Sample {
    liver: (Parts, f64),
}

/// Result of all tests.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Felt {
    /// Number of tests in which a liver is stable in a hand.
    pub(crate) stable: usize,
    /// Geometric mean of what the stiffest stable walls render, N/m.
    pub(crate) rendered_n_m: f64,
    /// Largest oscillation of the force in a stroke, N.
    pub(crate) peak_n: f64,
    /// Largest drag in free air, N.
    pub(crate) drag_n: f64,
}

impl Sample {
    /// Prepares the liver.
    ///
    /// # Errors
    /// The message of the scene's check.
    pub(crate) fn new() -> Result<Self, String> {
        let liver = liver(SPHERES, YOUNG_PA, Meets::Skin)?;
        Ok(Self { liver })
    }

    /// Runs the tests.
    ///
    /// # Errors
    /// The message of the scene's check.
    pub(crate) fn feel(&self) -> Result<Felt, String> {
        let mut bench = Bench {
            state: Box::new(State::new()),
            rows: Vec::new(),
            ratio: 4.0,
        };
        let (parts, top_m) = &self.liver;
        for delay_s in DELAYS_S {
            let device = Device {
                delay_s,
                ..Device::TOUCH
            };
            bench.wall(LawKind::Ours, Hand::RELAXED, device)?;
            bench.wall(LawKind::Ours, Hand::FIRM, device)?;
            bench.tissue(LawKind::Ours, (parts, *top_m, YOUNG_PA), device)?;
            bench.felt(LawKind::Ours, Hand::RELAXED, device, STROKE_N_M)?;
        }
        let rows = |test: Test| bench.rows.iter().filter(move |row| row.test == test);
        let walls = rows(Test::Wall).map(|row| row.rendered_n_m.max(1.0).ln());
        let strokes = || rows(Test::Felt).filter_map(|row| row.felt);
        Ok(Felt {
            stable: rows(Test::Tissue)
                .filter(|it| it.outcome.is_stable())
                .count(),
            rendered_n_m: (walls.sum::<f64>() / rows(Test::Wall).count() as f64).exp(),
            peak_n: strokes().map(|it| it.peak_n).fold(0.0, f64::max),
            drag_n: strokes().map(|it| it.drag_n).fold(0.0, f64::max),
        })
    }
}
