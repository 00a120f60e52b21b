//! What contacts on one skin do to each other beyond what the spheres carry over: what each pass over them
//! asks again and again, close together in memory (a [`crate::contact::constraint::ContactConstraint`] takes a kilobyte and a half).

use heapless::Vec;

use crate::capacity::MAX_CONTACT_CONSTRAINTS;
use crate::contact::law::Law;
use crate::math::{self, Vec3};

/// A contact as the others beside it see it.
#[derive(Debug, Clone)]
pub(crate) struct Presser {
    /// Its index among all touches.
    constraint: u8,
    normal: Vec3,
    at_m: Vec3,
    force_n: f32,
    /// How near it is to itself under this force, m ([`Law::near_m`]).
    near_m: f32,
    /// None of a spring: a tube's wall gives way by itself.
    law: Option<Law>,
}

impl Presser {
    /// The touch with this number, which presses with this force.
    pub(crate) fn new(
        constraint: usize,
        normal: Vec3,
        at_m: Vec3,
        force_n: f32,
        law: Option<Law>,
    ) -> Self {
        Self {
            constraint: constraint as u8, // there are 64 at most
            normal,
            at_m,
            force_n,
            near_m: law.map_or(0.0, |law| law.near_m(force_n)),
            law,
        }
    }
}

/// The contacts of an organ.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beside {
    pressers: Vec<Presser, MAX_CONTACT_CONSTRAINTS>,
}

impl Beside {
    /// Those of an organ, in their order.
    pub(crate) fn of(own: impl Iterator<Item = Presser>) -> Self {
        let mut pressers = Vec::new();
        for presser in own {
            let _ = pressers.push(presser); // there is room: touches are no more
        }
        Self { pressers }
    }

    /// How many.
    pub(crate) fn len(&self) -> usize {
        self.pressers.len()
    }

    /// Which touch the contact `own` is.
    pub(crate) fn constraint(&self, own: usize) -> Option<usize> {
        self.pressers.get(own).map(|it| usize::from(it.constraint))
    }

    /// The contact `own` presses with this force now.
    pub(crate) fn press(&mut self, own: usize, force_n: f32) {
        if let Some(presser) = self.pressers.get_mut(own) {
            presser.force_n = force_n;
            presser.near_m = presser.law.map_or(0.0, |law| law.near_m(force_n));
        }
    }

    /// How far the others have already pressed the skin away from the contact `own`, m.
    pub(crate) fn others_m(&self, own: usize) -> f32 {
        let Some(pressed) = self.pressers.get(own) else {
            return 0.0;
        };
        let mut sum_m = 0.0;
        for (i, other) in self.pressers.iter().enumerate() {
            if other.force_n <= 0.0 || i == own {
                continue;
            }
            let Some(law) = &other.law else {
                continue;
            };
            let along = other.normal.dot(&pressed.normal);
            if along <= 0.0 {
                continue;
            }
            let distance_m = math::norm(&(other.at_m - pressed.at_m));
            // What one load does to another is what that does to it (Betti): the wider of both counts.
            let near_m = other.near_m.max(pressed.near_m);
            sum_m += along * other.force_n * law.beside_m_n(distance_m, near_m);
        }
        sum_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::law::Shape;
    use proptest::prelude::*;

    fn presser(shape: Shape, at_m: Vec3, force_n: f32) -> Presser {
        let law = Law::new(shape, 6000.0, 0.1, 0.0);
        Presser {
            constraint: 0,
            normal: Vec3::z(),
            at_m,
            force_n,
            near_m: law.near_m(force_n),
            law: Some(law),
        }
    }

    proptest! {
        /// What a force at one place does to another is what the same force there does to it (Betti): were it more, the
        /// lightest touch of a tip would lift a shaft off that lies beside it.
        #[test]
        fn each_does_to_the_other_what_that_does_to_it(
            apart_m in 0.0f32..0.01, tip_n in 1.0e-5f32..0.5, shaft_n in 1.0e-5f32..0.5,
        ) {
            let tip = presser(Shape::Ball { radius_m: 0.0025 }, Vec3::zeros(), tip_n);
            let shaft = Shape::Bar { radius_m: 0.0025, length_m: 0.005 };
            let shaft = presser(shaft, Vec3::x() * apart_m, shaft_n);
            let beside = Beside { pressers: [tip, shaft].into_iter().collect() };
            let (by_shaft, by_tip) = (beside.others_m(0) / shaft_n, beside.others_m(1) / tip_n);
            prop_assert!(by_tip > 0.0 && (by_shaft / by_tip - 1.0).abs() < 1.0e-4, "{by_shaft} {by_tip}");
        }

        /// It is no more than what more of the force would do to either itself, also where one does not press at all:
        /// else either could hold the other off, and they would snap.
        #[test]
        fn neither_holds_the_other_off(
            apart_m in 0.0f32..0.01, tip_n in 0.0f32..0.5, shaft_n in 0.0f32..0.5, radius_m in 0.001f32..0.005,
        ) {
            let tip = presser(Shape::Ball { radius_m }, Vec3::zeros(), tip_n);
            let shaft = Shape::Bar { radius_m, length_m: 2.4 * radius_m };
            let shaft = presser(shaft, Vec3::x() * apart_m, shaft_n);
            let dents_more_m_n = |presser: &Presser| {
                let law = presser.law.expect("it has one");
                let depth_m = |force_n: f32| {
                    let (mut low, mut high) = (0.0f32, 0.1f32);
                    for _ in 0..40 {
                        let middle = 0.5 * (low + high);
                        if law.force_n(-middle, 0.0).0 < force_n { low = middle } else { high = middle }
                    }
                    high
                };
                let (_, stiffness_n_m) = law.force_n(-depth_m(presser.force_n).max(1.0e-5), 0.0);
                stiffness_n_m.recip()
            };
            let most_m_n = dents_more_m_n(&tip).min(dents_more_m_n(&shaft));
            let near_m = tip.near_m.max(shaft.near_m);
            let each_m_n = tip.law.expect("it has one").beside_m_n(apart_m, near_m);
            prop_assert!(each_m_n < 1.1 * most_m_n, "{each_m_n} {most_m_n}");
        }
    }
}
