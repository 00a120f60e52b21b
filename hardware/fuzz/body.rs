//! Body of the fuzz target: any bytes arrive on the line of an emulated haptic device. The driver's
//! samples go through Calot's own safety chain, which is asked for far too much force. The
//! output of the safety chain goes to the device's firmware. For all bytes there must be no panic,
//! no implausible position and no force above the clamp. No force may remain while samples are
//! missing or after the host has gone.

use hardware::emulate::{HapticModel, SimulatedDevice};
use rt_core::fault::FaultSet;
use rt_core::haptics::output_limit::{Demand, OutputLimit};
use rt_core::math::Vec3;
use rt_core::port::{ForceCommand, HapticDevice, Polled};
use rt_core::words::Status;

const MODELS: [HapticModel; 3] = [HapticModel::TouchRig, HapticModel::Woody, HapticModel::Hapi];
/// Age at which a sample of a device at 1 kHz is stale; the realtime process uses the same.
const STALE_MS: u32 = 5;
/// Time without samples, or without a host, after which no force may remain, ms.
const SILENT_MS: u32 = 100;
/// Largest distance of a handle from the device's origin, m, for any table-top device.
const REACH_M: f32 = 0.5;

/// The first byte chooses the device. Then pieces follow. The first byte of a piece states the
/// piece's length, the milliseconds that pass after the piece, and whether the device reports
/// during that time.
pub(crate) fn run(bytes: &[u8]) {
    let Some((&first, mut rest)) = bytes.split_first() else {
        return;
    };
    let model = MODELS[usize::from(first) % MODELS.len()];
    let (driver, line) = SimulatedDevice::open(model).expect("a device in memory answers");
    let mut station = Station::new(driver, line);
    // The force is on before the fuzzed bytes arrive.
    for _ in 0..5 {
        station.tick(true);
    }
    assert!(station.line.motor_load() > 0.1, "the force is on");
    while let Some((&how, more)) = rest.split_first() {
        let length = usize::from(how >> 2) % (more.len() + 1);
        let (piece, later) = more.split_at(length);
        rest = later;
        station.line.send_to_driver(piece);
        for _ in 0..1 + u32::from(how & 1) * 40 {
            station.tick(how & 2 != 0);
        }
    }
    station.end(model);
}

/// Driver, safety chain and device.
struct Station {
    driver: Box<dyn HapticDevice + Send>,
    line: SimulatedDevice,
    limit: OutputLimit,
    clamp_n: f32,
    place_m: Option<Vec3>,
    /// Time since the last sample.
    silent_ms: u32,
    is_lost: bool,
}

impl Station {
    fn new(driver: Box<dyn HapticDevice + Send>, line: SimulatedDevice) -> Self {
        let capabilities = driver.capabilities();
        let mut limit = OutputLimit::new(&capabilities, 0.0);
        limit.enable(true);
        Self {
            driver,
            line,
            limit,
            clamp_n: capabilities.force_max_n,
            place_m: None,
            silent_ms: 0,
            is_lost: false,
        }
    }

    fn tick(&mut self, device_speaks: bool) {
        self.line.millisecond(device_speaks);
        let now_ns = self.line.now_ns();
        let mut speed_m_s = 0.0;
        let mut fresh_m = None;
        match self.driver.poll(now_ns) {
            Polled::Fresh(sample) => {
                let pose = sample.device_from_handle;
                let place_m = pose.translation.vector;
                assert!(place_m.norm() <= REACH_M, "{place_m}");
                assert!((pose.rotation.norm() - 1.0).abs() < 1e-3, "{pose}");
                let velocity = sample.velocity_m_s.unwrap_or_default();
                assert!(velocity.iter().all(|part| part.is_finite()), "{velocity}");
                if let Some(before_m) = self.place_m.replace(place_m) {
                    speed_m_s = (place_m - before_m).norm() / 1e-3;
                }
                fresh_m = Some(place_m);
                self.silent_ms = 0;
            }
            Polled::Nothing => self.silent_ms += 1,
            Polled::Lost => {
                self.silent_ms += 1;
                self.is_lost = true;
            }
        }
        let demand = Demand {
            opening_n: 0.0,
            trocar_n: Vec3::zeros(),
            trocar_n_m: 0.0,
            force_n: Vec3::new(300.0, -200.0, 100.0),
            torque_nm: Vec3::new(1.0, 1.0, 1.0),
            stiffness_n_m: 100.0,
            handle_m: fresh_m,
            speed_m_s,
            device: match (self.is_lost, self.silent_ms > STALE_MS) {
                (true, _) => Status::Lost,
                (_, true) => Status::Stale,
                _ => Status::Live,
            },
            device_fails: false,
            paused: false,
        };
        // The test plays a person who enables the force again after each safety stop.
        if !self.limit.is_open() {
            self.limit.enable(true);
        }
        let command = self.limit.apply(&demand, &mut FaultSet::default());
        let size_n = command.force_n.norm();
        assert!(size_n <= self.clamp_n * 1.001, "{size_n} N leave");
        if self.silent_ms > SILENT_MS || self.is_lost {
            assert!(size_n <= 0.0, "{size_n} N leave without a sample");
        }
        self.driver.send(command, now_ns);
        let motor_load = self.line.motor_load();
        assert!(
            motor_load <= 1.001,
            "{motor_load} of what the motors may get"
        );
    }

    /// The host hangs, then closes.
    fn end(mut self, model: HapticModel) {
        self.driver
            .send(ForceCommand::default(), self.line.now_ns());
        let has_watchdog = model != HapticModel::Hapi;
        if has_watchdog {
            for _ in 0..=SILENT_MS {
                self.line.millisecond(false);
            }
            assert!(
                self.line.motor_load() <= 0.0,
                "the watchdog drops the force"
            );
        }
        drop(self.driver);
        self.line.millisecond(false);
        assert!(
            self.line.motor_load() <= 1e-6,
            "dropping the driver ends the force"
        );
    }
}
