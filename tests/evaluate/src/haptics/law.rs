//! Laws that compute the force from the handle's position: Calot's tick, and simpler laws for
//! comparison.

use nalgebra::Translation3;
use rt_core::fault::{Fault, FaultCounters};
use rt_core::math::{Pose, Vec3};
use rt_core::port::{Buttons, DeviceCapabilities, DeviceSample, ForceCommand, Opening, Polled};
use rt_core::scene::Scene;
use rt_core::sim::{Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;

use super::device::Device;

/// Distance from the wall at which trials start, m.
pub(super) const START_M: f64 = 0.003;

/// A law that computes a force in each tick.
pub(super) trait Law {
    /// Force on the handle, N, positive away from the wall. `x_m` is the handle's sample, if one
    /// arrived.
    fn force_n(&mut self, x_m: Option<f64>) -> f64;
    /// True if the law has switched its force off.
    fn gave_up(&self) -> bool {
        false
    }
}

/// Hooke's law on the depth in a wall at 0.
pub(super) struct Hooke {
    pub(super) stiffness_n_m: f64,
    pub(super) x_m: f64,
}

impl Law for Hooke {
    fn force_n(&mut self, x_m: Option<f64>) -> f64 {
        self.x_m = x_m.unwrap_or(self.x_m);
        self.stiffness_n_m * (-self.x_m).max(0.0)
    }
}

/// A virtual coupling (Colgate 1995): a spring and a damper between the handle and a proxy of 5 g,
/// which meets the wall.
pub(super) struct Coupling {
    pub(super) stiffness_n_m: f64,
    x_m: f64,
    proxy_m: f64,
    proxy_m_s: f64,
}

impl Coupling {
    /// Stiffness, N/m, damping, N s/m, and mass, kg: the middle of the settings that were tried.
    const SPRING: [f64; 3] = [600.0, 1.0, 0.005];

    pub(super) fn new(stiffness_n_m: f64, x_m: f64) -> Self {
        Self {
            stiffness_n_m,
            x_m,
            proxy_m: x_m,
            proxy_m_s: 0.0,
        }
    }
}

impl Law for Coupling {
    fn force_n(&mut self, x_m: Option<f64>) -> f64 {
        const DT: f64 = 1e-3;
        let [k, b, m] = Self::SPRING;
        let now_m = x_m.unwrap_or(self.x_m);
        let v_m_s = (now_m - self.x_m) / DT;
        self.x_m = now_m;
        // Implicit Euler without the wall, and again with the wall if the proxy ends up in it.
        let step = |wall: f64| {
            let pull_n = k * (now_m - self.proxy_m) + b * v_m_s - wall * self.proxy_m;
            (m * self.proxy_m_s + DT * pull_n) / (m + DT * b + DT * DT * (k + wall))
        };
        let free = step(0.0);
        let inside = self.proxy_m + DT * free < 0.0;
        self.proxy_m_s = if inside {
            step(self.stiffness_n_m)
        } else {
            free
        };
        self.proxy_m += DT * self.proxy_m_s;
        k * (self.proxy_m - now_m) + b * (self.proxy_m_s - v_m_s)
    }
}

/// Calot's own tick as a law: it takes the handle's sample, runs a tick and returns the command.
pub(super) struct Product<'a> {
    sim: Sim<'a>,
    world: World,
    /// Height of the handle when its tip is at 0, m.
    handle_at_0_m: f64,
}

/// Record of Calot's output limits.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LimitRecord {
    /// Ticks in which the passivity observer damped.
    pub(super) damped: u64,
    /// Ticks in which the contact was too stiff for the device.
    pub(super) capped: u64,
    /// Lowest energy of the passivity observer, J.
    pub(super) energy_j: f64,
}

struct World {
    samples: Samples,
    force_n: f64,
    faults: FaultCounters,
    energy_j: f32,
}

impl Ports for World {
    fn sample(&mut self) -> Samples {
        self.samples
    }

