//! Makes a closed surface, oriented outward, from the triangles of a mesh file.

use std::collections::{HashMap, HashSet};
use std::fmt;

use super::pieces::{gaps, piece_meshes, pieces};
use super::weld::{Welded, weld};
use super::{Mesh, close, sides, touch, wrap};
use crate::Vec3;
use crate::error::MeshProblem;
use crate::field::{Grid, overlap};
use crate::recipe::Closing;

/// Smallest extent of an organ, m.
const EXTENT_MIN_M: f64 = 0.002;
/// Largest extent of an organ, m.
const EXTENT_MAX_M: f64 = 2.0;
/// Vertices that are at most this share of the mesh's extent apart become one.
const WELD_SHARE: f64 = 1e-6;
/// Least volume over area^1.5. A ball has 0.094, a sheet of paper 1e-5.
const VOLUME_SHARE_MIN: f64 = 2e-5;
/// Pieces with less than this share of the largest piece's volume are dust.
const DUST_SHARE: f64 = 1e-3;
/// If inner pieces together have at least this share of the organ's volume, they are a cavity, and
/// a warning says that it was filled. Otherwise they are specks of a segmentation.
const CAVITY_SHARE: f64 = 0.05;
/// Pieces whose volumes differ by less than this share count as equally large. Single precision and
/// the order of a sum change a volume by less.
const EQUAL_SHARE: f64 = 1e-5;
/// Largest number of vertices of a piece that are tested for lying inside another piece.
const LOOKED_AT: usize = 64;
/// Largest number of pieces larger than dust. Each is tested against all larger pieces.
const PIECES_MAX: usize = 256;

/// A mesh is thin, and may be hollow, if twice its volume over its area is below this share of its
/// extent.
const THIN_SHARE: f64 = 0.05;
/// A thin mesh is hollow if its outer surface encloses more than this many times the mesh's volume.
const HOLLOW_GAIN: f64 = 1.6;
/// A thin mesh is also hollow if its volume is more than this many times the volume in its outer
/// surface, because walls inside walls count twice.
const TWICE_SHARE: f64 = 1.3;

/// A surface overlaps itself if it encloses more than this share of its volume twice.
const OVERLAP_SHARE: f64 = 0.02;
/// Lids larger than this share of an open surface's area suggest that the surface is a sheet, not a
/// body with holes. The lid of half a ball has 0.5 of its area, the lid of a flat sheet 1.
const LID_SHARE_MAX: f64 = 0.6;
/// Number of grid cells along the mesh's longest side when the overlap is measured.
const OVERLAP_LINES: f64 = 120.0;

/// A mended mesh and its repairs.
#[derive(Debug, Clone, PartialEq)]
pub struct Mended {
    /// The closed surface, oriented outward.
    pub mesh: Mesh,
    /// Volume inside the surface, m³.
    pub volume_m3: f64,
    welded: Welded,
    turned: bool,
    patched_loops: usize,
    wrapped: bool,
    hollow: bool,
    merged: bool,
    parted_edges: usize,
    inner: Vec<Inner>,
    tiny: Dropped,
    unwanted: Dropped,
}

/// A piece that was dropped because it lay inside another piece.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Inner {
    /// One of its vertices.
    at: Vec3,
    volume_m3: f64,
}

/// Pieces that were dropped for one reason.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Dropped {
    count: usize,
    volume_m3: f64,
    largest_m3: f64,
}

impl Dropped {
    fn add(&mut self, volume_m3: f64) {
        self.count += 1;
        self.volume_m3 += volume_m3;
        self.largest_m3 = self.largest_m3.max(volume_m3);
    }

    fn of(pieces: &[Inner]) -> Self {
        let mut all = Self::default();
        pieces.iter().for_each(|piece| all.add(piece.volume_m3));
        all
    }

    /// A note such as `70 tiny pieces dropped, 0.4 mL in all, the largest 0.020 mL`.
    fn note(&self, what: &str) -> Option<String> {
        let [all, largest] = [self.volume_m3, self.largest_m3].map(millilitres);
        match self.count {
            0 => None,
            1 => Some(format!("1 {what}piece of {all} dropped")),
            count => Some(format!(
                "{count} {what}pieces dropped, {all} in all, the largest {largest}"
            )),
        }
    }
}

