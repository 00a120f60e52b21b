//! The free experiments in their order, axis by axis, with nobody at the handle.

use rt_core::port::{DeviceCapabilities, HapticDevice};

use super::analyse::{Repetition, axis_of};
use super::bench::{Bench, Clock, Vector};
use super::excite::{Rough, chirp, is_movable, push};
use super::friction::{Broken, break_away};
use super::halt::Halt;
use super::hold::Hold;
use super::result::Characterised;

/// Largest distance from the middle of the workspace at which experiments begin, as a share of the
/// region.
const MIDDLE: f64 = 0.3;
/// Share of the first measured friction with which the force of later break-away experiments
/// begins.
const BEGIN: f64 = 0.6;
/// Time over which the force fades at the end, s.
const LET_GO_S: f64 = 0.5;

/// Options of the free experiments.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Axes x, y, z to be measured.
    pub axes: [bool; 3],
    /// Largest force, N. `None` means 1 N, or less if the device may not give as much.
    pub force_n: Option<f64>,
    /// Repetitions of each experiment: at least 2, because the error of a result is computed from
    /// their spread.
    pub repetitions: u32,
    /// Time for which a spring holds the handle before anything is measured, s. Meanwhile a person
    /// can let go of the handle.
    pub let_go_s: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            axes: [true; 3],
            force_n: None,
            repetitions: 3,
            let_go_s: 0.0,
        }
    }
}

/// Records of one axis.
#[derive(Debug, Clone)]
struct Recorded {
    rough: Rough,
    broken: Vec<[Broken; 2]>,
    repetitions: Vec<Repetition>,
}

/// Records of all experiments.
#[derive(Debug, Clone)]
pub struct Records {
    declared: DeviceCapabilities,
    force_n: f64,
    axes: [Option<Result<Recorded, String>>; 3],
}

impl Records {
    /// Records of a device without any experiment.
    #[must_use]
    pub fn none(device: &dyn HapticDevice) -> Self {
        Self {
            declared: device.capabilities(),
            force_n: 0.0,
            axes: [const { None }; 3],
        }
    }

    /// Fits the models. The computation takes seconds and needs no device.
    #[must_use]
    pub fn analyse(self) -> Characterised {
        let fitted = |it: Recorded| {
            let axis = axis_of(&it.rough, &it.broken, &it.repetitions);
            axis.ok_or_else(|| "the handle moved too little for a fit".to_owned())
        };
        Characterised {
            declared: self.declared,
            force_n: self.force_n,
            axes: self.axes.map(|axis| axis.map(|it| it.and_then(fitted))),
            echo_s: None,
            wall: None,
        }
    }
}

/// Measures a device that nobody holds. `tell` receives a line for each experiment.
///
/// Forces never exceed half of the declared peak, the continuous force, or [`Options::force_n`].
/// The measurement ends without force when the handle leaves 60 % of the workspace or the place of
/// its experiment, or moves faster than 0.5 m/s. It ends in the same way when the device is lost,
/// silent or at fault, or the clock ends.
///
/// # Errors
/// The reason for which an experiment was stopped.
pub fn measure(
    device: &mut dyn HapticDevice,
    clock: &mut dyn Clock,
    options: &Options,
    tell: &mut dyn FnMut(&str),
) -> Result<Records, Halt> {
    let declared = device.capabilities();
    let is_flat = device.freedom().rendered < 3;
    let mut bench = Bench::new(device, clock, options.force_n)?;
    let mut hold = Hold::new(&bench.now());
    let start_m = bench.now().at_m;
    let reach_m = MIDDLE * bench.region_m();
    let goal_m = start_m * (reach_m / start_m.norm().max(1e-9)).min(1.0);
    hold.settle(&mut bench, goal_m)?;
    if options.let_go_s > 0.0 {
        tell("Let go of the handle now: a spring holds it.");
        hold.keep(&mut bench, options.let_go_s)?;
        hold.settle(&mut bench, goal_m)?;
    }
    tell("weight and direction of all axes");
    let mut begin_n = [0.0; 3];
    for axis in (0..3).filter(|axis| !(is_flat && *axis == 1)) {
        if let Some([up, down]) = both_ways(&mut bench, &mut hold, goal_m, axis, 0.0)? {
            hold.know(axis, 0.5 * (up.force_n + down.force_n));
            begin_n[axis] = BEGIN * 0.5 * (up.force_n - down.force_n).max(0.0);
        }
    }
    let mut recorded: [Option<Result<Recorded, String>>; 3] = [const { None }; 3];
    for (at, name) in ["x", "y", "z"].into_iter().enumerate() {
        if !options.axes[at] {
            continue;
        }
        if is_flat && at == 1 {
            recorded[at] = Some(Err("a flat device has no motor along y".to_owned()));
            continue;
        }
        tell(&format!("{name}: friction, chirp and run-out"));
        recorded[at] = Some(one_axis(
            &mut bench,
            &mut hold,
            goal_m,
            (at, begin_n[at]),
            options,
        )?);
    }
    let force_n = bench.limit_n();
    let_go(&mut bench, &hold);
    Ok(Records {
        declared,
        force_n,
        axes: recorded,
    })
}

