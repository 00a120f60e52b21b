//! The compiled scene of a run, and the poses of its devices.

use std::path::Path;

use hardware::station::StationFile;
use rt_core::math::Vec3;
use rt_core::scene::{Scene, TrocarChoice};
use scene_load::{Records, SceneStorage};
use shared_mem::inputs::RunSetup;
use shared_mem::scene::SceneFile;

use crate::error::RtError;
use crate::inputs;

/// A compiled scene, converted to the core's layout once.
#[derive(Debug)]
pub(crate) struct LoadedScene {
    pub(crate) name: String,
    /// First half of the identity, as in frames.
    pub(crate) short_id: [u8; 16],
    /// The whole identity, hexadecimal.
    pub(crate) id: String,
    /// Trocar that the station file names.
    pub(crate) trocar: TrocarChoice,
    storage: SceneStorage,
}

impl LoadedScene {
    /// Reads and checks a compiled scene. The poses of devices and ports come from the station
    /// file; those that it lacks come from the scene.
    pub(crate) fn load(path: &Path, station: &StationFile) -> Result<Self, RtError> {
        Self::from_file(&SceneFile::open(path)?, station)
    }

    /// Uses the device poses of a recorded run.
    pub(crate) fn in_room_of(mut self, setup: &RunSetup) -> Self {
        let room = &mut self.storage.room;
        room.world_from_device = inputs::pose(&setup.world_from_device);
        room.world_from_tracker = inputs::pose(&setup.world_from_tracker);
        room.instrument_port_m = Vec3::from(setup.instrument_port_m);
        room.endoscope_port_m = Vec3::from(setup.endoscope_port_m);
        self.trocar = inputs::trocar(setup);
        self.storage.choose_trocar(self.trocar);
        self
    }

    /// Leaks the scene, because the simulation uses it until the process ends.
    pub(crate) fn keep(self) -> &'static Self {
        Box::leak(Box::new(self))
    }

    pub(crate) fn from_file(file: &SceneFile, station: &StationFile) -> Result<Self, RtError> {
        let mut storage = SceneStorage::new(Records::of_file(file)).map_err(RtError::Core)?;
        arrange(&mut storage, station);
        let loaded = Self {
            name: file.name().to_owned(),
            short_id: file.short_id(),
            id: file.id().iter().map(|byte| format!("{byte:02x}")).collect(),
            trocar: station.trocar,
            storage,
        };
        loaded.scene()?;
        Ok(loaded)
    }

    /// The scene, checked by the core.
    pub(crate) fn scene(&self) -> Result<Scene<'_>, RtError> {
        self.storage.scene().map_err(RtError::Core)
    }

    /// Number of spheres.
    pub(crate) fn sphere_count(&self) -> usize {
        self.storage.sphere_count()
    }
}

/// Replaces poses of devices and ports by those of the station file.
fn arrange(storage: &mut SceneStorage, station: &StationFile) {
    let room = &mut storage.room;
    if let Some(pose) = station.world_from_device {
        room.world_from_device = pose;
    }
    if let Some(pose) = station.world_from_tracker {
        room.world_from_tracker = pose;
    }
    if let Some(port_m) = station.instrument_port_m {
        room.instrument_port_m = port_m;
    }
    if let Some(port_m) = station.endoscope_port_m {
        room.endoscope_port_m = port_m;
    }
    storage.choose_trocar(station.trocar);
}
