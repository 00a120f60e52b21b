//! Causes of effects: events of the controller, and the electrode.

use assess::Rules;
use glam::Vec3;
use shared_mem::message::{Event, EventMsg, SphereState, ToolFrame};
use shared_mem::scene::OrganKind;
use shared_mem::words::{CapsuleRole, Current, Instrument, Switches};

/// A current acts on touched tissue within this distance of the electrode's tip, m.
const TIP_M: f32 = 0.003;
/// Temperature above the body's from which water boils, K. The controller keeps boiling tissue at
/// 63.
const BOILS_K: u8 = 62;
/// Lost water at which tissue stops steaming, in 255ths of all its water.
const DRY: u8 = 250;
/// Largest number of places that steam at a time.
const STEAMING: usize = 4;
/// Duration of the steam of a boiling place, s.
const STEAMS_S: f32 = 0.15;
/// Flow of the irrigator's water, ml/min. Assumed: a gentle jet. Pressure bags give 1000 and more.
const RINSES_ML_MIN: f32 = 240.0;
/// Duration of a leak, s: ten hours. A source of this duration or more counts as a leak. It
/// continues until an event changes or closes it.
pub(super) const LEAK_S: f32 = 36_000.0;

/// Kind of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Smoke of burnt tissue, which drifts and gathers in the cavity.
    Smoke,
    /// Steam of boiling water: white, and gone within a second.
    Steam,
    /// Sparks of a cutting current.
    Sparks,
    /// Blood, which runs down, drips and gathers in pools. From an artery it spurts.
    Blood,
    /// Bile, which runs down, drips and gathers in pools.
    Bile,
    /// Charring of the surface.
    Char,
    /// Jet of the irrigator's water.
    Water,
    /// Suction at the irrigator's tip.
    Suction,
}

/// An effect to start. Lengths in m, world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    /// Kind of the effect.
    pub kind: Kind,
    /// Position.
    pub at_m: Vec3,
    /// Direction in which the particles leave, of any length. Zero means along the skin's normal
    /// for blood and bile, and upwards otherwise.
    pub along: Vec3,
    /// Strength. 1 is the leak of a divided cystic artery, or the full current of a hook.
    pub strength: f32,
    /// Duration of the source, s. Char appears at once, as wide as a current of this duration burns
    /// it.
    pub lasts_s: f32,
    /// Flow of blood or bile at strength 1. Other kinds have no flow.
    pub flow: Flow,
}

/// Flow of blood or bile from a source of strength 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flow {
    /// Mean flow, ml/min.
    pub ml_min: f32,
    /// True if the flow spurts with the heartbeat, as from an artery; false if it oozes.
    pub pulses: bool,
}

impl Flow {
    /// Flow from an organ of this kind when it is fully open. The flow comes from the rules that
    /// assess the operation, so that the picture and the metrics have the same volume.
    #[must_use]
    pub fn of_organ(rules: &Rules, organ: OrganKind) -> Self {
        let pulses = matches!(organ, OrganKind::CysticArtery | OrganKind::Vessel);
        Self {
            ml_min: rules.flow_ml_min(Some(organ)) as f32,
            pulses,
        }
    }
}

impl Effect {
    /// Duration that marks an effect as a leak, s. A leak flows until a report closes it.
    pub const LEAK_S: f32 = LEAK_S;

    /// True for the report of a leak, which lasts until another report changes or closes it.
    #[must_use]
    pub fn is_leak(&self) -> bool {
        self.lasts_s >= LEAK_S
    }

    /// Effect of an event on an organ of this kind. `None` if the event has no effect. Ducts leak
    /// bile, and so does a gallbladder that leaks or is perforated. Other organs bleed, except fat
    /// and connective tissue. The rules name the flow of each kind of organ.
    #[must_use]
    pub fn of_event(event: &EventMsg, organ: Option<OrganKind>, rules: &Rules) -> Option<Self> {
        use OrganKind as Organ;
        let event_kind = event.decode().ok()?;
        let (kind, much) = match organ? {
            Organ::CysticDuct | Organ::BileDuct => (Kind::Bile, 1.0),
            Organ::CysticArtery | Organ::Vessel => (Kind::Blood, 1.0),
            Organ::Fat | Organ::ConnectiveTissue => return None,
            Organ::Gallbladder
                if matches!(event_kind, Event::Leak { .. } | Event::Perforation { .. }) =>
            {
                (Kind::Bile, 1.0)
            }
            // Only tubes and bands tear. So a tear or cut of the gallbladder lies in its bed, which
            // bleeds a little.
            _ => (Kind::Blood, 0.5),
        };
        let is_tube = matches!(
            organ?,
            Organ::CysticDuct | Organ::BileDuct | Organ::CysticArtery | Organ::Vessel
        );
        let (strength, lasts_s) = match event_kind {
            // The content of the tube flows out. If a leak remains, it has events of its own.
            Event::Tear { .. } | Event::Cut { .. } if is_tube => (0.5 * much, 1.5),
            Event::Tear { .. } => (0.5 * much, 6.0),
            Event::Cut { .. } => (much, 10.0),
            Event::Perforation { .. } => (0.5 * much, 1.5),
            Event::Leak { flow } => (flow * much, LEAK_S),
            _ => return None,
        };
        Some(Self {
            kind,
            at_m: Vec3::from(event.at_m),
            along: Vec3::ZERO,
            strength,
            lasts_s,
            flow: Flow::of_organ(rules, organ?),
        })
    }

