//! Effects alone, on skins of at most one vertex.

use proptest::prelude::*;
use shared_mem::message::{EventMsg, SphereState, ToolFrame};
use shared_mem::scene::OrganKind;
use shared_mem::words::{CapsuleRole, EventKind, Instrument, Switches};

use super::*;
use crate::skinning::SkinMesh;

fn effect(kind: Kind) -> Effect {
    Effect {
        kind,
        at_m: Vec3::new(0.0, 0.1, 0.0),
        along: Vec3::Y,
        strength: 1.0,
        lasts_s: 1.0,
        flow: Flow {
            ml_min: if kind == Kind::Blood { 30.0 } else { 2.0 },
            pulses: kind == Kind::Blood,
        },
    }
}

fn run(kind: Kind, frame_s: f32, seconds: f32) -> Effects {
    let mesh = SkinMesh::default();
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let mut effects = Effects::new(Vec3::Y);
    effects.begin(&effect(kind), &skin);
    for _ in 0..(seconds / frame_s).round() as u32 {
        effects.advance(frame_s, &skin);
    }
    effects
}

#[test]
fn smoke_gathers_until_it_is_evacuated() {
    let mesh = SkinMesh::default();
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let burnt = run(Kind::Smoke, 0.05, 8.0);
    let gathered = burnt.haze_per_m();
    assert!(gathered > 0.1, "{gathered}");
    assert!(run(Kind::Steam, 0.05, 8.0).haze_per_m() <= 0.0);
    let after = |suction: Option<Vec3>, seconds: u32| {
        let mut effects = burnt.clone();
        effects.draw_off(suction);
        for _ in 0..seconds * 20 {
            effects.advance(0.05, &skin);
        }
        effects.haze_per_m()
    };
    let port = Some(Vec3::new(0.0, 0.3, 0.0));
    assert!(after(None, 10) > 0.7 * gathered);
    assert!(after(port, 10) < 0.1 * gathered);
    assert!(
        after(Some(Vec3::NAN), 10) > 0.7 * gathered,
        "NaN is no place"
    );
}

#[test]
fn puffs_leave_through_the_trocar_that_evacuates_smoke() {
    let mesh = SkinMesh::default();
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let height = |suction: Option<Vec3>| {
        let mut effects = run(Kind::Smoke, 0.05, 1.0);
        effects.draw_off(suction);
        for _ in 0..30 {
            effects.advance(0.05, &skin);
        }
        let puffs = effects.particles();
        puffs.iter().map(|p| p.at_m.y).sum::<f32>() / puffs.len() as f32
    };
    let below = Some(Vec3::new(0.0, -0.2, 0.0));
    assert!(height(below) < height(None) - 0.03);
    let mut beside = run(Kind::Smoke, 0.05, 1.0);
    let mouth = beside.particles()[0].at_m;
    beside.draw_off(Some(mouth));
    let before = beside.particles().len();
    beside.advance(0.05, &skin);
    assert!(beside.particles().len() < before && beside.haze_per_m() <= 0.0);
}

#[test]
fn smoke_rises_and_blood_falls_and_both_end() {
    let all = |effects: &Effects| -> Vec<Particle> {
        let drops = effects.fluids().drops();
        effects.particles().iter().copied().chain(drops).collect()
    };
    let height = |kind| {
        let flying = all(&run(kind, 0.02, 0.5));
        assert!(flying.len() > 3, "{kind:?}");
        flying.iter().map(|p| p.at_m.y).sum::<f32>() / flying.len() as f32
    };
    assert!(height(Kind::Smoke) > 0.105 && height(Kind::Blood) < 0.1);
    for kind in [
        Kind::Smoke,
        Kind::Steam,
        Kind::Sparks,
        Kind::Blood,
        Kind::Bile,
    ] {
        assert!(all(&run(kind, 0.05, 30.0)).is_empty(), "{kind:?}");
    }
}