/// A volume in mL, rounded to suit its size.
fn millilitres(volume_m3: f64) -> String {
    let ml = 1e6 * volume_m3;
    match ml {
        10.0.. => format!("{ml:.0} mL"),
        0.1.. => format!("{ml:.1} mL"),
        0.001.. => format!("{ml:.3} mL"),
        _ => "less than 0.001 mL".into(),
    }
}

impl Mended {
    /// Keeps only the largest of the separate pieces, and the notes about cavities inside that
    /// piece.
    #[must_use]
    pub fn largest_piece(mut self) -> Self {
        let all = piece_meshes(&self.mesh);
        if all.len() < 2 {
            return self;
        }
        let mut largest = 0;
        for (i, piece) in all.iter().enumerate() {
            if piece.volume() > (1.0 + EQUAL_SHARE) * all[largest].volume() {
                largest = i;
            }
        }
        for (i, piece) in all.into_iter().enumerate() {
            if i == largest {
                self.volume_m3 = piece.volume();
                self.mesh = piece;
            } else {
                self.unwanted.add(piece.volume().abs());
            }
        }
        let mesh = &self.mesh;
        self.inner
            .retain(|inner| wrap::winding(mesh, &inner.at) > 0.5);
        self
    }

    /// A sentence that says that the inside was filled, for a person who wanted a hollow organ.
    /// `None` if nothing but specks was filled.
    #[must_use]
    pub fn filled(&self) -> Option<String> {
        let inner_m3 = Dropped::of(&self.inner).volume_m3;
        let share = inner_m3 / self.volume_m3;
        if !self.hollow && share < CAVITY_SHARE {
            return None;
        }
        let by_itself = "it behaves like an organ that is full, not like an empty bag";
        Some(if self.hollow {
            format!(
                "its hollow inside is filled: {by_itself}; `closing = \"fill\"` (--closing) keeps the wall"
            )
        } else {
            let inside = millilitres(inner_m3);
            format!("the {inside} within its inner surface are filled: {by_itself}")
        })
    }

    /// Distance of each separate piece except the largest from the larger pieces, m. Empty for a
    /// surface in one piece.
    #[must_use]
    pub fn gaps_m(&self) -> Vec<f64> {
        gaps(&self.mesh)
    }
}

impl fmt::Display for Mended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = [
            (self.welded.merged, "vertices merged"),
            (self.welded.degenerate, "degenerate triangles dropped"),
            (self.welded.duplicate, "duplicate triangles dropped"),
            (
                self.parted_edges,
                "times an edge was split where bodies touched along it",
            ),
        ];
        let mended = [
            (usize::from(self.turned), "inside-out surface turned"),
            (self.patched_loops, "open loops closed"),
            (usize::from(self.hollow), "hollow made solid"),
            (usize::from(self.merged), "surface that overlaps itself"),
            (usize::from(self.wrapped), "new surface wrapped around it"),
        ];
        let note = |(count, what): &(usize, &str)| (*count > 0).then(|| format!("{count} {what}"));
        let mut notes: Vec<String> = counted.iter().filter_map(note).collect();
        notes.extend(Dropped::of(&self.inner).note("inner "));
        notes.extend(self.tiny.note("tiny "));
        notes.extend(self.unwanted.note("unwanted "));
        notes.extend(mended.iter().filter_map(note));
        if notes.is_empty() {
            notes.push("closed as it came".into());
        }
        write!(f, "{}", notes.join(", "))
    }
}

/// Mends a mesh: welds seams, drops degenerate triangles, orients every piece outward, closes or
/// wraps an open surface, and drops dust and inner pieces.
///
/// # Errors
/// When the mesh cannot be mended, or `closing` does not allow it. The error names the fault.
pub fn mend(mesh: &Mesh, closing: Closing) -> Result<Mended, MeshProblem> {
    mend_as(mesh, closing, true)
}

/// Mends the surface of a body as [`mend`] does, without the search for a hollow inside, which
/// takes long.
///
/// # Errors
/// Those of [`mend`].
pub(crate) fn mend_body(mesh: &Mesh, closing: Closing) -> Result<Mended, MeshProblem> {
    mend_as(mesh, closing, false)
}

