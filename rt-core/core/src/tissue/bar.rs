//! Elastic link between two spheres (XPBD, Macklin 2016): `C = |p1 − p2| − L` with compliance.

use crate::math;
use crate::tissue::Node;
use crate::tissue::lanes::Lanes;
use crate::tissue::per_sphere::PerSphere;

/// Elastic parameters of a link in one substep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bar {
    /// Length at rest, m.
    pub(crate) rest_length_m: f32,
    /// Stretch per force, m/N.
    pub(crate) compliance_m_n: f32,
    /// Length of the substep, s.
    pub(crate) step_s: f32,
}

impl Bar {
    /// Displacement per inverse mass of an end at `difference` from the other, m kg. The inverse
    /// masses sum to `weight_sum`. Coincident ends have no direction and are left alone.
    #[inline(always)]
    pub(crate) fn push(&self, difference: Lanes, weight_sum: f32) -> Lanes {
        let length = math::sqrt(difference.norm_squared());
        self.damped_push(difference, length, weight_sum, 0.0, length)
    }

    /// As [`Bar::push`], for a bar of this length that was `last_m` long after its last projection.
    /// `rate` is the retardation time over the substep: weight of the strain rate relative to the
    /// strain.
    #[inline(always)]
    fn damped_push(
        &self,
        difference: Lanes,
        length_m: f32,
        weight_sum: f32,
        rate: f32,
        last_m: f32,
    ) -> Lanes {
        let softness = self.compliance_m_n / (self.step_s * self.step_s);
        let resistance = (1.0 + rate) * weight_sum + softness;
        let is_known = length_m > 1.0e-9 && resistance > 0.0;
        if !is_known {
            return Lanes::ZERO;
        }
        let error = length_m - self.rest_length_m + rate * (length_m - last_m);
        difference.scaled(-error / (resistance * length_m))
    }

    /// Projects the bar between two spheres. `last_m` is its length after its last projection, and
    /// becomes that after this one.
    #[inline(always)]
    pub(crate) fn project(
        &self,
        nodes: &mut PerSphere<Node>,
        [i, j]: [u32; 2],
        rate: f32,
        last_m: &mut f32,
    ) {
        let (a, b) = (*nodes.at(i), *nodes.at(j));
        let (wa, wb) = (a.inverse_mass_per_kg(), b.inverse_mass_per_kg());
        let difference = a.from(&b);
        let length_m = math::sqrt(difference.norm_squared());
        let push = self.damped_push(difference, length_m, wa + wb, rate, *last_m);
        *last_m = math::sqrt((difference + push.scaled(wa + wb)).norm_squared());
        nodes.at_mut(i).step_m = a.step_m + push.scaled(wa);
        nodes.at_mut(j).step_m = b.step_m - push.scaled(wb);
    }
}
