//! Residue that an operation leaves on the instrument: char on the electrode, blood and bile on the
//! jaws.

use glam::Vec3;
use shared_mem::message::ToolFrame;
use shared_mem::words::CapsuleRole;

use super::fluid::Fluids;
use super::{Effect, Kind, Source};

/// Time in which a full current chars a clean electrode completely, s.
const CHARRED_S: f32 = 5.0;
/// Distance from the electrode's axis, m, within which burnt tissue chars the electrode.
const OWN_M: f32 = 0.006;
/// Distance from a source within which its blood or bile wets the jaws, m.
const MOUTH_M: f32 = 0.008;
/// Time in which a source of strength 1 wets the jaws completely, s.
const WETTED_S: f32 = 1.5;
/// Strength of a source that wets the jaws as fast as one drop near them.
const DROP: f32 = 0.3;
/// Distance from the axis of a jaw, m, within which a drop's surface wets the jaws.
const DROP_M: f32 = 0.002;
/// Largest number of capsules of a working end that are kept.
const JAWS: usize = 3;

/// Shares of the working end that are covered: 0 is clean, 1 is covered completely. A change of the
/// instrument resets all shares to 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wear {
    /// Share covered by char.
    pub charred: f32,
    /// Share covered by blood.
    pub bloody: f32,
    /// Share covered by bile.
    pub bilious: f32,
    instrument: u32,
    /// Both ends of each capsule of the working end, world frame, m.
    jaws: [Option<[Vec3; 2]>; JAWS],
}

impl Wear {
    /// Takes the present instrument and the place of its working end. A newly taken instrument is
    /// clean.
    pub(super) fn hold(&mut self, tools: &ToolFrame) {
        if tools.instrument != self.instrument {
            *self = Self {
                instrument: tools.instrument,
                ..Self::default()
            };
        }
        let ends = |at: [f32; 3]| Vec3::from(at);
        let capsules = tools.capsules().unwrap_or(&[]).iter();
        let mut jaws = capsules
            .filter(|it| !it.is(CapsuleRole::Shaft))
            .map(|it| [ends(it.a_m), ends(it.b_m)]);
        self.jaws = core::array::from_fn(|_| jaws.next());
    }

    /// Chars the electrode if a new effect burns tissue near it.
    pub(super) fn begin(&mut self, effect: &Effect) {
        if effect.kind == Kind::Char && self.off(effect.at_m) < OWN_M {
            let more = effect.strength * effect.lasts_s / CHARRED_S;
            self.charred = (self.charred + more.max(0.0)).min(1.0);
        }
    }

    /// Advances by `seconds`. Sources and drops near the jaws wet them.
    pub(super) fn step(&mut self, seconds: f32, sources: &[Source], fluids: &Fluids) {
        if self.jaws[0].is_none() {
            return;
        }
        for kind in [Kind::Blood, Kind::Bile] {
            let flows = sources.iter().filter(|it| it.effect.kind == kind);
            let near = flows.filter(|it| self.off(it.effect.at_m) < MOUTH_M);
            let much: f32 = near.map(|it| it.effect.strength).sum();
            let drops = fluids.drops().filter(|it| it.kind == kind);
            let met = drops.filter(|it| self.off(it.at_m) < DROP_M + it.radius_m());
            let more = (much + met.count() as f32 * DROP) * seconds / WETTED_S;
            let film = match kind {
                Kind::Blood => &mut self.bloody,
                _ => &mut self.bilious,
            };
            *film = (*film + more.max(0.0)).min(1.0);
        }
    }

    /// Distance of a point from the axis of the nearest jaw, m.
    fn off(&self, at: Vec3) -> f32 {
        let off = |[a, b]: &[Vec3; 2]| {
            let along = *b - *a;
            let share = (at - *a).dot(along) / along.length_squared().max(1e-12);
            at.distance(*a + along * share.clamp(0.0, 1.0))
        };
        let jaws = self.jaws.iter().flatten();
        jaws.map(off).fold(f32::INFINITY, f32::min)
    }
}
