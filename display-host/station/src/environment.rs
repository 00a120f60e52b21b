//! Environment variables that we set for libraries.
#![allow(unsafe_code)] // `std::env::set_var`

/// Name of the variable that disables Mesa's device-selection layer of Vulkan. The layer asks the
/// Wayland compositor for its graphics card. Without `XDG_RUNTIME_DIR` there is no compositor, and
/// libwayland would complain on standard error.
const NO_SELECTION: &str = "NODEVICE_SELECT";

/// If any of these variables is set, the layer stays: there may be a screen, or the user chooses a
/// card.
const KEEPS_SELECTION: [&str; 8] = [
    "XDG_RUNTIME_DIR",
    "DISPLAY",
    "WAYLAND_DISPLAY",
    "WAYLAND_SOCKET",
    "DRI_PRIME",
    "MESA_VK_DEVICE_SELECT",
    "MESA_VK_DEVICE_SELECT_FORCE_DEFAULT_DEVICE",
    NO_SELECTION,
];

/// Disables Mesa's layer if none of [`KEEPS_SELECTION`] is set: there can then be no compositor,
/// and the user does not choose a card. Call this before the first thread starts.
pub(crate) fn prepare() {
    let is_set = |name| std::env::var_os(name).is_some();
    if KEEPS_SELECTION.into_iter().any(is_set) {
        return;
    }
    // SAFETY: `main` calls this first, so no other thread reads the environment.
    unsafe { std::env::set_var(NO_SELECTION, "1") };
}
