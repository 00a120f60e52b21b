//! Skin that heat has blanched: its vertices take on the look of cooked tissue.
//!
//! The controller publishes for each sphere which share of the proteins heat has denatured. A
//! vertex has the share of its spheres, by its weights. Vertices at a joint of two organs, which
//! have a second look already, show the cooked look as soon as it is the stronger one.

use core::ops::Range;

use bytemuck::cast_slice;
use shared_mem::message::SphereState;
use shared_mem::scene::WEIGHT_SUM;

use super::gpu::Gpu;
use super::look::COOKED;
use crate::skinning::{RestVertex, SkinMesh};

/// Steps in which the share changes. Each step uploads vertices.
const STEPS: u8 = 32;
/// Bits of `RestVertex::look` that hold the second look and its share.
const SECOND: u32 = 0xffff_00f0;
/// Largest gap between two changed vertices that are uploaded together.
const JOINED: usize = 16;

/// Shares of the skin that are cooked.
#[derive(Debug)]
pub(super) struct Heated {
    /// Cooked share of each sphere, in steps.
    spheres: Vec<u8>,
    /// Looks of the vertices that heat has not changed.
    cold: Vec<u32>,
}

impl Heated {
    /// The state of a cold skin.
    pub(super) fn of(mesh: &SkinMesh) -> Self {
        Self {
            spheres: Vec::new(),
            cold: mesh.vertices.iter().map(|it| it.look).collect(),
        }
    }

    /// Takes the state of the spheres. Returns the vertices of `mesh` whose look has changed.
    fn set(&mut self, spheres: &[SphereState], mesh: &mut SkinMesh) -> Vec<Range<usize>> {
        let now = spheres.iter().map(steps);
        if self.spheres.len() == spheres.len() && now.clone().eq(self.spheres.iter().copied()) {
            return Vec::new();
        }
        self.spheres = now.collect();
        let mut runs: Vec<Range<usize>> = Vec::new();
        let vertices = mesh.vertices.iter_mut().zip(&self.cold).take(mesh.skinned);
        for (i, (vertex, cold)) in vertices.enumerate() {
            let look = cooked(*cold, share(vertex, &self.spheres));
            if look == vertex.look {
                continue;
            }
            vertex.look = look;
            match runs.last_mut() {
                Some(run) if i - run.end < JOINED => run.end = i + 1,
                _ => runs.push(i..i + 1),
            }
        }
        runs
    }

    /// Takes the state of the spheres, and uploads the vertices that change.
    pub(super) fn follow(
        &mut self,
        gpu: &Gpu,
        spheres: &[SphereState],
        mesh: &mut SkinMesh,
        rest: &wgpu::Buffer,
    ) {
        for run in self.set(spheres, mesh) {
            let at = (run.start * size_of::<RestVertex>()) as u64;
            gpu.queue
                .write_buffer(rest, at, cast_slice(&mesh.vertices[run]));
        }
    }

    /// Prepares for a skin whose vertices have been replaced.
    pub(super) fn skin_changed(&mut self) {
        self.spheres.clear();
    }
}

/// Cooked share of a sphere, in steps.
fn steps(sphere: &SphereState) -> u8 {
    (u16::from(sphere.denatured()) * u16::from(STEPS) / 255) as u8
}

/// Cooked share of a vertex, 0 to 1.
fn share(vertex: &RestVertex, spheres: &[u8]) -> f32 {
    let own = vertex.bound().map(|(sphere, weight)| {
        let steps = spheres.get(sphere as usize).copied().unwrap_or(0);
        weight * u32::from(steps)
    });
    own.sum::<u32>() as f32 / (WEIGHT_SUM as f32 * f32::from(STEPS))
}

/// Look with this cooked share, unless the look's second part is stronger.
fn cooked(cold: u32, share: f32) -> u32 {
    // Tissue blanches early: its look changes with the square root of the share.
    let share = (share.sqrt() * 65_535.0) as u32;
    if share <= cold >> 16 {
        return cold;
    }
    cold & !SECOND | COOKED << 4 | share << 16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skinning::pairs;

    fn sphere(denatured: u8) -> SphereState {
        let cold = SphereState {
            center_m: [0.0; 3],
            bits: SphereState::AWAKE,
        };
        cold.with_heat([80, denatured, 0])
    }

    /// A skin of vertices that each follow one sphere. Their look is 3, without a second look.
    fn skin(count: u16) -> SkinMesh {
        let vertex = |i: u16| RestVertex {
            position: [0.0; 3],
            look: 3,
            normal: [0.0, 1.0, 0.0],
            ambient: 1.0,
            spheres: pairs([i, 0, 0, 0, 0, 0, 0, 0]),
            weights: pairs([WEIGHT_SUM as u16, 0, 0, 0, 0, 0, 0, 0]),
        };
        SkinMesh {
            vertices: (0..count).map(vertex).collect(),
            skinned: usize::from(count),
            ..SkinMesh::default()
        }
    }

    #[test]
    fn heated_vertices_look_cooked_and_only_they_are_uploaded() {
        let mut mesh = skin(100);
        let mut heated = Heated::of(&mesh);
        let mut spheres = vec![sphere(0); 100];
        assert!(heated.set(&spheres, &mut mesh).is_empty());
        spheres[7] = sphere(255);
        spheres[60] = sphere(128);
        assert_eq!(heated.set(&spheres, &mut mesh), [7..8, 60..61]);
        assert_eq!(mesh.vertices[7].look, 3 | COOKED << 4 | 65_535 << 16);
        let half = mesh.vertices[60].look >> 16;
        assert!((0.65..0.75).contains(&(half as f32 / 65_535.0)), "{half}");
        assert_eq!(mesh.vertices[8].look, 3);
        assert!(
            heated.set(&spheres, &mut mesh).is_empty(),
            "nothing changed"
        );
        // After a reset all is as before.
        assert_eq!(heated.set(&[sphere(0); 100], &mut mesh), [7..8, 60..61]);
        assert!(mesh.vertices.iter().all(|it| it.look == 3));
    }

    #[test]
    fn a_joint_keeps_its_second_look_until_the_heat_is_stronger() {
        let joint = 3 | 5 << 4 | 40_000 << 16;
        assert_eq!(cooked(joint, 0.1), joint);
        assert_eq!(cooked(joint, 1.0), 3 | COOKED << 4 | 65_535 << 16);
        assert_eq!(
            cooked(0x0f03, 1.0),
            0x0f03 | 65_535 << 16,
            "the tree's slot stays"
        );
    }
}
