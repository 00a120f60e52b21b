//! A scene that is turned and moved behaves like the original.

use nalgebra::{Matrix3, Rotation3, Unit};
use rt_core::math::Vec3 as Single;
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};
use rt_core::tool::{Capsule, Role};
use scene_prepare::mesh::Mesh;
use scene_prepare::shape::{Form, Shape};
use scene_prepare::{Prepared, Recipe, Vec3, prepare};

use crate::support::LoadedScene;

/// Ticks in which a loaded organ comes to rest: three seconds.
const TICKS: usize = 3000;

/// A turn and a shift of the whole scene.
#[derive(Clone, Copy)]
struct Turn {
    axes: Matrix3<f64>,
    shift_m: Vec3,
}

impl Turn {
    /// Pose number `number`. Pose 0 moves nothing.
    fn new(number: u32) -> Self {
        let around = Vec3::new(0.36, -0.48, 0.8) + Vec3::new(0.3, 0.1, -0.2) * f64::from(number);
        let angle = 1.1 * f64::from(number);
        Self {
            axes: Rotation3::from_axis_angle(&Unit::new_normalize(around), angle).into_inner(),
            shift_m: Vec3::new(0.31, -0.17, 0.093) * f64::from(number),
        }
    }

    fn place(&self, p: &Vec3) -> Vec3 {
        self.axes * p + self.shift_m
    }
}

/// An organ in its first pose.
struct Case {
    name: &'static str,
    mesh: Mesh,
    held: fn(&Turn) -> String,
    /// Direction in which the vertex that is pressed lies farthest.
    pressed: Vec3,
    /// Acceleration of gravity in the first pose, m/s².
    gravity: Vec3,
}

/// Measurements of a scene.
#[derive(Debug, Clone, Copy)]
struct Found {
    /// Largest displacement of a sphere under gravity, m.
    sag_m: f64,
    /// Force on a ball of 5 mm radius, 4 mm deep, N.
    force_n: f64,
    /// Figures of the report, as are the next two.
    gap_95_mm: f64,
    coverage: f64,
    held: usize,
}

