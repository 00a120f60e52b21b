//! The first steps, one after the other.

use super::*;

const GALLBLADDER: u32 = 5;

fn first_steps() -> Assessment {
    let organs = [
        ("liver", OrganKind::Liver),
        ("cystic duct", OrganKind::CysticDuct),
        ("cystic artery", OrganKind::CysticArtery),
        ("bile duct", OrganKind::BileDuct),
        ("fat", OrganKind::Fat),
        ("gallbladder", OrganKind::Gallbladder),
    ];
    let anatomy = Anatomy::new(&organs, &[Region::UpperBed]);
    let rules = Rules::default();
    Assessment::new(Task::Basics, Difficulty::Beginner, rules, anatomy)
}

fn done(assessment: &Assessment) -> usize {
    let steps = assessment.status().steps;
    assert_eq!(steps.len(), 5);
    steps.iter().filter(|(_, done)| *done).count()
}

/// Holds the tip at `tip_m` for `seconds`, with the gallbladder in the middle of the picture.
fn rest(assessment: &mut Assessment, from_s: f64, seconds: f64, tip_m: [f32; 3]) {
    let mut seen = nothing_seen();
    seen.organs[GALLBLADDER as usize] = OrganSeen::new(1.0, 0.8, 0.05, 0.1);
    for step in 0..=(seconds * 10.0).round() as u32 {
        let entry = moved(from_s + 0.1 * f64::from(step), here(tip_m));
        assessment.take(&entry);
        let what = EntryContent::Seen(seen);
        assessment.take(&Entry { what, ..entry });
    }
}

fn percent(assessment: &Assessment) -> Option<u8> {
    assessment.status().hint.and_then(|it| it.percent)
}

#[test]
fn each_step_has_its_goal_and_begins_after_the_one_before() {
    let mut it = first_steps();
    let far = [0.1, 0.0, -0.05];
    assert_eq!(it.status().hint.unwrap().advice, Advice::Hold);
    // The organ is in the middle from the start, so the step also asks for a movement of the
    // camera.
    rest(&mut it, 0.0, 3.0, far);
    assert_eq!((done(&it), percent(&it)), (0, Some(0)));
    let mut nearer = here(far);
    nearer.world_from_camera.position_m[2] = -0.02;
    it.take(&moved(3.0, nearer));
    // A grasp before the third step does not count.
    rest(&mut it, 3.0, 1.0, far);
    it.take(&event(
        4.0,
        EventKind::Grasp.number(),
        GALLBLADDER,
        0.0,
        3.0,
    ));
    assert_eq!(done(&it), 0);
    assert_eq!(percent(&it), Some(66), "1 s of 1.5 s");
    rest(&mut it, 4.1, 1.0, far);
    assert_eq!(done(&it), 1, "the organ was in the middle");
    assert_eq!(it.status().hint.unwrap().step, Step::Meet);
    rest(&mut it, 5.2, 3.0, far);
    assert_eq!(done(&it), 1, "the tip is out of view");
    rest(&mut it, 8.3, 1.7, [0.0, 0.0, -0.05]);
    assert_eq!(
        done(&it),
        2,
        "the tip was led into the middle, and held there"
    );

    it.take(&event(10.0, EventKind::Grasp.number(), LIVER, 0.0, 3.0));
    assert_eq!(done(&it), 2, "another organ");
    it.take(&event(
        10.1,
        EventKind::Grasp.number(),
        GALLBLADDER,
        0.0,
        3.0,
    ));
    assert_eq!(done(&it), 3);
    clip(&mut it, 10.2, NOTHING, 0.0, 0.0);
    assert_eq!(done(&it), 3, "a lost clip");
    clip(&mut it, 10.3, ARTERY, 0.0, 1.0);
    assert_eq!(done(&it), 4, "either tube");

    it.take(&event(10.4, EventKind::Burn.number(), FAT, 0.0, 0.2));
    assert_eq!((done(&it), percent(&it)), (4, Some(40)));
    assert!(!it.is_over());
    it.take(&event(10.5, EventKind::Burn.number(), FAT, 0.0, 0.3));
    let status = it.status();
    assert_eq!(status.outcome, Outcome::Passed, "{:?}", status.reasons);
}

#[test]
fn a_tip_that_the_camera_brought_into_the_middle_does_not_end_the_second_step() {
    let mut it = first_steps();
    let middle = [0.0, 0.0, -0.05];
    let mut away = here(middle);
    away.world_from_camera.position_m[0] = 0.05;
    it.take(&moved(0.0, away));
    rest(&mut it, 0.1, 1.7, middle);
    assert_eq!(done(&it), 1, "the camera was led, and the organ shown");
    rest(&mut it, 2.0, 3.0, middle);
    assert_eq!(
        (done(&it), percent(&it)),
        (1, Some(0)),
        "nobody led the tip"
    );
    rest(&mut it, 5.1, 1.7, [0.0, 0.004, -0.05]);
    assert_eq!(done(&it), 1, "less than 5 mm");
    rest(&mut it, 7.0, 0.2, [0.0, 0.006, -0.05]);
    assert_eq!(done(&it), 2, "it was in the middle for long enough");
}

#[test]
fn a_hint_says_how_much_of_a_dissection_is_left() {
    let rules = Rules::default();
    let mut it = Assessment::new(Task::Identify, Difficulty::Beginner, rules, anatomy());
    rest(&mut it, 0.0, 0.5, [0.0; 3]);
    assert_eq!(percent(&it), Some(0));
    remove(&mut it, 0..3);
    // Three of ten cells are removed. Nine must be.
    assert_eq!(percent(&it), Some(33));
    remove(&mut it, 3..9);
    let hint = it.status().hint.unwrap();
    assert_eq!((hint.step, hint.percent), (Step::LowerBed, Some(0)));
}

#[test]
fn an_alarm_knows_its_moment_in_the_recording_and_the_hands() {
    let mut it = begin(Task::Clamp);
    it.take(&moved(0.0, here([0.0, 0.0, -0.1])));
    it.take(&moved(2.0, here([0.0, 0.0, -0.2])));
    clip(&mut it, 2.5, NOTHING, 0.0, 0.0);
    let assessed = it.end();
    is(assessed.alarms[0].session_s, 2.5);
    let hands = assessed.hands[0].unwrap();
    is(hands.tip_m[2].into(), f64::from(-0.2f32));
    is(hands.shaft[2], 1.0);
    assert_eq!(assessed.hands.len(), assessed.alarms.len());
}
