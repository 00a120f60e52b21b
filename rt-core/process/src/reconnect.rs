//! The thread that opens the devices and reopens lost ones.
//!
//! The tick hands a lost device to this thread. The thread closes the device and then tries to open
//! its path until a device answers.

use core::sync::atomic::Ordering::Acquire;
use core::time::Duration;
use std::sync::mpsc::{self, SyncSender};
use std::sync::{Arc, OnceLock};
use std::thread::{JoinHandle, sleep};

use hardware::HardwareError;
use hardware::station::StationFile;
use heapless::spsc::{Consumer, Producer, Queue};
use rt_core::port::DeviceCapabilities;

use crate::config::{Realtime, RtConfig};
use crate::devices::{Device, Devices, Exchange, KINDS};
use crate::error::RtError;
use crate::realtime;
use crate::shared::Shared;
use crate::thread::{ended_without_report, spawn};

/// Interval between two checks for lost devices, and between two attempts to open one.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Longest pause between two attempts to open one device, in units of `LOOK_EVERY`: 5 s. Pauses
/// grow because each attempt may reset the device's board.
const PAUSE_MAX: u32 = 50;
/// One more than the number of kinds: a queue of `N` holds `N − 1`.
const PLACES: usize = KINDS + 1;

/// Settings of the thread.
pub(crate) struct Opener {
    pub(crate) config: RtConfig,
    pub(crate) file: StationFile,
    pub(crate) cores: Vec<usize>,
    pub(crate) tick_core: usize,
    pub(crate) shared: Arc<Shared>,
}

impl Opener {
    /// Starts the thread and waits until every device is open. The thread ends after the tick.
    pub(crate) fn start(self) -> Result<(Devices, JoinHandle<()>), RtError> {
        let (sender, receiver) = mpsc::sync_channel(1);
        let thread = spawn("devices", 1 << 20, move || self.run(&sender))?;
        match receiver.recv() {
            Ok(Ok(devices)) => Ok((devices, thread)),
            Ok(Err(error)) => Err(error),
            Err(_) => Err(ended_without_report("devices", thread)),
        }
    }

    fn run(self, sender: &SyncSender<Result<Devices, RtError>>) {
        realtime::leave_signals_to_main();
        if self.config.realtime == Realtime::Ask {
            // The threads that read the devices' lines inherit this priority, so that they stamp
            // input before the tick reads it. Refusals are ignored here, because the tick's thread
            // will report the same ones.
            let priority = self.config.priority.saturating_add(1).min(99);
            let _ = realtime::work_beside_tick(&self.cores, self.tick_core, priority);
        }
        let devices = match Devices::open(&self.config, &self.file) {
            Ok(devices) => devices,
            Err(error) => {
                let _ = sender.send(Err(error));
                return;
            }
        };
        let capabilities = devices.capabilities();
        let (lost_in, mut lost) = queue();
        let (mut reopened, reopened_out) = queue();
        let exchange = Exchange {
            lost: lost_in,
            reopened: reopened_out,
        };
        let _ = sender.send(Ok(devices.with_exchange(exchange)));

        let mut waiting = [false; KINDS];
        // For each kind, counted in checks: time until the next attempt, and the pause after that
        // attempt.
        let mut pauses = [(0u32, 1u32); KINDS];
        while !self.shared.tick_ended.load(Acquire) {
            sleep(LOOK_EVERY);
            for kind in 0..KINDS {
                // Lost devices are closed before each attempt, because an attempt may take seconds.
                // Closing a device zeroes its force.
                self.close(&mut lost, &mut waiting);
                let Some(pause) = pauses.get_mut(kind) else {
                    continue;
                };
                if waiting.get(kind) != Some(&true) {
                    *pause = (0, 1);
                    continue;
                }
                if pause.0 > 0 {
                    pause.0 -= 1;
                    continue;
                }
                *pause = (pause.1, (pause.1 * 2).min(PAUSE_MAX));
                if let Some(device) = self.try_open(kind, &capabilities) {
                    crate::say!("calot rt: back: {}", self.name(kind));
                    if let Some(waits) = waiting.get_mut(kind) {
                        *waits = reopened.enqueue(device).is_err();
                    }
                }
            }
        }
    }

    /// Closes the lost devices.
    fn close(&self, lost: &mut Consumer<'static, Device>, waiting: &mut [bool; KINDS]) {
        while let Some(device) = lost.dequeue() {
            let kind = device.kind();
            drop(device);
            crate::say!(
                "calot rt: lost: {}; it is used again when it is back",
                self.name(kind)
            );
            if let Some(waits) = waiting.get_mut(kind) {
                *waits = true;
            }
        }
    }

    /// Reopens the device, if it answers and has the capabilities of the one that was lost.
    fn try_open(&self, kind: usize, capabilities: &DeviceCapabilities) -> Option<Device> {
        let device = match Device::reopen(kind, &self.config, &self.file) {
            Ok(device) => device?,
            // The device is present, but a person must calibrate it.
            Err(RtError::Device {
                device,
                source: source @ HardwareError::Calibration { .. },
            }) => {
                static PRINTED: OnceLock<()> = OnceLock::new();
                PRINTED.get_or_init(|| crate::say!("calot rt: {device}: {source}"));
                return None;
            }
            Err(_) => return None,
        };
        match &device {
            // Every check of the force uses the limits of the first device.
            Device::Haptic(haptic) if haptic.capabilities() != *capabilities => {
                static PRINTED: OnceLock<()> = OnceLock::new();
                PRINTED.get_or_init(|| {
                    crate::say!(
                        "calot rt: {} is another device now (its limits differ): plug in the first \
                         one again, or restart",
                        self.name(kind)
                    );
                });
                None
            }
            _ => Some(device),
        }
    }

    fn name(&self, kind: usize) -> String {
        Device::name(kind, &self.config, &self.file)
    }
}

/// A queue that lives as long as the process, like the tick's other queues.
fn queue() -> (Producer<'static, Device>, Consumer<'static, Device>) {
    Box::leak(Box::new(Queue::<Device, PLACES>::new())).split()
}
