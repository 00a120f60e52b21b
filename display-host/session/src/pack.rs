//! Packs the inputs of a tick: absent fields are left out, times are differences. A tick with a
//! sample of the haptic device takes 51 to 83 bytes, besides samples of tracker and pedal and a
//! command.
//!
//! ```text
//! u16 number of ticks, u64 first tick, u64 time to which the first difference is added, ns; then
//! each tick:
//! u32 bits (those of InputRecord; 1 << 29 hashes of organs, 1 << 30 command, 1 << 31 long times)
//! time since the tick before: u32 ns, or u64 with long times
//! u32 tools hash, u32 spheres hash, [16 u8 hashes of organs, unless as before], [u8 command]
//! [haptic device: age, 3 f32 position, 4 f32 orientation, [3 f32 velocity], u16 number,
//!     u8 buttons, [f32 opening]]
//! [tracker: age, 3 f32, 4 f32]  [pedal: age]          an age has the size of the time
//! ```
//!
//! All little-endian.

use bytemuck::Zeroable as _;
use shared_mem::inputs::InputRecord;
use shared_mem::message::PoseMsg;

/// Bit of a packed tick: the hashes of the organs follow, because they changed.
const ORGANS: u32 = 1 << 29;
/// Bit of a packed tick: a command follows.
const COMMAND: u32 = 1 << 30;
/// Bit of a packed tick: its times have 64 bits.
const LONG: u32 = 1 << 31;
/// Bits of `InputRecord` that a packed tick keeps: all below the three bits above.
const KEPT: u32 = ORGANS - 1;

/// Packs the first records, up to a gap between their ticks. Returns the number of packed records.
pub fn pack(records: &[InputRecord], into: &mut Vec<u8>) -> usize {
    let Some(first) = records.first() else {
        return 0;
    };
    let expected = (0..u64::from(u16::MAX)).map(|i| first.tick.wrapping_add(i));
    let together = records
        .iter()
        .zip(expected)
        .take_while(|(record, tick)| record.tick == *tick)
        .count();
    into.extend((together as u16).to_le_bytes());
    into.extend(first.tick.to_le_bytes());
    into.extend(first.now_ns.to_le_bytes());
    let mut before = before_first(first.now_ns);
    for record in records.iter().take(together) {
        pack_one(record, &before, into);
        before = *record;
    }
    together
}

/// Reference against which the first tick of a message is packed.
fn before_first(now_ns: u64) -> InputRecord {
    InputRecord {
        now_ns,
        ..InputRecord::zeroed()
    }
}

fn pack_one(record: &InputRecord, before: &InputRecord, into: &mut Vec<u8>) {
    let has = |bit: u32| record.bits & bit != 0;
    let age = |at_ns: u64| record.now_ns.wrapping_sub(at_ns);
    let passed_ns = record.now_ns.wrapping_sub(before.now_ns);
    let ages = [
        (InputRecord::DEVICE_FRESH, age(record.device_at_ns)),
        (InputRecord::TRACKER_FRESH, age(record.tracker_at_ns)),
        (InputRecord::PEDAL_FRESH, age(record.pedal_at_ns)),
    ];
    let used = ages.iter().filter(|(bit, _)| has(*bit)).map(|(_, ns)| *ns);
    let is_long = used.chain([passed_ns]).any(|ns| u32::try_from(ns).is_err());
    let flag = |on: bool, bit: u32| if on { bit } else { 0 };
    let organs = record.organ_hashes != before.organ_hashes;
    let bits = (record.bits & KEPT)
        | flag(organs, ORGANS)
        | flag(record.command != 0, COMMAND)
        | flag(is_long, LONG);
    into.extend(bits.to_le_bytes());
    let time = |ns: u64, into: &mut Vec<u8>| match is_long {
        true => into.extend(ns.to_le_bytes()),
        false => into.extend((ns as u32).to_le_bytes()),
    };
    time(passed_ns, into);
    into.extend(record.tools_hash.to_le_bytes());
    into.extend(record.spheres_hash.to_le_bytes());
    if organs {
        into.extend(record.organ_hashes);
    }
    if record.command != 0 {
        into.push(record.command);
    }
    let [(_, device_ns), (_, tracker_ns), (_, pedal_ns)] = ages;
    if has(InputRecord::DEVICE_FRESH) {
        time(device_ns, into);
        into.extend(bytemuck::bytes_of(&record.device_from_handle));
        if has(InputRecord::HAS_VELOCITY) {
            into.extend(bytemuck::bytes_of(&record.velocity_m_s));
        }
        into.extend(record.sequence.to_le_bytes());
        into.push(record.buttons);
        if has(InputRecord::HAS_OPENING) {
            into.extend(record.opening.to_le_bytes());
        }
    }
    if has(InputRecord::TRACKER_FRESH) {
        time(tracker_ns, into);
        into.extend(bytemuck::bytes_of(&record.tracker_from_sensor));
    }
    if has(InputRecord::PEDAL_FRESH) {
        time(pedal_ns, into);
    }
}

