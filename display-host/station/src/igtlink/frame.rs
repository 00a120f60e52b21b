//! Frames of the sent poses.

use clap::ValueEnum;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// Frame of the sent poses: names of its axes x, y and z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum Frame {
    /// Right, anterior, superior: 3D Slicer's frame
    #[default]
    Ras,
    /// Left, posterior, superior: DICOM's and ITK's frame
    Lps,
    /// Left, superior, anterior: Calot's own frame
    Scene,
}

impl Frame {
    /// Name in arguments and messages.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Ras => "ras",
            Self::Lps => "lps",
            Self::Scene => "scene",
        }
    }

    /// Rows of the rotation from the scene's axes (left, head, front) to the frame's.
    #[rustfmt::skip]
    const fn rows(self) -> [[f32; 3]; 3] {
        match self {
            Self::Ras => [[-1.0, 0.0, 0.0],
                          [ 0.0, 0.0, 1.0],
                          [ 0.0, 1.0, 0.0]],
            Self::Lps => [[1.0, 0.0,  0.0],
                          [0.0, 0.0, -1.0],
                          [0.0, 1.0,  0.0]],
            Self::Scene => [[1.0, 0.0, 0.0],
                            [0.0, 1.0, 0.0],
                            [0.0, 0.0, 1.0]],
        }
    }

    fn matrix(self) -> Matrix3<f32> {
        Matrix3::from_row_iterator(self.rows().as_flattened().iter().copied())
    }

    /// A vector of the scene, in this frame.
    pub(super) fn vector(self, in_scene: Vector3<f32>) -> Vector3<f32> {
        self.matrix() * in_scene
    }

    /// A pose in the scene, in this frame. The body's own axes stay as they are.
    pub(super) fn pose(self, scene_from_body: &Isometry3<f32>) -> Isometry3<f32> {
        let turn = Rotation3::from_matrix_unchecked(self.matrix());
        let turn = UnitQuaternion::from_rotation_matrix(&turn);
        Isometry3::from_parts(
            Translation3::from(self.vector(scene_from_body.translation.vector)),
            turn * scene_from_body.rotation,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Towards the patient's left, head and front in the scene: its axes x, y and z.
    const LEFT: Vector3<f32> = Vector3::new(1.0, 0.0, 0.0);
    const HEAD: Vector3<f32> = Vector3::new(0.0, 1.0, 0.0);
    const FRONT: Vector3<f32> = Vector3::new(0.0, 0.0, 1.0);

    #[test]
    fn every_frame_is_a_rotation_of_the_scene() {
        for frame in Frame::value_variants() {
            let matrix = frame.matrix();
            assert!((matrix.determinant() - 1.0).abs() < 1e-6, "{frame:?}");
            let unit = matrix * matrix.transpose();
            assert!((unit - Matrix3::identity()).norm() < 1e-6, "{frame:?}");
        }
    }

    #[test]
    fn directions_of_the_patient_are_where_each_frame_has_them() {
        let of = |frame: Frame| [LEFT, HEAD, FRONT].map(|it| <[f32; 3]>::from(frame.vector(it)));
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let minus = |axis: [f32; 3]| axis.map(|part| 0.0 - part);
        // In R-A-S, left is −x, the head is z and the front is y.
        assert_eq!(of(Frame::Ras), [minus(x), z, y]);
        assert_eq!(of(Frame::Lps), [x, z, minus(y)]);
        assert_eq!(of(Frame::Scene), [x, y, z]);
    }

    #[test]
    fn poses_of_known_points_map_as_expected() {
        // The tip lies 20 mm down the shaft, along the instrument's −z. The shaft points at the
        // head, and so the tip lies 20 mm nearer to the head than the joint of the jaws.
        let turn = UnitQuaternion::rotation_between(&-FRONT, &HEAD).unwrap();
        let joint = Translation3::new(0.01, 0.02, 0.03);
        let scene_from_tool = Isometry3::from_parts(joint, turn);
        let tip = nalgebra::Point3::new(0.0, 0.0, -0.02);
        for (frame, expected) in [
            (Frame::Scene, [0.01, 0.04, 0.03]),
            (Frame::Ras, [-0.01, 0.03, 0.04]),
            (Frame::Lps, [0.01, -0.03, 0.04]),
        ] {
            let sent = frame.pose(&scene_from_tool) * tip;
            assert!(
                (sent.coords - Vector3::from(expected)).norm() < 1e-6,
                "{frame:?}: {sent}"
            );
        }
    }

    #[test]
    fn the_help_shows_the_matrices() {
        let help = super::super::HELP.replace(' ', "");
        for frame in [Frame::Ras, Frame::Lps] {
            for row in frame.rows() {
                let row = row.map(|part| format!("{part}"));
                assert!(
                    help.contains(&format!("({})", row.join(","))),
                    "{frame:?}: {row:?}"
                );
            }
        }
    }
}
