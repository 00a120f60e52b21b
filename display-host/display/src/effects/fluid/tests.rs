//! Tests volumes, and the places to which fluid runs, on planes, sheets above each other, and
//! tubes.

use glam::Vec3;
use proptest::prelude::*;

use super::*;
use crate::effects::{Effect, Effects, Flow};
use crate::skinning::{RestVertex, SkinMesh};

/// A square sheet of this side (m) around a place, inclined by `slope` towards x, as a skin that
/// never moves.
fn add_sheet(mesh: &mut SkinMesh, middle: Vec3, side_m: f32, slope: f32) {
    use bytemuck::Zeroable;
    const N: usize = 40;
    let vertices: Vec<RestVertex> = (0..N * N)
        .map(|i| {
            let [x, z] = [i % N, i / N].map(|k| (k as f32 / (N - 1) as f32 - 0.5) * side_m);
            RestVertex {
                position: (middle + Vec3::new(x, -slope * x, z)).to_array(),
                normal: Vec3::new(slope, 1.0, 0.0).normalize().to_array(),
                ..Zeroable::zeroed()
            }
        })
        .collect();
    let mut triangles = Vec::new();
    for k in 0..N - 1 {
        for i in 0..N - 1 {
            let a = (k * N + i) as u32;
            let n = N as u32;
            triangles.extend([[a, a + n, a + 1], [a + 1, a + n, a + n + 1]]);
        }
    }
    mesh.add_fixed(&vertices, &triangles);
}

fn leak(at_m: Vec3, ml_min: f32, pulses: bool) -> Effect {
    Effect {
        kind: Kind::Blood,
        at_m,
        along: Vec3::Y,
        strength: 1.0,
        lasts_s: Effect::LEAK_S,
        flow: Flow { ml_min, pulses },
    }
}

/// Sum of all places, ml.
fn everywhere(balance: &Balance) -> [f64; 3] {
    let places = [
        balance.lies_ml,
        balance.falls_ml,
        balance.gone_ml,
        balance.jar_ml,
    ];
    [0, 1, 2].map(|k| places.iter().map(|it| it[k]).sum())
}

fn is_balanced(fluids: &Fluids) -> bool {
    let balance = fluids.balance();
    let came = [0, 1, 2].map(|k| balance.leaked_ml[k] + balance.emptied_ml[k]);
    let there = everywhere(&balance);
    (0..3).all(|k| (came[k] - there[k]).abs() <= 1e-9 * came[k].max(1.0))
}

/// Plays a leak on a skin whose vertices all count as skin of organs, for `seconds`.
fn played(mesh: &mut SkinMesh, effects: &[Effect], seconds: f32, frame_s: f32) -> Effects {
    let spheres = sphere_at_rest(mesh);
    let skin = Skin::new(mesh, &spheres.0, &spheres.1, &[]);
    let mut all = Effects::new(Vec3::Y);
    for effect in effects {
        all.begin(effect, &skin);
    }
    for _ in 0..(seconds / frame_s).round() as u32 {
        all.advance(frame_s, &skin);
    }
    all
}

/// One sphere, by which `Skin::nearest` finds the displacement, far below all sheets.
fn sphere_at_rest(
    mesh: &mut SkinMesh,
) -> (
    Vec<shared_mem::scene::SphereRecord>,
    Vec<shared_mem::message::SphereState>,
) {
    use bytemuck::Zeroable;
    mesh.skinned = mesh.vertices.len();
    let at = [0.0, -10.0, 0.0];
    let mut rest = shared_mem::scene::SphereRecord::zeroed();
    let mut now = shared_mem::message::SphereState::zeroed();
    (rest.center_m, now.center_m) = (at, at);
    (vec![rest], vec![now])
}

fn mean_place(effects: &Effects, mesh: &SkinMesh) -> Vec3 {
    let skin = Skin::new(mesh, &[], &[], &[]);
    let places = effects.fluids().places(&skin);
    places.iter().sum::<Vec3>() / places.len().max(1) as f32
}