    fn send_force(&mut self, command: ForceCommand) {
        self.force_n = f64::from(command.force_n.z);
    }

    fn publish(&mut self, view: &TickView<'_>) {
        self.faults = *view.fault_counters;
        self.energy_j = self.energy_j.min(view.energy_j);
    }

    fn stamp(&mut self, _: Stage) {}
}

impl<'a> Product<'a> {
    /// Starts Calot with the shaft upright over the scene. `top_m` is the height at which the tip
    /// meets the scene.
    pub(super) fn new(
        scene: Scene<'a>,
        state: &'a mut State,
        device: DeviceCapabilities,
        top_m: f64,
    ) -> Self {
        let parameters = Parameters {
            force_ramp_s: 0.0,
            force_enabled: true,
        };
        let handle_at_0_m = top_m + f64::from(scene.room().instrument_length_m);
        let mut law = Self {
            sim: Sim::new(scene, state, device, parameters),
            world: World {
                samples: Samples {
                    now_ns: 0,
                    device: Polled::Nothing,
                    tracker: Polled::Nothing,
                    pedal: Polled::Nothing,
                    command: None,
                },
                force_n: 0.0,
                faults: FaultCounters::ZERO,
                energy_j: 0.0,
            },
            handle_at_0_m,
        };
        // The jaws close far above the tissue. Then the handle moves down to the start of the
        // trials.
        for tick in 0..600 {
            let share = (f64::from(tick) / 400.0 - 0.5).clamp(0.0, 1.0);
            law.force_n(Some(0.03 + (START_M - 0.03) * share));
        }
        law
    }

    /// Record of the output limits so far.
    pub(super) fn limits(&self) -> LimitRecord {
        LimitRecord {
            damped: self.count(Fault::Damped),
            capped: self.count(Fault::StiffnessCapped),
            energy_j: f64::from(self.world.energy_j),
        }
    }

    fn count(&self, fault: Fault) -> u64 {
        self.world.faults.of(fault)
    }
}

impl Law for Product<'_> {
    fn force_n(&mut self, x_m: Option<f64>) -> f64 {
        let samples = &mut self.world.samples;
        samples.now_ns += 1_000_000;
        let at_ns = samples.now_ns;
        samples.device = x_m.map_or(Polled::Nothing, |x_m| {
            let at = Vec3::new(0.0, 0.0, (self.handle_at_0_m + x_m) as f32);
            Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: Pose::from(Translation3::from(at)),
                velocity_m_s: None,
                buttons: Buttons::GRASP,
                sequence: 0,
                at_ns,
            })
        });
        self.sim.tick(&mut self.world);
        self.world.force_n
    }

    fn gave_up(&self) -> bool {
        self.count(Fault::SpeedTrip) > 0
    }
}

/// Capabilities that a device built like `device` would state.
pub(super) fn stated(device: &Device) -> DeviceCapabilities {
    // Viscous damping that dissipates as much energy as the dry friction does in a vibration of 0.2
    // m/s peak speed.
    let friction_n_s_m = 4.0 * device.friction_n / (std::f64::consts::PI * 0.2);
    DeviceCapabilities {
        opening: Opening::NONE,
        force_max_n: device.peak_n as f32,
        force_continuous_n: 0.88,
        torque_max_nm: 0.0,
        stiffness_max_n_m: 700.0,
        damping_max_n_s_m: 5.0,
        damping_n_s_m: (device.damping_n_s_m + friction_n_s_m) as f32,
        delay_s: device.delay_s as f32,
        workspace_radius_m: 0.1,
        rate_hz: (1000 / device.every) as f32,
    }
}

/// The stated capabilities without limits on stiffness and damping, so that only the clamp of the
/// force acts.
pub(super) fn boundless(device: &Device) -> DeviceCapabilities {
    DeviceCapabilities {
        stiffness_max_n_m: 1e9,
        damping_max_n_s_m: 0.0,
        damping_n_s_m: 1e9,
        delay_s: 0.0,
        ..stated(device)
    }
}
