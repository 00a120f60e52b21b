//! Reasons for which an experiment ends early, each with its remedy. Whatever the reason, the
//! device is left without force.

/// Reasons for which a characterisation was stopped. The force is zero already.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Halt {
    /// A person asked for the end.
    #[error("stopped by a person. The force is zero; start again when you like")]
    Asked,
    /// The line is gone.
    #[error("the device is lost in the middle of an experiment. Plug it in and start again")]
    Lost,
    /// No samples come.
    #[error(
        "no sample for {waited_ms:.0} ms, allowed are {allowed_ms:.0} ms. Test the device with \
         `calot devices conformance PATH`"
    )]
    Silent {
        /// Time without a sample, ms.
        waited_ms: f64,
        /// Longest time allowed, ms.
        allowed_ms: f64,
    },
    /// The driver found a fault.
    #[error(
        "the driver found a fault ({names}), allowed is none. Test the device with `calot devices \
         conformance PATH`, on an idle computer"
    )]
    Fault {
        /// Names of the faults.
        names: String,
    },
    /// The handle left the part of the workspace in which experiments are made.
    #[error(
        "the handle is {at_mm:.0} mm from the middle of the workspace, allowed are {allowed_mm:.0} mm. \
         Put it in the middle and start again"
    )]
    Outside {
        /// Distance of the handle from the middle, mm.
        at_mm: f64,
        /// Largest distance allowed, mm.
        allowed_mm: f64,
    },
    /// The handle is too fast.
    #[error(
        "the handle moves at {speed_m_s:.2} m/s, allowed are {allowed_m_s} m/s. Start again with \
         a smaller --force"
    )]
    Fast {
        /// Speed of the handle, m/s.
        speed_m_s: f64,
        /// Largest speed allowed, m/s.
        allowed_m_s: f64,
    },
    /// The handle went away from the place of an experiment.
    #[error(
        "the handle went {moved_mm:.0} mm away, allowed are {allowed_mm:.0} mm, while a force held \
         it. Run `calot devices feel` first: the force may have the wrong direction"
    )]
    Away {
        /// Distance from the place, mm.
        moved_mm: f64,
        /// Largest distance allowed, mm.
        allowed_mm: f64,
    },
    /// The handle moves against the force, or across it.
    #[error(
        "a force of {force_n:.2} N to {axis} moved the handle by {moved}, allowed is \
         along the force. Run `calot devices feel` first: direction or axis of the force is wrong"
    )]
    Backwards {
        /// Change of the force, N.
        force_n: f64,
        /// Direction of the force.
        axis: &'static str,
        /// Movement, with its unit.
        moved: String,
    },
    /// The permitted force does not hold the handle.
    #[error(
        "{force_n:.2} N do not hold the handle within {allowed_mm:.0} mm of its place. Balance its \
         weight, or allow more with --force"
    )]
    Unheld {
        /// Largest force permitted, N.
        force_n: f64,
        /// Largest distance allowed, mm.
        allowed_mm: f64,
    },
    /// The permitted force makes no sense for this device.
    #[error(
        "the force of the experiments is {force_n} N, allowed is 0.05 to {allowed_n:.2} N: half of the \
         declared peak, and no more than the continuous force. Correct --force or the device"
    )]
    Force {
        /// Force asked for, N.
        force_n: f64,
        /// Largest force allowed, N.
        allowed_n: f64,
    },
}
