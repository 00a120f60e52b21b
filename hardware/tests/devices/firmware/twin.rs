//! Runs the device of `calot_rig.h` and the device in Rust with the same calls.

use std::os::raw::c_char;

use hardware::rig::device::{Device, DeviceCounters, Motion};
use hardware::rig::wire::{Capabilities, DeviceKind, Force, Switches};
use libloading::Library;

use super::compiler::{Language, compile, path};

/// Options that make undefined behaviour end the test.
const TRAPS: [&str; 5] = [
    "-shared",
    "-fPIC",
    "-fsanitize=undefined,float-cast-overflow,float-divide-by-zero",
    "-fsanitize-undefined-trap-on-error",
    "-fno-sanitize-recover",
];

/// The firmware's library in C or C++.
pub(super) struct Firmware(Library);

impl Firmware {
    pub(super) fn new(language: Language) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let source = path("tests/devices/firmware/twin.c");
        let made = compile(language, &source, &TRAPS, &folder);
        // SAFETY: our own library.
        Self(unsafe { Library::new(made) }.expect("the library loads"))
    }

    /// A device that no host has greeted.
    pub(super) fn device(&self, can: &Capabilities) -> Twin<'_> {
        let mut twin = Twin {
            library: &self.0,
            memory: Vec::new(),
        };
        let bytes = twin.call::<extern "C" fn() -> usize>(b"twin_size")();
        twin.memory = vec![0; bytes.div_ceil(size_of::<u64>())];
        twin.start(can);
        twin
    }
}

/// A device in C or C++.
pub(super) struct Twin<'a> {
    library: &'a Library,
    /// Memory of the device, in words so that it is aligned.
    memory: Vec<u64>,
}

type Memory = *mut u64;

impl Twin<'_> {
    /// The library's function of this name.
    fn call<F: Copy>(&self, name: &[u8]) -> F {
        // SAFETY: the callers give the types of `twin.c`.
        *unsafe { self.library.get::<F>(name) }.expect("a function of twin.c")
    }

    fn memory(&mut self) -> Memory {
        self.memory.as_mut_ptr()
    }

    fn start(&mut self, can: &Capabilities) {
        let mut name = [0u8; 17];
        name[..16].copy_from_slice(&can.name);
        let figures = [
            can.force_max_n,
            can.force_continuous_n,
            can.stiffness_max_n_m,
            can.damping_max_n_s_m,
            can.workspace_radius_m,
            can.torque_max_nm,
            can.damping_n_s_m,
            can.delay_s,
            can.opening.map_or(0.0, |it| it.travel_m),
            can.opening.map_or(0.0, |it| it.force_max_n),
            can.opening.map_or(0.0, |it| it.stiffness_max_n_m),
        ];
        type Init = extern "C" fn(Memory, u8, u8, u16, u32, *const c_char, *const f32);
        self.call::<Init>(b"twin_init")(
            self.memory(),
            can.kind as u8,
            can.watchdog_ms,
            can.rate_hz,
            can.serial,
            name.as_ptr().cast(),
            figures.as_ptr(),
        );
    }

    pub(super) fn crc(&self, bytes: &[u8]) -> u32 {
        type Crc = extern "C" fn(*const u8, usize) -> u32;
        self.call::<Crc>(b"twin_crc")(bytes.as_ptr(), bytes.len())
    }

    pub(super) fn receive(&mut self, bytes: &[u8], now_us: u32) {
        type Receive = extern "C" fn(Memory, *const u8, usize, u32);
        let receive = self.call::<Receive>(b"twin_receive");
        receive(self.memory(), bytes.as_ptr(), bytes.len(), now_us);
    }

    pub(super) fn answer(&mut self) -> Vec<u8> {
        type Answer = extern "C" fn(Memory, *mut u8) -> usize;
        let answer = self.call::<Answer>(b"twin_answer");
        self.framed(|memory, out| answer(memory, out))
    }

    pub(super) fn force(&mut self, now_us: u32) -> Force {
        type Rendered = extern "C" fn(Memory, u32, *mut f32);
        let mut out = [0.0; 7];
        self.call::<Rendered>(b"twin_force")(self.memory(), now_us, out.as_mut_ptr());
        let [x, y, z, tx, ty, tz, opening_n] = out;
        Force {
            opening_n: Some(opening_n),
            force_n: [x, y, z],
            torque_nm: [tx, ty, tz],
        }
    }

    pub(super) fn state(&mut self, motion: &Motion, now_us: u32) -> Vec<u8> {
        type StateBytes = extern "C" fn(Memory, *const f32, u8, u32, *mut u8) -> usize;
        let state = self.call::<StateBytes>(b"twin_state");
        let mut parts = Vec::from(motion.position_m);
        parts.extend(motion.velocity_m_s);
        parts.extend(motion.rotation_xyzw);
        parts.push(motion.opening);
        self.framed(|memory, out| state(memory, parts.as_ptr(), motion.buttons, now_us, out))
    }

    pub(super) fn switches(&mut self, pressed: Switches) -> Vec<u8> {
        type Pressed = extern "C" fn(Memory, u8, *mut u8) -> usize;
        let bits = u8::from(pressed.cut)
            | u8::from(pressed.coagulate) << 1
            | u8::from(pressed.camera_lock) << 2;
        let switches = self.call::<Pressed>(b"twin_switches");
        self.framed(|memory, out| switches(memory, bits, out))
    }

    pub(super) fn report(&mut self, limited: bool, fault: bool) {
        type Report = extern "C" fn(Memory, u8, u8);
        self.call::<Report>(b"twin_report")(self.memory(), limited.into(), fault.into());
    }

    pub(super) fn counters(&mut self) -> DeviceCounters {
        type Counters = extern "C" fn(Memory, *mut u32);
        let mut out = [0; 3];
        self.call::<Counters>(b"twin_counters")(self.memory(), out.as_mut_ptr());
        let [messages, bad, watchdog_trips] = out;
        DeviceCounters {
            messages,
            bad,
            watchdog_trips,
        }
    }

    /// The frame that `say` writes; empty if none is due. Checks that no byte behind the frame
    /// changes.
    fn framed(&mut self, say: impl FnOnce(Memory, *mut u8) -> usize) -> Vec<u8> {
        const UNTOUCHED: u8 = 0xA5;
        let mut out = vec![UNTOUCHED; 128];
        let length = say(self.memory(), out.as_mut_ptr());
        let rest = out.split_off(length);
        assert!(rest.iter().all(|byte| *byte == UNTOUCHED), "{rest:?}");
        out
    }
}

