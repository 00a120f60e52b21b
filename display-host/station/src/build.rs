//! Identifies this program.

/// Version, commit, profile, processor family and fused multiply-add of this program. They could
/// affect the computed bits or their time.
pub(crate) fn build() -> String {
    let fma = match cfg!(target_feature = "fma") {
        true => " with fused multiply-add",
        false => "",
    };
    format!(
        "calot {}, commit {}, {}, {}{fma}",
        env!("CARGO_PKG_VERSION"),
        env!("CALOT_COMMIT"),
        env!("CALOT_PROFILE"),
        std::env::consts::ARCH,
    )
}
