//! Links (distance constraints) between spheres.

use crate::order;
use crate::pack::{Ball, Line};
use crate::tetra::Tetra;

/// Largest number of overlapping neighbours that a sphere chooses to be linked to (the paper's
/// number). It has more links if others choose it.
const CHOSEN_MAX: usize = 6;
/// Fewest links of a sphere.
const DEGREE_MIN: usize = 3;

/// Links each sphere to its nearest overlapping spheres, at most `CHOSEN_MAX`. Then adds links
/// until each sphere has `DEGREE_MIN` links and all spheres are connected, and orders the links for
/// the solver.
#[must_use]
pub fn link(balls: &[Ball]) -> Vec<[u32; 2]> {
    let near = neighbours(balls);
    let mut links = Vec::new();
    for (a, list) in near.iter().enumerate() {
        let overlapping = list
            .iter()
            .filter(|(b, distance)| *distance < balls[a].radius_m + balls[*b as usize].radius_m);
        links.extend(
            overlapping
                .take(CHOSEN_MAX)
                .map(|&(b, _)| pair(a as u32, b)),
        );
    }
    complete(balls, &near, links)
}

/// Links the spheres along the edges of their tetrahedra, then adds missing links as [`link`] does.
#[must_use]
pub fn link_edges(balls: &[Ball], tets: &[Tetra]) -> Vec<[u32; 2]> {
    let edges = |t: &Tetra| {
        let [a, b, c, d] = t.spheres;
        [
            pair(a, b),
            pair(a, c),
            pair(a, d),
            pair(b, c),
            pair(b, d),
            pair(c, d),
        ]
    };
    complete(
        balls,
        &neighbours(balls),
        tets.iter().flat_map(edges).collect(),
    )
}

/// Links each sphere of a tube to the next one and to the next but one. The links to the next but
/// one keep the tube from bending like a chain. Then adds missing links as [`link`] does.
#[must_use]
pub fn link_line(line: &Line) -> Vec<[u32; 2]> {
    let mut links = line.steps.clone();
    for (i, first) in line.steps.iter().enumerate() {
        for second in &line.steps[i + 1..] {
            let common = first.iter().find(|end| second.contains(end));
            if let Some(&common) = common {
                let other = |step: &[u32; 2]| if step[0] == common { step[1] } else { step[0] };
                links.push(pair(other(first), other(second)));
            }
        }
    }
    complete(&line.balls, &neighbours(&line.balls), links)
}

fn complete(balls: &[Ball], near: &[Vec<(u32, f64)>], mut links: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    links.sort_unstable();
    links.dedup();
    raise_degree(near, &mut links, balls.len());
    connect(balls, &mut links);
    links.sort_unstable();
    let order = order::spread(&links, balls.len());
    order.into_iter().map(|i| links[i]).collect()
}

fn pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// For each sphere, the nearest other spheres and the distances between centres, nearest first.
fn neighbours(balls: &[Ball]) -> Vec<Vec<(u32, f64)>> {
    let of = |a: &Ball, own: usize| {
        let others = balls.iter().enumerate().filter(|(j, _)| *j != own);
        let mut near: Vec<(u32, f64)> = others
            .map(|(j, b)| (j as u32, (b.center - a.center).norm()))
            .collect();
        let keep = (4 * CHOSEN_MAX).min(near.len());
        if keep < near.len() {
            near.select_nth_unstable_by(keep, |x, y| x.1.total_cmp(&y.1).then(x.0.cmp(&y.0)));
            near.truncate(keep);
        }
        near.sort_by(|x, y| x.1.total_cmp(&y.1).then(x.0.cmp(&y.0)));
        near
    };
    balls.iter().enumerate().map(|(i, a)| of(a, i)).collect()
}

fn raise_degree(near: &[Vec<(u32, f64)>], links: &mut Vec<[u32; 2]>, count: usize) {
    let mut linked: Vec<Vec<u32>> = vec![Vec::new(); count];
    for &[a, b] in links.iter() {
        linked[a as usize].push(b);
        linked[b as usize].push(a);
    }
    for (a, list) in near.iter().enumerate() {
        for &(b, _) in list {
            if linked[a].len() >= DEGREE_MIN {
                break;
            }
            if !linked[a].contains(&b) {
                linked[a].push(b);
                linked[b as usize].push(a as u32);
                links.push(pair(a as u32, b));
            }
        }
    }
}

/// Number of the connected piece to which each sphere belongs, and number of pieces.
#[must_use]
pub fn pieces(links: &[[u32; 2]], count: usize) -> (Vec<u32>, usize) {
    let mut linked: Vec<Vec<u32>> = vec![Vec::new(); count];
    for &[a, b] in links {
        linked[a as usize].push(b);
        linked[b as usize].push(a);
    }
    let mut piece = vec![u32::MAX; count];
    let mut found = 0;
    for first in 0..count {
        if piece[first] != u32::MAX {
            continue;
        }
        piece[first] = found;
        let mut stack = vec![first];
        while let Some(at) = stack.pop() {
            for &next in &linked[at] {
                if piece[next as usize] == u32::MAX {
                    piece[next as usize] = found;
                    stack.push(next as usize);
                }
            }
        }
        found += 1;
    }
    (piece, found as usize)
}

/// Joins separate pieces. Each round joins the first piece to the piece nearest to it, by up to
/// [`DEGREE_MIN`] short links from different spheres, so that the joint is not a hinge.
fn connect(balls: &[Ball], links: &mut Vec<[u32; 2]>) {
    loop {
        let (piece, count) = pieces(links, balls.len());
        if count < 2 {
            return;
        }
        let mut bridges: Vec<(f64, u32, u32)> = Vec::new();
        for (i, a) in balls.iter().enumerate().filter(|(i, _)| piece[*i] == 0) {
            let others = balls.iter().enumerate().filter(|(j, _)| piece[*j] != 0);
            let nearest = others
                .map(|(j, b)| ((b.center - a.center).norm(), i as u32, j as u32))
                .min_by(|x, y| x.0.total_cmp(&y.0).then(x.2.cmp(&y.2)));
            bridges.extend(nearest);
        }
        bridges.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let Some(&(_, _, first)) = bridges.first() else {
            return;
        };
        let to = piece[first as usize];
        let same = bridges.iter().filter(|(_, _, j)| piece[*j as usize] == to);
        links.extend(same.take(DEGREE_MIN).map(|&(_, i, j)| pair(i, j)));
    }
}
