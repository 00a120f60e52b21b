//! Motion of the tissue around each sphere: the displacement of its centre, and the rotation and
//! stretch of its neighbours about it.
//!
//! Links join a sphere to its neighbours. Relative to the sphere, a neighbour has moved from `d` to
//! `d'`. `A = Σ d' dᵀ / |d|²` and `B = Σ d dᵀ / |d|²` give the deformation `F = A B⁻¹`, which is
//! exact wherever tissue deforms affinely. A sphere of a duct has no neighbours across the duct,
//! and a sphere may have lost neighbours. In directions without neighbours, the rotation part of
//! `A` takes the place of `F`. An iteration finds the rotation from that of the last frame (Müller,
//! Bender, Chentanez, Macklin: "A Robust Method to Extract the Rotational Part of Deformations",
//! 2016).
//!
//! Neighbours in a row do not tell how far a duct has turned about itself. From frame to frame,
//! each sphere would keep a twist of its own from past bends, and skin between two spheres of
//! different twist would collapse. So spheres in a row also follow the rotation of their
//! neighbours, and of the organ to which an end is attached.

use std::collections::BTreeSet;

use glam::{Mat3, Quat, Vec3};
use shared_mem::message::SphereState;
use shared_mem::scene::{SceneFile, WORLD};

/// An affine motion `x' = x + G x + t`, as the rows of `[G t]`. All zeros mean rest.
pub type Motion = [[f32; 4]; 3];

/// The parts of a sphere's motion that vertices follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follow {
    /// Translation with its centre (paper Eq. 9–12), for comparison.
    Shift,
    /// Translation and rotation, for comparison.
    Turn,
    /// Translation, rotation and stretch: the one in use.
    Deform,
}

/// Weight of the rotation, as a share of the neighbours' mean weight in a direction. The rotation
/// decides in directions without neighbours, and hardly matters elsewhere.
const PRIOR: f32 = 0.05;
/// Largest deviation of the deformation from the rotation (Frobenius norm). Without a limit, a few
/// neighbours in one plane would exaggerate the deviation.
const STRETCH_MAX: f32 = 0.6;
/// Weight of the neighbours' rotations for a sphere in a row, as a share of the neighbours' mean
/// weight in a direction. It is small, so that the neighbours' positions decide wherever they
/// determine the rotation.
const TWIST: f32 = 0.1;
/// A sphere counts as in a row if the second invariant of `B` is below this share of the squared
/// trace of `B`. The share is 1/3 with neighbours all around, 1/4 in a plane, 0 in a row.
const ROW: f32 = 0.06;
/// Largest number of iterations for the rotation. One or two suffice from the last frame's
/// rotation.
const STEPS: usize = 20;
/// Turn in one iteration below which the iteration ends, rad.
const TURNED_RAD: f32 = 1e-5;

/// Motions of a scene's spheres from frame to frame.
#[derive(Debug, Clone)]
pub struct Motions {
    follow: Follow,
    rest: Vec<Vec3>,
    links: Vec<[u32; 2]>,
    /// Index in `around` at which the neighbours of each sphere begin. The neighbours of sphere `i`
    /// are `around[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    around: Vec<u32>,
    /// Spheres in a row, and the spheres whose rotations each of them follows.
    rows: Vec<(u32, Vec<u32>)>,
    /// Attachments between spheres of two organs.
    ties: Vec<[u32; 2]>,
    /// `(B + prior)⁻¹` and the prior of each sphere. The prior is the weight of the rotation in
    /// every direction.
    inverse: Vec<(Mat3, f32)>,
    /// Present rotation of each sphere.
    turns: Vec<Quat>,
    /// Present motion of each sphere.
    now: Vec<Motion>,
}

impl Motions {
    /// Motions of a scene at rest.
    #[must_use]
    pub fn new(scene: &SceneFile, follow: Follow) -> Self {
        let rest: Vec<Vec3> = scene.spheres().iter().map(|s| s.center_m.into()).collect();
        let links = scene.links().iter().map(|l| [l.a, l.b]);
        let ties = scene.attachments().iter().filter(|tie| tie.b != WORLD);
        let ties = ties.map(|tie| [tie.a, tie.b]).collect();
        Self::tied(rest, links, ties, follow)
    }

    /// Motions of spheres at `rest` (m), joined by `links`.
    #[must_use]
    pub fn of(rest: Vec<Vec3>, links: impl Iterator<Item = [u32; 2]>, follow: Follow) -> Self {
        Self::tied(rest, links, Vec::new(), follow)
    }

