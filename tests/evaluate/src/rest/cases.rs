//! The sweeps: recipes that differ in one value.

use std::path::Path;

use scene_prepare::Recipe;

use super::body::Form;

/// A recipe whose tissue must come to rest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Case {
    /// Swept quantity, with its unit.
    pub(super) sweep: &'static str,
    /// Its value.
    pub(super) value: String,
    what: What,
}

#[derive(Debug, Clone, PartialEq)]
enum What {
    /// One organ.
    Body(Body),
    /// A ball that hangs from a cube by a band. The numbers are their densities, kg/m³.
    Hanging([f64; 2]),
    /// A built-in scene.
    Built(Built),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Built {
    Liver,
    Triangle,
    Variant,
}

/// One organ, its material, its hold and its gravity.
#[derive(Debug, Clone, PartialEq)]
struct Body {
    form: Form,
    spheres: usize,
    young_pa: f64,
    poisson: f64,
    density_kg_m3: f64,
    /// Damping of the velocity, 1/s, and retardation time, s; `None` for typical values.
    damping: Option<[f64; 2]>,
    gravity_share: f64,
    gravity_m_s2: [f64; 3],
    held: &'static str,
    /// Rotation of the surface, degrees.
    turn_deg: f64,
}

impl Default for Body {
    /// A cube as soft as liver, held at its base, under its full weight.
    fn default() -> Self {
        Self {
            form: Form::Cube,
            spheres: 250,
            young_pa: 5400.0,
            poisson: 0.45,
            density_kg_m3: 1060.0,
            damping: None,
            gravity_share: 1.0,
            gravity_m_s2: [0.0, 0.0, -9.81],
            held: BASE,
            turn_deg: 0.0,
        }
    }
}

/// The lowest sixth is held.
const BASE: &str = "{ base = 0.17 }";

/// All cases, sweep by sweep. A quick run has the first and the last case of each sweep, if they
/// are small.
pub(super) fn all(quick: bool) -> Vec<Case> {
    let sweeps = [
        moduli(),
        poisson(),
        counts(),
        gravity(),
        supports(),
        densities(),
        orientations(),
        forms(),
        damping(),
        built(),
    ];
    let some = |sweep: Vec<Case>| {
        let last = sweep.len().saturating_sub(1);
        let kept = sweep.into_iter().enumerate();
        let kept = kept.filter(move |(i, _)| !quick || *i == 0 || *i == last);
        kept.map(|(_, case)| case)
    };
    let cases = sweeps.into_iter().flat_map(some);
    cases.filter(|case| !quick || case.is_small()).collect()
}

fn case(sweep: &'static str, value: &dyn std::fmt::Display, body: Body) -> Case {
    Case {
        sweep,
        value: value.to_string(),
        what: What::Body(body),
    }
}

fn moduli() -> Vec<Case> {
    let values = [
        10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e5, 1e6, 1e7, 5e7, 1e8,
    ];
    let body = |young_pa| Body {
        young_pa,
        ..Body::default()
    };
    values.map(|pa| case("modulus, Pa", &pa, body(pa))).into()
}

fn poisson() -> Vec<Case> {
    let body = |poisson| Body {
        poisson,
        ..Body::default()
    };
    let values = [0.0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499];
    values
        .map(|it| case("Poisson's ratio", &it, body(it)))
        .into()
}

fn counts() -> Vec<Case> {
    let body = |spheres| Body {
        spheres,
        ..Body::default()
    };
    let values = [8, 20, 60, 150, 581, 1500, 3200];
    values.map(|it| case("spheres", &it, body(it))).into()
}

fn gravity() -> Vec<Case> {
    let shares = [0.0, 0.25, 0.5, 0.75].map(|share| {
        let body = Body {
            gravity_share: share,
            young_pa: 1500.0,
            ..Body::default()
        };
        case("share of gravity, 1500 Pa", &share, body)
    });
    let strengths = [1.62, 15.0, 20.0].map(|z| {
        let body = Body {
            gravity_m_s2: [0.0, 0.0, -z],
            young_pa: 1500.0,
            ..Body::default()
        };
        case("gravity, m/s², 1500 Pa", &z, body)
    });
    shares.into_iter().chain(strengths).collect()
}

fn supports() -> Vec<Case> {
    let holds = [
        (
            "top",
            "{ plane = { point_m = [0.0, 0.0, 0.014], normal = [0.0, 0.0, 1.0] } }",
        ),
        (
            "side",
            "{ plane = { point_m = [0.014, 0.0, 0.0], normal = [1.0, 0.0, 0.0] } }",
        ),
        (
            "two sides",
            "{ plane = { point_m = [0.014, 0.0, 0.0], normal = [1.0, 0.0, 0.0] } }, \
             { plane = { point_m = [-0.014, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] } }",
        ),
        (
            "one corner",
            "{ ball = { center_m = [0.02, 0.02, 0.02], radius_m = 0.012 } }",
        ),
        ("half", "{ base = 0.5 }"),
        ("almost all", "{ base = 0.85 }"),
    ];
    let body = |held, young_pa| Body {
        held,
        young_pa,
        ..Body::default()
    };
    let soft = holds.map(|(name, held)| case("hold, 1500 Pa", &name, body(held, 1500.0)));
    let stiff = holds.map(|(name, held)| case("hold, 50 kPa", &name, body(held, 50e3)));
    soft.into_iter().chain(stiff).collect()
}

fn densities() -> Vec<Case> {
    let body = |density_kg_m3| Body {
        density_kg_m3,
        ..Body::default()
    };
    let alone = [100.0, 5000.0].map(|it| case("density, kg/m³", &it, body(it)));
    let pairs = [[100.0, 5000.0], [1000.0, 1000.0], [5000.0, 100.0]].map(|both| Case {
        sweep: "densities of a cube and of a ball that hangs from it, kg/m³",
        value: format!("{} and {}", both[0], both[1]),
        what: What::Hanging(both),
    });
    alone.into_iter().chain(pairs).collect()
}

fn orientations() -> Vec<Case> {
    let named = [
        ("+x", [9.81, 0.0, 0.0]),
        ("-x", [-9.81, 0.0, 0.0]),
        ("+y", [0.0, 9.81, 0.0]),
        ("+z", [0.0, 0.0, 9.81]),
        ("oblique", [5.66, -5.66, 5.66]),
    ];
    let pulls = named.map(|(name, gravity_m_s2)| {
        let body = Body {
            gravity_m_s2,
            young_pa: 1500.0,
            ..Body::default()
        };
        case("direction of gravity, 1500 Pa", &name, body)
    });
    let turns = [17.0, 45.0, 110.0].map(|turn_deg| {
        let body = Body {
            turn_deg,
            young_pa: 1500.0,
            ..Body::default()
        };
        case("turned cube, degrees, 1500 Pa", &turn_deg, body)
    });
    pulls.into_iter().chain(turns).collect()
}

fn forms() -> Vec<Case> {
    let body = |form, young_pa| Body {
        form,
        young_pa,
        ..Body::default()
    };
    let soft = Form::ALL.map(|form| case("form, 1500 Pa", &form.name(), body(form, 1500.0)));
    let stiff = Form::ALL.map(|form| case("form, 1 MPa", &form.name(), body(form, 1e6)));
    soft.into_iter().chain(stiff).collect()
}

fn damping() -> Vec<Case> {
    let body = |damping| Body {
        damping: Some(damping),
        ..Body::default()
    };
    [
        ("1 and 0", [1.0, 0.0]),
        ("4 and 0", [4.0, 0.0]),
        ("0 and 0.001", [0.0, 0.001]),
        ("4 and 1", [4.0, 1.0]),
        ("1000 and 0", [1000.0, 0.0]),
    ]
    .map(|(name, both)| case("damping, 1/s, and retardation, s", &name, body(both)))
    .into()
}

fn built() -> Vec<Case> {
    let scenes = [
        ("liver and gallbladder", Built::Liver),
        ("triangle", Built::Triangle),
        ("variant triangle", Built::Variant),
    ];
    let built = |(name, scene): (&str, Built)| Case {
        sweep: "built-in scene",
        value: name.to_owned(),
        what: What::Built(scene),
    };
    scenes.map(built).into()
}

impl Case {
    /// Name of the case. All names begin with `rest`.
    pub(super) fn name(&self) -> String {
        format!("rest {}: {}", self.sweep, self.value)
    }