#[test]
fn blood_runs_downhill_leaves_a_film_and_stands_on_level_ground() {
    let mut slope = SkinMesh::default();
    add_sheet(&mut slope, Vec3::ZERO, 0.08, 1.0);
    let top = Vec3::new(-0.03, 0.03, 0.0);
    let effects = played(&mut slope, &[leak(top, 4.0, false)], 4.0, 0.05);
    assert!(
        mean_place(&effects, &slope).x > -0.022,
        "{}",
        mean_place(&effects, &slope)
    );
    assert!(is_balanced(effects.fluids()));
    // After the leak is closed, a thin film is left on the path, and no more fluid comes.
    let mut closed = effects;
    let spheres = sphere_at_rest(&mut slope);
    let skin = Skin::new(&slope, &spheres.0, &spheres.1, &[]);
    closed.begin(
        &Effect {
            strength: 0.0,
            ..leak(top, 4.0, false)
        },
        &skin,
    );
    let leaked = closed.fluids().balance().leaked_ml[0];
    for _ in 0..200 {
        closed.advance(0.05, &skin);
    }
    assert!((closed.fluids().balance().leaked_ml[0] - leaked).abs() < 1e-12);
    let places = closed.fluids().places(&skin);
    assert!(
        places.iter().any(|at| at.x < -0.01),
        "no film is left on the path"
    );
    let lowest = places.iter().map(|at| at.x).fold(0.0, f32::max);
    assert!(lowest > 0.015, "it stopped at {lowest}");

    let mut level = SkinMesh::default();
    add_sheet(&mut level, Vec3::ZERO, 0.08, 0.0);
    let effects = played(&mut level, &[leak(Vec3::ZERO, 4.0, false)], 6.0, 0.05);
    let places = {
        let skin = Skin::new(&level, &[], &[], &[]);
        effects.fluids().places(&skin)
    };
    let radius_m = places.iter().map(|at| at.length()).fold(0.0, f32::max);
    assert!(
        (0.003..0.03).contains(&radius_m),
        "a pool of radius {radius_m}"
    );
    assert!(mean_place(&effects, &level).length() < 0.003);
}

#[test]
fn fluid_that_drips_off_one_organ_lies_on_the_next() {
    let mut mesh = SkinMesh::default();
    // A ceiling: a sheet turned over.
    add_sheet(&mut mesh, Vec3::Y * 0.03, 0.02, 0.0);
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    add_sheet(&mut mesh, Vec3::ZERO, 0.08, 0.0);
    let effects = played(&mut mesh, &[leak(Vec3::Y * 0.03, 10.0, false)], 4.0, 0.05);
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let below = effects
        .fluids()
        .places(&skin)
        .iter()
        .filter(|at| at.y < 0.01)
        .count();
    assert!(below > 20, "{below} parcels below");
    assert!(is_balanced(effects.fluids()));
    assert!(effects.fluids().balance().gone_ml[0] <= 0.0);
}

