//! Elastic link between two spheres (XPBD, Macklin 2016): `C = |p1 − p2| − L` with compliance.

use crate::math;
use crate::scene::Link;
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
    /// Retardation time over the substep: weight of the strain rate relative to the strain.
    pub(crate) rate: f32,
    /// Length of the substep, s.
    pub(crate) step_s: f32,
}

impl Bar {
    /// Displacement per inverse mass of an end at `difference` from the other, which has moved by
    /// `step` relative to it in this substep, m kg. The inverse masses sum to `weight_sum`.
    /// Coincident ends have no direction and are left alone.
    #[inline(always)]
    pub(crate) fn push(&self, difference: Lanes, step: Lanes, weight_sum: f32) -> Lanes {
        let length = math::sqrt(difference.norm_squared());
        let softness = self.compliance_m_n / (self.step_s * self.step_s);
        let resistance = (1.0 + self.rate) * weight_sum + softness;
        let is_known = length > 1.0e-9 && resistance > 0.0;
        if !is_known {
            return Lanes::ZERO;
        }
        let direction = difference.scaled(length.recip());
        let error = length - self.rest_length_m + self.rate * direction.dot(step);
        direction.scaled(-error / resistance)
    }
}

/// Projects a link of whose stiffness the share `left` remains, above 0.
#[inline(always)]
pub(crate) fn project(nodes: &mut PerSphere<Node>, link: &Link, left: f32, rate: f32, step_s: f32) {
    let (a, b) = (*nodes.at(link.a), *nodes.at(link.b));
    let (wa, wb) = (a.inverse_mass_per_kg(), b.inverse_mass_per_kg());
    let bar = Bar {
        rest_length_m: link.rest_length_m,
        compliance_m_n: link.compliance_m_n / left,
        rate,
        step_s,
    };
    let push = bar.push(a.from(&b), a.step_m - b.step_m, wa + wb);
    nodes.at_mut(link.a).step_m = a.step_m + push.scaled(wa);
    nodes.at_mut(link.b).step_m = b.step_m - push.scaled(wb);
}
