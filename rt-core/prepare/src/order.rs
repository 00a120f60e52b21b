//! Order in which a solver walks constraints.

use std::cmp::Reverse;
use std::collections::BTreeSet;

/// As far as possible, constraints fewer than this many places apart share no sphere. So a loop
/// over constraints does not wait for its own results, and eight at once fit into vector registers.
const APART: usize = 8;

/// Place of a waiting constraint in the queue. Each of its spheres has a number of waiting
/// constraints: the largest of these numbers decides, then their sum, then the constraint's index.
type Turn = (Reverse<usize>, Reverse<usize>, usize);

/// A permutation of the constraints in which any eight consecutive constraints share no sphere, as
/// far as possible. A constraint is given by the spheres that it moves. `count` is the number of
/// spheres.
#[must_use]
pub fn spread<const N: usize>(constraints: &[[u32; N]], count: usize) -> Vec<usize> {
    let mut waiting_at = vec![Vec::new(); count];
    for (index, spheres) in constraints.iter().enumerate() {
        for &i in spheres {
            waiting_at[i as usize].push(index);
        }
    }
    // The constraints of the sphere with the most waiting constraints come first, counted anew
    // after each choice. Otherwise the constraints of a few spheres would be left for the end, with
    // no others to put between them.
    let turn = |waiting_at: &[Vec<usize>], index: usize| -> Turn {
        let counts = constraints[index].map(|i| waiting_at[i as usize].len());
        let most = counts.into_iter().max().unwrap_or(0);
        (Reverse(most), Reverse(counts.iter().sum()), index)
    };
    let mut turns: Vec<Turn> = (0..constraints.len())
        .map(|index| turn(&waiting_at, index))
        .collect();
    let mut queue: BTreeSet<Turn> = turns.iter().copied().collect();
    let mut last_use = vec![None::<usize>; count];
    let mut ordered = Vec::with_capacity(constraints.len());
    while let Some(index) = next(&queue, |index| {
        let of = |&i: &u32| last_use[i as usize].map_or(APART, |at| ordered.len() - at);
        constraints[index].iter().map(of).min().unwrap_or(APART)
    }) {
        queue.remove(&turns[index]);
        for &i in &constraints[index] {
            last_use[i as usize] = Some(ordered.len());
            waiting_at[i as usize].retain(|other| *other != index);
        }
        for &i in &constraints[index] {
            for &other in &waiting_at[i as usize] {
                queue.remove(&turns[other]);
                turns[other] = turn(&waiting_at, other);
                queue.insert(turns[other]);
            }
        }
        ordered.push(index);
    }
    ordered
}

/// The first constraint in the queue whose spheres are free; if there is none, the constraint whose
/// spheres were used longest ago. `age` is the number of places since a constraint's spheres were
/// used.
fn next(queue: &BTreeSet<Turn>, age: impl Fn(usize) -> usize) -> Option<usize> {
    let mut chosen = None;
    for &(.., index) in queue {
        let age = age(index).min(APART);
        if chosen.is_none_or(|(best, _)| age > best) {
            chosen = Some((age, index));
        }
        if age == APART {
            break;
        }
    }
    chosen.map(|(_, index)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_taken_apart() {
        let chain: Vec<[u32; 2]> = (0..99).map(|i| [i, i + 1]).collect();
        let order = spread(&chain, 100);
        let mut seen = order.clone();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..99), "a permutation");
        // The last few windows are not checked: no other constraints remain to put between theirs.
        for window in order[..99 - 2 * APART].windows(APART) {
            let mut spheres: Vec<u32> = window.iter().flat_map(|&i| chain[i]).collect();
            spheres.sort_unstable();
            spheres.dedup();
            assert_eq!(spheres.len(), 16);
        }
    }

    /// Spheres of a block of tissue have up to 26 links each. Any eight consecutive links share no
    /// sphere, even at the end.
    #[test]
    fn links_of_a_block_are_taken_apart_to_the_end() {
        const SIDE: i32 = 6;
        let number = |[x, y, z]: [i32; 3]| (x + SIDE * (y + SIDE * z)) as u32;
        let places = (0..SIDE.pow(3)).map(|i| [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE]);
        let mut links = Vec::new();
        for a in places.clone() {
            let near = |b: &[i32; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) < 2);
            let after = places.clone().filter(|b| near(b) && number(*b) > number(a));
            links.extend(after.map(|b| [number(a), number(b)]));
        }
        let order = spread(&links, SIDE.pow(3) as usize);
        for window in order.windows(APART) {
            let mut spheres: Vec<u32> = window.iter().flat_map(|&i| links[i]).collect();
            spheres.sort_unstable();
            spheres.dedup();
            assert_eq!(spheres.len(), 16);
        }
    }

    #[test]
    fn a_star_that_cannot_be_taken_apart_is_still_complete() {
        let star: Vec<[u32; 2]> = (1..20).map(|i| [0, i]).collect();
        assert_eq!(spread(&star, 20).len(), 19);
    }
}
