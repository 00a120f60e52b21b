//! The station's devices behind the core's ports (traits). A device that is not configured is
//! absent.
//!
//! The tick hands a lost device to the thread that opens devices ([`crate::reconnect`]). That
//! thread closes the device, opens it again and hands it back.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hardware::HardwareError;
use hardware::bird::{BirdSetup, BirdTracker};
use hardware::station::StationFile;
use heapless::spsc::{Consumer, Producer};
use rt_core::fault::Fault;
use rt_core::port::{
    DeviceCapabilities, DeviceSample, Echo, Findings, ForceCommand, HapticDevice, Identity,
    LineCounters, Pedal, PedalSample, Polled, Tracker, TrackerSample,
};
use rt_core::time::TimeNs;
use shared_mem::message::DeviceHealth;

use crate::config::RtConfig;
use crate::error::RtError;
use crate::handle_pedal::HandlePedal;
use crate::held_pedal::HeldPedal;
use crate::silence::Silence;
use crate::summary::DeviceReport;

/// Capabilities that the core gets if no haptic device is configured. No force is sent then.
pub(crate) const FALLBACK_CAPABILITIES: DeviceCapabilities = DeviceCapabilities::TOUCH;

/// Number of device kinds. Their order is that of the [`DeviceHealth`]s.
pub(crate) const KINDS: usize = 3;

/// An open device of any kind.
pub(crate) enum Device {
    Haptic(Box<dyn HapticDevice + Send>),
    Tracker(Box<dyn Tracker + Send>),
    Pedal(Box<dyn Pedal + Send>),
}

impl Device {
    /// Opens the configured device of this kind (a number below [`KINDS`]), from its path or the
    /// station file. Waits until the device answers.
    pub(crate) fn open(
        kind: usize,
        config: &RtConfig,
        file: &StationFile,
    ) -> Result<Option<Self>, RtError> {
        Ok(match kind {
            0 => haptic(config, file)?.map(Self::Haptic),
            1 => tracker(config, file)?.map(Self::Tracker),
            _ => pedal(config, file)?.map(Self::Pedal),
        })
    }

    /// Opens a lost device again. Nobody holds its handle at the home position now, so a haptic
    /// device that must be held there is refused.
    pub(crate) fn reopen(
        kind: usize,
        config: &RtConfig,
        file: &StationFile,
    ) -> Result<Option<Self>, RtError> {
        match (kind, &config.haptic, &file.haptic) {
            (0, None, Some(spec)) => Ok(Some(Self::Haptic(named(HAPTIC, &spec.path, |_| {
                spec.reopen()
            })?))),
            _ => Self::open(kind, config, file),
        }
    }

    pub(crate) fn kind(&self) -> usize {
        match self {
            Self::Haptic(_) => 0,
            Self::Tracker(_) => 1,
            Self::Pedal(_) => 2,
        }
    }

    /// Kind and path, for messages.
    pub(crate) fn name(kind: usize, config: &RtConfig, file: &StationFile) -> String {
        let name = [HAPTIC, TRACKER, PEDAL].get(kind).copied().unwrap_or(PEDAL);
        let path = Self::path(kind, config, file);
        path.map_or(name.to_owned(), |path| format!("{name} {}", path.display()))
    }

