//! Force and torque on a tool.

use nalgebra::Vector3;

use super::case::{PORT_M, Placed};

type Point = Vector3<f64>;

/// Force on a tool, and torque about its port, in the axes of [`Placed`]: out of the body, along
/// the surface, across both. The force that a hand feels across the shaft is this torque divided by
/// the length outside the body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Wrench {
    /// Force, N.
    pub(crate) force_n: Point,
    /// Torque about the port, N m; NaN in references that were solved without it.
    pub(crate) torque_nm: Point,
}

/// Smallest force for which a relative error is meaningful, N. Below it the tool hardly touches.
pub(crate) const TOUCHES_N: f64 = 0.005;
/// Smallest torque for which a relative error is meaningful, N m: that of a transverse force
/// [`TOUCHES_N`] at the port's distance.
const TURNS_NM: f64 = TOUCHES_N * PORT_M;

impl Wrench {
    /// Makes a wrench from force and torque in the world's axes.
    pub(crate) fn new(placed: &Placed, force_n: &Point, torque_nm: &Point) -> Self {
        let axes = placed.axes();
        let turned = |v: &Point| Point::from(axes.map(|axis| axis.dot(v)));
        Self {
            force_n: turned(force_n),
            torque_nm: turned(torque_nm),
        }
    }

    /// Force out of the body, against the tool's motion, N.
    pub(crate) fn out_n(&self) -> f64 {
        self.force_n.x
    }

    /// Vector from the first point of contact to the force's line of action, perpendicular to the
    /// force, m. `port_m` is the port's position relative to that point, in the same axes.
    pub(crate) fn line_m(&self, port_m: &Point) -> Point {
        let about_site = self.torque_nm + port_m.cross(&self.force_n);
        self.force_n.cross(&about_site) / self.force_n.norm_squared()
    }
}

/// Root mean square of some relative errors, %; `None` without any.
fn rms_pct(errors: impl Iterator<Item = f64>) -> Option<f64> {
    let squares: Vec<f64> = errors.map(|e| e * e).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    (!squares.is_empty()).then(|| 100.0 * mean.sqrt())
}

/// Relative errors of the forces out of the body, at the depths that both have and at which the
/// tool touches.
pub(crate) fn force_errors<'a>(
    felt: &'a [Wrench],
    truth: &'a [Wrench],
) -> impl Iterator<Item = f64> + 'a {
    let pairs = felt.iter().zip(truth);
    let touching = pairs.filter(|(_, t)| t.out_n() >= TOUCHES_N);
    touching.map(|(f, t)| f.out_n() / t.out_n() - 1.0)
}

/// Root mean square of [`force_errors`], %; 0 if the tool never touches.
pub(crate) fn force_rms_pct(felt: &[Wrench], truth: &[Wrench]) -> f64 {
    rms_pct(force_errors(felt, truth)).unwrap_or(0.0)
}

/// Root mean square over the depths of the torque's relative error, %; `None` if the true torque is
/// nowhere known and large enough.
pub(crate) fn torque_rms_pct(felt: &[Wrench], truth: &[Wrench]) -> Option<f64> {
    let pairs = felt.iter().zip(truth);
    let turning = pairs.filter(|(_, t)| t.torque_nm.norm() >= TURNS_NM);
    rms_pct(turning.map(|(f, t)| (f.torque_nm - t.torque_nm).norm() / t.torque_nm.norm()))
}

/// Root mean square distance of the lines of action, mm; `None` if they are not known.
pub(crate) fn line_rms_mm(felt: &[Wrench], truth: &[Wrench], port_m: &Point) -> Option<f64> {
    let pairs = felt.iter().zip(truth);
    let known = pairs.filter(|(_, t)| t.out_n() >= TOUCHES_N && t.torque_nm.norm().is_finite());
    let off_m = known.map(|(f, t)| (f.line_m(port_m) - t.line_m(port_m)).norm());
    rms_pct(off_m).map(|pct| pct * 10.0) // % of a metre to mm
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(place_m: Point, port_m: &Point, force_n: Point) -> Wrench {
        Wrench {
            force_n,
            torque_nm: (place_m - port_m).cross(&force_n),
        }
    }

    #[test]
    fn a_line_of_action_goes_through_the_place_of_the_force() {
        let port_m = Point::new(0.15, 0.0, 0.0);
        let place_m = Point::new(-0.004, 0.003, -0.002);
        let felt = at(place_m, &port_m, Point::new(0.2, 0.0, 0.0));
        let line_m = felt.line_m(&port_m);
        assert!((line_m - Point::new(0.0, 0.003, -0.002)).norm() < 1e-12);
        let slanting = at(place_m, &port_m, Point::new(0.2, 0.01, -0.03));
        let off = place_m - slanting.line_m(&port_m);
        assert!(off.cross(&slanting.force_n).norm() < 1e-12);
    }

    #[test]
    fn errors_are_those_of_what_is_known_and_large_enough() {
        let port_m = Point::new(0.0, 0.15, 0.0);
        let truth = at(Point::zeros(), &port_m, Point::new(0.2, 0.0, 0.0));
        let mut felt = truth;
        felt.force_n *= 1.1;
        felt.torque_nm *= 1.1;
        assert!((force_rms_pct(&[felt], &[truth]) - 10.0).abs() < 1e-9);
        let torque = torque_rms_pct(&[felt], &[truth]).expect("large enough");
        assert!((torque - 10.0).abs() < 1e-9);
        assert!(line_rms_mm(&[felt], &[truth], &port_m).expect("known") < 1e-9);
        let moved = at(Point::new(0.0, 0.002, 0.0), &port_m, truth.force_n);
        let off_mm = line_rms_mm(&[moved], &[truth], &port_m).expect("known");
        assert!((off_mm - 2.0).abs() < 1e-9);
        let unknown = Wrench {
            torque_nm: Point::repeat(f64::NAN),
            ..truth
        };
        assert_eq!(torque_rms_pct(&[felt], &[unknown]), None);
        assert_eq!(line_rms_mm(&[felt], &[unknown], &port_m), None);
        let light = Wrench {
            force_n: Point::new(0.001, 0.0, 0.0),
            ..truth
        };
        assert_eq!(force_errors(&[felt], &[light]).count(), 0);
    }
}
