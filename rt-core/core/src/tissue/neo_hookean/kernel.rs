//! One pass over the tetrahedra of an organ, eight at a time.
//!
//! Cost: a tetrahedron takes about 430 additions and multiplications and three divisions; one
//! instruction serves eight tetrahedra. In order, a tetrahedron reads 72 bytes of constants (its
//! record and its mobility), and reads and writes 40 bytes of memory (volume and stress in
//! `BatchMemory`). Per corner it gathers 32 bytes from nodes in the second-level cache, and
//! scatters 16. The instruction rate of the core limits the kernel, not memory. To count the
//! instructions:
//!
//! ```text
//! cargo build --release -p rt-core --example cost
//! valgrind --tool=callgrind target/release/examples/cost liver 10   # and 110: difference / 100
//! ```

use crate::scene::{LANES, TetraBatch};
use crate::tissue::Node;
use crate::tissue::neo_hookean::wide::{Plain, Wide};
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::warm_start::BatchMemory;

/// Squared norm of the cofactor matrix (3 at rest) below which a tetrahedron counts as crushed to a
/// line or a point. Its volume constraint then has no gradient that would open it.
const CRUSHED: f32 = 0.2;
/// Largest addition to the diagonal of `F` of a crushed tetrahedron, which makes it appear more
/// open than it is.
const OPENING_MAX: f32 = 0.5;

/// Largest share by which the corners of an inverted tetrahedron are drawn towards their mean
/// displacement in a pass. 0.1 leaves knots in a scrambled liver (`scrambled_it_comes_back`); 0.8
/// shakes a liver that was pulled to five times its length.
const CONTRACTION_MAX: f32 = 0.4;

/// An organ's elasticity for one substep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moduli {
    /// `μ dt²`, N s²/m².
    pub(super) shear: f32,
    /// `μ/λ`, with `λ = λ₀ + μ`.
    pub(super) shear_over_bulk: f32,
    /// `γ = 1 + μ/λ`: with it, the stress of an undeformed tetrahedron is zero.
    pub(super) rest_volume: f32,
    /// Retardation time over dt: weight of the strain rate relative to the strain.
    pub(super) rate: f32,
    /// Share of the last impulses that the prediction contains.
    pub(super) kept_share: f32,
}

/// Projects every batch in order, in AVX registers if the processor has them, else in plain arrays.
pub(super) fn project(
    nodes: &mut PerSphere<Node>,
    batches: &[TetraBatch],
    last: &mut [BatchMemory],
    moduli: &Moduli,
) {
    #[cfg(target_arch = "x86_64")]
    if has_avx::get() {
        #[allow(unsafe_code)] // as in `wide::avx` and `math::sqrt`
        // SAFETY: `has_avx` has just found AVX on this processor.
        return unsafe { project_avx(nodes, batches, last, moduli) };
    }
    project_plain(nodes, batches, last, moduli);
}

#[cfg(target_arch = "x86_64")]
cpufeatures::new!(has_avx, "avx");

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx")]
pub(super) fn project_avx(
    nodes: &mut PerSphere<Node>,
    batches: &[TetraBatch],
    last: &mut [BatchMemory],
    moduli: &Moduli,
) {
    for (batch, last) in batches.iter().zip(last) {
        project_batch::<super::wide::Avx>(nodes, batch, last, moduli);
    }
}

/// Projects every batch with plain arrays: the reference for the vector version.
pub(super) fn project_plain(
    nodes: &mut PerSphere<Node>,
    batches: &[TetraBatch],
    last: &mut [BatchMemory],
    moduli: &Moduli,
) {
    for (batch, last) in batches.iter().zip(last) {
        project_batch::<Plain>(nodes, batch, last, moduli);
    }
}

type Vec3<W> = [W; 3];
/// By rows.
type Matrix<W> = [Vec3<W>; 3];
/// Entries xx, yy, zz, xy, xz, yz.
type Symmetric<W> = [W; 6];

