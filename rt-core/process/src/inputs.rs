//! Conversion between a tick's inputs and their record, which recorders receive.

use nalgebra::{Quaternion, Unit};
use rt_core::math::{Pose, Vec3};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, Opening, PedalSample, Polled, TrackerSample,
};
use rt_core::scene::{Room, TrocarChoice};
use rt_core::sim::{Command, Complication, Digest, Parameters, Samples, Task};
use rt_core::tool::Instrument;
use shared_mem::inputs::{InputRecord, RunSetup};
use shared_mem::message::{CommandMsg, PoseMsg};
use shared_mem::words;

/// Record of `samples`; [`seal`] adds the tick's number and the digest of its results.
pub(crate) fn record(samples: &Samples) -> InputRecord {
    let mut record: InputRecord = bytemuck::Zeroable::zeroed();
    record.now_ns = samples.now_ns;
    match &samples.device {
        Polled::Fresh(sample) => {
            record.bits |= InputRecord::DEVICE_FRESH;
            record.device_at_ns = sample.at_ns;
            record.device_from_handle = message(&sample.device_from_handle);
            record.sequence = sample.sequence;
            record.buttons = sample.buttons.0;
            if let Some(velocity_m_s) = sample.velocity_m_s {
                record.bits |= InputRecord::HAS_VELOCITY;
                record.velocity_m_s = velocity_m_s.into();
            }
            if let Some(opening) = sample.opening {
                record.bits |= InputRecord::HAS_OPENING;
                record.opening = opening;
            }
        }
        Polled::Nothing => {}
        Polled::Lost => record.bits |= InputRecord::DEVICE_LOST,
    }
    match &samples.tracker {
        Polled::Fresh(sample) => {
            record.bits |= InputRecord::TRACKER_FRESH;
            record.tracker_at_ns = sample.at_ns;
            record.tracker_from_sensor = message(&sample.tracker_from_sensor);
        }
        Polled::Nothing => {}
        Polled::Lost => record.bits |= InputRecord::TRACKER_LOST,
    }
    match &samples.pedal {
        Polled::Fresh(sample) => {
            let bit = |on: bool, bit: u32| u32::from(on) * bit;
            record.bits |= InputRecord::PEDAL_FRESH
                | bit(sample.cut, InputRecord::CUT)
                | bit(sample.coagulate, InputRecord::COAGULATE)
                | bit(sample.camera_lock, InputRecord::CAMERA_LOCK);
            record.pedal_at_ns = sample.at_ns;
        }
        Polled::Nothing => {}
        Polled::Lost => record.bits |= InputRecord::PEDAL_LOST,
    }
    let (kind, argument) = match samples.command {
        None => (0, 0),
        Some(Command::Pause(on)) => (CommandMsg::PAUSE, u8::from(on)),
        Some(Command::Reset) => (CommandMsg::RESET, 0),
        Some(Command::EnableForce(on)) => (CommandMsg::ENABLE_FORCE, u8::from(on)),
        Some(Command::Instrument(instrument)) => (CommandMsg::INSTRUMENT, instrument as u8),
        Some(Command::Start(task)) => (CommandMsg::START, task as u8),
        Some(Command::Complication(what)) => (CommandMsg::COMPLICATION, what as u8),
    };
    record.command = kind as u8 | argument << 4;
    record
}

/// Adds the tick's number and the digest of its result.
pub(crate) fn seal(record: &mut InputRecord, tick: u64, digest: Digest) {
    record.tick = tick;
    record.tools_hash = digest.tools;
    record.spheres_hash = digest.spheres;
    record.organ_hashes = digest.organs;
}

/// Samples of a record. Any record can be converted; the core refuses wrong values as it does from
/// a device.
pub(crate) fn samples(record: &InputRecord) -> Samples {
    let has = |bit: u32| record.bits & bit != 0;
    Samples {
        now_ns: record.now_ns,
        device: polled(
            has(InputRecord::DEVICE_FRESH),
            has(InputRecord::DEVICE_LOST),
            DeviceSample {
                device_from_handle: pose(&record.device_from_handle),
                velocity_m_s: has(InputRecord::HAS_VELOCITY)
                    .then(|| Vec3::from(record.velocity_m_s)),
                buttons: Buttons(record.buttons),
                opening: has(InputRecord::HAS_OPENING).then_some(record.opening),
                sequence: record.sequence,
                at_ns: record.device_at_ns,
            },
        ),
        tracker: polled(
            has(InputRecord::TRACKER_FRESH),
            has(InputRecord::TRACKER_LOST),
            TrackerSample {
                tracker_from_sensor: pose(&record.tracker_from_sensor),
                at_ns: record.tracker_at_ns,
            },
        ),
        pedal: polled(
            has(InputRecord::PEDAL_FRESH),
            has(InputRecord::PEDAL_LOST),
            PedalSample {
                cut: has(InputRecord::CUT),
                coagulate: has(InputRecord::COAGULATE),
                camera_lock: has(InputRecord::CAMERA_LOCK),
                at_ns: record.pedal_at_ns,
            },
        ),
        command: command(record.command),
    }
}

