//! Digest of a tick: a few bytes that are equal in two runs with equal inputs.
//!
//! Every sphere counts in every tick, so a comparison finds the first tick and the organ in which
//! two runs differ. A hash of all numbers would take too long for a tick; sums of the spheres' bits
//! take microseconds.

use crate::capacity::MAX_ORGANS;
use crate::hash::Hash;
use crate::sim::TickView;
use crate::tissue::Node;
use crate::words::SphereBits;

/// Hashes of the results of a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Digest {
    /// Hash of the tools (instrument, poses, jaw, force, torque and opening force on the hand,
    /// counts, switches), the clips, the trainee's sutures, the stones and the history of cells.
    pub tools: u32,
    /// Hash of all spheres: displacement, inverse mass, velocity and flags.
    pub spheres: u32,
    /// Hash of each organ's spheres in eight bits: one difference in 256 is not detected.
    pub organs: [u8; MAX_ORGANS],
}

impl TickView<'_> {
    /// Digest of this tick, for comparison with another run of equal inputs. Reads all spheres
    /// once.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut all = Hash::new();
        let mut organs = [0; MAX_ORGANS];
        for (organ, organ_hash) in self.scene.organs.iter().zip(&mut organs) {
            let (first, count) = (organ.sphere_start, organ.sphere_count);
            let nodes = self.bodies.nodes.range(first, count);
            let checksum = Sums::of(nodes, self.bodies.bits.range(first, count)).folded();
            all.word(checksum);
            *organ_hash = checksum.to_le_bytes().into_iter().fold(0, |a, b| a ^ b);
        }
        Digest {
            tools: self.tools_hash().folded(),
            spheres: all.folded(),
            organs,
        }
    }

    fn tools_hash(&self) -> Hash {
        let tool = self.tool;
        let mut hash = Hash::new();
        hash.pose(&tool.world_from_handle);
        hash.pose(&tool.world_from_instrument);
        hash.pose(&tool.world_from_camera);
        hash.vector(&tool.force_n);
        hash.vector(&tool.torque_nm);
        hash.float(tool.jaw);
        if tool.opening_n.abs() > 0.0 {
            hash.float(tool.opening_n);
        }
        hash.word(u32::from(tool.instrument as u8));
        hash.word(tool.contact_count);
        hash.word(tool.grasped_count);
        hash.word(self.clips_left);
        for clip in self.clips {
            hash.float(clip.share);
            hash.float(clip.closed);
            hash.vector(&clip.legs);
        }
        hash.word(u32::from(tool.switches.paused));
        hash.word(u32::from(tool.switches.force_enabled));
        if !self.scene.layers.cells.is_empty() {
            hash.word(self.bodies.cells.history());
        }
        self.bodies.sutures.hash_into(&mut hash);
        self.stones.hash_into(self.scene, &mut hash);
        hash
    }
}

/// Checksum of an organ's spheres. A sphere gives four words, one per lane. Each lane has the sum
/// of its words, and the sum of the partial sums (as in Fletcher's checksum). The checksum detects
/// every change of a single word, and nearly every exchange of two words.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sums {
    sum: [u64; 4],
    partial_sums: [u64; 4],
}

impl Sums {
    fn of(nodes: &[Node], bits: &[SphereBits]) -> Self {
        let (mut sum, mut partial_sums) = ([0; 4], [0; 4]);
        for (node, bits) in nodes.iter().zip(bits) {
            let ([a, b], [c, d]) = (node.moved_bits(), node.velocity_bits());
            // The upper half of `d` is the spare lane of the velocity, which is zero. It has room
            // for the sphere's flags.
            sum = add_lanes(sum, [a, b, c, d ^ (bits.0 as u64) << 32]);
            partial_sums = add_lanes(partial_sums, sum);
        }
        Self { sum, partial_sums }
    }

    fn folded(&self) -> u32 {
        let mut hash = Hash::new();
        for lanes in [self.sum, self.partial_sums] {
            for lane in lanes {
                hash.word(lane as u32);
                hash.word((lane >> 32) as u32);
            }
        }
        hash.folded()
    }
}

/// Lane-wise sum.
#[inline(always)]
const fn add_lanes(a: [u64; 4], b: [u64; 4]) -> [u64; 4] {
    let ([a, b, c, d], [e, f, g, h]) = (a, b);
    [
        a.wrapping_add(e),
        b.wrapping_add(f),
        c.wrapping_add(g),
        d.wrapping_add(h),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn row() -> ([Node; 40], [SphereBits; 40]) {
        let mut nodes = [Node::ZERO; 40];
        for (i, node) in (0u8..).zip(&mut nodes) {
            let x = f32::from(i) * 1.0e-3;
            node.put(&Vec3::new(x, 0.01 - x, 0.005), &Vec3::zeros());
        }
        (nodes, [SphereBits::default(); 40])
    }

    #[test]
    fn checksum_detects_any_change_and_an_exchange() {
        let (nodes, bits) = row();
        let sums = Sums::of(&nodes, &bits);
        assert_eq!(sums, Sums::of(&nodes, &bits));
        for i in 0..40 {
            let mut moved = nodes;
            let moved_place_m = moved[i].moved_m() + Vec3::z() * 1.0e-9;
            moved[i].put(&moved_place_m, &Vec3::zeros());
            assert_ne!(sums, Sums::of(&moved, &bits), "sphere {i} is elsewhere");
            let mut burnt = bits;
            burnt[i].0 ^= 1;
            assert_ne!(sums, Sums::of(&nodes, &burnt), "sphere {i} has other bits");
        }
        let mut exchanged = nodes;
        exchanged.swap(3, 17);
        assert_ne!(sums.folded(), Sums::of(&exchanged, &bits).folded());
    }
}
