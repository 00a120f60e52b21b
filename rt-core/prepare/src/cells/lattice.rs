//! Outlines of the cross-sections, layers between the outlines, and hexahedra between the points of
//! the layers' borders.

use rayon::prelude::*;

use super::course::CrossSections;
use super::{Cells, hexa};
use crate::Vec3;
use crate::field::Field;
use crate::recipe::Layers;

/// Fewest and most rays of a section.
const RAYS: (f64, f64) = (18.0, 96.0);
/// Length of a step along a ray, in cell sizes.
const STEP_CELLS: f64 = 0.1;
/// Distance from the course at which rays start, m. At the course all rays of a section meet, so a
/// cell that began there would have an edge without length.
const INNERMOST_M: f64 = 0.000_4;
/// The first and the last section lie at the organ's ends, where there is no tissue. Their outlines
/// are found this far inside the organ, in cell sizes.
const INSET_CELLS: f64 = 0.3;
/// Number of rounds in which rays without tissue take the mean outline of neighbouring rays.
const CARRIED: usize = 2;
/// A cell is tested for tissue at this number of points along each of its three directions.
const SAMPLES: usize = 4;
/// Bounds of the threshold that `Lattice::cells` chooses. Cells with a smaller share of tissue are
/// left out.
const TISSUE: (f64, f64) = (0.2, 0.8);

/// Outlines of the tissue: the radii at which it begins and ends along every ray of every section.
pub(super) struct Lattice<'a> {
    course: &'a CrossSections,
    field: &'a Field,
    rays: usize,
    layers: usize,
    /// Inner and outer radius by section and ray, m. `None` if neither the ray nor a ray within
    /// [`CARRIED`] places meets tissue.
    outline: Vec<Option<[f64; 2]>>,
}

impl<'a> Lattice<'a> {
    pub(super) fn new(course: &'a CrossSections, field: &'a Field, plan: &Layers) -> Self {
        let mut lattice = Self {
            course,
            field,
            rays: 48,
            layers: plan.count,
            outline: Vec::new(),
        };
        lattice.find_outlines(plan.cell_m);
        // The number of rays makes cells `cell_m` wide halfway between the outlines.
        let found = || lattice.outline.iter().flatten();
        let middle_m =
            found().map(|[a, b]| 0.5 * (a + b)).sum::<f64>() / found().count().max(1) as f64;
        let rays = std::f64::consts::TAU * middle_m / plan.cell_m;
        lattice.rays = rays.clamp(RAYS.0, RAYS.1).round() as usize;
        lattice.find_outlines(plan.cell_m);
        for _ in 0..CARRIED {
            lattice.carry_on();
        }
        lattice
    }

    fn sections(&self) -> usize {
        self.course.middles.len()
    }

    fn ray(&self, ray: usize) -> Vec3 {
        let angle = std::f64::consts::TAU * ray as f64 / self.rays as f64;
        let [_, x, y] = self.course.axes;
        // The directions along the course, around it and outwards are right-handed.
        x * libm::cos(angle) - y * libm::sin(angle)
    }

    fn find_outlines(&mut self, cell_m: f64) {
        let grid = &self.field.grid;
        let far = grid.position(grid.size) - grid.origin;
        let (step_m, reach_m) = (STEP_CELLS * cell_m, far.norm());
        let (sections, rays) = (self.sections(), self.rays);
        self.outline = (0..sections * rays)
            .into_par_iter()
            .map(|i| {
                let (section, ray) = (i / rays, self.ray(i % rays));
                let inset = match section {
                    0 => INSET_CELLS,
                    s if s + 1 == sections => -INSET_CELLS,
                    _ => 0.0,
                };
                let from = self.course.middles[section] + self.course.axes[0] * (inset * cell_m);
                let depth = |r: f64| self.inside(&(from + ray * r));
                let steps = (reach_m / step_m) as usize;
                let radius = |k: usize| INNERMOST_M + step_m * k as f64;
                let first = (0..steps).find(|&k| depth(radius(k)))?;
                let last = (first..steps).rev().find(|&k| depth(radius(k)))?;
                // The outlines lie half a step outside of the first and the last point in tissue.
                let inner = radius(first) - if first > 0 { 0.5 * step_m } else { 0.0 };
                Some([inner, radius(last) + 0.5 * step_m])
            })
            .collect();
    }

    /// True if there is tissue at `p`.
    fn inside(&self, p: &Vec3) -> bool {
        let grid = &self.field.grid;
        let last = grid.position(grid.size.map(|n| n - 1));
        let in_grid = (0..3).all(|k| (grid.origin[k]..=last[k]).contains(&p[k]));
        in_grid && self.field.at(p) < 0.0
    }

