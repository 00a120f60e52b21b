//! The experiments in which nobody holds the handle, axis by axis.

use rt_core::port::{DeviceCapabilities, HapticDevice};

use super::axis::{Recorded, both_ways, one_axis};
use super::bench::{Bench, Clock};
use super::halt::Halt;
use super::hold::Hold;
use super::opening::{RecordedOpening, opening};
use super::result::Characterised;

/// Largest distance from the middle of the workspace at which experiments begin, as a share of the
/// region.
const MIDDLE: f64 = 0.3;
/// Share of the first measured friction with which the force of later break-away experiments
/// begins.
const BEGIN: f64 = 0.6;
/// Time over which the force fades at the end, s.
const LET_GO_S: f64 = 0.5;

/// Options of the experiments in which nobody holds the handle.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Axes x, y, z to be measured.
    pub axes: [bool; 3],
    /// True to measure the opening as well, if the handle opens.
    pub opening: bool,
    /// Largest force, N. `None` means 1 N, or less if the device's limits are lower.
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
            opening: true,
            force_n: None,
            repetitions: 3,
            let_go_s: 0.0,
        }
    }
}

/// Records of all experiments.
#[derive(Debug, Clone)]
pub struct Records {
    declared: DeviceCapabilities,
    force_n: f64,
    axes: [Option<Result<Recorded, String>>; 3],
    opening: Option<Result<RecordedOpening, String>>,
}

impl Records {
    /// Records of a device without any experiment.
    #[must_use]
    pub fn none(device: &dyn HapticDevice) -> Self {
        Self {
            declared: device.capabilities(),
            force_n: 0.0,
            axes: [const { None }; 3],
            opening: None,
        }
    }

    /// Fits the models. The computation takes seconds and needs no device.
    #[must_use]
    pub fn analyse(self) -> Characterised {
        let axes = self.axes;
        Characterised {
            declared: self.declared,
            force_n: self.force_n,
            axes: axes.map(|axis| axis.map(|it| it.and_then(|it| it.fitted()))),
            opening: self.opening.map(|it| it.and_then(|it| it.fitted())),
            echo_s: None,
            wall: None,
            opening_wall: None,
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
    let reach_m = MIDDLE * bench.reach_m(0);
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
            hold.set_holding(axis, 0.5 * (up.force_n + down.force_n));
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
            options.repetitions,
        )?);
    }
    let force_n = bench.limits().handle_n;
    let opening = match options.opening && declared.opening.is_measured() {
        true => Some(opening(
            &mut bench,
            &mut hold,
            goal_m,
            options.repetitions,
            tell,
        )?),
        false => None,
    };
    fade_out(&mut bench, &hold);
    Ok(Records {
        declared,
        force_n,
        axes: recorded,
        opening,
    })
}

/// Lets the force fade. The handle may fall under its weight meanwhile; that is no failure.
fn fade_out(bench: &mut Bench<'_>, hold: &Hold) {
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
