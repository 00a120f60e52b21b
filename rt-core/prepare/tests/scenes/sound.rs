//! Properties that every prepared scene must have.

use scene_prepare::{Prepared, Vec3, tetra};
use shared_mem::scene::{OrganKind, SceneFile, WEIGHT_SUM};

pub(crate) fn check(prepared: &Prepared) {
    let scene = &prepared.scene;
    let file =
        SceneFile::from_bytes(&scene.to_bytes().expect("scene writes")).expect("scene reads");
    for (organ, report) in file.organs().iter().zip(&prepared.report.organs) {
        assert_eq!(report.components, 1, "{}", report.name);
        assert!(report.min_degree >= 3, "{}", report.name);
        assert!(report.protrusion_max_mm < 0.1, "{}", report.name);
        // A tube is a row of spheres: it has no tetrahedra, and all its links point one way.
        let is_tube = report.tetrahedra == 0;
        // A layer of connective tissue is one sphere thick, and spheres cannot fill it.
        let is_layer = organ.kind == OrganKind::ConnectiveTissue as u32;
        let least = match (is_tube, is_layer) {
            (_, true) => 0.35,
            (true, _) => 0.6,
            _ => 0.7,
        };
        assert!(
            report.coverage > least,
            "{}: {}",
            report.name,
            report.coverage
        );
        let [first, count] = organ.spheres.map(|x| x as usize);
        let spheres = &file.spheres()[first..first + count];
        let mass: f64 = spheres.iter().map(|s| f64::from(s.mass_kg)).sum();
        let expected = f64::from(organ.material.density_kg_m3) * f64::from(organ.volume_m3);
        assert!(
            (mass / expected - 1.0).abs() < 1e-5,
            "mass is density times volume"
        );
        let is_joined = file.attachments().iter().any(|tie| {
            [tie.a, tie.b]
                .iter()
                .any(|&s| s >= organ.spheres[0] && s < organ.spheres[0] + organ.spheres[1])
        });
        assert!(
            is_joined || spheres.iter().any(|s| s.held == 1),
            "{} is held or attached somewhere",
            report.name
        );
        assert!(
            spheres.iter().any(|s| s.held == 0),
            "{} is free somewhere",
            report.name
        );

        let is_tube = is_tube || is_layer;
        assert!(
            is_tube || report.tetrahedra > 3 * report.spheres / 2,
            "{}",
            report.name
        );
        assert!(
            is_tube || report.tetra_shape_min >= Some(tetra::SHAPE_MIN),
            "{}: {:?}",
            report.name,
            report.tetra_shape_min
        );
        assert!(
            is_tube || report.isotropy > 0.3,
            "{}: {}",
            report.name,
            report.isotropy
        );

        let [first, count] = organ.links.map(|x| x as usize);
        let list = &file.links()[first..first + count];
        let clashes = (1..list.len())
            .filter(|&i| {
                let recent = &list[i.saturating_sub(7)..i];
                let shares = |l: &shared_mem::scene::LinkRecord| {
                    [l.a, l.b]
                        .iter()
                        .any(|s| [list[i].a, list[i].b].contains(s))
                };
                recent.iter().any(shares)
            })
            .count();
        assert!(
            is_tube || clashes * 40 < list.len(),
            "{}: {clashes} of {} links wait",
            report.name,
            list.len()
        );
        for link in list {
            let at = |i: u32| Vec3::from(file.spheres()[i as usize].center_m.map(f64::from));
            let length = (at(link.a) - at(link.b)).norm();
            assert!((length - f64::from(link.rest_length_m)).abs() < 1e-6);
        }
    }
    for v in file.vertices() {
        let normal = Vec3::from(v.normal.map(f64::from)).norm();
        assert!((normal - 1.0).abs() < 1e-4);
        assert_eq!(
            v.weights.iter().map(|&w| u32::from(w)).sum::<u32>(),
            WEIGHT_SUM
        );
    }
    check_room(&file);
}

/// Checks that the instrument can work on the target, and that the handle stays near the device.
fn check_room(file: &SceneFile) {
    let room = file.room();
    let port = Vec3::from(room.instrument_port_m.map(f64::from));
    let base = Vec3::from(room.world_from_device.position_m.map(f64::from));
    let target = Vec3::from(room.target_m.map(f64::from));
    let normal = Vec3::from(room.target_normal.map(f64::from));
    let length = f64::from(room.instrument_length_m);
    for offset in [-0.02, 0.0, 0.03, 0.05] {
        let tip = target + normal * offset;
        let inside = (tip - port).norm();
        assert!(
            (0.06..0.22).contains(&(length - inside)),
            "{} m outside",
            length - inside
        );
        let handle = port - (tip - port) / inside * (length - inside);
        assert!(
            (handle - base).norm() < 0.08,
            "handle {} m off",
            (handle - base).norm()
        );
    }
    assert!(
        (target - port).normalize().dot(&normal) < -0.3,
        "the shaft comes in steeply"
    );
}

/// Asserts that the report has every figure, for the whole and for each organ.
pub(crate) fn assert_json_has_all_keys(report: &scene_prepare::Report) {
    let json = serde_json::to_value(report).expect("JSON");
    let organs = json["organs"].as_array().expect("a list");
    assert_eq!(organs.len(), report.organs.len());
    for key in [
        "build_s",
        "spheres",
        "springs",
        "tetrahedra",
        "coverage",
        "gap_mean_mm",
        "gap_95_mm",
        "gap_max_mm",
        "protrusion_max_mm",
        "components",
        "min_degree",
        "isotropy",
        "tetra_shape_min",
        "volume_ml",
        "mass_g",
    ] {
        for figures in organs.iter().chain([&json]) {
            assert!(figures[key].is_number(), "{key} of {figures}");
        }
    }
}
