//! Tests the compiled scene: writes and reads it, refuses faulty scenes, and reads damaged bytes.

use bytemuck::Zeroable;
use proptest::prelude::*;
use shared_mem::message::PoseMsg;
use shared_mem::scene::{
    AttachmentRecord, CellColumnRecord, CellRecord, ContactVertexRecord, LinkRecord,
    MaterialRecord, NO_CELL, NO_CONTACT_VERTEX, OrganKind, OrganRecord, RoomRecord, SceneData,
    SceneError, SceneFile, SphereRecord, StonesRecord, TetraRecord, TrocarRecord, VertexRecord,
    WORLD, name_from_str,
};

#[path = "../fuzz/body.rs"]
mod fuzz;

fn contact_vertex(i: u16) -> ContactVertexRecord {
    ContactVertexRecord {
        spheres: [i; 12],
        weights: [1.5, -0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        fan: [u32::from(i), 1],
        patch_m: 0.01,
        curvature_per_m: 20.0,
    }
}

/// Cell 0 or 1. Cell 1 lies on the outer face of cell 0.
fn cell(i: u16) -> CellRecord {
    let mut neighbours = [NO_CELL; 6];
    neighbours[usize::from(5 - i)] = 1 - i;
    CellRecord {
        corners: [0, 1, 2, 3, 4, 5, 6, 7],
        neighbours,
        spheres: [i; 12],
        weights: [0.5, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        center_m: [0.0, 0.0, 0.001 * f32::from(i)],
        extent_m: [0.001; 3],
        volume_m3: 1e-9,
        energy_j: 1.0,
        layer: i as u8,
        region: CellRecord::TRIANGLE,
        reserved: [0; 2],
    }
}

fn tiny_scene() -> SceneData {
    let sphere = |x: f32| SphereRecord {
        center_m: [x, 0.0, 0.0],
        radius_m: 0.01,
        mass_kg: 0.01,
        held: 0,
    };
    let vertex = |x: f32| VertexRecord {
        position_m: [x, 0.01, 0.0],
        normal: [0.0, 1.0, 0.0],
        spheres: [0; 8],
        weights: [65_535, 0, 0, 0, 0, 0, 0, 0],
    };
    let room = RoomRecord {
        name: name_from_str("tiny"),
        gravity_m_s2: [0.0, -9.81, 0.0],
        world_from_device: PoseMsg::IDENTITY,
        world_from_tracker: PoseMsg::IDENTITY,
        world_from_camera: PoseMsg::IDENTITY,
        instrument_length_m: 0.33,
        ..RoomRecord::zeroed()
    };
    let organ = OrganRecord {
        name: name_from_str("liver"),
        kind: OrganKind::Liver as u32,
        spheres: [0, 4],
        links: [0, 1],
        tetrahedra: [0, 1],
        elastic_links: 1,
        substeps: 1,
        gravity_share: 1.0,
        breath_m: [0.0, 0.01, 0.0],
        vertices: [0, 3],
        triangles: [0, 1],
        volume_m3: 1e-5,
        material: MaterialRecord {
            density_kg_m3: 1060.0,
            young_pa: 5000.0,
            poisson: 0.45,
            stretch_stiffness: 0.5,
            laplacian_stiffness: 0.1,
            damping_per_s: 1.0,
            contact_stiffness_n_m: 200.0,
            retardation_s: 0.002,
            friction: 0.1,
            toughness_j_m2: 100.0,
        },
    };
    SceneData {
        room: Some(room),
        trocar: None,
        stones: None,
        organs: vec![organ],
        spheres: vec![sphere(0.0), sphere(0.01), sphere(0.02), sphere(0.03)],
        links: vec![LinkRecord {
            a: 0,
            b: 1,
            rest_length_m: 0.01,
            compliance_m_n: 1e-3,
        }],
        vertices: vec![vertex(0.0), vertex(0.01), vertex(0.02)],
        triangles: vec![[0, 1, 2]],
        tetrahedra: vec![TetraRecord {
            spheres: [0, 1, 2, 3],
            volume_m3: 1e-5,
        }],
        contact_vertices: vec![contact_vertex(0), contact_vertex(1), contact_vertex(2)],
        contact_fans: vec![[1, 2], [2, 0], [0, 1]],
        contact_nearest: vec![0, 1, 2, NO_CONTACT_VERTEX],
        attachments: vec![AttachmentRecord {
            a: 3,
            b: WORLD,
            anchor_m: [0.0, 0.1, 0.0],
            rest_length_m: 0.1,
            compliance_m_n: 0.0,
            is_thread: 1,
            tear_j: 0.01,
        }],
        cells: vec![cell(0), cell(1)],
        cell_corners: vec![vertex(0.0); 8],
        cell_columns: vec![
            CellColumnRecord {
                cells: [1, 0, NO_CELL, NO_CELL, NO_CELL, NO_CELL],
                inwards: [4; 6],
                reserved: [0; 2],
            };
            3
        ],
    }
}

fn trocar(sliding_n: f32, breakaway_n: f32, wall_nm_rad: f32) -> TrocarRecord {
    TrocarRecord {
        sliding_n,
        breakaway_n,
        wall_nm_rad,
    }
}

#[test]
fn a_trocar_is_read_as_written_and_its_absence_leaves_the_bytes_as_they_were() {
    let without = tiny_scene();
    let with = SceneData {
        trocar: Some(trocar(1.0, 1.5, 0.3)),
        ..tiny_scene()
    };
    let read = |data: &SceneData| SceneFile::from_bytes(&data.to_bytes().unwrap()).unwrap();
    assert_eq!(read(&with).trocar(), with.trocar.as_ref());
    assert_eq!(read(&with).cell_columns(), with.cell_columns);
    assert_eq!(read(&without).trocar(), None);
    // Header with 14 sections, as scenes had before trocars were known.
    let bytes = without.to_bytes().unwrap();
    assert_eq!(bytes[12..16], 14u32.to_le_bytes());
    assert_ne!(read(&with).id(), read(&without).id());
    let mut broken = with.to_bytes().unwrap();
    broken[12] = 17;
    let error = SceneFile::from_bytes(&broken).unwrap_err();
    assert!(matches!(error, SceneError::NotAScene("wrong length")));
}

fn few_stones() -> StonesRecord {
    StonesRecord {
        count: 20,
        diameter_m: 0.004,
        room_m3: 40.0e-6,
        world_from_bowl: PoseMsg::IDENTITY,
        bowl_radii_m: [0.1; 3],
    }
}

#[test]
fn stones_are_read_as_written_also_without_a_trocar() {
    let stones = few_stones();
    let with = SceneData {
        stones: Some(stones),
        ..tiny_scene()
    };
    let read = |data: &SceneData| SceneFile::from_bytes(&data.to_bytes().unwrap()).unwrap();
    assert_eq!(read(&with).stones(), Some(&stones));
    assert_eq!(read(&with).trocar(), None);
    let both = SceneData {
        trocar: Some(trocar(1.0, 1.5, 0.3)),
        ..with
    };
    assert_eq!(read(&both).stones(), Some(&stones));
    assert_eq!(read(&both).trocar(), both.trocar.as_ref());
    assert_eq!(read(&tiny_scene()).stones(), None);
}

#[test]
fn a_scene_is_read_as_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiny.calot");
    let data = tiny_scene();
    let id = data.write(&path).unwrap();
    let scene = SceneFile::open(&path).unwrap();
    assert_eq!(scene.id(), id);
    assert_eq!(scene.name(), "tiny");
    assert_eq!(scene.organs(), data.organs);
    assert_eq!(scene.spheres(), data.spheres);
    assert_eq!(scene.links(), data.links);
    assert_eq!(scene.vertices(), data.vertices);
    assert_eq!(scene.triangles(), data.triangles);
    assert_eq!(scene.tetrahedra(), data.tetrahedra);
    assert_eq!(scene.attachments(), data.attachments);
    assert_eq!(scene.contact_vertices(), data.contact_vertices);
    assert_eq!(scene.contact_fans(), data.contact_fans);
    assert_eq!(scene.contact_nearest(), data.contact_nearest);
    assert_eq!(scene.cells(), data.cells);
    assert_eq!(scene.cell_corners(), data.cell_corners);
    assert_eq!(scene.cell_columns(), data.cell_columns);
    assert_eq!(
        data.to_bytes().unwrap(),
        std::fs::read(&path).unwrap(),
        "same scene, same bytes"
    );
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        1,
        "no partial file stays"
    );
}

