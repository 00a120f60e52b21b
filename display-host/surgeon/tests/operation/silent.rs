//! A surgeon whose haptic device falls silent.

use rt_process::rehearsal::{Rehearsal, rehearse};
use shared_mem::message::{CommandMsg, DeviceHealth, HandMsg};
use shared_mem::scene::SceneFile;
use surgeon::{Seen, Surgeon, Theatre, operate};

use crate::theatre::triangle_bytes;
use assess::Task;

/// Looks in which the device is silent, and the last look.
const SILENT: std::ops::Range<u32> = 300..500;
const LAST: u32 = 600;

struct Silenced<'a, 'b> {
    rehearsal: &'a mut Rehearsal<'b>,
    looks: u32,
    command: Option<CommandMsg>,
    asked: Vec<HandMsg>,
}

impl Theatre for Silenced<'_, '_> {
    fn look(&mut self, asked: &HandMsg, seen: &mut Seen) -> bool {
        self.asked.push(*asked);
        for _ in 0..8 {
            self.rehearsal.tick(asked, self.command.take());
        }
        seen.at_s += 8e-3;
        *seen.state = *self.rehearsal.state();
        *seen.tools = *self.rehearsal.tools();
        seen.events = self.rehearsal.events();
        if SILENT.contains(&self.looks) {
            seen.tools.health[0].status = DeviceHealth::LOST;
        }
        self.looks += 1;
        self.looks < LAST
    }

    fn command(&mut self, command: CommandMsg) -> Result<(), String> {
        self.command = Some(command);
        Ok(())
    }

    fn tell(&mut self, _: &str) {}
}

/// A hand that moved on would leap to another place when its device returns.
#[test]
fn a_hand_keeps_still_while_its_device_is_silent() {
    let bytes = triangle_bytes();
    let [scene, own] = [(); 2].map(|()| SceneFile::from_bytes(&bytes).expect("a scene"));
    let asked = rehearse(&scene, |rehearsal| {
        let mut theatre = Silenced {
            rehearsal,
            looks: 0,
            command: None,
            asked: Vec::new(),
        };
        let task = Task::Clamp;
        let outcome = operate(Surgeon::Careful, task, own, &mut theatre);
        assert_eq!(outcome, Ok(()), "the looks end the operation");
        assert_eq!(theatre.looks, LAST);
        theatre.asked
    })
    .expect("a rehearsal");
    let moved = |look: u32| asked[look as usize].moved_m.map(f64::to_bits);
    // The silence of a look is known at the next one.
    let silent = || (SILENT.start + 1..=SILENT.end).map(moved);
    let first = moved(SILENT.start + 1);
    assert!(silent().all(|it| it == first));
    assert_ne!(moved(SILENT.start - 100), first, "the hand was at work");
    assert_ne!(moved(LAST - 1), first, "the hand went on");
}
