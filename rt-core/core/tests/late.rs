//! A late tick omits optional work, but never the force.

mod rig;

use rig::{Anatomy, Bench, PAPER, TOUCH, method, paper};
use rt_core::math::{Vec3, norm};
use rt_core::port::{Buttons, ForceCommand};
use rt_core::sim::{Optional, Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use rt_core::words::SphereBits;

const FORCE_ENABLED: Parameters = Parameters {
    force_ramp_s: 0.05,
    force_enabled: true,
};
/// Spheres of the liver; the gallbladder's follow.
const LIVER: usize = 581;

/// A bench that has time only for the optional work for which `has_time` returns true.
struct Late {
    bench: Bench,
    has_time: fn(Optional) -> bool,
    asked: Vec<Optional>,
}

impl Ports for Late {
    fn sample(&mut self) -> Samples {
        self.bench.sample()
    }
    fn send_force(&mut self, command: ForceCommand) {
        self.bench.send_force(command);
    }
    fn publish(&mut self, view: &TickView<'_>) {
        self.bench.publish(view);
    }
    fn may(&mut self, work: Optional) -> bool {
        self.asked.push(work);
        (self.has_time)(work)
    }
    fn stamp(&mut self, stage: Stage) {
        self.bench.stamp(stage);
    }
}

/// Presses on the liver, far from the gallbladder, for 400 ticks with time for all work, then for
/// 100 ticks with time as `has_time` says. Returns the ports, and the centres of the spheres after
/// the 400 ticks.
fn press(has_time: fn(Optional) -> bool) -> (Late, Vec<Vec3>) {
    let anatomy = Anatomy::liver_and_gallbladder();
    let (mut state, mut paper) = (Box::new(State::new()), paper(Some(PAPER)));
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    sim.solve_by(method(&mut paper));
    let mut late = Late {
        bench: Bench::new(),
        has_time: |_| true,
        asked: Vec::new(),
    };
    let mut before = Vec::new();
    for t in 0..500 {
        if t == 400 {
            late.has_time = has_time;
            before.clone_from(&late.bench.centers_m);
        }
        late.asked.clear();
        let down_m = 0.07 - 0.00008 * t as f32;
        late.bench
            .next_at(&Vec3::new(0.03, 0.0, down_m), Buttons(0));
        sim.tick(&mut late);
        assert_eq!(late.bench.sent.len(), 1, "one force in every tick");
        let order = [Optional::SelfCollision, Optional::FarOrgans];
        assert_eq!(late.asked, order);
    }
    (late, before)
}

fn distance_max_m(now: &[Vec3], before: &[Vec3]) -> f32 {
    let distances = now.iter().zip(before).map(|(a, b)| norm(&(a - b)));
    distances.fold(0.0, f32::max)
}

#[test]
fn far_organs_stand_still_and_the_force_goes_on() {
    let (late, before) = press(|work| work != Optional::FarOrgans);
    let (full, _) = press(|_| true);
    let bench = &late.bench;
    let gallbladder = distance_max_m(&bench.centers_m[LIVER..], &before[LIVER..]);
    assert!(gallbladder <= 0.0, "stands: {gallbladder}");
    assert!(distance_max_m(&bench.centers_m[..LIVER], &before[..LIVER]) > 0.001);
    let awake = |bits: &SphereBits| bits.contains(SphereBits::AWAKE);
    assert!(bench.bits[..LIVER].iter().all(awake));
    assert!(!bench.bits[LIVER..].iter().any(awake), "far organs sleep");
    let (late_n, full_n) = (norm(&bench.force_n), norm(&full.bench.force_n));
    assert!(full_n > 0.1, "{full_n} N");
    assert!(
        (late_n - full_n).abs() < 0.1 * full_n,
        "{late_n} and {full_n} N"
    );
}

#[test]
fn an_organ_that_is_touched_is_never_far() {
    let (late, before) = press(|_| false);
    assert!(distance_max_m(&late.bench.centers_m[..LIVER], &before[..LIVER]) > 0.001);
    assert!(norm(&late.bench.force_n) > 0.1);
}

#[test]
fn omitted_self_collision_is_made_up_later() {
    let mut anatomy = Anatomy::liver_and_gallbladder();
    anatomy.organs[1].gravity_share = 1.0;
    let (mut state, mut paper) = (Box::new(State::new()), paper(Some(PAPER)));
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    sim.solve_by(method(&mut paper));
    let mut late = Late {
        bench: Bench::new(),
        has_time: |work| work != Optional::SelfCollision,
        asked: Vec::new(),
    };
    // The gallbladder lies on the liver. Without contact between organs it sinks into the liver.
    let mut height_m = |ticks: u32, has_time: fn(Optional) -> bool| {
        late.has_time = has_time;
        for _ in 0..ticks {
            late.bench.next();
            sim.tick(&mut late);
        }
        let spheres = &late.bench.centers_m[LIVER..];
        spheres.iter().map(|c| c.z).fold(f32::MAX, f32::min)
    };
    let start_m = height_m(1, |_| true);
    let sunk_m = height_m(150, |work| work != Optional::SelfCollision);
    let back_m = height_m(1500, |_| true);
    assert!(sunk_m < start_m, "{sunk_m} {start_m}");
    assert!(back_m > sunk_m, "{back_m} {sunk_m}");
}
