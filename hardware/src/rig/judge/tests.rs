//! Tests the judgement of devices that work, stall or report wrong values.

use super::*;

const MS: u64 = 1_000_000;

/// A device and a host at 1 kHz.
struct Bench {
    judge: Judge,
    now_ns: u64,
    /// Samples admitted.
    admitted: u32,
    fastest_m_s: f32,
    leaps: u32,
    /// Every fault seen.
    seen: FaultSet,
}

impl Bench {
    fn new() -> Self {
        Self {
            judge: Judge::default(),
            now_ns: 10_000 * MS,
            admitted: 0,
            fastest_m_s: 0.0,
            leaps: 0,
            seen: FaultSet::NONE,
        }
    }

    /// One poll that brings these samples: each is a clock reading in µs, a position in m and a
    /// velocity in m/s, both along x.
    fn poll(&mut self, samples: &[(u32, f32, f32)], measures: bool) {
        self.judge.begin(self.now_ns);
        for (us, x_m, x_m_s) in samples {
            let state = State {
                device_time_us: *us,
                position_m: [*x_m, 0.0, 0.0],
                velocity_m_s: [*x_m_s, 0.0, 0.0],
                rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
                ..SAMPLE
            };
            if let Some(velocity_m_s) = self.judge.take(&state, measures, self.now_ns) {
                self.admitted += 1;
                self.fastest_m_s = self.fastest_m_s.max(velocity_m_s.norm());
            }
        }
        self.judge.end(samples.len() * 50);
        let findings = self.judge.findings();
        self.seen = self.seen.with(findings.faults);
        self.leaps += u32::from(findings.leapt);
        self.now_ns += MS;
    }

    /// Polls once for each millisecond of `ms`, with one `sample` per poll.
    fn run(&mut self, ms: std::ops::Range<u32>, sample: impl Fn(u32) -> (u32, f32, f32)) {
        ms.for_each(|at| self.poll(&[sample(at)], true));
    }
}

const SAMPLE: State = State {
    opening: None,
    status: super::super::wire::Status(0),
    buttons: 0,
    applied_force: 0,
    device_time_us: 0,
    position_m: [0.0; 3],
    velocity_m_s: [0.0; 3],
    rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
};

/// A hand at a steady speed, m/s.
fn moving(speed_m_s: f32) -> impl Fn(u32) -> (u32, f32, f32) {
    move |ms| (ms * 1000, ms as f32 * 0.001 * speed_m_s, speed_m_s)
}

#[test]
fn all_samples_of_a_steady_hand_are_admitted() {
    let mut bench = Bench::new();
    bench.run(0..3000, moving(0.1));
    assert!(bench.seen.is_empty());
    assert_eq!((bench.admitted, bench.leaps), (3000, 0));
    assert!((bench.fastest_m_s - 0.1).abs() < 1e-3);
}

#[test]
fn a_stop_of_the_host_causes_no_fault_and_no_speed() {
    for (stop_ms, speed_m_s) in [(30, 0.113), (50, 0.0126), (500, 0.113), (5000, 0.0126)] {
        for measures in [false, true] {
            let mut bench = Bench::new();
            let sample = moving(speed_m_s);
            (0..1000).for_each(|ms| bench.poll(&[sample(ms)], measures));
            bench.now_ns += u64::from(stop_ms) * MS;
            // The line's buffer kept the oldest 1600 samples of the pause. They arrive 80 a poll.
            let kept: Vec<_> = (1000..1000 + stop_ms.min(1600)).map(&sample).collect();
            kept.chunks(80)
                .for_each(|portion| bench.poll(portion, measures));
            let on = 1000 + stop_ms;
            (on..on + 2000).for_each(|ms| bench.poll(&[sample(ms)], measures));
            assert!(bench.seen.is_empty(), "{stop_ms} ms: {:?}", bench.seen);
            assert!(
                bench.fastest_m_s < 0.2,
                "{stop_ms} ms: {} m/s",
                bench.fastest_m_s
            );
            assert!(bench.admitted >= 2900, "{stop_ms} ms: {}", bench.admitted);
        }
    }
}

