extern crate std;

use std::boxed::Box;
use std::vec::Vec as List;

use proptest::prelude::*;

use super::*;
use crate::scene::tests::{organ, room, sphere};
use crate::scene::{
    Attachment, COLUMNS, Cell, Column, Layers, Link, NO_CELL, Organ, RestSphere, SKIN_BINDINGS,
};

const SIDE: u16 = 10;
const LAYERS: u16 = 8;
/// Spheres of the sheet; a sphere of another organ follows.
const SPHERES: u32 = 16;

/// A block of cells over a row of linked spheres, each attached to a sphere of another organ.
struct Block {
    organs: [Organ; 2],
    spheres: List<RestSphere>,
    links: List<Link>,
    ties: List<Attachment>,
    cells: List<Cell>,
    columns: List<Column>,
}

impl Block {
    fn new() -> Self {
        let at = |i: u32| Vec3::x() * (0.004 * i as f32);
        let index = |[x, y, z]: [u16; 3]| x + SIDE * (y + SIDE * z);
        let mut cells = List::new();
        for z in 0..LAYERS {
            for y in 0..SIDE {
                for x in 0..SIDE {
                    let place = [x, y, z];
                    let neighbours = core::array::from_fn(|face| {
                        let mut adjacent = place;
                        let last = [SIDE, SIDE, LAYERS][face / 2] - 1;
                        match face % 2 {
                            0 if place[face / 2] > 0 => adjacent[face / 2] -= 1,
                            1 if place[face / 2] < last => adjacent[face / 2] += 1,
                            _ => return NO_CELL,
                        }
                        index(adjacent)
                    });
                    cells.push(Cell {
                        spheres: [x * SPHERES as u16 / SIDE; SKIN_BINDINGS],
                        weights: core::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 }),
                        neighbours,
                        center_m: Vec3::new(f32::from(x), f32::from(y), f32::from(z)) * 0.001,
                        extent_m: [0.001; 3],
                        volume_m3: 1.0e-9 * (1.0 + 0.01 * f32::from(y)),
                        energy_j: 1.0,
                    });
                }
            }
        }
        let links = (0..SPHERES - 1).map(|a| Link {
            a,
            b: a + 1,
            rest_length_m: 0.004,
            compliance_m_n: 0.001,
        });
        let ties = (0..SPHERES).map(|i| Attachment {
            sphere: i,
            to: Anchor::Sphere(SPHERES),
            rest_length_m: 0.01,
            compliance_m_n: 0.01,
            is_thread: false,
            tear_j: 0.001,
        });
        let top = index([SIDE / 2, SIDE / 2, LAYERS - 1]);
        let mut column = Column {
            cells: [NO_CELL; COLUMNS],
            inwards: [4; COLUMNS],
        };
        column.cells[0] = top;
        Self {
            organs: [
                organ(0, SPHERES, 0, SPHERES - 1),
                organ(SPHERES, 1, SPHERES - 1, 0),
            ],
            spheres: (0..=SPHERES).map(|i| sphere(at(i), 0.002)).collect(),
            links: links.collect(),
            ties: ties.collect(),
            cells,
            columns: [column].into(),
        }
    }

    fn scene(&self) -> Scene<'_> {
        Scene::new(&self.organs, &self.spheres, &self.links, room())
            .and_then(|scene| scene.with_attachments(&self.ties))
            .and_then(|scene| {
                scene.with_cells(Layers {
                    cells: &self.cells,
                    columns: &self.columns,
                })
            })
            .unwrap()
    }
}

fn loaded(scene: &Scene<'_>) -> Box<Bodies> {
    let mut bodies = Box::new(Bodies::new());
    bodies.load(scene);
    bodies
}

/// The state that follows from the set of removed cells, bit for bit.
fn outcome(bodies: &Bodies, scene: &Scene<'_>) -> List<u32> {
    let mut all = List::new();
    for i in 0..scene.layers.cells.len() as u16 {
        let present = bodies.cells.is_present(i);
        all.push(u32::from(present) + 2 * u32::from(present && bodies.cells.is_exposed(i)));
    }
    for i in 0..SPHERES {
        all.push(bodies.cells.remaining_share(i).to_bits());
        all.push(u32::from(bodies.bits.at(i).0));
        all.push(bodies.damage.intact_of_tie(i as usize).to_bits());
        all.push(bodies.damage.intact_of_link(i).to_bits());
    }
    all.push(bodies.cells.sunk_m(0, scene).to_bits());
    all
}

/// Asserts that exposure, volumes and flags agree with the set of removed cells.
fn check(bodies: &Bodies, scene: &Scene<'_>) {
    let mut remaining = [0u64; SPHERES as usize];
    for (i, cell) in (0u16..).zip(scene.layers.cells) {
        let place = usize::from(i);
        let heat_j = bodies.cells.heat_j[place];
        assert!((0.0..=cell.energy_j).contains(&heat_j), "{i}: {heat_j} J");
        if bodies.cells.is_present(i) {
            let open = |n: &u16| *n == NO_CELL || !bodies.cells.is_present(*n);
            let exposed = cell.neighbours.iter().any(open);
            assert_eq!(bodies.cells.is_exposed(i), exposed, "{i}");
            remaining[cell.sphere() as usize] += u64::from(volume_units(cell));
        }
    }
    for (i, remaining) in (0u32..).zip(remaining) {
        assert_eq!(
            u64::from(*bodies.cells.remaining_units.at(i)),
            remaining,
            "sphere {i}"
        );
        let removed = bodies.bits.at(i).contains(SphereBits::REMOVED);
        assert_eq!(
            removed,
            remaining == 0 && bodies.cells.has_cells(i),
            "sphere {i}"
        );
    }
}