#[test]
fn effects_do_not_depend_on_the_frame_rate() {
    let [slow, fast] = [0.05, 0.008_333_334].map(|frame| run(Kind::Smoke, frame, 1.0));
    assert!(slow.particles().len().abs_diff(fast.particles().len()) <= 1);
    let (a, b) = (slow.particles()[2], fast.particles()[2]);
    assert!(a.at_m.distance(b.at_m) < 2e-3, "{a:?} {b:?}");
}

#[test]
fn a_cut_vessel_bleeds_in_pulses_until_coagulation_dries_it() {
    let mesh = SkinMesh::default();
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let mut effects = Effects::new(Vec3::Y);
    effects.begin(
        &Effect {
            lasts_s: 20.0,
            ..effect(Kind::Blood)
        },
        &skin,
    );
    let mut thrown = Vec::new();
    let mut before = 0.0;
    for _ in 0..60 {
        effects.advance(0.05, &skin);
        let [blood, ..] = effects.fluids().balance().emptied_ml;
        thrown.push(blood - before);
        before = blood;
    }
    let most = thrown.iter().copied().fold(0.0, f64::max);
    let least = thrown.iter().copied().fold(1.0, f64::min);
    assert!(most > 2.0 * least, "{thrown:?}");
    effects.begin(&effect(Kind::Bile), &skin);
    effects.begin(
        &Effect {
            at_m: Vec3::new(0.0, 0.101, 0.0),
            ..effect(Kind::Steam)
        },
        &skin,
    );
    let kinds: Vec<Kind> = effects.sources.iter().map(|s| s.effect.kind).collect();
    assert_eq!(kinds, [Kind::Bile, Kind::Steam]);
}

#[test]
fn the_flow_of_each_organ_is_that_of_the_metrics() {
    let rules = assess::Rules::default();
    for organ in [
        OrganKind::CysticArtery,
        OrganKind::Vessel,
        OrganKind::CysticDuct,
        OrganKind::Gallbladder,
    ] {
        let event = EventMsg {
            kind: EventKind::Leak.number(),
            value: 0.5,
            ..bytemuck::Zeroable::zeroed()
        };
        let leak = Effect::of_event(&event, Some(organ), &rules).expect("a leak");
        let mut effects = Effects::new(Vec3::Y);
        let mesh = SkinMesh::default();
        let skin = Skin::new(&mesh, &[], &[], &[]);
        effects.begin(&leak, &skin);
        // The effects run for 8.6 s, which are ten heartbeats.
        for _ in 0..86 {
            effects.advance(0.1, &skin);
        }
        let balance = effects.fluids().balance();
        let metric_ml = 0.5 * rules.flow_ml_min(Some(organ)) / 60.0 * 8.6;
        let shown_ml: f64 = balance.leaked_ml.iter().sum();
        assert!(metric_ml > 0.0, "{organ:?}");
        let off = (shown_ml - metric_ml).abs();
        assert!(
            off < 0.02 * metric_ml + 0.006,
            "{organ:?}: {shown_ml} ml, {metric_ml} ml"
        );
    }
}

#[test]
fn a_leak_continues_until_a_report_closes_it() {
    let mesh = SkinMesh::default();
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let mut effects = Effects::new(Vec3::Y);
    let leak = |value, x| {
        let event = EventMsg {
            kind: EventKind::Leak.number(),
            at_m: [x, 0.0, 0.0],
            value,
            ..bytemuck::Zeroable::zeroed()
        };
        Effect::of_event(
            &event,
            Some(OrganKind::CysticDuct),
            &assess::Rules::default(),
        )
        .expect("bile")
    };
    for (value, x) in [(1.0, 0.0), (0.5, 0.0), (1.0, 0.001)] {
        effects.begin(&leak(value, x), &skin);
    }
    for _ in 0..600 {
        effects.advance(0.1, &skin);
    }
    let strengths: Vec<f32> = effects.sources.iter().map(|s| s.effect.strength).collect();
    assert_eq!(strengths, [0.5, 1.0], "a minute later");
    effects.begin(&leak(0.0, 0.0), &skin);
    assert_eq!(effects.sources.len(), 1);
}