#[test]
fn a_leap_of_one_sample_is_dropped_and_a_lasting_one_is_accepted() {
    let mut bench = Bench::new();
    bench.run(0..1000, |ms| {
        let leap = if ms == 500 { 0.05 } else { 0.0 };
        (ms * 1000, leap, 0.0)
    });
    assert!(bench.seen.contains(Fault::DeviceLeap));
    assert_eq!((bench.admitted, bench.leaps), (999, 0));
    bench.run(1000..1100, |ms| (ms * 1000, 0.05, 0.0));
    assert_eq!((bench.admitted, bench.leaps), (999 + 93, 1));
    assert!(bench.fastest_m_s < 0.1, "{}", bench.fastest_m_s);
}

#[test]
fn a_frozen_position_is_found_and_a_resting_hand_is_not() {
    let mut bench = Bench::new();
    bench.run(0..500, |ms| (ms * 1000, 0.01, 0.0));
    assert!(bench.seen.is_empty());
    bench.run(500..600, |ms| (ms * 1000, 0.01, 0.0126));
    assert!(bench.seen.contains(Fault::FrozenDevice));
    let admitted = bench.admitted;
    assert!(admitted < 550, "{admitted}");
    bench.run(600..700, |ms| (ms * 1000, 0.01 + ms as f32 * 1e-5, 0.01));
    assert_eq!((bench.admitted - admitted, bench.leaps), (100, 1));
}

#[test]
fn clocks_that_run_backwards_stop_or_count_milliseconds_are_found() {
    let clocks: [fn(u32) -> u32; 3] = [|ms| 10_000_000 - ms * 1000, |_| 7, |ms| ms];
    for clock in clocks {
        let mut bench = Bench::new();
        bench.run(0..1000, |ms| (clock(ms), ms as f32 * 1e-5, 0.01));
        assert!(bench.seen.contains(Fault::DeviceClock));
        assert!(bench.judge.findings().faults.contains(Fault::DeviceClock));
    }
}

#[test]
fn a_device_that_restarts_is_accepted_after_a_moment() {
    let mut bench = Bench::new();
    bench.run(0..500, |ms| (1_000_000 + ms * 1000, 0.0, 0.0));
    bench.run(0..100, |ms| (ms * 1000, 0.0, 0.0));
    assert_eq!((bench.admitted, bench.leaps), (500 + 92, 1));
}

#[test]
fn a_device_that_confirms_no_force_is_deaf_but_not_while_no_force_is_sent() {
    for sends in [true, false] {
        let mut bench = Bench::new();
        for ms in 0..600 {
            if sends {
                bench.judge.sent(bench.now_ns);
            }
            bench.poll(&[moving(0.0)(ms)], true);
        }
        assert_eq!(bench.seen.contains(Fault::DeafDevice), sends);
    }
}

#[test]
fn a_silent_device_has_no_other_fault() {
    let mut bench = Bench::new();
    bench.run(0..200, |_| (7, 0.01, 0.0));
    assert!(!bench.judge.findings().faults.is_empty());
    (0..200).for_each(|_| bench.poll(&[], true));
    assert!(
        bench.judge.findings().faults.is_empty(),
        "a silent device has no faults"
    );
}

#[test]
fn a_device_whose_line_refuses_forces_is_deaf_until_the_line_takes_one() {
    let mut bench = Bench::new();
    bench.run(0..100, moving(0.0));
    for ms in 100..1100 {
        bench.judge.refused();
        bench.poll(&[moving(0.0)(ms)], true);
        let is_deaf = bench.judge.findings().faults.contains(Fault::DeafDevice);
        assert_eq!(is_deaf, ms - 100 + 1 >= REFUSALS, "{ms}");
    }
    let admitted = bench.admitted;
    bench.judge.sent(bench.now_ns);
    bench.poll(&[moving(0.0)(1100)], true);
    assert!(!bench.judge.findings().faults.contains(Fault::DeafDevice));
    assert_eq!(
        (bench.admitted, bench.leaps),
        (admitted + 1, 1),
        "the force begins anew"
    );
}

#[test]
fn a_deaf_device_stays_deaf_while_its_line_refuses() {
    let mut bench = Bench::new();
    for ms in 0..2000 {
        // The line takes forces until its buffer is full.
        match ms {
            ..400 => bench.judge.sent(bench.now_ns),
            _ => bench.judge.refused(),
        }
        bench.poll(&[moving(0.0)(ms)], true);
        let is_deaf = bench.judge.findings().faults.contains(Fault::DeafDevice);
        assert!(ms < 300 || is_deaf, "{ms}");
    }
}

