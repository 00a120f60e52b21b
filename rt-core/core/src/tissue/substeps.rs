//! Advances all organs through a tick, each in its own number of substeps.

use crate::capacity::MAX_ORGANS;
use crate::scene::{Organ, Scene};
use crate::tissue::{Bodies, Solver, attachment};

/// External constraints on organs: tools, clips, and other organs.
pub(crate) trait Coupling {
    /// Called in each substep of this organ, before its constraints.
    fn pre_solve(&mut self, organ: u8, step_s: f32, bodies: &mut Bodies);
    /// Projects the constraints between organs that are due. `now` is the index of the finest
    /// substep within the tick.
    fn couple(&mut self, _now: u32, _bodies: &mut Bodies) {}
    /// Called after the constraints of each substep of this organ except the last of the tick.
    /// `share` is the share of the tick that has passed when the substep ends.
    fn post_solve(&mut self, organ: u8, share: f32, step_s: f32, bodies: &mut Bodies);
}

/// Advances every organ of `moves` through the tick. The caller ends the last substep: it applies
/// the couplings, then calls `Bodies::advance`. Returns the number of spheres that were quarantined
/// (reset to their last place).
pub(crate) fn run(
    scene: &Scene<'_>,
    solver: &mut impl Solver,
    moves: &[bool; MAX_ORGANS],
    coupling: &mut impl Coupling,
    bodies: &mut Bodies,
) -> u32 {
    let finest = scene.finest();
    let mut quarantined = 0;
    for now in 0..finest {
        for (i, organ, length) in moving(scene, moves, finest) {
            if now.is_multiple_of(length) {
                let step_s = scene.step_s_of(i);
                bodies.predict(scene, organ, step_s);
                coupling.pre_solve(i, step_s, bodies);
                solver.project(scene, organ, step_s, bodies);
            }
        }
        let due = moving(scene, moves, finest).filter(|(.., length)| now.is_multiple_of(*length));
        solver.project_links(scene, due.map(|(i, ..)| i), bodies);
        attachment::project_due(scene, now, bodies);
        coupling.couple(now, bodies);
        let ended = now + 1;
        for (i, organ, length) in moving(scene, moves, finest) {
            if !ended.is_multiple_of(length) {
                continue;
            }
            bodies.store_steps_before_tools(organ);
            if ended < finest {
                let step_s = scene.step_s_of(i);
                let share = ended as f32 / finest as f32;
                coupling.post_solve(i, share, step_s, bodies);
                quarantined += bodies.advance(scene, organ, step_s);
            }
        }
    }
    quarantined
}

/// Organs that move, each with its index and the length of its substep in units of the finest
/// substep.
fn moving<'a>(
    scene: &'a Scene<'_>,
    moves: &'a [bool; MAX_ORGANS],
    finest: u32,
) -> impl Iterator<Item = (u8, &'a Organ, u32)> {
    let all = (0u8..).zip(scene.organs).zip(moves);
    let length = all.filter(|(_, moves)| **moves);
    length.map(move |((i, organ), _)| (i, organ, (finest / organ.substeps.max(1)).max(1)))
}
