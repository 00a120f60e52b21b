extern crate std;
use super::*;
use crate::math::{Vec3, norm};
use crate::scene::tests::{organ, room, sphere};
use crate::scene::{Link, RestSphere};
use crate::state::State;
use proptest::prelude::*;
use std::boxed::Box;
use std::vec::Vec;

/// Distance between neighbours, m.
const SPACING_M: f32 = 0.002;

/// A sheet of `across` rows with `along` spheres each, each row 2 mm thick and 2 mm wide.
fn sheet(along: u32, across: u32) -> (Vec<RestSphere>, Vec<Link>) {
    let spheres = (0..across).flat_map(|y| {
        (0..along).map(move |x| RestSphere {
            mass_kg: DENSITY_KG_M3 * SPACING_M * SPACING_M * SPACING_M,
            ..sphere(
                Vec3::new(x as f32, y as f32, 0.0) * SPACING_M,
                0.5 * SPACING_M,
            )
        })
    });
    let link = |a, b| Link {
        a,
        b,
        rest_length_m: SPACING_M,
        compliance_m_n: 0.2,
    };
    let mut links = Vec::new();
    for y in 0..across {
        for x in 0..along {
            let own = y * along + x;
            links.extend((x + 1 < along).then(|| link(own, own + 1)));
            links.extend((y + 1 < across).then(|| link(own, own + along)));
        }
    }
    (spheres.collect(), links)
}

