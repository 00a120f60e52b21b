//! Table `ticks`: inputs, results and times of each tick.

use rt_core::math::{Pose, Vec3};
use rt_process::replay::Replayed;
use session::TickTimes;
use shared_mem::inputs::InputRecord;
use shared_mem::message::{PoseMsg, STAGE_NAMES, STAGES};

use super::columns::seconds;
use super::counted;
use super::table::{Cell, Column, Kind};

pub(crate) fn columns() -> Vec<Column> {
    let mut all = Vec::new();
    let mut add = |name: &str, kind, meaning| all.push(Column::new(name, kind, meaning));
    add("tick", Kind::Whole, "number of the tick");
    add("time_s", Kind::Double, "time since the first tick, s");
    add("time_unix_ns", Kind::Whole, "time since 1970 UTC, ns");
    add("debrief_s", Kind::Double, counted::MEANING);
    add(
        "device_fresh",
        Kind::Flag,
        "the device brought a new sample",
    );
    let device = "position of the handle in the device's frame, newest sample, m";
    vector(&mut add, "device", "m", device);
    let velocity =
        "velocity of the handle in the device's frame; empty: the device measures none, m/s";
    vector(&mut add, "device_v", "m_s", velocity);
    let turned = "orientation of the handle in the device's frame, quaternion";
    rotation(&mut add, "device", turned);
    for (name, place, turned) in [
        (
            "handle",
            "position of the handle, world frame, m",
            "orientation of the handle, world frame, quaternion",
        ),
        (
            "instrument",
            "position of the jaws' joint, world frame, m",
            "orientation of the instrument, world frame (-z along the shaft to the tip), quaternion",
        ),
        (
            "camera",
            "position of the endoscope's camera, world frame, m",
            "orientation of the camera, world frame (looks along -z, y up), quaternion",
        ),
    ] {
        vector(&mut add, name, "m", place);
        rotation(&mut add, name, turned);
    }
    vector(
        &mut add,
        "tip",
        "m",
        "tip of the instrument, world frame, m",
    );
    vector(
        &mut add,
        "force",
        "n",
        "force on the hand as sent, world frame, N",
    );
    vector(
        &mut add,
        "torque",
        "n_m",
        "torque on the hand as sent, world frame, N m",
    );
    add(
        "opening_n",
        Kind::Single,
        "force that opens the handle as sent, N",
    );
    add(
        "handle_opening",
        Kind::Single,
        "opening of the handle, 0 shut to 1 wide; empty: none",
    );
    add(
        "jaw",
        Kind::Single,
        "opening of the jaws, 0 closed to 1 open",
    );
    add("buttons", Kind::Whole, "bits of the handle's buttons");
    add("cut", Kind::Flag, "a pedal asks for the cutting current");
    add(
        "coagulate",
        Kind::Flag,
        "a pedal asks for the coagulating current",
    );
    add("camera_lock", Kind::Flag, "a pedal holds the picture still");
    add("paused", Kind::Flag, "the simulation is paused");
    add("force_enabled", Kind::Flag, "force may go to the device");
    add("contacts", Kind::Whole, "contacts of the instrument");
    add("grasped", Kind::Whole, "spheres between the closed jaws");
    add("instrument", Kind::Text, "instrument on the shaft");
    add(
        "energy_j",
        Kind::Single,
        "energy that the hand put into contact and did not get back, J",
    );
    add("wake_ns", Kind::Whole, "actual minus scheduled start, ns");
    add("tick_ns", Kind::Whole, "duration of the tick, ns");
    add(
        "motion_to_force_ns",
        Kind::Whole,
        "from the sample's arrival until the force was written, ns; empty: no new sample",
    );
    for stage in STAGE_NAMES {
        add(
            &format!("{stage}_ns"),
            Kind::Whole,
            "duration of the stage, ns",
        );
    }
    add(
        "missed",
        Kind::Whole,
        "periods that were skipped before the tick",
    );
    all
}

