//! Round-trip time on the line of a rig, from a command to the sample that confirms the command.

use rt_core::port::{ForceCommand, HapticDevice, Polled};

use super::bench::Clock;
use super::halt::Halt;
use crate::rig::RigHaptic;

/// Number of echoes to measure.
const ECHOES: usize = 200;
/// Largest number of ticks for all echoes. A device without an echo in this time confirms no
/// commands.
const TICKS_MAX: u32 = 3000;

/// Median time from a command of zero force to the sample that confirms the command, s. `None` if
/// the device confirms no commands.
///
/// # Errors
/// If the line is lost, or a person asks to stop.
pub fn echo_s(device: &mut RigHaptic, clock: &mut dyn Clock) -> Result<Option<f64>, Halt> {
    let mut under_way: Option<(u16, u64)> = None;
    let mut echoes_ns = Vec::with_capacity(ECHOES);
    for _ in 0..TICKS_MAX {
        if echoes_ns.len() >= ECHOES {
            break;
        }
        let now_ns = clock.next().ok_or(Halt::Asked)?;
        match device.poll(now_ns) {
            Polled::Lost => return Err(Halt::Lost),
            Polled::Fresh(_) => {
                let applied = device.status().applied_force;
                if let Some((sent, sent_ns)) = under_way
                    && applied.wrapping_sub(sent) < 0x8000
                {
                    echoes_ns.push(now_ns.saturating_sub(sent_ns));
                    under_way = None;
                }
            }
            Polled::Nothing => {}
        }
        device.send(ForceCommand::default(), now_ns);
        under_way = under_way.or(Some((device.sent_sequence(), now_ns)));
    }
    echoes_ns.sort_unstable();
    let median = echoes_ns.get(echoes_ns.len() / 2);
    Ok(median.map(|ns| *ns as f64 * 1e-9))
}
