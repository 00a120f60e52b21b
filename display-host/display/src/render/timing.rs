//! Cost of each pass of a frame, by the graphics device's own clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use super::gpu::Gpu;

/// The measured passes, in order.
pub const PASSES: [&str; 6] = ["skinning", "shadow", "scene", "exposure", "glare", "lens"];
/// Alignment of resolved timestamps, bytes.
const STRIDE_BYTES: u64 = wgpu::QUERY_RESOLVE_BUFFER_ALIGNMENT;
/// Number of frames whose timestamps may be on their way from the device at one time.
const STAGINGS: usize = 3;
/// Size of two timestamps, bytes.
const PAIR_BYTES: u64 = 16;

/// Time of each pass of a frame, ms. It is 0 for a pass that the frame lacked.
pub type PassTimes = [f32; PASSES.len()];

const FREE: u8 = 0;
const IN_FLIGHT: u8 = 1;
const ARRIVED: u8 = 2;
const FAILED: u8 = 3;

/// Timestamps of one frame on their way from the device.
struct Staging {
    buffer: wgpu::Buffer,
    /// One bit for each pass that the frame had.
    used: u32,
    /// State of the mapping: `FREE`, `IN_FLIGHT`, `ARRIVED` or `FAILED`.
    state: Arc<AtomicU8>,
}

/// Measures passes. Does nothing if the device has no clock.
pub(super) struct Timing {
    clock: Option<Clock>,
    /// Times that have arrived and were not taken yet.
    newest: Option<PassTimes>,
    /// One bit for each pass of the present frame.
    used: u32,
}

struct Clock {
    stamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    ring: [Staging; STAGINGS],
    ms_per_tick: f32,
}

impl Timing {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let size = STRIDE_BYTES * PASSES.len() as u64;
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stamps"),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let clock = gpu.has_clock().then(|| Clock {
            stamps: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("passes"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * PASSES.len() as u32,
            }),
            resolved: buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC),
            ring: core::array::from_fn(|_| Staging {
                buffer: buffer(Usage::COPY_DST | Usage::MAP_READ),
                used: 0,
                state: Arc::new(AtomicU8::new(FREE)),
            }),
            ms_per_tick: gpu.queue.get_timestamp_period() * 1e-6,
        });
        Self {
            clock,
            newest: None,
            used: 0,
        }
    }

    /// Timestamp writes of a render pass. Several render passes may count as one measured pass;
    /// `first` and `last` are true for the first and the last of them.
    pub(super) fn render(
        &mut self,
        pass: usize,
        first: bool,
        last: bool,
    ) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let clock = self.clock.as_ref()?;
        self.used |= u32::from(last) << pass;
        (first || last).then(|| wgpu::RenderPassTimestampWrites {
            query_set: &clock.stamps,
            beginning_of_pass_write_index: first.then_some(2 * pass as u32),
            end_of_pass_write_index: last.then_some(2 * pass as u32 + 1),
        })
    }

    /// Timestamp writes of a compute pass.
    pub(super) fn compute(&mut self, pass: usize) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let clock = self.clock.as_ref()?;
        self.used |= 1 << pass;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &clock.stamps,
            beginning_of_pass_write_index: Some(2 * pass as u32),
            end_of_pass_write_index: Some(2 * pass as u32 + 1),
        })
    }

    /// Sends the frame's timestamps if a buffer is free; call it after all passes.
    pub(super) fn finish(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let used = core::mem::take(&mut self.used);
        let Some(clock) = &mut self.clock else { return };
        let Some(staging) = clock
            .ring
            .iter_mut()
            .find(|s| s.state.load(Ordering::Acquire) == FREE && s.used == 0)
        else {
            return;
        };
        for pass in (0..PASSES.len() as u32).filter(|pass| used >> pass & 1 == 1) {
            let at = u64::from(pass) * STRIDE_BYTES;
            encoder.resolve_query_set(&clock.stamps, 2 * pass..2 * pass + 2, &clock.resolved, at);
            encoder.copy_buffer_to_buffer(&clock.resolved, at, &staging.buffer, at, PAIR_BYTES);
        }
        staging.used = used;
    }

    /// Maps the sent timestamps and takes those that have arrived; call it after submitting the
    /// frame.
    pub(super) fn collect(&mut self) {
        let Some(clock) = &mut self.clock else { return };
        for staging in &mut clock.ring {
            match staging.state.load(Ordering::Acquire) {
                FREE if staging.used != 0 => {
                    let state = staging.state.clone();
                    state.store(IN_FLIGHT, Ordering::Release);
                    staging
                        .buffer
                        .slice(..)
                        .map_async(wgpu::MapMode::Read, move |result| {
                            let now = if result.is_ok() { ARRIVED } else { FAILED };
                            state.store(now, Ordering::Release);
                        });
                }
                ARRIVED => {
                    if let Ok(bytes) = staging.buffer.slice(..).get_mapped_range() {
                        self.newest = Some(times(&bytes, staging.used, clock.ms_per_tick));
                    }
                    staging.buffer.unmap();
                    staging.used = 0;
                    staging.state.store(FREE, Ordering::Release);
                }
                FAILED => {
                    staging.used = 0;
                    staging.state.store(FREE, Ordering::Release);
                }
                _ => {}
            }
        }
    }

    /// Times of the latest frame whose timestamps have arrived since the last call.
    pub(super) fn take(&mut self) -> Option<PassTimes> {
        self.newest.take()
    }
}

fn times(bytes: &[u8], used: u32, ms_per_tick: f32) -> PassTimes {
    core::array::from_fn(|pass| {
        let at = pass * STRIDE_BYTES as usize;
        let stamp = |k: usize| {
            let raw = bytes.get(at + 8 * k..at + 8 * k + 8)?;
            raw.try_into().ok().map(u64::from_le_bytes)
        };
        match (used >> pass & 1, stamp(0), stamp(1)) {
            // A driver may give 0, or timestamps in the wrong order.
            (1, Some(from), Some(to)) if from > 0 => to.saturating_sub(from) as f32 * ms_per_tick,
            _ => 0.0,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_become_times_and_nonsense_becomes_nothing() {
        let mut bytes = vec![0u8; STRIDE_BYTES as usize * PASSES.len()];
        let mut put = |pass: usize, from: u64, to: u64| {
            let at = pass * STRIDE_BYTES as usize;
            bytes[at..at + 8].copy_from_slice(&from.to_le_bytes());
            bytes[at + 8..at + 16].copy_from_slice(&to.to_le_bytes());
        };
        put(1, 1_000_000, 3_500_000);
        put(2, 9, 3);
        put(3, 0, 7);
        put(4, 5, 1_000_005);
        let found = times(&bytes, 0b01_1110, 1e-6);
        for (found, wanted) in found.into_iter().zip([0.0, 2.5, 0.0, 0.0, 1.0, 0.0]) {
            assert!((found - wanted).abs() < 1e-6, "{found} instead of {wanted}");
        }
        // A pass that the frame lacked counts 0, whatever the buffer holds.
        assert!(times(&bytes, 0, 1e-6).iter().all(|t| *t <= 0.0));
        assert!(times(&[], u32::MAX, 1.0).iter().all(|t| *t <= 0.0));
    }
}