fn mend_as(mesh: &Mesh, closing: Closing, may_be_hollow: bool) -> Result<Mended, MeshProblem> {
    check_numbers(mesh)?;
    let [min, max] = mesh.bounds();
    let extent_m = (max - min).max();
    let (mut mesh, welded) = weld(mesh, WELD_SHARE * extent_m);
    if mesh.triangles.is_empty() {
        return Err(MeshProblem::NoTriangles);
    }
    let mut mended = Mended {
        mesh: Mesh::default(),
        volume_m3: 0.0,
        welded,
        turned: false,
        patched_loops: 0,
        wrapped: false,
        hollow: false,
        merged: false,
        parted_edges: 0,
        inner: Vec::new(),
        tiny: Dropped::default(),
        unwanted: Dropped::default(),
    };
    if closing == Closing::Solid {
        let sealed = wrap::seal(&mesh).ok_or(MeshProblem::NoVolume { volume_ml: 0.0 })?;
        mended.wrapped = true;
        return finish(mended, sealed);
    }
    let mut many = edges_of_many_triangles(&mesh);
    if many > 0 {
        orient_consistently(&mut mesh)?;
        let parted = touch::part(&mut mesh);
        many = edges_of_many_triangles(&mesh);
        // An edge is not split if its bodies are also connected around both of its ends.
        if many == 0 {
            mended.parted_edges = parted;
        }
    }
    let mut wrapping = closing == Closing::Wrap;
    if many > 0 {
        if matches!(closing, Closing::Refuse | Closing::Fill) {
            return Err(MeshProblem::NonManifold { edges: many });
        }
        wrapping = true;
    }
    orient_consistently(&mut mesh)?;
    let loops = close::open_loops(&mesh);
    let mut lid_share = 0.0;
    if !wrapping && !loops.is_empty() {
        if closing == Closing::Refuse {
            let edges = loops.iter().map(Vec::len).sum();
            return Err(MeshProblem::Open {
                loops: loops.len(),
                edges,
            });
        }
        let sheet_m2 = mesh.area();
        close::fill(&mut mesh, &loops);
        lid_share = mesh.area() / sheet_m2 - 1.0;
        mended.patched_loops = loops.len();
        if !mesh.is_closed() {
            if closing == Closing::Fill {
                return Err(MeshProblem::NonManifold {
                    edges: edges_of_many_triangles(&mesh),
                });
            }
            wrapping = true;
            mended.patched_loops = 0;
        }
    }
    if wrapping {
        orient_pieces_outward(&mut mesh);
        mesh = wrap::wrap(&mesh).ok_or(MeshProblem::NoVolume { volume_ml: 0.0 })?;
        mended.wrapped = true;
    }
    let mut mended = finish(mended, mesh)?;
    let is_thin = is_thin(&mended);
    // A body with a hole lies on one side of the lid. A sheet lies close to its lid, or crosses it.
    let is_sheet = || closing == Closing::Auto && lid_share > LID_SHARE_MAX && !mended.wrapped;
    if is_sheet() && (is_thin || doubled(&mended.mesh).0 > OVERLAP_SHARE) {
        return Err(MeshProblem::Sheet {
            loops: loops.len(),
            percent: 100.0 * lid_share,
        });
    }
    if closing == Closing::Auto && is_thin && may_be_hollow {
        mended = solid_if_hollow(mended);
    }
    if mended.wrapped || mended.hollow {
        return Ok(mended);
    }
    once_only(mended, closing)
}

/// Share of its volume that a surface encloses more than once or inside out, and the place where it
/// does so most, m.
fn doubled(mesh: &Mesh) -> (f64, Vec3) {
    let [min, max] = mesh.bounds();
    let cell_m = (max - min).max() / OVERLAP_LINES;
    let found = overlap(mesh, &Grid::around([min, max], cell_m, 1));
    let share = found.doubled_m3 / found.enclosed_m3.max(f64::MIN_POSITIVE);
    (share, found.at)
}

/// If a surface overlaps itself, wraps it (`Closing::Auto`) or refuses it: its volume and inside
/// would be wrong.
fn once_only(mended: Mended, closing: Closing) -> Result<Mended, MeshProblem> {
    let (share, at) = doubled(&mended.mesh);
    if share <= OVERLAP_SHARE {
        return Ok(mended);
    }
    if closing != Closing::Auto {
        return Err(MeshProblem::Overlaps {
            percent: 100.0 * share,
            at_m: at.into(),
        });
    }
    let wrapped = wrap::wrap(&mended.mesh).ok_or(MeshProblem::NoVolume { volume_ml: 0.0 })?;
    let once = Mended {
        mesh: Mesh::default(),
        wrapped: true,
        merged: true,
        ..mended
    };
    finish(once, wrapped)
}