#[test]
fn a_changed_scene_has_another_identity() {
    let id = |data: &SceneData| {
        SceneFile::from_bytes(&data.to_bytes().unwrap())
            .unwrap()
            .id()
    };
    let mut other = tiny_scene();
    other.spheres[1].radius_m = 0.011;
    assert_ne!(id(&tiny_scene()), id(&other));
}

type Fault = (&'static str, fn(&mut SceneData));

#[test]
fn every_fault_is_refused_and_named() {
    let faults: [Fault; 46] = [
        ("kind", |s| s.organs[0].kind = 99),
        ("name", |s| s.organs[0].name = [0; 32]),
        ("poisson", |s| s.organs[0].material.poisson = 0.5),
        ("young_pa", |s| s.organs[0].material.young_pa = f32::NAN),
        ("range", |s| s.organs[0].spheres = [1, 1]),
        ("cover", |s| s.organs[0].links = [0, u32::MAX]),
        ("cover", |s| s.organs[0].triangles = [0, 0]),
        ("sphere 1", |s| s.spheres[1].center_m[2] = f32::INFINITY),
        ("sphere 0", |s| s.spheres[0].mass_kg = 0.0),
        ("link 0", |s| s.links[0].b = 4),
        ("link 0", |s| s.links[0].compliance_m_n = -1.0),
        ("elastic", |s| s.organs[0].elastic_links = 2),
        ("substeps", |s| s.organs[0].substeps = 0),
        ("breath_m", |s| s.organs[0].breath_m[1] = f32::NAN),
        ("retardation_s", |s| {
            s.organs[0].material.retardation_s = -1.0;
        }),
        ("friction", |s| s.organs[0].material.friction = 2.5),
        ("toughness_j_m2", |s| {
            s.organs[0].material.toughness_j_m2 = f32::NAN;
        }),
        ("tetrahedron 0", |s| s.tetrahedra[0].spheres[2] = 4),
        ("tetrahedron 0", |s| s.tetrahedra[0].spheres[2] = 0),
        ("attachment 0", |s| s.attachments[0].b = 4),
        ("attachment 0: is_thread must be 0 or 1", |s| {
            s.attachments[0].is_thread = 2;
        }),
        ("attachment 0", |s| s.attachments[0].tear_j = -1.0),
        ("link 0", |s| s.links[0].b = 0),
        ("vertex 2", |s| s.vertices[2].weights[0] = 1),
        ("vertex 0", |s| s.vertices[0].spheres[7] = 4),
        ("triangle 0", |s| s.triangles[0][1] = 3),
        ("contact vertex 1", |s| s.contact_vertices[1].spheres[3] = 4),
        ("contact vertex 2", |s| {
            s.contact_vertices[2].weights[0] = f32::NAN;
        }),
        ("contact triangle 0", |s| s.contact_fans[0][0] = 3),
        ("nearest contact vertex 3", |s| s.contact_nearest[3] = 3),
        ("cell 1", |s| s.cells[1].corners[7] = 8),
        ("cell 0", |s| s.cells[0].spheres[3] = 4),
        ("cell 0: neighbour 2 does not exist", |s| {
            s.cells[0].neighbours[5] = 2;
        }),
        ("cell 0: its neighbour 1 does not name it", |s| {
            s.cells[1].neighbours[4] = NO_CELL;
        }),
        ("cell 1", |s| s.cells[1].energy_j = f32::NAN),
        ("cell 1: region must be 0 to 3", |s| s.cells[1].region = 9),
        ("cell corner 2", |s| s.cell_corners[2].weights[0] = 1),
        ("cell column 1", |s| s.cell_columns[1].inwards[5] = 6),
        ("trocar 0: sliding_n is 9, allowed are 0 to 8", |s| {
            s.trocar = Some(trocar(9.0, 9.0, 0.0));
        }),
        ("trocar 0: breakaway_n is 1, allowed are 2 to 8", |s| {
            s.trocar = Some(trocar(2.0, 1.0, 0.0));
        }),
        ("trocar 0: wall_nm_rad is NaN, allowed are 0 to 2", |s| {
            s.trocar = Some(trocar(0.0, 0.0, f32::NAN));
        }),
        ("stones 0: count is 31, allowed are 0 to 30", |s| {
            s.stones = Some(StonesRecord {
                count: 31,
                ..few_stones()
            });
        }),
        ("stones 0: diameter_m is NaN", |s| {
            s.stones = Some(StonesRecord {
                diameter_m: f32::NAN,
                ..few_stones()
            });
        }),
        ("stones 0: bowl_radii_m up is 0", |s| {
            s.stones = Some(StonesRecord {
                bowl_radii_m: [0.1, 0.0, 0.1],
                ..few_stones()
            });
        }),
        ("stones 0: world_from_bowl is PoseMsg", |s| {
            let world_from_bowl = PoseMsg {
                orientation: [0.0; 4],
                ..PoseMsg::IDENTITY
            };
            s.stones = Some(StonesRecord {
                world_from_bowl,
                ..few_stones()
            });
        }),
        ("instrument length", |s| {
            if let Some(room) = &mut s.room {
                room.instrument_length_m = 0.0;
            }
        }),
    ];
    for (expected, break_it) in faults {
        let mut data = tiny_scene();
        break_it(&mut data);
        let error = data.to_bytes().unwrap_err().to_string();
        assert!(
            error.contains(expected),
            "expected '{expected}' in: {error}"
        );
    }
    let empty = SceneData {
        room: tiny_scene().room,
        ..SceneData::default()
    };
    assert!(matches!(
        empty.to_bytes(),
        Err(SceneError::Count { what: "organs", .. })
    ));
    assert!(matches!(
        SceneData::default().to_bytes(),
        Err(SceneError::MissingRoom)
    ));
}

#[test]
fn missing_foreign_old_and_damaged_files_are_told_apart() {
    let missing = SceneFile::open(std::path::Path::new("no-such.calot"));
    assert!(matches!(missing, Err(SceneError::Io { .. })));
    assert!(matches!(
        SceneFile::from_bytes(b"v 0 0 0\n"),
        Err(SceneError::NotAScene(_))
    ));
    let good = tiny_scene().to_bytes().unwrap();
    let mut old = good.clone();
    old[8] = 0;
    assert!(matches!(
        SceneFile::from_bytes(&old),
        Err(SceneError::Version { found: 0 })
    ));
    let mut damaged = good.clone();
    *damaged.last_mut().unwrap() ^= 1;
    assert!(matches!(
        SceneFile::from_bytes(&damaged),
        Err(SceneError::Identity)
    ));
    assert!(SceneFile::from_bytes(&good[..good.len() - 1]).is_err());
}

/// The mass of a sphere distinguishes the three levels.
#[test]
fn levels_of_detail_in_one_file_are_opened_by_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.calot");
    let level = |n: u8| {
        let mut scene = tiny_scene();
        scene.spheres[0].mass_kg = f32::from(n + 1);
        scene
    };
    let written: Vec<SceneData> = (0..3).map(level).collect();
    let finest = SceneData::write_levels(&written, &path).unwrap();
    assert_eq!(SceneFile::open(&path).unwrap().id(), finest);
    let found = SceneFile::levels(&path);
    assert_eq!(found.len(), 3);
    for (level, (found, written)) in found.iter().zip(&written).enumerate() {
        let scene = SceneFile::open(found).unwrap();
        assert_eq!(scene.spheres(), written.spheres, "{level}");
    }
    assert_eq!(SceneFile::levels(&found[1]), [found[1].clone()]);
    let beyond = folder.path().join("scene.calot#3");
    let refused = SceneFile::open(&beyond).unwrap_err().to_string();
    assert!(
        refused.contains("3 levels of detail, there is no level 3"),
        "{refused}"
    );

    // A file that does not consist of whole levels is refused as a whole.
    let whole = std::fs::read(&path).unwrap();
    for damaged in [
        whole[..whole.len() - 1].to_vec(),
        [whole.as_slice(), &[0; 64]].concat(),
        [whole.as_slice(), &[0; 3]].concat(),
    ] {
        std::fs::write(&path, damaged).unwrap();
        assert!(matches!(
            SceneFile::open(&path),
            Err(SceneError::NotAScene("wrong length"))
        ));
        assert_eq!(SceneFile::levels(&path).len(), 1);
    }
    assert!(SceneData::write_levels(&[], &path).is_err());
    assert!(SceneData::write_levels(&vec![tiny_scene(); 9], &path).is_err());
}