    /// Effects of the irrigator during `seconds`: the cutting pedal opens its water, the
    /// coagulating pedal its suction. Both may be open.
    #[must_use]
    pub fn of_irrigator(tools: &ToolFrame, seconds: f32) -> Vec<Self> {
        let tip = tools
            .capsules()
            .and_then(|c| c.iter().find(|c| c.is(CapsuleRole::Tip)));
        let Some(tip) = tip.filter(|_| tools.has(Instrument::Irrigator)) else {
            return Vec::new();
        };
        let (from_m, mouth_m) = (Vec3::from(tip.a_m), Vec3::from(tip.b_m));
        let along = (mouth_m - from_m).normalize_or(Vec3::NEG_Y);
        let effect = |kind, ml_min| Self {
            kind,
            at_m: mouth_m + along * tip.radius_m,
            along,
            strength: 1.0,
            // The effect lasts a little longer than `seconds`, so that it does not stop while the
            // pedal is down.
            lasts_s: seconds + 0.05,
            flow: Flow {
                ml_min,
                pulses: false,
            },
        };
        let pedals = [
            (Switches::CUT, effect(Kind::Water, RINSES_ML_MIN)),
            (Switches::COAGULATE, effect(Kind::Suction, 0.0)),
        ];
        let open = pedals
            .into_iter()
            .filter(|it| tools.switches().contains(it.0));
        open.map(|it| it.1).collect()
    }

    /// Steam of the tissue that boils, wherever heat has spread. `spheres` are those of the scene,
    /// each with its radius, m. `up` points against gravity.
    #[must_use]
    pub fn of_heat<'a>(
        spheres: impl Iterator<Item = (&'a SphereState, f32)>,
        up: Vec3,
    ) -> Vec<Self> {
        let boils = spheres.filter(|(it, _)| it.rise_k() >= BOILS_K && it.dried() < DRY);
        let steam = boils.map(|(it, radius_m)| Self {
            kind: Kind::Steam,
            at_m: Vec3::from(it.center_m) + up * radius_m,
            along: up,
            strength: 0.4,
            lasts_s: STEAMS_S,
            flow: Flow::default(),
        });
        steam.take(STEAMING).collect()
    }

    /// Effects of an electrode in contact with tissue during `seconds`. Cutting (switch 1) sparks,
    /// and smokes and chars a little. Coagulation (switch 2) smokes, steams and chars. `touched`
    /// gives the centre and the radius, m, of each sphere in contact with any tool. Only spheres at
    /// the electrode's tip count, because a shaft that rests on tissue burns nothing.
    #[must_use]
    pub fn of_electrode(
        tools: &ToolFrame,
        mut touched: impl Iterator<Item = (Vec3, f32)>,
        seconds: f32,
    ) -> Vec<Self> {
        let current = tools.switches().current();
        // With both switches pressed the controller passes no current.
        if !tools.has(Instrument::Hook) || current == Current::Off {
            return Vec::new();
        }
        let Some(tip) = tools
            .capsules()
            .and_then(|c| c.iter().find(|c| c.is(CapsuleRole::Tip)))
        else {
            return Vec::new();
        };
        let at_m = Vec3::from(tip.b_m);
        if !touched.any(|(center, radius_m)| center.distance(at_m) < radius_m + TIP_M) {
            return Vec::new();
        }
        let along = (Vec3::from(tip.a_m) - at_m).normalize_or(Vec3::Y);
        let effect = |kind, strength| Self {
            kind,
            at_m,
            along,
            strength,
            flow: Flow::default(),
            // Effects other than char last a little longer than `seconds`, so that they do not stop
            // while the electrode is on.
            lasts_s: if kind == Kind::Char {
                seconds
            } else {
                seconds + 0.05
            },
        };
        if current == Current::Cut {
            vec![
                effect(Kind::Sparks, 1.0),
                effect(Kind::Smoke, 0.5),
                effect(Kind::Char, 0.4),
            ]
        } else {
            vec![
                effect(Kind::Smoke, 1.0),
                effect(Kind::Steam, 0.6),
                effect(Kind::Char, 1.0),
            ]
        }
    }
}
