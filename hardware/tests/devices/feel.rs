//! `feel` with an emulated person, in simulated time: a good rig passes, and each mistake fails for
//! its reason.

use hardware::conformance::CheckOutcome;
use hardware::emulate::{Grip, HapticModel, Mistake, SimulatedDevice};
use hardware::feel::{Answer, Direction, Felt, Guide, Left, Squeezed, Step, feel};
use rt_core::math::Vec3;

/// A hand that holds the handle loosely.
const LOOSE: Grip = Grip {
    stiffness_n_m: 60.0,
    damping_n_s_m: 2.0,
};
/// Speed of the hand, m/s.
const HAND_M_S: f32 = 0.1;
/// Least force that a hand notices, N.
const NOTICED_N: f32 = 0.05;

/// A person who does each step and answers what she feels.
struct Person<'a> {
    simulated: &'a SimulatedDevice,
    at_m: Vec3,
    goal_m: Vec3,
    told_ms: u32,
    is_pressed: bool,
    strongest_n: Vec3,
    /// Force at the handle now, N.
    now_n: Vec3,
    /// Strongest push of the fingers, N; positive opens.
    squeezed_n: f32,
    pressed_n: f32,
    has_scale: bool,
    /// Time after which she stops the test, ms.
    stops_ms: Option<u32>,
    ms: u32,
}

impl<'a> Person<'a> {
    fn at(simulated: &'a SimulatedDevice) -> Self {
        Self {
            simulated,
            at_m: Vec3::zeros(),
            goal_m: Vec3::zeros(),
            told_ms: 0,
            is_pressed: false,
            strongest_n: Vec3::zeros(),
            now_n: Vec3::zeros(),
            squeezed_n: 0.0,
            pressed_n: 0.0,
            has_scale: true,
            stops_ms: None,
            ms: 0,
        }
    }
}

impl Guide for Person<'_> {
    fn tell(&mut self, step: &Step) {
        self.told_ms = 0;
        self.is_pressed = matches!(step, Step::Press { .. });
        match step {
            Step::Move { direction, way_m } => {
                self.goal_m = self.at_m + direction.vector() * *way_m;
            }
            Step::Shut => self.simulated.squeeze(true),
            Step::Open | Step::HoldFingers => self.simulated.squeeze(false),
            Step::PushFingers { .. } => self.squeezed_n = 0.0,
            Step::Hold | Step::HoldFirmly | Step::HoldForSilence | Step::Scale => {
                self.goal_m = Vec3::zeros();
            }
            Step::Push { .. }
            | Step::PushAndFallSilent { .. }
            | Step::Press { .. }
            | Step::Response => {
                self.strongest_n = Vec3::zeros();
            }
        }
    }

    fn is_done(&mut self) -> bool {
        self.told_ms > 1500
    }

    fn pushed(&mut self) -> Answer {
        if self.strongest_n.norm() < NOTICED_N {
            return Answer::Nothing;
        }
        Answer::Felt(Direction::nearest(&self.strongest_n).0)
    }

    fn squeezed(&mut self) -> Squeezed {
        match self.squeezed_n {
            felt_n if felt_n > NOTICED_N => Squeezed::Open,
            felt_n if felt_n < -NOTICED_N => Squeezed::Shut,
            _ => Squeezed::Nothing,
        }
    }

    fn has_scale(&mut self) -> bool {
        self.has_scale
    }

    fn pressed_n(&mut self) -> Option<f32> {
        Some(self.pressed_n)
    }

    fn left(&mut self) -> Option<Left> {
        Some(match self.now_n.norm() < NOTICED_N {
            true => Left::Nothing,
            false => Left::Pushes,
        })
    }

    fn wait(&mut self) -> u64 {
        let way_m = self.goal_m - self.at_m;
        let step_m = way_m.norm().min(HAND_M_S * 1e-3);
        if step_m > 0.0 {
            self.at_m += way_m.normalize() * step_m;
        }
        let force_n = self.simulated.advance(self.at_m);
        self.now_n = force_n;
        if force_n.norm() > self.strongest_n.norm() {
            self.strongest_n = force_n;
        }
        let opening_n = self.simulated.opening_n();
        if opening_n.abs() > self.squeezed_n.abs() {
            self.squeezed_n = opening_n;
        }
        if self.is_pressed {
            self.pressed_n = self.pressed_n.max(-force_n.y);
        }
        self.told_ms += 1;
        self.ms += 1;
        self.simulated.now_ns()
    }

    fn is_stopped(&self) -> bool {
        self.stops_ms.is_some_and(|stops_ms| self.ms >= stops_ms)
    }
}

