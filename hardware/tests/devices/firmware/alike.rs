//! Checks that `calot_rig.h` and the device in Rust do the same on any bytes, at any time.

use hardware::rig::device::Motion;
use hardware::rig::frame::Frame;
use hardware::rig::wire::{Capabilities, DeviceKind, Force, Hello, Opening, Switches, stop_frame};
use proptest::prelude::*;

use super::compiler::Language;
use super::twin::{Firmware, Pair, figured, with_opening, with_torque};

/// One event of a device's life.
#[derive(Debug, Clone)]
enum Event {
    Bytes(Vec<u8>),
    Time(u32),
    Report(bool, bool),
    Switches(u8),
    State([f32; 11], u8),
}

fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let number = prop_oneof![0u16..6, 0x7FFDu16..0x8004, 0xFFFCu16..=0xFFFF];
    let part = prop_oneof![Just(0.0f32), -4.0..4.0f32, -40.0..40.0f32];
    let opening_n = prop::option::of(-9.0..9.0f32);
    let parts = (prop::array::uniform6(part), opening_n, number);
    let force = parts.prop_map(|([x, y, z, a, b, c], opening_n, number)| {
        Force {
            force_n: [x, y, z],
            torque_nm: [a / 10.0, b / 10.0, c / 10.0],
            opening_n,
        }
        .frame(number)
    });
    let framed = prop::collection::vec(any::<u8>(), 1..=60)
        .prop_map(|payload| Frame::new(&payload).expect("short"));
    let kinds = (1u8..5, 0usize..20).prop_map(|(kind, length)| {
        let mut payload = vec![kind];
        payload.resize(1 + length, 0);
        Frame::new(&payload).expect("short")
    });
    let frame = prop_oneof![
        8 => force,
        2 => (any::<u16>(), 1u8..4).prop_map(|(number, version)| Hello { version }.frame(number)),
        1 => any::<u16>().prop_map(stop_frame),
        1 => framed,
        1 => kinds,
    ];
    let whole = frame.prop_map(|frame| frame.as_bytes().to_vec());
    let damaged = (whole.clone(), any::<prop::sample::Index>(), any::<u8>()).prop_map(
        |(mut bytes, at, byte)| {
            let at = at.index(bytes.len());
            bytes[at] = byte;
            bytes
        },
    );
    // A frame, and then the same frame without its last byte before the zero. Bytes of the first
    // frame must not complete the second one.
    let cut = whole.clone().prop_map(|bytes| {
        let mut both = [&bytes[..], &bytes[..]].concat();
        both.remove(both.len() - 2);
        both
    });
    let noise = prop::collection::vec(prop_oneof![Just(0u8), 1u8..4, any::<u8>()], 0..150);
    prop_oneof![6 => whole, 1 => damaged, 1 => cut, 1 => noise]
}

fn part() -> impl Strategy<Value = f32> {
    prop_oneof![8 => -2.0..2.0f32, 1 => any::<f32>(), 1 => prop::num::f32::ANY]
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        6 => bytes().prop_map(Event::Bytes),
        3 => prop_oneof![0u32..2000, 45_000u32..55_000, any::<u32>()].prop_map(Event::Time),
        1 => (any::<bool>(), prop::bool::weighted(0.2)).prop_map(|(a, b)| Event::Report(a, b)),
        1 => any::<u8>().prop_map(Event::Switches),
        4 => (prop::collection::vec(part(), 11), any::<u8>()).prop_map(|(parts, buttons)| {
            Event::State(parts.try_into().expect("eleven"), buttons)
        }),
    ]
}

fn live(pair: &mut Pair<'_>, event: Event) {
    match event {
        Event::Bytes(bytes) => pair.receive(&bytes),
        Event::Time(passed_us) => pair.now_us = pair.now_us.wrapping_add(passed_us),
        Event::Report(limited, fault) => pair.report(limited, fault),
        Event::Switches(bits) => {
            pair.switches(Switches {
                cut: bits & 1 != 0,
                coagulate: bits & 2 != 0,
                camera_lock: bits & 4 != 0,
            });
        }
        Event::State([x, y, z, u, v, w, a, b, c, d, opening], buttons) => {
            pair.state(&Motion {
                position_m: [x, y, z],
                velocity_m_s: [u, v, w],
                rotation_xyzw: [a, b, c, d],
                buttons,
                opening,
            });
        }
    }
}

fn config() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(400)
    }
}

fn alike(language: Language) {
    let firmware = Firmware::new(language);
    let life = prop::collection::vec((event(), any::<bool>()), 0..60);
    proptest!(config(), |(life in life, start_us in any::<u32>(), opens in any::<bool>(), version in 1u8..3)| {
        let can = if opens { with_opening() } else { with_torque() };
        let mut pair = Pair::new(&firmware, can, start_us);
        pair.receive(Hello { version }.frame(1).as_bytes());
        for (event, asks) in life {
            live(&mut pair, event);
            if asks {
                pair.force();
                pair.answer();
            }
        }
    });
}

#[test]
fn the_device_in_c_behaves_like_the_device_in_rust() {
    alike(Language::C);
}

#[test]
fn the_device_in_cpp_behaves_like_the_device_in_rust() {
    alike(Language::Cpp);
}

#[test]
fn every_description_is_sent_identically() {
    let firmware = Firmware::new(Language::C);
    let figure = || prop_oneof![0.0..100.0f32, part()];
    let figures = prop::collection::vec(figure(), 8);
    // The device in C has an opening if its travel is positive.
    let opening = prop::option::of((0.0001..1.0f32, figure(), figure()).prop_map(|figures| {
        let (travel_m, force_max_n, stiffness_max_n_m) = figures;
        Opening {
            travel_m,
            force_max_n,
            stiffness_max_n_m,
        }
    }));
    let kinds = any::<bool>();
    proptest!(config(), |(
        haptic in kinds, watchdog_ms in any::<u8>(), figures in figures, opening in opening,
        version in 1u8..4,
    )| {
        let kind = if haptic { DeviceKind::Haptic } else { DeviceKind::Pedal };
        let figures = figures.try_into().expect("eight");
        let can = Capabilities { opening, ..figured(kind, watchdog_ms, figures) };
        let mut pair = Pair::new(&firmware, can, 0);
        pair.receive(Hello { version }.frame(1).as_bytes());
        pair.answer();
        let force = Force { force_n: [30.0, -20.0, 0.5], torque_nm: [1.0, 0.0, -3.0], opening_n: opening.map(|_| 40.0) };
        pair.receive(force.frame(1).as_bytes());
        pair.force();
        pair.now_us = 100_001;
        pair.force();
    });
}
