//! The order in which a solver walks constraints.

use std::cmp::Reverse;

/// Constraints fewer than this many places apart share no sphere, where that is possible. A loop
/// over them then does not wait for its own results, and eight fit into a vector register.
const APART: usize = 8;

/// A permutation of the constraints in which any eight consecutive ones share no sphere, as far as
/// possible. A constraint is given by the spheres that it moves; `count` is the number of spheres.
#[must_use]
pub fn spread<const N: usize>(constraints: &[[u32; N]], count: usize) -> Vec<usize> {
    let mut degree = vec![0usize; count];
    for &i in constraints.as_flattened() {
        degree[i as usize] += 1;
    }
    let busiest = |c: &[u32; N]| c.iter().map(|&i| degree[i as usize]).max();
    // Spheres with many constraints come first. Otherwise their constraints would be left for the
    // end.
    let mut waiting: Vec<Option<usize>> = (0..constraints.len()).map(Some).collect();
    waiting.sort_by_key(|i| i.map(|i| (Reverse(busiest(&constraints[i])), constraints[i])));
    let mut ordered = Vec::with_capacity(constraints.len());
    let mut last_use = vec![None::<usize>; count];
    let mut first = 0;
    while ordered.len() < constraints.len() {
        let position = ordered.len();
        let age = |c: &[u32; N]| {
            let of = |&i: &u32| last_use[i as usize].map_or(usize::MAX, |at| position - at);
            c.iter().map(of).min().unwrap_or(usize::MAX)
        };
        while waiting.get(first).is_some_and(Option::is_none) {
            first += 1;
        }
        // Takes the first constraint whose spheres are free; without any, the one whose spheres
        // were used longest ago.
        let mut chosen = None;
        for (slot, index) in waiting.iter().enumerate().skip(first) {
            let Some(index) = *index else { continue };
            let age = age(&constraints[index]).min(APART);
            if chosen.is_none_or(|(best, _, _)| age > best) {
                chosen = Some((age, slot, index));
            }
            if age == APART {
                break;
            }
        }
        let Some((_, slot, index)) = chosen else {
            break;
        };
        waiting[slot] = None;
        for &i in &constraints[index] {
            last_use[i as usize] = Some(position);
        }
        ordered.push(index);
    }
    ordered
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
        // The last few are left out: no other constraints remain to be put between them.
        for window in order[..99 - 2 * APART].windows(APART) {
            let mut spheres: Vec<u32> = window.iter().flat_map(|&i| chain[i]).collect();
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
