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
    /// Compliance divided by dt² (`α̃` of XPBD), 1/kg.
    pub(crate) scaled_compliance_per_kg: f32,
}

/// Compliance divided by dt², 1/kg, of a bar whose intact share is `intact`. `per_step_s2` is
/// 1/dt².
#[inline(always)]
pub(crate) fn scaled_compliance_per_kg(compliance_m_n: f32, intact: f32, per_step_s2: f32) -> f32 {
    let softness = compliance_m_n * per_step_s2;
    // A division takes as long as the rest of this function, and few bars are damaged.
    if intact >= 1.0 {
        softness
    } else {
        softness / intact
    }
}

impl Bar {
    /// Positional impulse on one end, m kg. `difference` points to it from the other end, m. The
    /// inverse masses sum to `weight_sum`. Coincident ends have no direction and get no impulse.
    #[inline(always)]
    pub(crate) fn push(&self, difference: Lanes, weight_sum: f32) -> Lanes {
        let length_m = math::sqrt(difference.norm_squared());
        difference.scaled(self.push_factor(length_m, weight_sum, 0.0, length_m))
    }

    /// Positional impulse on one end as a factor on the difference of the ends, kg. `last_length_m`
    /// is the length after the last projection. `rate` is the retardation time divided by the
    /// substep: the weight of the strain rate relative to the strain.
    #[inline(always)]
    fn push_factor(&self, length_m: f32, weight_sum: f32, rate: f32, last_length_m: f32) -> f32 {
        self.push_factor_beyond(0.0, length_m, weight_sum, rate, last_length_m)
    }

    /// The same, if the ends have already felt `kept_m_kg`, the size of an impulse that pushes them
    /// apart.
    #[inline(always)]
    fn push_factor_beyond(
        &self,
        kept_m_kg: f32,
        length_m: f32,
        weight_sum: f32,
        rate: f32,
        last_length_m: f32,
    ) -> f32 {
        let resistance = (1.0 + rate) * weight_sum + self.scaled_compliance_per_kg;
        let is_solvable = length_m > 1.0e-9 && resistance > 0.0;
        if !is_solvable {
            return 0.0;
        }
        let error = length_m - self.rest_length_m
            + rate * (length_m - last_length_m)
            + self.scaled_compliance_per_kg * kept_m_kg;
        -error / (resistance * length_m)
    }

    /// Projects the bar between two spheres. `last_length_m` is its length after the last
    /// projection; the method updates it.
    #[inline(always)]
    pub(crate) fn project(
        &self,
        nodes: &mut PerSphere<Node>,
        [i, j]: [u32; 2],
        rate: f32,
        last_length_m: &mut f32,
    ) {
        let (a, b) = (nodes.at(i), nodes.at(j));
        let (wa, wb) = (a.inverse_mass_per_kg(), b.inverse_mass_per_kg());
        let difference = a.from(b);
        let length_m = math::sqrt(difference.norm_squared());
        let push_factor = self.push_factor(length_m, wa + wb, rate, *last_length_m);
        let push = difference.scaled(push_factor);
        *last_length_m = (length_m + length_m * (push_factor * (wa + wb))).abs();
        let (a, b) = (a.step_m + push.scaled(wa), b.step_m - push.scaled(wb));
        nodes.at_mut(i).step_m = a;
        nodes.at_mut(j).step_m = b;
    }

    /// Projects the bar between two spheres that have already felt `kept_share` of `impulse`, the
    /// bar's impulse in the last substep. The impulse turns with the bar. The method updates
    /// `impulse` (spare lane: its size) and `last_length_m`.
    #[inline(always)]
    pub(crate) fn project_warm(
        &self,
        nodes: &mut PerSphere<Node>,
        [i, j]: [u32; 2],
        rate: f32,
        kept_share: f32,
        (last_length_m, impulse): (&mut f32, &mut Lanes),
    ) {
        let (a, b) = (nodes.at(i), nodes.at(j));
        let (wa, wb) = (a.inverse_mass_per_kg(), b.inverse_mass_per_kg());
        let difference = a.from(b);
        let length_m = math::sqrt(difference.norm_squared());
        let kept_m_kg = kept_share * impulse.spare();
        let more =
            length_m * self.push_factor_beyond(kept_m_kg, length_m, wa + wb, rate, *last_length_m);
        let push_m_kg = kept_m_kg + more;
        let now = difference.scaled(push_m_kg / length_m.max(1.0e-9));
        let change = now - impulse.scaled(kept_share);
        *last_length_m = (length_m + more * (wa + wb)).abs();
        *impulse = now.with_spare(push_m_kg);
        let (a, b) = (a.step_m + change.scaled(wa), b.step_m - change.scaled(wb));
        nodes.at_mut(i).step_m = a;
        nodes.at_mut(j).step_m = b;
    }
}
