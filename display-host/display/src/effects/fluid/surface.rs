//! The skin as fluid runs over it: places on triangles, and the way from one triangle to the next.

use glam::{Vec2, Vec3};

use super::super::stain::Skin;

/// Stands for no neighbour.
const NONE: u32 = u32::MAX;
/// Largest number of edges that a parcel crosses in one step.
const EDGES_MAX: usize = 12;

/// A place on the skin: a triangle, and the weights of its corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) triangle: u32,
    pub(super) weights: [f32; 3],
}

impl Place {
    fn of(&self, corners: [Vec3; 3]) -> Vec3 {
        let [a, b, c] = corners;
        a * self.weights[0] + b * self.weights[1] + c * self.weights[2]
    }
}

/// Neighbours of the triangles, and the present places of the vertices that were asked for.
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    /// For each triangle: the neighbours across the edges opposite to its corners.
    next: Vec<[u32; 3]>,
    now: Vec<Vec3>,
    /// Vertices whose place in `now` is of this moment.
    known: Vec<u32>,
    moment: u32,
}

impl Surface {
    /// Finds the neighbours of all triangles.
    pub(super) fn of(skin: &Skin<'_>) -> Self {
        let triangles = skin.triangles();
        let mut edges: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(triangles.len() * 3);
        for (number, corners) in (0u32..).zip(triangles) {
            for k in 0..3u8 {
                let [a, b] = [1, 2].map(|by| corners[(usize::from(k) + by) % 3]);
                if a != b {
                    edges.push(([a.min(b), a.max(b)], number, k));
                }
            }
        }
        edges.sort_unstable();
        let mut next = vec![[NONE; 3]; triangles.len()];
        for pair in edges.windows(2) {
            let [(edge, a, i), (other, b, j)] = [pair[0], pair[1]];
            if edge == other {
                next[a as usize][usize::from(i)] = b;
                next[b as usize][usize::from(j)] = a;
            }
        }
        Self {
            next,
            now: vec![Vec3::ZERO; skin.vertex_count()],
            known: vec![0; skin.vertex_count()],
            moment: 0,
        }
    }

    /// True if this is the surface of a skin with as many triangles.
    pub(super) fn fits(&self, skin: &Skin<'_>) -> bool {
        self.next.len() == skin.triangles().len() && self.now.len() == skin.vertex_count()
    }

    /// Forgets where the vertices were.
    pub(super) fn begin_moment(&mut self) {
        self.moment = self.moment.wrapping_add(1);
        if self.moment == 0 {
            self.known.fill(0);
            self.moment = 1;
        }
    }

    /// Present place of a vertex, m.
    pub(super) fn vertex(&mut self, vertex: u32, skin: &Skin<'_>) -> Vec3 {
        let v = vertex as usize;
        if self.known[v] != self.moment {
            self.known[v] = self.moment;
            self.now[v] = skin.place(v);
        }
        self.now[v]
    }

    pub(super) fn corners(&mut self, triangle: u32, skin: &Skin<'_>) -> [Vec3; 3] {
        let corners = skin.triangles()[triangle as usize];
        corners.map(|v| self.vertex(v, skin))
    }

    /// Present position of a place, m.
    pub(super) fn position(&mut self, place: &Place, skin: &Skin<'_>) -> Vec3 {
        place.of(self.corners(place.triangle, skin))
    }

    /// The place on the tissue at rest, m.
    pub(super) fn at_rest(place: &Place, skin: &Skin<'_>) -> Vec3 {
        let corners = skin.triangles()[place.triangle as usize];
        place.of(corners.map(|v| skin.at_rest(v as usize)))
    }

    /// Gradient in the present space of a number whose gradient in the tissue at rest is `at_rest`.
    pub(super) fn carried(&mut self, triangle: u32, at_rest: Vec3, skin: &Skin<'_>) -> Vec3 {
        let rest = skin.triangles()[triangle as usize].map(|v| skin.at_rest(v as usize));
        let now = self.corners(triangle, skin);
        let [rise_b, rise_c] = [1, 2].map(|k| at_rest.dot(rest[k] - rest[0]));
        let [b, c] = [1, 2].map(|k| now[k] - now[0]);
        solve(b, c, Vec2::new(rise_b, rise_c)).map_or(Vec3::ZERO, |w| b * w.x + c * w.y)
    }

