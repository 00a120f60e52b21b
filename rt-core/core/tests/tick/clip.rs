//! Clips: the tubes that they close, and those that they do not.

use super::grip::count;
use super::vessel::{artery, divided, leaks, tip_past, use_instrument};
use super::*;
use rt_core::tool::Instrument;

/// Events of clips: organ and number.
fn reported(bench: &Bench) -> Vec<(Option<u32>, f32)> {
    let clips = bench.events.iter().filter(|it| it.kind == EventKind::Clip);
    clips.map(|it| (it.organ, it.value)).collect()
}

#[test]
fn a_clip_before_the_cut_keeps_the_blood_in_and_scissors_do_not_cut_it() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::ClipApplier,
        &tip_past(-0.0075),
    );
    assert_eq!(reported(&bench), [(Some(0), 0.0)]);
    assert_eq!((bench.clips.len(), bench.clips_left), (1, 11));
    let clip = bench.clips[0];
    assert!(
        clip.closed > 0.999 && (norm(&clip.legs) - 1.0).abs() < 1.0e-4,
        "{clip:?}"
    );
    assert_eq!(clip.spheres, [7, 8]);
    // Seven links lie before the clip's link.
    let event = |kind| bench.events.iter().find(|it| it.kind == kind).unwrap();
    let [closes, along] = [EventKind::ClipCloses, EventKind::ClipAlong].map(event);
    assert!((closes.value - clip.closed).abs() < 1.0e-6, "{closes:?}");
    let link_m = anatomy.links[0].rest_length_m;
    let expected_m = (7.0 + clip.share) * link_m;
    assert!(
        (along.value - expected_m).abs() < 1.0e-5,
        "{along:?} {expected_m}"
    );
    assert_eq!((closes.organ, along.organ), (Some(0), Some(0)));
    // Scissors on the clip itself, which is metal.
    let at_m = (bench.centers_m[7] + bench.centers_m[8]) * 0.5;
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(at_m.x),
    );
    assert_eq!(count(&bench, EventKind::Cut), 0);
    // Scissors next to the clip.
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(0.0015),
    );
    assert_eq!(count(&bench, EventKind::Cut), 1);
    assert!(leaks(&bench).is_empty(), "{:?}", leaks(&bench));
    assert_eq!(divided(&bench), [1.0], "what goes away is open");
    // The clip has moved with the tissue, and still lies across the tube.
    let clip = bench.clips[0];
    let along = bench.centers_m[8] - bench.centers_m[7];
    assert!(clip.legs.dot(&along).abs() < 1.0e-3 * norm(&along));
}

#[test]
fn both_sides_are_closed_only_after_a_cut_between_clips() {
    // Places of two cuts along the tube, m, and the open share that each reports. Clips lie at
    // -0.0105 and 0.0105.
    for (at_m, open) in [
        ([-0.0165, 0.0015], [1.0, 0.0]),
        ([0.0165, 0.0015], [1.0, 0.0]),
    ] {
        let anatomy = artery();
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        for clip_m in [-0.0105, 0.0105] {
            let at = tip_past(clip_m);
            use_instrument(&mut sim, &mut bench, Instrument::ClipApplier, &at);
        }
        assert_eq!(bench.clips.len(), 2, "{:?}", bench.clips);
        for at_m in at_m {
            use_instrument(&mut sim, &mut bench, Instrument::Scissors, &tip_past(at_m));
        }
        assert_eq!(divided(&bench), open, "{at_m:?} {:?}", bench.clips);
        // A third cut, between the two divisions: both stumps end at a division, so no lumen is
        // open.
        let middle_m = (bench.centers_m[8] + bench.centers_m[9]) * 0.5;
        let at = middle_m + tip_past(-0.0005);
        use_instrument(&mut sim, &mut bench, Instrument::Scissors, &at);
        assert_eq!(divided(&bench).get(2), Some(&0.0), "{:?}", bench.clips);
    }
}

#[test]
fn a_clip_on_the_bleeding_stump_stops_it_and_a_reset_takes_it_off() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(0.0105),
    );
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::ClipApplier,
        &tip_past(-0.0105),
    );
    let values: Vec<f32> = leaks(&bench).iter().map(|leak| leak.0).collect();
    assert_eq!(values.len(), 2, "{values:?} {:?}", bench.clips);
    assert!(values[0] > 0.99 && values[1] < 0.01, "{values:?}");
    bench.next_at(&AWAY, NONE).command = Some(Command::Reset);
    sim.tick(&mut bench);
    assert_eq!((bench.clips.len(), bench.clips_left), (0, 12));
    let reported = bench.events.iter().filter(|it| it.kind == EventKind::Reset);
    assert_eq!(reported.count(), 1);
}

#[test]
fn a_clip_over_part_of_a_vessel_closes_part_of_it() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let at = Vec3::new(-0.0075, 0.0, -0.0005);
    use_instrument(&mut sim, &mut bench, Instrument::ClipApplier, &at);
    assert_eq!(bench.clips.len(), 1);
    let closed = bench.clips[0].closed;
    assert!((0.2..0.95).contains(&closed), "{closed}");
    use_instrument(
        &mut sim,
        &mut bench,
        Instrument::Scissors,
        &tip_past(0.0015),
    );
    let leaks = leaks(&bench);
    assert!(
        leaks.len() == 1 && (leaks[0].0 - (1.0 - closed)).abs() < 0.01,
        "{leaks:?}"
    );
}

#[test]
fn a_clip_on_nothing_is_lost_and_the_thirteenth_is_none() {
    let anatomy = artery();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let aside = tip_past(0.0) + Vec3::y() * 0.02;
    bench.next_at(&aside, NONE).command = Some(Command::Instrument(Instrument::ClipApplier));
    sim.tick(&mut bench);
    for _ in 0..14 {
        hold_tip(&mut sim, &mut bench, &aside, 200, Buttons::GRASP);
        hold_tip(&mut sim, &mut bench, &aside, 200, NONE);
    }
    let numbers: Vec<f32> = reported(&bench).iter().map(|clip| clip.1).collect();
    assert_eq!(numbers, (0..12).map(|i| i as f32).collect::<Vec<_>>());
    assert!(reported(&bench).iter().all(|clip| clip.0.is_none()));
    assert_eq!((bench.clips.len(), bench.clips_left), (0, 0));
}
