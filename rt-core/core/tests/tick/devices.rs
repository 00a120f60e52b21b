//! Valid and invalid samples, and the force when a device sends no more samples.

use crate::rig::{Anatomy, Bench, TOUCH, pedal, tracker_at};
use crate::{AWAY, FORCE_ENABLED, NONE, PRESSED, hold_tip, move_tip, new_state};
use rt_core::fault::Fault;
use rt_core::math::{Vec3, norm};
use rt_core::port::{DeviceCapabilities, Findings, PedalSample, Polled};
use rt_core::sim::{Command, Sim};
use rt_core::words::{EventKind, Status};

#[test]
fn a_silent_device_loses_its_force_and_a_returning_one_gets_it_back() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    assert_eq!(bench.status[0], Status::Absent);
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 300, NONE);
    let full = norm(&bench.force_n);
    assert!(full > 0.1);
    for _ in 0..5 {
        bench.next();
        sim.tick(&mut bench);
    }
    assert_eq!(bench.status[0], Status::Live, "5 ms are not too long");
    for _ in 0..25 {
        bench.next();
        sim.tick(&mut bench);
    }
    assert_eq!(bench.status[0], Status::Stale);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    assert_eq!(bench.counters.of(Fault::StaleDevice), 25);
    hold_tip(&mut sim, &mut bench, &PRESSED, 100, NONE);
    assert!(norm(&bench.force_n) > 0.8 * full);
    bench.next().device = Polled::Lost;
    sim.tick(&mut bench);
    assert!(norm(&bench.force_n) < f32::EPSILON);
    bench.next(); // silence does not mean that it is back
    sim.tick(&mut bench);
    assert_eq!(bench.status[0], Status::Lost);
    assert_eq!(bench.counters.of(Fault::LostDevice), 2);
    let faults: Vec<f32> = bench
        .events
        .iter()
        .filter(|e| e.kind == EventKind::Fault)
        .map(|e| e.value)
        .collect();
    assert_eq!(
        faults,
        [Fault::StaleDevice, Fault::LostDevice].map(|f| f32::from(f.code()))
    );
}

#[test]
fn a_leap_of_the_handle_trips_until_a_person_enables() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    hold_tip(&mut sim, &mut bench, &AWAY, 50, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 50, NONE); // 11 cm in a tick
    assert_eq!(bench.counters.of(Fault::SpeedTrip), 1);
    assert!(bench.contact_count > 0 && norm(&bench.force_n) < f32::EPSILON);
    bench.next_at(&PRESSED, NONE).command = Some(Command::EnableForce(true));
    sim.tick(&mut bench);
    hold_tip(&mut sim, &mut bench, &PRESSED, 50, NONE);
    assert!(norm(&bench.force_n) > 0.05);
}

#[test]
fn invalid_poses_are_ignored() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    let good = bench.tip_m;
    for tip in [
        Vec3::repeat(f32::NAN),
        Vec3::repeat(f32::INFINITY),
        Vec3::repeat(1.0e6),
    ] {
        let samples = bench.next_at(&PRESSED, NONE);
        if let Polled::Fresh(sample) = &mut samples.device {
            sample.device_from_handle.translation.vector = tip;
        }
        sim.tick(&mut bench);
        assert_eq!(bench.tip_m, good);
    }
    assert_eq!(bench.counters.of(Fault::BadSample), 3);
    let samples = bench.next();
    samples.tracker = Polled::Fresh(tracker_at(Vec3::repeat(f32::NAN), samples.now_ns));
    sim.tick(&mut bench);
    assert_eq!(bench.counters.of(Fault::BadSample), 4);
}

#[test]
fn pedal_and_camera() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let mut tick = |bench: &mut Bench, x: f32, cut: bool, lock: bool| {
        let samples = bench.next();
        samples.tracker = Polled::Fresh(tracker_at(Vec3::new(x, 0.0, 0.0), samples.now_ns));
        samples.pedal = Polled::Fresh(pedal(cut, lock, samples.now_ns));
        sim.tick(bench);
        (bench.camera.translation.vector.x * 10.0).round() as i32
    };
    assert_eq!(tick(&mut bench, 0.1, false, false), 1);
    assert_eq!(tick(&mut bench, 0.2, true, true), 1, "locked");
    assert_eq!(tick(&mut bench, 0.3, true, false), 3);
    let electro = |bench: &Bench| -> Vec<f32> {
        let events = bench.events.iter();
        let electro = events.filter(|event| event.kind == EventKind::Electro);
        electro.map(|event| event.value).collect()
    };
    assert_eq!(electro(&bench), [1.0]);
    bench.next().pedal = Polled::Lost;
    sim.tick(&mut bench);
    assert_eq!(
        electro(&bench),
        [1.0, 0.0],
        "a lost pedal is a released one"
    );
    assert_eq!(bench.status[2], Status::Lost);
    assert_eq!(bench.counters.of(Fault::LostPedal), 1);
    let announced = bench.events.iter().filter(|it| it.kind == EventKind::Fault);
    assert_eq!(announced.count(), 1, "a person hears of it");
    // A pedal on an open line that sends nothing also counts as lost.
    bench.next().pedal = Polled::Fresh(pedal(true, false, bench.samples.now_ns));
    sim.tick(&mut bench);
    for _ in 0..600 {
        bench.next().pedal = Polled::Nothing;
        sim.tick(&mut bench);
    }
    assert_eq!(bench.status[2], Status::Stale);
    let silent = bench.counters.of(Fault::LostPedal);
    assert!((95..=105).contains(&silent), "{silent} ticks");
}

