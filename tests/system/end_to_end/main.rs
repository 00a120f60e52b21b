//! The real programs: stations, their processes, devices on real lines, screens, networks.

mod bad_input;
mod devices;
mod drill;
mod elsewhere;
mod failures;
mod jitter;
mod launcher;
mod main_job;
mod operation;
mod replay;
