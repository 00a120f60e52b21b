//! Tests with an emulated hAPI board: the torques of its motors when hosts come, go and are cut
//! off.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::hapi::HapiHaptic;
use hardware::hapi::device::Board;
use hardware::hapi::pantograph::{Pantograph, swapped};
use hardware::hapi::wire::{set_up, torques};
use rt_core::math::Vec3;
use rt_core::port::{ForceCommand, HapticDevice, Polled};
use rustix::fs::OFlags;

use crate::hostile::pty;
use crate::support::{now_ns, persist, poll_for};

const LINKAGE: Pantograph = Pantograph::GEN3;
/// Long enough for a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// A board behind a pty. The handle is held at home until the board is set up, then at the test's
/// position, at first the middle.
struct EmulatedBoard {
    path: PathBuf,
    board: Arc<Mutex<Board>>,
    handle_m: Arc<Mutex<Vec3>>,
    deaf: Arc<AtomicBool>,
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl EmulatedBoard {
    fn start() -> Self {
        let (path, master) = pty();
        rustix::fs::fcntl_setfl(master.as_fd(), OFlags::NONBLOCK).expect("a pty");
        let board = Arc::new(Mutex::new(Board::default()));
        let handle_m = Arc::new(Mutex::new(Vec3::zeros()));
        let [deaf, end] = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
        let thread = std::thread::spawn({
            let (board, deaf, end) = (Arc::clone(&board), Arc::clone(&deaf), Arc::clone(&end));
            let handle_m = Arc::clone(&handle_m);
            move || emulate(File::from(master), &board, &handle_m, &deaf, &end)
        });
        Self {
            path,
            board,
            handle_m,
            deaf,
            end,
            thread: Some(thread),
        }
    }

    fn open(&self) -> HapiHaptic {
        persist(|| HapiHaptic::open(&self.path, LINKAGE))
    }

    /// Pushes until the motors are on. Opens the board anew if a busy machine lost the board.
    fn push(&self, device: &mut Option<HapiHaptic>) -> bool {
        self.motors_become(true, |now_ns| {
            let pushed = device.as_mut().is_some_and(|device| {
                device.send(push(2.0), now_ns);
                device.poll(now_ns) != Polled::Lost
            });
            if !pushed {
                *device = None;
                *device = Some(self.open());
            }
        })
    }

    /// Moves the handle elsewhere.
    fn move_handle(&self, handle_m: Vec3) {
        *self.handle_m.lock().expect("no test panics with it") = handle_m;
    }

    /// Waits until the device reports this position. Opens the device anew if a busy machine lost
    /// it.
    fn reaches(&self, device: HapiHaptic, wanted_m: Vec3) -> bool {
        let mut device = Some(device);
        let mut is_there = false;
        poll_for(PATIENCE, |now_ns| {
            let Some(open) = &mut device else {
                device = HapiHaptic::reopen(&self.path, LINKAGE).ok();
                return true;
            };
            open.send(push(0.0), now_ns);
            match open.poll(now_ns) {
                Polled::Fresh(sample) => {
                    let at_m = sample.device_from_handle.translation.vector;
                    is_there = (at_m - wanted_m).norm() < 1e-3;
                }
                Polled::Nothing => {}
                Polled::Lost => drop(device.take()),
            }
            !is_there
        });
        is_there
    }

    fn board(&self) -> MutexGuard<'_, Board> {
        self.board.lock().expect("no test panics with it")
    }

    fn torque_nm(&self) -> f32 {
        let torques = self.board().torques_nm();
        torques
            .iter()
            .fold(0.0, |most, torque| most.max(torque.abs()))
    }

    /// Waits until the motors are on or off, as `on` states. Returns true if that happens in time.
    fn motors_become(&self, on: bool, mut meanwhile: impl FnMut(u64)) -> bool {
        let mut is_so = false;
        poll_for(PATIENCE, |now_ns| {
            meanwhile(now_ns);
            is_so = (self.torque_nm() > 1e-6) == on;
            !is_so
        });
        is_so
    }
}