#[test]
fn events_and_currents_have_the_effects_of_their_organ_and_switch() {
    let event = |kind| EventMsg {
        kind,
        ..bytemuck::Zeroable::zeroed()
    };
    let rules = assess::Rules::default();
    let shown = |kind, organ| Effect::of_event(&event(kind), organ, &rules).map(|e| e.kind);
    use OrganKind as Organ;
    for (organ, kind) in [
        (Organ::CysticArtery, Some(Kind::Blood)),
        (Organ::Liver, Some(Kind::Blood)),
        (Organ::CysticDuct, Some(Kind::Bile)),
        (Organ::Fat, None),
    ] {
        assert_eq!(
            shown(EventKind::Cut.number(), Some(organ)),
            kind,
            "{organ:?}"
        );
        assert_eq!(shown(EventKind::Contact.number(), Some(organ)), None);
    }
    assert_eq!(shown(EventKind::Cut.number(), None), None);
    for (organ, kind) in [
        (Organ::CysticArtery, Kind::Blood),
        (Organ::CysticDuct, Kind::Bile),
        (Organ::Gallbladder, Kind::Bile),
    ] {
        assert_eq!(shown(EventKind::Leak.number(), Some(organ)), Some(kind));
    }
    let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
    tools.world_from_handle.orientation[3] = 1.0;
    tools.world_from_instrument = tools.world_from_handle;
    tools.world_from_camera = tools.world_from_handle;
    (tools.instrument, tools.contact_count, tools.capsule_count) = (1, 1, 2);
    // The hook's straight part ends 20 mm from the electrode's end.
    tools.capsules[0].role = CapsuleRole::UpperJaw as u32;
    tools.capsules[0].b_m = [0.02, 0.0, 0.0];
    tools.capsules[1].role = CapsuleRole::Tip as u32;
    let mut kinds = |switches, distance_m| {
        tools.switches = switches;
        let touched = [(Vec3::new(distance_m, 0.0, 0.0), 0.004)];
        Effect::of_electrode(&tools, touched.into_iter(), 0.1)
            .iter()
            .map(|e| e.kind)
            .collect::<Vec<_>>()
    };
    assert!(kinds(1, 0.005).contains(&Kind::Sparks) && kinds(2, 0.005).contains(&Kind::Steam));
    assert!(kinds(0, 0.005).is_empty() && kinds(3, 0.005).is_empty());
    // Only the hook's straight part touches the tissue.
    assert!(kinds(1, 0.02).is_empty());
}

#[test]
fn char_grows_with_time_and_blood_leaves_skin_at_right_angles() {
    use bytemuck::Zeroable;
    use shared_mem::message::SphereState;
    use shared_mem::scene::SphereRecord;
    let mesh = SkinMesh {
        vertices: vec![crate::skinning::RestVertex {
            normal: [1.0, 0.0, 0.0],
            ..Zeroable::zeroed()
        }],
        skinned: 1,
        ..SkinMesh::default()
    };
    let (rest, now) = ([SphereRecord::zeroed()], [SphereState::zeroed()]);
    let skin = Skin::new(&mesh, &rest, &now, &[]);
    let burnt = |frames: u32, seconds: f32| {
        let mut effects = Effects::new(Vec3::Y);
        for _ in 0..frames {
            let moment = Effect {
                at_m: Vec3::ZERO,
                lasts_s: seconds / frames as f32,
                ..effect(Kind::Char)
            };
            effects.begin(&moment, &skin);
        }
        effects.stains()[0].radius_m
    };
    assert!((burnt(10, 0.5) - burnt(60, 0.5)).abs() < 1e-6);
    assert!((burnt(10, 0.5) - burnt(10, 0.25) - 0.25 * 0.003).abs() < 1e-6);
    let mut effects = Effects::new(Vec3::Y);
    let bleeds = Effect {
        at_m: Vec3::ZERO,
        along: Vec3::ZERO,
        ..effect(Kind::Blood)
    };
    effects.begin(&bleeds, &skin);
    assert_eq!(effects.sources[0].effect.along, Vec3::X);
}