    /// Gives each ray without an outline the mean outline of its neighbours that have one.
    fn carry_on(&mut self) {
        let (sections, rays) = (self.sections(), self.rays);
        let old = self.outline.clone();
        for i in 0..old.len() {
            if old[i].is_some() {
                continue;
            }
            let (section, ray) = (i / rays, i % rays);
            let beside = [
                (section > 0).then(|| i - rays),
                (section + 1 < sections).then(|| i + rays),
                Some(section * rays + (ray + 1) % rays),
                Some(section * rays + (ray + rays - 1) % rays),
            ];
            let known: Vec<[f64; 2]> = beside.iter().flatten().filter_map(|&k| old[k]).collect();
            if !known.is_empty() {
                let mean = |k: usize| known.iter().map(|o| o[k]).sum::<f64>() / known.len() as f64;
                self.outline[i] = Some([mean(0), mean(1)]);
            }
        }
    }

    /// Joins the points to hexahedra and keeps those with enough tissue. The threshold for the
    /// share of tissue is chosen so that the kept cells together have the organ's volume, as far
    /// as [`TISSUE`] allows.
    pub(super) fn cells(&self, volume_m3: f64) -> Cells {
        let (rays, layers) = (self.rays, self.layers);
        let points = layers + 1;
        let mut all = Cells::default();
        for (i, outline) in self.outline.iter().enumerate() {
            let [inner, outer] = outline.unwrap_or([INNERMOST_M, 2.0 * INNERMOST_M]);
            let (from, ray) = (self.course.middles[i / rays], self.ray(i % rays));
            for layer in 0..points {
                let share = layer as f64 / layers as f64;
                all.corners
                    .push(from + ray * (inner + (outer - inner) * share));
            }
        }
        let mut number = vec![None; self.outline.len() * layers];
        let mut places = Vec::new();
        for section in 0..self.sections() - 1 {
            for ray in 0..rays {
                let lines: [usize; 4] =
                    std::array::from_fn(|k| (section + (k & 1)) * rays + (ray + (k >> 1)) % rays);
                if lines.iter().any(|&line| self.outline[line].is_none()) {
                    continue;
                }
                for layer in 0..layers {
                    let corner = |k: usize| (lines[k & 3] * points + layer + (k >> 2)) as u32;
                    number[lines[0] * layers + layer] = Some(all.cells.len() as u32);
                    all.cells.push(std::array::from_fn(corner));
                    all.layers.push(layer as u8);
                    places.push([section, ray, layer]);
                }
            }
        }
        let of = |[section, ray, layer]: [usize; 3]| {
            number[(section * rays + ray % rays) * layers + layer]
        };
        let beside = |&[section, ray, layer]: &[usize; 3]| {
            [
                (section > 0)
                    .then(|| of([section - 1, ray, layer]))
                    .flatten(),
                (section + 1 < self.sections())
                    .then(|| of([section + 1, ray, layer]))
                    .flatten(),
                of([section, ray + rays - 1, layer]),
                of([section, ray + 1, layer]),
                (layer > 0).then(|| of([section, ray, layer - 1])).flatten(),
                (layer + 1 < layers)
                    .then(|| of([section, ray, layer + 1]))
                    .flatten(),
            ]
        };
        all.neighbours = places.iter().map(beside).collect();
        let tissue: Vec<(f64, f64)> = (0..all.cells.len())
            .into_par_iter()
            .map(|i| {
                let p = all.places(i);
                (self.tissue(&p), hexa::volume_m3(&p))
            })
            .collect();
        let kept_m3 = |least: f64| {
            let kept = tissue.iter().filter(|(share, _)| *share >= least);
            kept.map(|(_, volume)| volume).sum::<f64>()
        };
        let (mut low, mut high) = TISSUE;
        for _ in 0..12 {
            let least = 0.5 * (low + high);
            if kept_m3(least) > volume_m3 {
                low = least;
            } else {
                high = least;
            }
        }
        all.keep(|cell| tissue[cell].0 >= high);
        all
    }

    /// Share of a cell that is tissue.
    fn tissue(&self, p: &[Vec3; 8]) -> f64 {
        let share = |k: usize| (k as f64 + 0.5) / SAMPLES as f64;
        let inside = (0..SAMPLES.pow(3)).filter(|k| {
            let at = [k % SAMPLES, k / SAMPLES % SAMPLES, k / SAMPLES / SAMPLES].map(share);
            self.inside(&hexa::at(p, at))
        });
        inside.count() as f64 / SAMPLES.pow(3) as f64
    }
}