/// True if the mesh is thin: a wall, a sheet or a tube rather than a body.
fn is_thin(mended: &Mended) -> bool {
    let [min, max] = mended.mesh.bounds();
    2.0 * mended.volume_m3 / mended.mesh.area() < THIN_SHARE * (max - min).max()
}

/// The outer surface of a hollow organ. Any other mesh stays as it is.
fn solid_if_hollow(mended: Mended) -> Mended {
    let sealed = wrap::seal(&mended.mesh);
    let solid = sealed.and_then(|sealed| {
        let blank = Mended {
            mesh: Mesh::default(),
            volume_m3: 0.0,
            ..mended.clone()
        };
        finish(blank, sealed).ok()
    });
    match solid {
        // Walls inside walls count twice, so the volume can exceed that of the outer surface.
        Some(solid)
            if solid.volume_m3 > HOLLOW_GAIN * mended.volume_m3
                || mended.volume_m3 > TWICE_SHARE * solid.volume_m3 =>
        {
            Mended {
                hollow: true,
                ..solid
            }
        }
        _ => mended,
    }
}

fn finish(mut mended: Mended, mut mesh: Mesh) -> Result<Mended, MeshProblem> {
    let turned = orient_pieces_outward(&mut mesh);
    let kept = drop_pieces(&mut mesh, &mut mended)?;
    // Inner pieces do not count, because a cavity is inside out. Nor does a wrapped surface, which
    // was made here and not in the file.
    if !mended.wrapped {
        mended.turned |= kept.iter().any(|piece| turned[*piece]);
    }
    mended.volume_m3 = mesh.volume();
    // `>` also refuses a surface without area.
    let is_solid = mended.volume_m3 > VOLUME_SHARE_MIN * mesh.area() * mesh.area().sqrt();
    if !is_solid {
        return Err(MeshProblem::NoVolume {
            volume_ml: mended.volume_m3 * 1e6,
        });
    }
    mended.mesh = mesh;
    Ok(mended)
}

fn check_numbers(mesh: &Mesh) -> Result<(), MeshProblem> {
    if mesh.triangles.is_empty() {
        return Err(MeshProblem::NoTriangles);
    }
    let bad = mesh
        .vertices
        .iter()
        .position(|p| !p.iter().all(|x| x.is_finite()));
    if let Some(index) = bad {
        return Err(MeshProblem::NotFinite { index });
    }
    let vertices = mesh.vertices.len();
    for (triangle, t) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = t.iter().find(|&&i| i as usize >= vertices) {
            let vertex = u64::from(vertex);
            return Err(MeshProblem::IndexOutOfRange {
                triangle,
                vertex,
                vertices,
            });
        }
    }
    let [min, max] = mesh.bounds();
    let extent_m = (max - min).max();
    if !(EXTENT_MIN_M..=EXTENT_MAX_M).contains(&extent_m) {
        let hint = match extent_m {
            x if (20.0..=2000.0).contains(&x) => {
                "; these look like millimetres that were read as metres"
            }
            x if x < EXTENT_MIN_M && x * 1e3 >= EXTENT_MIN_M => {
                "; these look like metres that were read as millimetres"
            }
            _ => "",
        };
        return Err(MeshProblem::Extent {
            extent_m,
            min_m: EXTENT_MIN_M,
            max_m: EXTENT_MAX_M,
            hint,
        });
    }
    Ok(())
}