/// The stable neo-Hookean energy `V (μ/2 F:F + λ/2 (det F − γ)²)` (Smith 2018) of each tetrahedron,
/// solved by XPBD (Macklin 2016; Macklin and Müller 2021) from its last impulse. `F = I + Σ e bᵀ`,
/// with `e` the displacements of the edges and `b` the shape gradients, contains the kept share of
/// that impulse, `P'`. A stress `μ P` moves each corner by `w μ dt² V P b`, and so changes `F` by
/// `P M`:
///
/// ```text
/// M = μ dt² V Σ w b bᵀ          mobility, over the four corners
/// F₀ = F − P' M                 without the last impulse
/// F⁺ = F₀ + P M                 after this projection
/// P = p cof F − F⁺ − s (F⁺ − F)
/// p = −λ/μ (J⁺ − γ + r (J⁺ − J'))         J⁺ = det F + cof F : (F⁺ − F)
/// ```
///
/// At rest `F⁺ = F`, so `−μ P` is the first Piola–Kirchhoff stress of the energy, not of its
/// linearisation. Solved for `P`, with `B = (1 + (1 + s) M)⁻¹`:
///
/// ```text
/// Y = (F − (1 + s) P' M) B      Z = cof F B      P = p Z − Y
/// J⁺ = det F + (cof F : (Y − F) + p (cof F : (cof F − Z))) / (1 + s)
/// ```
///
/// `s` resists the change of `F` in this projection, and has no effect at rest. It is needed
/// because the direction `cof F` of the pressure changes with `F`, by at most `|p|` times that
/// change. So `s` is the size of the pressure `p` at `F`, and at least 1, its size without load.
/// `r` is the retardation time divided by dt, and `J'` is `J⁺` of the last substep.
///
/// There are no closures here, because a closure that is not inlined would be compiled without AVX.
#[inline(always)]
fn project_batch<W: Wide>(
    nodes: &mut PerSphere<Node>,
    batch: &TetraBatch,
    last: &mut BatchMemory,
    moduli: &Moduli,
) {
    let [s0, s1, s2, s3] = &batch.spheres;
    let origin = gather::<W>(nodes, s0);
    let (x, y, z) = (
        gather::<W>(nodes, s1),
        gather::<W>(nodes, s2),
        gather::<W>(nodes, s3),
    );
    let weights = [origin.weight, x.weight, y.weight, z.weight];
    let edges = [
        sub(x.moved, origin.moved),
        sub(y.moved, origin.moved),
        sub(z.moved, origin.moved),
    ];
    let [b1, b2, b3] = &batch.gradients_per_m;
    let b = [load(b1), load(b2), load(b3)];
    let f = deformation(&edges, &b);
    let (volume, cofactor) = volume_and_cofactor(&f);
    let old = scale_all(&load_all(&last.stress), W::splat(moduli.kept_share));
    let new = stress(&f, volume, &cofactor, &old, last, moduli);
    last.stress = [store(new[0]), store(new[1]), store(new[2])];

    let shear = W::load(&batch.volume_m3).mul(W::splat(moduli.shear));
    let change = scale_all(&sub_all(&new, &old), shear);
    let impulses = [
        times(&change, b[0]),
        times(&change, b[1]),
        times(&change, b[2]),
    ];
    scatter(
        nodes,
        s0,
        scale(sum(&impulses), W::splat(0.0).sub(weights[0])),
    );
    scatter(nodes, s1, scale(impulses[0], weights[1]));
    scatter(nodes, s2, scale(impulses[1], weights[2]));
    scatter(nodes, s3, scale(impulses[2], weights[3]));
    if volume.any_below(W::splat(0.0)) {
        let [d0, d1, d2, d3] = contraction(&edges, &weights, volume);
        shift(nodes, s0, d0);
        shift(nodes, s1, d1);
        shift(nodes, s2, d2);
        shift(nodes, s3, d3);
    }
}

