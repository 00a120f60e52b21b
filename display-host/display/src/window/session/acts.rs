//! Acts of instructors. The station's window shows them, and an instructor's window asks for them.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{Vec2, Vec3};
use shared_mem::message::{ActMsg, ActReply, SphereState, StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::service::ACT_PATIENCE;
use shared_mem::words::ActKind;

use super::Session;
use crate::render::camera::Scope;
use crate::ui::{ActsReader, ActsView};
use crate::words::Words;

/// Distance of a mark behind which nothing lies, from the endoscope's lens, m.
const NOWHERE_M: f32 = 0.08;
/// Largest distance from a mark to the centre of the sphere with which it moves, m.
const TISSUE_M: f32 = 0.02;

/// An instructor's mark, which moves with the tissue at which the instructor pointed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StuckMark {
    /// Place at which the instructor pointed, world frame, m.
    asked_m: Vec3,
    /// The nearest sphere and its centre then, m; `None` if no tissue is near.
    to: Option<(usize, Vec3)>,
}

impl StuckMark {
    fn at(asked_m: Vec3, spheres: &[SphereState]) -> Self {
        let is_there = |it: &(usize, &SphereState)| it.1.bits & SphereState::GONE == 0;
        let spheres = spheres.iter().enumerate().filter(is_there);
        let centres = spheres.map(|(number, it)| (number, Vec3::from(it.center_m)));
        let far_m = |it: &(usize, Vec3)| it.1.distance(asked_m);
        let nearest = centres.min_by(|a, b| far_m(a).total_cmp(&far_m(b)));
        Self {
            asked_m,
            to: nearest.filter(|it| far_m(it) < TISSUE_M),
        }
    }

    /// Present place, world frame, m.
    fn now_m(&self, spheres: &[SphereState]) -> Vec3 {
        let moved = self.to.and_then(|(number, then_m)| {
            let now_m = Vec3::from(spheres.get(number)?.center_m);
            Some(now_m - then_m)
        });
        self.asked_m + moved.unwrap_or_default()
    }
}

impl Session {
    /// Shows these acts.
    pub(in crate::window) fn with_acts(mut self, acts: Option<Arc<Mutex<ActsView>>>) -> Self {
        self.acts = acts;
        self
    }

    /// Takes the newest acts.
    pub(super) fn receive_acts(&mut self) {
        if let Some(acts) = &self.acts {
            self.ui.acts = acts.lock().unwrap_or_else(PoisonError::into_inner).clone();
        } else if let Some((_, done)) = &self.desk {
            let now_s = self.start.elapsed().as_secs_f64();
            self.ui.acts = ActsView::at(done, now_s, ActsReader::Instructor);
        }
        // The trainee may have ended the pause. In a replay, the viewer pauses, not an instructor.
        if self.replay.is_none() {
            let paused = self.ui.is_paused();
            let lasts = self.pause_note.tells(self.ui.acts.pauses, paused);
            let is_over = |notice: &mut (ActKind, _)| notice.0 == ActKind::Pause && !lasts;
            self.ui.acts.notice.take_if(is_over);
        }
    }

    /// True if an instructor fogged the lens since the last call.
    pub(in crate::window) fn takes_fog(&mut self) -> bool {
        let fogs = self.ui.acts.fogs;
        core::mem::replace(&mut self.fogs, fogs) < fogs
    }

    /// Places the instructor's mark in the picture.
    pub(super) fn mark_acts(&mut self, scope: &Scope) {
        let spheres = self.feed.state().and_then(StateFrame::spheres);
        let spheres = spheres.unwrap_or(&[]);
        let at_m = self.ui.acts.mark.map(Vec3::from);
        if self.mark.map(|it| it.asked_m) != at_m {
            self.mark = at_m.map(|at_m| StuckMark::at(at_m, spheres));
        }
        let tools = self.feed.tools().map(|it| self.seen_tools(it));
        self.ui.act_mark = tools.zip(self.mark).and_then(|(tools, mark)| {
            let camera = scope.world_from_view(&tools).inverse();
            scope.project(camera.transform_point3(mark.now_m(spheres)))
        });
    }

    /// Asks the station to point at what lies at this place of the picture.
    pub(super) fn point(&mut self, [x, y]: [f32; 2], scene: &SceneFile) {
        let moment = self.moment();
        let at = moment.and_then(|it| found(it, scene, &self.scope, Vec2::new(x, y)));
        if let Some(at_m) = at {
            self.act(ActMsg::point(at_m.to_array()));
        }
    }