fn prepared(case: &Case, turn: &Turn) -> Prepared {
    let mut text = String::new();
    for p in &case.mesh.vertices {
        let p = turn.place(p);
        text.push_str(&format!("v {:.9} {:.9} {:.9}\n", p.x, p.y, p.z));
    }
    for [a, b, c] in &case.mesh.triangles {
        text.push_str(&format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("organ.obj"), text).expect("written");
    let [x, y, z]: [f64; 3] = (turn.axes * case.gravity).into();
    let recipe = format!(
        "name = \"turned\"\n[room]\ngravity_m_s2 = [{x}, {y}, {z}]\n[[organ]]\nname = \"organ\"\n\
         kind = \"liver\"\nmesh = \"organ.obj\"\nunit = \"m\"\nspheres = 250\ngravity_share = 1.0\n\
         held = [{}]\n[organ.material]\nyoung_pa = 5000.0\n",
        (case.held)(turn)
    );
    let recipe = Recipe::parse(&recipe, "a test", folder.path()).expect("a good recipe");
    prepare(&recipe, &mut |_| {}).expect("an organ")
}

fn single(v: &Vec3) -> Single {
    v.map(|x| x as f32)
}

fn measure(case: &Case, turn: &Turn) -> Found {
    let built = prepared(case, turn);
    let loaded = LoadedScene::new(&built.scene);
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    for _ in 0..TICKS {
        assert_eq!(tissue.step(), 0);
    }
    let moved = (0..built.scene.spheres.len() as u32).map(|i| tissue.displacement_m(i).norm());
    let sag_m = f64::from(moved.fold(0.0, f32::max));

    // The organ without weight is pressed, because its surface stays where the mesh has it.
    let mut weightless = built.scene.clone();
    weightless.organs[0].gravity_share = 0.0;
    let loaded = LoadedScene::new(&weightless);
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    let along = |p: &Vec3| p.dot(&case.pressed);
    let site = case
        .mesh
        .vertices
        .iter()
        .max_by(|a, b| along(a).total_cmp(&along(b)));
    let site = turn.place(site.expect("a vertex"));
    let out = single(&(turn.axes * case.pressed.normalize()));
    let mut force_n = 0.0;
    for tick in 0..1000u16 {
        let depth_m = 0.004 * (f32::from(tick) / 300.0).min(1.0);
        let center_m = single(&site) + out * (0.005 - depth_m);
        let tip = Capsule {
            a_m: center_m,
            b_m: center_m,
            radius_m: 0.005,
            role: Role::Tip,
        };
        force_n = tissue.press(&[tip]).force_n.dot(&out);
    }
    let organ = &built.report.organs[0];
    Found {
        sag_m,
        force_n: f64::from(force_n),
        gap_95_mm: organ.gap_95_mm,
        coverage: organ.coverage,
        held: organ.held,
    }
}

fn written(v: &Vec3) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

fn plane(turn: &Turn, point_m: Vec3, normal: Vec3) -> String {
    let (point, normal) = (turn.place(&point_m), turn.axes * normal);
    format!(
        "{{ plane = {{ point_m = {}, normal = {} }} }}",
        written(&point),
        written(&normal)
    )
}

/// A prism of this many sides, a cube with four.
fn prism(sides: u32, radius_m: f64, height_m: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..sides {
        let angle = std::f64::consts::TAU * (f64::from(i) + 0.5) / f64::from(sides);
        let (sin, cos) = libm::sincos(angle);
        mesh.vertices
            .push(Vec3::new(cos * radius_m, sin * radius_m, 0.0));
        mesh.vertices
            .push(Vec3::new(cos * radius_m, sin * radius_m, height_m));
    }
    let (low, high) = (2 * sides, 2 * sides + 1);
    mesh.vertices.extend([Vec3::zeros(), Vec3::z() * height_m]);
    for i in 0..sides {
        let (a, b) = (2 * i, 2 * ((i + 1) % sides));
        let around = [
            [a, b, b + 1],
            [a, b + 1, a + 1],
            [low, b, a],
            [high, a + 1, b + 1],
        ];
        mesh.triangles.extend(around);
    }
    mesh
}

fn cases() -> [Case; 5] {
    let bare = |turn: &Turn| {
        plane(
            turn,
            Vec3::new(0.0, 0.36, -0.085),
            Vec3::new(0.0, 0.5, -0.87),
        )
    };
    let hilum = |turn: &Turn| {
        let center = written(&turn.place(&Vec3::new(0.0, 0.36, -0.085)));
        format!("{{ ball = {{ center_m = {center}, radius_m = 0.04 }} }}")
    };
    let foot = |turn: &Turn| plane(turn, Vec3::new(0.0, 0.0, 0.012), -Vec3::z());
    [
        Case {
            name: "liver",
            mesh: Shape::from(Form::Liver).mesh(),
            held: bare,
            pressed: Vec3::new(0.1, -0.3, 1.0),
            gravity: Vec3::new(0.0, -0.3, -0.2),
        },
        // Only a few spheres are held.
        Case {
            name: "hung liver",
            mesh: Shape::from(Form::Liver).mesh(),
            held: hilum,
            pressed: Vec3::new(0.1, -0.3, 1.0),
            gravity: Vec3::new(0.0, -0.3, -0.2),
        },
        Case {
            name: "stomach",
            mesh: Shape::from(Form::Stomach).mesh(),
            held: |_| "{ base = 0.3 }".into(),
            pressed: Vec3::new(0.1, 0.1, 1.0),
            gravity: Vec3::new(0.0, 0.0, -1.0),
        },
        Case {
            name: "cube",
            mesh: prism(4, 0.07, 0.099),
            held: foot,
            pressed: Vec3::new(0.003, 0.001, 1.0),
            gravity: Vec3::new(0.5, 0.3, 0.0),
        },
        Case {
            name: "cylinder",
            mesh: prism(48, 0.04, 0.12),
            held: foot,
            pressed: Vec3::new(0.003, 0.001, 1.0),
            gravity: Vec3::new(0.5, 0.3, 0.0),
        },
    ]
}

#[test]
fn a_scene_turned_and_moved_sags_and_pushes_alike() {
    for case in cases() {
        let first = measure(&case, &Turn::new(0));
        println!("{}: {first:?}", case.name);
        for number in 1..4 {
            let found = measure(&case, &Turn::new(number));
            println!("{}, pose {number}: {found:?}", case.name);
            for (what, now, before) in [
                ("sag", found.sag_m, first.sag_m),
                ("force", found.force_n, first.force_n),
                ("gap", found.gap_95_mm, first.gap_95_mm),
                ("coverage", found.coverage, first.coverage),
                ("held", found.held as f64, first.held as f64),
            ] {
                let share = now / before;
                assert!(
                    (share - 1.0).abs() < 0.01,
                    "{}, pose {number}: {what} {share}",
                    case.name
                );
            }
        }
    }
}
