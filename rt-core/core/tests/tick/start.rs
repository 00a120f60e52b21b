//! Each task begins at the end of the task before it.

use super::vessel::artery;
use super::*;
use rt_core::scene::{Anchor, Inside};
use rt_core::sim::Task;

/// An artery that comes from the left and is attached to a bag of bile at its right.
pub(super) fn anatomy() -> Anatomy {
    let (center_m, half_axes_m) = (Vec3::new(0.05, 0.0, 0.0), Vec3::new(0.018, 0.018, 0.018));
    let mut anatomy = artery().with_ellipsoid(center_m, half_axes_m, 60, 200);
    anatomy.organs[1].inside = Inside::Bile;
    let distance_m = |i: usize| norm(&(anatomy.spheres[i].center_m - anatomy.spheres[20].center_m));
    let nearest = (21..81)
        .min_by(|a, b| distance_m(*a).total_cmp(&distance_m(*b)))
        .expect("spheres");
    let tie = &mut anatomy.attachments[0];
    tie.to = Anchor::Sphere(nearest as u32);
    tie.rest_length_m = distance_m(nearest);
    anatomy
}

/// Runs the first ticks of a task.
pub(super) fn begin_with(sim: &mut Sim<'_>, task: Task, ticks: u32) -> Bench {
    let mut bench = Bench::new();
    hold_tip(sim, &mut bench, &AWAY, 100, NONE);
    bench.next_at(&AWAY, NONE).command = Some(Command::Start(task));
    sim.tick(&mut bench);
    hold_tip(sim, &mut bench, &AWAY, ticks, NONE);
    bench
}

/// Runs the first second of a task. Returns the bench, and the first sphere of each link of the
/// tube that is then longer than 4 mm (3 mm at rest).
fn begin(task: Task) -> (Bench, Vec<usize>) {
    let anatomy = anatomy();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let bench = begin_with(&mut sim, task, 1000);
    let tube = bench.centers_m[..21].windows(2).enumerate();
    let stretched = tube.filter(|(_, pair)| norm(&(pair[1] - pair[0])) > 0.004);
    let stretched = stretched.map(|(i, _)| i).collect();
    (bench, stretched)
}

#[test]
fn task_starts_with_the_earlier_tasks_done() {
    for (task, clips, is_divided) in [
        (Task::Identify, 0, false),
        (Task::Clamp, 0, false),
        (Task::Cut, 3, false),
        (Task::Disconnect, 3, true),
    ] {
        let (bench, stretched) = begin(task);
        assert_eq!(
            (bench.clips.len(), bench.clips_left),
            (clips, 12 - clips as u32),
            "{task:?}"
        );
        assert_eq!(!stretched.is_empty(), is_divided, "{task:?} {stretched:?}");
        let reported = bench.events.iter().map(|it| it.kind);
        let reported: Vec<_> = reported.filter(|it| *it != EventKind::Fault).collect();
        assert_eq!(reported, [EventKind::Reset], "{task:?}");
        if let [link] = stretched[..] {
            let places: Vec<u32> = bench.clips.iter().map(|clip| clip.spheres[0]).collect();
            assert!(
                places[1] < link as u32 && (link as u32) < places[2],
                "{places:?} {link}"
            );
        }
    }
}
