//! Quality tiers, by cost of a frame.

use super::gpu::Gpu;

/// A quality tier. All tiers show the same scene and differ in detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quality {
    /// True to move the skin on the CPU, which is faster with a software driver.
    pub skin_on_cpu: bool,
    /// Level of tissue detail: 1 draws two octaves of noise, 2 draws four.
    pub detail: u32,
    /// Side of the shadow map, pixels. `None`: no shadows.
    pub shadow_side: Option<u32>,
    /// Glare around highlights.
    pub bloom: bool,
    /// Samples a pixel: 1 or 4.
    pub samples: u32,
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
        size: [1280, 720],
    };
    /// Quality for a software driver.
    pub const SOFTWARE: Self = Self {
        skin_on_cpu: true,
        detail: 2,
        shadow_side: Some(768),
        bloom: true,
        samples: 4,
        size: [640, 480],
    };

    /// Quality for a window on a software driver. A frame takes a seventh of `SOFTWARE`'s time.
    pub const SOFTWARE_LIVE: Self = Self {
        detail: 1,
        shadow_side: Some(384),
        bloom: false,
        samples: 1,
        size: [480, 360],
        ..Self::SOFTWARE
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
    /// Tiers for a window on a software driver, best first; the last has no shadows.
    pub const SOFTWARE_TIERS: [Self; 2] = [
        Self::SOFTWARE_LIVE,
        Self {
            shadow_side: None,
            ..Self::SOFTWARE_LIVE
        },
    ];

    /// Tiers of an adapter for a window, best first, and the allowed cost of a frame, ms. The cost
    /// allows 60 frames a second and leaves time for the window itself. On a software driver it
    /// allows 15 frames a second.
    #[must_use]
    pub fn tiers(gpu: &Gpu) -> (Vec<Self>, f32) {
        if gpu.is_software() {
            (Self::SOFTWARE_TIERS.to_vec(), 66.0)
        } else {
            (Self::GPU_TIERS.to_vec(), 13.0)
        }
    }

    /// Desired interval between the frames of a window, ms.
    #[must_use]
    pub fn period_ms(gpu: &Gpu) -> f32 {
        if gpu.is_software() {
            66.0
        } else {
            1000.0 / 60.0
        }
    }

    /// Quality of an adapter for a window, which shows frame after frame.
    #[must_use]
    pub fn live(gpu: &Gpu) -> Self {
        if gpu.is_software() {
            Self::SOFTWARE_LIVE
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