fn polled<T>(fresh: bool, lost: bool, sample: T) -> Polled<T> {
    match (fresh, lost) {
        (true, _) => Polled::Fresh(sample),
        (false, true) => Polled::Lost,
        (false, false) => Polled::Nothing,
    }
}

pub(crate) fn command(code: u8) -> Option<Command> {
    let (kind, argument) = (u32::from(code & 15), code >> 4);
    Some(match kind {
        CommandMsg::PAUSE => Command::Pause(argument != 0),
        CommandMsg::RESET => Command::Reset,
        CommandMsg::ENABLE_FORCE => Command::EnableForce(argument != 0),
        CommandMsg::INSTRUMENT => Command::Instrument(instrument(argument.into())?),
        CommandMsg::START => Command::Start(Task::from_number(argument.into())?),
        CommandMsg::COMPLICATION => {
            Command::Complication(Complication::from_number(argument.into())?)
        }
        _ => return None,
    })
}

/// Instrument with this number.
pub(crate) fn instrument(number: u32) -> Option<Instrument> {
    Some(match words::Instrument::try_from(number).ok()? {
        words::Instrument::Grasper => Instrument::Grasper,
        words::Instrument::Hook => Instrument::Hook,
        words::Instrument::Scissors => Instrument::Scissors,
        words::Instrument::ClipApplier => Instrument::ClipApplier,
        words::Instrument::Irrigator => Instrument::Irrigator,
    })
}

/// Start conditions of a run.
pub(crate) fn setup(
    scene_id: [u8; 16],
    period_ns: u64,
    room: &Room,
    device: &DeviceCapabilities,
    parameters: &Parameters,
    trocar: TrocarChoice,
    paper_iterations: u32,
) -> RunSetup {
    RunSetup {
        scene_id,
        period_ns,
        world_from_device: message(&room.world_from_device),
        world_from_tracker: message(&room.world_from_tracker),
        instrument_port_m: room.instrument_port_m.into(),
        endoscope_port_m: room.endoscope_port_m.into(),
        device: [
            device.force_max_n,
            device.force_continuous_n,
            device.torque_max_nm,
            device.stiffness_max_n_m,
            device.damping_max_n_s_m,
            device.damping_n_s_m,
            device.delay_s,
            device.workspace_radius_m,
            device.rate_hz,
        ],
        opening: [
            device.opening.travel_m,
            device.opening.force_max_n,
            device.opening.stiffness_max_n_m,
        ],
        trocar: trocar as u32,
        force_ramp_s: parameters.force_ramp_s,
        force_enabled: parameters.force_enabled.into(),
        paper_iterations,
    }
}

/// Capabilities of a recorded run's haptic device.
pub(crate) fn capabilities(setup: &RunSetup) -> DeviceCapabilities {
    let [
        force_max_n,
        force_continuous_n,
        torque_max_nm,
        stiffness_max_n_m,
        damping_max_n_s_m,
        damping_n_s_m,
        delay_s,
        workspace_radius_m,
        rate_hz,
    ] = setup.device;
    let [travel_m, opening_max_n, opening_max_n_m] = setup.opening;
    DeviceCapabilities {
        force_max_n,
        force_continuous_n,
        torque_max_nm,
        opening: Opening {
            travel_m,
            force_max_n: opening_max_n,
            stiffness_max_n_m: opening_max_n_m,
        },
        stiffness_max_n_m,
        damping_max_n_s_m,
        damping_n_s_m,
        delay_s,
        workspace_radius_m,
        rate_hz,
    }
}

/// Trocar of a recorded run. A number that this program does not know means the trocar of the
/// scene.
pub(crate) fn trocar(setup: &RunSetup) -> TrocarChoice {
    TrocarChoice::from_number(setup.trocar).unwrap_or_default()
}

/// Parameters of a recorded run.
pub(crate) fn parameters(setup: &RunSetup) -> Parameters {
    Parameters {
        force_ramp_s: setup.force_ramp_s,
        force_enabled: setup.force_enabled != 0,
    }
}

fn message(pose: &Pose) -> PoseMsg {
    let q = pose.rotation.coords;
    PoseMsg {
        position_m: pose.translation.vector.into(),
        orientation: [q.x, q.y, q.z, q.w],
    }
}

