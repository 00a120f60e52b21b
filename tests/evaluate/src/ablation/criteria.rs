//! Criteria by which a change of a tuned value is judged.

use rt_process::replay::Replay;
use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::words::EventKind;

use crate::{force, haptics, stay, surface};

/// A group of criteria that one run measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    /// Presses beside finite elements.
    Force,
    /// A device in a hand.
    Haptics,
    /// Organs after work at them.
    Stay,
    /// Recorded operations.
    Operation,
}

/// A criterion's name and its value.
pub(super) type Value = (&'static str, f64);

impl Group {
    pub(super) const ALL: [Self; 4] = [Self::Force, Self::Haptics, Self::Stay, Self::Operation];
}

/// Everything that is prepared once, with the usual values.
pub(super) struct Bench {
    force: force::Sample,
    haptics: haptics::Sample,
    stay: stay::Sample,
}

impl Bench {
    /// Prepares bodies and scenes.
    ///
    /// # Errors
    /// The reason in words.
    pub(super) fn new() -> Result<Self, String> {
        Ok(Self {
            force: force::Sample::new()?,
            haptics: haptics::Sample::new()?,
            stay: stay::Sample::new()?,
        })
    }

    /// Measures a group.
    ///
    /// # Errors
    /// The reason in words.
    pub(super) fn measure(&mut self, group: Group) -> Result<Vec<Value>, String> {
        Ok(match group {
            Group::Force => {
                let it = self.force.press()?;
                vec![
                    ("force rows within 7 %", it.within as f64),
                    ("force, rms %", it.rms_pct),
                    ("step in slow work, mN", it.step_n * 1e3),
                ]
            }
            Group::Haptics => {
                let it = self.haptics.feel()?;
                vec![
                    ("stable settings", it.stable as f64),
                    ("rendered wall, N/m", it.rendered_n_m),
                    ("oscillation in a stroke, mN", it.peak_n * 1e3),
                    ("drag in free air, mN", it.drag_n * 1e3),
                ]
            }
            Group::Stay => {
                let it = self.stay.work()?;
                vec![
                    ("speed 2 s after work, mm/s", f64::from(it.speed_m_s) * 1e3),
                    ("organ in organ, mm", f64::from(it.inside_m) * 1e3),
                    ("loose attachment, mm", f64::from(it.loose_m) * 1e3),
                    ("works that tear", it.torn as f64),
                ]
            }
            Group::Operation => operation(self.stay.scene())?,
        })
    }
}

/// Ticks between two looks at the frames.
const LOOK_EVERY: u64 = 4;

/// Largest values in the recorded operations.
#[derive(Default)]
struct Seen {
    force_n: f32,
    tears: usize,
    divided: usize,
    removed: usize,
    /// Places of the spheres at the last look, m.
    places_m: Vec<[f32; 3]>,
    /// Largest speed at the last look, m/s.
    speed_m_s: f32,
}

impl Seen {
    fn look(&mut self, state: &StateFrame, tools: &ToolFrame) {
        let force_n = glam::Vec3::from(tools.force_n).length();
        self.force_n = self.force_n.max(force_n);
        let places_m: Vec<_> = state.spheres().unwrap_or(&[]).iter().collect();
        let before = self.places_m.iter().zip(&places_m);
        let ways = before.map(|(a, b)| glam::Vec3::from(*a).distance(b.center_m.into()));
        self.speed_m_s = ways.fold(0.0, f32::max) / (LOOK_EVERY as f32 * 1e-3);
        self.places_m = places_m.iter().map(|it| it.center_m).collect();
    }

    fn note(&mut self, kind: u32) {
        let is = |of: EventKind| usize::from(of.number() == kind);
        self.tears += is(EventKind::Tear);
        self.divided += is(EventKind::Divided);
        self.removed += is(EventKind::Removed);
    }
}

fn operation(scene: &SceneFile) -> Result<Vec<Value>, String> {
    let mut all = Seen::default();
    for name in surface::RECORDED {
        let (setup, records) = surface::recorded(name)?;
        let replay = Replay::new(scene, &setup).map_err(|e| e.to_string())?;
        let (mut state, mut tools) = (bytemuck::zeroed_box(), bytemuck::zeroed_box());
        let mut seen = Seen::default();
        let ran = replay.run(records, |tick| {
            tick.events().for_each(|event| seen.note(event.kind));
            if tick.record.tick.is_multiple_of(LOOK_EVERY) {
                tick.fill(scene.short_id(), &mut state, &mut tools);
                seen.look(&state, &tools);
            }
            true
        });
        ran.map_err(|e| e.to_string())?;
        all.force_n = all.force_n.max(seen.force_n);
        all.speed_m_s = all.speed_m_s.max(seen.speed_m_s);
        all.tears += seen.tears;
        all.divided += seen.divided;
        all.removed += seen.removed;
    }
    Ok(vec![
        ("largest force in operations, N", f64::from(all.force_n)),
        ("speed at their end, mm/s", f64::from(all.speed_m_s) * 1e3),
        ("tears in operations", all.tears as f64),
        ("divisions in operations", all.divided as f64),
        ("removed parts in operations", all.removed as f64),
    ])
}