    /// Path of the configured device of this kind.
    pub(crate) fn path<'a>(
        kind: usize,
        config: &'a RtConfig,
        file: &'a StationFile,
    ) -> Option<&'a Path> {
        let path = match kind {
            0 => (config.haptic.as_ref()).or(file.haptic.as_ref().map(|spec| &spec.path)),
            1 => (config.tracker.as_ref()).or(file.tracker.as_ref().map(|spec| &spec.path)),
            _ => (config.pedal.as_ref()).or(file.pedal.as_ref().map(|spec| &spec.path)),
        };
        path.map(PathBuf::as_path)
    }

    /// Description for reports.
    fn report(&self, path: &Path) -> DeviceReport {
        let (identity, capabilities) = match self {
            Self::Haptic(device) => (device.identity(), Some(device.capabilities())),
            Self::Tracker(_) | Self::Pedal(_) => (Identity::default(), None),
        };
        DeviceReport {
            kind: ["haptic", "tracker", "pedal"][self.kind()],
            path: path.to_owned(),
            name: identity.name.as_str().to_owned(),
            serial: identity.serial,
            capabilities: capabilities.map(by_name).unwrap_or_default(),
        }
    }

    fn counters(&self) -> LineCounters {
        match self {
            Self::Haptic(device) => device.counters(),
            Self::Tracker(device) => device.counters(),
            Self::Pedal(device) => device.counters(),
        }
    }
}

const HAPTIC: &str = "haptic device";
const TRACKER: &str = "tracker";
const PEDAL: &str = "pedal";

fn haptic(
    config: &RtConfig,
    file: &StationFile,
) -> Result<Option<Box<dyn HapticDevice + Send>>, RtError> {
    Ok(match (&config.haptic, &file.haptic) {
        (Some(path), _) => Some(Box::new(named(
            HAPTIC,
            path,
            hardware::rig::RigHaptic::open,
        )?)),
        (None, Some(spec)) => Some(named(HAPTIC, &spec.path, |_| {
            spec.check_felt()?;
            spec.open()
        })?),
        (None, None) => None,
    })
}

fn tracker(
    config: &RtConfig,
    file: &StationFile,
) -> Result<Option<Box<dyn Tracker + Send>>, RtError> {
    Ok(match (&config.tracker, &file.tracker) {
        (Some(path), _) => Some(Box::new(named(TRACKER, path, |path| {
            BirdTracker::open(path, BirdSetup::default())
        })?)),
        (None, Some(spec)) => Some(Box::new(named(TRACKER, &spec.path, |_| spec.open())?)),
        (None, None) => None,
    })
}

fn pedal(config: &RtConfig, file: &StationFile) -> Result<Option<Box<dyn Pedal + Send>>, RtError> {
    Ok(match (&config.pedal, &file.pedal) {
        (Some(path), _) => Some(Box::new(named(PEDAL, path, hardware::rig::RigPedal::open)?)),
        (None, Some(spec)) => Some(named(PEDAL, &spec.path, |_| spec.open())?),
        (None, None) => None,
    })
}

/// The tick's ends of the two queues that connect it to the thread that opens devices. Each queue
/// has room for one device of every kind. That is enough: each kind has one device, which is in its
/// slot, in one of the queues, or in the hands of that thread.
pub(crate) struct Exchange {
    pub(crate) lost: Producer<'static, Device>,
    pub(crate) reopened: Consumer<'static, Device>,
}

/// One kind of device, present or lost.
#[derive(Default)]
struct Slot {
    device: Option<Device>,
    is_lost: bool,
    /// Sum of the line counters of this kind's earlier devices, which were lost.
    before: LineCounters,
    /// True once a device of this kind was put here.
    configured: bool,
}

/// The tick's devices of all kinds.
#[derive(Default)]
pub(crate) struct Devices {
    slots: [Slot; KINDS],
    handle_pedal: HandlePedal,
    held_pedal: HeldPedal,
    silence: Silence,
    exchange: Option<Exchange>,
}

impl Devices {
    /// Opens all configured devices. Waits for each device's answer.
    pub(crate) fn open(config: &RtConfig, file: &StationFile) -> Result<Self, RtError> {
        let mut devices = Self {
            handle_pedal: HandlePedal::new(file.handle_buttons),
            ..Self::default()
        };
        for kind in 0..KINDS {
            if let Some(device) = Device::open(kind, config, file)? {
                devices.put(device);
            }
        }
        Ok(devices)
    }

    /// Makes lost devices leave and return through `exchange`. Without an exchange, a lost device
    /// stays in its slot.
    pub(crate) fn with_exchange(mut self, exchange: Exchange) -> Self {
        self.exchange = Some(exchange);
        self
    }

