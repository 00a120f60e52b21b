//! Settings of the tick's thread.

use rt_core::scene::TrocarChoice;
use rt_core::sim::Parameters;
use shared_mem::message::STAGES;

use crate::admission::Admission;
use crate::alloc_counter::OnViolation;
use crate::budget;
use crate::config::{Realtime, RtConfig, Scheduler};

/// The numbers of [`RtConfig`] that the tick's thread needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Settings {
    pub(crate) realtime: Realtime,
    pub(crate) priority: u8,
    pub(crate) scheduler: Scheduler,
    pub(crate) period_ns: u64,
    pub(crate) spin_ns: u64,
    pub(crate) follows_device: bool,
    pub(crate) publish_every: u32,
    /// Time that each stage needs, ns: measured at admission, or else its budget.
    pub(crate) needs_ns: [u64; STAGES],
    pub(crate) periods_max: Option<u64>,
    pub(crate) parameters: Parameters,
    pub(crate) paper_iterations: u32,
    /// Trocar that the station file names.
    pub(crate) trocar: TrocarChoice,
    pub(crate) on_violation: OnViolation,
}

impl Settings {
    pub(crate) fn new(config: &RtConfig, admission: Option<&Admission>) -> Self {
        let budgets = budget::all_ns(config.period_ns);
        Self {
            needs_ns: admission.map_or(budgets, |admission| admission.worst_stage_ns),
            realtime: config.realtime,
            priority: config.priority,
            scheduler: config.scheduler,
            period_ns: config.period_ns,
            spin_ns: config.spin_ns,
            follows_device: config.follows_device,
            publish_every: config.publish_every,
            periods_max: config.periods_max,
            parameters: config.parameters,
            paper_iterations: config.paper_iterations,
            trocar: TrocarChoice::Scene,
            on_violation: config.on_violation,
        }
    }
}
