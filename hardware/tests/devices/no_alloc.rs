//! A poll and a send allocate nothing, whatever the line does.
#![allow(unsafe_code)] // a counting allocator

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use hardware::bird::{BirdSetup, BirdTracker};
use hardware::emulate::{Faults, LineFaults};
use hardware::rig::{RigHaptic, RigPedal};
use rt_core::math::Vec3;
use rt_core::port::{ForceCommand, HapticDevice, Pedal, Polled, Tracker};

use crate::support::{Emulator, PATIENCE, persist, poll_for};

/// The system's allocator; counts what an armed thread asks of it.
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

/// How often `work` allocates or frees.
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
fn polls_and_sends_do_not_allocate_even_on_a_noisy_line_that_hangs_up() {
    // A tracker needs a quiet line to answer on.
    let hang_up = Faults {
        hang_up_at_s: Some(9.0),
        ..Faults::default()
    };
    let noisy = Faults {
        corrupted: 0.001,
        babble: 0.1,
        ..hang_up
    };
    let emulator = Emulator::with(LineFaults {
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
                    force_n,
                    torque_n_m: Vec3::zeros(),
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
