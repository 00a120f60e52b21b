//! The scene that the watched station runs: names of its organs, and their surfaces.

use std::time::{Duration, Instant};

use display_host::skinning::organs::{OrganSurface, OrganSurfaces};
use hardware::igtlink::message::Message;
use nalgebra::Vector3;
use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::scene::{SceneFile, str_from_name};
use shared_mem::service::Host;

use super::clock::Stamps;
use super::frame::Frame;
use crate::folder::running_scene;
use crate::say;

/// Interval between two searches for the scene.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Number of searches in vain before the user gets a message. `calot run` names its scene a moment
/// after its first frames.
const PATIENCE: u32 = 5;

/// Organs of the watched station.
pub(super) struct Anatomy {
    station: String,
    /// Interval of rounds of surfaces; `None` if surfaces are not requested.
    every: Option<Duration>,
    known: Option<Known>,
    looked: Option<Instant>,
    /// Number of searches in vain.
    misses: u32,
}

struct Known {
    scene_id: [u8; 16],
    names: Vec<String>,
    surfaces: Option<Surfaces>,
}

impl Anatomy {
    /// `surfaces_hz`: rounds of all organs' surfaces in a second; 0 for none.
    pub(super) fn new(station: &str, surfaces_hz: f64) -> Self {
        let every = (surfaces_hz > 0.0).then(|| Duration::from_secs_f64(1.0 / surfaces_hz));
        Self {
            station: station.to_owned(),
            every,
            known: None,
            looked: None,
            misses: 0,
        }
    }

    /// Name of an organ by its number, if the scene is known.
    pub(super) fn name(&self, organ: u32) -> Option<&str> {
        let known = self.known.as_ref()?;
        known.names.get(organ as usize).map(String::as_str)
    }

    /// Finds the scene that this frame belongs to, unless it is known already.
    pub(super) fn meet(&mut self, tools: &ToolFrame) {
        let is_it = |known: &Known| known.scene_id == tools.scene_id;
        let is_early = |looked: Instant| looked.elapsed() < LOOK_EVERY;
        if self.known.as_ref().is_some_and(is_it) || self.looked.is_some_and(is_early) {
            return;
        }
        self.known = self.find(tools.scene_id);
        if self.known.is_some() {
            (self.looked, self.misses) = (None, 0);
            return;
        }
        self.looked = Some(Instant::now());
        self.misses = self.misses.saturating_add(1);
        if self.misses == PATIENCE && self.every.is_some() {
            say::note(format_args!(
                "no surfaces are sent: the scene of station '{0}' is not known, because its \
                 `calot rt` was started by hand; `calot run --station {0}` names it",
                self.station
            ));
        }
    }

    fn find(&self, scene_id: [u8; 16]) -> Option<Known> {
        let path = running_scene(&self.station).ok().flatten()?;
        let scene = SceneFile::open(&path).ok()?;
        let name = |name: &_| str_from_name(name).unwrap_or_default().to_owned();
        let surfaces = |every| Surfaces::of(&scene, every);
        (scene.short_id() == scene_id).then(|| Known {
            scene_id,
            names: scene.organs().iter().map(|it| name(&it.name)).collect(),
            surfaces: self.every.map(surfaces),
        })
    }

    /// Surfaces that are due now.
    pub(super) fn due(&mut self, host: &Host, tools: &ToolFrame, frame: Frame) -> Vec<Message> {
        let surfaces = self.known.as_mut().and_then(|it| it.surfaces.as_mut());
        surfaces.map_or_else(Vec::new, |it| it.due(host, tools, frame))
    }
}

/// Sends the surfaces of all organs in rounds. A round shows one moment, and its organs are spread
/// over the interval. All at once would fill a client's socket, and the client would always miss
/// the same organs.
struct Surfaces {
    organs: OrganSurfaces,
    state: Box<StateFrame>,
    every: Duration,
    began: Option<Instant>,
    next: usize,
    stamps: Stamps,
    unix_ns: u64,
}

impl Surfaces {
    fn of(scene: &SceneFile, every: Duration) -> Self {
        Self {
            organs: OrganSurfaces::of(scene),
            state: bytemuck::zeroed_box(),
            every,
            began: None,
            next: 0,
            stamps: Stamps::now(),
            unix_ns: 0,
        }
    }

    fn due(&mut self, host: &Host, tools: &ToolFrame, frame: Frame) -> Vec<Message> {
        let now = Instant::now();
        let is_over = |began: Instant| now.duration_since(began) >= self.every;
        if self.next >= self.organs.count() && self.began.is_none_or(is_over) {
            self.begin(host, tools, now);
        }
        let Some(began) = self.began else {
            self.begin(host, tools, now);
            return Vec::new();
        };
        let passed = now.duration_since(began).div_duration_f64(self.every);
        let until = (passed * self.organs.count() as f64).ceil() as usize;
        let until = until.clamp(self.next, self.organs.count());
        let due = (self.next..until).filter_map(|organ| self.organs.get(organ));
        let messages = due
            .map(|organ| polydata(&organ, frame, self.unix_ns))
            .collect();
        self.next = until;
        messages
    }

    /// Begins a round, if there is a new state.
    fn begin(&mut self, host: &Host, tools: &ToolFrame, now: Instant) {
        let is_of_scene = |state: &StateFrame| state.scene_id == tools.scene_id;
        if !host.newest_state(&mut self.state) || !is_of_scene(&self.state) {
            return;
        }
        self.organs.follow(&self.state, tools);
        self.unix_ns = self.stamps.of(self.state.at_ns);
        self.began = Some(now);
        self.next = 0;
    }
}

/// Message `POLYDATA` with the surface of an organ.
fn polydata(organ: &OrganSurface<'_>, frame: Frame, unix_ns: u64) -> Message {
    let turned = |point: [f32; 3]| frame.vector(Vector3::from(point)).into();
    let points: Vec<[f32; 3]> = organ.points_m().map(turned).collect();
    Message::polydata(organ.name, &points, &organ.triangles, unix_ns)
}
