//! Closed titanium clips on vessels and ducts. Each is a rigid part, numbered after the parts of
//! the instrument.

use glam::{Mat4, Vec3, Vec4};
use shared_mem::message::{ClipMsg, MAX_CLIPPED, SphereState};
use shared_mem::scene::SphereRecord;

use super::look::BLADE;
use super::solid::{Finish, Solid, circle, curve};
use super::stones;

/// Index of the first clip among the rigid parts.
pub(super) const FIRST_PART: usize = 8;
const _: () = assert!(FIRST_PART + MAX_CLIPPED == stones::FIRST_PART);
/// Half length of a closed clip, mm.
const HALF_MM: f32 = 4.5;

/// All possible clips, around a tube of 1 mm radius. The tube runs along x. The open ends of the
/// legs point towards −z, and the legs are spread along y.
pub(super) fn all() -> Solid {
    let mut solid = Solid::default();
    for number in 0..MAX_CLIPPED as u32 {
        let mm = |y: f32, z: f32| Vec3::new(0.0, y, z) * 0.001;
        let path = curve(
            &[
                mm(0.25, -HALF_MM),
                mm(0.75, -2.4),
                mm(1.05, 0.0),
                mm(0.8, 2.6),
                mm(0.0, HALF_MM),
                mm(-0.8, 2.6),
                mm(-1.05, 0.0),
                mm(-0.75, -2.4),
                mm(-0.25, -HALF_MM),
            ],
            5,
        );
        let section = |_| circle(8).map(|c| c * 0.000_45).collect();
        let finish = Finish {
            look: BLADE,
            part: FIRST_PART as u32 + number,
        };
        solid.swept(&path, section, finish);
    }
    solid
}

/// Poses of the clips, widened to their tubes. A missing clip has size 0.
pub(super) fn places(
    clips: &[ClipMsg],
    spheres: &[SphereState],
    rest: &[SphereRecord],
) -> [Mat4; MAX_CLIPPED] {
    let mut places = [Mat4::ZERO; MAX_CLIPPED];
    for (place, clip) in places.iter_mut().zip(clips) {
        let [a, b] = clip.spheres.map(|it| it as usize);
        let (Some(from), Some(to), Some(tube)) = (spheres.get(a), spheres.get(b), rest.get(a))
        else {
            continue;
        };
        let (from_m, to_m) = (Vec3::from(from.center_m), Vec3::from(to.center_m));
        let along = (to_m - from_m).normalize_or(Vec3::X);
        let legs = Vec3::from(clip.legs);
        let legs = (legs - along * along.dot(legs)).normalize_or(along.any_orthonormal_vector());
        let spread = -legs.cross(along);
        let at_m = from_m.lerp(to_m, clip.share);
        // The tube is drawn round, so the legs are spread by its radius.
        let radii = (tube.radius_m * 1000.0).max(0.2);
        *place = Mat4::from_cols(
            along.extend(0.0),
            (spread * radii).extend(0.0),
            -legs.extend(0.0),
            Vec4::from((at_m, 1.0)),
        );
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn clips_lie_across_their_tube_and_absent_ones_are_nowhere() {
        let sphere = |x: f32| SphereState {
            center_m: [x, 0.0, 0.0],
            ..SphereState::zeroed()
        };
        let rest = SphereRecord {
            radius_m: 0.002,
            ..SphereRecord::zeroed()
        };
        let clip = ClipMsg {
            spheres: [0, 1],
            share: 0.25,
            legs: [0.3, 0.0, 1.0],
            ..ClipMsg::zeroed()
        };
        let wrong = ClipMsg {
            spheres: [0, 9],
            ..clip
        };
        let places = places(&[clip, wrong], &[sphere(0.0), sphere(0.004)], &[rest; 2]);
        let at = |p: Vec3| places[0].transform_point3(p);
        assert!(at(Vec3::ZERO).distance(Vec3::new(0.001, 0.0, 0.0)) < 1e-6);
        assert!(
            at(-Vec3::Z).distance(Vec3::new(0.001, 0.0, 1.0)) < 1e-5,
            "open ends"
        );
        assert!(
            (places[0].determinant() - 2.0).abs() < 1e-4,
            "right-handed, twice as wide"
        );
        assert_eq!(places[1..], [Mat4::ZERO; MAX_CLIPPED - 1]);
    }
}