fn vector(
    add: &mut impl FnMut(&str, Kind, &'static str),
    name: &str,
    unit: &str,
    means: &'static str,
) {
    // A velocity has no separator before its axis: device_vx_m_s.
    let between = if name.ends_with("_v") { "" } else { "_" };
    for axis in ["x", "y", "z"] {
        add(
            &format!("{name}{between}{axis}_{unit}"),
            Kind::Single,
            means,
        );
    }
}

fn rotation(add: &mut impl FnMut(&str, Kind, &'static str), name: &str, means: &'static str) {
    for axis in ["x", "y", "z", "w"] {
        add(&format!("{name}_q{axis}"), Kind::Single, means);
    }
}

/// Makes the rows of a session.
pub(crate) struct Rows {
    wall_from_host_ns: i64,
    first_ns: Option<u64>,
    /// Newest sample of the device, in its frame: position, m; velocity, m/s; orientation. A tick
    /// without a new sample repeats the sample.
    device: [f32; 10],
    /// Opening of the handle in that sample, 0 to 1.
    opening: f32,
}

impl Rows {
    pub(crate) fn new(wall_from_host_ns: i64) -> Self {
        Self {
            wall_from_host_ns,
            first_ns: None,
            device: [f32::NAN; 10],
            opening: f32::NAN,
        }
    }

    /// Host time of the first tick, ns; 0 before the first row.
    pub(crate) fn first_ns(&self) -> u64 {
        self.first_ns.unwrap_or(0)
    }

    /// Row of a tick, in the order of [`columns`]. `counted` is the debrief's time.
    pub(crate) fn row(
        &mut self,
        replayed: &Replayed<'_>,
        counted: Cell,
        times: Option<TickTimes>,
    ) -> Vec<Cell> {
        let (record, tool) = (replayed.record, replayed.view.tool);
        let first_ns = *self.first_ns.get_or_insert(record.now_ns);
        self.take(record);
        let mut row = Vec::with_capacity(80);
        row.push(Cell::Whole(replayed.view.tick));
        row.push(Cell::Double(seconds(first_ns, record.now_ns)));
        let wall_ns = record.now_ns.saturating_add_signed(self.wall_from_host_ns);
        row.push(Cell::Whole(wall_ns));
        row.push(counted);
        row.push(Cell::Flag(record.bits & InputRecord::DEVICE_FRESH != 0));
        row.extend(self.device.map(Cell::finite));
        for pose in [
            &tool.world_from_handle,
            &tool.world_from_instrument,
            &tool.world_from_camera,
        ] {
            row.extend(pose_cells(pose));
        }
        for vector in [&tool.tip_m, &tool.force_n, &tool.torque_nm] {
            row.extend(vector_cells(vector));
        }
        row.push(Cell::finite(tool.opening_n));
        row.push(Cell::finite(self.opening));
        row.push(Cell::finite(tool.jaw));
        row.push(Cell::Whole(tool.buttons.0.into()));
        let (switches, pedal) = (&tool.switches, &tool.switches.pedal);
        let flags = [
            pedal.cut,
            pedal.coagulate,
            pedal.camera_lock,
            switches.paused,
            switches.force_enabled,
        ];
        row.extend(flags.map(Cell::Flag));
        row.push(Cell::Whole(tool.contact_count.into()));
        row.push(Cell::Whole(tool.grasped_count.into()));
        row.push(Cell::Text(format!("{:?}", tool.instrument)));
        row.push(Cell::finite(replayed.view.energy_j));
        row.extend(time_cells(times));
        row
    }

    fn take(&mut self, record: &InputRecord) {
        let has = |bit: u32| record.bits & bit != 0;
        if !has(InputRecord::DEVICE_FRESH) {
            return;
        }
        let PoseMsg {
            position_m: [x, y, z],
            orientation: [qx, qy, qz, qw],
        } = record.device_from_handle;
        let [vx, vy, vz] = match has(InputRecord::HAS_VELOCITY) {
            true => record.velocity_m_s,
            false => [f32::NAN; 3],
        };
        self.device = [x, y, z, vx, vy, vz, qx, qy, qz, qw];
        self.opening = match has(InputRecord::HAS_OPENING) {
            true => record.opening,
            false => f32::NAN,
        };
    }
}

fn vector_cells(vector: &Vec3) -> impl Iterator<Item = Cell> + use<'_> {
    vector.iter().copied().map(Cell::finite)
}

fn pose_cells(pose: &Pose) -> impl Iterator<Item = Cell> + use<'_> {
    let turned = pose.rotation.coords.iter().copied();
    vector_cells(&pose.translation.vector).chain(turned.map(Cell::finite))
}

fn time_cells(times: Option<TickTimes>) -> impl Iterator<Item = Cell> {
    let whole = |number: u32| Cell::Whole(number.into());
    let cells: [Cell; 4 + STAGES] = match times {
        Some(times) => {
            let [sample, tool, contact, solve, force, procedure, publish] =
                times.stage_ns.map(whole);
            let motion = match times.motion_to_force_ns {
                0 => Cell::Absent,
                ns => whole(ns),
            };
            [
                whole(times.wake_ns),
                whole(times.tick_ns),
                motion,
                sample,
                tool,
                contact,
                solve,
                force,
                procedure,
                publish,
                whole(times.missed),
            ]
        }
        None => core::array::from_fn(|_| Cell::Absent),
    };
    cells.into_iter()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_of_columns_differ() {
        let names: BTreeSet<String> = columns().into_iter().map(|it| it.name).collect();
        assert_eq!(names.len(), columns().len());
    }

    #[test]
    fn a_row_without_times_lacks_them() {
        assert!(time_cells(None).all(|it| it == Cell::Absent));
        let times = TickTimes {
            tick: 1,
            wake_ns: 2,
            tick_ns: 3,
            motion_to_force_ns: 0,
            stage_ns: [4, 5, 6, 7, 8, 9, 10],
            missed: 11,
        };
        let cells: Vec<Cell> = time_cells(Some(times)).collect();
        assert_eq!(cells[2], Cell::Absent);
        assert_eq!(cells[6], Cell::Whole(7), "the solve");
        assert_eq!(cells.last(), Some(&Cell::Whole(11)));
    }
}