proptest! {
    /// Runs the fuzz target's body over damaged scenes, some of them cut short.
    #[test]
    fn hostile_bytes_never_panic(mut edits in prop::collection::vec((0usize..2000, any::<u8>()), 1..40),
                                 cut in prop::option::of(0usize..2000)) {
        let mut bytes = tiny_scene().to_bytes().unwrap();
        for (at, value) in edits.drain(..) {
            let at = at % bytes.len();
            bytes[at] = value;
        }
        bytes.truncate(cut.unwrap_or(bytes.len()));
        fuzz::scene_file(&bytes);
    }

    /// Opens damaged and cut files of several levels. Each level is refused or is intact.
    #[test]
    fn hostile_levels_never_panic(edits in prop::collection::vec((0usize..4000, any::<u8>()), 0..6),
                                  cut in prop::option::of(0usize..4000)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.calot");
        SceneData::write_levels(&[tiny_scene(), tiny_scene()], &path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        for (at, value) in edits {
            let at = at % bytes.len();
            bytes[at] = value;
        }
        bytes.truncate(cut.unwrap_or(bytes.len()));
        std::fs::write(&path, &bytes).unwrap();
        for level in SceneFile::levels(&path) {
            if let Ok(scene) = SceneFile::open(&level) {
                prop_assert_eq!(scene.spheres().len(), 4);
            }
        }
    }
}

/// A mistyped path (`--out liver.stl`, a device) destroys nothing and leaves no partial file.
#[test]
fn a_scene_replaces_only_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("liver.stl"), "solid liver, of many hours").unwrap();
    std::fs::create_dir(at("folder")).unwrap();
    std::os::unix::fs::symlink("/dev/null", at("device")).unwrap();
    for name in ["liver.stl", "folder", "device", "missing/x.calot"] {
        let refused = tiny_scene().write(&at(name)).unwrap_err().to_string();
        assert!(refused.contains(name), "{refused}");
        assert!(refused.contains("cannot be written"), "{refused}");
        assert!(refused.contains("name a new file"), "{refused}");
    }
    let kept = std::fs::read_to_string(at("liver.stl")).unwrap();
    assert_eq!(kept, "solid liver, of many hours");
    assert!(at("device").is_symlink());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
    std::fs::write(at("empty"), "").unwrap();
    tiny_scene().write(&at("empty")).unwrap();
    let mut other = tiny_scene();
    other.spheres[0].mass_kg *= 2.0;
    let id = other.write(&at("empty")).unwrap();
    assert_eq!(SceneFile::open(&at("empty")).unwrap().id(), id);
}

/// Reads the files that the fuzzer kept because they reached new code.
#[test]
fn the_corpus_is_read_or_refused() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/seeds/scene_file");
    let files = std::fs::read_dir(folder).unwrap();
    let count = files
        .map(|file| fuzz::scene_file(&std::fs::read(file.unwrap().path()).unwrap()))
        .count();
    assert!(count > 5, "{count} files");
}
