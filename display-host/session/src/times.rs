//! Times of a session's ticks and of their stages, which the realtime process measured.

use prost::Message as _;
use shared_mem::message::STAGES;

use crate::proto;

/// Times of one tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TickTimes {
    /// Number of the tick.
    pub tick: u64,
    /// Actual minus scheduled start, ns.
    pub wake_ns: u32,
    /// Duration of the tick, ns.
    pub tick_ns: u32,
    /// From the arrival of the device's sample until the force was written, ns; 0: no new sample.
    pub motion_to_force_ns: u32,
    /// Duration of each stage, ns: sample, tool, contact, solve, force, procedure, publish.
    pub stage_ns: [u32; STAGES],
    /// Periods that were skipped before the tick.
    pub missed: u32,
}

/// Parses a message; `None` if it is no message of this kind, or if its columns differ in length.
pub(crate) fn read(message: &[u8]) -> Option<Vec<TickTimes>> {
    let stages = proto::Stages::decode(message).ok()?;
    let of_stages: [&Vec<u32>; STAGES] = [
        &stages.sample_ns,
        &stages.tool_ns,
        &stages.contact_ns,
        &stages.solve_ns,
        &stages.force_ns,
        &stages.procedure_ns,
        &stages.publish_ns,
    ];
    (0..stages.wake_ns.len())
        .map(|i| {
            let of = |column: &Vec<u32>| column.get(i).copied();
            let mut stage_ns = [0; STAGES];
            for (ns, column) in stage_ns.iter_mut().zip(of_stages) {
                *ns = of(column)?;
            }
            Some(TickTimes {
                tick: stages.first_tick.checked_add(i as u64)?,
                wake_ns: of(&stages.wake_ns)?,
                tick_ns: of(&stages.tick_ns)?,
                motion_to_force_ns: of(&stages.motion_to_force_ns)?,
                stage_ns,
                missed: of(&stages.missed)?,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn columns_of_different_lengths_are_refused() {
        let one = vec![1];
        let mut stages = proto::Stages {
            first_tick: 4,
            wake_ns: one.clone(),
            tick_ns: one.clone(),
            motion_to_force_ns: one.clone(),
            sample_ns: one.clone(),
            tool_ns: one.clone(),
            contact_ns: one.clone(),
            solve_ns: vec![9],
            force_ns: one.clone(),
            procedure_ns: one.clone(),
            publish_ns: one.clone(),
            missed: one,
        };
        let read_back = read(&stages.encode_to_vec()).unwrap();
        assert_eq!((read_back[0].tick, read_back[0].stage_ns[3]), (4, 9));
        stages.first_tick = u64::MAX;
        assert!(read(&stages.encode_to_vec()).is_some());
        stages.solve_ns.clear();
        assert_eq!(read(&stages.encode_to_vec()), None);
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = read(&bytes);
        }
    }
}