    /// Moves a place by `by` (m, present space) along the skin. Returns how far it came, m.
    pub(super) fn walk(&mut self, place: &mut Place, by: Vec3, skin: &Skin<'_>) -> f32 {
        let (mut left, mut came) = (by, 0.0);
        for _ in 0..EDGES_MAX {
            let corners = self.corners(place.triangle, skin);
            let [a, b, c] = corners;
            let within = |way: Vec3| {
                let along = Vec2::new(way.dot(b - a), way.dot(c - a));
                solve(b - a, c - a, along)
            };
            let Some(rate) = within(left) else { break };
            let rates = [-rate.x - rate.y, rate.x, rate.y];
            let end = (0..3).filter(|k| rates[*k] < -1e-9);
            let end = end
                .map(|k| (place.weights[k].max(0.0) / -rates[k], k))
                .min_by(|x, y| x.0.total_cmp(&y.0));
            let (share, edge) = match end {
                Some((share, edge)) if share < 1.0 => (share, Some(edge)),
                _ => (1.0, None),
            };
            for (weight, rate) in place.weights.iter_mut().zip(rates) {
                *weight += rate * share;
            }
            let flat = (b - a) * rate.x + (c - a) * rate.y;
            came += flat.length() * share;
            let Some(edge) = edge else { break };
            place.weights[edge] = 0.0;
            left = flat * (1.0 - share);
            let ends = [1, 2].map(|by| (edge + by) % 3);
            if !self.cross(place, edge, &mut left, skin) {
                // The skin ends here or turns back, so the rest leads along the edge.
                let along = corners[ends[1]] - corners[ends[0]];
                left = along * (left.dot(along) / along.length_squared().max(1e-16));
            }
            if left.length_squared() < 1e-14 {
                break;
            }
        }
        let sum: f32 = place.weights.iter().map(|w| w.max(0.0)).sum();
        if sum > 0.0 {
            place.weights = place.weights.map(|w| w.max(0.0) / sum);
        }
        came
    }

    /// Crosses the edge opposite to a corner. Returns false if no triangle is beyond it, or if the
    /// rest of the way (`left`) does not lead into that triangle.
    fn cross(&mut self, place: &mut Place, edge: usize, left: &mut Vec3, skin: &Skin<'_>) -> bool {
        let triangle = self.next[place.triangle as usize][edge];
        let Some(corners) = skin.triangles().get(triangle as usize) else {
            return false;
        };
        let own = skin.triangles()[place.triangle as usize];
        let mut weights = [0.0; 3];
        let mut far = None;
        for k in 0..3 {
            match own.iter().position(|v| *v == corners[k]) {
                Some(same) if same != edge => weights[k] = place.weights[same],
                _ => far = Some(k),
            }
        }
        let Some(far) = far else { return false };
        let now = self.corners(triangle, skin);
        let [p, q] = [1, 2].map(|by| now[(far + by) % 3]);
        let inwards = (now[far] - p).reject_from((q - p).normalize_or_zero());
        // Bend the way over the edge: its part along the edge stays, and the rest leads inwards.
        let along = (q - p).normalize_or_zero();
        let onwards = left.dot(inwards.normalize_or_zero());
        if onwards <= 0.0 {
            return false;
        }
        *left = along * left.dot(along) + inwards.normalize_or_zero() * onwards;
        *place = Place { triangle, weights };
        true
    }
}

/// Coefficients of `b` and `c` for the vector in their plane whose dot products with `b` and `c`
/// are `products`. `None` if `b` and `c` are parallel.
fn solve(b: Vec3, c: Vec3, products: Vec2) -> Option<Vec2> {
    let (bb, bc, cc) = (b.dot(b), b.dot(c), c.dot(c));
    let det = bb * cc - bc * bc;
    (det > 1e-24).then(|| {
        let x = products.x * cc - products.y * bc;
        let y = products.y * bb - products.x * bc;
        Vec2::new(x, y) / det
    })
}
