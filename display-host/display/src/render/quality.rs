//! Quality tiers, by cost of a frame.

use super::governor::Governor;
use super::gpu::Gpu;

/// Allowed cost of a picture on a graphics device, ms.
const MAY_COST_MS: f32 = 13.0;
/// Desired interval between pictures, ms.
const PERIOD_MS: f32 = 1000.0 / 60.0;
/// Desired interval between pictures on a software driver, ms: 12 a second. The governor lowers the
/// quality below 10.
const SOFTWARE_PERIOD_MS: f32 = 1000.0 / 12.0;

/// A quality tier. All tiers show the same scene and differ in detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quality {
    /// True to move the skin on the CPU, which is faster with a software driver.
    pub skin_on_cpu: bool,
    /// Level of detail of tissue, light and lens. 0: one octave of noise, one reflection, no blur
    /// and no colour fringes; 1: two octaves; 2: four octaves.
    pub detail: u32,
    /// Side of the shadow map, pixels. `None`: no shadows.
    pub shadow_side: Option<u32>,
    /// Glare around highlights.
    pub bloom: bool,
    /// Samples a pixel: 1 or 4. With 1 the lens smooths the edges that it finds in the light.
    pub samples: u32,
    /// Number of the picture's pixels along the side of a pixel of light: 1 or 2.
    pub part: u32,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
}

impl Quality {
    /// Quality for a graphics device.
    pub const GPU: Self = Self {
        skin_on_cpu: false,
        detail: 2,
        shadow_side: Some(2048),
        bloom: true,
        samples: 4,
        part: 1,
        size: [1280, 720],
    };
    /// Quality for a software driver.
    pub const SOFTWARE: Self = Self {
        skin_on_cpu: true,
        shadow_side: Some(768),
        size: [640, 480],
        ..Self::GPU
    };

    /// Tiers for a graphics device, best first. All keep the picture's size.
    pub const GPU_TIERS: [Self; 4] = [
        Self::GPU,
        Self {
            shadow_side: Some(1024),
            ..Self::GPU
        },
        Self {
            shadow_side: Some(1024),
            samples: 1,
            ..Self::GPU
        },
        Self {
            detail: 1,
            shadow_side: Some(512),
            bloom: false,
            samples: 1,
            ..Self::GPU
        },
    ];
    /// Tiers for a window on a software driver, best first. The last ones are for computers of two
    /// cores, one of which is the tick's.
    pub const SOFTWARE_TIERS: [Self; 4] = [
        Self {
            detail: 1,
            shadow_side: Some(384),
            bloom: false,
            samples: 1,
            ..Self::SOFTWARE
        },
        Self {
            detail: 1,
            shadow_side: None,
            bloom: false,
            samples: 1,
            ..Self::SOFTWARE
        },
        Self {
            detail: 0,
            shadow_side: None,
            bloom: false,
            samples: 1,
            ..Self::SOFTWARE
        },
        Self {
            detail: 0,
            shadow_side: None,
            bloom: false,
            samples: 1,
            part: 2,
            ..Self::SOFTWARE
        },
    ];

    /// Size of the light from which the lens makes the picture, pixels.
    #[must_use]
    pub fn light_size(&self) -> [u32; 2] {
        self.size.map(|side| side.div_ceil(self.part.max(1)))
    }

    /// Tiers of an adapter for a window, best first.
    #[must_use]
    pub fn tiers(gpu: &Gpu) -> Vec<Self> {
        if gpu.is_software() {
            Self::SOFTWARE_TIERS.to_vec()
        } else {
            Self::GPU_TIERS.to_vec()
        }
    }

    /// Chooses the tiers of a window. A graphics device with a clock may take 13 ms for a picture,
    /// which leaves time for the window at 60 a second. A software driver begins with the cheapest
    /// tier. Everything that the processor does for a picture counts, so the time from picture to
    /// picture is judged: it keeps the quality if there are 10 a second. `screen_ms` is the
    /// screen's interval, or 0 if it is unknown.
    #[must_use]
    pub fn governor(gpu: &Gpu, screen_ms: f32) -> Governor {
        let tiers = Self::tiers(gpu);
        if gpu.is_software() {
            Governor::by_period(tiers, SOFTWARE_PERIOD_MS, screen_ms).from_below()
        } else if gpu.has_clock() {
            Governor::new(tiers, MAY_COST_MS)
        } else {
            Governor::by_period(tiers, PERIOD_MS, screen_ms)
        }
    }

    /// Quality with which a window starts.
    #[must_use]
    pub fn live(gpu: &Gpu) -> Self {
        let first = Self::governor(gpu, 0.0).quality();
        first.unwrap_or(Self::GPU)
    }

    /// Quality of an adapter for a single picture, which may take time.
    #[must_use]
    pub fn for_adapter(gpu: &Gpu) -> Self {
        if gpu.is_software() {
            Self::SOFTWARE
        } else {
            Self::GPU
        }
    }
}
