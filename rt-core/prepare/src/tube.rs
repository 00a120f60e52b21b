//! Substeps of a tube, by the stiffness of its links and the masses of its spheres.

use crate::elastic::{Elastic, LINKS_OF_A_SPHERE, SUBSTEPS_MAX, TICK_S, TUBE_STIFFNESS_NUMBER_MAX};

/// Chooses the fewest substeps in which the tube has its material's stiffness, at most
/// [`SUBSTEPS_MAX`]. The stiffness number of a tube is the number of its free sphere with the
/// stiffest links for its mass.
pub(crate) fn choose_substeps(elastic: &mut Elastic, masses_kg: &[f64], held: &[bool]) {
    let mut stiffness_n_m = vec![0.0; masses_kg.len()];
    for ([a, b], compliance_m_n) in &elastic.links {
        for end in [a, b] {
            stiffness_n_m[*end as usize] += compliance_m_n.recip();
        }
    }
    let free = (0..held.len()).filter(|i| !held[*i]);
    let per_mass_s2 = free.map(|i| stiffness_n_m[i] / masses_kg[i]);
    let of_a_tick = per_mass_s2.fold(0.0, f64::max) * TICK_S * TICK_S / LINKS_OF_A_SPHERE;
    let number = |substeps: u32| of_a_tick / f64::from(substeps * substeps);
    elastic.substeps = 1;
    while elastic.substeps < SUBSTEPS_MAX && number(elastic.substeps) > TUBE_STIFFNESS_NUMBER_MAX {
        elastic.substeps *= 2;
    }
    elastic.stiffness_number = number(elastic.substeps);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Substeps and stiffness number of a row of eleven spheres of 10 mg. The first is held and
    /// weighs next to nothing, and the last is lighter by `lighter`.
    fn row(stiffness_n_m: f64, lighter: f64) -> (u32, f64) {
        let links = (0..10).map(|i| ([i, i + 1], stiffness_n_m.recip()));
        let mut elastic = Elastic {
            links: links.collect(),
            count: 10,
            substeps: 1,
            stiffness_number: 0.0,
        };
        let mut masses_kg = vec![1e-5; 11];
        masses_kg[0] = 1e-12;
        masses_kg[10] /= lighter;
        let held: Vec<bool> = (0..11).map(|i| i == 0).collect();
        choose_substeps(&mut elastic, &masses_kg, &held);
        (elastic.substeps, elastic.stiffness_number)
    }

    /// Two links of `k` give a sphere the stiffness number `2 k dt² / (1.25 m)`.
    #[test]
    fn a_tube_has_the_fewest_substeps_that_keep_its_number() {
        let limit_n_m = TUBE_STIFFNESS_NUMBER_MAX * LINKS_OF_A_SPHERE * 1e-5 / 2.0 / 1e-6;
        for (stiffness_n_m, substeps) in [(0.1, 1), (0.99, 1), (1.01, 2), (4.1, 4), (255.0, 16)] {
            let (chosen, number) = row(stiffness_n_m * limit_n_m, 1.0);
            assert_eq!(chosen, substeps, "{stiffness_n_m}");
            let expected = TUBE_STIFFNESS_NUMBER_MAX * stiffness_n_m / f64::from(chosen * chosen);
            assert!((number / expected - 1.0).abs() < 1e-9, "{number}");
        }
        let (chosen, number) = row(1000.0 * limit_n_m, 1.0);
        assert_eq!(chosen, SUBSTEPS_MAX);
        assert!(number > TUBE_STIFFNESS_NUMBER_MAX, "{number}");
    }

    /// The last sphere has one link, so it decides only if it weighs less than half of the others.
    #[test]
    fn a_light_sphere_asks_for_substeps() {
        assert_eq!(row(10.0, 1.9), row(10.0, 1.0));
        assert_eq!((row(10.0, 1.0).0, row(10.0, 20.0).0), (1, 4));
    }
}
