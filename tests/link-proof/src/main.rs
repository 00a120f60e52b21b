//! A program that contains only the scene's checks and the tick. Its panic handler calls a function
//! that does not exist, and it has no allocator. If any path of the checks or the tick can panic or
//! allocate, the program does not link.

#![no_std]
#![no_main]

#[cfg(feature = "broken-alloc")]
extern crate alloc;

use core::cell::UnsafeCell;
use core::hint::black_box;

use rt_core::math::{Pose, Vec3};
use rt_core::port::{DeviceCapabilities, ForceCommand, Opening};
use rt_core::scene::{
    Attachment, Cell, Column, Layers, Link, Organ, RestSphere, Room, Scene, Skin, TetraBatch, Trocar,
};
use rt_core::sim::{Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use rt_core::tissue::Method;
use rt_core::tissue::paper::Paper;

unsafe extern "C" {
    /// A function that is defined nowhere.
    safe fn the_tick_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    the_tick_can_panic()
}

struct Storage(UnsafeCell<(State, Paper)>);

// SAFETY: the program has one thread.
unsafe impl Sync for Storage {}

static STORAGE: Storage = Storage(UnsafeCell::new((State::new(), Paper::new(10))));

/// Hides a value from the optimiser, which must then expect any value from outside.
fn anything<T: Copy>(example: T) -> T {
    black_box(example)
}

struct World {
    samples: Samples,
}

impl Ports for World {
    fn sample(&mut self) -> Samples {
        #[cfg(feature = "broken-panic")]
        black_box([1, 2, 3][anything(1_usize)]);
        #[cfg(feature = "broken-alloc")]
        black_box(alloc::boxed::Box::new(anything(1)));
        anything(self.samples)
    }

    fn send_force(&mut self, command: ForceCommand) {
        black_box(command);
    }

    fn publish(&mut self, view: &TickView<'_>) {
        for sphere in view.spheres() {
            black_box(sphere);
        }
        black_box(view.digest());
        black_box(view);
    }

    fn stamp(&mut self, stage: Stage) {
        black_box(stage);
    }
}

#[unsafe(no_mangle)]
extern "C" fn _start() -> ! {
    let organs: &[Organ] = black_box(&[]);
    let spheres: &[RestSphere] = black_box(&[]);
    let links: &[Link] = black_box(&[]);
    let tetrahedra: &[TetraBatch] = black_box(&[]);
    let attachments: &[Attachment] = black_box(&[]);
    let skin = Skin {
        vertices: black_box(&[]),
        fans: black_box(&[]),
        nearest: black_box(&[]),
    };
    let cells: &[Cell] = black_box(&[]);
    let columns: &[Column] = black_box(&[]);
    let layers = Layers { cells, columns };
    let zero = Vec3::new(0.0, 0.0, 0.0);
    let room = anything(Room {
        gravity_m_s2: zero,
        world_from_device: Pose::identity(),
        world_from_tracker: Pose::identity(),
        instrument_port_m: zero,
        instrument_length_m: 0.3,
        endoscope_port_m: zero,
        world_from_camera: Pose::identity(),
        breath_s: 0.0,
        trocar: Trocar::NONE,
    });
    let device = anything(DeviceCapabilities {
        opening: Opening::NONE,
        force_max_n: 1.0,
        force_continuous_n: 1.0,
        torque_max_nm: 0.0,
        stiffness_max_n_m: 1.0,
        damping_max_n_s_m: 1.0,
        damping_n_s_m: 1.8,
        delay_s: 0.001,
        workspace_radius_m: 1.0,
        rate_hz: 1000.0,
    });
    // SAFETY: this is the only reference to it, in the only thread.
    let (state, paper) = unsafe { &mut *STORAGE.0.get() };
    if let Ok(scene) = Scene::new(organs, spheres, links, room)
        .and_then(|scene| scene.with_tetrahedra(tetrahedra))
        .and_then(|scene| scene.with_attachments(attachments))
        .and_then(|scene| scene.with_skin(skin))
        .and_then(|scene| scene.with_cells(layers))
    {
        let mut sim = Sim::new(scene, state, device, anything(Parameters::default()));
        if anything(true) {
            sim.solve_by(Method::Paper(paper));
        }
        let mut world = World {
            samples: Samples {
                now_ns: 0,
                device: rt_core::port::Polled::Nothing,
                tracker: rt_core::port::Polled::Nothing,
                pedal: rt_core::port::Polled::Nothing,
                command: None,
            },
        };
        loop {
            sim.tick(&mut world);
            sim.note_overrun();
            black_box(sim.state_hash());
        }
    }
    loop {}
}
