//! The loop of hand, instrument and tissue generates no energy, and does not depend on the
//! orientation of the room.

use super::tear::{BITTEN, pad};
use super::*;
use crate::rig::LEVER;
use proptest::prelude::*;
use rt_core::math::Quat;

/// Number of random cases of each test. 300 cases have been run once; in each of them, the hand
/// gave energy.
const CASES: u32 = 12;

/// A segment of the hand's path: target of the tip, and speed.
#[derive(Debug, Clone, Copy)]
struct Leg {
    to_m: Vec3,
    speed_m_s: f32,
}

fn leg() -> impl Strategy<Value = Leg> {
    let place = (-0.015f32..0.015, -0.015f32..0.015, -0.002f32..0.03);
    (place, 0.01f32..0.06).prop_map(|((x, y, z), speed_m_s)| Leg {
        to_m: Vec3::new(x, y, z),
        speed_m_s,
    })
}

/// A hand that sums the energy that it gives.
struct Hand<'a, 's> {
    sim: &'a mut Sim<'s>,
    bench: Bench,
    tip_m: Vec3,
    /// Position at the end of the last tick.
    handle_m: Vec3,
    force_n: Vec3,
    /// Energy that the hand has given so far, J.
    given_j: f32,
    /// Largest value of `given_j` so far, J.
    most_j: f32,
}

impl<'a, 's> Hand<'a, 's> {
    fn new(sim: &'a mut Sim<'s>) -> Self {
        Self {
            sim,
            bench: Bench::new(),
            tip_m: AWAY,
            handle_m: handle_m(&AWAY),
            force_n: Vec3::zeros(),
            given_j: 0.0,
            most_j: 0.0,
        }
    }

    fn follow(&mut self, leg: &Leg, buttons: Buttons) {
        let (from_m, travel_m) = (self.tip_m, leg.to_m - self.tip_m);
        let ticks = (norm(&travel_m) / (0.001 * leg.speed_m_s)).ceil().max(1.0) as usize;
        for tick in 1..=ticks {
            self.tick(from_m + travel_m * (tick as f32 / ticks as f32), buttons);
        }
    }

    fn rest(&mut self, ticks: usize, buttons: Buttons) {
        for _ in 0..ticks {
            self.tick(self.tip_m, buttons);
        }
    }

    fn tick(&mut self, tip_m: Vec3, buttons: Buttons) {
        self.bench.next_at(&tip_m, buttons);
        self.sim.tick(&mut self.bench);
        let (now_m, now_n) = (handle_m(&tip_m), self.bench.force_n);
        let mean_n = (self.force_n + now_n) * 0.5;
        self.given_j -= mean_n.dot(&(now_m - self.handle_m));
        self.most_j = self.most_j.max(self.given_j);
        (self.tip_m, self.handle_m, self.force_n) = (tip_m, now_m, now_n);
    }
}

fn handle_m(tip_m: &Vec3) -> Vec3 {
    let up = Vec3::new(0.0, 1.0, 0.0);
    LEVER.handle_from_tip(tip_m, &up).translation.vector
}

fn to(to_m: Vec3) -> Leg {
    Leg {
        to_m,
        speed_m_s: 0.06,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    /// Presses and pushes with open jaws, from no contact to no contact. The hand gets no more
    /// energy than it has given.
    #[test]
    fn a_round_through_tissue_costs_the_hand(legs in prop::collection::vec(leg(), 1..5)) {
        let anatomy = pad();
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut hand = Hand::new(&mut sim);
        let above = to(BITTEN + Vec3::new(0.0, 0.0, 0.04));
        for leg in [above].iter().chain(&legs).chain(&[above, to(AWAY)]) {
            hand.follow(leg, NONE);
        }
        let (given_j, most_j) = (hand.given_j, hand.most_j);
        prop_assert!(given_j > -1.0e-5 - 0.01 * most_j, "{} J of {} J", given_j, most_j);
    }

    /// Grasps and pulls, with slipping and tearing, back to the place of the grasp. (Closing and
    /// opening are not counted, because the drive of the jaws supplies their energy.)
    #[test]
    fn a_round_with_tissue_in_the_jaws_costs_the_hand(legs in prop::collection::vec(leg(), 1..5)) {
        let anatomy = pad();
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut hand = Hand::new(&mut sim);
        hand.follow(&to(BITTEN), NONE);
        hand.rest(600, Buttons::GRASP);
        prop_assert!(hand.bench.grasped_count > 0);
        (hand.given_j, hand.most_j) = (0.0, 0.0);
        for leg in legs.iter().chain(&[to(BITTEN)]) {
            hand.follow(leg, Buttons::GRASP);
        }
        let (given_j, most_j) = (hand.given_j, hand.most_j);
        prop_assert!(given_j > -1.0e-5 - 0.01 * most_j, "{} J of {} J", given_j, most_j);
    }

    /// The rotated tissue, with room and devices rotated as well, gives the rotated force.
    #[test]
    fn force_is_invariant_under_rotation(axis in (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0)) {
        let turn = Quat::from_scaled_axis(Vec3::new(axis.0, axis.1, axis.2) * 3.0);
        let sent_forces = |anatomy: &Anatomy| {
            let mut state = new_state();
            let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
            let mut bench = Bench::new();
            let mut sent = Vec::new();
            let pulled = BITTEN + Vec3::new(0.004, 0.002, 0.008);
            let path = [(AWAY, BITTEN, NONE), (BITTEN, BITTEN, Buttons::GRASP),
                (BITTEN, pulled, Buttons::GRASP)];
            for (from, to, buttons) in path {
                for t in 0..300 {
                    bench.next_at(&(from + (to - from) * (t as f32 / 300.0)), buttons);
                    sim.tick(&mut bench);
                    sent.push(bench.sent[0].force_n);
                }
            }
            sent
        };
        let (here, there) = (sent_forces(&pad()), sent_forces(&pad().turned(turn)));
        let force_max_n = here.iter().map(norm).fold(0.0, f32::max);
        let difference_n = here.iter().zip(&there).map(|(a, b)| norm(&(a - b))).fold(0.0, f32::max);
        prop_assert!(force_max_n > 0.1, "{}", force_max_n);
        // Spheres may begin to touch one tick earlier or later.
        prop_assert!(difference_n < 0.03 * force_max_n, "{} of {} N", difference_n, force_max_n);
    }
}
