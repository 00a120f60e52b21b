//! Prepared scenes in the core's solver: they stay at rest, and organs hold each other.

use crate::support::LoadedScene;
use std::collections::BTreeMap;

use rt_core::math::Vec3;
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};
use scene_prepare::{Recipe, links, prepare};
use shared_mem::scene::{LinkRecord, SceneData};

const TICKS: usize = 400;

/// The sphere in the middle of a tube.
fn middle_of(prepared: &LoadedScene, organ: usize) -> u32 {
    let o = &prepared.organs[organ];
    o.sphere_start + o.sphere_count / 2
}

#[test]
fn triangle_rests_and_its_organs_hold_each_other() {
    let mut recipe = Recipe::triangle(false).unwrap();
    // The tests in `sewing.rs` look at sutures.
    recipe.ties.clear();
    let built = prepare(&recipe, &mut |_| {}).unwrap();
    let loaded = LoadedScene::new(&built.scene);
    let organ = |name: &str| {
        let all = &built.report.organs;
        all.iter().position(|o| o.name == name).unwrap()
    };
    let spheres = built.scene.spheres.len() as u32;
    let largest = |tissue: &Tissue<'_>, range: std::ops::Range<u32>| {
        range
            .map(|i| tissue.displacement_m(i).norm())
            .fold(0.0, f32::max)
    };
    let of = |organ: usize| {
        let o = &loaded.organs[organ];
        o.sphere_start..o.sphere_start + o.sphere_count
    };

    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    for _ in 0..TICKS {
        tissue.step();
    }
    let moved_m = largest(&tissue, 0..spheres);
    assert!(moved_m < 5e-6, "at rest it moves by {moved_m} m");

    // The cystic duct is pulled 6 mm towards the feet. Gallbladder and bile duct follow, and go
    // back when the duct is let go.
    let duct = organ("cystic duct");
    let led = middle_of(&loaded, duct);
    tissue.hold(led, true);
    for tick in 0..TICKS {
        let share = (tick as f32 / 200.0).min(1.0);
        tissue.lead(led, &Vec3::new(0.0, -0.006 * share, 0.0));
        tissue.step();
    }
    for name in ["gallbladder", "bile duct"] {
        let moved_m = largest(&tissue, of(organ(name)));
        assert!((0.0001..0.006).contains(&moved_m), "{name}: {moved_m} m");
    }
    let mut duct_lengths = built.scene.links[loaded.organs[duct].link_start as usize..]
        [..loaded.organs[duct].link_count as usize]
        .iter()
        .map(|l| {
            let at = |i: u32| {
                Vec3::from(built.scene.spheres[i as usize].center_m) + tissue.displacement_m(i)
            };
            (at(l.a) - at(l.b)).norm() / l.rest_length_m
        });
    assert!(duct_lengths.all(|stretch| stretch.is_finite() && stretch < 2.0));
    tissue.hold(led, false);
    for _ in 0..3 * TICKS {
        tissue.step();
    }
    // The duct itself may stay kinked, because a row of spheres hardly resists a kink.
    for (name, limit_m) in [
        ("gallbladder", 0.002),
        ("bile duct", 0.002),
        ("cystic duct", 0.006),
    ] {
        let left_m = largest(&tissue, of(organ(name)));
        assert!(left_m < limit_m, "let go, {name} is still {left_m} m off");
    }
}

/// The scene without the links of `organ` for which `is_cut` is true.
fn without(scene: &SceneData, organ: usize, is_cut: impl Fn(&LinkRecord) -> bool) -> SceneData {
    let mut left = SceneData {
        links: Vec::new(),
        ..scene.clone()
    };
    for (i, o) in left.organs.iter_mut().enumerate() {
        let [first, count] = o.links.map(|n| n as usize);
        let own = &scene.links[first..first + count];
        let start = left.links.len();
        for (k, link) in own.iter().enumerate() {
            if i == organ && is_cut(link) {
                o.elastic_links -= u32::from(k < scene.organs[i].elastic_links as usize);
            } else {
                left.links.push(*link);
            }
        }
        o.links = [start as u32, (left.links.len() - start) as u32];
    }
    left
}