/// Runs `work` on a sheet at the temperature of the body.
fn on_sheet(along: u32, across: u32, work: impl FnOnce(&Scene<'_>, &mut State)) {
    let (spheres, links) = sheet(along, across);
    let organs = [organ(0, spheres.len() as u32, 0, links.len() as u32)];
    let scene = Scene::new(&organs, &spheres, &links, room()).expect("sound");
    let mut state = Box::new(State::new());
    state.bodies.load(&scene);
    state.bodies.begin(&scene, true);
    state.heat.load(&scene);
    work(&scene, &mut state);
}

/// Advances by `seconds`.
fn wait(seconds: f32, scene: &Scene<'_>, state: &mut State) {
    let mut journal = Journal::default();
    for _ in 0..(seconds / TICK_S) as u32 {
        journal.begin();
        state.heat.advance(scene, &state.bodies, &mut journal);
    }
}

/// Mean square of the distance of heat from sphere `middle` along x, m².
fn variance_m2(middle: u32, scene: &Scene<'_>, state: &State) -> f32 {
    let at_m = |sphere: u32| scene.spheres[sphere as usize].center_m;
    let all = 0..scene.spheres.len() as u32;
    let whole_j: f32 = all.clone().map(|it| *state.heat.warmth_j.at(it)).sum();
    let moment: f32 = all
        .map(|it| *state.heat.warmth_j.at(it) * (at_m(it).x - at_m(middle).x).powi(2))
        .sum();
    moment / whole_j
}

#[test]
fn heat_spreads_in_a_bar_and_in_a_sheet_as_in_tissue() {
    // In any number of dimensions the variance along an axis grows by 2 k t / (ρ c).
    for (along, across) in [(61, 1), (41, 41)] {
        on_sheet(along, across, |scene, state| {
            let middle = (across / 2) * along + along / 2;
            // The heat is so little that it destroys nothing and changes no blood flow.
            state.heat.warm(middle, 0.2);
            wait(60.0, scene, state);
            let conductivity_w_m_k = conduction::conductivity_w_m_k(middle, scene, &state.bodies);
            let diffusivity_m2_s = conductivity_w_m_k / (DENSITY_KG_M3 * CAPACITY_J_KG_K);
            let expected_m2 = 2.0 * diffusivity_m2_s * 60.0;
            let found_m2 = variance_m2(middle, scene, state);
            let relative = found_m2 / expected_m2;
            assert!((0.9..1.1).contains(&relative), "{across} rows: {relative}");
        });
    }
}

#[test]
fn blood_carries_heat_off_until_the_tissue_is_destroyed_and_gas_always_does() {
    on_sheet(3, 1, |scene, state| {
        state.heat.warm(1, 0.2);
        let first = state.heat.balance(scene);
        wait(100.0, scene, state);
        let left = state.heat.balance(scene);
        let share = left.stored_j / first.stored_j;
        let lost = 100.0 * (0.0008 + f64::from(loss_per_s(0.5 * SPACING_M)));
        assert!((share - f64::exp(-lost)).abs() < 0.01, "{share}");
        let carried = left.perfused_j / left.cooled_j;
        assert!((carried - 0.08 / (lost - 0.08)).abs() < 0.01, "{carried}");
        let whole_j = left.stored_j + left.perfused_j + left.cooled_j;
        assert!((whole_j - first.stored_j).abs() < 1.0e-4);
    });
    on_sheet(2, 1, |scene, state| {
        for sphere in 0..2 {
            let capacity_j_k = *state.heat.capacity_j_k.at(sphere);
            state.heat.warm(sphere, 40.0 * capacity_j_k);
        }
        wait(0.2, scene, state);
        let before = state.heat.balance(scene);
        wait(100.0, scene, state);
        let after = state.heat.balance(scene);
        let carried_j = after.perfused_j - before.perfused_j;
        assert!(carried_j <= 0.0, "{carried_j} J through dead tissue");
        assert!(after.cooled_j > before.cooled_j + 0.5 * before.stored_j);
    });
}

#[test]
fn water_boils_before_tissue_gets_hotter_and_steam_takes_the_rest() {
    on_sheet(1, 1, |scene, state| {
        let capacity_j_k = *state.heat.capacity_j_k.at(0);
        let boils_j = BOILS_K * capacity_j_k;
        let drying_j = state.heat.drying_j(0);
        let warm = |state: &mut State, energy_j: f32| {
            for _ in 0..100 {
                state.heat.warm(0, 0.01 * energy_j);
            }
            state.heat.rise_k(0)
        };
        assert!((warm(state, boils_j + 0.5 * drying_j) - BOILS_K).abs() < 0.1);
        assert!((state.heat.code(0, 0.0).dried).abs_diff(127) <= 1);
        assert!(warm(state, 0.5 * drying_j + 100.0 * capacity_j_k) > BOILS_K + 90.0);
        assert!((warm(state, 1000.0 * capacity_j_k) - HOTTEST_K).abs() < 0.1);
        let balance = state.heat.balance(scene);
        let given_j = f64::from(boils_j + drying_j + 1100.0 * capacity_j_k);
        let found_j = balance.stored_j + balance.boiled_j;
        assert!(
            (found_j / given_j - 1.0).abs() < 1.0e-3,
            "{found_j} {given_j}"
        );
    });
}

#[test]
fn destroyed_tissue_is_reported_with_its_volume() {
    on_sheet(3, 1, |scene, state| {
        let capacity_j_k = *state.heat.capacity_j_k.at(1);
        state.heat.warm(1, 40.0 * capacity_j_k);
        let mut journal = Journal::default();
        let mut reported = Vec::new();
        for _ in 0..2000 {
            journal.begin();
            state.heat.advance(scene, &state.bodies, &mut journal);
            reported.extend(journal.events().iter().copied());
        }
        assert!(
            reported.iter().all(|it| it.kind == EventKind::Seared),
            "{reported:?}"
        );
        let volume_m3 = SPACING_M * SPACING_M * SPACING_M;
        let first = reported
            .first()
            .expect("two seconds at 77 °C destroy tissue");
        assert!(
            (first.value / volume_m3 - 1.0).abs() < 0.01,
            "{}",
            first.value
        );
        assert!(norm(&(first.at_m - scene.spheres[1].center_m)) < 1.0e-6);
        assert!(state.heat.codes(3)[1].denatured >= 161, "Ω of 1 and more");
        assert_eq!(state.heat.codes(3)[1].dried, 0);
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Wherever heat is put, none is lost, and nothing becomes hotter than the hottest place was.
    #[test]
    fn heat_flows_from_warm_to_cold_and_none_is_lost(
        places in prop::collection::vec((0u32..24, 0.0f32..0.5), 1..8),
    ) {
        on_sheet(6, 4, |scene, state| {
            for (sphere, energy_j) in &places {
                state.heat.warm(*sphere, *energy_j);
            }
            let hottest_k = |state: &State| {
                (0..24).map(|it| state.heat.rise_k(it)).fold(0.0, f32::max)
            };
            let (first, hottest) = (state.heat.balance(scene), hottest_k(state));
            wait(5.0, scene, state);
            let last = state.heat.balance(scene);
            let before_j = first.stored_j + first.boiled_j;
            let after_j = last.stored_j + last.boiled_j + last.perfused_j + last.cooled_j;
            assert!((after_j - before_j).abs() < 1.0e-4 * before_j.max(0.01));
            assert!(hottest_k(state) <= hottest * 1.000_1);
            assert!((0..24).all(|it| state.heat.rise_k(it) >= 0.0));
        });
    }
}