fn felt(mistake: Option<Mistake>, seed: u64) -> Felt {
    felt_of(HapticModel::TouchRig, mistake, seed)
}

fn felt_of(model: HapticModel, mistake: Option<Mistake>, seed: u64) -> Felt {
    let (mut device, simulated) =
        SimulatedDevice::open_rig_as(model, mistake, LOOSE).expect("a rig");
    let mut person = Person::at(&simulated);
    let felt = feel(&mut *device, &mut person, seed);
    let left_n = simulated.advance(Vec3::zeros()).norm();
    assert!(left_n < 1e-3, "{left_n} N are left");
    assert!(simulated.opening_n().abs() < 1e-3, "the fingers are free");
    felt
}

#[test]
fn a_good_rig_passes_in_any_order() {
    for seed in 0..6 {
        let felt = felt(None, seed);
        assert!(felt.report.passed(), "{}", felt.report);
        assert!(felt.response.len() > 8000);
    }
}

#[test]
fn a_good_handle_that_opens_passes_in_any_order() {
    for seed in [0, 6] {
        let felt = felt_of(HapticModel::HandleRig, None, seed);
        assert!(felt.report.passed(), "{}", felt.report);
        for name in ["opening", "push open", "push shut"] {
            let check = felt.report.check(name).map(|it| it.outcome);
            assert_eq!(check, Some(CheckOutcome::Pass), "{name}: {}", felt.report);
        }
    }
    let plain = felt(None, 0);
    assert!(plain.report.check("opening").is_none(), "{}", plain.report);
}

#[test]
fn an_inverted_opening_fails() {
    let mistake = Mistake::OpeningReversed;
    fails_of(
        HapticModel::HandleRig,
        mistake,
        "opening",
        "the wrong way round",
    );
}

#[test]
fn a_force_along_the_opening_with_the_wrong_sign_fails() {
    let mistake = Mistake::OpeningForceNegated;
    for (check, words) in [
        (
            "push open",
            "1.0 N towards open, felt shut: the force has the wrong",
        ),
        (
            "push shut",
            "1.0 N towards shut, felt open: the force has the wrong",
        ),
    ] {
        fails_of(HapticModel::HandleRig, mistake, check, words);
    }
}

fn fails(mistake: Mistake, check: &str, words: &str) {
    fails_of(HapticModel::TouchRig, mistake, check, words);
}

fn fails_of(model: HapticModel, mistake: Mistake, check: &str, words: &str) {
    let felt = felt_of(model, Some(mistake), 1);
    let report = &felt.report;
    let found = report.check(check);
    assert!(
        found.is_some_and(|it| it.outcome == CheckOutcome::Fail && it.detail.contains(words)),
        "{mistake:?}: {words:?} in {check}: {report}"
    );
}

#[test]
fn a_stopped_test_is_reported_and_leaves_no_force() {
    for stops_ms in [100, 5000, 9000, 14_000] {
        let (mut device, simulated) = SimulatedDevice::open_rig(None, LOOSE).expect("a rig");
        let mut person = Person::at(&simulated);
        person.stops_ms = Some(stops_ms);
        let felt = feel(&mut *device, &mut person, 1);
        assert!(!felt.report.passed());
        assert!(
            felt.report.to_string().contains("was stopped"),
            "{}",
            felt.report
        );
        assert!(simulated.advance(Vec3::zeros()).norm() < 1e-3);
    }
}

#[test]
fn positions_in_millimetres_fails() {
    fails(
        Mistake::PositionsInMillimetres,
        "move right",
        "times too little",
    );
}

#[test]
fn positions_ten_times_too_small_fails() {
    fails(Mistake::PositionsTenfold, "move up", "0.09 of the distance");
}

