//! One pass over the tetrahedra of an organ, eight at a time.
//!
//! Cost: a tetrahedron takes about 450 additions and multiplications, three divisions and one root,
//! eight to an instruction. It reads 48 bytes of its own in order, and per corner gathers 32 bytes
//! and scatters 16, from nodes that stay in the second-level cache. A tick of the liver (2426
//! tetrahedra) takes 425 000 instructions in all: 175 a tetrahedron, of which 56 are the arithmetic
//! and the rest loads, transpositions and stores of corners. At 14 ns a tetrahedron (quiet machine,
//! about 3 GHz) that is four instructions a cycle. So the kernel is bound by the rate at which a
//! core issues instructions, not by memory (3.4 GB/s of its own data); arithmetic alone would be
//! twice as fast. To count again:
//!
//! ```text
//! cargo build --release -p rt-core --example cost
//! valgrind --tool=callgrind target/release/examples/cost liver 10   # and 110: difference / 100
//! ```

use crate::scene::{LANES, TetraBatch};
use crate::tissue::Node;
use crate::tissue::neo_hookean::wide::{Plain, Wide};
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::viscosity::BatchStrain;

/// Squared norm of the cofactor matrix (3 at rest) below which a tetrahedron counts as crushed to a
/// line or a point. Its volume constraint has no gradient there that leads out.
const CRUSHED: f32 = 0.2;
/// Share by which a crushed tetrahedron is treated as more open than it is.
const OPENING: f32 = 0.5;

/// Share by which the corners of an inverted tetrahedron are drawn towards their mean displacement
/// in a pass. 0.01 to 0.4 all untie a scrambled liver.
const DRAWN_MAX: f32 = 0.1;

/// An organ's elasticity for one substep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moduli {
    /// `1 / (λ dt²)` with `λ = λ₀ + μ`: compliance of the volume constraint times volume.
    pub(super) hydrostatic: f32,
    /// `1 / (μ dt²)`: that of the shape constraint.
    pub(super) deviatoric: f32,
    /// `γ = 1 + μ/λ`: the determinant at which both balance at rest.
    pub(super) rest_volume: f32,
    /// Retardation time over dt: weight of the strain rate relative to the strain.
    pub(super) rate: f32,
}

