//! Worked tissue comes to rest when the hand leaves it, and when the hand stays and keeps still.

use assess::Task;
use bytemuck::Zeroable as _;
use rt_process::rehearsal::{Rehearsal, rehearse};
use shared_mem::message::{CommandMsg, HandMsg};
use surgeon::{Seen, Surgeon, Theatre, operate};

use crate::theatre;

/// Ticks between two looks.
const LOOK_EVERY: u64 = 8;
/// Length of a look, s.
const LOOK_S: f32 = LOOK_EVERY as f32 * 1e-3;

/// Course of the hand, and the looks at the end over which the speeds are read.
struct Course {
    patient: &'static str,
    /// Ticks for which the surgeon works.
    work_ticks: u64,
    /// Looks until the instrument is out; 0: it stays where it is.
    out_looks: u64,
    /// Looks until the speeds are read.
    rest_looks: u64,
    read_looks: u64,
}

/// The largest values at the end.
#[derive(Debug)]
struct Read {
    speed_mm_s: f32,
    /// Difference of the largest and the smallest force, N.
    force_swing_n: f32,
}

/// A theatre that the surgeon must leave after a while.
struct Brief<'a, 'b> {
    rehearsal: &'a mut Rehearsal<'b>,
    asked: HandMsg,
    command: Option<CommandMsg>,
    work_ticks: u64,
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
        self.rehearsal.ticks() < self.work_ticks
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

impl Course {
    fn run(&self) -> Read {
        let scene = theatre::patient(self.patient);
        let own = theatre::patient(self.patient);
        let read = rehearse(&scene, |rehearsal| {
            let mut brief = Brief {
                rehearsal,
                asked: HandMsg::zeroed(),
                command: theatre::start(Task::Identify).map(|argument| CommandMsg {
                    kind: CommandMsg::START,
                    argument: argument.into(),
                }),
                work_ticks: self.work_ticks,
            };
            operate(Surgeon::Careful, Task::Identify, own, &mut brief).expect("a controller");
            self.leave(&mut brief)
        });
        read.expect("the core takes it")
    }

    fn leave(&self, brief: &mut Brief<'_, '_>) -> Read {
        let mut asked = HandMsg {
            buttons: 0,
            switches: 0,
            ..brief.asked
        };
        let mut before = brief.centers_m();
        let (mut speed_mm_s, mut forces_n) = (0.0f32, [f32::MAX, 0.0]);
        for look in 0..self.rest_looks + self.read_looks {
            if look < self.out_looks {
                asked.moved_m[2] += 0.1 / self.out_looks as f64;
            }
            brief.ticks(asked);
            let now = brief.centers_m();
            if look >= self.rest_looks {
                let moved_m = now.iter().zip(&before).map(|(a, b)| away_m(a, b));
                let moved_mm = moved_m.fold(0.0, f32::max) * 1e3;
                speed_mm_s = speed_mm_s.max(moved_mm / LOOK_S);
                let force_n = away_m(&brief.rehearsal.tools().force_n, &[0.0; 3]);
                forces_n = [forces_n[0].min(force_n), forces_n[1].max(force_n)];
            }
            before = now;
        }
        Read {
            speed_mm_s,
            force_swing_n: forces_n[1] - forces_n[0],
        }
    }
}

/// By 12 s the surgeon has pushed ducts and arteries through the fat.
#[test]
fn patients_ducts_and_fat_rest_after_work() {
    let course = Course {
        patient: "berta",
        work_ticks: 12_000,
        out_looks: 125,
        rest_looks: 725,
        read_looks: 25,
    };
    let read = course.run();
    assert!(read.speed_mm_s < 3.0, "{read:?} after 5 s");
}

/// The hook stands still in the fat at the cystic duct. If contact takes the far side of a thin
/// lobe for the near one, it pulls the lobe over the hook again and again: 2 m/s and 35 mN without
/// end.
#[test]
fn patients_tissue_rests_around_a_still_hook() {
    let course = Course {
        patient: "ada",
        work_ticks: 8_000,
        out_looks: 0,
        rest_looks: 188,
        read_looks: 62,
    };
    let read = course.run();
    assert!(
        read.speed_mm_s < 10.0 && read.force_swing_n < 0.005,
        "{read:?} after 1.5 s"
    );
}