    /// Puts this device into the slot of its kind.
    pub(crate) fn put(&mut self, device: Device) {
        if let Some(slot) = self.slots.get_mut(device.kind()) {
            slot.device = Some(device);
            slot.is_lost = false;
            slot.configured = true;
        }
    }

    /// Takes back reopened devices. Neither waits nor frees memory.
    pub(crate) fn take_reopened(&mut self) {
        while let Some(device) = self.exchange.as_mut().and_then(|e| e.reopened.dequeue()) {
            self.put(device);
        }
    }

    /// The newest sample of the haptic device.
    pub(crate) fn poll_haptic(&mut self, now_ns: TimeNs) -> Polled<DeviceSample> {
        let mut polled = self.poll(0, |device| match device {
            Device::Haptic(device) => device.poll(now_ns),
            _ => Polled::Nothing,
        });
        self.silence.note(&polled, now_ns);
        self.handle_pedal.take(&mut polled);
        polled
    }

    /// Findings of the haptic device's last poll, and the fault of a pedal that is held down.
    /// Without an open haptic device, the result has only the pedal's fault.
    pub(crate) fn findings(&self) -> Findings {
        let mut findings = match self.slots.first().and_then(|slot| slot.device.as_ref()) {
            Some(Device::Haptic(haptic)) => self.silence.complete(haptic.findings()),
            _ => Findings::default(),
        };
        let is_held = self.held_pedal.is_held();
        findings.faults.raise_if(is_held, Fault::HeldPedal);
        findings
    }

    /// Echo of a force that the haptic device's last poll heard.
    pub(crate) fn echo(&self) -> Option<Echo> {
        match self.slots.first().and_then(|slot| slot.device.as_ref()) {
            Some(Device::Haptic(haptic)) => haptic.echo(),
            _ => None,
        }
    }

    /// The newest sample of the tracker.
    pub(crate) fn poll_tracker(&mut self, now_ns: TimeNs) -> Polled<TrackerSample> {
        self.poll(1, |device| match device {
            Device::Tracker(device) => device.poll(now_ns),
            _ => Polled::Nothing,
        })
    }

    /// Newest state of the pedal, including handle buttons that act as a pedal. Call it after
    /// [`Self::poll_haptic`].
    pub(crate) fn poll_pedal(&mut self, now_ns: TimeNs) -> Polled<PedalSample> {
        let pedal = self.poll(2, |device| match device {
            Device::Pedal(device) => device.poll(now_ns),
            _ => Polled::Nothing,
        });
        let joined = self.handle_pedal.join(pedal, now_ns);
        self.held_pedal.released_once(joined)
    }

    fn poll<T>(&mut self, kind: usize, poll: impl FnOnce(&mut Device) -> Polled<T>) -> Polled<T> {
        let Some(slot) = self.slots.get_mut(kind) else {
            return Polled::Nothing;
        };
        let Some(device) = &mut slot.device else {
            return if slot.is_lost {
                Polled::Lost
            } else {
                Polled::Nothing
            };
        };
        // The device stays in its slot while it is polled. If the driver panics, the thread still
        // sends it zero force.
        let polled = poll(device);
        if let (Polled::Lost, Some(exchange)) = (&polled, &mut self.exchange)
            && let Some(lost) = slot.device.take()
        {
            slot.is_lost = true;
            slot.before = slot.before.plus(lost.counters());
            // The queue is never full. If it were, the device would stay in its slot, and the next
            // poll would find it lost again.
            slot.device = exchange.lost.enqueue(lost).err();
        }
        polled
    }

    /// True if a haptic device is configured, even if it is lost now.
    pub(crate) fn has_haptic(&self) -> bool {
        self.slots.first().is_some_and(|slot| slot.configured)
    }

