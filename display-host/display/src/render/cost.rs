//! Cost of drawing the same frame again and again.

use std::time::Instant;

use shared_mem::message::{SphereState, ToolFrame};

use super::gpu::Gpu;
use super::timing::PASSES;
use super::{Quality, Renderer};
use crate::DisplayError;

/// Frames before the measured ones. They compile shaders.
const WARM_UP: usize = 4;
/// Time between two drawn frames, s. The texture of smoke drifts by it.
const FRAME_S: f32 = 1.0 / 60.0;

/// Cost of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameCost {
    /// Measured frames.
    pub frames: usize,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// Median time that this program takes to move the skin and to write the commands, ms.
    pub submitted_ms: f32,
    /// Median time from the start of a frame until the graphics device is idle, ms.
    pub drawn_ms: f32,
    /// 99th percentile of the time until the graphics device is idle, ms.
    pub drawn_p99_ms: f32,
    /// Time that all threads of this process compute for a frame, ms. A software driver draws in
    /// such threads, so one core shows at most 1000 divided by this frames a second.
    pub computed_ms: f32,
    /// Frames a second if each is started before the previous one is drawn.
    pub per_second: f32,
    /// Name of each pass and its median time on the graphics device's clock, ms. Empty if the
    /// device has no clock.
    pub passes_ms: Vec<(&'static str, f32)>,
}

/// Draws one frame `frames` times and waits for each. Then draws it as often without waiting.
///
/// # Errors
/// [`DisplayError::Device`].
pub fn measure(
    gpu: &Gpu,
    renderer: &mut Renderer,
    spheres: &[SphereState],
    tools: &ToolFrame,
    frames: usize,
) -> Result<FrameCost, DisplayError> {
    let frames = frames.max(1);
    let (mut submitted, mut drawn) = (Vec::new(), Vec::new());
    let mut passes = [const { Vec::new() }; PASSES.len()];
    for frame in 0..frames + WARM_UP {
        let start = Instant::now();
        renderer.render(gpu, spheres, tools, frame as f32 * FRAME_S);
        let submitted_ms = ms_since(start);
        gpu.wait("drawing")?;
        let drawn_ms = ms_since(start);
        let times = renderer.take_pass_times();
        if frame < WARM_UP {
            continue;
        }
        submitted.push(submitted_ms);
        drawn.push(drawn_ms);
        for (all, ms) in passes.iter_mut().zip(times.into_iter().flatten()) {
            all.push(ms);
        }
    }
    let (start, computed) = (Instant::now(), computed_ms());
    for frame in 0..frames {
        renderer.render(gpu, spheres, tools, frame as f32 * FRAME_S);
        // The poll frees the resources of finished frames. A window polls in each frame, too.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
    }
    gpu.wait("drawing")?;
    let per_second = frames as f32 / start.elapsed().as_secs_f32();
    let computed_ms = (computed_ms() - computed) as f32 / frames as f32;
    let passes_ms = PASSES.into_iter().zip(&mut passes);
    Ok(FrameCost {
        frames,
        size: renderer.quality().size,
        submitted_ms: quantile(&mut submitted, 50),
        drawn_ms: quantile(&mut drawn, 50),
        drawn_p99_ms: quantile(&mut drawn, 99),
        computed_ms,
        per_second,
        passes_ms: passes_ms
            .filter(|(_, all)| !all.is_empty())
            .map(|(name, all)| (name, quantile(all, 50)))
            .collect(),
    })
}

/// Time to read the last picture back into memory, median of `times`, ms.
///
/// # Errors
/// [`DisplayError::Device`].
pub fn read_back_ms(gpu: &Gpu, renderer: &Renderer, times: usize) -> Result<f32, DisplayError> {
    let mut all = Vec::new();
    for _ in 0..times.max(1) {
        let start = Instant::now();
        renderer.read(gpu)?;
        all.push(ms_since(start));
    }
    Ok(quantile(&mut all, 50))
}

/// Quality tiers that a window on this device chooses from, best first, at this size.
#[must_use]
pub fn tiers(gpu: &Gpu, size: [u32; 2]) -> Vec<Quality> {
    let tiers = Quality::tiers(gpu).into_iter();
    tiers.map(|tier| Quality { size, ..tier }).collect()
}

/// Time that all threads of this process have computed, ms.
fn computed_ms() -> f64 {
    let used = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    used.tv_sec as f64 * 1e3 + used.tv_nsec as f64 * 1e-6
}

fn ms_since(start: Instant) -> f32 {
    start.elapsed().as_secs_f32() * 1e3
}

fn quantile(all: &mut [f32], percent: usize) -> f32 {
    all.sort_by(f32::total_cmp);
    all.get(all.len() * percent / 100).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_tail_are_found_in_any_order() {
        let mut all: Vec<f32> = (0..100).rev().map(|it| it as f32).collect();
        let found = [50, 99].map(|it| quantile(&mut all, it).to_bits());
        assert_eq!(found, [50.0, 99.0].map(f32::to_bits));
        assert_eq!(quantile(&mut [], 50).to_bits(), 0.0f32.to_bits());
    }
}
