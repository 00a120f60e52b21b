//! The drills on the phantom, one after the other.

use super::*;

const PARTS: [(&str, OrganKind); 7] = [
    ("board", OrganKind::AbdominalWall),
    ("upper left ball", OrganKind::Liver),
    ("right ball", OrganKind::Liver),
    ("lower left ball", OrganKind::Liver),
    ("rope", OrganKind::Gallbladder),
    ("tube", OrganKind::CysticDuct),
    ("fat", OrganKind::Fat),
];

fn part(name: &str) -> u32 {
    let found = PARTS.iter().position(|it| it.0 == name);
    u32::try_from(found.unwrap()).unwrap()
}

/// The phantom, whose organs all have their middle at the origin, and fat of twenty cells.
fn drills() -> Assessment {
    let anatomy = Anatomy::new(&PARTS, &[Region::Elsewhere; 20]);
    assert_eq!(Task::Phantom.lacks(&anatomy), None);
    let rules = Rules::default();
    Assessment::new(Task::Phantom, Difficulty::Beginner, rules, anatomy)
}

/// Tools at rest, with the tip 10 cm before the endoscope.
fn seen(tip_m: [f32; 3]) -> Movement {
    let [x, y, z] = tip_m;
    let mut camera = PoseMsg::IDENTITY;
    camera.position_m = [x, y, z + 0.1];
    Movement {
        world_from_camera: camera,
        ..here(tip_m)
    }
}

fn done(assessment: &Assessment) -> usize {
    let steps = assessment.status().steps;
    assert_eq!(steps.len(), 7);
    steps.iter().filter(|(_, done)| *done).count()
}

#[test]
fn each_drill_begins_after_the_one_before() {
    let mut it = drills();
    let far = [0.1, 0.0, 0.0];
    it.take(&moved(0.0, seen(far)));
    let mut at_s = 0.0;
    let mut raise = |it: &mut Assessment, kind: EventKind, name: &str, value: f32| {
        at_s += 0.1;
        it.take(&event(at_s, kind.number(), part(name), 0.0, value));
        done(it)
    };
    assert_eq!(raise(&mut it, EventKind::Contact, "right ball", 0.1), 0);
    assert_eq!(
        raise(&mut it, EventKind::Contact, "upper left ball", 0.1),
        1
    );
    assert_eq!(
        raise(&mut it, EventKind::Contact, "lower left ball", 0.1),
        2
    );
    assert_eq!(raise(&mut it, EventKind::Contact, "right ball", 0.1), 3);
    let hint = it.status().hint.unwrap();
    assert_eq!(hint.advice, Advice::Use(Instrument::Grasper));

    // What the jaws hold matters, and where they are.
    let near = [0.013, 0.0, 0.0];
    it.take(&moved(1.0, seen(near)));
    assert_eq!(done(&it), 3, "empty jaws");
    raise(&mut it, EventKind::Grasp, "board", 3.0);
    it.take(&moved(1.1, seen(near)));
    assert_eq!(done(&it), 3, "the board");
    raise(&mut it, EventKind::Grasp, "rope", 3.0);
    it.take(&moved(1.2, seen([0.015, 0.0, 0.0])));
    assert_eq!(done(&it), 3, "too far");
    raise(&mut it, EventKind::LetGo, "rope", 3.0);
    it.take(&moved(1.3, seen(near)));
    assert_eq!(done(&it), 3, "let go before");
    raise(&mut it, EventKind::Grasp, "rope", 3.0);
    it.take(&moved(1.4, seen(near)));
    assert_eq!(done(&it), 4);

    clip(&mut it, 2.0, part("tube"), 0.0, 0.0);
    let percent = |it: &Assessment| it.status().hint.and_then(|it| it.percent);
    assert_eq!((done(&it), percent(&it)), (4, Some(50)));
    clip(&mut it, 2.1, part("tube"), 0.01, 1.0);
    assert_eq!(done(&it), 5);
    cut(&mut it, 2.2, part("tube"));
    assert_eq!(done(&it), 6);
    remove(&mut it, 0..1);
    it.take(&moved(2.5, seen(far)));
    assert!(it.is_over(), "one of twenty cells");
    let status = it.status();
    assert_eq!(status.outcome, Outcome::Passed, "{:?}", status.reasons);
}

#[test]
fn a_cut_without_clips_fails_the_drills() {
    let mut it = drills();
    it.take(&moved(0.0, seen([0.0; 3])));
    cut_open(&mut it, 0.5, part("tube"), 1.0);
    assert_eq!(it.status().outcome, Outcome::Failed);
}

#[test]
fn other_scenes_have_no_drills() {
    let lacks = Task::Phantom.lacks(&anatomy()).unwrap();
    assert!(lacks.contains("phantom"), "{lacks}");
}

#[test]
fn recordings_know_the_endoscope_drill_by_its_name() {
    assert_eq!(Task::Scope.name(), session::ENDOSCOPE_DRILL);
}
