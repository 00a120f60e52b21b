//! Stones that spill from a patient's perforated gallbladder: one is picked up, others are left.

use assess::{Metric, Task};
use shared_mem::message::StoneMsg;
use surgeon::{Seen, Surgeon};

use crate::theatre::{patient, start, work};

/// Stones of 4 mm, so that some leave through a burnt hole.
const PATIENT: &str = "clara";
const STONES: usize = 20;

/// The others are counted as left behind.
#[test]
fn a_spilled_stone_is_picked_up() {
    let scene = patient(PATIENT);
    let mut most = 0;
    let mut held = 0;
    let mut sunk_m = f32::MIN;
    let mut watch = |seen: &Seen, assessed: &assess::Assessment| {
        let stones = seen.state.stones().expect("sane stones");
        most = most.max(stones.len());
        held += stones.iter().filter(|it| it.is_held != 0).count();
        // What the events say and what lies in the body agree at any moment.
        let values = assessed.metrics();
        let left = values.get(Metric::StonesLeft) as usize;
        assert!(stones.len() <= left, "{} of {left}", stones.len());
        // Jaws may draw what they hold through tissue.
        for stone in stones.iter().filter(|it| it.is_held == 0) {
            sunk_m = sunk_m.max(depth_m(stone, seen, &scene));
        }
    };
    let task = Task::Identify;
    let times_s = [95.0, 0.0];
    let result = work(
        start(task),
        Surgeon::StonePicker,
        task,
        &scene,
        times_s,
        &mut watch,
    );
    let metrics = &result.assessed.metrics;
    let counts = [
        Metric::StonesSpilled,
        Metric::StonesRetrieved,
        Metric::StonesLeft,
    ];
    let [spilled, out, left] = counts.map(|it| metrics.get(it) as usize);
    println!(
        "{spilled} spilled, {out} out, {left} left, {most} at once, {sunk_m} m; {:?}",
        result.said
    );
    assert!(
        (2..=STONES).contains(&spilled),
        "{spilled}: {:?}",
        result.said
    );
    assert_eq!(out, 1, "{:?}", result.said);
    assert_eq!(left, spilled - out);
    assert!(held > 0 && most > 1);
    // The spheres lie up to a few millimetres under the skin.
    assert!(
        sunk_m < 0.001,
        "a stone is {sunk_m} m in a sphere of the tissue"
    );
    let lost = &result.assessed.lost;
    assert!(lost.iter().any(|it| it.metric == "stones_left"), "{lost:?}");
    let moments = &result.assessed.moments;
    assert!(moments.iter().any(|it| it.what == "stone_retrieved"));
}

/// Depth of a stone's middle in any sphere of tissue that is there, m.
fn depth_m(stone: &StoneMsg, seen: &Seen, scene: &shared_mem::scene::SceneFile) -> f32 {
    use shared_mem::message::SphereState;
    let spheres = seen.state.spheres().expect("sane spheres").iter();
    let there = spheres
        .zip(scene.spheres())
        .filter(|(now, _)| now.bits & SphereState::GONE == 0);
    let depths = there.map(|(now, rest)| {
        let apart2: f32 = (0..3)
            .map(|k| (now.center_m[k] - stone.at_m[k]).powi(2))
            .sum();
        rest.radius_m - apart2.sqrt()
    });
    depths.fold(f32::MIN, f32::max)
}
