//! Errors of a display.

use std::path::PathBuf;

/// An error, its place, and the next step for the user.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// The compiled scene is invalid.
    #[error(transparent)]
    Scene(#[from] shared_mem::scene::SceneError),
    /// The services in shared memory cannot be opened.
    #[error(transparent)]
    Service(#[from] shared_mem::service::ServiceError),
    /// No controller published a state on this station, the name that controller and display share.
    #[error(
        "station '{station}': no controller published a state within {waited_s:.1} s; start one \
         with `calot rt`, or use `calot run`, which starts everything"
    )]
    NoController {
        /// The station's name.
        station: String,
        /// Time waited, s.
        waited_s: f64,
    },
    /// Controller and display have loaded different scenes.
    #[error(
        "controller runs scene {running}, display has {ours} ('{name}'); start both with the same \
         compiled scene"
    )]
    OtherScene {
        /// Identity of the controller's scene (hexadecimal, first half).
        running: String,
        /// Identity of the display's scene.
        ours: String,
        /// Name of the display's scene.
        name: String,
    },
    /// There is no graphics driver.
    #[error(
        "no Vulkan or OpenGL adapter ({detail}); install a driver: `sudo apt-get install \
         mesa-vulkan-drivers libegl1 libgl1-mesa-dri` (it draws on the CPU if there is no GPU)"
    )]
    NoAdapter {
        /// Message of the graphics library.
        detail: String,
    },
    /// The graphics device, or a step beside it, failed during operation.
    #[error("the display failed while {doing}: {detail}; start the display again")]
    Device {
        /// The operation that failed, e.g. "drawing a frame".
        doing: &'static str,
        /// Message of the driver.
        detail: String,
    },
    /// The scene exceeds a limit of the graphics device.
    #[error(
        "scene has {found} {what}, this graphics device allows {max}; reduce the triangles of the \
         scene's meshes, for instance in Blender, and prepare the scene again (`calot prepare`)"
    )]
    TooLarge {
        /// The limited quantity.
        what: &'static str,
        /// Amount required.
        found: u64,
        /// Largest amount allowed.
        max: u64,
    },
    /// The picture size is out of range.
    #[error("picture of {width}×{height} pixels: each side must be 64 to 8192 (--size)")]
    Size {
        /// Width, pixels.
        width: u32,
        /// Height, pixels.
        height: u32,
    },
    /// The duration of the run is out of range.
    #[error("cannot run for {0} s; allowed are more than 0 and at most 86400 s (--seconds)")]
    Seconds(f64),
    /// A file cannot be written.
    #[error("{path}: {detail}; choose another folder with --out")]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// Message of the operating system.
        detail: String,
    },
    /// The pictures cannot be made into an animation.
    #[error("{path}: cannot write the animation: {detail}")]
    Animation {
        /// Path of the animation.
        path: PathBuf,
        /// The reason.
        detail: String,
    },
    /// There is no window system.
    #[error("cannot open a window: {detail}. Without a screen use `calot run --headless`")]
    NoWindow {
        /// Message of the window system.
        detail: String,
    },
    /// The window, or the connection to its screen, was lost.
    #[error("the window was lost before the end ({detail}); everything up to there is kept")]
    WindowLost {
        /// The reason.
        detail: String,
    },
}
