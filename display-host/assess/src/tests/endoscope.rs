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

/// An identity image that shows this organ well.
fn shows(organ: u32) -> Seen {
    let mut seen = nothing_seen();
    seen.organs[organ as usize] = OrganSeen::new(1.0, 0.8, 0.05, 0.3);
    seen
}

#[test]
fn the_drill_is_done_when_each_organ_was_shown() {
    let rules = Rules::default();
    let mut drill = Assessment::new(Task::Scope, Difficulty::Beginner, rules, anatomy());
    // The organs in the order of the drill.
    for (number, organ) in [0.0, 1.0, 2.0].into_iter().zip([DUCT, LIVER, ARTERY]) {
        assert!(!drill.is_over());
        let hint = drill.status().hint.expect("a beginner's");
        assert_eq!(hint.advice, Advice::Hold);
        hold(&mut drill, 2.0 * number, 1.8, &shows(organ));
    }
    assert_eq!(
        drill.status().outcome,
        Outcome::Passed,
        "{:?}",
        drill.status()
    );
}

/// An organ that is hidden, small, outside of the picture or at the picture's rim does not count as
/// shown, whichever organ it is. A large one may be partly outside.
#[test]
fn visible_means_visible() {
    let held = |duct: OrganSeen| {
        let mut drill = begin(Task::Scope);
        let mut seen = nothing_seen();
        seen.organs[DUCT as usize] = duct;
        hold(&mut drill, 0.0, 1.8, &seen);
        let lack = drill.status().hold.and_then(|it| it.lack);
        (drill.status().steps[0].1, lack)
    };
    for (in_view, clear, size, off, lack) in [
        (1.0, 0.3, 0.01, 0.1, Some(Lack::Hidden)),
        (0.3, 1.0, 0.01, 0.1, Some(Lack::OutOfView)),
        (1.0, 1.0, 0.0005, 0.1, Some(Lack::Small)),
        (1.0, 1.0, 0.01, 0.7, Some(Lack::Aside)),
        (0.2, 1.0, 0.3, 0.3, None),
        (1.0, 0.5, 0.01, 0.1, None),
    ] {
        let duct = OrganSeen::new(in_view, clear, size, off);
        let (is_done, why) = held(duct);
        assert_eq!(is_done, lack.is_none(), "{duct:?}");
        assert!(is_done || why == lack, "{duct:?} {why:?}");
    }
}

/// Sway and score of a drill whose endoscope trembles by this much, rad, at this frequency, Hz.
fn drill(tremor_rad: f64, hz: f64) -> [f64; 2] {
    let mut drill = begin(Task::Scope);
    for step in 0..=1600 {
        let at_s = f64::from(step) * 0.01;
        let half = 0.5 * tremor_rad * (at_s * hz * std::f64::consts::TAU).sin();
        let mut look = here([0.0, 0.0, 0.3]);
        look.world_from_camera.orientation = [half.sin() as f32, 0.0, 0.0, half.cos() as f32];
        drill.take(&moved(at_s, look));
        if step % 20 == 0 {
            let mut seen = shows(DUCT);
            for organ in [LIVER, ARTERY] {
                seen.organs[organ as usize] = seen.organs[DUCT as usize];
            }
            let what = EntryContent::Seen(seen);
            let entry = moved(at_s, look);
            drill.take(&Entry { what, ..entry });
        }
    }
    let drill = drill.end();
    assert_eq!(drill.outcome, Outcome::Passed, "{:?}", drill.reasons);
    assert!(drill.metrics.get(Metric::OutOfView) > 4.0);
    [drill.metrics.get(Metric::ScopeSway), drill.score]
}

#[test]
fn a_drill_costs_points_for_a_picture_that_sways_and_none_for_the_instrument() {
    let [still, whole] = drill(0.0, 4.0);
    is(still, 0.0);
    is(whole, 100.0);
    let [sways, score] = drill(0.025, 4.0);
    assert!((6.0..30.0).contains(&sways), "{sways} mm/s");
    assert!((70.0..100.0 - 1.0).contains(&score), "{score}");
}

/// A hand trembles by 0.2 mm at most, at 8 to 12 Hz. A lens that turns about its port, as far from
/// the hand as from the place in the picture, shows 0.2 mm there: 2 mrad, 10 cm before the lens.
#[test]
fn tremor_of_a_hand_costs_no_points_in_the_drill() {
    for hz in [8.0, 10.0, 12.0] {
        let [sways, score] = drill(0.002, hz);
        is(sways, 0.0);
        is(score, 100.0);
    }
}

/// A novice's endoscope sways by 6 mm to both sides every 1.2 s: 20 mm/s on the mean, and 31 mm/s
/// at its fastest. The drill can be done, and the score tells of the sway.
#[test]
fn a_drill_with_slow_sway_is_done_and_scored_by_it() {
    let [sways, score] = drill(0.06, 1.0 / 1.2);
    assert!((15.0..25.0).contains(&sways), "{sways} mm/s");
    assert!((78.0..92.0).contains(&score), "{score}");
}