/// `P` of this projection. Keeps `J⁺` for the next substep.
#[inline(always)]
fn stress<W: Wide>(
    f: &Matrix<W>,
    volume: W,
    cofactor: &Matrix<W>,
    old: &Matrix<W>,
    last: &mut BatchMemory,
    moduli: &Moduli,
) -> Matrix<W> {
    let (zero, one) = (W::splat(0.0), W::splat(1.0));
    let pressure = volume
        .sub(W::splat(moduli.rest_volume))
        .mul(W::splat(moduli.shear_over_bulk.recip()));
    let s = pressure.max(zero.sub(pressure)).max(one);
    let s_and_one = s.add(one);
    let inverse_s_and_one = one.div(s_and_one);
    let scaled = mobility(last, s_and_one.mul(W::splat(moduli.shear)));
    let inverse = inverse_of_one_plus(&scaled);

    let y = sub_all(f, &times_symmetric(old, &scaled));
    let y = times_symmetric(&y, &inverse);
    let z = times_symmetric(cofactor, &inverse);
    let before = volume.add(inner(cofactor, &sub_all(&y, f)).mul(inverse_s_and_one));
    let volume_per_pressure = inner(cofactor, &sub_all(cofactor, &z)).mul(inverse_s_and_one);

    let rate = W::splat(moduli.rate);
    let error = before
        .sub(W::splat(moduli.rest_volume))
        .add(before.sub(W::load(&last.volume)).mul(rate));
    let denominator = volume_per_pressure
        .mul(rate.add(one))
        .add(W::splat(moduli.shear_over_bulk));
    let p = zero.sub(error.div(denominator));
    last.volume = before.add(volume_per_pressure.mul(p)).store();
    sub_all(&scale_all(&z, p), &y)
}

/// Displacements that contract an inverted tetrahedron without moving its centre of mass.
/// Elasticity alone can turn an inverted tetrahedron back in ways that wind tissue into knots, and
/// a knot is an equilibrium. Contraction takes the corners out of the knot.
#[inline(always)]
fn contraction<W: Wide>(edges: &[Vec3<W>; 3], weights: &[W; 4], volume: W) -> [Vec3<W>; 4] {
    let zero = W::splat(0.0);
    let inversion = zero.sub(volume).max(zero);
    // The minimum of two, as the negative of the maximum of their negatives.
    let share = zero.sub(
        zero.sub(inversion.mul(W::splat(10.0)))
            .max(W::splat(-CONTRACTION_MAX)),
    );
    let [w0, w1, w2, w3] = *weights;
    let lightest = w0.max(w1).max(w2).max(w3).max(W::splat(1.0e-6));
    let per_weight = share.div(lightest);
    let mean = scale(sum(edges), W::splat(0.25));
    [
        scale(mean, per_weight.mul(w0)),
        scale(sub(mean, edges[0]), per_weight.mul(w1)),
        scale(sub(mean, edges[1]), per_weight.mul(w2)),
        scale(sub(mean, edges[2]), per_weight.mul(w3)),
    ]
}

/// One corner of eight tetrahedra.
struct Corner<W> {
    /// Displacement from rest as corrected so far.
    moved: Vec3<W>,
    weight: W,
}

#[inline(always)]
fn gather<W: Wide>(nodes: &PerSphere<Node>, spheres: &[u16; LANES]) -> Corner<W> {
    let [a, b, c, d, e, f, g, h] = *spheres;
    let [a, b, c, d] = [at(nodes, a), at(nodes, b), at(nodes, c), at(nodes, d)];
    let [e, f, g, h] = [at(nodes, e), at(nodes, f), at(nodes, g), at(nodes, h)];
    // The steps have zero in the spare lane, so the sum keeps the weight there.
    let rows = [
        a.moved_m + a.step_m,
        b.moved_m + b.step_m,
        c.moved_m + c.step_m,
        d.moved_m + d.step_m,
        e.moved_m + e.step_m,
        f.moved_m + f.step_m,
        g.moved_m + g.step_m,
        h.moved_m + h.step_m,
    ];
    let [mx, my, mz, weight] = W::columns(rows.each_ref());
    Corner {
        moved: [mx, my, mz],
        weight,
    }
}

#[inline(always)]
fn at(nodes: &PerSphere<Node>, sphere: u16) -> &Node {
    nodes.at(u32::from(sphere))
}

