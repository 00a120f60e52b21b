//! Worked tissue comes to rest when the hand leaves it.

use assess::Task;
use bytemuck::Zeroable as _;
use rt_process::rehearsal::{Rehearsal, rehearse};
use shared_mem::message::{CommandMsg, HandMsg};
use surgeon::{Seen, Surgeon, Theatre, operate};

use crate::theatre;

/// Ticks between two looks.
const LOOK_EVERY: u64 = 8;
/// Ticks for which the surgeon works: it has pushed ducts and arteries through the fat by then.
const WORK_TICKS: u64 = 12_000;
/// Looks until the instrument is out, and until the speeds are read.
const OUT_LOOKS: u64 = 125;
const REST_LOOKS: u64 = 725;
/// Looks over which the speeds are read.
const READ_LOOKS: u64 = 25;
/// Largest speed of tissue at rest, mm/s.
const REST_MM_S: f32 = 3.0;

/// A theatre that the surgeon must leave after a while.
struct Brief<'a, 'b> {
    rehearsal: &'a mut Rehearsal<'b>,
    asked: HandMsg,
    command: Option<CommandMsg>,
}

impl Brief<'_, '_> {
    fn ticks(&mut self, asked: HandMsg) {
        for _ in 0..LOOK_EVERY {
            self.rehearsal.tick(&asked, self.command.take());
        }
        self.asked = asked;
    }

    fn centers_m(&self) -> Vec<[f32; 3]> {
        let spheres = self.rehearsal.state().spheres().expect("a sound frame");
        spheres.iter().map(|it| it.center_m).collect()
    }
}

impl Theatre for Brief<'_, '_> {
    fn look(&mut self, asked: &HandMsg, seen: &mut Seen) -> bool {
        self.ticks(*asked);
        seen.at_s = self.rehearsal.ticks() as f64 * 1e-3;
        *seen.state = *self.rehearsal.state();
        *seen.tools = *self.rehearsal.tools();
        seen.events = self.rehearsal.events();
        self.rehearsal.ticks() < WORK_TICKS
    }

    fn command(&mut self, command: CommandMsg) -> Result<(), String> {
        self.command = Some(command);
        Ok(())
    }

    fn look_off(&mut self, _: [f32; 2]) -> bool {
        true
    }

    fn tell(&mut self, _: &str) {}
}

/// Distance, m.
fn away_m(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f32>().sqrt()
}

#[test]
fn patients_ducts_and_fat_rest_after_work() {
    let scene = theatre::patient("berta");
    let own = theatre::patient("berta");
    let fastest_mm_s = rehearse(&scene, |rehearsal| {
        let mut brief = Brief {
            rehearsal,
            asked: HandMsg::zeroed(),
            command: theatre::start(Task::Identify).map(|argument| CommandMsg {
                kind: CommandMsg::START,
                argument: argument.into(),
            }),
        };
        operate(Surgeon::Careful, Task::Identify, own, &mut brief).expect("a controller");
        let mut asked = HandMsg {
            buttons: 0,
            switches: 0,
            ..brief.asked
        };
        let mut before = brief.centers_m();
        let mut fastest_mm_s = 0.0f32;
        for look in 0..REST_LOOKS + READ_LOOKS {
            if look < OUT_LOOKS {
                asked.moved_m[2] += 0.1 / OUT_LOOKS as f64;
            }
            brief.ticks(asked);
            let now = brief.centers_m();
            if look >= REST_LOOKS {
                let moved_m = now.iter().zip(&before).map(|(a, b)| away_m(a, b));
                let moved_mm = moved_m.fold(0.0, f32::max) * 1e3;
                fastest_mm_s = fastest_mm_s.max(moved_mm / (LOOK_EVERY as f32 * 1e-3));
            }
            before = now;
        }
        fastest_mm_s
    });
    let fastest_mm_s = fastest_mm_s.expect("the core takes it");
    assert!(fastest_mm_s < REST_MM_S, "{fastest_mm_s} mm/s after 5 s");
}
