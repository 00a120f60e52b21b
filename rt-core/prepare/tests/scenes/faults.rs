//! Scenes with an author's mistakes: supports that hold nothing or everything, organs that overlap,
//! organs of a few millimetres, organs that fall or shake.

use crate::support::LoadedScene;
use rt_core::port::{DeviceCapabilities, ForceCommand, Polled};
use rt_core::sim::{Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use rt_core::words::{Event, EventKind};
use scene_prepare::mesh::Mesh;
use scene_prepare::{Prepared, Recipe, Vec3, prepare, shape};

/// A ball of this radius around a place.
fn ball(at: [f64; 3], radius_m: f64) -> Mesh {
    let at = Vec3::from(at);
    let margin = Vec3::repeat(1.2 * radius_m);
    let distance = move |p: &Vec3| (p - at).norm() - radius_m;
    shape::skin(&distance, [at - margin, at + margin], radius_m / 6.0)
}

/// A plate of 80 × 50 × 24 mm with round edges. Its middle is at this height.
fn plate(up_m: f64) -> Mesh {
    let (half_m, up, round_m) = (Vec3::new(0.04, 0.025, 0.012), Vec3::z() * up_m, 0.009);
    let distance = move |p: &Vec3| {
        let beyond = (p - up).abs() - half_m.add_scalar(-round_m);
        beyond.sup(&Vec3::zeros()).norm() + beyond.max().min(0.0) - round_m
    };
    let margin = Vec3::repeat(0.004);
    shape::skin(
        &distance,
        [up - half_m - margin, up + half_m + margin],
        0.003,
    )
}

/// Prepares organs. Each is a mesh and the further lines of its table in the recipe.
fn prepared(organs: &[(Mesh, &str)]) -> Result<Prepared, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = String::from(
        "name = \"faults\"\n[room]\nlook_at_m = [0.0, 0.0, 0.0]\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\
         breath_s = 4.0\n",
    );
    for (number, (mesh, lines)) in organs.iter().enumerate() {
        let mut obj = String::new();
        for v in &mesh.vertices {
            obj.push_str(&format!("v {} {} {}\n", v.x, v.y, v.z));
        }
        for [a, b, c] in &mesh.triangles {
            obj.push_str(&format!("f {} {} {}\n", a + 1, b + 1, c + 1));
        }
        let file = format!("{number}.obj");
        std::fs::write(folder.path().join(&file), obj).expect("written");
        text.push_str(&format!(
            "[[organ]]\nname = \"organ {number}\"\nkind = \"liver\"\nmesh = \"{file}\"\nunit = \"m\"\n{lines}\n"
        ));
    }
    let recipe = Recipe::parse(&text, "faults", folder.path()).map_err(|it| it.to_string())?;
    prepare(&recipe, &mut |_| {}).map_err(|it| it.to_string())
}

/// A station at which nobody works.
#[derive(Default)]
struct Nobody {
    now_ns: u64,
    events: Vec<(u64, Event)>,
}

impl Ports for Nobody {
    fn sample(&mut self) -> Samples {
        Samples {
            now_ns: self.now_ns,
            device: Polled::Nothing,
            tracker: Polled::Nothing,
            pedal: Polled::Nothing,
            command: None,
        }
    }

    fn send_force(&mut self, _: ForceCommand) {}

    fn publish(&mut self, view: &TickView<'_>) {
        let ms = self.now_ns / 1_000_000;
        self.events.extend(view.events.iter().map(|it| (ms, *it)));
    }

    fn stamp(&mut self, _: Stage) {}
}

/// Events of organs that fall or shake while nobody works for this time.
fn left_alone(built: &Prepared, seconds: u64) -> Vec<(u64, Event)> {
    let loaded = LoadedScene::new(&built.scene);
    let mut state = Box::new(State::new());
    let device = DeviceCapabilities::TOUCH;
    let mut sim = Sim::new(loaded.scene(), &mut state, device, Parameters::default());
    let mut hand = Nobody::default();
    for _ in 0..1000 * seconds {
        hand.now_ns += 1_000_000;
        sim.tick(&mut hand);
    }
    let mut told = hand.events;
    told.retain(|(_, it)| matches!(it.kind, EventKind::Fall | EventKind::Shake));
    told
}

