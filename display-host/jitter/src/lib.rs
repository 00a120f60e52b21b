//! Measures the ticks of a controller: their wake-up latency, their duration and the share of
//! missed periods. Compares them with other programs that ran in the same minutes. The package
//! starts no station and draws no picture; its caller passes in timing records.
//!
//! ```text
//! timing records ─► tally ─┬─► blackbox   ticks around the most delayed ones
//!                          ├─► timeline   worst times of each time step
//!                          ├─► budgets    the stage that made a tick late
//!                          └─► report ◄── baselines   other programs, which take turns
//!                                │  ◄──── kernel      interrupts, stolen time
//!                                │  ◄──── why         what ran on the core while a tick was late
//!                                └─► table (text, CSV), page (HTML), trace (Perfetto), two_runs,
//!                                    exchange (.hgrm, cyclictest's text)
//! ```
//!
//! [`photon`] is a separate measurement: the time from a tick to its light on the screen.

pub mod baselines;
pub mod blackbox;
pub mod budgets;
mod cause;
pub mod certainty;
pub mod exchange;
pub mod intervals;
pub mod kernel;
pub mod machines;
pub mod misses;
mod page;
mod part;
pub mod photon;
mod problem;
pub mod report;
mod slice;
pub mod table;
pub mod tally;
pub mod timeline;
pub mod timerlat;
mod trace;
mod turn;
pub mod two_runs;
pub mod verdict;
pub mod why;

pub use baselines::Baseline;
pub use page::html;
pub use problem::Problem;
pub use report::Report;
pub use trace::json as trace;