/// Both devices, which get the same calls.
pub(super) struct Pair<'a> {
    c: Twin<'a>,
    rust: Device,
    pub(super) now_us: u32,
}

impl<'a> Pair<'a> {
    pub(super) fn new(firmware: &'a Firmware, can: Capabilities, now_us: u32) -> Self {
        Self {
            c: firmware.device(&can),
            rust: Device::new(can),
            now_us,
        }
    }

    pub(super) fn receive(&mut self, bytes: &[u8]) {
        self.c.receive(bytes, self.now_us);
        self.rust.receive(bytes, self.now_us);
        assert_eq!(self.c.counters(), self.rust.counters());
    }

    pub(super) fn answer(&mut self) -> Vec<u8> {
        let said = self.rust.answer();
        same(self.c.answer(), said.as_ref().map(|frame| frame.as_bytes()))
    }

    pub(super) fn state(&mut self, motion: &Motion) -> Vec<u8> {
        let said = self.rust.state(motion, self.now_us);
        let c = self.c.state(motion, self.now_us);
        same(c, said.as_ref().map(|frame| frame.as_bytes()))
    }

    pub(super) fn switches(&mut self, pressed: Switches) -> Vec<u8> {
        let said = self.rust.switches(pressed);
        let c = self.c.switches(pressed);
        same(c, said.as_ref().map(|frame| frame.as_bytes()))
    }

    pub(super) fn force(&mut self) -> Force {
        let force = self.rust.force(self.now_us);
        // In C, a command without an opening has an opening force of 0 N.
        let opening_n = Some(force.opening_n.unwrap_or_default());
        assert_eq!(self.c.force(self.now_us), Force { opening_n, ..force });
        assert_eq!(self.c.counters(), self.rust.counters());
        force
    }

    pub(super) fn report(&mut self, limited: bool, fault: bool) {
        self.c.report(limited, fault);
        self.rust.set_limited(limited);
        self.rust.set_fault(fault);
    }
}

/// Checks that both frames are equal, and returns the frame.
fn same(c: Vec<u8>, rust: Option<&[u8]>) -> Vec<u8> {
    assert_eq!(c, rust.unwrap_or_default());
    c
}

/// A haptic device that renders torque too.
pub(super) fn with_torque() -> Capabilities {
    Capabilities {
        torque_max_nm: 0.1,
        ..Capabilities::touch_class()
    }
}

/// A haptic device with torque and a handle that opens.
pub(super) fn with_opening() -> Capabilities {
    Capabilities {
        torque_max_nm: 0.1,
        ..Capabilities::touch_class_with_opening()
    }
}

/// A device of this kind with these figures.
pub(super) fn figured(kind: DeviceKind, watchdog_ms: u8, figures: [f32; 8]) -> Capabilities {
    let [
        force_max_n,
        force_continuous_n,
        stiffness_max_n_m,
        damping_max_n_s_m,
        workspace_radius_m,
        torque_max_nm,
        damping_n_s_m,
        delay_s,
    ] = figures;
    Capabilities {
        kind,
        measures_velocity: kind == DeviceKind::Haptic,
        watchdog_ms,
        force_max_n,
        force_continuous_n,
        stiffness_max_n_m,
        damping_max_n_s_m,
        workspace_radius_m,
        torque_max_nm,
        damping_n_s_m,
        delay_s,
        ..Capabilities::touch_class()
    }
}
