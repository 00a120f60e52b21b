//! The cases of the chart of speed against accuracy.

use crate::body::Tissue;
use crate::organ::Organ;
use crate::scene::Kind;

/// An organ, its material and its experiment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    /// Organ under test.
    pub(crate) organ: Organ,
    /// Experiment.
    pub(crate) kind: Kind,
    /// Material of the organ.
    pub(crate) tissue: Tissue,
}

impl Case {
    /// An organ of liver tissue.
    pub(crate) const fn new(organ: Organ, kind: Kind) -> Self {
        Self {
            organ,
            kind,
            tissue: Tissue::LIVER,
        }
    }

    const fn of(self, young_pa: f64, poisson: f64) -> Self {
        let tissue = Tissue {
            young_pa,
            poisson,
            ..self.tissue
        };
        Self { tissue, ..self }
    }

    /// All cases. Methods are calibrated on the first one only.
    pub(crate) fn all() -> Vec<Self> {
        let liver = |kind| Self::new(Organ::Liver, kind);
        let mut all = vec![
            liver(Kind::Sag),
            liver(Kind::Pull),
            liver(Kind::Twist(90)),
            liver(Kind::Twist(180)),
            liver(Kind::Sag).of(2500.0, 0.45),
            liver(Kind::Sag).of(20e3, 0.45),
            liver(Kind::Pull).of(20e3, 0.30),
            liver(Kind::Sag).of(5e3, 0.49),
            Self::new(Organ::Gallbladder, Kind::Sag),
            Self::new(Organ::Gallbladder, Kind::Twist(90)),
            Self::new(Organ::Atlas, Kind::Sag),
            Self::new(Organ::Atlas, Kind::Pull),
        ];
        // The balls' diameters are those of laparoscopic instruments.
        let balls = [3, 5, 10].into_iter();
        all.extend(balls.flat_map(|mm| (0..3).map(move |site| liver(Kind::Press(mm, site)))));
        all
    }

    /// Few cases, for a quick look and for the test.
    pub(crate) fn few() -> Vec<Self> {
        Self::all().into_iter().take(3).collect()
    }

    /// Name of the case in files.
    pub(crate) fn name(&self) -> String {
        let mut name = format!("{}: {}", self.organ.name(), self.kind.name());
        if self.tissue.young_pa != Tissue::LIVER.young_pa {
            name += &format!(", E {} kPa", self.tissue.young_pa / 1e3);
        }
        if self.tissue.poisson != Tissue::LIVER.poisson {
            name += &format!(", ν {}", self.tissue.poisson);
        }
        name
    }
}
