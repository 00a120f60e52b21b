//! Instrument against endoscope: steel on steel. The hand feels the contact; the endoscope does not
//! yield.

use heapless::Vec;

use crate::capacity::MAX_CAPSULES;
use crate::contact::contact_force::ContactForce;
use crate::contact::separation::FilteredSeparation;
use crate::math::{self, Vec3};
use crate::tool::{Capsule, Role, Tool};

/// Stiffness of the contact, N/m. It feels hard to a hand. The output limit lowers it to the
/// stiffness that the device can render.
const STIFFNESS_N_M: f32 = 2000.0;
/// A part that is closer than this is tracked, m. At up to 3 m/s each, both tools together travel
/// less in a tick, so the part's side is known before it touches.
const NEAR_M: f32 = 0.0065;

/// Largest gap, m, across which a contact that has opened still pushes for a short time.
const OPENING_MAX_M: f32 = 0.000_5;
/// Travel of both tools in a tick that counts as a jump of the pose, m. A pose jumps after its
/// device was unplugged or stalled.
const MOTION_MAX_M: f32 = 0.02;

/// A part of the instrument near the endoscope, at the end of a tick.
#[derive(Debug, Clone, Copy)]
struct PersistentContact {
    part: Role,
    /// Unit vector from the endoscope to the part.
    normal: Vec3,
    /// Place of closest approach on each axis, 0 to 1.
    nearest: [f32; 2],
    /// Place on the part's axis where the contact is felt, 0 to 1: near the middle of the overlap
    /// along the axes.
    felt_at: f32,
    separation: FilteredSeparation,
    /// Ends of the part's axis and of the endoscope's, m.
    ends_m: [Vec3; 4],
}

/// All parts of the instrument near the endoscope.
#[derive(Debug, Clone, Default)]
pub(crate) struct RigidContacts {
    contacts: Vec<PersistentContact, MAX_CAPSULES>,
}

impl RigidContacts {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.contacts.clear();
    }

    /// Finds contacts of the instrument and the endoscope among `parts`.
    pub(crate) fn find(&mut self, parts: &[Capsule], mut add: impl FnMut(ContactForce)) {
        let before = core::mem::take(&mut self.contacts);
        let Some(scope) = parts.iter().find(|part| part.role == Role::Endoscope) else {
            return;
        };
        for part in parts.iter().filter(|part| part.role != Role::Endoscope) {
            let last = before.iter().find(|last| last.part == part.role);
            let Some(contact) = track(part, scope, last) else {
                continue;
            };
            let depth_m = (-contact.separation.separation_m).max(0.0);
            if depth_m > 0.0 {
                add(ContactForce {
                    tool: Tool::Instrument,
                    organ: None,
                    at_m: point_at(part, contact.felt_at) - contact.normal * part.radius_m,
                    normal: contact.normal,
                    force_n: STIFFNESS_N_M * depth_m,
                    stiffness_n_m: STIFFNESS_N_M,
                    friction_n: Vec3::zeros(),
                    friction_stiffness_n_m: 0.0,
                });
            }
            let _ = self.contacts.push(contact); // there is room for all parts
        }
    }
}

/// Tracks a part. A part that overlaps the endoscope is first lifted out along the last normal;
/// then its closest approach is found. So the part cannot pass through the endoscope within a tick.
/// `None` if the part is far from the endoscope.
fn track(
    part: &Capsule,
    scope: &Capsule,
    last: Option<&PersistentContact>,
) -> Option<PersistentContact> {
    let reach_m = part.radius_m + scope.radius_m;
    // Distance of the axes along `normal`, from the endoscope's place to the part's.
    let height_m = |normal: &Vec3, shares: &[f32; 2]| {
        let [s, t] = shares;
        normal.dot(&(point_at(part, *s) - point_at(scope, *t)))
    };
    let ends_m = [part.a_m, part.b_m, scope.a_m, scope.b_m];
    let travel_m = last.map(|last| {
        let moved_m = last.ends_m.iter().zip(&ends_m);
        let moved_m = moved_m.map(|(before, now)| math::norm(&(now - before)));
        // Both tools may have moved towards each other.
        2.0 * moved_m.fold(0.0, f32::max)
    });
    // After a jump the last side is not valid.
    let last = last.filter(|_| travel_m.is_some_and(|travel_m| travel_m < MOTION_MAX_M));
    let lift_m = last.map_or_else(Vec3::zeros, |last| {
        last.normal * (reach_m - height_m(&last.normal, &last.nearest)).max(0.0)
    });
    let lifted = Capsule {
        a_m: part.a_m + lift_m,
        b_m: part.b_m + lift_m,
        ..*part
    };
    let nearest = nearest(&lifted, scope);
    let from_scope_m = point_at(&lifted, nearest[0]) - point_at(scope, nearest[1]);
    let side = last.map(|last| last.normal);
    let normal = math::unit(&from_scope_m).or(side)?;
    let separation_m = height_m(&normal, &nearest) - reach_m;
    if separation_m > NEAR_M {
        return None;
    }
    let separation = last.zip(travel_m).map_or_else(
        || FilteredSeparation::first(separation_m),
        |(last, travel_m)| last.separation.next(separation_m, travel_m, OPENING_MAX_M),
    );
    Some(PersistentContact {
        part: part.role,
        normal,
        nearest,
        felt_at: middle_of_overlap(&lifted, scope),
        separation,
        ends_m,
    })
}