#[test]
fn findings_of_a_driver_are_counted_and_announced_and_a_leap_starts_the_force_from_nothing() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 200, NONE);
    let full = norm(&bench.force_n);
    bench.findings.faults.raise(Fault::FrozenDevice);
    hold_tip(&mut sim, &mut bench, &PRESSED, 3, NONE);
    assert_eq!(bench.counters.of(Fault::FrozenDevice), 3);
    let announced = bench.events.iter().filter(|it| it.kind == EventKind::Fault);
    assert_eq!(announced.count(), 1, "once a second");
    assert!(
        norm(&bench.force_n) > 0.9 * full,
        "a finding of the driver does not change the force"
    );
    bench.findings = Findings {
        leapt: true,
        ..Findings::default()
    };
    hold_tip(&mut sim, &mut bench, &PRESSED, 1, NONE);
    assert!(norm(&bench.force_n) < 0.2 * full, "{}", bench.force_n);
}

#[test]
fn a_slow_device_is_stale_after_three_of_its_periods() {
    for (rate_hz, live_ms) in [(1000.0, 5), (100.0, 30), (10.0, 100), (f32::NAN, 100)] {
        let anatomy = Anatomy::liver();
        let mut state = new_state();
        let slow = DeviceCapabilities { rate_hz, ..TOUCH };
        let mut sim = Sim::new(anatomy.scene(), &mut state, slow, FORCE_ENABLED);
        let mut bench = Bench::new();
        hold_tip(&mut sim, &mut bench, &AWAY, 10, NONE);
        let mut lived_ms = 0;
        while lived_ms < 200 {
            bench.next();
            sim.tick(&mut bench);
            if bench.status[0] == Status::Stale {
                break;
            }
            lived_ms += 1;
        }
        assert_eq!(lived_ms, live_ms, "{rate_hz} Hz");
    }
}

#[test]
fn a_standstill_starts_the_force_from_nothing() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    move_tip(&mut sim, &mut bench, &AWAY, &PRESSED, 500, NONE);
    hold_tip(&mut sim, &mut bench, &PRESSED, 200, NONE);
    let full = norm(&bench.force_n);
    let standstill = |bench: &mut Bench, ms: u64| {
        bench.samples.now_ns += ms * 1_000_000;
        bench.next_at(&PRESSED, NONE);
    };
    standstill(&mut bench, 18);
    sim.tick(&mut bench);
    assert!(norm(&bench.force_n) > 0.9 * full, "a hiccup is not felt");
    standstill(&mut bench, 200);
    sim.tick(&mut bench);
    assert!(norm(&bench.force_n) < 0.2 * full, "{}", bench.force_n);
    assert_eq!(bench.counters.of(Fault::StaleDevice), 1);
}

#[test]
fn both_electrodes_at_once_are_an_alarm_and_none_works() {
    let anatomy = Anatomy::liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    let mut reported = Vec::new();
    for (cut, coagulate) in [(true, false), (true, true), (true, true), (false, true)] {
        let samples = bench.next();
        samples.pedal = Polled::Fresh(PedalSample {
            coagulate,
            ..pedal(cut, false, samples.now_ns)
        });
        sim.tick(&mut bench);
        let electro = bench.events.iter().rev();
        let electro = electro.filter(|event| event.kind == EventKind::Electro);
        reported.push(electro.map(|event| event.value as u8).next());
    }
    assert_eq!(bench.counters.of(Fault::BothElectrodes), 2);
    let alarms = bench
        .events
        .iter()
        .filter(|event| event.kind == EventKind::Fault);
    assert_eq!(alarms.count(), 1, "{:?}", bench.events);
    assert_eq!(reported.last(), Some(&Some(2)), "{reported:?}");
    assert_eq!(reported.get(1), Some(&Some(0)), "neither works");
}
