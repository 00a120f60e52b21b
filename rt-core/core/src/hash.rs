//! Hash of bit patterns: two runs with equal inputs have equal hashes.

use crate::math::{Pose, Vec3};

/// FNV-1a with 64 bits, fed with 32 bits at a time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hash(u64);

impl Hash {
    pub(crate) const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub(crate) const fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ word as u64).wrapping_mul(0x0000_0100_0000_01b3);
    }

    pub(crate) const fn float(&mut self, x: f32) {
        self.word(x.to_bits());
    }

    pub(crate) fn vector(&mut self, v: &Vec3) {
        self.float(v.x);
        self.float(v.y);
        self.float(v.z);
    }

    pub(crate) fn pose(&mut self, pose: &Pose) {
        self.vector(&pose.translation.vector);
        let q = &pose.rotation.coords;
        self.vector(&Vec3::new(q.x, q.y, q.z));
        self.float(q.w);
    }

    /// The upper and the lower half, combined by exclusive or.
    pub(crate) const fn folded(self) -> u32 {
        (self.0 >> 32) as u32 ^ self.0 as u32
    }

    pub(crate) const fn finish(self) -> u64 {
        self.0
    }
}