    /// Sends a force if a haptic device is present.
    pub(crate) fn send(&mut self, command: ForceCommand, now_ns: TimeNs) {
        if let Some(Device::Haptic(haptic)) = self.slots.first_mut().and_then(|s| s.device.as_mut())
        {
            haptic.send(command, now_ns);
        }
    }

    /// Capabilities of the haptic device; [`FALLBACK_CAPABILITIES`] if none is open.
    pub(crate) fn capabilities(&self) -> DeviceCapabilities {
        match self.slots.first().and_then(|slot| slot.device.as_ref()) {
            Some(Device::Haptic(haptic)) => haptic.capabilities(),
            _ => FALLBACK_CAPABILITIES,
        }
    }

    /// Sends zero force, which is the safe state. It sends three messages, because a line may drop
    /// one.
    pub(crate) fn make_safe(&mut self, now_ns: TimeNs) {
        for _ in 0..3 {
            self.send(ForceCommand::default(), now_ns);
        }
    }

    /// Descriptions of the open devices.
    pub(crate) fn reports(&self, config: &RtConfig, file: &StationFile) -> Vec<DeviceReport> {
        let open = self.slots.iter().filter_map(|slot| slot.device.as_ref());
        open.filter_map(|device| Some(device.report(Device::path(device.kind(), config, file)?)))
            .collect()
    }

    /// Line counters of haptic device, tracker and pedal; `None` for one that is not configured.
    pub(crate) fn counters(&self) -> [Option<LineCounters>; KINDS] {
        self.slots.each_ref().map(|slot| {
            let now = slot.device.as_ref().map(Device::counters);
            slot.configured
                .then(|| slot.before.plus(now.unwrap_or_default()))
        })
    }
}

/// Capabilities as a map from field name to value, for reports.
fn by_name(capabilities: DeviceCapabilities) -> BTreeMap<&'static str, f32> {
    [
        ("force_max_n", capabilities.force_max_n),
        ("force_continuous_n", capabilities.force_continuous_n),
        ("torque_max_n_m", capabilities.torque_max_nm),
        ("opening_travel_m", capabilities.opening.travel_m),
        ("opening_force_max_n", capabilities.opening.force_max_n),
        (
            "opening_stiffness_max_n_m",
            capabilities.opening.stiffness_max_n_m,
        ),
        ("stiffness_max_n_m", capabilities.stiffness_max_n_m),
        ("damping_max_n_s_m", capabilities.damping_max_n_s_m),
        ("damping_n_s_m", capabilities.damping_n_s_m),
        ("delay_s", capabilities.delay_s),
        ("workspace_radius_m", capabilities.workspace_radius_m),
        ("rate_hz", capabilities.rate_hz),
    ]
    .into()
}

fn named<T>(
    device: &'static str,
    path: &Path,
    open: impl FnOnce(&Path) -> Result<T, HardwareError>,
) -> Result<T, RtError> {
    open(path).map_err(|source| RtError::Device { device, source })
}

/// Health of a device as frames carry it.
pub(crate) fn health(health: rt_core::words::Health, line: Option<LineCounters>) -> DeviceHealth {
    let line_or_zero = line.unwrap_or_default();
    DeviceHealth {
        status: match (line, health.status) {
            (None, _) => DeviceHealth::ABSENT,
            // The device is configured, but no sample has come yet, or the newest one is too old.
            (Some(_), rt_core::words::Status::Absent | rt_core::words::Status::Stale) => {
                DeviceHealth::STALE
            }
            (Some(_), rt_core::words::Status::Live) => DeviceHealth::LIVE,
            (Some(_), rt_core::words::Status::Lost) => DeviceHealth::LOST,
        },
        age_us: u32::try_from(health.age_ns / 1000).unwrap_or(u32::MAX),
        frames: line_or_zero.frames,
        bad_frames: line_or_zero.bad_frames,
        lost_frames: line_or_zero.lost_frames,
        dropped_writes: line_or_zero.dropped_writes,
        unread_bytes: line_or_zero.unread_bytes,
    }
}