/// Appends the ticks of one message to `into`; `None` if the message is malformed.
pub fn unpack(message: &[u8], into: &mut Vec<InputRecord>) -> Option<()> {
    let mut rest = Rest(message);
    let count = u16::from_le_bytes(rest.take()?);
    let first = u64::from_le_bytes(rest.take()?);
    let mut before = before_first(u64::from_le_bytes(rest.take()?));
    for i in 0..u64::from(count) {
        let record = unpack_one(first.wrapping_add(i), &before, &mut rest)?;
        before = record;
        into.push(record);
    }
    rest.0.is_empty().then_some(())
}

fn unpack_one(tick: u64, before: &InputRecord, rest: &mut Rest<'_>) -> Option<InputRecord> {
    let bits = u32::from_le_bytes(rest.take()?);
    let is_long = bits & LONG != 0;
    let mut record = InputRecord {
        tick,
        now_ns: before.now_ns.wrapping_add(rest.time(is_long)?),
        bits: bits & KEPT,
        tools_hash: u32::from_le_bytes(rest.take()?),
        spheres_hash: u32::from_le_bytes(rest.take()?),
        organ_hashes: before.organ_hashes,
        ..InputRecord::zeroed()
    };
    if bits & ORGANS != 0 {
        record.organ_hashes = rest.take()?;
    }
    let has = |bit: u32| bits & bit != 0;
    if bits & COMMAND != 0 {
        [record.command] = rest.take()?;
    }
    if has(InputRecord::DEVICE_FRESH) {
        record.device_at_ns = record.now_ns.wrapping_sub(rest.time(is_long)?);
        record.device_from_handle = rest.pose()?;
        if has(InputRecord::HAS_VELOCITY) {
            record.velocity_m_s = bytemuck::cast(rest.take::<12>()?);
        }
        record.sequence = u16::from_le_bytes(rest.take()?);
        [record.buttons] = rest.take()?;
        if has(InputRecord::HAS_OPENING) {
            record.opening = f32::from_le_bytes(rest.take()?);
        }
    }
    if has(InputRecord::TRACKER_FRESH) {
        record.tracker_at_ns = record.now_ns.wrapping_sub(rest.time(is_long)?);
        record.tracker_from_sensor = rest.pose()?;
    }
    if has(InputRecord::PEDAL_FRESH) {
        record.pedal_at_ns = record.now_ns.wrapping_sub(rest.time(is_long)?);
    }
    Some(record)
}

/// Bytes still to be read.
pub(crate) struct Rest<'a>(pub(crate) &'a [u8]);