/// Point of an axis at this share of its length.
fn point_at(part: &Capsule, share: f32) -> Vec3 {
    part.a_m + (part.b_m - part.a_m) * share
}

/// Closest places of two axes, 0 to 1 on each: an end of either, or the crossing. Rounding makes
/// the crossing of nearly parallel axes inexact. There, an end is as close as the crossing.
fn nearest(one: &Capsule, other: &Capsule) -> [f32; 2] {
    let (d1, d2) = (one.b_m - one.a_m, other.b_m - other.a_m);
    let r = one.a_m - other.a_m;
    let a = d1.norm_squared().max(1.0e-12);
    let e = d2.norm_squared().max(1.0e-12);
    let (b, c, f) = (d1.dot(&d2), d1.dot(&r), d2.dot(&r));
    let on_one = |t: f32| [((b * t - c) / a).clamp(0.0, 1.0), t];
    let on_other = |s: f32| [s, ((b * s + f) / e).clamp(0.0, 1.0)];
    // Ericson 2004, section 5.1.9.
    let crossing = ((b * f - c * e) / (a * e - b * b).max(1.0e-6 * a * e)).clamp(0.0, 1.0);
    let mut best = on_one(on_other(crossing)[1]);
    let squared_m2 = |[s, t]: [f32; 2]| (point_at(one, s) - point_at(other, t)).norm_squared();
    for ends in [on_other(0.0), on_other(1.0), on_one(0.0), on_one(1.0)] {
        if squared_m2(ends) < squared_m2(best) {
            best = ends;
        }
    }
    best
}

/// Weight of the middle of the overlap against the closest approach. Parallel axes are equally
/// close everywhere, so the place of closest approach jumps from one end to the other as the axes
/// turn through parallel. With this weight the contact moves from end to end through the middle
/// without a jump, while the axes turn by a few times `√MIDDLE_WEIGHT` (2°). With a larger weight
/// it moves more slowly.
const MIDDLE_WEIGHT: f32 = 1.0e-3;

/// Place on the first axis, 0 to 1, where the contact is felt. It minimises the squared distance
/// plus [`MIDDLE_WEIGHT`] times the squared distances of both places from the middle of the
/// overlap.
fn middle_of_overlap(one: &Capsule, other: &Capsule) -> f32 {
    let (d1, d2) = (one.b_m - one.a_m, other.b_m - other.a_m);
    let r = one.a_m - other.a_m;
    let a = d1.norm_squared().max(1.0e-12);
    let e = d2.norm_squared().max(1.0e-12);
    let (b, c, f) = (d1.dot(&d2), d1.dot(&r), d2.dot(&r));
    // Middles of the projections of each axis on the other.
    let s_middle = middle(-c / a, (b - c) / a);
    let t_middle = middle(f / e, (b + f) / e);
    // At the minimum: `p s − b t = u` and `q t − b s = v`.
    let (p, q) = (a * (1.0 + MIDDLE_WEIGHT), e * (1.0 + MIDDLE_WEIGHT));
    let (u, v) = (
        MIDDLE_WEIGHT * a * s_middle - c,
        MIDDLE_WEIGHT * e * t_middle + f,
    );
    let s = ((u * q + v * b) / (p * q - b * b)).clamp(0.0, 1.0);
    let t = ((b * s + v) / q).clamp(0.0, 1.0);
    ((b * t + u) / p).clamp(0.0, 1.0)
}

