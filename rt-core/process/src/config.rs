//! Settings of a run of the realtime process.

use std::path::PathBuf;

use rt_core::sim::Parameters;

use crate::alloc_counter::OnViolation;
use crate::error::RtError;
use crate::scope_line::ScopeLine;

/// Request for realtime privileges from Linux.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Realtime {
    /// Ask Linux. Continue without the privileges that it refuses, and say so in every report.
    Ask,
    /// Do not ask. Every report is marked "not realtime".
    Never,
}

/// Linux's realtime schedulers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheduler {
    /// `SCHED_FIFO`, pinned to one core.
    Fifo,
    /// `SCHED_DEADLINE`: the kernel guarantees the tick its time in every period and stops it when
    /// it takes more. The thread is not pinned, because Linux refuses that, and priorities do not
    /// apply.
    Deadline,
}

/// Policy on scenes that may not fit this machine ([`crate::admission`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdmissionPolicy {
    /// Measure; take the finest level that fits. If none fits, run the coarsest and report it.
    Measure,
    /// Like `Measure`, but refuse to run if no level fits.
    Strict,
    /// Do not measure. This is for tests that must start at once.
    Skip,
}

/// Settings of a run. `RtConfig::new` fills in the defaults.
#[derive(Debug, Clone)]
pub struct RtConfig {
    /// Name under which the station's processes meet.
    pub station: String,
    /// The compiled scene.
    pub scene: PathBuf,
    /// Coarser scenes, finest first. They are tried if no level in the scene's own file fits this
    /// machine.
    pub coarser: Vec<PathBuf>,
    /// Policy on scenes that may not fit.
    pub admission: AdmissionPolicy,
    /// Refuse to run if Linux does not grant realtime.
    pub must_be_realtime: bool,
    /// File with the station's devices and their poses ([`hardware::station`]).
    pub station_file: Option<PathBuf>,
    /// Path of the haptic device's serial port. It overrides the station file. Without a haptic
    /// device in either place, the force stays zero.
    pub haptic: Option<PathBuf>,
    /// Path of the serial port of the endoscope's tracker. It overrides the station file.
    pub tracker: Option<PathBuf>,
    /// Path of the foot pedal's serial port. It overrides the station file.
    pub pedal: Option<PathBuf>,
    /// Request for realtime privileges.
    pub realtime: Realtime,
    /// Realtime scheduler of the tick's thread.
    pub scheduler: Scheduler,
    /// Core of the tick; `None`: the last core that the process may use.
    pub core: Option<usize>,
    /// `SCHED_FIFO` priority of the tick, 2 to 99.
    pub priority: u8,
    /// `SCHED_FIFO` priority of the publishing thread, below the tick's.
    pub publisher_priority: u8,
    /// Control period, ns. 1 ms; other values are for experiments.
    pub period_ns: u64,
    /// Time before each tick in which the thread spins instead of sleeping, ns. Spinning lowers the
    /// wake-up latency and costs processor time. At most half a period, because Linux throttles a
    /// thread that never sleeps.
    pub spin_ns: u64,
    /// Let the ticks follow the arrivals of the haptic device's samples ([`crate::phase`]).
    pub follows_device: bool,
    /// Number of ticks per published frame. A frame has the spheres and the tools.
    pub publish_every: u32,
    /// Number of periods (run or missed) after which the run ends; `None`: until stopped.
    pub periods_max: Option<u64>,
    /// Duration of the force ramp, and permission for force from the start.
    pub parameters: Parameters,
    /// Iterations of the paper's method; 0: the run solves neo-Hookean tetrahedra instead.
    pub paper_iterations: u32,
    /// A modem line that is high while a tick runs, or until its force has left, for an
    /// oscilloscope.
    pub scope_line: Option<ScopeLine>,
    /// Consequence of an allocation, page fault or block in the tick's thread.
    pub on_violation: OnViolation,
}

impl RtConfig {
    /// Usual settings of a station for a scene, without devices.
    #[must_use]
    pub fn new(station: impl Into<String>, scene: impl Into<PathBuf>) -> Self {
        Self {
            station: station.into(),
            scene: scene.into(),
            coarser: Vec::new(),
            admission: AdmissionPolicy::Measure,
            must_be_realtime: false,
            station_file: None,
            haptic: None,
            tracker: None,
            pedal: None,
            realtime: Realtime::Ask,
            scheduler: Scheduler::Fifo,
            core: None,
            priority: 80,
            publisher_priority: 40,
            period_ns: 1_000_000,
            spin_ns: 0,
            follows_device: false,
            publish_every: 4,
            periods_max: None,
            // The force needs no person to enable it: it rises by the ramp from the start.
            parameters: Parameters {
                force_enabled: true,
                ..Parameters::default()
            },
            paper_iterations: 0,
            scope_line: None,
            on_violation: OnViolation::BUILD_DEFAULT,
        }
    }

    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// [`RtError::Config`] names the first number out of its range.
    pub fn check(&self) -> Result<(), RtError> {
        let range = |what: &'static str, value: u64, min: u64, max: u64| {
            if (min..=max).contains(&value) {
                return Ok(());
            }
            Err(RtError::Config {
                what,
                value,
                min,
                max,
            })
        };
        range("priority", self.priority.into(), 2, 99)?;
        let below = u64::from(self.priority) - 1;
        range(
            "publisher_priority",
            self.publisher_priority.into(),
            1,
            below,
        )?;
        range("period_ns", self.period_ns, 100_000, 100_000_000)?;
        range("spin_ns", self.spin_ns, 0, self.period_ns / 2)?;
        range("publish_every", self.publish_every.into(), 1, 1000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_in_range_and_a_setting_out_of_range_is_named() {
        let good = RtConfig::new("s", "x.scene");
        assert!(good.check().is_ok());
        let bad = [
            (
                "priority",
                RtConfig {
                    priority: 100,
                    ..good.clone()
                },
            ),
            (
                "publisher_priority",
                RtConfig {
                    publisher_priority: 80,
                    ..good.clone()
                },
            ),
            (
                "period_ns",
                RtConfig {
                    period_ns: 0,
                    ..good.clone()
                },
            ),
            (
                "spin_ns",
                RtConfig {
                    spin_ns: 900_000,
                    ..good.clone()
                },
            ),
            (
                "publish_every",
                RtConfig {
                    publish_every: 0,
                    ..good
                },
            ),
        ];
        for (name, config) in bad {
            let error = config.check().unwrap_err().to_string();
            assert!(error.starts_with(name), "{error}");
            assert!(error.contains(", allowed are "), "{error}");
        }
    }
}