impl Rest<'_> {
    pub(crate) fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn time(&mut self, is_long: bool) -> Option<u64> {
        Some(match is_long {
            true => u64::from_le_bytes(self.take()?),
            false => u32::from_le_bytes(self.take()?).into(),
        })
    }

    pub(crate) fn pose(&mut self) -> Option<PoseMsg> {
        Some(bytemuck::cast(self.take::<28>()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A record as the controller makes it: absent fields are zero.
    fn records() -> impl Strategy<Value = InputRecord> {
        let bytes = prop::collection::vec(any::<u8>(), size_of::<InputRecord>());
        (bytes, 0u8..4, any::<bool>()).prop_map(|(bytes, times, at_rest)| {
            let mut record: InputRecord = bytemuck::pod_read_unaligned(&bytes);
            if at_rest {
                record.organ_hashes = [7; 16];
            }
            let has = |bits: u32, bit: u32| bits & bit != 0;
            record.bits &= KEPT;
            if times > 0 {
                // Usual times: shortly before the tick.
                record.now_ns >>= 20;
                let before = |age: u64| record.now_ns.wrapping_sub(age % 1_000_000);
                record.device_at_ns = before(record.device_at_ns);
                record.tracker_at_ns = before(record.tracker_at_ns);
                record.pedal_at_ns = before(record.pedal_at_ns);
            }
            if !has(record.bits, InputRecord::DEVICE_FRESH) {
                record.bits &= !(InputRecord::HAS_VELOCITY | InputRecord::HAS_OPENING);
                record.device_at_ns = 0;
                record.device_from_handle = PoseMsg::zeroed();
                (record.sequence, record.buttons) = (0, 0);
            }
            if !has(record.bits, InputRecord::HAS_VELOCITY) {
                record.velocity_m_s = [0.0; 3];
            }
            if !has(record.bits, InputRecord::HAS_OPENING) {
                record.opening = 0.0;
            }
            if !has(record.bits, InputRecord::TRACKER_FRESH) {
                record.tracker_at_ns = 0;
                record.tracker_from_sensor = PoseMsg::zeroed();
            }
            if !has(record.bits, InputRecord::PEDAL_FRESH) {
                record.pedal_at_ns = 0;
            }
            record
        })
    }

    fn bytes(records: &[InputRecord]) -> &[u8] {
        bytemuck::cast_slice(records)
    }

    proptest! {
        #[test]
        fn packed_record_comes_back_bit_by_bit(
            mut given in prop::collection::vec(records(), 0..20),
            first in any::<u64>(),
            gap in 0usize..30,
        ) {
            for (i, record) in given.iter_mut().enumerate() {
                record.tick = first.wrapping_add(i as u64 + u64::from(i >= gap));
            }
            let (mut rest, mut back) = (&given[..], Vec::new());
            while !rest.is_empty() {
                let mut message = Vec::new();
                let taken = pack(rest, &mut message);
                prop_assert!(taken > 0);
                prop_assert!(unpack(&message, &mut back).is_some());
                rest = &rest[taken..];
            }
            prop_assert_eq!(bytes(&given), bytes(&back));
        }

        #[test]
        fn any_bytes_are_read_or_refused(message in prop::collection::vec(any::<u8>(), 0..400)) {
            let mut back = Vec::new();
            let _ = unpack(&message, &mut back);
            prop_assert!(back.len() <= message.len());
        }
    }

    fn size(record: &InputRecord) -> usize {
        let mut message = Vec::new();
        pack(&[*record], &mut message);
        message.len() - 18
    }

    #[test]
    fn a_tick_takes_the_bytes_that_the_documents_name() {
        let least = InputRecord {
            bits: InputRecord::DEVICE_FRESH,
            ..InputRecord::zeroed()
        };
        let most = InputRecord {
            bits: InputRecord::DEVICE_FRESH | InputRecord::HAS_VELOCITY | InputRecord::HAS_OPENING,
            organ_hashes: [1; 16],
            ..InputRecord::zeroed()
        };
        let said = format!("{} to {} bytes", size(&least), size(&most));
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        for file in ["src/pack.rs", "src/lib.rs", "../../ARCHITECTURE.md"] {
            let text = std::fs::read_to_string(root.join(file)).unwrap();
            assert!(text.contains(&said), "{file} does not say {said}");
        }
    }

    #[test]
    fn an_hour_of_a_1_khz_device_is_far_below_500_mb() {
        let record = InputRecord {
            bits: InputRecord::DEVICE_FRESH | InputRecord::HAS_VELOCITY,
            organ_hashes: [1; 16],
            ..InputRecord::zeroed()
        };
        let tracked = InputRecord {
            bits: record.bits | InputRecord::TRACKER_FRESH | InputRecord::PEDAL_FRESH,
            ..record
        };
        // A tracker at 140 Hz, a pedal at 50 Hz.
        let second = 1000 * size(&record) + 140 * (size(&tracked) - size(&record));
        assert!(second * 3600 < 330_000_000, "{second} bytes a second");
    }
}