    /// Asks the station for an act, and keeps the answer for the panel.
    pub(super) fn act(&mut self, act: ActMsg) {
        let Some((sender, done)) = &mut self.desk else {
            return;
        };
        // The instructor's picture waits as well.
        let outcome = sender.ask(act, ACT_PATIENCE).ok();
        if outcome.is_some_and(ActReply::is_recorded) {
            done.push((self.start.elapsed().as_secs_f64(), act));
            let is_remark = act.kind() == Ok(ActKind::Remark);
            self.ui.saved_remarks += usize::from(is_remark);
        }
        let text = answer(&self.ui.words, outcome);
        self.ui.act_answer = Some((text, outcome == Some(ActReply::DONE)));
    }
}

/// Place of the nearest sphere under a place of the picture, world frame, m. Spheres of removed
/// tissue do not count. `None` outside the endoscope's circle.
fn found(
    (state, tools): (&StateFrame, &ToolFrame),
    scene: &SceneFile,
    scope: &Scope,
    at: Vec2,
) -> Option<Vec3> {
    let world_from_view = scope.world_from_view(tools);
    let eye = world_from_view.transform_point3(Vec3::ZERO);
    let along = world_from_view.transform_vector3(scope.direction(at)?);
    let spheres = state.spheres().unwrap_or(&[]).iter().zip(scene.spheres());
    let is_there = |it: &(&SphereState, _)| it.0.bits & SphereState::GONE == 0;
    let hits = spheres.filter(is_there).filter_map(|(now, rest)| {
        let to = Vec3::from(now.center_m) - eye;
        let near_m = to.dot(along);
        let off2 = to.length_squared() - near_m * near_m;
        let half2 = rest.radius_m * rest.radius_m - off2;
        (near_m > 0.0 && half2 > 0.0).then(|| near_m - half2.sqrt())
    });
    let far_m = hits.min_by(f32::total_cmp).unwrap_or(NOWHERE_M);
    Some(eye + along * far_m)
}

/// Text of the station's answer. `None`: no answer.
fn answer(words: &Words, outcome: Option<u32>) -> String {
    words.say(match outcome {
        Some(ActReply::DONE) => "act-done",
        Some(ActReply::EXAM) => "act-refused-exam",
        Some(ActReply::NOTHING) => "act-refused-nothing",
        Some(ActReply::UNRECORDED) => "act-refused-unrecorded",
        Some(ActReply::SILENT) => "act-refused-silent",
        Some(ActReply::UNCERTAIN) => "act-uncertain",
        Some(ActReply::FULL) => "act-refused-full",
        Some(_) => "act-refused-unknown",
        None => "act-refused-nobody",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn a_mark_moves_with_the_tissue_and_stays_where_there_is_none() {
        let sphere = |center_m| SphereState { center_m, bits: 0 };
        let then = [sphere([0.0; 3]), sphere([0.05, 0.0, 0.0])];
        let mark = StuckMark::at(Vec3::new(0.045, 0.003, 0.0), &then);
        assert_eq!(mark.to.map(|it| it.0), Some(1));
        let now = [then[0], sphere([0.05, 0.01, 0.0])];
        let off = mark.now_m(&now) - Vec3::new(0.045, 0.013, 0.0);
        assert!(off.length() < 1e-6, "{off}");
        let nowhere = Vec3::new(0.0, 0.5, 0.0);
        assert_eq!(StuckMark::at(nowhere, &then).now_m(&now), nowhere);
        let gone = SphereState {
            bits: SphereState::GONE,
            ..then[1]
        };
        assert_eq!(StuckMark::at(Vec3::new(0.05, 0.0, 0.0), &[gone]).to, None);
    }

    #[test]
    fn every_answer_is_said_in_every_language() {
        let outcomes = (0..=ActReply::FULL + 1).map(Some).chain([None]);
        let (english, german) = (Words::default(), Words::new(Language::German));
        for outcome in outcomes {
            let said = [&english, &german].map(|words| answer(words, outcome));
            assert_ne!(said[0], said[1]);
            assert!(said.iter().all(|it| !it.starts_with("act-")), "{said:?}");
        }
    }
}
