//! Repeats a simulation from recorded inputs, as fast as possible.
//!
//! ```text
//! InputRecord ─► Samples, answers to "is there time?" ─► Sim::tick ─► Digest  ==?  the record's
//! ```
//!
//! There is no clock, device or thread: each tick gets its recorded inputs.

mod leaks;
mod player;
mod show;

pub use player::length_ns;
pub use show::{Pace, Shown, show};

use hardware::station::StationFile;
use rt_core::fault::{Fault, FaultSet};
use rt_core::port::{Findings, ForceCommand, LineCounters};
use rt_core::scene::Scene;
use rt_core::sim::{Digest, Optional, Ports, Samples, Stage, TickView};
use shared_mem::inputs::{InputRecord, RunSetup};
use shared_mem::message::{EventMsg, StateFrame, ToolFrame};
use shared_mem::scene::{SceneFile, str_from_name};

use crate::error::RtError;
use crate::frames;
use crate::inputs;
use crate::scene::LoadedScene;
use crate::storage::Storage;

/// Start conditions of a run, ready to be repeated.
#[derive(Debug)]
pub struct Replay {
    scene: LoadedScene,
    setup: RunSetup,
    organs: Vec<String>,
}

/// A repeated tick.
#[derive(Debug)]
pub struct Replayed<'a> {
    /// Recorded inputs and digest of the tick.
    pub record: &'a InputRecord,
    /// Digest of the repeated tick.
    pub digest: Digest,
    /// Results of the repeated tick.
    pub view: &'a TickView<'a>,
}

impl Replayed<'_> {
    /// Difference from the recorded run, if any.
    #[must_use]
    pub fn differs(&self) -> Option<Difference> {
        if self.record.spheres_hash != self.digest.spheres {
            let mut organs = self.digest.organs.iter().zip(&self.record.organ_hashes);
            return Some(Difference::Organ(organs.position(|(a, b)| a != b)));
        }
        (self.record.tools_hash != self.digest.tools).then_some(Difference::Tools)
    }

    /// Fills the frames that a display would have received. Their times are those of the record.
    pub fn fill(&self, scene_id: [u8; 16], state: &mut StateFrame, tools: &mut ToolFrame) {
        let now_ns = self.record.now_ns;
        let lines = [Some(LineCounters::default()); 3];
        frames::fill_state(state, self.view, scene_id, now_ns);
        frames::fill_tools(tools, self.view, lines, scene_id, now_ns);
    }

    /// Events of the tick; their numbers start at 0 in each tick.
    pub fn events(&self) -> impl Iterator<Item = EventMsg> {
        let (tick, now_ns) = (self.record.tick, self.record.now_ns);
        let numbered = (0..).zip(self.view.events);
        numbered.map(move |(number, event)| frames::event(event, number, tick, now_ns))
    }
}

/// Difference between two runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Difference {
    /// The first organ that differs, by its index in the scene; `None` if the eight stored bits of
    /// every organ agree by chance.
    Organ(Option<usize>),
    /// The instrument, the endoscope or the force.
    Tools,
}

impl Replay {
    /// Prepares to run `scene` from `setup`. The scene may differ from the recorded one: compare
    /// [`Replay::scene_id`] first if equal bits are needed.
    ///
    /// # Errors
    /// When the core refuses the scene or the devices' poses.
    pub fn new(scene: &SceneFile, setup: &RunSetup) -> Result<Self, RtError> {
        let loaded = LoadedScene::from_file(scene, &StationFile::default())?.in_room_of(setup);
        loaded.scene()?;
        Ok(Self {
            scene: loaded,
            setup: *setup,
            organs: scene
                .organs()
                .iter()
                .map(|organ| str_from_name(&organ.name).unwrap_or_default().to_owned())
                .collect(),
        })
    }

    /// First half of the scene's identity.
    #[must_use]
    pub fn scene_id(&self) -> [u8; 16] {
        self.scene.short_id
    }

    /// The scene's name.
    #[must_use]
    pub fn scene_name(&self) -> &str {
        &self.scene.name
    }

    /// Names of the scene's organs.
    #[must_use]
    pub fn organs(&self) -> &[String] {
        &self.organs
    }