/// xorshift: equal on every machine.
struct Dice(u32);

impl Dice {
    fn below(&mut self, n: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 % n
    }
}

/// Removes the whole block again and again in random order, and restores it. Some cells are removed
/// twice, some by heat; the heat may be any number.
#[test]
fn a_million_random_deletions_never_break_it() {
    let block = Block::new();
    let scene = block.scene();
    let mut bodies = loaded(&scene);
    let count = scene.layers.cells.len() as u32;
    let mut dice = Dice(2_463_534_242);
    let (mut removed, mut resets) = (0u32, 0);
    for step in 0..1_000_000u32 {
        // Some of these cells do not exist.
        let index = dice.below(count + 20) as u16;
        match dice.below(16) {
            0 => {
                let heat = [0.5, -1.0, f32::NAN, f32::INFINITY, 1.0e30, 0.0];
                let energy_j = heat[dice.below(6) as usize];
                if let Some(cell) = scene.layers.cell(index)
                    && bodies.cells.add_heat(index, cell, energy_j)
                {
                    removed += u32::from(bodies.remove_cell(index, &scene).is_some());
                }
            }
            _ => removed += u32::from(bodies.remove_cell(index, &scene).is_some()),
        }
        if step % 50_000 == 0 {
            check(&bodies, &scene);
        }
        if bodies.cells.removed == count {
            check(&bodies, &scene);
            bodies.reset(&scene);
            check(&bodies, &scene);
            resets += 1;
        }
    }
    assert!(removed > 50_000 && resets > 50, "{removed} {resets}");
}

#[test]
fn skin_sinks_with_its_cells_and_is_open_when_all_are_removed() {
    let block = Block::new();
    let scene = block.scene();
    let mut bodies = loaded(&scene);
    let mut cell = block.columns[0].cells[0];
    for removed in 0..LAYERS {
        let sunk_m = bodies.cells.sunk_m(0, &scene);
        assert!(
            (sunk_m - 0.001 * f32::from(removed)).abs() < 1.0e-7,
            "{sunk_m}"
        );
        bodies.remove_cell(cell, &scene).unwrap();
        cell = scene.layers.cell(cell).unwrap().across(4);
    }
    assert!(bodies.cells.sunk_m(0, &scene) > OPEN_DEPTH_M);
    assert!(bodies.cells.sunk_m(7, &scene) <= 0.0, "no such column");
}

#[test]
fn only_detached_cells_are_removed() {
    let block = Block::new();
    let scene = block.scene();
    let mut bodies = loaded(&scene);
    let mut removed = List::new();
    bodies.tear_cells(&scene, |cell| removed.push(cell.cell));
    assert!(removed.is_empty());
    bodies.damage.weaken_tie(3, 0.0);
    for _ in 0..100 {
        bodies.tear_cells(&scene, |cell| removed.push(cell.cell));
    }
    let own = (0u16..)
        .zip(&block.cells)
        .filter(|(_, cell)| cell.sphere() == 3);
    assert_eq!(removed, own.map(|(i, _)| i).collect::<List<u16>>());
    assert!(bodies.bits.at(3).contains(SphereBits::REMOVED));
    assert!(bodies.damage.intact_of_link(2) <= 0.0 && bodies.damage.intact_of_link(3) <= 0.0);
    assert!(bodies.damage.intact_of_link(4) >= 1.0);
    check(&bodies, &scene);
}

/// A sphere that did not follow would fall, and with it the cells that it carries in part.
#[test]
fn sphere_without_cells_moves_with_its_neighbours() {
    let block = Block::new();
    let scene = block.scene();
    let mut bodies = loaded(&scene);
    let target_m = Vec3::new(0.001, 0.002, -0.003);
    bodies.move_spheres_without_cells(&scene);
    for (index, _) in (0u16..)
        .zip(&block.cells)
        .filter(|(_, it)| it.sphere() == 3)
    {
        assert!(bodies.remove_cell(index, &scene).is_some());
    }
    for sphere in [2, 4] {
        bodies.nodes.at_mut(sphere).put(&target_m, &Vec3::zeros());
    }
    bodies.nodes.at_mut(3).put(&Vec3::y(), &-Vec3::y());
    for _ in 0..100 {
        bodies.move_spheres_without_cells(&scene);
    }
    let distance_m =
        |sphere: u32| crate::math::norm(&(bodies.nodes.at(sphere).moved_m() - target_m));
    assert!(distance_m(3) < 1.0e-6, "{}", distance_m(3));
    assert!(
        distance_m(2) <= 0.0 && distance_m(4) <= 0.0,
        "nobody follows it"
    );
    assert!(crate::math::norm(&bodies.nodes.at(3).velocity_m_s()) <= 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// The state does not depend on the order of removal, bit for bit. A reset restores the first
    /// state.
    #[test]
    fn order_of_removal_does_not_matter(
        order in Just((0..SIDE * SIDE * LAYERS).collect::<List<u16>>()).prop_shuffle(),
        taken in 0usize..800,
    ) {
        let block = Block::new();
        let scene = block.scene();
        let mut bodies = loaded(&scene);
        let initial = outcome(&bodies, &scene);
        for cell in &order[..taken] {
            prop_assert!(bodies.remove_cell(*cell, &scene).is_some());
        }
        let first = outcome(&bodies, &scene);
        bodies.reset(&scene);
        prop_assert_eq!(outcome(&bodies, &scene), initial);
        let mut sorted = order[..taken].to_vec();
        sorted.sort_unstable();
        for cell in sorted {
            bodies.remove_cell(cell, &scene);
        }
        prop_assert_eq!(outcome(&bodies, &scene), first);
        check(&bodies, &scene);
    }
}