#[test]
fn a_support_that_holds_nothing_is_refused_with_entry_place_and_distance() {
    let refused = |held: &str| {
        let lines = format!("spheres = 60\nheld = [{{ base = 0.2 }}, {held}]");
        prepared(&[(plate(0.0), &lines)]).expect_err(held)
    };
    let cases = [
        (
            "{ ball = { center_m = [0.0, 0.2, 0.0], radius_m = 0.01 } }",
            [
                "'organ 0'",
                "held[1], a ball of 10.0 mm",
                "[0.0, 0.2, 0.0] m",
            ],
        ),
        (
            "{ box = { min_m = [0.1, 0.1, 0.1], max_m = [0.12, 0.12, 0.12] } }",
            [
                "'organ 0'",
                "held[1], a box of 20 x 20 x 20 mm",
                "none of its 60",
            ],
        ),
        (
            "{ plane = { point_m = [0.0, 0.0, 0.5], normal = [0.0, 0.0, 1.0] } }",
            [
                "'organ 0'",
                "held[1], a plane at [0.0, 0.0, 0.5] m",
                "mm off",
            ],
        ),
    ];
    for (held, words) in cases {
        let message = refused(held);
        assert!(words.iter().all(|it| message.contains(it)), "{message}");
        assert!(!message.contains("millimetres"), "{message}");
    }
    // The ball's surface is 190 mm away from the middle of the plate, and the plate reaches 25 mm
    // towards the ball.
    let message = refused(cases[0].0);
    let off_mm: f64 = message
        .split("nearest is ")
        .nth(1)
        .and_then(|it| it.split(" mm").next()?.parse().ok())
        .expect("a distance");
    assert!((160.0..185.0).contains(&off_mm), "{message}");
    let in_mm = refused("{ ball = { center_m = [0.0, 0.0, -9.0], radius_m = 0.8 } }");
    assert!(in_mm.contains("look like millimetres"), "{in_mm}");
    let far = refused("{ ball = { center_m = [0.0, 0.0, -90.0], radius_m = 0.8 } }");
    assert!(far.contains("are these millimetres?"), "{far}");
}

#[test]
fn a_support_that_holds_everything_is_refused() {
    for held in [
        "{ box = { min_m = [-1.0, -1.0, -1.0], max_m = [1.0, 1.0, 1.0] } }",
        "{ base = 0.6 }, { plane = { point_m = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] } }",
    ] {
        let lines = format!("spheres = 60\nheld = [{held}]");
        let message = prepared(&[(plate(0.0), &lines)]).expect_err(held);
        assert!(
            message.contains("catches all of its 60 spheres"),
            "{message}"
        );
    }
}

/// The warnings, without those about thin parts: these plates are about two spheres thick.
fn warnings(built: &Prepared) -> Vec<&str> {
    let all = built.report.warnings.iter().map(String::as_str);
    all.filter(|it| !it.contains(" has thin parts")).collect()
}

#[test]
fn an_attachment_that_catches_nothing_or_everything_is_refused() {
    let with = |within_m: f64| {
        let lines =
            format!("spheres = 60\nattached = [{{ to = \"organ 0\", within_m = {within_m} }}]");
        let below = (plate(0.0), "spheres = 60\nheld = [{ base = 0.2 }]");
        prepared(&[below, (plate(0.03), &lines)])
    };
    let nothing = with(0.0005).expect_err("6 mm apart");
    assert!(
        nothing.contains("attached[0], within 0.5 mm of 'organ 0', catches none"),
        "{nothing}"
    );
    let everything = with(0.09).expect_err("all of it");
    assert!(
        everything.contains("catches all of its 60 spheres"),
        "{everything}"
    );
    let some = with(0.012).expect("its lower side");
    assert_eq!(warnings(&some), [""; 0]);
}

#[test]
fn an_organ_that_nothing_holds_is_warned_of_and_falls() {
    let loose = |share: &str| {
        let lines = format!("spheres = 60\nheld = []\ngravity_share = {share}");
        prepared(&[(plate(0.0), &lines)]).expect("a warning only")
    };
    let heavy = loose("1.0");
    let [warning] = &warnings(&heavy)[..] else {
        panic!("{:?}", heavy.report.warnings)
    };
    assert!(
        warning.starts_with("nothing holds 'organ 0' (held 0 spheres): it falls"),
        "{warning}"
    );
    assert!(heavy.report.to_string().contains(warning));
    let told = left_alone(&heavy, 4);
    assert_eq!(told.len(), 1, "{told:?}");
    let (at_ms, event) = told[0];
    assert_eq!((event.kind, event.organ), (EventKind::Fall, Some(0)));
    // It falls its own length of 0.1 m in 0.14 s, and stays away.
    assert!(
        (140..1500).contains(&at_ms) && event.value > 0.09,
        "{event:?} after {at_ms} ms"
    );
    let light = loose("0.0");
    assert!(
        light.report.warnings[0].contains("floats away"),
        "{:?}",
        light.report.warnings
    );
    assert_eq!(left_alone(&light, 4), []);
}

#[test]
fn an_organ_that_is_held_neither_falls_nor_shakes() {
    let lines = "spheres = 100\nheld = [{ base = 0.2 }]\ngravity_share = 1.0\n\
                 material = { young_pa = 5000.0, poisson = 0.45 }";
    let built = prepared(&[(plate(0.0), lines)]).expect("a good scene");
    assert_eq!(warnings(&built), [""; 0]);
    assert_eq!(left_alone(&built, 12), []);
}

/// Breath keeps an organ moving for ever. Preparation must not reduce the organ's weight because of
/// that.
#[test]
fn an_organ_that_breathes_keeps_its_weight() {
    let lines = "spheres = 60\nheld = [{ base = 0.2 }]\ngravity_share = 1.0\n\
                 breath_mm = [0.0, 0.0, 5.0]\nmaterial = { young_pa = 5000.0, poisson = 0.45 }";
    let built = prepared(&[(plate(0.0), lines)]).expect("a good scene");
    assert_eq!(warnings(&built), [""; 0]);
    assert!((built.scene.organs[0].gravity_share - 1.0).abs() < 1.0e-6);
}

