//! Definitions of the metrics: name, unit, definition, source. A changed definition needs a new
//! [`crate::VERSION`], which reports show.

macro_rules! metrics {
    ($($variant:ident $name:literal $unit:literal $definition:literal $source:literal)*) => {
        /// A metric of the assessment.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Metric {
            $(#[doc = $definition] $variant,)*
        }

        impl Metric {
            /// All metrics, in the order of display.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// Name in JSON, CSV and rules; it ends with the unit, if it has one.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Unit of the metric; `1` for a share, `n` for a count.
            #[must_use]
            pub fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit,)* }
            }

            /// Definition of the metric.
            #[must_use]
            pub fn definition(self) -> &'static str {
                match self { $(Self::$variant => $definition,)* }
            }

            /// The publication or product from which the definition comes; `own`: none.
            #[must_use]
            pub fn source(self) -> &'static str {
                match self { $(Self::$variant => $source,)* }
            }
        }
    };
}

metrics! {
    Time "time_s" "s"
        "Time of the task. Pauses, gaps in the recording and times without a device that the trainee needs do not count."
        "LAP Mentor, LapSim: time"
    Gaps "gaps_s" "s"
        "Time in gaps of the recording: more than 0.25 s between two records of the hands. Pauses are not gaps."
        "own"
    Paused "paused_s" "s"
        "Time in pauses; no other metric counts it."
        "own"
    DeviceLost "device_lost_s" "s"
        "Time without a device that the trainee needs: haptic device, tracker or, with the hook in hand, pedal. A device counts once it has been there, a haptic device also if it is silent from the start. No other metric counts this time."
        "own"
    Noise "noise_mm" "mm"
        "Noise of the device: standard deviation per axis of the handle's position from a straight line over 0.25 s, in the calmest tenth of such parts. Smooth deviations such as tremor are left out."
        "own"
    Restarts "restarts" "n"
        "Number of resets and restarts after the hands had moved. All other metrics begin anew with each."
        "own"
    LostEvents "lost_events" "n"
        "Number of events that the recording lacks, from gaps in their numbers. The other metrics cannot count them."
        "own"
    Path "path_m" "m"
        "Path length of the instrument's tip, smoothed at 6 Hz. The counted point follows the tip on a leash of 0.8 mm, so noise and tremor within it do not count."
        "LAP Mentor: path length; Winter 2009: smoothing; play own"
    ScopePath "scope_path_m" "m"
        "Path of the endoscope's lens, smoothed in the same way."
        "LapSim camera navigation: path length; Winter 2009: smoothing; play own"
    Movements "movements" "n"
        "Number of movements of the instrument. Each begins when the mean speed over 0.2 s exceeds 20 mm/s and ends when it falls below 5 mm/s."
        "LAP Mentor, ICSAD: number of movements; limits own"
    ScopeMovements "scope_movements" "n"
        "Movements of the endoscope, counted in the same way."
        "LAP Mentor: number of movements; limits own"
    Economy "economy" "1"
        "Sum of the straight distances from start to end of the instrument's movements, divided by the sum of their paths; 1: all straight. The built-in rules leave it out, because a hasty hand moves straight, too."
        "LapSim: economy of movement"
    Smoothness "smoothness" "1"
        "Spectral arc length of the instrument's speed in each finished movement, mean by duration; a movement over 5 s counts in parts of 5 s. −1.4: one smooth movement; each hesitation makes it less."
        "SPARC: Balasubramanian et al. 2015"
    ScopeSmoothness "scope_smoothness" "1"
        "Smoothness of the endoscope's lens, measured in the same way."
        "SPARC: Balasubramanian et al. 2015"
    BothMoving "both_moving" "1"
        "Share of the time with a movement of instrument or endoscope in which both moved."
        "own; the two hands' coordination"
    Idle "idle_s" "s"
        "Time in which instrument and endoscope were both slower than 5 mm/s for 1 s or longer."
        "LAP Mentor: idle time; limits own"
    ForceMax "force_max_n" "N"
        "Largest force on the hand, in records at 100 Hz."
        "NeuroVR tier 3: force"
    ForceMean "force_mean_n" "N"
        "Mean force on the hand while the instrument touched."
        "NeuroVR tier 2: sum of force, over time"
    Force95 "force_p95_n" "N"
        "Force on the hand that was not exceeded in 95 % of the time in which the instrument touched something, rounded up to a multiple of 0.05 N, but not above the greatest force; 12 N at most."
        "NeuroVR tier 3: force histogram"
    ForceSaturated "force_saturated_s" "s"
        "Time at 97 % or more of the haptic device's greatest force: the tissue may have resisted more than was felt."
        "own"
    CauteryOn "cautery_on_s" "s"
        "Time with current on the hook."
        "LAP Mentor: safe cautery"
    CauteryAir "cautery_air_s" "s"
        "Time with current on the hook in which the instrument touched nothing and nothing had burnt for 0.1 s."
        "LAP Mentor: cautery without contact; own: current across a gap does not count"
    CauteryBlind "cautery_blind_s" "s"
        "Time with current on the hook in which the instrument's tip was outside the endoscope's picture."
        "own"
    CauterySafe "cautery_safe" "1"
        "Share of the time with current on the hook in which the tip was in the endoscope's picture, and touched or burnt something."
        "LAP Mentor: safe cautery; measure own"
    BurnWrong "burn_wrong_j" "J"
        "Energy into structures that the rules protect from burning, and into places of other organs that are burnt deeper than the rules allow. A vessel that an instructor opened may be coagulated."
        "own"
    BurnLiver "burn_liver_j" "J" "Energy into the liver." "own"
    BurnGallbladder "burn_gallbladder_j" "J" "Energy into the gallbladder." "own"
    BurnDuct "burn_duct_j" "J" "Energy into cystic and bile duct." "own"
    BurnVessel "burn_vessel_j" "J" "Energy into arteries." "own"
    BurnTarget "burn_target_j" "J" "Energy into fat and connective tissue." "own"
    Touches "touches" "n"
        "Touches of structures that the rules protect. A light touch is no fault, and costs no points."
        "own"
    TouchesWrong "touches_wrong" "n"
        "Presses on structures that the rules protect, with the force of the rules (`touch_n`) or more, such structures crushed in the jaws, and hard presses on the organs that the rules name in `press_n`."
        "paper, evaluation; force: De et al. 2007"
    PressWrongMax "press_wrong_max_n" "N"
        "Largest force of the instrument on a structure that the rules protect, smoothed over 50 ms, in steps of 0.1 N; 0 without a press."
        "own; force: De et al. 2007"
    BurnsWrong "burns_wrong" "n"
        "Burns of structures that the rules protect, and burns of other organs deeper than the rules allow."
        "paper, evaluation"
    CutsWrong "cuts_wrong" "n"
        "Cuts of anything except cystic duct and artery, fat, connective tissue, gallbladder, liver and sutures. Cuts of one organ that follow each other within the rules' `quiet_s` are one."
        "own"
    ClipsUsed "clips_used" "n" "Clips that closed." "LAP Mentor: clips"
    ClipsLost "clips_lost" "n" "Clips that closed without tissue." "LAP Mentor: lost clips"
    ClipsMisplaced "clips_misplaced" "n"
        "Clips on structures other than cystic duct and artery, and clips on both at once."
        "LAP Mentor: clips"
    ClipsDuct "clips_duct" "n" "Clips that close the cystic duct." "paper, task 2"
    ClipsArtery "clips_artery" "n" "Clips that close the cystic artery." "paper, task 2"
    ClipsEarly "clips_early" "n"
        "Clips on cystic duct and artery before the critical view of safety was achieved, in the whole operation. Clips on a vessel that an instructor opened do not count."
        "critical view of safety (Strasberg)"
    ActsBlind "acts_blind" "n"
        "Clips that closed, and ducts and vessels that scissors divided, while the instrument's tip was outside the endoscope's picture."
        "own"
    ClipSpacing "clip_spacing_mm" "mm"
        "Smallest distance between two closed clips on one vessel."
        "own"
    ClipRoom "clip_room_mm" "mm"
        "Room for the cut: largest distance between neighbouring clips along a vessel at rest; of the two vessels, the smaller."
        "own"
    CutsOneSided "cuts_one_sided" "n"
        "Number of the two vessels, cystic duct and artery, that were divided with clips on them, but with a side left open."
        "paper, task 3: between the clips"
    Unclamped "unclamped" "n"
        "Number of the two vessels, cystic duct and artery, that were divided with too few clips or with a side left open, or that leaked after the division."
        "paper, evaluation"
    Injuries "injuries" "n"
        "Injuries that rule out a pass: structures divided, perforated, torn in part, clipped or burnt beyond the limits of the rules (`injury`)."
        "own"
    Blood "blood_ml" "ml"
        "Blood lost: the flow of all leaks of organs without bile, summed over the counted time."
        "LAP Mentor: blood loss"
    Bile "bile_ml" "ml"
        "Bile lost: the flow of all leaks of bile ducts, cystic duct and gallbladder, summed over the counted time."
        "own"
    StonesSpilled "stones_spilled" "n" "Gallstones that left the gallbladder through a hole." "own"
    StonesRetrieved "stones_retrieved" "n"
        "Spilled gallstones that were taken out of the body, with the grasper or by suction."
        "own"
    StonesLeft "stones_left" "n"
        "Spilled gallstones that were left behind: spilled and not taken out. A stone between the jaws is still in the body."
        "Woodfield et al. 2004 (10.1007/s00464-003-8260-4)"
    Perforations "perforations" "n" "Walls burnt through, and ducts and vessels torn, cut or burnt half through." "LAP Mentor: perforations"
    Crushes "crushes" "n" "Times that the jaws crushed tissue in their grip." "GOALS: tissue handling"
    Tears "tears" "n"
        "Ducts, vessels and other organs torn; fat and connective tissue do not count. Tears of one organ that follow each other within the rules' `quiet_s` are one."
        "GOALS: tissue handling"
    Slips "slips" "n" "Times that tissue slipped from the jaws." "GOALS: tissue handling"
    OutOfView "out_of_view_s" "s"
        "Time in which the instrument's tip was more than 35° off the endoscope's line of sight, so outside its picture."
        "LAP Mentor: tool out of view"
    ScopeTurn "scope_turn_deg" "deg"
        "Angle through which the view of the endoscope turned, measured in steps of 1°."
        "LapSim camera navigation: angular path"
    ScopeTilt "scope_tilt_deg" "deg"
        "Mean tilt of the picture's horizon."
        "LapSim camera navigation: horizon"
    ScopeSway "scope_sway_mm_s" "mm/s"
        "Mean speed of the middle of the picture, 10 cm before the lens, while the endoscope drill's organs were held in view. Smoothing and leash are those of the paths."
        "LapSim camera navigation: stability; measure own"
    Exchanges "exchanges" "n" "Exchanges of the instrument." "own"
    CvsTriangle "cvs_triangle" "1"
        "Removed share of the layered tissue in Calot's triangle, by volume. Tissue cleared before the task counts as removed."
        "critical view of safety, criterion 1 (Strasberg)"
    CvsBed "cvs_bed" "1"
        "Removed share of the layered tissue in the lower third of the gallbladder's bed, by volume."
        "critical view of safety, criterion 2 (Strasberg)"
    CvsTwo "cvs_two" "1"
        "Share of the two vessels, cystic duct and artery, that are neither divided, torn nor perforated: 1, 0.5 or 0."
        "critical view of safety, criterion 3 (Strasberg)"
    ViewsHeld "views_held" "n"
        "Sides of the triangle, front and behind, from which the critical view was shown and held before the first clip."
        "doublet view (Sanford and Strasberg)"
    Bed "bed" "1"
        "Share of the layered tissue of the whole bed that is removed, by volume."
        "paper, task 4"
    Complications "complications" "n"
        "Times that an instructor fogged the lens, started a bleeding or let a clip slip. Learning curves leave such sessions out."
        "own"
    Alarms "alarms" "n" "Alarms of any kind." "paper, evaluation"
}

/// Total time from which the report has a sentence about pauses, gaps or missing devices, s. A
/// single late record of a device takes less. The table of all metrics shows shorter times, too.
const MENTIONED_S: f64 = 0.1;

impl Metric {
    /// True for a value that is worth a sentence in addition to the table of all metrics.
    #[must_use]
    pub fn is_worth_mention(self, value: f64) -> bool {
        match self {
            Self::Paused | Self::Gaps | Self::DeviceLost => value >= MENTIONED_S,
            _ => value > 0.0,
        }
    }

    /// True for a share of a whole, which is read best in per cent.
    #[must_use]
    pub fn is_share(self) -> bool {
        self.unit() == "1" && !matches!(self, Self::Smoothness | Self::ScopeSmoothness)
    }

    /// The metric of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|metric| metric.name() == name)
    }
}

impl serde::Serialize for Metric {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> serde::Deserialize<'de> for Metric {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::from_name(&name)
            .ok_or_else(|| serde::de::Error::custom(format_args!("no metric is called {name:?}")))
    }
}
