//! Published measurements, with their sources.

/// Strains of the compressed silicones, per cent of the height.
pub(super) const STRAINS_PCT: [f64; 7] = [5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0];

/// A silicone: a cylinder of 50 mm by 30 mm, pressed at 10 mm/min, ten runs.
#[derive(Debug)]
pub(super) struct Silicone {
    pub(super) name: &'static str,
    /// Young's modulus at 10 % strain, Pa. The fit starts from it.
    pub(super) young_pa: f64,
    /// Mean and standard deviation of the force at each of [`STRAINS_PCT`], N.
    pub(super) force_n: [[f64; 2]; 7],
}

/// Silicones from soft to stiff. The first is as soft as liver.
pub(super) const SILICONES: [Silicone; 7] = [
    Silicone {
        name: "EF10_100T",
        young_pa: 6000.0,
        force_n: [
            [0.578, 0.106],
            [1.299, 0.112],
            [2.903, 0.155],
            [4.984, 0.239],
            [8.514, 0.431],
            [16.37, 0.91],
            [37.8, 2.1],
        ],
    },
    Silicone {
        name: "EF10_87_5T",
        young_pa: 8000.0,
        force_n: [
            [0.840, 0.036],
            [1.747, 0.040],
            [3.745, 0.080],
            [6.397, 0.109],
            [10.897, 0.220],
            [20.94, 0.52],
            [48.3, 1.4],
        ],
    },
    Silicone {
        name: "EF10_75T",
        young_pa: 8900.0,
        force_n: [
            [0.921, 0.016],
            [1.945, 0.022],
            [4.277, 0.066],
            [7.233, 0.126],
            [12.245, 0.233],
            [23.68, 0.57],
            [56.4, 1.9],
        ],
    },
    Silicone {
        name: "EF10_50T",
        young_pa: 15_100.0,
        force_n: [
            [1.574, 0.055],
            [3.280, 0.078],
            [7.064, 0.192],
            [11.934, 0.222],
            [19.605, 0.345],
            [35.86, 0.70],
            [79.3, 1.8],
        ],
    },
    Silicone {
        name: "EF10_0T",
        young_pa: 53_000.0,
        force_n: [
            [5.33, 0.28],
            [11.56, 0.35],
            [24.90, 0.68],
            [41.5, 0.9],
            [66.8, 1.4],
            [118.5, 2.5],
            [252.0, 5.0],
        ],
    },
    Silicone {
        name: "EF30_0T",
        young_pa: 98_000.0,
        force_n: [
            [9.83, 0.28],
            [21.35, 0.42],
            [47.17, 0.35],
            [79.0, 0.4],
            [125.1, 0.8],
            [212.0, 2.0],
            [422.0, 5.0],
        ],
    },
    Silicone {
        name: "EF50_0T",
        young_pa: 152_000.0,
        force_n: [
            [14.90, 0.35],
            [33.20, 0.56],
            [74.68, 0.59],
            [125.1, 0.8],
            [196.3, 1.6],
            [331.0, 4.0],
            [651.0, 10.0],
        ],
    },
];

/// A published value of an effect that Calot does not model.
#[derive(Debug)]
pub(super) struct Missing {
    pub(super) source: &'static str,
    pub(super) quantity: &'static str,
    pub(super) condition: &'static str,
    pub(super) published: f64,
    pub(super) sd: Option<f64>,
    /// The effect that the model lacks.
    pub(super) reason: &'static str,
}

/// Effects that a surgeon's hand feels and Calot does not model.
pub(super) const MISSING: [Missing; 14] = [
    Missing {
        source: "PMC493277",
        quantity: "growth of the length at 5 kPa, %",
        condition: "porcine common bile duct, filled",
        published: 25.0,
        sd: None,
        reason: "ducts do not widen under pressure",
    },
    Missing {
        source: "PMID 32468887",
        quantity: "mean grip, N",
        condition: "laparoscopic hepatectomy, pigs",
        published: 1.75,
        sd: None,
        reason: "a button closes the jaws, and their grip is not read",
    },
    Missing {
        source: "PMID 32468887",
        quantity: "largest grip, N",
        condition: "laparoscopic hepatectomy, pigs",
        published: 3.38,
        sd: None,
        reason: "a button closes the jaws, and their grip is not read",
    },
    Missing {
        source: "PMID 15108104",
        quantity: "pinch needed at a pull of 5 N, N",
        condition: "laparoscopic grasper",
        published: 3.0,
        sd: Some(0.4),
        reason: "a button closes the jaws, and their grip is not read",
    },
    Missing {
        source: "PMID 15108104",
        quantity: "pinch used at a pull of 5 N, N",
        condition: "laparoscopic grasper",
        published: 6.8,
        sd: Some(0.5),
        reason: "a button closes the jaws, and their grip is not read",
    },
    Missing {
        source: "Cartmill 1999",
        quantity: "pressure at the grasper's tip, kPa",
        condition: "straight pull",
        published: 210.0,
        sd: None,
        reason: "the pressure of a bite is its mean",
    },
    Missing {
        source: "Cartmill 1999",
        quantity: "pressure at the grasper's tip, kPa",
        condition: "pull at 135 degrees",
        published: 650.0,
        sd: None,
        reason: "the pressure of a bite is its mean",
    },
    Missing {
        source: "PMC8058906",
        quantity: "mean force of sharp dissection, N",
        condition: "45 studies",
        published: 0.03,
        sd: None,
        reason: "blades return no force",
    },
    Missing {
        source: "Deans 1995",
        quantity: "pressure that clips bear, mmHg",
        condition: "90 clips on vessels, none displaced",
        published: 300.0,
        sd: None,
        reason: "clips do not slip and vessels do not burst",
    },
    Missing {
        source: "PMID 25982449",
        quantity: "burst pressure, mmHg",
        condition: "cystic duct closed by clips",
        published: 329.7,
        sd: Some(38.8),
        reason: "ducts do not burst",
    },
    Missing {
        source: "PMID 25982449",
        quantity: "burst pressure, mmHg",
        condition: "cystic duct closed by ultrasound",
        published: 358.0,
        sd: Some(33.1),
        reason: "ducts do not burst",
    },
    Missing {
        source: "PMID 25982449",
        quantity: "burst pressure, mmHg",
        condition: "cystic duct closed by bipolar heat",
        published: 219.7,
        sd: Some(41.2),
        reason: "ducts do not burst",
    },
    Missing {
        source: "Lund",
        quantity: "largest rate of bile leaks, %",
        condition: "metal clips",
        published: 2.0,
        sd: None,
        reason: "a clip that reaches across never leaks",
    },
    Missing {
        source: "PMC3359872",
        quantity: "growth of the shear modulus with hepatic pressure",
        condition: "0 to 35 mmHg, free to expand",
        published: 5.4,
        sd: None,
        reason: "the liver has no pressure inside",
    },
];
