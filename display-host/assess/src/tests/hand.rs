//! Effect of noise, sample rates and lost devices on the metrics of a hand.

use super::*;

/// Metrics of a hand on a circle of 5 cm radius, one turn in four seconds, sampled at this rate.
pub(super) fn circle(hz: f64, seconds: f64, tremor_m: f64) -> Values {
    let mut assessment = begin(Task::Free);
    for step in 0..=(hz * seconds) as u32 {
        let at_s = f64::from(step) / hz;
        let turn = at_s * std::f64::consts::TAU / 4.0;
        let shake = tremor_m * (at_s * std::f64::consts::TAU * 9.0).sin();
        let place = [0.05 * turn.cos(), 0.05 * turn.sin(), shake - 0.1];
        assessment.take(&moved(at_s, here(place.map(|x| x as f32))));
    }
    assessment.end().metrics
}

/// An approximately normal random number of standard deviation 1: the sum of twelve uniform ones.
fn normal(seed: &mut u64) -> f64 {
    let mut uniform = || {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// Metrics of a minute in which the handle and the tip follow `way`. A device with this noise
/// samples them at this rate.
fn minute(hz: f64, noise_m: f64, way: impl Fn(f64) -> [f64; 3]) -> Values {
    follow([60.0, hz], [noise_m, 7.0], way)
}

/// Metrics of a hand that follows `way` as in [`minute`], for `seconds` at `hz` samples/s. The
/// noise comes from `seed`.
fn follow(
    [seconds, hz]: [f64; 2],
    [noise_m, seed]: [f64; 2],
    way: impl Fn(f64) -> [f64; 3],
) -> Values {
    let mut assessment = begin(Task::Free);
    let mut seed = seed as u64;
    for step in 0..=(hz * seconds) as u32 {
        let at_s = f64::from(step) / hz;
        let place = way(at_s).map(|x| (x + noise_m * normal(&mut seed)) as f32);
        let mut movement = here(place);
        movement.world_from_handle.position_m = place;
        assessment.take(&moved(at_s, movement));
    }
    assessment.end().metrics
}

const RATES_HZ: [f64; 5] = [10.0, 30.0, 100.0, 333.0, 1000.0];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The hand moves smoothly to a place in any direction, rests there, and moves back.
    #[test]
    fn a_smooth_movement_measures_the_same_at_any_rate_and_with_noise(
        far_m in prop::array::uniform3(0.03f64..0.08), takes_s in 0.8f64..2.5, seed in 1u32..1000,
    ) {
        let way = |at_s: f64| {
            let (there, back) = ((at_s / takes_s).min(1.0), (at_s / takes_s - 2.0).clamp(0.0, 1.0));
            let bell = |at: f64| at * at * at * (10.0 - 15.0 * at + 6.0 * at * at);
            far_m.map(|x| x * (bell(there) - bell(back)) - 0.1)
        };
        let of = |hz: f64, noise_m: f64| {
            let values = follow([4.0 * takes_s, hz], [noise_m, seed.into()], way);
            [Metric::Path, Metric::Movements, Metric::Smoothness].map(|it| values.get(it))
        };
        let [path_m, movements, smoothness] = of(1000.0, 0.0);
        is(movements, 2.0);
        let true_m = 2.0 * far_m.iter().map(|x| x * x).sum::<f64>().sqrt();
        prop_assert!((path_m - true_m).abs() < 0.03 * true_m, "{path_m}, not {true_m}");
        prop_assert!(smoothness > -1.8, "{smoothness}");
        for (hz, noise_m) in [30.0, 100.0, 333.0].map(|hz| (hz, 0.0)).into_iter()
            .chain([30.0, 100.0, 333.0, 1000.0].map(|hz| (hz, 0.3e-3)))
        {
            let found = of(hz, noise_m);
            let case = format!("{found:?}, not {path_m} {smoothness}, {hz} Hz, {noise_m} m");
            is(found[1], 2.0);
            prop_assert!((found[0] - path_m).abs() < 0.04 * path_m, "{}", case);
            // Among 300 random movements, noise changed the smoothness by 8 % at most. Among 20
            // movements without noise, sampling at 30 Hz changed the smoothness of one by 4 %,
            // because that one begins between two samples.
            let off = if noise_m > 0.0 { 0.15 } else { 0.08 };
            prop_assert!((found[2] / smoothness - 1.0).abs() < off, "{}", case);
        }
    }
}

#[test]
fn a_resting_hand_with_a_noisy_device_rests_at_every_rate() {
    for (noise_m, hz) in [0.0, 0.05e-3, 0.3e-3]
        .into_iter()
        .flat_map(|noise| RATES_HZ.map(|hz| (noise, hz)))
    {
        let values = minute(hz, noise_m, |_| [0.0, 0.0, -0.1]);
        let [path_m, idle_s] = [Metric::Path, Metric::Idle].map(|it| values.get(it));
        assert!(path_m < 3e-3, "{path_m} m at {hz} Hz with {noise_m} m");
        is(values.get(Metric::Movements), 0.0);
        assert!(idle_s > 59.5, "{idle_s} s at {hz} Hz with {noise_m} m");
        // The noise is measured in parts of 0.25 s. A slow device has too few samples in a part.
        let noise_mm = values.get(Metric::Noise);
        assert!(
            hz < 50.0 || (noise_mm - noise_m * 1e3).abs() < 0.2 * noise_m * 1e3 + 0.011,
            "{noise_mm} mm"
        );
    }
    // The largest noise for which the debrief promises less than 5 mm a minute.
    let path_m = minute(100.0, 0.7e-3, |_| [0.0, 0.0, -0.1]).get(Metric::Path);
    assert!(path_m < 5e-3, "{path_m}");
}

#[test]
fn tremor_is_neither_movement_nor_rest_and_strokes_count_the_same_at_every_rate() {
    let turn = std::f64::consts::TAU;
    let tremor = |at_s: f64| [0.0, 3e-3 * (8.0 * turn * at_s).sin(), -0.1];
    // Thirty strokes of 4 cm, each a second long and followed by a second of rest.
    let strokes = |at_s: f64| {
        let (stroke, within) = ((at_s / 2.0).floor(), (at_s % 2.0).min(1.0));
        let part = 0.5 - 0.5 * (0.5 * turn * within).cos();
        let part = if stroke % 2.0 == 0.0 {
            part
        } else {
            1.0 - part
        };
        [0.04 * part, 0.0, -0.1]
    };
    let of = |hz, noise_m, way: &dyn Fn(f64) -> [f64; 3]| minute(hz, noise_m, way);
    for hz in [100.0, 333.0, 1000.0] {
        let shaken = of(hz, 0.0, &tremor);
        is(shaken.get(Metric::Movements), 0.0);
        is(shaken.get(Metric::Idle), 0.0);
        // The path of the tremor itself is 5.8 m long.
        let path_m = shaken.get(Metric::Path);
        assert!(path_m < 0.58, "{path_m} m at {hz} Hz");
        let noise_mm = shaken.get(Metric::Noise);
        assert!(noise_mm.is_nan(), "{noise_mm} mm: it moves");
    }
    let stroked = RATES_HZ.map(|hz| of(hz, 0.0, &strokes));
    let noisy = RATES_HZ.map(|hz| of(hz, 0.3e-3, &strokes));
    for values in [stroked, noisy] {
        for (metric, slow) in [
            (Metric::Path, 0),
            (Metric::Movements, 0),
            (Metric::Time, 0),
            (Metric::Smoothness, 0),
            // Noise sampled at 10 Hz is as slow as a hand, and interrupts the hand's rest.
            (Metric::Idle, 1),
        ] {
            let all = values.iter().skip(slow).map(|it| it.get(metric).abs());
            let all: Vec<f64> = all.collect();
            let [least, most] =
                [f64::min, f64::max].map(|of| all.iter().copied().reduce(of).unwrap());
            assert!(most - least <= 0.06 * most, "{} {all:?}", metric.name());
        }
    }
    for values in [&stroked[0], &noisy[0]] {
        is(values.get(Metric::Movements), 30.0);
        let path_m = values.get(Metric::Path);
        assert!((path_m - 1.2).abs() < 0.05 * 1.2, "{path_m}");
    }
}

/// Time in which a device was lost counts as [`Metric::DeviceLost`], and not as the trainee's time.
/// The smoothness comes from the magnitude of the speed, and a tremor across the way adds little to
/// that. A hand that trembles in a circle therefore loses less than its tremor suggests.
#[test]
fn tremor_along_the_way_is_less_smooth_and_tremor_across_it_hardly() {
    let smoothness = |tremor_m: [f64; 2]| {
        let way = |at_s: f64| {
            let (stroke, at) = ((at_s / 2.0).floor(), (at_s % 2.0 / 1.2).min(1.0));
            let bell = at * at * at * (10.0 - 15.0 * at + 6.0 * at * at);
            let there = if stroke % 2.0 < 0.5 { bell } else { 1.0 - bell };
            let shake = (at_s * std::f64::consts::TAU * 8.0).sin();
            let [along_m, across_m] = tremor_m.map(|it| it * shake);
            [0.06 * there + along_m, across_m, -0.1]
        };
        follow([30.0, 100.0], [0.0, 1.0], way).get(Metric::Smoothness)
    };
    let calm = smoothness([0.0, 0.0]);
    let [along, across] = [smoothness([0.002, 0.0]), smoothness([0.0, 0.002])];
    println!("{calm}, with tremor along the way {along}, across it {across}");
    assert!(along < calm - 0.3, "{calm} {along}");
    assert!((across - calm).abs() < 0.15, "{calm} {across}");
}

#[test]
fn time_without_a_lost_device_is_not_the_trainees() {
    let mut assessment = begin(Task::Free);
    let at = |at_s: f64, live| Movement {
        live,
        ..here([(at_s * 0.03) as f32, 0.0, -0.1])
    };
    for step in 0..3000 {
        let at_s = f64::from(step) * 0.01;
        let live = if (10.0..19.0).contains(&at_s) { 6 } else { 7 };
        assessment.take(&moved(at_s, at(at_s, live)));
    }
    let values = assessment.end().metrics;
    assert!(
        (values.get(Metric::DeviceLost) - 9.0).abs() < 0.03,
        "{}",
        values.get(Metric::DeviceLost)
    );
    assert!((values.get(Metric::Time) - 21.0).abs() < 0.05);
    assert!(
        (values.get(Metric::Path) - 0.63).abs() < 0.01,
        "{}",
        values.get(Metric::Path)
    );
    // Without the pedal the hands go on, because only the hook needs the pedal.
    for (instrument, gone) in [(Instrument::Grasper, 0.0), (Instrument::Hook, 2.0)] {
        let mut pedal = begin(Task::Free);
        for step in 0..500 {
            let live = if (100..300).contains(&step) { 3 } else { 7 };
            let held = Movement {
                instrument: instrument.number() as u8,
                ..at(0.0, live)
            };
            pedal.take(&moved(f64::from(step) * 0.01, held));
        }
        let values = pedal.end().metrics;
        let lost_s = values.get(Metric::DeviceLost);
        assert!((lost_s - gone).abs() < 0.03, "{instrument:?}: {lost_s}");
        assert!((values.get(Metric::Time) + lost_s - 4.99).abs() < 1e-6);
    }
    // Time without the endoscope's tracker does not count either, because the trainee does not see.
    let mut blind = begin(Task::Free);
    for step in 0..300 {
        let live = if step < 100 { 7 } else { 5 };
        blind.take(&moved(f64::from(step) * 0.01, at(0.0, live)));
    }
    let lost_s = blind.end().metrics.get(Metric::DeviceLost);
    assert!((lost_s - 2.0).abs() < 0.03, "{lost_s}");
    // A station that never had a haptic device has lost none.
    let mut without = begin(Task::Free);
    for step in 0..100 {
        without.take(&moved(f64::from(step) * 0.01, at(0.0, 6)));
    }
    is(without.end().metrics.get(Metric::DeviceLost), 0.0);
    // A haptic device that is open but never sent anything counts as missing, too.
    let mut silent = begin(Task::Free);
    let fault = Fault::SilentDevice.number() as f32;
    for step in 0..300 {
        let at_s = f64::from(step) * 0.01;
        if step == 100 {
            silent.take(&event(at_s, EventKind::Fault.number(), DUCT, 0.0, fault));
        }
        silent.take(&moved(at_s, at(0.0, 6)));
    }
    let lost_s = silent.end().metrics.get(Metric::DeviceLost);
    assert!((lost_s - 2.0).abs() < 0.05, "{lost_s}");
}