/// Pose with exactly the same bits. Normalising the quaternion again would change them.
pub(crate) fn pose(message: &PoseMsg) -> Pose {
    let [x, y, z, w] = message.orientation;
    let rotation = Unit::new_unchecked(Quaternion::new(w, x, y, z));
    Pose::from_parts(Vec3::from(message.position_m).into(), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rt_core::scene::Trocar;

    fn poses() -> impl Strategy<Value = Pose> {
        (
            prop::array::uniform3(-1.0f32..1.0),
            prop::array::uniform4(-1.0f32..1.0),
        )
            .prop_map(|(position_m, orientation)| {
                pose(&PoseMsg {
                    position_m,
                    orientation,
                })
            })
    }

    fn polls<T: Clone + core::fmt::Debug>(
        fresh: impl Strategy<Value = T>,
    ) -> impl Strategy<Value = Polled<T>> {
        (0..3, fresh).prop_map(|(kind, sample)| match kind {
            0 => Polled::Fresh(sample),
            1 => Polled::Nothing,
            _ => Polled::Lost,
        })
    }

    fn commands() -> impl Strategy<Value = Option<Command>> {
        (0u32..7, any::<bool>(), 0u32..4).prop_map(|(kind, on, number)| match kind {
            1 => Some(Command::Pause(on)),
            2 => Some(Command::Reset),
            3 => Some(Command::EnableForce(on)),
            4 => instrument(number).map(Command::Instrument),
            5 => Task::from_number(number).map(Command::Start),
            6 => Complication::from_number(number).map(Command::Complication),
            _ => None,
        })
    }

    proptest! {
        #[test]
        fn samples_come_back_from_their_record(
            now_ns in any::<u64>(),
            device in polls((poses(), prop::option::of(prop::array::uniform3(-9.0f32..9.0)), prop::option::of(0.0f32..1.0), any::<(u8, u16, u64)>())),
            tracker in polls((poses(), any::<u64>())),
            pedal in polls(any::<(bool, bool, bool, u64)>()),
            command in commands(),
        ) {
            fn map<T, U>(polled: Polled<T>, f: impl FnOnce(T) -> U) -> Polled<U> {
                match polled {
                    Polled::Fresh(x) => Polled::Fresh(f(x)),
                    Polled::Nothing => Polled::Nothing,
                    Polled::Lost => Polled::Lost,
                }
            }
            let given = Samples {
                now_ns,
                device: map(device, |(device_from_handle, velocity, opening, (buttons, sequence, at_ns))| DeviceSample {
                    device_from_handle,
                    velocity_m_s: velocity.map(Vec3::from),
                    buttons: Buttons(buttons),
                    opening,
                    sequence,
                    at_ns,
                }),
                tracker: map(tracker, |(tracker_from_sensor, at_ns)| TrackerSample { tracker_from_sensor, at_ns }),
                pedal: map(pedal, |(cut, coagulate, camera_lock, at_ns)| PedalSample { cut, coagulate, camera_lock, at_ns }),
                command,
            };
            prop_assert_eq!(samples(&record(&given)), given);
        }

        #[test]
        fn any_record_gives_samples(bytes in prop::collection::vec(any::<u8>(), size_of::<InputRecord>())) {
            let record: InputRecord = bytemuck::pod_read_unaligned(&bytes);
            let _ = samples(&record);
        }
    }

    #[test]
    fn start_conditions_of_a_run_come_back_from_its_setup() {
        let device = DeviceCapabilities {
            opening: Opening {
                travel_m: 0.025,
                force_max_n: 8.0,
                stiffness_max_n_m: 900.0,
            },
            ..crate::devices::FALLBACK_CAPABILITIES
        };
        let room = Room {
            gravity_m_s2: Vec3::zeros(),
            world_from_device: Pose::translation(1.0, 2.0, 3.0),
            world_from_tracker: Pose::translation(4.0, 5.0, 6.0),
            instrument_port_m: Vec3::new(7.0, 8.0, 9.0),
            instrument_length_m: 0.3,
            endoscope_port_m: Vec3::new(10.0, 11.0, 12.0),
            world_from_camera: Pose::identity(),
            breath_s: 0.0,
            trocar: Trocar::NONE,
        };
        let given = Parameters {
            force_ramp_s: 0.25,
            force_enabled: true,
        };
        let wet = TrocarChoice::Wet;
        let setup = setup([3; 16], 1_000_000, &room, &device, &given, wet, 7);
        assert_eq!(trocar(&setup), wet);
        assert_eq!(capabilities(&setup), device);
        assert_eq!(parameters(&setup), given);
        assert_eq!(setup.paper_iterations, 7);
        assert_eq!(pose(&setup.world_from_device), room.world_from_device);
        assert_eq!(pose(&setup.world_from_tracker), room.world_from_tracker);
    }
}
