//! Surfaces of the organs at rest. The close pictures show them. Their silhouettes lie behind the
//! paths of the tools in the debrief.

use core::fmt::Write as _;

use shared_mem::scene::{OrganKind, SceneFile, str_from_name};

/// Number of cells along each side of a view. Each is 2 of the drawing's 228 units wide.
pub(super) const CELLS: usize = 114;
/// An organ's name is drawn if the organ covers at least this many cells: about the area of the
/// name.
const NAMED_CELLS: usize = 90;

/// Surfaces of all organs of a scene at rest, world frame, m.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outlines(Vec<Outline>);

#[derive(Debug, Clone, PartialEq)]
struct Outline {
    name: String,
    kind: Option<OrganKind>,
    triangles: Vec<[[f32; 3]; 3]>,
}

/// Name, kind and triangles of an organ.
pub(super) type Surface<'a> = (&'a str, Option<OrganKind>, &'a [[[f32; 3]; 3]]);

/// One view: two axes of the world, and the range of each that the view shows, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    pub(super) axes: [usize; 2],
    pub(super) from_m: [f64; 2],
    pub(super) width_m: f64,
}

/// An organ in a view.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Silhouette<'a> {
    pub(super) name: &'a str,
    pub(super) color: &'static str,
    /// Covered runs of cells: row, first column, number of columns. Row 0 is the lowest.
    pub(super) runs: Vec<[usize; 3]>,
    /// Centroid of the covered cells (column, row), where the name goes. `None` if the organ is too
    /// small for it.
    pub(super) middle: Option<[f64; 2]>,
}

impl Outlines {
    /// Organs of a scene that have a surface, in the order in which they are drawn: most triangles
    /// first.
    #[must_use]
    pub fn of(scene: &SceneFile) -> Self {
        let (vertices, triangles) = (scene.vertices(), scene.triangles());
        let place = |index: u32| vertices.get(index as usize).map(|it| it.position_m);
        let corners = |it: &[u32; 3]| Some([place(it[0])?, place(it[1])?, place(it[2])?]);
        let organ = |record: &shared_mem::scene::OrganRecord| {
            let [first, count] = record.triangles.map(|it| it as usize);
            let own = triangles.iter().skip(first).take(count);
            Outline {
                name: str_from_name(&record.name).unwrap_or_default().to_owned(),
                kind: OrganKind::from_u32(record.kind),
                triangles: own.filter_map(corners).collect(),
            }
        };
        let mut organs: Vec<Outline> = scene.organs().iter().map(organ).collect();
        organs.retain(|it| !it.triangles.is_empty());
        organs.sort_by_key(|it| core::cmp::Reverse(it.triangles.len()));
        Self(organs)
    }

    /// True if there is an organ to draw.
    pub(super) const fn is_any(&self) -> bool {
        !self.0.is_empty()
    }

    /// Name, kind and triangles of each organ.
    pub(super) fn surfaces(&self) -> impl Iterator<Item = Surface<'_>> {
        self.0
            .iter()
            .map(|it| (it.name.as_str(), it.kind, it.triangles.as_slice()))
    }

    /// One organ of these triangles.
    #[cfg(test)]
    pub(super) fn test(kind: OrganKind, triangles: Vec<[[f32; 3]; 3]>) -> Self {
        Self(vec![Outline {
            name: "liver".to_owned(),
            kind: Some(kind),
            triangles,
        }])
    }

    /// These organs, and one more.
    #[cfg(test)]
    pub(super) fn with(mut self, name: &str, kind: OrganKind, own: Vec<[[f32; 3]; 3]>) -> Self {
        self.0.push(Outline {
            name: name.to_owned(),
            kind: Some(kind),
            triangles: own,
        });
        self
    }

    /// The organs that a view shows, in the order in which they are drawn.
    pub(super) fn seen(&self, view: View) -> impl Iterator<Item = Silhouette<'_>> {
        self.0.iter().filter_map(move |organ| {
            let covered = covered(&organ.triangles, view);
            let runs = runs(&covered);
            (!runs.is_empty()).then(|| Silhouette {
                name: &organ.name,
                color: color(organ.kind),
                middle: middle(&runs),
                runs,
            })
        })
    }
}

impl Silhouette<'_> {
    /// Path data of an SVG: a horizontal stroke for each run. The stroke's width is the height of a
    /// row. `left` and `top` are the upper left corner of the view, `side` its width and height.
    pub(super) fn path(&self, [left, top]: [f64; 2], side: f64) -> String {
        let cell = side / CELLS as f64;
        let mut path = String::new();
        for [row, first, count] in &self.runs {
            let x = left + cell * *first as f64;
            let y = top + side - cell * (*row as f64 + 0.5);
            // Writing to a string cannot fail.
            let _ = write!(path, "M{x:.1} {y:.1}h{:.1}", cell * *count as f64);
        }
        path
    }
}