#[inline(always)]
fn scatter<W: Wide>(nodes: &mut PerSphere<Node>, spheres: &[u16; LANES], push: Vec3<W>) {
    let rows = W::rows(push);
    for lane in 0..LANES {
        let node = nodes.at_mut(u32::from(spheres[lane]));
        node.step_m = node.step_m + rows[lane];
    }
}

#[inline(always)]
fn load<W: Wide>([x, y, z]: &[[f32; LANES]; 3]) -> Vec3<W> {
    [W::load(x), W::load(y), W::load(z)]
}

/// Moves corners without giving them a velocity.
#[inline(always)]
fn shift<W: Wide>(nodes: &mut PerSphere<Node>, spheres: &[u16; LANES], by: Vec3<W>) {
    let rows = W::rows(by);
    for lane in 0..LANES {
        let node = nodes.at_mut(u32::from(spheres[lane]));
        node.moved_m = node.moved_m + rows[lane];
    }
}

/// `V Σ w b bᵀ`, times `by`.
#[inline(always)]
fn mobility<W: Wide>(memory: &BatchMemory, by: W) -> Symmetric<W> {
    let [xx, yy, zz, xy, xz, yz] = &memory.mobility_m_kg;
    scale_symmetric(
        &[
            W::load(xx),
            W::load(yy),
            W::load(zz),
            W::load(xy),
            W::load(xz),
            W::load(yz),
        ],
        by,
    )
}

/// `(1 + m)⁻¹` of a matrix without negative eigenvalues.
#[inline(always)]
fn inverse_of_one_plus<W: Wide>(m: &Symmetric<W>) -> Symmetric<W> {
    let one = W::splat(1.0);
    let [xx, yy, zz] = [m[0].add(one), m[1].add(one), m[2].add(one)];
    let [_, _, _, xy, xz, yz] = *m;
    let minors = [
        yy.mul(zz).sub(yz.mul(yz)),
        xx.mul(zz).sub(xz.mul(xz)),
        xx.mul(yy).sub(xy.mul(xy)),
        xz.mul(yz).sub(xy.mul(zz)),
        xy.mul(yz).sub(xz.mul(yy)),
        xy.mul(xz).sub(xx.mul(yz)),
    ];
    let first_row = xx.mul(minors[0]).add(xy.mul(minors[3]));
    scale_symmetric(&minors, one.div(first_row.add(xz.mul(minors[4]))))
}

#[inline(always)]
fn scale_symmetric<W: Wide>(m: &Symmetric<W>, by: W) -> Symmetric<W> {
    let [xx, yy, zz, xy, xz, yz] = *m;
    [
        xx.mul(by),
        yy.mul(by),
        zz.mul(by),
        xy.mul(by),
        xz.mul(by),
        yz.mul(by),
    ]
}

/// Matrix, by rows, times a symmetric matrix.
#[inline(always)]
fn times_symmetric<W: Wide>(m: &Matrix<W>, s: &Symmetric<W>) -> Matrix<W> {
    let [xx, yy, zz, xy, xz, yz] = *s;
    let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    [times(&rows, m[0]), times(&rows, m[1]), times(&rows, m[2])]
}

#[inline(always)]
fn load_all<W: Wide>([x, y, z]: &[[[f32; LANES]; 3]; 3]) -> Matrix<W> {
    [load(x), load(y), load(z)]
}

#[inline(always)]
fn store<W: Wide>([x, y, z]: Vec3<W>) -> [[f32; LANES]; 3] {
    [x.store(), y.store(), z.store()]
}

/// `F = I + Σ e_a b_aᵀ`, by rows.
#[inline(always)]
fn deformation<W: Wide>(edges: &[Vec3<W>; 3], gradients: &[Vec3<W>; 3]) -> [Vec3<W>; 3] {
    let one = W::splat(1.0);
    let [mut x, mut y, mut z] = [
        row(edges, gradients, 0),
        row(edges, gradients, 1),
        row(edges, gradients, 2),
    ];
    x[0] = x[0].add(one);
    y[1] = y[1].add(one);
    z[2] = z[2].add(one);
    [x, y, z]
}