/// Projects every batch in order, with the widest registers that this processor has.
pub(super) fn project(
    nodes: &mut PerSphere<Node>,
    batches: &[TetraBatch],
    last: &mut [BatchStrain],
    moduli: &Moduli,
) {
    #[cfg(target_arch = "x86_64")]
    if has_avx::get() {
        #[allow(unsafe_code)] // the other named place is `wide::avx`
        // SAFETY: the processor has just said that it has AVX.
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
    last: &mut [BatchStrain],
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
    last: &mut [BatchStrain],
    moduli: &Moduli,
) {
    for (batch, last) in batches.iter().zip(last) {
        project_batch::<Plain>(nodes, batch, last, moduli);
    }
}

type Vec3<W> = [W; 3];

/// XPBD (Macklin 2016) of the stable neo-Hookean energy (Smith 2018; Macklin and Müller 2021). The
/// volume `det F − γ` and the shape `√(F:F)` of a tetrahedron are solved together, in one pass from
/// zero multipliers. With `F = I + Σ e_a b_aᵀ`, `e` the displacements of the edges and `b` the
/// shape gradients:
///
/// ```text
/// g_a = cof(F) b_a       h_a = F b_a / √(F:F)       (corner 0: minus the sum)
/// m11 = (1+r) Σ w|g|² + 1/(λ V dt²)   m12 = (1+r) Σ w g·h   m22 = (1+r) Σ w|h|² + 1/(μ V dt²)
/// m · (p, q) = −(C + r (C − C'))      d_a += w_a (p g_a + q h_a)
/// ```
///
/// `r` is the retardation time over dt. `C'` is what `C` was after its projection in the last
/// substep ([`crate::tissue::viscosity`]).
///
/// No closure here: one that is not inlined would be compiled without the wide registers.
#[inline(always)]
fn project_batch<W: Wide>(
    nodes: &mut PerSphere<Node>,
    batch: &TetraBatch,
    last: &mut BatchStrain,
    moduli: &Moduli,
) {
    let [s0, s1, s2, s3] = &batch.spheres;
    let origin = gather::<W>(nodes, s0);
    let (x, y, z) = (
        gather::<W>(nodes, s1),
        gather::<W>(nodes, s2),
        gather::<W>(nodes, s3),
    );
    let edges = [
        sub(x.moved, origin.moved),
        sub(y.moved, origin.moved),
        sub(z.moved, origin.moved),
    ];
    let [b1, b2, b3] = &batch.gradients_per_m;
    let b = [load(b1), load(b2), load(b3)];

    let f = deformation(&edges, &b);
    let (volume, cofactor) = volume_and_cofactor(&f);
    let shape = norm_squared(&f).sqrt().max(W::splat(1.0e-6));
    let per_shape = W::splat(1.0).div(shape);

    let g = [
        times(&cofactor, b[0]),
        times(&cofactor, b[1]),
        times(&cofactor, b[2]),
    ];
    let h = [
        scale(times(&f, b[0]), per_shape),
        scale(times(&f, b[1]), per_shape),
        scale(times(&f, b[2]), per_shape),
    ];
    let (g0, h0) = (sum(&g), sum(&h));

    let weights = [origin.weight, x.weight, y.weight, z.weight];
    let rate = W::splat(moduli.rate);
    let one_and_rate = W::splat(1.0 + moduli.rate);
    let inverse_volume = W::load(&batch.inverse_volume_per_m3);
    let soft11 = inverse_volume.mul(W::splat(moduli.hydrostatic));
    let soft22 = inverse_volume.mul(W::splat(moduli.deviatoric));
    let free11 = weighted(&weights, dot(g0, g0), &g, &g);
    let free12 = weighted(&weights, dot(g0, h0), &g, &h);
    let free22 = weighted(&weights, dot(h0, h0), &h, &h);
    let m11 = free11.mul(one_and_rate).add(soft11);
    let m12 = free12.mul(one_and_rate);
    let m22 = free22.mul(one_and_rate).add(soft22);

    let c1 = volume
        .sub(W::splat(moduli.rest_volume))
        .add(volume.sub(W::load(&last.volume)).mul(rate));
    let c2 = shape.add(shape.sub(W::load(&last.shape)).mul(rate));

    // Eliminates the second row: the product of both diagonals would overflow for tiny masses.
    let share = m12.div(m22);
    let pivot = m11.sub(share.mul(m12)).max(soft11);
    let p = share.mul(c2).sub(c1).div(pivot);
    let q = W::splat(0.0).sub(c2.add(m12.mul(p)).div(m22));
    last.volume = volume.add(free11.mul(p)).add(free12.mul(q)).store();
    last.shape = shape.add(free12.mul(p)).add(free22.mul(q)).store();

    let minus = W::splat(0.0).sub(origin.weight);
    let mut pushes = [
        push(g0, h0, p, q, minus),
        push(g[0], h[0], p, q, x.weight),
        push(g[1], h[1], p, q, y.weight),
        push(g[2], h[2], p, q, z.weight),
    ];
    if volume.any_below(W::splat(0.0)) {
        let drawn = drawn_together(&edges, &weights, volume);
        for (push, drawn) in pushes.iter_mut().zip(drawn) {
            *push = add(*push, drawn);
        }
    }
    let [p0, p1, p2, p3] = pushes;
    scatter(nodes, s0, p0);
    scatter(nodes, s1, p1);
    scatter(nodes, s2, p2);
    scatter(nodes, s3, p3);
}

/// Draws the displacements of an inverted tetrahedron's corners together, without moving their
/// common centre of mass. Elasticity alone leaves an inverted tetrahedron by ways that wind tissue
/// around itself, and such a knot is an equilibrium. The mean of the neighbours' displacements is
/// not.
#[inline(always)]
fn drawn_together<W: Wide>(edges: &[Vec3<W>; 3], weights: &[W; 4], volume: W) -> [Vec3<W>; 4] {
    let zero = W::splat(0.0);
    let inside_out = zero.sub(volume).max(zero);
    // The smaller of two, as the negative of the larger of their negatives.
    let share = zero.sub(
        zero.sub(inside_out.mul(W::splat(10.0)))
            .max(W::splat(-DRAWN_MAX)),
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
    // The steps have a zero in the lane of the weight.
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

/// `Σ w a·b` over the corners; `at_origin` is `a·b` of the first.
#[inline(always)]
fn weighted<W: Wide>(w: &[W; 4], at_origin: W, a: &[Vec3<W>; 3], b: &[Vec3<W>; 3]) -> W {
    let first = w[0].mul(at_origin).add(w[1].mul(dot(a[0], b[0])));
    first
        .add(w[2].mul(dot(a[1], b[1])))
        .add(w[3].mul(dot(a[2], b[2])))
}

#[inline(always)]
fn push<W: Wide>(g: Vec3<W>, h: Vec3<W>, p: W, q: W, weight: W) -> Vec3<W> {
    scale(add(scale(g, p), scale(h, q)), weight)
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

/// `det F` and the cofactor matrix, by rows. A crushed tetrahedron gets those of a matrix that is a
/// little more open in every direction: they lead out.
#[inline(always)]
fn volume_and_cofactor<W: Wide>(f: &[Vec3<W>; 3]) -> (W, [Vec3<W>; 3]) {
    let closed = cofactor(f);
    let size = norm_squared(&closed);
    if !size.any_below(W::splat(CRUSHED)) {
        return (dot(f[0], closed[0]), closed);
    }
    let open = W::splat(OPENING).sub(size.mul(W::splat(OPENING / CRUSHED)));
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