    /// Runs all ticks in order, from the scene at rest. `each` gets every tick; it ends the run by
    /// returning `false`.
    ///
    /// # Errors
    /// When the core refuses the scene.
    pub fn run(
        &self,
        records: impl IntoIterator<Item = InputRecord>,
        each: impl FnMut(&Replayed<'_>) -> bool,
    ) -> Result<(), RtError> {
        run_scene(self.scene.scene()?, &self.setup, records, each);
        Ok(())
    }
}

/// Like [`Replay::run`], on a scene in memory whose room is the recorded run's.
pub(crate) fn run_scene(
    scene: Scene<'_>,
    setup: &RunSetup,
    records: impl IntoIterator<Item = InputRecord>,
    mut each: impl FnMut(&Replayed<'_>) -> bool,
) {
    let mut storage = Storage::new(setup.paper_iterations);
    let device = inputs::capabilities(setup);
    let mut sim = storage.sim(scene, device, inputs::parameters(setup));
    for record in records {
        let mut goes_on = true;
        sim.tick(&mut Recorded {
            record: &record,
            each: |replayed: &Replayed<'_>| goes_on = each(replayed),
        });
        if !goes_on {
            break;
        }
    }
}

/// The recorded inputs of one tick, in place of devices and clock.
struct Recorded<'a, F> {
    record: &'a InputRecord,
    each: F,
}

impl<F: FnMut(&Replayed<'_>)> Ports for Recorded<'_, F> {
    fn sample(&mut self) -> Samples {
        inputs::samples(self.record)
    }

    fn findings(&mut self) -> Findings {
        let mut faults = FaultSet::NONE;
        let failed = self.record.bits & InputRecord::DEVICE_FAILED != 0;
        faults.raise_if(failed, Fault::DeviceFault);
        Findings {
            faults,
            leapt: self.record.bits & InputRecord::LEAPT != 0,
            ..Findings::default()
        }
    }

    fn send_force(&mut self, _command: ForceCommand) {}

    fn publish(&mut self, view: &TickView<'_>) {
        (self.each)(&Replayed {
            record: self.record,
            digest: view.digest(),
            view,
        });
    }

    fn may(&mut self, work: Optional) -> bool {
        let bit = match work {
            Optional::SelfCollision => InputRecord::NO_SELF_COLLISION,
            Optional::FarOrgans => InputRecord::NO_FAR_ORGANS,
        };
        self.record.bits & bit == 0
    }

    fn stamp(&mut self, _stage: Stage) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rt_core::math::{Pose, Vec3};
    use rt_core::scene::{Room, Trocar};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// A session with correct checksums may still hold any values.
        #[test]
        fn any_setup_and_any_inputs_run_without_a_panic(
            setup in prop::collection::vec(any::<u8>(), size_of::<RunSetup>()),
            ticks in prop::collection::vec(prop::collection::vec(any::<u8>(), size_of::<InputRecord>()), 1..20),
            is_plausible in any::<bool>(),
        ) {
            let setup: RunSetup = bytemuck::pod_read_unaligned(&setup);
            let mut room = Room {
                gravity_m_s2: Vec3::zeros(),
                world_from_device: inputs::pose(&setup.world_from_device),
                world_from_tracker: inputs::pose(&setup.world_from_tracker),
                instrument_port_m: setup.instrument_port_m.into(),
                instrument_length_m: 0.3,
                endoscope_port_m: setup.endoscope_port_m.into(),
                world_from_camera: Pose::identity(),
                breath_s: 0.0,
                trocar: Trocar::NONE,
            };
            if is_plausible {
                room.world_from_device = Pose::identity();
                room.world_from_tracker = Pose::identity();
                room.instrument_port_m = Vec3::zeros();
                room.endoscope_port_m = Vec3::zeros();
            }
            let records: Vec<InputRecord> =
                ticks.iter().map(|it| bytemuck::pod_read_unaligned(it)).collect();
            // The core may refuse the room.
            if let Ok(scene) = Scene::new(&[], &[], &[], room) {
                let mut seen = 0;
                run_scene(scene, &setup, records.iter().copied(), |_| {
                    seen += 1;
                    true
                });
                prop_assert_eq!(seen, records.len());
            }
        }
    }
}
