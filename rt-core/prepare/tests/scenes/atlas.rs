//! Tests with meshes of real organs. A machine without the meshes skips them.

use scene_prepare::mesh::mend;
use scene_prepare::pack::{Interior, Quality, pack_as_paper, pack_evenly};
use scene_prepare::recipe::Closing;
use scene_prepare::{Recipe, prepare};
use std::path::{Path, PathBuf};

use crate::sound::check;

/// The folder of the meshes, if this machine has it.
fn anatomy() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/anatomy");
    let folder = std::env::var_os("CALOT_ANATOMY").map_or(beside, PathBuf::from);
    if folder.join("hra-female").is_dir() {
        return Some(folder);
    }
    println!(
        "skipped: no anatomy in {}; set CALOT_ANATOMY to its folder",
        folder.display()
    );
    None
}

#[test]
fn atlas_scene_is_sound() {
    let Some(folder) = anatomy() else { return };
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/hra-female.toml");
    let recipe = Recipe::load(&recipe, Some(&folder.join("hra-female"))).unwrap();
    let prepared = prepare(&recipe, &mut |_| {}).unwrap();
    check(&prepared);
    assert!(
        prepared.report.organs[0]
            .mesh
            .contains("1 open loops closed")
    );
}

/// The left end and the margin of a real liver are thin for 250 spheres.
#[test]
fn thin_parts_of_the_atlas_liver_are_warned_of() {
    let Some(folder) = anatomy() else { return };
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/hra-female.toml");
    let recipe = Recipe::load(&recipe, Some(&folder.join("hra-female"))).unwrap();
    let report = prepare(&recipe.with_spheres(250).unwrap(), &mut |_| {})
        .unwrap()
        .report;
    println!("{report}");
    let is_warned = |it: &String| it.starts_with("'liver' has thin parts");
    assert!(
        report.warnings.iter().any(is_warned),
        "{:?}",
        report.warnings
    );
}

/// Open-ended ducts, an artery with branches, and the liver as 26 patches are prepared.
#[test]
fn atlas_tubes_and_patches_prepare() {
    let Some(folder) = anatomy() else { return };
    let organ = |name: &str, kind: &str, file: &str, part: &str, spheres: usize| {
        format!(
            "[[organ]]\nname = \"{name}\"\nkind = \"{kind}\"\nmesh = \"{file}\"\nparts = [\"{part}\"]\nspheres = {spheres}\nheld = [{{ base = 0.2 }}]\n"
        )
    };
    let text = [
        "name = \"atlas\"\n[room.target]\norgan = \"liver\"\n".to_owned(),
        organ(
            "liver",
            "liver",
            "VH_F_Liver.glb",
            "VH_F_capsule_of_the_liver",
            300,
        ),
        organ(
            "gallbladder",
            "gallbladder",
            "VH_F_Gallbladder.glb",
            "VH_F_gallbladder",
            100,
        ),
        organ(
            "cystic duct",
            "cystic-duct",
            "VH_F_Biliary_Tree.glb",
            "VH_F_cystic_duct",
            20,
        ),
        organ(
            "bile duct",
            "bile-duct",
            "VH_F_Biliary_Tree.glb",
            "VH_F_common_bile_duct",
            30,
        ),
        organ(
            "hepatic duct",
            "bile-duct",
            "VH_F_Biliary_Tree.glb",
            "VH_F_common_hepatic_duct",
            10,
        ),
        organ(
            "cystic artery",
            "cystic-artery",
            "VH_F_Blood_Vasculature_Gallbladder.glb",
            "VH_F_cystic_artery",
            40,
        ),
    ]
    .concat();
    let recipe = Recipe::parse(&text, "atlas", &folder.join("hra-female")).unwrap();
    let prepared = prepare(&recipe, &mut |_| {}).unwrap();
    println!("{}", prepared.report);
    for report in &prepared.report.organs {
        assert_eq!(report.components, 1, "{}", report.name);
        assert!(
            report.min_degree >= 3 && report.spheres >= 8,
            "{}: {report:?}",
            report.name
        );
    }
    // In the atlas the ducts are hollow walls. The volume that they enclose counts.
    for (name, low_ml, high_ml) in [("cystic duct", 0.03, 0.06), ("bile duct", 0.12, 0.19)] {
        let report = prepared
            .report
            .organs
            .iter()
            .find(|o| o.name == name)
            .unwrap();
        assert!(
            (low_ml..high_ml).contains(&report.volume_ml),
            "{name}: {}",
            report.volume_ml
        );
    }
    let patches = "VH_F_liver";
    let mesh =
        scene_prepare::mesh::read(&folder.join("hra-female/VH_F_Liver.glb"), &[patches.into()]);
    let solid = mend(&mesh.unwrap(), Closing::Solid).unwrap();
    println!("26 patches: {solid}, {} mL", solid.volume_m3 * 1e6);
    assert!(
        (1.8e-3..2.2e-3).contains(&solid.volume_m3),
        "{}",
        solid.volume_m3
    );
}

#[test]
fn paper_meshes_of_table_1_prepare_with_both_packings() {
    let Some(folder) = anatomy() else { return };
    for (file, spheres) in [("liver_8128.obj", 581), ("gallbladder_1461.obj", 475)] {
        let mesh = scene_prepare::mesh::read(&folder.join("derived").join(file), &[]).unwrap();
        let mended = mend(&mesh, Closing::Auto).unwrap();
        let interior = Interior::new(&mended.mesh, mended.volume_m3, spheres).unwrap();
        for balls in [
            pack_evenly(&interior, spheres),
            pack_as_paper(&interior, spheres),
        ] {
            let quality = Quality::measure(&interior, &mended.mesh, &balls);
            println!("{file}: {} spheres, {quality:?}", balls.len());
            assert!(balls.len() > spheres * 9 / 10);
            assert!(
                quality.coverage > 0.8 && quality.protrusion_max_m < 1e-4,
                "{quality:?}"
            );
        }
    }
}
