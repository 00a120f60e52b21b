//! Identity of this program, for reports and recordings.

/// Version, commit, profile, processor family and fused multiply-add of this program. Each of them
/// may change the computed bits, or the time of the computation.
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