#[inline(always)]
fn row<W: Wide>(edges: &[Vec3<W>; 3], gradients: &[Vec3<W>; 3], i: usize) -> Vec3<W> {
    let first = scale(gradients[0], edges[0][i]);
    let second = add(first, scale(gradients[1], edges[1][i]));
    add(second, scale(gradients[2], edges[2][i]))
}

/// `det F` and the cofactor matrix, by rows. A crushed tetrahedron gets the values of a matrix that
/// is a little more open in every direction, so that its volume constraint opens it.
#[inline(always)]
fn volume_and_cofactor<W: Wide>(f: &[Vec3<W>; 3]) -> (W, [Vec3<W>; 3]) {
    let closed = cofactor(f);
    let size = norm_squared(&closed);
    if !size.any_below(W::splat(CRUSHED)) {
        return (dot(f[0], closed[0]), closed);
    }
    let open = W::splat(OPENING_MAX).sub(size.mul(W::splat(OPENING_MAX / CRUSHED)));
    let open = open.max(W::splat(0.0));
    let opened = [
        [f[0][0].add(open), f[0][1], f[0][2]],
        [f[1][0], f[1][1].add(open), f[1][2]],
        [f[2][0], f[2][1], f[2][2].add(open)],
    ];
    let cofactor = cofactor(&opened);
    (dot(opened[0], cofactor[0]), cofactor)
}

#[inline(always)]
fn cofactor<W: Wide>(f: &[Vec3<W>; 3]) -> [Vec3<W>; 3] {
    [cross(f[1], f[2]), cross(f[2], f[0]), cross(f[0], f[1])]
}

#[inline(always)]
fn norm_squared<W: Wide>(m: &[Vec3<W>; 3]) -> W {
    dot(m[0], m[0]).add(dot(m[1], m[1])).add(dot(m[2], m[2]))
}

#[inline(always)]
fn add<W: Wide>(a: Vec3<W>, b: Vec3<W>) -> Vec3<W> {
    [a[0].add(b[0]), a[1].add(b[1]), a[2].add(b[2])]
}

#[inline(always)]
fn sub<W: Wide>(a: Vec3<W>, b: Vec3<W>) -> Vec3<W> {
    [a[0].sub(b[0]), a[1].sub(b[1]), a[2].sub(b[2])]
}

#[inline(always)]
fn scale<W: Wide>(a: Vec3<W>, by: W) -> Vec3<W> {
    [a[0].mul(by), a[1].mul(by), a[2].mul(by)]
}

#[inline(always)]
fn scale_all<W: Wide>(m: &Matrix<W>, by: W) -> Matrix<W> {
    [scale(m[0], by), scale(m[1], by), scale(m[2], by)]
}

#[inline(always)]
fn sub_all<W: Wide>(a: &Matrix<W>, b: &Matrix<W>) -> Matrix<W> {
    [sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2])]
}

/// `a : b`.
#[inline(always)]
fn inner<W: Wide>(a: &Matrix<W>, b: &Matrix<W>) -> W {
    dot(a[0], b[0]).add(dot(a[1], b[1])).add(dot(a[2], b[2]))
}

#[inline(always)]
fn sum<W: Wide>(a: &[Vec3<W>; 3]) -> Vec3<W> {
    add(add(a[0], a[1]), a[2])
}

#[inline(always)]
fn dot<W: Wide>(a: Vec3<W>, b: Vec3<W>) -> W {
    a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
}

#[inline(always)]
fn cross<W: Wide>(a: Vec3<W>, b: Vec3<W>) -> Vec3<W> {
    [
        a[1].mul(b[2]).sub(a[2].mul(b[1])),
        a[2].mul(b[0]).sub(a[0].mul(b[2])),
        a[0].mul(b[1]).sub(a[1].mul(b[0])),
    ]
}

/// Matrix, by rows, times vector.
#[inline(always)]
fn times<W: Wide>(m: &[Vec3<W>; 3], v: Vec3<W>) -> Vec3<W> {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}
