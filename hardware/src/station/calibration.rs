//! Computes the pose of a device from landmarks. The pose is the rigid motion that maps the
//! measured positions of the landmarks to their known positions.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use rt_core::math::{Pose, Vec3};

/// Fewest landmarks that determine a pose.
pub const LANDMARKS_MIN: usize = 3;
/// Smallest spread of the landmarks across the line along which they spread most, m. With a smaller
/// spread, the rotation about that line is unknown.
const SPREAD_MIN_M: f32 = 0.01;

/// Pose of a device, and the quality of the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Frame of the device in the world.
    pub world_from_device: Pose,
    /// Root mean square of the residuals, m.
    pub rms_m: f32,
    /// Largest residual, m.
    pub worst_m: f32,
    /// Index of the landmark that fits the others least: without it, the residual is smallest.
    /// `None` for three landmarks, because any two fit.
    pub odd_one: Option<usize>,
}

/// Reasons for which no fit is possible.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoFit {
    /// Too few landmarks.
    #[error(
        "{0} landmarks are too few: a frame needs {LANDMARKS_MIN} or more; name them in the station file"
    )]
    TooFew(usize),
    /// All landmarks lie on one line.
    #[error(
        "the landmarks lie on a line, within {0:.4} m: choose one that is {SPREAD_MIN_M} m or more off it"
    )]
    OnALine(f32),
    /// A measurement is not finite.
    #[error("a measured position is not finite: check the device with `calot devices watch`")]
    NotFinite,
}

/// Least-squares rigid motion (Kabsch 1976, Umeyama 1991). `pairs` holds measured and known
/// positions, m.
pub fn fit(pairs: &[(Vec3, Vec3)]) -> Result<Fit, NoFit> {
    let whole = least_squares(pairs)?;
    let without = |landmark: &usize| {
        let mut others = pairs.to_vec();
        others.remove(*landmark);
        least_squares(&others).map_or(f32::INFINITY, |fit| fit.rms_m)
    };
    let odd_one = (0..pairs.len())
        .filter(|_| pairs.len() > LANDMARKS_MIN)
        .min_by(|a, b| without(a).total_cmp(&without(b)));
    Ok(Fit { odd_one, ..whole })
}