/// Marks every cell whose middle lies in a triangle. The cells of the triangle's corners are
/// marked, too, because a triangle may be smaller than a cell.
fn covered(triangles: &[[[f32; 3]; 3]], view: View) -> Vec<bool> {
    let mut cells = vec![false; CELLS * CELLS];
    let to_cell = |point: &[f32; 3]| {
        let [x, y] = view
            .axes
            .map(|axis| f64::from(point.get(axis).copied().unwrap_or(0.0)));
        [x - view.from_m[0], y - view.from_m[1]].map(|m| m / view.width_m * CELLS as f64)
    };
    let mut cover = |column: f64, row: f64| {
        let inside = |it: f64| (0.0..CELLS as f64).contains(&it).then_some(it as usize);
        if let (Some(column), Some(row)) = (inside(column), inside(row))
            && let Some(cell) = cells.get_mut(row * CELLS + column)
        {
            *cell = true;
        }
    };
    for triangle in triangles {
        let [a, b, c] = [
            to_cell(&triangle[0]),
            to_cell(&triangle[1]),
            to_cell(&triangle[2]),
        ];
        let range = |axis: usize| {
            let [a, b, c] = [a[axis], b[axis], c[axis]];
            let [least, most] = [a.min(b).min(c), a.max(b).max(c)];
            let cell = |it: f64| it.clamp(0.0, CELLS as f64) as usize;
            cell(least)..cell(most + 1.0)
        };
        for row in range(1) {
            for column in range(0) {
                let at = [column as f64 + 0.5, row as f64 + 0.5];
                if is_inside(at, [a, b, c]) {
                    cover(at[0], at[1]);
                }
            }
        }
        [a, b, c].into_iter().for_each(|[x, y]| cover(x, y));
    }
    cells
}

/// True if a point lies in a triangle or on its edge, whichever way round its corners are.
fn is_inside(at: [f64; 2], [a, b, c]: [[f64; 2]; 3]) -> bool {
    let side =
        |p: [f64; 2], q: [f64; 2]| (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0]);
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|it| *it >= 0.0) || sides.iter().all(|it| *it <= 0.0)
}

fn runs(cells: &[bool]) -> Vec<[usize; 3]> {
    let mut runs = Vec::new();
    for (row, line) in cells.chunks(CELLS).enumerate() {
        let mut column = 0;
        for run in line.chunk_by(|a, b| a == b) {
            if run.first() == Some(&true) {
                runs.push([row, column, run.len()]);
            }
            column += run.len();
        }
    }
    runs
}

fn middle(runs: &[[usize; 3]]) -> Option<[f64; 2]> {
    let count: usize = runs.iter().map(|[.., count]| count).sum();
    let sum = |of: fn(&[usize; 3]) -> f64| runs.iter().map(of).sum::<f64>() / count as f64;
    (count >= NAMED_CELLS).then(|| {
        [
            sum(|[_, first, count]| (*first as f64 + 0.5 * *count as f64) * *count as f64),
            sum(|[row, _, count]| (*row as f64 + 0.5) * *count as f64),
        ]
    })
}

/// Light colours near those of the tissue, so that the paths stand out.
const fn color(kind: Option<OrganKind>) -> &'static str {
    match kind {
        Some(OrganKind::Liver) => "#e3c1b4",
        Some(OrganKind::Gallbladder) => "#bcd3b0",
        Some(OrganKind::CysticDuct | OrganKind::BileDuct) => "#cfc763",
        Some(OrganKind::CysticArtery | OrganKind::Vessel) => "#d98c86",
        Some(OrganKind::Fat | OrganKind::ConnectiveTissue) => "#efe3b8",
        _ => "#e6d3d3",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: View = View {
        axes: [0, 1],
        from_m: [0.0, 0.0],
        width_m: 0.001 * CELLS as f64,
    };

    fn square(from_m: [f32; 2], side_m: f32) -> Outlines {
        let [x, y] = from_m;
        let corner = |right: f32, up: f32| [x + right * side_m, y + up * side_m, 0.5];
        let [a, b] = [corner(0.0, 0.0), corner(1.0, 0.0)];
        let [c, d] = [corner(1.0, 1.0), corner(0.0, 1.0)];
        Outlines(vec![Outline {
            name: "liver".to_owned(),
            kind: Some(OrganKind::Liver),
            triangles: vec![[a, b, c], [a, d, c]],
        }])
    }

    #[test]
    fn an_organ_covers_the_cells_that_it_lies_over() {
        let organs = square([0.0101, 0.0201], 0.0198);
        let seen: Vec<_> = organs.seen(VIEW).collect();
        let count: usize = seen[0].runs.iter().map(|[.., count]| count).sum();
        assert_eq!(count, 400, "20 cells of 1 mm each way");
        assert!(
            seen[0]
                .runs
                .iter()
                .all(|[row, first, _]| *row >= 20 && *first >= 10)
        );
        let [x, y] = seen[0].middle.unwrap();
        assert!((x - 20.0).abs() < 0.6 && (y - 30.0).abs() < 0.6, "{x} {y}");
    }

    #[test]
    fn what_lies_outside_is_not_drawn_and_what_is_small_has_no_name() {
        assert_eq!(square([0.2, 0.2], 0.05).seen(VIEW).count(), 0);
        let organs = square([0.0303, 0.0303], 0.0004);
        let seen: Vec<_> = organs.seen(VIEW).collect();
        assert!(
            seen[0].middle.is_none() && seen[0].runs.len() == 1,
            "{seen:?}"
        );
    }
}
