//! What the realtime process is asked to do.

use std::path::PathBuf;

use rt_core::sim::Parameters;

use crate::alloc_counter::OnViolation;
use crate::error::RtError;
use crate::scope_line::ScopeLine;

/// Whether to ask Linux for realtime.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Realtime {
    /// Ask; go on without what is refused, and say so everywhere.
    Ask,
    /// Do not ask: every report is marked "not realtime".
    Never,
}

/// Which of Linux's realtime schedulers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheduler {
    /// `SCHED_FIFO`, pinned to one core.
    Fifo,
    /// `SCHED_DEADLINE`: the kernel guarantees the tick its time in every period and stops it when
    /// it takes more. Not pinned (Linux refuses that); priorities do not apply.
    Deadline,
}

/// Whether a scene must prove that it fits this machine ([`crate::admission`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdmissionPolicy {
    /// Measured; a scene that does not fit gives way to the next coarser level. When no level
    /// fits, the coarsest runs and says so.
    Measure,
    /// As `Measure`, but when no level fits, nothing runs.
    Strict,
    /// Not measured: a test that must start at once.
    Skip,
}

/// Everything that a run is given. `RtConfig::new` fills in the defaults.
#[derive(Debug, Clone)]
pub struct RtConfig {
    /// Name that the station's processes meet under.
    pub station: String,
    /// The compiled scene.
    pub scene: PathBuf,
    /// Coarser scenes, finest first, for a machine that fits none of the levels in the scene's
    /// own file.
    pub coarser: Vec<PathBuf>,
    /// Whether the scene must prove that it fits.
    pub admission: AdmissionPolicy,
    /// File that names the station's devices and where they stand ([`hardware::station`]).
    pub station_file: Option<PathBuf>,
    /// Serial device of the haptic device, in place of the station file's. Without either the
    /// force stays zero.
    pub haptic: Option<PathBuf>,
    /// Serial device of the endoscope's tracker.
    pub tracker: Option<PathBuf>,
    /// Serial device of the foot pedal.
    pub pedal: Option<PathBuf>,
    /// Whether to ask for realtime.
    pub realtime: Realtime,
    /// Which realtime scheduler the tick's thread asks for.
    pub scheduler: Scheduler,
    /// Core of the tick; none: the last one allowed.
    pub core: Option<usize>,
    /// `SCHED_FIFO` priority of the tick, 2 to 99.
    pub priority: u8,
    /// `SCHED_FIFO` priority of the publishing thread, below the tick's.
    pub publisher_priority: u8,
    /// Control period, ns. 1 ms; others are for experiments.
    pub period_ns: u64,
    /// Time before a tick that is spun instead of slept, ns. Lowers the wake-up latency, costs
    /// processor time; at most half a period, for Linux throttles a thread that never sleeps.
    pub spin_ns: u64,
    /// A sphere and tool frame is published every so many ticks.
    pub publish_every: u32,
    /// Ends by itself after so many periods (run or missed); none: runs until stopped.
    pub periods_max: Option<u64>,
    /// Iterations, force ramp, and whether force may leave from the start.
    pub parameters: Parameters,
    /// A line that is high while a tick runs, for an oscilloscope.
    pub scope_line: Option<ScopeLine>,
    /// What an allocation or page fault of the tick's thread leads to.
    pub on_violation: OnViolation,
}

impl RtConfig {
    /// A station's usual run of a scene, without devices.
    #[must_use]
    pub fn new(station: impl Into<String>, scene: impl Into<PathBuf>) -> Self {
        Self {
            station: station.into(),
            scene: scene.into(),
            coarser: Vec::new(),
            admission: AdmissionPolicy::Measure,
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
            publish_every: 4,
            periods_max: None,
            // The ramp takes the place of a person who enables the force.
            parameters: Parameters {
                force_enabled: true,
                ..Parameters::default()
            },
            scope_line: None,
            on_violation: OnViolation::BUILD_DEFAULT,
        }
    }

    /// Whether every number is in its range.
    ///
    /// # Errors
    /// [`RtError::Config`] names the first that is not.
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
    fn the_defaults_are_in_range_and_nonsense_is_named() {
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
        }
    }
}
