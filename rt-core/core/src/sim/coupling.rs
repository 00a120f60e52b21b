//! Constraints of tools, clips and contacts between organs, applied in each substep.

use crate::contact::tool_contact::ToolContacts;
use crate::math::Pose;
use crate::organs::between::Between;
use crate::procedure::clip::Clips;
use crate::procedure::grasp::Grasp;
use crate::scene::Scene;
use crate::tissue::Bodies;
use crate::tissue::substeps::Coupling;

/// Constraints that act on an organ from outside in a substep.
pub(super) struct OuterConstraints<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) jaws: &'a Pose,
    pub(super) between: &'a mut Between,
    pub(super) contacts: &'a mut ToolContacts,
    pub(super) clips: &'a mut Clips,
    pub(super) grasp: &'a mut Grasp,
}

impl Coupling for OuterConstraints<'_> {
    fn pre_solve(&mut self, organ: u8, step_s: f32, bodies: &mut Bodies) {
        self.contacts.pre_solve(organ, step_s, bodies);
    }

    fn couple(&mut self, now: u32, bodies: &mut Bodies) {
        self.between.press_due(now, self.scene, bodies);
    }

    fn post_solve(&mut self, organ: u8, share: f32, step_s: f32, bodies: &mut Bodies) {
        self.clips.carry(Some(organ), self.scene, bodies);
        self.grasp
            .carry(Some(organ), share, self.jaws, self.scene, bodies);
        self.contacts.post_solve(organ, share, step_s, bodies);
    }
}