#[test]
fn a_device_that_paused_while_its_clock_ran_is_not_frozen() {
    let mut bench = Bench::new();
    // After every 50 samples the device's clock steps by 40 ms instead of 1 ms. The hand moves by
    // an encoder step of 0.055 mm in three samples.
    let mut us = 0;
    for sample in 0..3000u32 {
        us += if sample % 50 == 0 { 40_000 } else { 1000 };
        let x_m = (sample / 3) as f32 * 0.055e-3;
        bench.poll(&[(us, x_m, 0.0183)], true);
    }
    assert!(
        !bench.seen.contains(Fault::FrozenDevice),
        "{:?}",
        bench.seen
    );
}

#[test]
fn a_frozen_position_is_found_without_a_measured_velocity() {
    let mut bench = Bench::new();
    (0..200).for_each(|ms| bench.poll(&[(ms * 1000, 0.01, 0.0126)], false));
    assert!(bench.judge.findings().faults.contains(Fault::FrozenDevice));
}

#[test]
fn an_old_sample_at_the_start_of_a_clock_comparison_causes_no_fault() {
    let mut bench = Bench::new();
    bench.run(0..1000, moving(0.0));
    // The device's clock advances by 5 s between two samples, and the host's by 11 ms. The judge
    // sees no pause and no backlog.
    bench.now_ns += 10 * MS;
    bench.run(6000..9000, moving(0.0));
    assert!(!bench.seen.contains(Fault::DeviceClock));
}

#[test]
fn a_velocity_that_is_always_zero_does_not_hide_a_thrown_handle() {
    let mut bench = Bench::new();
    bench.run(0..100, |ms| (ms * 1000, ms as f32 * 0.00255, 0.0));
    assert!(
        (bench.fastest_m_s - 2.55).abs() < 0.1,
        "{}",
        bench.fastest_m_s
    );
}

/// `cargo test --release -p hardware --lib cost_of_judging -- --ignored --nocapture`
#[test]
#[ignore = "measures, for the report"]
fn cost_of_judging_a_sample() {
    const POLLS: u32 = 1_000_000;
    let mut best_ns = f64::INFINITY;
    for _ in 0..10 {
        let (mut judge, mut admitted) = (Judge::default(), 0);
        let start = std::time::Instant::now();
        for at in 1..=POLLS {
            let now_ns = u64::from(at) * MS;
            judge.begin(now_ns);
            // To and fro by 10 mm at 10 mm/s.
            let state = State {
                device_time_us: at * 1000,
                applied_force: at as u16,
                position_m: [(at % 2000).abs_diff(1000) as f32 * 1.0e-5, 0.0, 0.0],
                velocity_m_s: [0.01, 0.0, 0.0],
                ..SAMPLE
            };
            let velocity_m_s = judge.take(std::hint::black_box(&state), true, now_ns);
            admitted += u32::from(velocity_m_s.is_some());
            judge.end(50);
            std::hint::black_box(judge.findings());
            judge.sent(now_ns);
        }
        best_ns = best_ns.min(start.elapsed().as_secs_f64() * 1.0e9 / f64::from(POLLS));
        assert_eq!(admitted, POLLS);
    }
    println!("judging a sample, bundles included: {best_ns:.0} ns a tick");
}

#[test]
fn noisy_positions_are_reported_and_admitted_until_they_are_calm() {
    let mut bench = Bench::new();
    // Noise of ±0.25 mm, alternating, on the positions of a moving hand.
    let noisy = |ms: u32| {
        let (us, x_m, m_s) = moving(0.05)(ms);
        (
            us,
            x_m + if ms.is_multiple_of(2) {
                0.00025
            } else {
                -0.00025
            },
            m_s,
        )
    };
    bench.run(0..2000, noisy);
    assert!(bench.seen.is_empty(), "one window may be a knock");
    bench.run(2000..4000, noisy);
    let found = bench.judge.findings().faults;
    assert!(found.contains(Fault::NoisyDevice) && bench.admitted == 4000);
    bench.run(4000..6000, moving(0.05));
    assert!(bench.judge.findings().faults.is_empty());
}
