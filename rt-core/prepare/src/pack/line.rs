//! Packing of thin organs: spheres along the centre line of a tube and of its branches.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use super::{Ball, Interior};
use crate::Vec3;

/// A piece of a slice with less than this share of the mean piece's points is a bump, not a branch.
const BUMP_SHARE: f64 = 0.2;

/// Spheres along a tube, numbered from one end of the tube, and pairs that follow each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The spheres. Each is as wide as the tube.
    pub balls: Vec<Ball>,
    /// Pairs of spheres that follow each other.
    pub steps: Vec<[u32; 2]>,
}

/// Cuts the tube into slices by the length of the way through the inside from one end. Each
/// connected piece of a slice becomes a sphere, unless it is a bump. There are at most `count`
/// spheres, unless even two slices give more.
#[must_use]
pub fn pack_line(interior: &Interior<'_>, count: usize) -> Line {
    let way_m = way_from_end(interior);
    let longest = way_m.values().copied().fold(0.0, f64::max);
    let mut slices = count.max(2);
    loop {
        let line = slice(interior, &way_m, longest, slices);
        if line.balls.len() <= count || slices <= 2 {
            return line;
        }
        slices = (slices * count / line.balls.len()).clamp(2, slices - 1);
    }
}

/// Length of the shortest way through the inside from one end of the tube to each grid point, m.
fn way_from_end(interior: &Interior<'_>) -> HashMap<u32, f64> {
    let from = |start: u32| {
        let way = ways(interior, start);
        let farthest = way
            .iter()
            .max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)));
        (farthest.map_or(start, |(i, _)| *i), way)
    };
    let (end, _) = from(interior.points[0]);
    let (_, way) = from(end);
    way
}

#[derive(PartialEq)]
struct Reached(f64, u32);

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Lengths of Dijkstra's shortest ways from `start` to the grid points inside, with steps to all 26
/// neighbours, m.
fn ways(interior: &Interior<'_>, start: u32) -> HashMap<u32, f64> {
    let mut way = HashMap::from([(start, 0.0)]);
    let mut heap = BinaryHeap::from([Reached(0.0, start)]);
    while let Some(Reached(length, i)) = heap.pop() {
        if length > way[&i] {
            continue;
        }
        for (next, step) in around(interior, i) {
            let length = length + step;
            if way.get(&next).is_none_or(|&known| length < known) {
                way.insert(next, length);
                heap.push(Reached(length, next));
            }
        }
    }
    way
}

/// The up to 26 neighbours of a grid point inside the organ, and their distances, m.
fn around<'a>(interior: &'a Interior<'_>, i: u32) -> impl Iterator<Item = (u32, f64)> + 'a {
    let grid = &interior.field.grid;
    let at = grid.coordinates(i as usize);
    (0..27usize).filter(|&k| k != 13).filter_map(move |k| {
        let step = [k % 3, k / 3 % 3, k / 9];
        let mut next = [0; 3];
        for axis in 0..3 {
            next[axis] = (at[axis] + step[axis]).checked_sub(1)?;
            if next[axis] >= grid.size[axis] {
                return None;
            }
        }
        let index = grid.index(next);
        let squared = step.iter().filter(|&&s| s != 1).count() as f64;
        let inside = interior.field.is_inside(index);
        inside.then(|| (index as u32, squared.sqrt() * grid.cell_m))
    })
}

fn slice(interior: &Interior<'_>, way_m: &HashMap<u32, f64>, longest: f64, slices: usize) -> Line {
    let slice_of = |i: u32| {
        let share = way_m.get(&i)? / longest.max(f64::MIN_POSITIVE);
        Some(((share * slices as f64) as usize).min(slices - 1))
    };
    // A piece is a connected set of points of one slice.
    let mut piece_of: HashMap<u32, u32> = HashMap::new();
    let mut pieces: Vec<Vec<u32>> = Vec::new();
    for &first in &interior.points {
        let Some(slice) = slice_of(first) else {
            continue;
        };
        if piece_of.contains_key(&first) {
            continue;
        }
        let number = pieces.len() as u32;
        piece_of.insert(first, number);
        let mut members = vec![first];
        let mut next = 0;
        while next < members.len() {
            for (j, _) in around(interior, members[next]) {
                if slice_of(j) == Some(slice) && !piece_of.contains_key(&j) {
                    piece_of.insert(j, number);
                    members.push(j);
                }
            }
            next += 1;
        }
        pieces.push(members);
    }
    // Number the spheres in their order along the line, because `Sim::start` finds a place along a
    // tube by counting spheres.
    pieces.sort_by_key(|members| (slice_of(members[0]), members[0]));
    for (number, members) in pieces.iter().enumerate() {
        for &member in members {
            piece_of.insert(member, number as u32);
        }
    }
    let mean = interior.points.len() as f64 / pieces.len().max(1) as f64;
    let mut number = vec![None; pieces.len()];
    let mut line = Line {
        balls: Vec::new(),
        steps: Vec::new(),
    };
    for (piece, members) in pieces.iter().enumerate() {
        if members.len() as f64 >= BUMP_SHARE * mean {
            number[piece] = Some(line.balls.len() as u32);
            let sum: Vec3 = members.iter().map(|&i| interior.position(i)).sum();
            let middle = sum / members.len() as f64;
            line.balls.push(interior.inscribed(middle, f64::INFINITY));
        }
    }
    for &i in &interior.points {
        let here = piece_of.get(&i).and_then(|&piece| number[piece as usize]);
        let Some(here) = here else { continue };
        for (j, _) in around(interior, i) {
            let there = piece_of.get(&j).and_then(|&piece| number[piece as usize]);
            if let Some(there) = there.filter(|&there| there > here) {
                line.steps.push([here, there]);
            }
        }
    }
    line.steps.sort_unstable();
    line.steps.dedup();
    line
}
