//! Triangles of the skin that a picture can show, nearest first. They are chosen on the CPU for
//! software drivers, which otherwise spend much of a frame on vertices.
//!
//! Many triangles face away, lie outside the picture, or are so small that they fall between the
//! samples of its pixels. The picture is the same without them. Surfaces behind the nearest
//! triangles fail the depth test and are not shaded.

use bytemuck::cast_slice;
use glam::{Mat4, Vec3};

use super::gpu::Gpu;
use crate::skinning::SkinnedVertex;

/// Number of the lowest bits of a distance in single precision that do not count for the order. The
/// remaining bits give eight classes for each doubling of the distance.
const COARSE_BITS: u32 = 20;
/// Number of classes of distance, for twenty doublings. The last class holds all farther distances.
const CLASSES: usize = 160;
/// Largest deviation of the device's arithmetic from that of this module, pixels.
const SLACK_PX: f32 = 1.0 / 64.0;

/// A camera's view of the skin.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    pub(super) clip_from_world: Mat4,
    /// Size of the picture that is drawn, pixels.
    pub(super) size: [u32; 2],
    /// Samples a pixel: 1 or 4.
    pub(super) samples: u32,
    /// Nearest visible distance, m.
    pub(super) near_m: f32,
}

/// A vertex in the picture: pixels from the lower left, and distance before the camera, m.
#[derive(Debug, Clone, Copy)]
struct Seen {
    x: f32,
    y: f32,
    far_m: f32,
}

impl View {
    fn sees(&self, at: Vec3) -> Seen {
        let clip = self.clip_from_world * at.extend(1.0);
        let [width, height] = self.size.map(|side| 0.5 * side as f32);
        Seen {
            x: (clip.x / clip.w + 1.0) * width,
            y: (clip.y / clip.w + 1.0) * height,
            far_m: clip.w,
        }
    }

    /// Distance of the nearest corner of a triangle, m. `None` if the picture cannot show the
    /// triangle.
    fn shows(&self, corners: [Seen; 3]) -> Option<f32> {
        let [a, b, c] = corners;
        let nearest = a.far_m.min(b.far_m).min(c.far_m);
        let farthest = a.far_m.max(b.far_m).max(c.far_m);
        if nearest < self.near_m {
            // A triangle through the plane of the lens has no size in the picture.
            return (farthest >= self.near_m).then_some(self.near_m);
        }
        let doubled_px2 = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if doubled_px2 <= -SLACK_PX {
            return None;
        }
        let within = |sides: [f32; 3], size: u32| {
            let low = sides[0].min(sides[1]).min(sides[2]).max(0.0) - SLACK_PX;
            let high = sides[0].max(sides[1]).max(sides[2]).min(size as f32) + SLACK_PX;
            // Samples lie in the middles of equal parts: one part a pixel, or four along each side.
            let parts = self.samples as f32;
            (high * parts - 0.5).floor() >= (low * parts - 0.5).ceil()
        };
        let [width, height] = self.size;
        (within([a.x, b.x, c.x], width) && within([a.y, b.y, c.y], height)).then_some(nearest)
    }

    fn class(&self, far_m: f32) -> usize {
        let from = self.near_m.to_bits() >> COARSE_BITS;
        let class = (far_m.to_bits() >> COARSE_BITS).saturating_sub(from);
        (class as usize).min(CLASSES - 1)
    }
}

/// Lists of a frame, kept so that a frame allocates nothing.
#[derive(Default)]
struct Lists {
    seen: Vec<Seen>,
    /// Triangles that the picture may show, and their classes of distance.
    shown: Vec<(u32, u8)>,
    /// Corners of these triangles, nearest class first.
    corners: Vec<[u32; 3]>,
}

impl Lists {
    fn choose(
        &mut self,
        view: &View,
        places: &[SkinnedVertex],
        triangles: &[[u32; 3]],
        is_hidden: &[bool],
    ) {
        self.seen.clear();
        let places = places.iter().map(|it| Vec3::from_slice(&it.position));
        self.seen.extend(places.map(|at| view.sees(at)));
        self.shown.clear();
        let mut ends = [0usize; CLASSES + 1];
        for (number, corners) in triangles.iter().enumerate() {
            let is_gone = corners[0] == corners[1] || is_hidden.get(number) == Some(&true);
            if is_gone {
                continue;
            }
            if let Some(far_m) = view.shows(corners.map(|v| self.seen[v as usize])) {
                let class = view.class(far_m);
                ends[class + 1] += 1;
                self.shown.push((number as u32, class as u8));
            }
        }
        for class in 0..CLASSES {
            ends[class + 1] += ends[class];
        }
        self.corners.clear();
        self.corners.resize(self.shown.len(), [0; 3]);
        for &(number, class) in &self.shown {
            let next = &mut ends[usize::from(class)];
            self.corners[*next] = triangles[number as usize];
            *next += 1;
        }
    }
}