impl Drop for EmulatedBoard {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn emulate(
    mut line: File,
    board: &Mutex<Board>,
    handle_m: &Mutex<Vec3>,
    deaf: &AtomicBool,
    end: &AtomicBool,
) {
    let start = Instant::now();
    let mut bytes = [0; 256];
    while !end.load(Ordering::Relaxed) {
        // Reading fails while nobody has the line open.
        let count = line.read(&mut bytes).unwrap_or(0);
        let received = if deaf.load(Ordering::Relaxed) {
            0
        } else {
            count
        };
        let now_us = start.elapsed().as_micros() as u32;
        if let (Ok(mut board), Ok(handle_m)) = (board.lock(), handle_m.lock()) {
            let [first, second] = swapped(if board.was_set_up() {
                LINKAGE.angles_deg(*handle_m)
            } else {
                LINKAGE.home_deg
            });
            let angles = [first, second, 0.0, 0.0];
            board.receive(&bytes[..received], angles, now_us, |answer| {
                let _ = line.write_all(answer);
            });
        }
        std::thread::sleep(Duration::from_micros(200));
    }
}

fn push(newtons: f32) -> ForceCommand {
    ForceCommand {
        opening_n: 0.0,
        force_n: Vec3::new(newtons, 0.0, 0.0),
        torque_nm: Vec3::zeros(),
    }
}

/// Leaves a torque behind, as another host would.
fn leave_torque(path: &Path, emulated: &EmulatedBoard, commands: &[&[u8]]) {
    let mut host = File::options().write(true).open(path).expect("the line");
    for command in commands {
        host.write_all(command).expect("the line takes it");
    }
    assert!(
        emulated.motors_become(true, |_| {}),
        "the board holds a torque"
    );
}

#[test]
fn the_force_is_rendered_and_ends_with_the_driver() {
    let emulated = EmulatedBoard::start();
    let mut device = None;
    assert!(emulated.push(&mut device));
    let expected = LINKAGE
        .torques_nm(LINKAGE.angles_deg(Vec3::zeros()), Vec3::new(2.0, 0.0, 0.0))
        .unwrap();
    let most = expected[0].abs().max(expected[1].abs());
    // Waits until the driver admits the step from home to the middle.
    let mut is_so = false;
    poll_for(PATIENCE, |_| {
        assert!(emulated.push(&mut device));
        is_so = (emulated.torque_nm() - most).abs() <= 0.01 * most;
        !is_so
    });
    assert!(is_so, "{} N m", emulated.torque_nm());
    drop(device);
    assert!(emulated.motors_become(false, |_| {}));
}

#[test]
fn state_of_an_earlier_host_is_cleared_first() {
    // An earlier set-up by Calot, one by another program, and a broken command.
    let ours = set_up(&LINKAGE.ports(LINKAGE.home_deg));
    let strong = torques([0.1, -0.1]);
    let (mut theirs, mut their_torque) = (ours, strong);
    (theirs[1], their_torque[1]) = (5, 5);
    for commands in [
        vec![&ours[..], &strong],
        vec![&theirs[..], &their_torque],
        vec![&ours[..], &strong, &strong[..7]],
    ] {
        let emulated = EmulatedBoard::start();
        // The line is held open, because without any host the pty loses its settings.
        let _line = hold(&emulated.path);
        leave_torque(&emulated.path, &emulated, &commands);
        let mut device = Some(emulated.open());
        assert!(emulated.torque_nm() < 1e-6, "{commands:?}");
        let mut fresh = false;
        poll_for(PATIENCE, |now_ns| {
            let mut open_device = device.take().unwrap_or_else(|| emulated.open());
            open_device.send(push(0.0), now_ns);
            let polled = open_device.poll(now_ns);
            fresh = matches!(polled, Polled::Fresh(_));
            // A device that a busy machine lost is closed and opened anew.
            device = Some(open_device).filter(|_| polled != Polled::Lost);
            !fresh
        });
        assert!(fresh);
    }
}

/// Opens the line raw, as a host does.
fn hold(path: &Path) -> File {
    let line = File::options()
        .read(true)
        .write(true)
        .open(path)
        .expect("the line");
    let mut termios = rustix::termios::tcgetattr(&line).expect("a terminal");
    termios.make_raw();
    rustix::termios::tcsetattr(&line, rustix::termios::OptionalActions::Now, &termios)
        .expect("a terminal");
    line
}

/// A position that is neither home nor the middle.
const ELSEWHERE_M: Vec3 = Vec3::new(0.02, 0.0, 0.015);

/// Sends until the device is lost.
fn lose(device: &mut HapiHaptic) {
    let mut lost = false;
    poll_for(PATIENCE, |now_ns| {
        device.send(push(2.0), now_ns);
        lost = device.poll(now_ns) == Polled::Lost;
        !lost
    });
    assert!(lost && device.is_lost());
    assert_eq!(device.poll(now_ns()), Polled::Lost, "lost for good");
}

#[test]
fn a_board_that_lost_its_angles_has_no_torque_until_it_is_at_home() {
    let emulated = EmulatedBoard::start();
    let mut device = None;
    assert!(emulated.push(&mut device));
    let mut device = device.expect("it pushes");
    // Some bytes never arrive. Then the board reads on in the middle of a command. Its set-up is
    // lost and its torque stays.
    emulated.deaf.store(true, Ordering::Relaxed);
    emulated
        .board()
        .receive(&[2, 0, 0, 0, 0], [0.0; 4], 0, |_| {});
    lose(&mut device);
    emulated.move_handle(ELSEWHERE_M);
    emulated.deaf.store(false, Ordering::Relaxed);
    drop(device);
    assert!(emulated.motors_become(false, |_| {}));
    for open in [HapiHaptic::reopen, HapiHaptic::open] {
        let error = open(&emulated.path, LINKAGE).unwrap_err();
        assert!(
            matches!(error, HardwareError::Calibration { .. }),
            "{error}"
        );
    }
    // Power cycle with the handle at home.
    *emulated.board() = Board::default();
    assert!(
        emulated.reaches(emulated.open(), ELSEWHERE_M),
        "after a start at home the device knows the handle's position"
    );
}

#[test]
fn a_board_that_answers_only_its_name_is_lost() {
    let emulated = EmulatedBoard::start();
    let mut device = None;
    assert!(emulated.push(&mut device));
    let mut device = device.expect("it pushes");
    // One byte of a command is lost: the rest resets the board, and its torque stays.
    emulated.board().receive(&[0, 0], [0.0; 4], 0, |_| {});
    lose(&mut device);
    drop(device);
    assert!(emulated.motors_become(false, |_| {}));
    let error = HapiHaptic::reopen(&emulated.path, LINKAGE).unwrap_err();
    assert!(
        matches!(error, HardwareError::Calibration { .. }),
        "{error}"
    );
}

#[test]
fn a_board_that_was_only_slow_keeps_its_angles() {
    let emulated = EmulatedBoard::start();
    let mut device = None;
    assert!(emulated.push(&mut device));
    let mut device = device.expect("it pushes");
    emulated.deaf.store(true, Ordering::Relaxed);
    lose(&mut device);
    emulated.move_handle(ELSEWHERE_M);
    emulated.deaf.store(false, Ordering::Relaxed);
    drop(device);
    assert!(emulated.motors_become(false, |_| {}));
    let again = persist(|| HapiHaptic::reopen(&emulated.path, LINKAGE));
    assert!(emulated.reaches(again, ELSEWHERE_M));
}

#[test]
fn a_board_that_lost_its_angles_is_not_given_new_ones() {
    // The board lost its power, and nobody holds the handle at home.
    let emulated = EmulatedBoard::start();
    let error = HapiHaptic::reopen(&emulated.path, LINKAGE).unwrap_err();
    assert!(
        matches!(error, HardwareError::Calibration { .. }),
        "{error}"
    );
}

#[test]
fn a_force_that_is_not_a_number_is_rendered_as_zero() {
    let emulated = EmulatedBoard::start();
    let mut device = emulated.open();
    poll_for(Duration::from_millis(100), |now_ns| {
        device.poll(now_ns);
        device.send(push(f32::NAN), now_ns);
        assert!(emulated.torque_nm() < 1e-9);
        true
    });
}

#[test]
fn another_device_is_refused() {
    let (path, master) = pty();
    let chatter = std::thread::spawn(move || {
        let mut line = File::from(master);
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(5) {
            let _ = line.write_all(b"[3,1,2,3,0,0,0,0]\n");
            std::thread::sleep(Duration::from_millis(5));
        }
    });
    let error = HapiHaptic::open(&path, LINKAGE).unwrap_err();
    assert!(
        matches!(error, HardwareError::Silent { heard, .. } if heard > 0),
        "{error}"
    );
    chatter.join().expect("it only writes");
}