/// Soft and stiff tissue comes to rest under its weight. Tissue that would not rest gets less
/// weight, and then rests.
#[test]
fn an_organ_that_cannot_bear_its_weight_gets_less_of_it() {
    let built = |young_pa: u32| {
        let lines = format!(
            "spheres = 60\nheld = [{{ base = 0.2 }}]\ngravity_share = 1.0\n\
             material = {{ young_pa = {young_pa}, poisson = 0.45 }}"
        );
        prepared(&[(plate(0.0), &lines)]).expect("a good scene")
    };
    let soft = built(20);
    let share = soft.scene.organs[0].gravity_share;
    let expected = format!("prepared with gravity_share = {share}");
    assert!(share < 1.0 && soft.report.warnings[0].contains(&expected));
    for built in [soft, built(1000), built(100_000)] {
        assert_eq!(left_alone(&built, 12), [], "{:?}", built.report.warnings);
    }
}

/// One sphere holds a thin plate. The plate turns about it without end, and bursts under a tool.
#[test]
fn an_organ_that_never_comes_to_rest_is_refused() {
    let half_m = Vec3::new(0.030, 0.020, 0.0025);
    let distance = move |p: &Vec3| {
        let beyond = p.abs() - half_m;
        beyond.sup(&Vec3::zeros()).norm() + beyond.max().min(0.0)
    };
    let margin = Vec3::repeat(0.003);
    let thin = shape::skin(&distance, [-half_m - margin, half_m + margin], 0.001);
    let lines = "spheres = 250\ngravity_share = 1.0\n\
                 held = [{ ball = { center_m = [-0.027, 0.018, -0.001], radius_m = 0.0015 } }]\n\
                 material = { young_pa = 1500.0 }";
    let refusal = prepared(&[(thin, lines)]).expect_err("it is not held");
    let expected = "organ 'organ 0': does not come to rest, even with a thousandth of its weight: 1 \
                    of its 250 spheres are held; hold more of it";
    assert!(refusal.starts_with(expected), "{refusal}");
}

/// The reported depth is that of the skins and does not depend on the spheres.
#[test]
fn organs_that_overlap_are_reported_with_place_and_depth() {
    let at = |gap_m: f64| {
        let below = (plate(0.0), "spheres = 60\nheld = [{ base = 0.2 }]");
        let above = (
            plate(0.024 + gap_m),
            "spheres = 60\nheld = [{ base = 0.2 }]",
        );
        prepared(&[below, above]).expect("it may overlap").report
    };
    for gap_m in [0.01, 0.0] {
        assert_eq!(at(gap_m).overlaps, [], "{gap_m}");
    }
    for depth_m in [0.001, 0.004, 0.012] {
        let report = at(-depth_m);
        let [overlap] = &report.overlaps[..] else {
            panic!("{:?}", report.overlaps)
        };
        assert_eq!(overlap.organs, ["organ 0", "organ 1"]);
        assert!(
            (overlap.depth_mm - 1e3 * depth_m).abs() < 0.1,
            "{overlap:?}"
        );
        assert!((0.0..0.013).contains(&overlap.at_m[2]), "{overlap:?}");
        assert!(report.to_string().contains(&format!("warning: {overlap}")));
    }
}

/// Organs of a few millimetres need a contact skin of their own: their spheres must not name
/// vertices of the organ before.
#[test]
fn organs_of_a_few_millimetres_run_alone_and_beside_another() {
    for (radius_m, spheres) in [(0.0015, 200), (0.002, 60), (0.0012, 400), (0.004, 8)] {
        let lines = format!("spheres = {spheres}\nheld = [{{ base = 0.3 }}]");
        let tiny = || ball([0.0, 0.0, 0.03], radius_m);
        let beside = (plate(0.0), "spheres = 60\nheld = [{ base = 0.2 }]");
        let both = prepared(&[beside, (tiny(), &lines)]).expect("beside another");
        let alone = prepared(&[(tiny(), &lines)]).expect("alone");
        for built in [both, alone] {
            assert_eq!(left_alone(&built, 2), [], "{radius_m} m");
            let skinned = built
                .scene
                .contact_nearest
                .iter()
                .filter(|it| **it != u16::MAX);
            assert_eq!(skinned.count(), built.scene.spheres.len(), "{radius_m} m");
        }
    }
}

/// Preparation refuses a scene that the realtime process would refuse, with the organ and the
/// remedy.
#[test]
fn an_organ_too_small_for_the_realtime_process_is_refused() {
    let lines = "spheres = 3000\nheld = [{ base = 0.3 }]";
    let message = prepared(&[(ball([0.0; 3], 0.0006), lines)]).expect_err("too light");
    assert!(message.contains("organ 'organ 0'"), "{message}");
    assert!(
        message.contains("fewer spheres") || message.contains("unit"),
        "{message}"
    );
}
