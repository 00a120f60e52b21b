//! A poll and a send allocate nothing, whatever the line does.
#![allow(unsafe_code)] // a counting allocator

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::time::Instant;

use hardware::HardwareError;
use hardware::bird::{BirdSetup, BirdTracker};
use hardware::emulate::{EmulatedInverse3, Faults, HapticModel, LineFaults, ServiceFault};
use hardware::hapi::{HapiHaptic, pantograph::Pantograph};
use hardware::inverse3::Inverse3Haptic;
use hardware::rig::{RigHaptic, RigPedal};
use hardware::woody::WoodyHaptic;
use rt_core::math::Vec3;
use rt_core::port::{ForceCommand, HapticDevice, Pedal, Polled, Tracker};

use crate::fake_dhd::{Entry, Fake, SIGMA_7};
use crate::support::{Emulator, PATIENCE, persist, poll_for};

/// The system's allocator, which counts the calls of a thread while the thread is armed.
struct Counting;

thread_local! {
    static ARMED: Cell<bool> = const { Cell::new(false) };
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    if ARMED.get() {
        COUNT.set(COUNT.get() + 1);
    }
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Number of allocations and frees in `work`.
fn allocations(work: impl FnOnce()) -> u64 {
    COUNT.set(0);
    ARMED.set(true);
    work();
    ARMED.set(false);
    COUNT.get()
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(1)))), 2);
}

#[test]
fn polls_and_sends_do_not_allocate_even_on_a_noisy_line_that_is_unplugged() {
    // A tracker needs a quiet line for its answers.
    let hang_up = Faults {
        hang_up_at_s: Some(9.0),
        ..Faults::default()
    };
    let noisy = Faults {
        corrupted: 0.001,
        babble: 0.1,
        ..hang_up
    };
    let emulator = Emulator::with_faults(LineFaults {
        haptic: noisy,
        tracker: hang_up,
        pedal: noisy,
    });
    let lines = &emulator.lines;
    let mut device = persist(|| RigHaptic::open(&lines.haptic));
    let mut tracker = persist(|| BirdTracker::open(&lines.tracker, BirdSetup::default()));
    let mut pedal = persist(|| RigPedal::open(&lines.pedal));
    let (mut samples, mut lost) = (0, false);
    let count = allocations(|| {
        poll_for(PATIENCE, |now_ns| {
            let force_n = Vec3::new(0.1, 0.0, 0.0);
            device.send(
                ForceCommand {
                    opening_n: 1.0,
                    force_n,
                    torque_nm: Vec3::zeros(),
                },
                now_ns,
            );
            let polled = device.poll(now_ns);
            samples += u32::from(matches!(polled, Polled::Fresh(_)));
            lost = matches!(polled, Polled::Lost)
                & matches!(tracker.poll(now_ns), Polled::Lost)
                & matches!(pedal.poll(now_ns), Polled::Lost);
            !lost
        });
    });
    assert!(samples > 10 && lost, "{samples} samples, lost: {lost}");
    assert_eq!(count, 0);
}

/// Sends and polls without allocation until the device is lost; returns the number of samples.
/// `meanwhile` runs after each sample.
fn until_lost(device: &mut dyn HapticDevice, mut meanwhile: impl FnMut(u32)) -> u32 {
    let (mut samples, mut lost) = (0, false);
    let count = allocations(|| {
        poll_for(PATIENCE, |now_ns| {
            device.send(
                ForceCommand {
                    opening_n: 1.0,
                    force_n: Vec3::new(0.1, 0.0, 0.0),
                    torque_nm: Vec3::zeros(),
                },
                now_ns,
            );
            match device.poll(now_ns) {
                Polled::Fresh(_) => samples += 1,
                Polled::Nothing => {}
                Polled::Lost => lost = true,
            }
            meanwhile(samples);
            !lost
        });
    });
    assert!(lost, "{samples} samples");
    assert_eq!(count, 0);
    samples
}

/// Tests a driver on a noisy line that hangs up. Repeats the test if a busy machine loses the
/// device too early.
fn on_a_noisy_line<D: HapticDevice>(
    model: HapticModel,
    open: impl Fn(&Path) -> Result<D, HardwareError>,
) {
    let noisy = LineFaults {
        haptic: Faults {
            corrupted: 0.001,
            babble: 0.05,
            from_s: 1.0,
            hang_up_at_s: Some(3.0),
            ..Faults::default()
        },
        ..LineFaults::default()
    };
    let start = Instant::now();
    loop {
        let emulator = Emulator::with_model(model, noisy);
        let device = open(&emulator.lines.haptic).ok();
        if device.is_some_and(|mut device| until_lost(&mut device, |_| {}) > 10) {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "{model:?} gives no samples");
    }
}

#[test]
fn the_other_haptic_devices_do_not_allocate() {
    on_a_noisy_line(HapticModel::Woody, WoodyHaptic::open);
    on_a_noisy_line(HapticModel::Hapi, |path| {
        HapiHaptic::open(path, Pantograph::GEN3)
    });
    let start = Instant::now();
    loop {
        let service = EmulatedInverse3::start().expect("a socket");
        let address = service.address().to_string();
        let mut device = persist(|| Inverse3Haptic::open(address.as_ref(), None));
        let hang_up = |samples| {
            if samples > 100 {
                service.set_fault(ServiceFault::HangUp);
            }
        };
        if until_lost(&mut device, hang_up) > 10 {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "the Inverse3 gives no samples");
    }
}

#[test]
fn a_device_of_libdhd_does_not_allocate() {
    let fake = Fake::new(SIGMA_7);
    let mut device = persist(|| fake.open());
    let unplug = |samples| {
        if samples > 100 {
            fake.set(Entry::ReadError, 2.0);
        }
    };
    assert!(until_lost(&mut device, unplug) > 100);
}