    fn tied(
        rest: Vec<Vec3>,
        links: impl Iterator<Item = [u32; 2]>,
        ties: Vec<[u32; 2]>,
        follow: Follow,
    ) -> Self {
        let mut motions = Self {
            follow,
            turns: vec![Quat::IDENTITY; rest.len()],
            now: vec![Motion::default(); rest.len()],
            links: links.collect(),
            rest,
            first: Vec::new(),
            around: Vec::new(),
            rows: Vec::new(),
            ties,
            inverse: Vec::new(),
        };
        motions.find_neighbours(&[]);
        motions
    }

    /// Severs these links and joins all others. A severed link joins no neighbours.
    pub fn sever(&mut self, severed: &[[u32; 2]]) {
        self.find_neighbours(severed);
    }

    fn find_neighbours(&mut self, severed: &[[u32; 2]]) {
        let severed: BTreeSet<[u32; 2]> = severed.iter().map(|[a, b]| pair(*a, *b)).collect();
        let whole = |link: &&[u32; 2]| !severed.contains(&pair(link[0], link[1]));
        let mut first = vec![0u32; self.rest.len() + 1];
        for i in self.links.iter().filter(whole).flatten() {
            first[*i as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut around = vec![0u32; first[self.rest.len()] as usize];
        for &[a, b] in self.links.iter().filter(whole) {
            for (i, j) in [(a, b), (b, a)] {
                around[next[i as usize] as usize] = j;
                next[i as usize] += 1;
            }
        }
        self.first = first;
        self.around = around;
        self.inverse = (0..self.rest.len())
            .map(|i| {
                let b = self.spread(i, |j| self.rest[j]);
                let trace = b.x_axis.x + b.y_axis.y + b.z_axis.z;
                let prior = (PRIOR * trace / 3.0).max(1e-6);
                (
                    (b + Mat3::from_diagonal(Vec3::splat(prior))).inverse(),
                    prior,
                )
            })
            .collect();
        self.rows = (0..self.rest.len() as u32)
            .filter(|i| self.is_in_row(*i as usize))
            .map(|i| (i, self.followed(i)))
            .collect();
    }

    /// True if a sphere's neighbours lie in a row.
    fn is_in_row(&self, sphere: usize) -> bool {
        let b = self.spread(sphere, |j| self.rest[j]);
        let trace = b.x_axis.x + b.y_axis.y + b.z_axis.z;
        let squares = [b.x_axis, b.y_axis, b.z_axis].map(Vec3::length_squared);
        let invariant = 0.5 * (trace * trace - squares.iter().sum::<f32>());
        trace > 0.0 && invariant < ROW * trace * trace
    }

    /// The spheres whose rotations a sphere in a row follows.
    fn followed(&self, sphere: u32) -> Vec<u32> {
        let [first, end] = [sphere, sphere + 1].map(|i| self.first[i as usize] as usize);
        let tied = self.ties.iter().filter_map(|[a, b]| match sphere {
            it if it == *a => Some(*b),
            it if it == *b => Some(*a),
            _ => None,
        });
        self.around[first..end]
            .iter()
            .copied()
            .chain(tied)
            .collect()
    }

    /// Lets each sphere in a row turn with its neighbours. It takes the spheres in the order of
    /// their numbers, then in the reverse order.
    fn untwist(&mut self, at: impl Fn(usize) -> Vec3) {
        let there_and_back = (0..self.rows.len()).chain((0..self.rows.len()).rev());
        for row in there_and_back {
            let (sphere, followed) = &self.rows[row];
            let i = *sphere as usize;
            let sum = followed.iter().fold(Mat3::ZERO, |sum, j| {
                sum + Mat3::from_quat(self.turns[*j as usize])
            });
            let weight = TWIST * self.inverse[i].1 / PRIOR / followed.len().max(1) as f32;
            let a = self.spread(i, &at) + sum * weight;
            self.turns[i] = rotation(&a, self.turns[i]);
        }
    }

    /// Updates the motions. `spheres` has as many entries as the scene (a [`crate::feed::Feed`]
    /// ensures this), or none for rest.
    pub fn update(&mut self, spheres: &[SphereState]) -> &[Motion] {
        let rest = std::mem::take(&mut self.rest);
        let at = |i: usize| spheres.get(i).map_or(rest[i], |s| s.center_m.into());
        let places: Vec<Vec3> = (0..rest.len()).map(at).collect();
        self.rest = rest;
        let at = |i: usize| places[i];
        if self.follow != Follow::Shift {
            for i in 0..self.rest.len() {
                self.turns[i] = rotation(&self.spread(i, at), self.turns[i]);
            }
            self.untwist(at);
        }
        for i in 0..self.rest.len() {
            let shift = at(i) - self.rest[i];
            let grown = match self.follow {
                Follow::Shift => Mat3::ZERO,
                follow => {
                    let a = self.spread(i, at);
                    let turn = Mat3::from_quat(self.turns[i]);
                    let (inverse, prior) = self.inverse[i];
                    let deformed = match follow {
                        Follow::Deform => {
                            let stretch = (a + turn * prior) * inverse - turn;
                            let size = Vec3::from_array(
                                [stretch.x_axis, stretch.y_axis, stretch.z_axis].map(Vec3::length),
                            );
                            turn + stretch * (STRETCH_MAX / size.length().max(STRETCH_MAX))
                        }
                        _ => turn,
                    };
                    deformed - Mat3::IDENTITY
                }
            };
            let offset = shift - grown * self.rest[i];
            let rows = grown.transpose();
            self.now[i] = [
                rows.x_axis.extend(offset.x).to_array(),
                rows.y_axis.extend(offset.y).to_array(),
                rows.z_axis.extend(offset.z).to_array(),
            ];
        }
        &self.now
    }

    /// The motions of the last [`Motions::update`].
    #[must_use]
    pub fn now(&self) -> &[Motion] {
        &self.now
    }

    /// `Σ d' dᵀ / |d|²` over the neighbours of a sphere.
    fn spread(&self, i: usize, at: impl Fn(usize) -> Vec3) -> Mat3 {
        let [first, end] = [self.first[i], self.first[i + 1]].map(|x| x as usize);
        let (here, rest) = (at(i), self.rest[i]);
        let mut sum = Mat3::ZERO;
        for &j in &self.around[first..end] {
            let d = self.rest[j as usize] - rest;
            let now = at(j as usize) - here;
            let d = d / d.length_squared().max(1e-12);
            sum += Mat3::from_cols(now * d.x, now * d.y, now * d.z);
        }
        sum
    }
}

/// Rotation part of `a`, by iteration from `start`. In directions without information `start`
/// remains.
fn rotation(a: &Mat3, start: Quat) -> Quat {
    let mut turn = start;
    for _ in 0..STEPS {
        let r = Mat3::from_quat(turn);
        let torque = r.x_axis.cross(a.x_axis) + r.y_axis.cross(a.y_axis) + r.z_axis.cross(a.z_axis);
        let pull = r.x_axis.dot(a.x_axis) + r.y_axis.dot(a.y_axis) + r.z_axis.dot(a.z_axis);
        let step = torque / (pull.abs() + 1e-9);
        let angle = step.length();
        // The negation also catches NaN.
        if !(angle > TURNED_RAD && angle.is_finite()) {
            break;
        }
        turn = (Quat::from_axis_angle(step / angle, angle) * turn).normalize();
    }
    turn
}

/// Position of a point at rest after the motion, m.
#[must_use]
pub fn moved(motion: &Motion, at: Vec3) -> Vec3 {
    let row = |k: usize| Vec3::from_slice(&motion[k]).dot(at) + motion[k][3];
    at + Vec3::new(row(0), row(1), row(2))
}

/// The ends of a link, the smaller number first.
fn pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A block of spheres, each joined to its neighbours.
    fn block(side: usize) -> (Vec<Vec3>, Vec<[u32; 2]>) {
        let at = |i: usize| {
            let [x, y, z] = [i % side, i / side % side, i / side / side].map(|k| k as f32);
            // The shake makes the block a little different from a grid.
            let shake = Vec3::new(
                (i as f32 * 1.7).sin(),
                (i as f32 * 2.9).cos(),
                (i as f32).sin(),
            );
            (Vec3::new(x, y, z) + 0.2 * shake) * 0.012 + Vec3::new(0.1, 0.3, -0.2)
        };
        let rest: Vec<Vec3> = (0..side * side * side).map(at).collect();
        let mut links = Vec::new();
        for i in 0..rest.len() {
            let near = (0..i).filter(|&j| rest[i].distance(rest[j]) < 0.019);
            links.extend(near.map(|j| [i as u32, j as u32]));
        }
        (rest, links)
    }

    fn states(centers: impl Iterator<Item = Vec3>) -> Vec<SphereState> {
        centers
            .map(|c| SphereState {
                center_m: c.to_array(),
                bits: 0,
            })
            .collect()
    }

    fn unit(seed: [f32; 4]) -> Quat {
        Quat::from_array(seed).normalize()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn a_rigid_motion_moves_all_tissue_rigidly(
            turn in prop::array::uniform4(-1.0f32..1.0), shift in prop::array::uniform3(-0.1f32..0.1),
        ) {
            prop_assume!(Vec3::from_slice(&turn).length() > 0.1);
            let (turn, shift) = (unit(turn), Vec3::from(shift));
            let (rest, links) = block(4);
            for follow in [Follow::Turn, Follow::Deform] {
                let mut motions = Motions::of(rest.clone(), links.iter().copied(), follow);
                let now = states(rest.iter().map(|&c| turn * c + shift));
                // The first frame may need more iterations than one update makes; the next update
                // continues.
                for _ in 0..4 { motions.update(&now); }
                for (motion, &c) in motions.now().iter().zip(&rest) {
                    let skin = c + Vec3::new(0.004, -0.003, 0.006);
                    let off = moved(motion, skin).distance(turn * skin + shift);
                    prop_assert!(off < 2e-5, "{follow:?}: {off} m");
                }
            }
        }

        #[test]
        fn deform_is_exact_under_an_affine_motion(
            stretch in prop::array::uniform9(-0.19f32..0.19),
        ) {
            let f = Mat3::IDENTITY + Mat3::from_cols_array(&stretch);
            let (rest, links) = block(4);
            let mut motions = Motions::of(rest.clone(), links.into_iter(), Follow::Deform);
            motions.update(&states(rest.iter().map(|&c| f * c)));
            for (motion, &c) in motions.now().iter().zip(&rest) {
                let skin = c + Vec3::new(0.004, -0.003, 0.006);
                let off = moved(motion, skin).distance(f * skin);
                // The prior makes the stretch some hundredths too small. The point is 8 mm away
                // from the sphere.
                prop_assert!(off < 4e-4, "{off} m");
            }
        }

        #[test]
        fn motions_stay_finite_on_any_input(
            seed in 0u32..1000, size in 0.0f32..0.2, collapsed: bool,
        ) {
            let (rest, links) = block(3);
            let mut motions = Motions::of(rest.clone(), links.into_iter(), Follow::Deform);
            let noise = |i: usize, k: u32| ((i as u32 * 31 + k * 17 + seed) as f32 * 12.9898).sin();
            let now = states(rest.iter().enumerate().map(|(i, &c)| {
                let c = if collapsed { rest[0] } else { c };
                c + Vec3::new(noise(i, 0), noise(i, 1), noise(i, 2)) * size
            }));
            motions.update(&now);
            prop_assert!(motions.now().iter().flatten().flatten().all(|x| x.is_finite()));
        }
    }

    #[test]
    fn a_row_of_spheres_turns_as_a_whole() {
        let rest: Vec<Vec3> = (0..5).map(|i| Vec3::X * (i as f32 * 0.004)).collect();
        let links = (1..5).map(|i| [i - 1, i]);
        let mut motions = Motions::of(rest.clone(), links, Follow::Deform);
        let quarter = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
        for step in 1..=16 {
            let turn = Quat::IDENTITY.slerp(quarter, step as f32 / 16.0);
            motions.update(&states(rest.iter().map(|&c| turn * c)));
        }
        for (motion, &c) in motions.now().iter().zip(&rest) {
            // The point lies off the row, in a direction without neighbours.
            let skin = c + Vec3::new(0.0, 0.0015, 0.0);
            let off = moved(motion, skin).distance(quarter * skin);
            assert!(off < 1e-4, "{off} m");
        }
    }

    #[test]
    fn a_sphere_without_neighbours_follows_its_centre() {
        let mut motions = Motions::of(vec![Vec3::ONE], core::iter::empty(), Follow::Deform);
        motions.update(&states([Vec3::ONE * 1.5].into_iter()));
        assert!(moved(&motions.now()[0], Vec3::ZERO).distance(Vec3::splat(0.5)) < 1e-6);
    }

    /// The free half of a tube goes round and round, and comes back. Rotations that follow only
    /// each sphere's own bends would keep a twist for every round.
    #[test]
    fn a_tube_that_was_stirred_is_not_twisted() {
        let count = 12;
        let rest: Vec<Vec3> = (0..count).map(|i| Vec3::X * (i as f32 * 0.005)).collect();
        let links = (0..count as u32).flat_map(|i| [[i, i + 1], [i, i + 2]]);
        let links = links.filter(|link| link[1] < count as u32);
        let mut motions = Motions::of(rest.clone(), links, Follow::Deform);
        let mut lean = |angle: f32, tilt: f32| {
            let way = Vec3::new(
                tilt.cos(),
                tilt.sin() * angle.cos(),
                tilt.sin() * angle.sin(),
            );
            let bent = |p: &Vec3| {
                let past_m = (p.x - 0.03).max(0.0);
                Vec3::X * p.x.min(0.03) + way * past_m
            };
            let state = |p: &Vec3| SphereState {
                center_m: bent(p).to_array(),
                bits: 0,
            };
            let spheres: Vec<SphereState> = rest.iter().map(state).collect();
            motions.update(&spheres);
            motions.turns.clone()
        };
        for step in 0..400 {
            let round = step as f32 / 40.0 * std::f32::consts::TAU;
            lean(round, 1.0);
        }
        let turns = lean(0.0, 0.0);
        for pair in turns.windows(2) {
            let twist = pair[0].angle_between(pair[1]);
            assert!(twist < 0.2, "{twist} rad between neighbours");
        }
    }
}
