//! The first move of a task: clock, metrics and course of a task begin with it.

use shared_mem::message::{PoseMsg, ToolFrame};

use crate::Movement;

/// Movement of instrument or endoscope from rest that counts as a move, m. It is several times the
/// noise of a device.
const MOVED_M: f32 = 2e-3;
/// Turn of instrument or endoscope that counts as a move, rad.
const TURNED_RAD: f32 = 0.035;
/// Change of the jaws' opening that counts as a move.
const JAW: f32 = 0.1;

/// Waits for the first move.
#[derive(Debug, Default)]
pub(super) struct FirstMove {
    rest: Option<Movement>,
    has_moved: bool,
}

impl FirstMove {
    /// Takes the next frame of the tools. True from the first move on.
    pub(super) fn has_come(&mut self, tools: &ToolFrame) -> bool {
        if let (false, Some(now)) = (self.has_moved, Movement::of(tools)) {
            let rest = self.rest.get_or_insert(now);
            self.has_moved = moves(rest, &now);
        }
        self.has_moved
    }
}

fn moves(rest: &Movement, now: &Movement) -> bool {
    let held = [&now.world_from_instrument, &now.world_from_camera];
    let before = [&rest.world_from_instrument, &rest.world_from_camera];
    let pedals = |it: &Movement| it.switches().current();
    let is_moved = |(a, b): (&PoseMsg, &PoseMsg)| {
        distance(a.position_m, b.position_m) > MOVED_M || turn_rad(a, b) > TURNED_RAD
    };
    before.into_iter().zip(held).any(is_moved)
        || (now.jaw - rest.jaw).abs() > JAW
        || now.instrument != rest.instrument
        || pedals(now) != pedals(rest)
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    let squares = a.into_iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f32>().sqrt()
}

/// Angle between two orientations, rad.
fn turn_rad(a: &PoseMsg, b: &PoseMsg) -> f32 {
    let both = a.orientation.into_iter().zip(b.orientation);
    let cos = both.map(|(a, b)| a * b).sum::<f32>().abs().min(1.0);
    2.0 * cos.acos()
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;
    use shared_mem::words::Switches;

    use super::*;

    type Change = fn(&mut ToolFrame);

    fn at_rest() -> ToolFrame {
        ToolFrame {
            world_from_handle: PoseMsg::IDENTITY,
            world_from_instrument: PoseMsg::IDENTITY,
            world_from_camera: PoseMsg::IDENTITY,
            ..ToolFrame::zeroed()
        }
    }

    #[test]
    fn noise_and_waiting_are_no_move_and_everything_that_a_hand_does_is_one() {
        let moves: [(&str, Change); 6] = [
            ("instrument", |it| {
                it.world_from_instrument.position_m[0] = 0.003;
            }),
            ("endoscope", |it| {
                it.world_from_camera.position_m[2] = -0.003;
            }),
            ("roll", |it| {
                it.world_from_instrument.orientation = [0.0, 0.0, 0.05, 0.998_749];
            }),
            ("jaws", |it| it.jaw += 0.3),
            ("instrument in hand", |it| it.instrument = 2),
            ("pedal", |it| it.switches |= Switches::CUT.bits()),
        ];
        for (what, change) in moves {
            let mut first = FirstMove::default();
            for noise in 0..200 {
                let mut frame = at_rest();
                frame.world_from_instrument.position_m[1] = if noise % 2 == 0 { 6e-4 } else { 0.0 };
                assert!(!first.has_come(&frame), "{what}");
            }
            let mut moved = at_rest();
            change(&mut moved);
            assert!(first.has_come(&moved), "{what}");
            assert!(first.has_come(&at_rest()), "{what}: it has begun");
        }
    }
}