/// Distance of each sphere of a tube from one end of the tube, along the tube's links, m.
fn way_along(scene: &SceneData, organ: usize) -> BTreeMap<u32, f32> {
    let o = &scene.organs[organ];
    let own = o.spheres[0]..o.spheres[0] + o.spheres[1];
    let links = &scene.links[o.links[0] as usize..][..o.links[1] as usize];
    let from = |start: u32| {
        let mut way: BTreeMap<u32, f32> = own.clone().map(|i| (i, f32::INFINITY)).collect();
        way.insert(start, 0.0);
        for _ in own.clone() {
            for link in links {
                for (a, b) in [(link.a, link.b), (link.b, link.a)] {
                    let through = way[&a] + link.rest_length_m;
                    if through < way[&b] {
                        way.insert(b, through);
                    }
                }
            }
        }
        way
    };
    let far = from(own.start);
    let end = far.iter().max_by(|a, b| a.1.total_cmp(b.1));
    from(end.map_or(own.start, |(i, _)| *i))
}

/// A tube may be cut between any two spheres that follow each other. Each stump stays with the
/// organ at its end, and does not follow the other stump.
#[test]
fn tubes_are_cut_at_any_place() {
    let built = crate::prepared_triangle(false);
    let scene = &built.scene;
    for name in ["cystic duct", "cystic artery"] {
        let organ = built.report.organs.iter().position(|o| o.name == name);
        let organ = organ.unwrap();
        let way = way_along(scene, organ);
        let mut along: Vec<(u32, f32)> = way.iter().map(|(i, m)| (*i, *m)).collect();
        along.sort_by(|a, b| a.1.total_cmp(&b.1));
        let tied = |i: u32| scene.attachments.iter().any(|t| t.a == i || t.b == i);
        let moved_m = |scene: &SceneData, led: u32, seen: u32| {
            let loaded = LoadedScene::new(scene);
            let mut bodies = Box::new(Bodies::new());
            let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
            tissue.hold(led, true);
            for tick in 0..300 {
                let share = (tick as f32 / 200.0).min(1.0);
                tissue.lead(led, &Vec3::new(0.0, -0.006 * share, 0.0));
                assert_eq!(tissue.step(), 0, "finite");
            }
            tissue.displacement_m(seen).norm()
        };
        // The spheres at the ends that are attached to other organs are not cut apart. Every place
        // between them is cut.
        let first_free = along.iter().position(|(i, _)| !tied(*i)).unwrap();
        let last_free = along.iter().rposition(|(i, _)| !tied(*i)).unwrap();
        for k in first_free..=last_free {
            let at_m = 0.5 * (along[k].1 + along[k - 1].1);
            let is_before = |i: u32| way[&i] < at_m;
            let cut = without(scene, organ, |l| is_before(l.a) != is_before(l.b));
            cut.to_bytes().unwrap();
            let o = &cut.organs[organ];
            let links = &cut.links[o.links[0] as usize..][..o.links[1] as usize];
            let pairs: Vec<[u32; 2]> = links
                .iter()
                .map(|l| [l.a - o.spheres[0], l.b - o.spheres[0]])
                .collect();
            let (piece, pieces) = links::pieces(&pairs, o.spheres[1] as usize);
            assert_eq!(pieces, 2, "{name}, cut {k}");
            for side in [&along[..k], &along[k..]] {
                let own = piece[(side[0].0 - o.spheres[0]) as usize];
                assert!(
                    side.iter()
                        .all(|(i, _)| piece[(i - o.spheres[0]) as usize] == own)
                );
                assert!(
                    side.iter().any(|(i, _)| tied(*i)),
                    "{name}, cut {k}: stays with an organ"
                );
            }
            if (k - first_free) % 5 == 2 {
                let (led, seen) = (along[k - 1].0, along[k].0);
                let (whole_m, cut_m) = (moved_m(scene, led, seen), moved_m(&cut, led, seen));
                assert!(
                    whole_m > 0.002 && cut_m < 0.25 * whole_m,
                    "{name}, cut {k}: the other stump moves {cut_m} m, uncut {whole_m} m"
                );
            }
        }
    }
}
