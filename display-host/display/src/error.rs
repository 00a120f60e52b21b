//! Why a display cannot go on.

use std::path::PathBuf;

/// What went wrong, where, and what to do next.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// The compiled scene is refused.
    #[error(transparent)]
    Scene(#[from] shared_mem::scene::SceneError),
    /// The services do not open.
    #[error(transparent)]
    Service(#[from] shared_mem::service::ServiceError),
    /// Nobody published on this station.
    #[error(
        "station '{station}': no controller published a state within {waited_s:.1} s; start one \
         with `calot rt`, or use `calot run`, which starts everything"
    )]
    NoController {
        /// Station.
        station: String,
        /// How long was waited, s.
        waited_s: f64,
    },
    /// Controller and display loaded different scenes.
    #[error(
        "controller runs scene {running}, display has {ours} ('{name}'); start both with the same \
         compiled scene"
    )]
    OtherScene {
        /// Identity that the controller publishes (hexadecimal, first half).
        running: String,
        /// Identity of the display's scene.
        ours: String,
        /// Name of the display's scene.
        name: String,
    },
    /// No driver that can draw.
    #[error(
        "no Vulkan or OpenGL adapter ({detail}); install a driver: `sudo apt-get install \
         mesa-vulkan-drivers libegl1 libgl1-mesa-dri` (draws on the CPU if there is no GPU)"
    )]
    NoAdapter {
        /// What the graphics library said.
        detail: String,
    },
    /// The driver failed in mid-air.
    #[error("graphics device, {doing}: {detail}; start the display again")]
    Device {
        /// What was being done.
        doing: &'static str,
        /// What the driver said.
        detail: String,
    },
    /// The scene needs more than the graphics device has.
    #[error("scene has {found} {what}, this graphics device takes {max}; prepare a coarser skin")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How many.
        found: u64,
        /// How many fit.
        max: u64,
    },
    /// Picture size that cannot be drawn.
    #[error("picture of {width}×{height} pixels: each side must be 64 to 8192")]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// Not a duration to run for.
    #[error("cannot run for {0} s: more than 0 and at most 86400 are possible")]
    Seconds(f64),
    /// A file cannot be written.
    #[error("{path}: {detail}; choose another folder with --out")]
    Write {
        /// Which.
        path: PathBuf,
        /// What the system said.
        detail: String,
    },
    /// Pictures that do not become an animation.
    #[error("{path}: no animation: {detail}")]
    Animation {
        /// The animation.
        path: PathBuf,
        /// Why not.
        detail: String,
    },
    /// No window system.
    #[error(
        "cannot open a window ({detail}); is DISPLAY or WAYLAND_DISPLAY set? Without a screen use \
         `calot run --headless`"
    )]
    NoWindow {
        /// What the window system said.
        detail: String,
    },
}
