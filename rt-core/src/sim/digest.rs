//! What a tick leaves of itself, in eight bytes: two runs with the same inputs agree in it.
//!
//! Hashing all spheres takes longer than a tick has to spare, so each tick hashes [`WINDOW`] of
//! them, organ by organ; after at most 79 ticks ([`crate::capacity::MAX_SPHERES`], and a rest for each
//! organ) every sphere had its turn.

use crate::capacity::{MAX_ORGANS, MAX_SPHERES};
use crate::hash::Hash;
use crate::scene::Scene;
use crate::sim::TickView;

/// Spheres of one organ that a tick hashes.
const WINDOW: u32 = 64;

const _: () = assert!(MAX_SPHERES / WINDOW as usize + MAX_ORGANS - 1 == 79);

/// Hashes of what a tick computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Digest {
    /// Of the tools: poses, jaw, force and torque on the hand, counts, switches; and of what was done to
    /// cells of layered tissue.
    pub tools: u32,
    /// Of the spheres whose turn it was: where they are, how fast, and their bits.
    pub spheres: u32,
    /// Their organ; none in a scene without organs.
    pub organ: Option<u8>,
}

impl TickView<'_> {
    /// What to compare with another run of the same inputs. Costs as much as hashing 64 spheres.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let turn = turn(self.scene, self.tick);
        let mut spheres = Hash::new();
        if let Some(Turn { first, count, .. }) = turn {
            let nodes = self.bodies.nodes.range(first, count).iter();
            for (node, bits) in nodes.zip(self.bodies.bits.range(first, count)) {
                spheres.vector(&node.moved_m());
                spheres.vector(&node.velocity_m_s());
                spheres.word(u32::from(bits.0));
            }
        }
        Digest {
            tools: self.tools_hash().folded(),
            spheres: spheres.folded(),
            organ: turn.map(|turn| turn.organ),
        }
    }

    fn tools_hash(&self) -> Hash {
        let tool = self.tool;
        let mut hash = Hash::new();
        hash.pose(&tool.world_from_handle);
        hash.pose(&tool.world_from_instrument);
        hash.pose(&tool.world_from_camera);
        hash.vector(&tool.force_n);
        hash.vector(&tool.torque_n_m);
        hash.float(tool.jaw);
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
        hash
    }
}

/// Spheres `first` to `first + count`, all of one organ.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    organ: u8,
    first: u32,
    count: u32,
}

/// Whose turn it is in `tick`.
fn turn(scene: &Scene<'_>, tick: u64) -> Option<Turn> {
    let windows = |count: u32| count.div_ceil(WINDOW);
    let all: u32 = scene.organs.iter().map(|it| windows(it.sphere_count)).sum();
    let mut window = tick.checked_rem(u64::from(all))? as u32;
    for (organ, record) in (0u8..).zip(scene.organs) {
        let own = windows(record.sphere_count);
        if window < own {
            let done = window * WINDOW;
            return Some(Turn {
                organ,
                first: record.sphere_start + done,
                count: (record.sphere_count - done).min(WINDOW),
            });
        }
        window -= own;
    }
    None
}