fn undirected([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn edges_of_many_triangles(mesh: &Mesh) -> usize {
    let mut edges: Vec<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&t| sides(t))
        .map(undirected)
        .collect();
    edges.sort_unstable();
    edges
        .chunk_by(|a, b| a == b)
        .filter(|same| same.len() > 2)
        .count()
}

/// Turns triangles until neighbours agree, starting from the first triangle of each piece.
/// Triangles at an edge of more than two triangles do not count as neighbours.
fn orient_consistently(mesh: &mut Mesh) -> Result<(), MeshProblem> {
    let mut by_edge: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
    for (i, &t) in mesh.triangles.iter().enumerate() {
        for side in sides(t) {
            by_edge.entry(undirected(side)).or_default().push(i as u32);
        }
    }
    let mut visited = vec![false; mesh.triangles.len()];
    for first in 0..mesh.triangles.len() {
        if visited[first] {
            continue;
        }
        visited[first] = true;
        let mut stack = vec![first];
        while let Some(i) = stack.pop() {
            for side in sides(mesh.triangles[i]) {
                let around = &by_edge[&undirected(side)];
                if around.len() != 2 {
                    continue;
                }
                let other = around[usize::from(around[0] as usize == i)] as usize;
                let agrees = sides(mesh.triangles[other]).contains(&[side[1], side[0]]);
                if visited[other] {
                    if !agrees {
                        return Err(MeshProblem::NotOrientable);
                    }
                    continue;
                }
                visited[other] = true;
                if !agrees {
                    mesh.triangles[other].swap(1, 2);
                }
                stack.push(other);
            }
        }
    }
    Ok(())
}

/// Turns every piece whose volume is negative. Returns true for each piece that was turned.
fn orient_pieces_outward(mesh: &mut Mesh) -> Vec<bool> {
    let (of_triangle, count) = pieces(mesh);
    let mut volume = vec![0.0; count];
    let [min, max] = mesh.bounds();
    let origin = (min + max) / 2.0;
    for (&t, &piece) in mesh.triangles.iter().zip(&of_triangle) {
        let [a, b, c] = mesh.corners(t).map(|p| p - origin);
        volume[piece] += a.dot(&b.cross(&c));
    }
    for (t, &piece) in mesh.triangles.iter_mut().zip(&of_triangle) {
        if volume[piece] < 0.0 {
            t.swap(1, 2);
        }
    }
    volume.iter().map(|v| *v < 0.0).collect()
}

/// Returns a vertex of `piece` if the piece lies wholly inside `other`. Up to `LOOKED_AT` vertices,
/// spread over the piece, are tested. One vertex is not enough, because overlapping bodies have
/// some vertices in each other. Vertices that the two pieces share do not count.
fn lies_inside(piece: &Mesh, other: &Mesh) -> Option<Vec3> {
    let [[low, high], [least, most]] = [piece, other].map(Mesh::bounds);
    if !(0..3).all(|k| least[k] <= low[k] && high[k] <= most[k]) {
        return None;
    }
    let bits = |p: &Vec3| [p.x, p.y, p.z].map(f64::to_bits);
    let touched: HashSet<[u64; 3]> = other.vertices.iter().map(bits).collect();
    let apart = piece.vertices.iter();
    let apart: Vec<&Vec3> = apart.filter(|p| !touched.contains(&bits(p))).collect();
    let step = apart.len().div_ceil(LOOKED_AT).max(1);
    let mut looked_at = apart.iter().step_by(step);
    let is_inside = looked_at.all(|p| wrap::winding(other, p) > 0.5);
    apart.first().filter(|_| is_inside).map(|p| **p)
}

/// Drops dust, and pieces that lie inside a larger piece, such as the inner side of a wall. Notes
/// both in `mended`. Returns the numbers of the pieces that are left.
///
/// # Errors
/// When more than `PIECES_MAX` pieces are larger than dust.
fn drop_pieces(mesh: &mut Mesh, mended: &mut Mended) -> Result<Vec<usize>, MeshProblem> {
    let mut all: Vec<(usize, Mesh)> = piece_meshes(mesh).into_iter().enumerate().collect();
    if all.len() < 2 {
        return Ok((0..all.len()).collect());
    }
    all.sort_by(|(_, a), (_, b)| b.volume().total_cmp(&a.volume()));
    let dust = DUST_SHARE * all[0].1.volume();
    let count = all.len();
    let at = all.partition_point(|(_, piece)| piece.volume() >= dust);
    for (_, piece) in all.drain(at..) {
        mended.tiny.add(piece.volume().abs());
    }
    if all.len() > PIECES_MAX {
        return Err(MeshProblem::ManyPieces {
            count: all.len(),
            max: PIECES_MAX,
        });
    }
    let mut kept: Vec<(usize, Mesh)> = Vec::new();
    for (number, piece) in all {
        let mut larger = kept.iter();
        match larger.find_map(|(_, other)| lies_inside(&piece, other)) {
            Some(at) => mended.inner.push(Inner {
                at,
                volume_m3: piece.volume().abs(),
            }),
            None => kept.push((number, piece)),
        }
    }
    if kept.len() < count {
        *mesh = Mesh::default();
        for (_, piece) in &kept {
            mesh.append(piece);
        }
    }
    Ok(kept.into_iter().map(|(number, _)| number).collect())
}
