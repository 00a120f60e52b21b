//! The endoscope: its view and its drill.

use super::*;

#[test]
fn view_of_an_angled_endoscope_is_not_that_of_its_shaft() {
    let away_s = |looks_off: Option<f32>, tip_m: [f32; 3]| {
        let mut assessment = begin(Task::Free);
        if let Some(degrees) = looks_off {
            let (off_rad, turned_rad) = (degrees.to_radians(), 0.0);
            let what = EntryContent::Sight {
                off_rad,
                turned_rad,
            };
            assessment.take(&Entry {
                tick: 0,
                at_ns: 0,
                what,
            });
        }
        for step in 0..=20 {
            assessment.take(&moved(0.1 * f64::from(step), here(tip_m)));
        }
        assessment.end().metrics.get(Metric::OutOfView)
    };
    let (ahead, below) = ([0.0, 0.0, -0.1], [0.0, -0.1, -0.1]);
    is(away_s(None, ahead), 0.0);
    is(away_s(Some(0.0), below), 2.0);
    is(away_s(Some(45.0), below), 0.0);
    is(away_s(Some(45.0), ahead), 2.0);
}

#[test]
fn the_drill_is_done_when_each_organ_was_shown() {
    let mut organs = anatomy();
    for (number, organ) in organs.organs.iter_mut().enumerate() {
        organ.middle_m = [0.05 * number as f64, 0.0, -0.1];
    }
    let mut drill = Assessment::new(Task::Scope, Difficulty::Beginner, Rules::default(), organs);
    let mut at_s = 0.0;
    // In the order of the drill: cystic duct, liver, cystic artery.
    for number in [1, 0, 2] {
        assert!(!drill.is_over());
        let hint = drill.status().hint.expect("a beginner's");
        assert_eq!(hint.advice, Advice::Hold);
        for _ in 0..20 {
            let mut look = here([0.0, 0.0, -0.1]);
            look.world_from_camera.position_m[0] = 0.05 * number as f32;
            drill.take(&moved(at_s, look));
            at_s += 0.1;
        }
    }
    assert_eq!(
        drill.status().outcome,
        Outcome::Passed,
        "{:?}",
        drill.status()
    );
}

/// Sway and score of a drill whose endoscope trembles by this much, rad, at 4 Hz.
fn drill(tremor_rad: f64) -> [f64; 2] {
    let mut organs = anatomy();
    for organ in &mut organs.organs {
        organ.middle_m = [0.0, 0.0, -0.1];
    }
    let rules = Rules::default();
    let mut drill = Assessment::new(Task::Scope, Difficulty::Trainee, rules, organs);
    for step in 0..=600 {
        let at_s = f64::from(step) * 0.01;
        let half = 0.5 * tremor_rad * (at_s * 4.0 * std::f64::consts::TAU).sin();
        let mut look = here([0.0, 0.0, 0.3]);
        look.world_from_camera.orientation = [half.sin() as f32, 0.0, 0.0, half.cos() as f32];
        drill.take(&moved(at_s, look));
    }
    let drill = drill.end();
    assert_eq!(drill.outcome, Outcome::Passed, "{:?}", drill.reasons);
    assert!(drill.metrics.get(Metric::OutOfView) > 4.0);
    [drill.metrics.get(Metric::ScopeSway), drill.score]
}

#[test]
fn a_drill_costs_points_for_a_picture_that_sways_and_none_for_the_instrument() {
    let [still, whole] = drill(0.0);
    is(still, 0.0);
    is(whole, 100.0);
    let [sways, score] = drill(0.03);
    assert!((10.0..60.0).contains(&sways), "{sways} mm/s");
    assert!((70.0..100.0 - 5.0).contains(&score), "{score}");
}
