//! Identifies this program.

/// Version, commit and compiler options: everything that could affect the computed bits.
pub(crate) fn build() -> String {
    let profile = match cfg!(debug_assertions) {
        true => "debug",
        false => "release",
    };
    let fma = match cfg!(target_feature = "fma") {
        true => " with fused multiply-add",
        false => "",
    };
    format!(
        "calot {}, commit {}, {profile}, {}{fma}",
        env!("CARGO_PKG_VERSION"),
        env!("CALOT_COMMIT"),
        std::env::consts::ARCH,
    )
}