/// A closed tube along x of this radius, m, 20 mm long, around a place.
fn add_tube(mesh: &mut SkinMesh, middle: Vec3, radius_m: f32) {
    use bytemuck::Zeroable;
    const ROUND: u32 = 12;
    const LONG: u32 = 20;
    let vertex = |normal: Vec3, along: f32, off: f32| RestVertex {
        position: (middle + Vec3::X * along + normal * off).to_array(),
        normal: normal.to_array(),
        ..Zeroable::zeroed()
    };
    let mut vertices = Vec::new();
    for i in 0..=LONG {
        for k in 0..ROUND {
            let (sin, cos) = (k as f32 / ROUND as f32 * core::f32::consts::TAU).sin_cos();
            let normal = Vec3::new(0.0, sin, cos);
            vertices.push(vertex(normal, (i as f32 - 10.0) * 0.001, radius_m));
        }
    }
    vertices.push(vertex(Vec3::NEG_X, -0.01, 0.0));
    vertices.push(vertex(Vec3::X, 0.01, 0.0));
    let at = |i: u32, k: u32| i * ROUND + k % ROUND;
    let mut triangles = Vec::new();
    for k in 0..ROUND {
        for i in 0..LONG {
            let [a, b, c, d] = [at(i, k), at(i, k + 1), at(i + 1, k), at(i + 1, k + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
        let ends = (LONG + 1) * ROUND;
        triangles.push([ends, at(0, k + 1), at(0, k)]);
        triangles.push([ends + 1, at(LONG, k), at(LONG, k + 1)]);
    }
    // Outward all round.
    for triangle in &mut triangles {
        let [a, b, c] = triangle.map(|v| Vec3::from(vertices[v as usize].position));
        let out = (a + b + c) / 3.0 - middle;
        if (b - a).cross(c - a).dot(out) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    mesh.add_fixed(&vertices, &triangles);
}

#[test]
fn blood_on_a_thin_tube_runs_round_it_and_drips() {
    let mut mesh = SkinMesh::default();
    let middle = Vec3::Y * 0.02;
    add_tube(&mut mesh, middle, 0.001);
    add_sheet(&mut mesh, Vec3::ZERO, 0.08, 0.0);
    let top = leak(middle + Vec3::Y * 0.001, 10.0, false);
    let effects = played(&mut mesh, &[top], 12.0, 0.05);
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let mut surface = Surface::of(&skin);
    surface.begin_moment();
    let fluids = effects.fluids();
    let below = fluids.lying.iter();
    let below = below.filter(|it| surface.position(&it.place, &skin).y < 0.01);
    let below_ml = 1e6 * below.map(Lying::total_m3).sum::<f64>();
    assert!(below_ml > 1.7, "{below_ml} of 2 ml on the sheet");
    assert!(is_balanced(fluids));
}

#[test]
fn too_little_fluid_for_a_drop_stays_under_a_thin_tube() {
    let mut mesh = SkinMesh::default();
    add_tube(&mut mesh, Vec3::ZERO, 0.001);
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let lowest = (0..mesh.vertices.len())
        .min_by(|a, b| skin.at_rest(*a).y.total_cmp(&skin.at_rest(*b).y))
        .unwrap();
    let (triangle, weights) = skin.place_at(lowest).unwrap();
    let mut fluids = Fluids::new(Vec3::Y);
    fluids.field = Some(Field::around(Vec3::ZERO));
    // Too little for a drop.
    let place = Place { triangle, weights };
    fluids.lie(Lying::new(place, [1e-9, 0.0, 0.0], 0.0), &skin);
    for _ in 0..30 {
        fluids.begin_moment(&skin);
        fluids.step(0.033, &skin);
        assert!(fluids.places(&skin).iter().all(|at| at.y < 0.0));
    }
    assert_eq!(fluids.counts(), [1, 0]);
}

#[test]
fn surplus_parcels_join_their_neighbours() {
    let mut mesh = SkinMesh::default();
    add_sheet(&mut mesh, Vec3::ZERO, 0.2, 0.0);
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let mut fluids = Fluids::new(Vec3::Y);
    let triangles = skin.triangles().len() as u32;
    for number in 0..3 * LYING as u32 {
        let weights = [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8]];
        let place = Place {
            triangle: number.wrapping_mul(7919) % triangles,
            weights: weights[number as usize % 3],
        };
        fluids.lie(Lying::new(place, [1e-9, 0.0, 0.0], 0.0), &skin);
    }
    assert!(fluids.lying.len() <= LYING);
    let came_ml = 3e-3 * LYING as f64;
    assert!((fluids.balance().lies_ml[0] - came_ml).abs() < 1e-9);
    // No single parcel took in the fluid of the whole sheet.
    let most = fluids.lying.iter().map(Lying::total_m3).fold(0.0, f64::max);
    assert!(most < 40e-9, "{most} m³ at one place");
}

#[test]
fn fluid_on_skin_that_a_cut_hides_lies_on_the_skin_beside() {
    let mut mesh = SkinMesh::default();
    add_sheet(&mut mesh, Vec3::ZERO, 0.08, 0.0);
    let effects = played(&mut mesh, &[leak(Vec3::ZERO, 8.0, false)], 1.0, 0.05);
    let mut cut = effects;
    let hidden = |t: &[u32; 3], mesh: &SkinMesh| {
        t.iter()
            .all(|v| mesh.vertices[*v as usize].position[0].abs() < 0.003)
    };
    let gone: Vec<usize> = (0..mesh.triangles.len())
        .filter(|k| hidden(&mesh.triangles[*k], &mesh))
        .collect();
    for k in &gone {
        mesh.triangles[*k] = [mesh.triangles[*k][0]; 3];
    }
    cut.skin_changed();
    let spheres = sphere_at_rest(&mut mesh);
    let skin = Skin::new(&mesh, &spheres.0, &spheres.1, &[]);
    cut.advance(0.5, &skin);
    assert!(is_balanced(cut.fluids()));
    let is_hidden = |it: &Lying| gone.contains(&(it.place.triangle as usize));
    assert!(!cut.fluids().lying.iter().any(is_hidden));
    assert!(cut.fluids().balance().lies_ml[0] > 0.1);
}

#[test]
fn clotted_blood_stands_on_a_slope_and_under_a_ceiling() {
    for slope in [1.0, 1e3] {
        let mut mesh = SkinMesh::default();
        add_sheet(&mut mesh, Vec3::ZERO, 0.03, slope);
        let skin = Skin::new(&mesh, &[], &[], &[]);
        let mut fluids = Fluids::new(Vec3::Y);
        fluids.field = Some(Field::around(Vec3::ZERO));
        let place = Place {
            triangle: skin.triangles().len() as u32 / 2,
            weights: [0.3, 0.3, 0.4],
        };
        fluids.lie(Lying::new(place, [2e-8, 0.0, 0.0], 600.0), &skin);
        for _ in 0..30 {
            fluids.begin_moment(&skin);
            fluids.step(0.033, &skin);
        }
        assert_eq!(fluids.counts(), [1, 0]);
        assert_eq!(fluids.lying[0].place, place);
    }
}

#[test]
fn the_same_leak_gives_the_same_fluid_at_any_frame_rate() {
    let run = |frame_s| {
        let mut mesh = SkinMesh::default();
        add_sheet(&mut mesh, Vec3::ZERO, 0.08, 0.4);
        let effects = played(&mut mesh, &[leak(Vec3::ZERO, 12.0, true)], 2.0, frame_s);
        (mean_place(&effects, &mesh), effects.fluids().balance())
    };
    let [a, b, c] = [0.05, 0.05, 0.1].map(run);
    assert_eq!(a, b, "two runs differ");
    assert!(
        (a.1.leaked_ml[0] - c.1.leaked_ml[0]).abs() < 0.01,
        "{a:?} {c:?}"
    );
    assert!(a.0.distance(c.0) < 0.002, "{a:?} {c:?}");
}

#[test]
fn an_artery_gives_its_mean_flow_and_pulses() {
    let mut mesh = SkinMesh::default();
    add_sheet(&mut mesh, Vec3::ZERO, 0.08, 0.2);
    let spheres = sphere_at_rest(&mut mesh);
    let skin = Skin::new(&mesh, &spheres.0, &spheres.1, &[]);
    let mut effects = Effects::new(Vec3::Y);
    effects.begin(&leak(Vec3::ZERO, 30.0, true), &skin);
    let mut flows = Vec::new();
    let mut before = 0.0;
    // 20 beats of 0.86 s.
    for _ in 0..172 {
        effects.advance(0.1, &skin);
        let leaked = effects.fluids().balance().leaked_ml[0];
        flows.push(leaked - before);
        before = leaked;
    }
    assert!((before / (0.5 * 17.2) - 1.0).abs() < 0.02, "{before} ml");
    let most = flows.iter().copied().fold(0.0, f64::max);
    let least = flows.iter().skip(1).copied().fold(1.0, f64::min);
    assert!(most > 3.0 * least, "{most} {least}");
}

#[test]
fn memory_is_bounded_and_blood_mixes_with_bile() {
    let mut mesh = SkinMesh::default();
    add_sheet(&mut mesh, Vec3::ZERO, 0.2, 0.0);
    let bile = Effect {
        kind: Kind::Bile,
        ..leak(Vec3::X * 0.002, 200.0, false)
    };
    let effects = played(
        &mut mesh,
        &[leak(Vec3::ZERO, 200.0, false), bile],
        30.0,
        1.0,
    );
    let [lying, falling] = effects.fluids().counts();
    assert!(lying <= LYING && falling <= FALLING, "{lying} {falling}");
    assert!(is_balanced(effects.fluids()));
    let field = effects.fluids().field().expect("wet");
    let [xs, ys, zs] = field.wet().expect("wet");
    let mixed = (zs[0]..zs[1]).any(|z| {
        (ys[0]..ys[1]).any(|y| {
            (xs[0]..xs[1]).any(|x| field.at([x, y, z]).thick_m[..2].iter().all(|h| *h > 1e-4))
        })
    });
    assert!(mixed);
}

/// Share of the places with fluid at which the field has a film.
fn seen(fluids: &Fluids, places: &[Vec3]) -> f32 {
    let field = fluids.field().expect("wet");
    let seen = places.iter().filter(|at| field.thickness(**at).0 > 0.0);
    seen.count() as f32 / places.len() as f32
}

#[test]
fn blood_that_runs_far_from_its_leak_has_a_film() {
    let mut mesh = SkinMesh::default();
    add_sheet(&mut mesh, Vec3::ZERO, 0.3, 0.5);
    let spheres = sphere_at_rest(&mut mesh);
    let skin = Skin::new(&mesh, &spheres.0, &spheres.1, &[]);
    let top = Vec3::new(-0.14, 0.07, 0.0);
    let mut effects = Effects::new(Vec3::Y);
    effects.begin(&leak(top, 60.0, false), &skin);
    let ran_m = |effects: &Effects| {
        let places = effects.fluids().places(&skin);
        places.iter().map(|at| at.x - top.x).fold(0.0, f32::max)
    };
    // The blood leaves the first window, which was opened around the leak.
    let mut frames = 0;
    while ran_m(&effects) < 0.075 {
        effects.advance(0.05, &skin);
        frames += 1;
        assert!(frames < 240, "it ran {} m in 12 s", ran_m(&effects));
    }
    // The window follows within half a second. The whole path fits in it.
    for _ in 0..10 {
        effects.advance(0.05, &skin);
    }
    let far_m = ran_m(&effects);
    assert!(far_m < Field::extent_m().x, "it ran {far_m} m");
    let share = seen(effects.fluids(), &effects.fluids().places(&skin));
    assert!(share > 0.8, "{share} of a path of {far_m} m");
    assert!(is_balanced(effects.fluids()));
}

#[test]
fn a_path_longer_than_the_window_has_a_film_at_the_middle_of_its_blood() {
    let mut mesh = SkinMesh::default();
    add_sheet(&mut mesh, Vec3::ZERO, 0.3, 0.5);
    let top = Vec3::new(-0.14, 0.07, 0.0);
    let effects = played(&mut mesh, &[leak(top, 60.0, false)], 12.0, 0.05);
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let fluids = effects.fluids();
    let places = fluids.places(&skin);
    let ran_m = places.iter().map(|at| at.x - top.x).fold(0.0, f32::max);
    let window_m = Field::extent_m().x;
    assert!(ran_m > 2.0 * window_m, "it ran {ran_m} m");
    let field = fluids.field().expect("wet");
    let mean_m = places.iter().sum::<Vec3>() / places.len() as f32;
    assert!(field.covers(mean_m, mean_m), "{mean_m}");
    // The path is about evenly wet, so a window at its middle holds the share window / path of the
    // blood. A window at the leak would hold only half of that.
    let share = seen(fluids, &places);
    assert!(share > 0.9 * window_m / ran_m, "{share} of {ran_m} m");
    assert!(is_balanced(fluids));
}

/// A jet or a mouth of the irrigator at `at_m`, which points down.
fn irrigator(kind: Kind, at_m: Vec3, lasts_s: f32) -> Effect {
    Effect {
        kind,
        at_m,
        along: Vec3::NEG_Y,
        lasts_s,
        ..leak(at_m, 240.0, false)
    }
}

/// Pours blood on a level sheet for two seconds, then works with the irrigator for as long.
fn after_blood(kind: Kind, off: Vec3) -> (Effects, Balance) {
    let mut mesh = SkinMesh::default();
    add_sheet(&mut mesh, Vec3::ZERO, 0.06, 0.0);
    let spheres = sphere_under(&mut mesh, Vec3::ZERO);
    let skin = Skin::new(&mesh, &spheres.0, &spheres.1, &[]);
    let mut effects = Effects::new(Vec3::Y);
    let once = Effect {
        lasts_s: 2.0,
        ..leak(Vec3::ZERO, 30.0, false)
    };
    effects.begin(&once, &skin);
    for _ in 0..40 {
        effects.advance(0.05, &skin);
    }
    let before = effects.fluids().balance();
    effects.begin(&irrigator(kind, off, 2.0), &skin);
    for _ in 0..40 {
        effects.advance(0.05, &skin);
    }
    assert!(
        is_balanced(effects.fluids()),
        "{:?}",
        effects.fluids().balance()
    );
    (effects, before)
}

/// As [`sphere_at_rest`], with a sphere at a place of the skin, so that jets meet it.
fn sphere_under(
    mesh: &mut SkinMesh,
    at: Vec3,
) -> (
    Vec<shared_mem::scene::SphereRecord>,
    Vec<shared_mem::message::SphereState>,
) {
    let (mut rest, mut now) = sphere_at_rest(mesh);
    for (rest, now) in rest.iter_mut().zip(&mut now) {
        (rest.center_m, now.center_m) = (at.to_array(), at.to_array());
        rest.radius_m = 0.002;
    }
    (rest, now)
}

#[test]
fn suction_takes_fluid_near_its_mouth_into_the_jar_and_none_far_away() {
    let (effects, before) = after_blood(Kind::Suction, Vec3::Y * 0.002);
    let after = effects.fluids().balance();
    assert!(before.lies_ml[0] > 0.4, "{before:?}");
    let jar_ml = after.jar_ml[0];
    assert!(
        jar_ml > 0.5 * before.lies_ml[0],
        "{jar_ml} ml of {before:?}"
    );
    assert!((effects.fluids().jar().0 - jar_ml).abs() < 1e-9);
    // A mouth above the pool takes only air.
    for above_m in [0.009, 0.03] {
        let (far, _) = after_blood(Kind::Suction, Vec3::Y * above_m);
        assert!(far.fluids().balance().jar_ml[0] <= 0.0, "at {above_m} m");
    }
}

#[test]
fn fluid_around_the_suction_flows_to_it_but_a_film_and_far_fluid_stay() {
    let mut mesh = SkinMesh::default();
    add_sheet(&mut mesh, Vec3::ZERO, 0.06, 0.0);
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let mut fluids = Fluids::new(Vec3::Y);
    fluids.field = Some(Field::around(Vec3::ZERO));
    let place_at = |at: Vec3| {
        let place = |triangle| Place {
            triangle,
            weights: [0.3, 0.3, 0.4],
        };
        let far = |it: &Place| Surface::at_rest(it, &skin).distance_squared(at);
        let all = (0..skin.triangles().len() as u32).map(place);
        all.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap()
    };
    // Beside the mouth, near it and far from it; and a film near it.
    let drop_m3 = 5e-9;
    let laid = [
        (0.003, drop_m3),
        (-0.009, drop_m3),
        (0.015, drop_m3),
        (0.009, 1e-10),
    ];
    for (x, volume_m3) in laid {
        let place = place_at(Vec3::X * x);
        fluids.lie(Lying::new(place, [volume_m3, 0.0, 0.0], 0.0), &skin);
    }
    fluids.begin_moment(&skin);
    fluids.step(0.001, &skin);
    let before = fluids.places(&skin);
    let mut suck = |above_m: f32| {
        for _ in 0..120 {
            fluids.suck(Vec3::Y * above_m, 1.0 / 120.0, &skin);
        }
        (fluids.places(&skin), fluids.jar().0)
    };
    let (places, jar_ml) = suck(0.006);
    assert_eq!(places, before, "no fluid rises to a mouth above it");
    assert!(jar_ml <= 0.0, "{jar_ml} ml");
    let (places, jar_ml) = suck(0.002);
    assert!((jar_ml - 2e6 * drop_m3).abs() < 1e-9, "{jar_ml} ml");
    assert_eq!(places, before[2..], "the rest of the fluid does not move");
}

#[test]
fn water_spreads_blood_and_thins_its_film() {
    let (effects, before) = after_blood(Kind::Water, Vec3::Y * 0.02);
    let after = effects.fluids().balance();
    let water_ml = after.leaked_ml[2];
    assert!(
        (water_ml - 8.0).abs() < 0.1,
        "240 ml/min for 2 s: {water_ml}"
    );
    assert!((after.leaked_ml[0] - before.leaked_ml[0]).abs() < 0.05);
    let (dry, _) = after_blood(Kind::Suction, Vec3::Y * 0.04);
    let thickest = |effects: &Effects| {
        let field = effects.fluids().field().expect("wet");
        let [xs, ys, zs] = field.wet().expect("wet");
        let mut most = 0.0f32;
        for z in zs[0]..zs[1] {
            for y in ys[0]..ys[1] {
                for x in xs[0]..xs[1] {
                    most = most.max(field.at([x, y, z]).thick_m[0]);
                }
            }
        }
        most
    };
    let (rinsed, untouched) = (thickest(&effects), thickest(&dry));
    assert!(rinsed < 0.7 * untouched, "{rinsed} of {untouched} m");
}

#[test]
fn water_that_meets_no_tissue_falls_and_a_full_jar_takes_no_more() {
    let mut mesh = SkinMesh::default();
    let spheres = sphere_at_rest(&mut mesh);
    let skin = Skin::new(&mesh, &spheres.0, &spheres.1, &[]);
    let mut effects = Effects::new(Vec3::Y);
    effects.begin(&irrigator(Kind::Water, Vec3::ZERO, 1.0), &skin);
    for _ in 0..60 {
        effects.advance(0.05, &skin);
    }
    let balance = effects.fluids().balance();
    assert!(balance.gone_ml[2] > 3.5, "{balance:?}");
    assert!(is_balanced(effects.fluids()));
    let mut fluids = Fluids::new(Vec3::Y);
    fluids.jar_m3 = [0.0, 0.0, 2e-3];
    fluids.throw(Vec3::ZERO, Vec3::ZERO, [1e-8, 0.0, 0.0], 0.0);
    fluids.suck(Vec3::ZERO, 1.0, &skin);
    assert_eq!(fluids.counts(), [0, 1]);
    assert!((fluids.jar().1 - 1.0).abs() < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_balance_has_all_fluid_that_left_a_vessel(
        slope in -2.0f32..2.0, ml_min in 0.5f32..300.0, pulses: bool, seconds in 0.1f32..6.0,
        frame_s in 0.02f32..1.0, along in any::<[f32; 3]>(), lasts_s in 0.2f32..3.0,
        rinses: bool, sucks: bool, off in -0.02f32..0.02,
    ) {
        let mut mesh = SkinMesh::default();
        add_sheet(&mut mesh, Vec3::ZERO, 0.03, slope);
        add_sheet(&mut mesh, Vec3::NEG_Y * 0.05, 0.03, 0.0);
        let start = leak(Vec3::ZERO, ml_min, pulses);
        let empties = Effect { lasts_s, kind: Kind::Bile, along: along.into(), ..start };
        let mut all = vec![start, empties];
        let mouth = Vec3::new(off, 0.01 - slope * off, 0.0);
        all.extend(rinses.then(|| irrigator(Kind::Water, mouth, lasts_s)));
        all.extend(sucks.then(|| irrigator(Kind::Suction, mouth, lasts_s)));
        let effects = played(&mut mesh, &all, seconds, frame_s);
        prop_assert!(is_balanced(effects.fluids()), "{:?}", effects.fluids().balance());
        let [lying, falling] = effects.fluids().counts();
        prop_assert!(lying <= LYING && falling <= FALLING);
        let skin = Skin::new(&mesh, &[], &[], &[]);
        prop_assert!(effects.fluids().places(&skin).iter().all(|at| at.is_finite()));
    }
}
