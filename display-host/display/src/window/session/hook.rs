//! Watches the current of the hook: a trainee who heats nothing, or the wrong organ, sees only that
//! the step does not go on.

use std::time::{Duration, Instant};

use shared_mem::message::{Event, EventMsg, ToolFrame};
use shared_mem::scene::{OrganKind, SceneFile};
use shared_mem::words::{Instrument, Switches};

/// Time after which it is judged what the current heats: longer than the short bursts that the
/// hints ask for, and twenty of the controller's reports of a burn.
const JUDGED_AFTER: Duration = Duration::from_secs(1);

/// The present current, and the organs that it has heated so far.
#[derive(Debug, Default)]
pub(super) struct Hook {
    /// By organ: true if it is loose tissue, which the hook may take.
    may_heat: Vec<bool>,
    /// Time since which current flows.
    since: Option<Instant>,
    /// Organ that was heated last.
    heated: Option<u32>,
    /// True once loose tissue was heated.
    is_right: bool,
    /// True once the current is judged.
    is_judged: bool,
}

impl Hook {
    pub(super) fn of(scene: &SceneFile) -> Self {
        let is_loose = |kind| {
            matches!(
                OrganKind::from_u32(kind),
                Some(OrganKind::Fat | OrganKind::ConnectiveTissue)
            )
        };
        let organs = scene.organs().iter();
        Self {
            may_heat: organs.map(|it| is_loose(it.kind)).collect(),
            ..Self::default()
        }
    }

    pub(super) fn event(&mut self, event: &EventMsg) {
        if let Ok(Event::Burn { .. }) = event.decode() {
            self.heated = Some(event.organ);
            let may_heat = self.may_heat.get(event.organ as usize);
            self.is_right |= may_heat.copied().unwrap_or(false);
        }
    }

    /// Returns, once for each current that heats no loose tissue, the organ that it heats;
    /// `Some(None)`: it heats nothing.
    pub(super) fn heats_wrong(&mut self, tools: &ToolFrame, now: Instant) -> Option<Option<u32>> {
        let [cuts, coagulates] =
            [Switches::CUT, Switches::COAGULATE].map(|it| tools.switches().contains(it));
        // Both pedals together make no current.
        if !tools.has(Instrument::Hook) || cuts == coagulates {
            let may_heat = core::mem::take(&mut self.may_heat);
            *self = Self {
                may_heat,
                ..Self::default()
            };
            return None;
        }
        let since = *self.since.get_or_insert(now);
        if self.is_judged || now.saturating_duration_since(since) < JUDGED_AFTER {
            return None;
        }
        self.is_judged = true;
        (!self.is_right).then_some(self.heated)
    }
}

#[cfg(test)]
mod tests {
    use shared_mem::words::EventKind;

    use super::*;

    const FAT: u32 = 0;
    const LIVER: u32 = 1;

    /// Answers of one current of 2 s, in which this organ is heated, if any.
    fn answers(instrument: Instrument, pedals: Switches, organ: Option<u32>) -> Vec<Option<u32>> {
        let mut hook = Hook {
            may_heat: vec![true, false],
            ..Hook::default()
        };
        let tools = ToolFrame {
            instrument: instrument.number(),
            switches: pedals.bits(),
            ..bytemuck::Zeroable::zeroed()
        };
        let begin = Instant::now();
        let frames = 0..20u32;
        let told = frames.filter_map(|number| {
            if let Some(organ) = organ {
                hook.event(&EventMsg {
                    kind: EventKind::Burn.number(),
                    organ,
                    value: 0.1,
                    ..bytemuck::Zeroable::zeroed()
                });
            }
            hook.heats_wrong(&tools, begin + Duration::from_millis(100) * number)
        });
        told.collect()
    }

    #[test]
    fn a_current_that_heats_nothing_or_the_wrong_organ_is_reported_once() {
        let of = |organ| answers(Instrument::Hook, Switches::COAGULATE, organ);
        assert_eq!(of(None), [None], "in the air");
        assert_eq!(of(Some(LIVER)), [Some(LIVER)]);
        assert_eq!(of(Some(FAT)), []);
        assert_eq!(answers(Instrument::Hook, Switches::NONE, None), []);
        let both = Switches::CUT | Switches::COAGULATE;
        assert_eq!(answers(Instrument::Hook, both, None), []);
        assert_eq!(answers(Instrument::Irrigator, Switches::CUT, None), []);
    }

    #[test]
    fn a_released_pedal_forgets_the_current_before() {
        let mut hook = Hook {
            is_right: true,
            is_judged: true,
            heated: Some(LIVER),
            since: Some(Instant::now()),
            may_heat: vec![true],
        };
        let still: ToolFrame = bytemuck::Zeroable::zeroed();
        assert_eq!(hook.heats_wrong(&still, Instant::now()), None);
        assert!(!hook.is_right && !hook.is_judged && hook.heated.is_none());
        assert_eq!(hook.may_heat, [true]);
    }
}