#[test]
fn work_leaves_char_and_blood_on_the_instrument_until_it_is_exchanged() {
    let mesh = SkinMesh::default();
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
    tools.world_from_handle.orientation[3] = 1.0;
    tools.world_from_instrument = tools.world_from_handle;
    tools.world_from_camera = tools.world_from_handle;
    (tools.instrument, tools.capsule_count) = (1, 2);
    tools.capsules[0].a_m = [0.0, 0.5, 0.0];
    tools.capsules[1].role = 3;
    let mut effects = Effects::new(Vec3::Y);
    effects.hold(&tools);
    let here = |kind, at_m| Effect {
        at_m,
        ..effect(kind)
    };
    effects.begin(&here(Kind::Char, Vec3::X), &skin);
    effects.begin(&here(Kind::Blood, Vec3::X), &skin);
    // Blood that meets the shaft leaves no residue on the jaws.
    effects.begin(&here(Kind::Blood, Vec3::Y * 0.3), &skin);
    effects.advance(0.2, &skin);
    assert!(effects.wear().charred <= 0.0 && effects.wear().bloody <= 0.0);
    effects.begin(&here(Kind::Char, Vec3::X * 0.001), &skin);
    effects.begin(&here(Kind::Blood, Vec3::X * 0.004), &skin);
    effects.advance(0.2, &skin);
    let worn = *effects.wear();
    assert!((worn.charred - 0.2).abs() < 1e-6, "{worn:?}");
    assert!(worn.bloody > 0.05 && worn.bilious <= 0.0, "{worn:?}");
    effects.hold(&tools);
    assert!(effects.wear().charred > 0.0);
    tools.instrument = 0;
    effects.hold(&tools);
    assert!(effects.wear().charred <= 0.0 && effects.wear().bloody <= 0.0);
}

#[test]
fn an_absurd_flow_is_limited() {
    let mesh = SkinMesh::default();
    let skin = Skin::new(&mesh, &[], &[], &[]);
    for ml_min in [1e20, f32::MAX, f32::INFINITY, f32::NAN, -1e20] {
        let mut effects = Effects::new(Vec3::Y);
        let effect = Effect {
            flow: Flow {
                ml_min,
                pulses: true,
            },
            kind: Kind::Blood,
            at_m: Vec3::ZERO,
            along: Vec3::Y,
            strength: 1e20,
            lasts_s: Effect::LEAK_S,
        };
        effects.begin(&effect, &skin);
        effects.advance(0.5, &skin);
        let came = effects.fluids().balance();
        let came_ml = came.leaked_ml[0] + came.emptied_ml[0];
        // 1000 ml/min for half a second, at most at the pressure of a beat's peak.
        assert!((0.0..60.0).contains(&came_ml), "{came_ml} at {ml_min}");
    }
}

proptest! {
    #[test]
    fn effects_survive_any_input(
        at in any::<[f32; 3]>(), along in any::<[f32; 3]>(), strength in any::<f32>(),
        lasts_s in any::<f32>(), seconds in any::<f32>(), times in 0u32..12,
    ) {
        let mesh = SkinMesh::default();
        let skin = Skin::new(&mesh, &[], &[], &[]);
        let mut effects = Effects::new(Vec3::ZERO);
        for kind in [Kind::Smoke, Kind::Blood, Kind::Sparks, Kind::Char] {
            let effect = Effect {
                kind, at_m: at.into(), along: along.into(), strength, lasts_s,
                flow: Flow { ml_min: strength, pulses: true },
            };
            effects.begin(&effect, &skin);
        }
        for _ in 0..times {
            effects.advance(seconds, &skin);
        }
        prop_assert!(effects.particles().len() <= PARTICLES);
        prop_assert!(effects.stains().len() <= STAINS);
        prop_assert!(effects.particles().iter().all(|p| p.at_m.is_finite()));
    }
}