/// All experiments along one axis. A text gives the reason for which nothing can be measured.
fn one_axis(
    bench: &mut Bench<'_>,
    hold: &mut Hold,
    goal_m: Vector,
    (axis, begin_n): (usize, f64),
    options: &Options,
) -> Result<Result<Recorded, String>, Halt> {
    let mut broken = Vec::new();
    for _ in 0..options.repetitions.max(2) {
        let Some(pair) = both_ways(bench, hold, goal_m, axis, begin_n)? else {
            return Ok(Err(format!(
                "{:.2} N do not move the handle: no motor acts along this axis, or its friction is higher",
                bench.limit_n()
            )));
        };
        broken.push(pair);
    }
    let rough = rough_of(&broken);
    let middle_n = mean(&broken, |[up, down]| 0.5 * (up.force_n + down.force_n));
    hold.know(axis, middle_n);
    if !is_movable(bench, hold, axis, &rough) {
        return Ok(Err(format!(
            "weight and friction leave too little of {:.2} N to move the handle well: allow more with --force",
            bench.limit_n()
        )));
    }
    let mut repetitions = Vec::new();
    for number in 0..options.repetitions.max(2) {
        let sign = if number % 2 == 0 { 1.0 } else { -1.0 };
        let chirp = chirp(bench, hold, axis, &rough, sign)?;
        hold.settle(bench, goal_m)?;
        let there = push(bench, hold, axis, &rough, sign)?;
        hold.settle(bench, goal_m)?;
        let back = push(bench, hold, axis, &rough, -sign)?;
        hold.settle(bench, goal_m)?;
        let pushes = [there, back];
        repetitions.push(Repetition::new(&chirp, &pushes, axis));
    }
    Ok(Ok(Recorded {
        rough,
        broken,
        repetitions,
    }))
}

/// Break-away in both directions. `None` if the largest force does not move the handle.
fn both_ways(
    bench: &mut Bench<'_>,
    hold: &mut Hold,
    goal_m: Vector,
    axis: usize,
    begin_n: f64,
) -> Result<Option<[Broken; 2]>, Halt> {
    let mut pair = [None; 2];
    for (found, sign) in pair.iter_mut().zip([1.0, -1.0]) {
        *found = break_away(bench, hold, axis, sign, begin_n)?;
        hold.settle(bench, goal_m)?;
    }
    Ok(match pair {
        [Some(up), Some(down)] => Some([up, down]),
        _ => None,
    })
}

fn rough_of(broken: &[[Broken; 2]]) -> Rough {
    Rough {
        mass_kg: mean(broken, |[up, down]| 0.5 * (up.mass_kg + down.mass_kg)),
        friction_n: mean(broken, |[up, down]| 0.5 * (up.force_n - down.force_n)).max(0.0),
    }
}

fn mean(broken: &[[Broken; 2]], of: fn(&[Broken; 2]) -> f64) -> f64 {
    broken.iter().map(of).sum::<f64>() / broken.len().max(1) as f64
}

/// Lets the force fade. If the handle falls under its weight meanwhile, that is no failure.
fn let_go(bench: &mut Bench<'_>, hold: &Hold) {
    let begun_s = bench.now().at_s;
    loop {
        let now = bench.now();
        let left = 1.0 - (now.at_s - begun_s) / LET_GO_S;
        if left <= 0.0 || bench.tick(hold.force_n(&now) * left).is_err() {
            break;
        }
    }
    bench.cut();
}
