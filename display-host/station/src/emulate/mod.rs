//! `calot emulate`.

mod lead;

use std::process::ExitCode;

use hardware::emulate::{EmulateConfig, HandScript};
use rt_core::math::{Pose, Quat, Vec3};
use rt_process::realtime;
use shared_mem::message::PoseMsg;
use shared_mem::scene::{RoomRecord, SceneFile};

use crate::children::READY;
use crate::cli::EmulateArgs;
use crate::say;
use crate::scene::Problem;
use crate::stop;

/// `SCHED_FIFO` priority of the emulated devices: below the tick's, should they share its core.
const EMULATOR_PRIORITY: u8 = 70;

/// Emulates the devices until told to end.
pub(crate) fn run(args: &EmulateArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    let scene = SceneFile::open(&args.scene)?;
    let config = EmulateConfig {
        directory: args.dir.clone(),
        script: script(scene.room()),
        seed: args.seed,
        haptic: hardware::emulate::HapticModel::default(),
        faults: hardware::emulate::LineFaults::default(),
    };
    // A device has a processor of its own. Where Linux refuses that, it is a slower device.
    let cores = realtime::allowed_cores();
    let tick_core = cores.last().copied().unwrap_or(0);
    let _ = realtime::work_beside_tick(&cores, tick_core, EMULATOR_PRIORITY);
    let mut lead = lead::Lead::new(args)?;
    hardware::emulate::run_led(&config, &stop, &mut || lead.wish(), &mut |lines| {
        say::answer(format_args!(
            "{READY} {} {} {}",
            lines.haptic.display(),
            lines.tracker.display(),
            lines.pedal.display()
        ));
    })?;
    Ok(ExitCode::SUCCESS)
}

/// The hand works where the scene says.
fn script(room: &RoomRecord) -> HandScript {
    HandScript {
        instrument_port_m: Vec3::from(room.instrument_port_m),
        instrument_length_m: room.instrument_length_m,
        world_from_device: pose(&room.world_from_device),
        world_from_tracker: pose(&room.world_from_tracker),
        world_from_camera: pose(&room.world_from_camera),
        endoscope_port_m: Vec3::from(room.endoscope_port_m),
        target_m: Vec3::from(room.target_m),
        target_normal: Vec3::from(room.target_normal),
    }
}

fn pose(message: &PoseMsg) -> Pose {
    let [x, y, z, w] = message.orientation;
    let rotation = Quat::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    Pose::from_parts(Vec3::from(message.position_m).into(), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_keeps_its_order_of_components() {
        let quarter = core::f32::consts::FRAC_1_SQRT_2;
        let message = PoseMsg {
            position_m: [1.0, 2.0, 3.0],
            orientation: [0.0, 0.0, quarter, quarter],
        };
        let moved = pose(&message) * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!(
            (moved - nalgebra::Point3::new(1.0, 3.0, 3.0)).norm() < 1e-6,
            "{moved}"
        );
    }
}