#[test]
fn exchanged_axes_fails() {
    fails(
        Mistake::AxesExchanged,
        "move up",
        "axes are exchanged: this is towards you",
    );
}

#[test]
fn a_mirrored_axis_fails() {
    fails(Mistake::Mirrored, "move right", "points the wrong way");
}

#[test]
fn a_velocity_that_is_always_zero_fails() {
    fails(Mistake::VelocityZero, "velocity", "leaves it zero");
}

#[test]
fn a_velocity_in_millimetres_fails() {
    fails(Mistake::VelocityInMillimetres, "velocity", "0.00 of what");
}

#[test]
fn a_velocity_with_the_wrong_sign_fails() {
    fails(Mistake::VelocityNegated, "velocity", "wrong sign");
}

#[test]
fn a_force_with_the_wrong_sign_fails() {
    fails(Mistake::ForceNegated, "push right", "wrong sign");
}

#[test]
fn a_force_with_exchanged_axes_fails() {
    fails(
        Mistake::ForceExchanged,
        "push up",
        "axes of the force are exchanged",
    );
}

#[test]
fn half_the_force_fails() {
    fails(Mistake::ForceWeak, "scale", "0.25 N on the scale");
}

#[test]
fn no_force_fails() {
    fails(Mistake::ForceMissing, "push towards", "nothing was felt");
}

#[test]
fn a_large_force_with_the_wrong_sign_fails() {
    fails(
        Mistake::ForceOverflows,
        "push hard",
        "the force has the wrong sign",
    );
    let report = felt(None, 1).report;
    let said = report.check("push hard").map(|it| it.detail.clone());
    assert!(
        said.is_some_and(|it| it.contains("to 3.3 N were not tested")),
        "{report}"
    );
}

#[test]
fn a_watchdog_that_does_not_end_the_motors_force_fails() {
    fails(
        Mistake::WatchdogInStatusOnly,
        "silence",
        "the handle still pushes. The motors keep the force",
    );
}

#[test]
fn a_device_without_a_known_watchdog_gets_no_silence_test() {
    let (mut device, simulated) =
        SimulatedDevice::open_rig_as(HapticModel::Hapi, None, LOOSE).expect("a board");
    let mut person = Person::at(&simulated);
    let felt = feel(&mut *device, &mut person, 1);
    if let Some(check) = felt.report.check("silence") {
        assert_eq!(check.outcome, CheckOutcome::Skipped, "{}", felt.report);
    }
}

#[test]
fn a_device_with_a_fault_fails() {
    fails(Mistake::Fault, "end", "device_fault");
}

#[test]
fn a_device_that_stands_in_one_place_fails() {
    fails(Mistake::Frozen, "end", "frozen_device");
}

#[test]
fn a_clock_that_has_stopped_fails() {
    fails(Mistake::ClockZero, "end", "found a fault (frozen_device)");
}

#[test]
fn without_a_scale_no_force_is_tested_on_one() {
    let (mut device, simulated) = SimulatedDevice::open_rig(None, LOOSE).expect("a rig");
    let mut person = Person::at(&simulated);
    person.has_scale = false;
    let felt = feel(&mut *device, &mut person, 1);
    assert!(felt.report.passed(), "{}", felt.report);
    let scale = felt.report.check("scale").map(|it| it.outcome);
    assert_eq!(scale, Some(CheckOutcome::Skipped));
    assert!(person.pressed_n.abs() < 1e-6);
}

#[test]
fn a_handle_that_nobody_holds_runs_away_and_gets_no_more_force() {
    let free = Grip {
        stiffness_n_m: 0.0,
        damping_n_s_m: 0.0,
    };
    let (mut device, simulated) = SimulatedDevice::open_rig(None, free).expect("a rig");
    let mut person = Person::at(&simulated);
    let felt = feel(&mut *device, &mut person, 1);
    let end = felt.report.check("end").map(|it| it.detail.clone());
    assert!(
        end.is_some_and(|it| it.contains("ran off")),
        "{}",
        felt.report
    );
    assert!(simulated.advance(Vec3::zeros()).norm() < 1e-3);
}