/// The triangles of the next frame, in an index buffer.
pub(super) struct Visible {
    lists: Lists,
    buffer: wgpu::Buffer,
}

impl Visible {
    /// For a skin of this many triangles.
    pub(super) fn new(gpu: &Gpu, triangles: usize) -> Self {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("visible triangles"),
            size: (triangles.max(1) * size_of::<[u32; 3]>()) as u64,
            usage: wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            lists: Lists::default(),
            buffer,
        }
    }

    /// Chooses the triangles that are not hidden. `places` are those of all vertices.
    pub(super) fn choose(
        &mut self,
        gpu: &Gpu,
        view: &View,
        places: &[SkinnedVertex],
        triangles: &[[u32; 3]],
        is_hidden: &[bool],
    ) {
        self.lists.choose(view, places, triangles, is_hidden);
        let corners = self.lists.corners.as_flattened();
        gpu.queue.write_buffer(&self.buffer, 0, cast_slice(corners));
    }

    /// The index buffer and the number of its indices.
    pub(super) fn corners(&self) -> (&wgpu::Buffer, u32) {
        (&self.buffer, self.lists.corners.len() as u32 * 3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::camera::rh::{proj::directx as projection, view};

    const SIZE: [u32; 2] = [64, 48];

    fn looking_along_z(samples: u32) -> View {
        let clip = projection::perspective_infinite_reverse(1.0, 64.0 / 48.0, 0.002);
        let eye = view::look_to_mat4(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y);
        View {
            clip_from_world: clip * eye,
            size: SIZE,
            samples,
            near_m: 0.002,
        }
    }

    fn shown(samples: u32, corners: &[[f32; 3]], is_hidden: &[bool]) -> Vec<[u32; 3]> {
        let places: Vec<SkinnedVertex> = corners
            .iter()
            .map(|at| SkinnedVertex {
                position: [at[0], at[1], at[2], 0.0],
                normal: [0.0; 4],
            })
            .collect();
        let count = corners.len() as u32 / 3;
        let triangles: Vec<[u32; 3]> = (0..count).map(|i| [0, 1, 2].map(|k| 3 * i + k)).collect();
        let mut lists = Lists::default();
        lists.choose(&looking_along_z(samples), &places, &triangles, is_hidden);
        lists.corners
    }

    /// A triangle of this size at this place, which faces the camera.
    fn facing(x: f32, y: f32, z: f32, side: f32) -> [[f32; 3]; 3] {
        [[x, y, z], [x + side, y, z], [x, y + side, z]]
    }

    #[test]
    fn triangles_that_face_away_lie_outside_or_are_hidden_are_left_out() {
        let [a, b, c] = facing(0.0, 0.0, -0.1, 0.01);
        assert_eq!(shown(1, &[a, b, c], &[]), [[0, 1, 2]]);
        assert!(shown(1, &[a, c, b], &[]).is_empty(), "faces away");
        assert!(shown(1, &[a, b, c], &[true]).is_empty(), "is hidden");
        assert!(shown(1, &facing(0.5, 0.0, -0.1, 0.01), &[]).is_empty());
        assert!(shown(1, &facing(0.0, 0.0, 0.1, 0.01), &[]).is_empty());
        // A triangle that reaches behind the lens stays.
        assert_eq!(shown(1, &[a, [0.0, 0.01, 0.1], c], &[]).len(), 1);
    }

    #[test]
    fn triangles_between_the_samples_are_left_out() {
        // At 1 m a pixel is 22.8 mm wide. The picture's middle is a corner of four pixels.
        let small = facing(0.001, 0.001, -1.0, 0.006);
        assert!(shown(1, &small, &[]).is_empty());
        assert_eq!(shown(4, &small, &[]).len(), 1, "it covers a sample");
        let in_the_middle = facing(0.009, 0.009, -1.0, 0.006);
        assert_eq!(shown(1, &in_the_middle, &[]).len(), 1);
    }

    #[test]
    fn the_nearest_triangle_comes_first() {
        let [far, near] = [-0.4, -0.1].map(|z| facing(0.0, 0.0, z, 0.05));
        let both = [far, near].concat();
        assert_eq!(shown(1, &both, &[]), [[3, 4, 5], [0, 1, 2]]);
    }
}
