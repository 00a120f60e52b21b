//! Substeps of a tube, and the mass that its spheres need for them.
//!
//! A tube is light and stiff. With its own mass it would need more than sixteen substeps a tick, and
//! every organ that is tied to it would pay for them. So a sphere that is too light for its links
//! gets more mass, as in explicit finite elements (mass scaling, Belytschko 2013, section 6.2). The
//! mass adds inertia and no weight. A tube of a gram then resists acceleration like three grams,
//! which no hand feels: 3 mN at 1 m/s².

use crate::elastic::{Elastic, LINKS_OF_A_SPHERE, SUBSTEPS_MAX, TICK_S, TUBE_STIFFNESS_NUMBER_MAX};

/// Largest stiffness of a sphere's links, times `dt²` over its mass.
const LINKS_NUMBER_MAX: f64 = TUBE_STIFFNESS_NUMBER_MAX * LINKS_OF_A_SPHERE;
/// Largest mass of the free spheres, as a multiple of their own.
const GROWTH_MAX: f64 = 3.0;
/// Largest mass that a tube gets in addition, kg. A hand that lifts a loop of intestine would feel
/// more.
const ADDED_MAX_KG: f64 = 0.005;

/// Chooses the fewest substeps for which the free spheres need at most [`GROWTH_MAX`] times their
/// mass and [`ADDED_MAX_KG`] more, and adds that mass. A tube that needs more even in the most
/// substeps keeps its mass, and is softer than its material. Returns the factor of the free
/// spheres' mass.
pub(crate) fn for_tube(elastic: &mut Elastic, masses_kg: &mut [f64], held: &[bool]) -> f64 {
    let mut stiffness_n_m = vec![0.0; masses_kg.len()];
    for ([a, b], compliance_m_n) in &elastic.links {
        for end in [a, b] {
            stiffness_n_m[*end as usize] += compliance_m_n.recip();
        }
    }
    let free = || (0..held.len()).filter(|i| !held[*i]);
    let needed_kg = |i: usize, substeps: u32| {
        let dt_s = TICK_S / f64::from(substeps);
        stiffness_n_m[i] * dt_s * dt_s / LINKS_NUMBER_MAX
    };
    let own_kg: f64 = free().map(|i| masses_kg[i]).sum();
    let grown_kg = |substeps: u32| -> f64 {
        free()
            .map(|i| masses_kg[i].max(needed_kg(i, substeps)))
            .sum()
    };
    let most_kg = (GROWTH_MAX * own_kg).min(own_kg + ADDED_MAX_KG);
    let mut substeps = 1;
    while substeps < SUBSTEPS_MAX && grown_kg(substeps) > most_kg {
        substeps *= 2;
    }
    elastic.substeps = substeps;
    let grown_kg = grown_kg(substeps);
    let bears = own_kg > 0.0 && grown_kg <= most_kg;
    if bears {
        for i in free() {
            masses_kg[i] = masses_kg[i].max(needed_kg(i, substeps));
        }
    }
    let number = |i: usize| needed_kg(i, substeps) * LINKS_NUMBER_MAX / masses_kg[i];
    let largest = free().map(number).fold(0.0, f64::max);
    elastic.stiffness_number = largest / LINKS_OF_A_SPHERE;
    if bears { grown_kg / own_kg } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of eleven spheres of 10 mg. The first is held, and the last is light.
    fn row(stiffness_n_m: f64) -> (Elastic, Vec<f64>, Vec<bool>) {
        let links = (0..10).map(|i| ([i, i + 1], stiffness_n_m.recip()));
        let elastic = Elastic {
            links: links.collect(),
            count: 10,
            substeps: 1,
            stiffness_number: 0.0,
        };
        let mut masses_kg = vec![1e-5; 11];
        masses_kg[10] = 1e-6;
        let held = (0..11).map(|i| i == 0).collect();
        (elastic, masses_kg, held)
    }

    /// Largest stiffness of a free sphere's links, times `dt²` over its mass.
    fn number(elastic: &Elastic, masses_kg: &[f64]) -> f64 {
        let dt_s = TICK_S / f64::from(elastic.substeps);
        let of = |i: u32| {
            let own = elastic.links.iter().filter(|(ends, _)| ends.contains(&i));
            let stiffness_n_m: f64 = own.map(|(_, compliance)| compliance.recip()).sum();
            stiffness_n_m * dt_s * dt_s / masses_kg[i as usize]
        };
        (1..11).map(of).fold(0.0, f64::max)
    }

    #[test]
    fn spheres_get_the_mass_that_their_links_need() {
        for stiffness_n_m in [1.0, 50.0, 1_000.0, 10_000.0] {
            let (mut elastic, mut masses_kg, held) = row(stiffness_n_m);
            let own_kg = masses_kg.clone();
            let growth = for_tube(&mut elastic, &mut masses_kg, &held);
            assert!((1.0..=GROWTH_MAX).contains(&growth), "{growth}");
            let grown: f64 = masses_kg[1..].iter().sum::<f64>() / own_kg[1..].iter().sum::<f64>();
            assert!((grown - growth).abs() < 1e-9);
            assert!(masses_kg.iter().zip(&own_kg).all(|(now, own)| now >= own));
            assert!((masses_kg[0] - own_kg[0]).abs() < 1e-12, "it is held");
            let number = number(&elastic, &masses_kg);
            assert!(number <= LINKS_NUMBER_MAX + 1e-9, "{number}");
            let told = elastic.stiffness_number * LINKS_OF_A_SPHERE;
            assert!((told - number).abs() < 1e-9, "{told} of {number}");
        }
    }

    #[test]
    fn a_soft_tube_keeps_its_mass_in_one_substep() {
        let (mut elastic, mut masses_kg, held) = row(0.1);
        assert!((for_tube(&mut elastic, &mut masses_kg, &held) - 1.0).abs() < 1e-12);
        assert_eq!(elastic.substeps, 1);
    }

    #[test]
    fn a_tube_of_steel_keeps_its_mass_and_is_too_stiff() {
        let (mut elastic, mut masses_kg, held) = row(1e7);
        let own_kg = masses_kg.clone();
        assert!((for_tube(&mut elastic, &mut masses_kg, &held) - 1.0).abs() < 1e-12);
        assert_eq!((elastic.substeps, masses_kg), (SUBSTEPS_MAX, own_kg));
        assert!(elastic.stiffness_number > TUBE_STIFFNESS_NUMBER_MAX);
    }
}