/// Middle of the part of an axis, 0 to 1, between two places.
fn middle(one: f32, other: f32) -> f32 {
    let (one, other) = (one.clamp(0.0, 1.0), other.clamp(0.0, 1.0));
    0.5 * (one + other)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::testing::vector;
    use proptest::prelude::*;

    fn rod(a_m: Vec3, b_m: Vec3, role: Role) -> Capsule {
        let radius_m = if role == Role::Endoscope {
            0.005
        } else {
            0.0025
        };
        Capsule {
            a_m,
            b_m,
            radius_m,
            role,
        }
    }

    /// Distance between two axes, m: from every end to the other axis, and at the crossing, in
    /// double precision.
    fn exact_m(one: &Capsule, other: &Capsule) -> f64 {
        let [a, b, c, d] = [one.a_m, one.b_m, other.a_m, other.b_m].map(|p| p.cast::<f64>());
        let to_axis = |p: nalgebra::Vector3<f64>, [a, b]: [nalgebra::Vector3<f64>; 2]| {
            let share = (p - a).dot(&(b - a)) / (b - a).norm_squared();
            (p - a - (b - a) * share.clamp(0.0, 1.0)).norm()
        };
        let ends = [
            to_axis(a, [c, d]),
            to_axis(b, [c, d]),
            to_axis(c, [a, b]),
            to_axis(d, [a, b]),
        ];
        let across = (b - a).cross(&(d - c));
        // Shares at which the axes cross.
        let share = |direction: nalgebra::Vector3<f64>| {
            (c - a).cross(&direction).dot(&across) / across.norm_squared()
        };
        let cross = [share(d - c), share(b - a)]
            .iter()
            .all(|s| (0.0..1.0).contains(s));
        let distance = (c - a).dot(&across).abs() / across.norm();
        ends.into_iter()
            .fold(if cross { distance } else { f64::MAX }, f64::min)
    }

    /// The endoscope lies on x; a shaft along y comes down on it by `step_m` a tick.
    fn lower_shaft(step_m: f32, ticks: u16) -> std::vec::Vec<ContactForce> {
        let scope = rod(Vec3::zeros(), Vec3::x() * 0.2, Role::Endoscope);
        let mut rigid = RigidContacts::default();
        let mut last = std::vec::Vec::new();
        for tick in 0..ticks {
            let at_m = Vec3::new(0.1, 0.0, 0.0105 - step_m * f32::from(tick));
            let shaft = rod(at_m - Vec3::y() * 0.1, at_m + Vec3::y() * 0.1, Role::Shaft);
            last.clear();
            rigid.find(&[shaft, scope], |contact| last.push(contact));
        }
        last
    }

    #[test]
    fn endoscope_pushes_the_shaft_and_is_not_crossed() {
        // The shaft begins 3 mm above contact. After 7 ticks of 0.5 mm it is 0.5 mm deep.
        let contacts = lower_shaft(0.0005, 8);
        assert_eq!(contacts.len(), 1);
        assert!((contacts[0].force_n - 1.0).abs() < 1.0e-2, "{contacts:?}");
        assert!(contacts[0].normal.z > 0.999 && contacts[0].tool == Tool::Instrument);
        // At 3 m/s the shaft ends far below the endoscope, but the push is still upwards.
        let contacts = lower_shaft(0.003, 8);
        assert!(
            contacts[0].normal.z > 0.999 && contacts[0].force_n > 10.0,
            "{contacts:?}"
        );
        assert!(lower_shaft(0.0001, 20).is_empty());
    }

    #[test]
    fn force_is_the_same_whichever_tool_moves() {
        let shaft = rod(Vec3::y() * -0.1, Vec3::y() * 0.1, Role::Shaft);
        let mut rigid = RigidContacts::default();
        let mut last = std::vec::Vec::new();
        for tick in 0..8 {
            let at_m = Vec3::new(-0.1, 0.0, -0.0105 + 0.0005 * tick as f32);
            let scope = rod(at_m, at_m + Vec3::x() * 0.2, Role::Endoscope);
            last.clear();
            rigid.find(&[shaft, scope], |contact| last.push(contact));
        }
        let by_shaft = lower_shaft(0.0005, 8);
        assert_eq!(last.len(), 1);
        let difference_n = last[0].force_n - by_shaft[0].force_n;
        assert!(difference_n.abs() < 1.0e-2, "{last:?} {by_shaft:?}");
    }

    #[test]
    fn jump_through_the_endoscope_makes_no_contact() {
        let scope = rod(Vec3::zeros(), Vec3::x() * 0.2, Role::Endoscope);
        let mut rigid = RigidContacts::default();
        for z_m in [0.008, -0.030, -0.004] {
            let at_m = Vec3::new(0.1, 0.0, z_m);
            let shaft = rod(at_m - Vec3::y() * 0.1, at_m + Vec3::y() * 0.1, Role::Shaft);
            let mut force_n = 0.0;
            rigid.find(&[shaft, scope], |contact| force_n += contact.force_n);
            assert!(force_n < 0.1, "{force_n} N at {z_m} m");
        }
    }

    proptest! {
        /// No two places of the axes are closer than the closest approach.
        #[test]
        fn no_places_of_two_axes_are_closer_than_the_nearest(a in vector(1.0), b in vector(1.0), c in vector(1.0), d in vector(1.0),
                          u in 0.0f32..1.0, v in 0.0f32..1.0) {
            let (one, other) = (rod(a, b, Role::Shaft), rod(c, d, Role::Endoscope));
            let [s, t] = nearest(&one, &other);
            let found = math::norm(&(point_at(&one, s) - point_at(&other, t)));
            let any = math::norm(&(point_at(&one, u) - point_at(&other, v)));
            prop_assert!(found <= any + 1.0e-4, "{found} {any}");
        }

        /// The force of a shaft that rests on the endoscope follows from the true overlap of the
        /// capsules. This holds at any angle and any place of contact along both axes.
        #[test]
        fn steel_force_follows_from_the_true_overlap(
            along_m in -0.1f32..0.1, length_m in 0.05f32..0.25, pivot in 0.0f32..1.0, depth_m in 1.0e-4f32..1.0e-3,
            turn in -0.2f32..0.2, tilt in -0.02f32..0.02,
        ) {
            let scope = rod(Vec3::zeros(), Vec3::x() * 0.2, Role::Endoscope);
            let direction = Vec3::new(turn.cos() * tilt.cos(), turn.sin() * tilt.cos(), tilt.sin());
            let a_m = Vec3::new(0.1 + along_m, 0.0, 0.0) - direction * (length_m * pivot);
            let shaft = |z_m: f32| {
                let a_m = a_m + Vec3::z() * z_m;
                rod(a_m, a_m + direction * length_m, Role::Shaft)
            };
            // The height at which they overlap by this depth.
            let (mut low_m, mut high_m) = (0.001, 0.05f32);
            for _ in 0..40 {
                let middle_m = 0.5 * (low_m + high_m);
                let is_high = exact_m(&shaft(middle_m), &scope) > 0.0075 - f64::from(depth_m);
                if is_high { high_m = middle_m } else { low_m = middle_m }
            }
            let mut rigid = RigidContacts::default();
            let mut force_n = 0.0;
            for tick in 0u16..1500 {
                let above_m = 0.002 * (1.0 - f32::from(tick) / 200.0).max(0.0);
                force_n = 0.0;
                rigid.find(&[shaft(high_m + above_m), scope], |contact| force_n += contact.force_n);
            }
            let error_m = force_n / STIFFNESS_N_M - depth_m;
            prop_assert!(error_m.abs() < 1.0e-5, "off by {error_m} m");
        }

        /// A shaft rests on the endoscope and turns through parallel by a milliradian a tick
        /// (60°/s). Neither its contact point nor its force has a step, at any place of contact
        /// along both axes.
        #[test]
        fn turn_through_parallel_has_no_step(
            along_m in -0.1f32..0.1, length_m in 0.05f32..0.25, pivot in 0.0f32..1.0,
            depth_m in 1.0e-4f32..1.0e-3,
        ) {
            let scope = rod(Vec3::zeros(), Vec3::x() * 0.2, Role::Endoscope);
            let mut rigid = RigidContacts::default();
            let mut last: Option<ContactForce> = None;
            for tick in -200i16..200 {
                let turn = 1.0e-3 * f32::from(tick);
                let direction = Vec3::new(turn.cos(), turn.sin(), 0.0);
                // The shaft descends in the first hundred ticks, more slowly than the contact's
                // offset decays.
                let down_m = depth_m * (f32::from(tick + 200) / 100.0).min(1.0);
                let at_m = Vec3::new(0.1 + along_m, 0.0, 0.0075 - down_m);
                let a_m = at_m - direction * (length_m * pivot);
                let shaft = rod(a_m, a_m + direction * length_m, Role::Shaft);
                let mut now = None;
                rigid.find(&[shaft, scope], |contact| now = Some(contact));
                if let (Some(last), Some(now)) = (&last, &now) {
                    let step_m = math::norm(&(now.at_m - last.at_m));
                    prop_assert!(step_m < 0.025 * length_m.max(0.2), "{step_m} m at {turn}");
                    let step_n = now.normal * now.force_n - last.normal * last.force_n;
                    prop_assert!(math::norm(&step_n) < 0.06, "{step_n} N at {turn}");
                }
                last = now;
            }
        }
    }
}