    /// True for a case that takes seconds.
    fn is_small(&self) -> bool {
        match &self.what {
            What::Body(body) => body.spheres <= 600,
            What::Hanging(_) => true,
            What::Built(scene) => *scene == Built::Liver,
        }
    }

    /// The recipe. Its surfaces are written to a folder.
    ///
    /// # Errors
    /// When a surface cannot be written, or the recipe is refused, in words.
    pub(super) fn recipe(&self, folder: &Path) -> Result<Recipe, String> {
        let text = match &self.what {
            What::Body(body) => body.text(folder)?,
            What::Hanging(densities) => hanging(densities, folder)?,
            What::Built(scene) => return scene.recipe(),
        };
        Recipe::parse(&text, &self.name(), folder).map_err(|e| e.to_string())
    }
}

impl Built {
    fn recipe(self) -> Result<Recipe, String> {
        let recipe = match self {
            Self::Liver => Recipe::built_in(),
            Self::Triangle => Recipe::triangle(false),
            Self::Variant => Recipe::triangle(true),
        };
        recipe
            .map(|it| it.level(0))
            .map_err(|error| error.to_string())
    }
}

impl Body {
    fn text(&self, folder: &Path) -> Result<String, String> {
        let [x, y, z] = self.gravity_m_s2;
        let damping = self.damping.map(|[damping_per_s, retardation_s]| {
            format!(", damping_per_s = {damping_per_s:?}, retardation_s = {retardation_s:?}")
        });
        Ok(format!(
            "name = \"rest\"\n\
             [room]\ngravity_m_s2 = [{x:?}, {y:?}, {z:?}]\n\
             [[organ]]\nname = \"body\"\nkind = \"liver\"\nmesh = \"{mesh}\"\nspheres = {spheres}\n\
             gravity_share = {share:?}\nheld = [{held}]\n\
             material = {{ young_pa = {young_pa:?}, poisson = {poisson:?}, \
             density_kg_m3 = {density:?}{damping} }}\n",
            mesh = self.form.write(folder, self.turn_deg)?,
            spheres = self.spheres,
            share = self.gravity_share,
            held = self.held,
            young_pa = self.young_pa,
            poisson = self.poisson,
            density = self.density_kg_m3,
            damping = damping.unwrap_or_default(),
        ))
    }
}

/// A held cube, and a ball that hangs below it by a band. The ball's file is written beside the
/// cube's.
fn hanging(densities: &[f64; 2], folder: &Path) -> Result<String, String> {
    let [above, below] = densities;
    let cube = Form::Cube.write(folder, 0.0)?;
    let ball = Form::Ball.write_below(folder, 0.050)?;
    Ok(format!(
        "name = \"rest\"\n\
         [room]\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\
         [[organ]]\nname = \"cube\"\nkind = \"liver\"\nmesh = \"{cube}\"\nspheres = 200\n\
         gravity_share = 1.0\n\
         held = [{{ plane = {{ point_m = [0.0, 0.0, 0.014], normal = [0.0, 0.0, 1.0] }} }}]\n\
         material = {{ density_kg_m3 = {above:?} }}\n\
         [[organ]]\nname = \"ball\"\nkind = \"liver\"\nmesh = \"{ball}\"\nspheres = 150\n\
         gravity_share = 1.0\nmaterial = {{ density_kg_m3 = {below:?} }}\n\
         [[band]]\nfrom = {{ organ = \"cube\", near_m = [0.0, 0.0, -0.02] }}\n\
         to = {{ organ = \"ball\", near_m = [0.0, 0.0, -0.03] }}\nstiffness_n_m = 200.0\n"
    ))
}
