//! Mutual influence of the contacts on one skin, beyond the influence that the spheres transmit.
//!
//! The solver reads these data in every pass, so a [`LoadedContact`] holds nothing else, and the
//! contacts lie close together in memory. A whole [`crate::contact::constraint::ContactConstraint`]
//! takes a kilobyte and a half.

use heapless::Vec;

use crate::capacity::MAX_CONTACT_CONSTRAINTS;
use crate::contact::law::Law;
use crate::math::{self, Vec3};

/// The data of a contact that the other contacts need.
#[derive(Debug, Clone)]
pub(crate) struct LoadedContact {
    /// Index of the contact among all constraints.
    constraint: u8,
    normal: Vec3,
    at_m: Vec3,
    force_n: f32,
    /// Self-influence distance under this force, m ([`Law::self_influence_distance_m`]).
    self_influence_distance_m: f32,
    /// `None` for a tube's wall, which is a spring and does not displace other contacts.
    law: Option<Law>,
}

impl LoadedContact {
    /// The constraint with this number, under this force.
    pub(crate) fn new(
        constraint: usize,
        normal: Vec3,
        at_m: Vec3,
        force_n: f32,
        law: Option<Law>,
    ) -> Self {
        Self {
            constraint: constraint as u8, // there are at most 64 constraints
            normal,
            at_m,
            force_n,
            self_influence_distance_m: law
                .map_or(0.0, |law| law.self_influence_distance_m(force_n)),
            law,
        }
    }
}

/// The contacts of an organ, with their present forces.
#[derive(Debug, Clone, Default)]
pub(crate) struct Influences {
    contacts: Vec<LoadedContact, MAX_CONTACT_CONSTRAINTS>,
}

impl Influences {
    /// Collects the contacts of an organ.
    pub(crate) fn new(contacts: impl Iterator<Item = LoadedContact>) -> Self {
        let mut all = Vec::new();
        for loaded in contacts {
            let _ = all.push(loaded); // room for every constraint
        }
        Self { contacts: all }
    }

    /// Number of contacts.
    pub(crate) fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Index of contact `index` among all constraints.
    pub(crate) fn constraint(&self, index: usize) -> Option<usize> {
        self.contacts
            .get(index)
            .map(|it| usize::from(it.constraint))
    }

    /// Sets the force of contact `index`, N.
    pub(crate) fn set_force(&mut self, index: usize, force_n: f32) {
        if let Some(loaded) = self.contacts.get_mut(index) {
            loaded.force_n = force_n;
            loaded.self_influence_distance_m = loaded
                .law
                .map_or(0.0, |law| law.self_influence_distance_m(force_n));
        }
    }

    /// Displacement of the skin under contact `index` by the other contacts, m.
    pub(crate) fn displacement_by_others_m(&self, index: usize) -> f32 {
        let Some(target) = self.contacts.get(index) else {
            return 0.0;
        };
        let mut sum_m = 0.0;
        for (i, other) in self.contacts.iter().enumerate() {
            if other.force_n <= 0.0 || i == index {
                continue;
            }
            let Some(law) = &other.law else {
                continue;
            };
            let along = other.normal.dot(&target.normal);
            if along <= 0.0 {
                continue;
            }
            let distance_m = math::norm(&(other.at_m - target.at_m));
            // Betti: influence is symmetric, so the wider of both contacts counts.
            let self_influence_distance_m = other
                .self_influence_distance_m
                .max(target.self_influence_distance_m);
            sum_m +=
                along * other.force_n * law.influence_m_n(distance_m, self_influence_distance_m);
        }
        sum_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::law::Shape;
    use proptest::prelude::*;

    fn loaded(shape: Shape, at_m: Vec3, force_n: f32) -> LoadedContact {
        let law = Law::new(shape, 6000.0, 0.1, 0.0);
        LoadedContact {
            constraint: 0,
            normal: Vec3::z(),
            at_m,
            force_n,
            self_influence_distance_m: law.self_influence_distance_m(force_n),
            law: Some(law),
        }
    }

    proptest! {
        /// Reciprocity (Betti). Without it, the lightest touch of a tip would lift a shaft nearby
        /// off the skin.
        #[test]
        fn influence_is_symmetric(
            apart_m in 0.0f32..0.01, tip_n in 1.0e-5f32..0.5, shaft_n in 1.0e-5f32..0.5,
        ) {
            let tip = loaded(Shape::Ball { radius_m: 0.0025 }, Vec3::zeros(), tip_n);
            let shaft = Shape::Cylinder { radius_m: 0.0025, length_m: 0.005 };
            let shaft = loaded(shaft, Vec3::x() * apart_m, shaft_n);
            let influences = Influences { contacts: [tip, shaft].into_iter().collect() };
            let (by_shaft, by_tip) = (influences.displacement_by_others_m(0) / shaft_n, influences.displacement_by_others_m(1) / tip_n);
            prop_assert!(by_tip > 0.0 && (by_shaft / by_tip - 1.0).abs() < 1.0e-4, "{by_shaft} {by_tip}");
        }

        /// The influence is bounded by the compliance of either contact, even one without force.
        /// Otherwise one contact could keep the other off the tissue, and the pair would snap.
        #[test]
        fn influence_is_bounded_by_either_compliance(
            apart_m in 0.0f32..0.01, tip_n in 0.0f32..0.5, shaft_n in 0.0f32..0.5, radius_m in 0.001f32..0.005,
        ) {
            let tip = loaded(Shape::Ball { radius_m }, Vec3::zeros(), tip_n);
            let shaft = Shape::Cylinder { radius_m, length_m: 2.4 * radius_m };
            let shaft = loaded(shaft, Vec3::x() * apart_m, shaft_n);
            let compliance_m_n = |loaded: &LoadedContact| {
                let law = loaded.law.expect("half-space law");
                let depth_m = |force_n: f32| {
                    let (mut low, mut high) = (0.0f32, 0.1f32);
                    for _ in 0..40 {
                        let middle = 0.5 * (low + high);
                        if law.force_n(-middle, 0.0).0 < force_n { low = middle } else { high = middle }
                    }
                    high
                };
                let (_, stiffness_n_m) = law.force_n(-depth_m(loaded.force_n).max(1.0e-5), 0.0);
                stiffness_n_m.recip()
            };
            let compliance_min_m_n = compliance_m_n(&tip).min(compliance_m_n(&shaft));
            let self_influence_distance_m = tip.self_influence_distance_m.max(shaft.self_influence_distance_m);
            let influence_m_n = tip.law.expect("half-space law").influence_m_n(apart_m, self_influence_distance_m);
            prop_assert!(influence_m_n < 1.1 * compliance_min_m_n, "{influence_m_n} {compliance_min_m_n}");
        }
    }
}
