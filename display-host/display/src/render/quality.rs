//! Quality tiers, by cost of a frame.

use super::gpu::Gpu;

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
    /// Side of a pixel of light, in pixels of the picture: 1 or 2.
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
    /// Tiers for a window on a software driver, best first. The last ones are for computers with
    /// two cores, one of which runs the tick.
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

    /// Quality with which a window starts.
    #[must_use]
    pub fn live(gpu: &Gpu) -> Self {
        if gpu.is_software() {
            Self::SOFTWARE_TIERS[Self::SOFTWARE_TIERS.len() - 1]
        } else {
            Self::GPU
        }
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
