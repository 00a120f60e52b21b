//! What libraries read from the environment and we decide for them.
#![allow(unsafe_code)] // `std::env::set_var`

/// Vulkan's device-selection layer of Mesa asks the Wayland compositor for its graphics card.
/// Without `XDG_RUNTIME_DIR` there is no compositor to ask, and libwayland would complain on
/// standard error.
const NO_SELECTION: &str = "NODEVICE_SELECT";

/// Leaves that layer out where no compositor can be and the user does not use it to choose a card.
/// To be called before the first thread starts.
pub(crate) fn prepare() {
    let is_set = |name| std::env::var_os(name).is_some();
    if ["XDG_RUNTIME_DIR", "MESA_VK_DEVICE_SELECT", NO_SELECTION]
        .into_iter()
        .any(is_set)
    {
        return;
    }
    // SAFETY: `main` calls this first, so no other thread reads the environment.
    unsafe { std::env::set_var(NO_SELECTION, "1") };
}
