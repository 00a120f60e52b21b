//! Warnings of organs that fell or shook in a run, or that held the instrument when its device
//! started or returned.

use shared_mem::message::{Event, EventMsg};
use shared_mem::scene::{SceneFile, str_from_name};

/// Largest number of findings that are kept. A scene has at most 16 organs.
const KEPT_MAX: usize = 64;

/// Findings of a run: the organ and its event. Each organ is kept once for each kind.
#[derive(Debug, Clone, Default)]
pub(super) struct Unrest(Vec<(u32, Event)>);

impl Unrest {
    pub(super) fn take(&mut self, event: &EventMsg) {
        let Ok(found @ (Event::Fall { .. } | Event::Shake { .. } | Event::Buried { .. })) =
            event.decode()
        else {
            return;
        };
        let kind = core::mem::discriminant(&found);
        let is_known = |(organ, known): &(u32, Event)| {
            *organ == event.organ && core::mem::discriminant(known) == kind
        };
        if self.0.len() < KEPT_MAX && !self.0.iter().any(is_known) {
            self.0.push((event.organ, found));
        }
    }

    pub(super) fn findings(&self, scene: &SceneFile) -> Vec<UnrestFinding> {
        let name = |organ: u32| {
            let record = scene.organs().get(organ as usize);
            let name = record.and_then(|it| str_from_name(&it.name));
            name.map_or_else(|| format!("organ {organ}"), str::to_owned)
        };
        let all = self.0.iter();
        all.filter_map(|(organ, event)| finding(name(*organ), event))
            .collect()
    }
}

/// An organ in `summary.json` that fell or shook, or that held the instrument when its device
/// started or returned.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct UnrestFinding {
    /// `fall`, `shake` or `buried`.
    pub what: &'static str,
    /// The organ's name.
    pub organ: String,
    /// Distance of a fallen organ from its place, m, speed of a shaking one, m/s, or depth of the
    /// instrument, m.
    pub value: f32,
    /// The finding as one of the run's warnings.
    pub warning: String,
}

/// The finding, whose warning names a remedy. `None` for another kind of event.
fn finding(organ: String, event: &Event) -> Option<UnrestFinding> {
    let (what, value, warning) = match *event {
        Event::Fall { distance_m } => (
            "fall",
            distance_m,
            format!(
                "'{organ}' fell: it was {:.0} mm off its place, and nobody had freed it; hold it in the recipe \
             (held, attached or suture), or give it a smaller gravity_share",
                distance_m * 1e3
            ),
        ),
        Event::Shake { speed_m_s } => (
            "shake",
            speed_m_s,
            format!(
                "'{organ}' shook at up to {:.0} mm/s without being moved; give it a stiffer material, fewer \
             spheres or a smaller gravity_share in the recipe",
                speed_m_s * 1e3
            ),
        ),
        Event::Buried { depth_m } => (
            "buried",
            depth_m,
            format!(
                "the instrument began {:.0} mm deep inside '{organ}': draw it out before a run starts, or \
                 change `world_from_device` if the hand was in free air",
                depth_m * 1e3
            ),
        ),
        _ => return None,
    };
    Some(UnrestFinding {
        what,
        organ,
        value,
        warning,
    })
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use shared_mem::words::EventKind;

    use super::*;

    #[test]
    fn each_organ_is_kept_once_for_each_kind_and_other_events_are_not() {
        let mut unrest = Unrest::default();
        let mut take = |kind: EventKind, organ, value| {
            unrest.take(&EventMsg {
                kind: kind.number(),
                organ,
                value,
                ..EventMsg::zeroed()
            });
        };
        take(EventKind::Fall, 1, 0.25);
        take(EventKind::Fall, 1, 0.5);
        take(EventKind::Shake, 1, 0.058);
        take(EventKind::Shake, 0, 0.01);
        take(EventKind::Buried, 0, 0.012);
        take(EventKind::Grasp, 0, 3.0);
        let said: Vec<_> = unrest
            .0
            .iter()
            .filter_map(|(_, it)| finding("liver".into(), it))
            .collect();
        assert_eq!(said.len(), 4);
        assert!(
            said[3].warning.contains("began 12 mm deep inside"),
            "{:?}",
            said[3]
        );
        assert!(
            said[0]
                .warning
                .starts_with("'liver' fell: it was 250 mm off its place"),
            "{:?}",
            said[0]
        );
        assert!(
            said[1]
                .warning
                .starts_with("'liver' shook at up to 58 mm/s"),
            "{:?}",
            said[1]
        );
    }
}
