//! The endoscope follows the work.

use assess::Task;
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use rt_process::rehearsal::{Rehearsal, rehearse};
use shared_mem::message::{CommandMsg, HandMsg};
use shared_mem::scene::SceneFile;
use shared_mem::words::{CapsuleRole, EventKind};
use surgeon::{Seen, Surgeon, Theatre, operate};

use crate::theatre::triangle_bytes;

/// Looks until the operation ends.
const LOOKS: u32 = 2500;
/// Turn of the endoscope at the start, to the left, rad. The triangle then lies at the rim of the
/// picture, or outside it.
const TURNED_RAD: f64 = 0.25;
/// Angle from the middle of the picture beyond which the tip is outside it, rad (`assess`).
const OUTSIDE_RAD: f64 = 0.61;

/// A theatre whose endoscope points aside at the start.
struct Aside<'a, 'b> {
    rehearsal: &'a mut Rehearsal<'b>,
    looks: u32,
    command: Option<CommandMsg>,
    /// Angle between the tip and the middle of the picture at each burn, rad.
    burns_rad: Vec<f64>,
}

/// Angle between the middle of the hook's bent end and the middle of the picture, rad.
fn off_rad(seen: &Seen) -> f64 {
    let tools = &seen.tools;
    let tip = (tools.capsules.iter()).find(|it| it.is(CapsuleRole::Tip));
    let tip = tip.map(|it| [it.a_m, it.b_m].map(|end| Point3::from(end.map(f64::from))));
    let [heel, end] = tip.expect("a hook has a tip");
    let camera = &tools.world_from_camera;
    let [x, y, z, w] = camera.orientation.map(f64::from);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let middle = nalgebra::center(&heel, &end);
    let to = middle - Point3::from(camera.position_m.map(f64::from));
    (turn * -Vector3::z()).angle(&to)
}

impl Theatre for Aside<'_, '_> {
    fn look(&mut self, asked: &HandMsg, seen: &mut Seen) -> bool {
        let mut asked = *asked;
        asked.scope_turned_rad[0] += TURNED_RAD;
        for _ in 0..8 {
            self.rehearsal.tick(&asked, self.command.take());
        }
        seen.at_s += 8e-3;
        *seen.state = *self.rehearsal.state();
        *seen.tools = *self.rehearsal.tools();
        seen.events = self.rehearsal.events();
        if seen.events.iter().any(|it| it.is(EventKind::Burn)) {
            self.burns_rad.push(off_rad(seen));
        }
        self.looks += 1;
        self.looks < LOOKS
    }

    fn command(&mut self, command: CommandMsg) -> Result<(), String> {
        self.command = Some(command);
        Ok(())
    }

    fn tell(&mut self, _: &str) {}
}

/// Without it, the careful surgeon burnt outside the picture for 10 s in patient Ada.
#[test]
fn the_endoscope_turns_to_the_work_before_the_hook_burns() {
    let bytes = triangle_bytes();
    let [scene, own] = [(); 2].map(|()| SceneFile::from_bytes(&bytes).expect("a scene"));
    let burns_rad = rehearse(&scene, |rehearsal| {
        let mut theatre = Aside {
            rehearsal,
            looks: 0,
            command: None,
            burns_rad: Vec::new(),
        };
        let outcome = operate(Surgeon::Careful, Task::Identify, own, &mut theatre);
        assert_eq!(outcome, Ok(()), "the looks end the operation");
        theatre.burns_rad
    })
    .expect("a rehearsal");
    println!("{burns_rad:.2?}");
    assert!(burns_rad.len() > 5, "{burns_rad:?}");
    assert!(
        burns_rad.iter().all(|it| *it < OUTSIDE_RAD),
        "{burns_rad:?}"
    );
}