fn least_squares(pairs: &[(Vec3, Vec3)]) -> Result<Fit, NoFit> {
    if pairs.len() < LANDMARKS_MIN {
        return Err(NoFit::TooFew(pairs.len()));
    }
    if !pairs
        .iter()
        .all(|(a, b)| (a + b).iter().all(|x| x.is_finite()))
    {
        return Err(NoFit::NotFinite);
    }
    let count = pairs.len() as f32;
    let mean = |of: fn(&(Vec3, Vec3)) -> Vec3| pairs.iter().map(of).sum::<Vec3>() / count;
    let (measured, known) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let spread = |of: fn(&(Vec3, Vec3)) -> Vec3, middle: Vec3| {
        let about: Matrix3<f32> = pairs
            .iter()
            .map(|pair| (of(pair) - middle) * (of(pair) - middle).transpose())
            .sum();
        // The second largest is the spread across the line along which the landmarks spread most.
        let mut across = about.symmetric_eigenvalues().map(|x| x.max(0.0).sqrt());
        across.as_mut_slice().sort_by(f32::total_cmp);
        across[1]
    };
    let across_m = spread(|pair| pair.0, measured).min(spread(|pair| pair.1, known));
    if across_m < SPREAD_MIN_M {
        return Err(NoFit::OnALine(across_m));
    }
    let covariance: Matrix3<f32> = pairs
        .iter()
        .map(|(a, b)| (b - known) * (a - measured).transpose())
        .sum();
    let parts = covariance.svd(true, true);
    let (Some(u), Some(v_t)) = (parts.u, parts.v_t) else {
        return Err(NoFit::NotFinite);
    };
    // A reflection is not a rigid motion, so the weakest of the three directions is flipped.
    let mut signs = Vec3::new(1.0, 1.0, 1.0);
    if (u * v_t).determinant() < 0.0 {
        signs[parts.singular_values.imin()] = -1.0;
    }
    let turn = u * Matrix3::from_diagonal(&signs) * v_t;
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    let world_from_device = Pose::from_parts((known - rotation * measured).into(), rotation);
    let left = pairs.iter().map(|(a, b)| {
        (world_from_device * nalgebra::Point3::from(*a) - b)
            .coords
            .norm()
    });
    let rms_m = (left.clone().map(|x| x * x).sum::<f32>() / count).sqrt();
    Ok(Fit {
        world_from_device,
        rms_m,
        worst_m: left.fold(0.0, f32::max),
        odd_one: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const KNOWN: [[f32; 3]; 5] = [
        [0.1, 0.0, 0.0],
        [-0.1, 0.0, 0.02],
        [0.0, 0.12, 0.0],
        [0.02, -0.05, 0.1],
        [-0.06, -0.04, -0.05],
    ];

    fn pose() -> impl Strategy<Value = Pose> {
        (
            [-1.0f32..1.0, -1.0..1.0, -1.0..1.0],
            [-3.0f32..3.0, -3.0..3.0, -3.0..3.0],
        )
            .prop_map(|(at, turn)| {
                let turn = UnitQuaternion::from_scaled_axis(Vec3::from(turn));
                Pose::from_parts(Vec3::from(at).into(), turn)
            })
    }

    proptest! {
        /// Any pose of the device is found, and the residual is the noise.
        #[test]
        fn calibration_finds_the_frame(
            world_from_device in pose(), count in 3usize..6,
            noise in prop::collection::vec([-5e-4f32..5e-4, -5e-4..5e-4, -5e-4..5e-4], 5),
            noisy in any::<bool>(),
        ) {
            let pairs: Vec<(Vec3, Vec3)> = KNOWN.iter().zip(&noise).take(count).map(|(known, noise)| {
                let known = Vec3::from(*known);
                let measured = world_from_device.inverse() * nalgebra::Point3::from(known);
                let noise = if noisy { Vec3::from(*noise) } else { Vec3::zeros() };
                (measured.coords + noise, known)
            }).collect();
            let fit = fit(&pairs).unwrap();
            let off = fit.world_from_device.inverse() * world_from_device;
            let (limit_m, limit_rad) = if noisy { (8e-3, 2e-2) } else { (1e-5, 1e-4) };
            prop_assert!(off.translation.vector.norm() < limit_m + limit_rad, "{off}");
            prop_assert!(off.rotation.angle() < limit_rad, "{off}");
            prop_assert!(fit.rms_m <= fit.worst_m * 1.000_1 + 1e-9);
            let left_m = if noisy { 9e-4 } else { 1e-6 };
            prop_assert!(fit.rms_m < left_m);
        }

        #[test]
        fn calibration_never_panics(values in prop::collection::vec((any::<[f32; 3]>(), any::<[f32; 3]>()), 0..6)) {
            let pairs: Vec<_> =
                values.into_iter().map(|(a, b)| (Vec3::from(a), Vec3::from(b))).collect();
            let _ = fit(&pairs);
        }
    }

    #[test]
    fn landmarks_that_determine_no_frame_are_refused() {
        let at = |x: f32| (Vec3::new(x, 0.0, 0.0), Vec3::new(0.0, x, 0.0));
        assert_eq!(fit(&[at(0.0), at(1.0)]), Err(NoFit::TooFew(2)));
        assert!(matches!(
            fit(&[at(0.0), at(0.1), at(0.3)]),
            Err(NoFit::OnALine(_))
        ));
        let nan = (Vec3::new(f32::NAN, 0.0, 0.0), Vec3::zeros());
        assert_eq!(fit(&[at(0.0), at(1.0), nan]), Err(NoFit::NotFinite));
    }

    #[test]
    fn a_landmark_that_was_missed_is_named() {
        let mut pairs = KNOWN.map(|known| (Vec3::from(known), Vec3::from(known)));
        pairs[2].0.z += 0.02;
        let fit = fit(&pairs).unwrap();
        assert_eq!(fit.odd_one, Some(2));
        assert!(fit.rms_m > 3e-3);
        assert_eq!(super::fit(&pairs[..3]).unwrap().odd_one, None);
    }
}