/// Tools with the irrigator's tip at the origin, which points down.
fn irrigator(switches: Switches) -> ToolFrame {
    let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
    // A frame whose poses are not unit quaternions has no capsules.
    tools.world_from_handle.orientation[3] = 1.0;
    tools.world_from_instrument = tools.world_from_handle;
    tools.world_from_camera = tools.world_from_handle;
    tools.instrument = Instrument::Irrigator.number();
    tools.switches = switches.bits();
    tools.capsule_count = 1;
    tools.capsules[0].a_m = [0.0, 0.01, 0.0];
    tools.capsules[0].radius_m = 0.0025;
    tools.capsules[0].role = CapsuleRole::Tip.number();
    tools
}

#[test]
fn pedals_open_the_irrigator_s_water_and_suction() {
    let kinds = |tools: &ToolFrame| {
        let effects = Effect::of_irrigator(tools, 0.1);
        effects.iter().map(|it| it.kind).collect::<Vec<_>>()
    };
    let (cut, coagulate) = (Switches::CUT, Switches::COAGULATE);
    assert_eq!(kinds(&irrigator(cut)), [Kind::Water]);
    assert_eq!(kinds(&irrigator(coagulate)), [Kind::Suction]);
    assert_eq!(
        kinds(&irrigator(cut | coagulate)),
        [Kind::Water, Kind::Suction]
    );
    assert_eq!(kinds(&irrigator(Switches::NONE)), []);
    let mut hook = irrigator(cut);
    hook.instrument = Instrument::Hook.number();
    assert_eq!(kinds(&hook), []);
    let jet = Effect::of_irrigator(&irrigator(cut), 0.1)[0];
    assert!((jet.along - Vec3::NEG_Y).length() < 1e-6);
    assert!(
        (jet.at_m - Vec3::NEG_Y * 0.0025).length() < 1e-6,
        "at its end"
    );
}

#[test]
fn a_moving_irrigator_has_one_jet() {
    let mesh = SkinMesh::default();
    let skin = Skin::new(&mesh, &[], &[], &[]);
    let mut effects = Effects::new(Vec3::Y);
    for step in 0..20u8 {
        let at = Vec3::X * (0.01 * f32::from(step));
        let water = Effect {
            kind: Kind::Water,
            at_m: at,
            lasts_s: 0.15,
            ..effect(Kind::Bile)
        };
        effects.begin(&water, &skin);
        effects.advance(0.1, &skin);
    }
    let came_ml = effects.fluids().balance().leaked_ml[2];
    assert!(
        (came_ml - 2.0 / 60.0 * 2.0).abs() < 0.03,
        "2 ml/min for 2 s: {came_ml}"
    );
}

#[test]
fn tissue_that_boils_steams_until_it_is_dry() {
    let sphere = |heat| {
        let cold = SphereState {
            center_m: [0.0; 3],
            bits: SphereState::AWAKE,
        };
        cold.with_heat(heat)
    };
    let steams = |heat| {
        let spheres = [sphere(heat), sphere([0, 0, 0])];
        let each = spheres.iter().map(|it| (it, 0.002));
        Effect::of_heat(each, Vec3::Y)
    };
    assert_eq!(steams([63, 255, 100]).len(), 1);
    assert!((steams([63, 255, 100])[0].at_m - Vec3::Y * 0.002).length() < 1e-6);
    assert!(steams([63, 255, 255]).is_empty() && steams([50, 200, 0]).is_empty());
}
