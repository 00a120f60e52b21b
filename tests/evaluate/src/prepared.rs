//! Organs, prepared by Calot. A recipe of one organ goes through the whole preparation. The result
//! is the scene that the realtime process loads.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use rt_core::scene::{Link, SkinVertex};
use scene_prepare::held::Plane;
use scene_prepare::mesh::Mesh;
use scene_prepare::recipe::{Closing, MeshOptions, Packing, Region, Unit};
use scene_prepare::skin::ContactSkin;
use scene_prepare::{Prepared, Recipe, prepare};
use shared_mem::scene::OrganKind;

use crate::body::{Body, Edge, Tissue};

/// Prepares a closed mesh as a body of `count` spheres, and its contact skin. Tissue beyond
/// `planes` is held.
///
/// # Errors
/// The reason in words.
pub(crate) fn prepared(
    mesh: &Mesh,
    count: usize,
    tissue: Tissue,
    planes: &[Plane],
) -> Result<(Body, ContactSkin), String> {
    prepared_as(OrganKind::Liver, mesh, count, tissue, planes)
}

/// Like [`prepared`], for an organ of this kind. Tubes become beads along a line.
///
/// # Errors
/// The reason in words.
pub(crate) fn prepared_as(
    kind: OrganKind,
    mesh: &Mesh,
    count: usize,
    tissue: Tissue,
    planes: &[Plane],
) -> Result<(Body, ContactSkin), String> {
    let file = MeshFile::new(mesh)?;
    let options = MeshOptions {
        kind,
        unit: Some(Unit::Metre),
        closing: Closing::Refuse,
        ..MeshOptions::default()
    };
    let mut recipe = Recipe::from_mesh(&file.0, &options).map_err(|e| e.to_string())?;
    let plan = &mut recipe.organs[0];
    plan.spheres = count;
    if is_tube(kind) {
        plan.packing = Packing::Line;
    }
    plan.material.retardation_s = tissue.retardation_s();
    plan.material.damping_per_s = tissue.damping_per_s();
    plan.material.young_pa = tissue.young_pa;
    plan.material.poisson = tissue.poisson;
    plan.material.density_kg_m3 = tissue.density_kg_m3;
    let region = |plane: &Plane| Region::Plane {
        point_m: plane.point_m.into(),
        normal: plane.normal.into(),
    };
    plan.held = planes.iter().map(region).collect();
    let made = prepare(&recipe, &mut |_| ()).map_err(|e| e.to_string())?;
    Ok((body(&made, tissue), skin(&made)))
}

/// True for organs that a recipe packs along their centre line by default.
fn is_tube(kind: OrganKind) -> bool {
    use OrganKind::{BileDuct, CysticArtery, CysticDuct, Vessel};
    matches!(kind, BileDuct | CysticArtery | CysticDuct | Vessel)
}

/// The spheres of a prepared organ, with their tetrahedra and springs.
fn body(made: &Prepared, tissue: Tissue) -> Body {
    let scene = &made.scene;
    let spheres = &scene.spheres;
    let centers: Vec<_> = spheres
        .iter()
        .map(|s| nalgebra::Vector3::from(s.center_m).cast::<f64>())
        .collect();
    let shares: Vec<f64> = spheres
        .iter()
        .map(|s| f64::from(s.mass_kg) / tissue.density_kg_m3)
        .collect();
    let tets: Vec<_> = made.tetrahedra[0]
        .iter()
        .map(|t| (t.spheres.map(|i| i as usize), t.volume_m3))
        .collect();
    let mut body = Body::new(&centers, &shares, &tets, tissue);
    body.radius_m = spheres.iter().map(|s| s.radius_m).collect();
    body.supported = spheres.iter().map(|s| s.held != 0).collect();
    body.substeps = scene.organs[0].substeps;
    // Springs of spheres that no tetrahedron joins.
    let springs = scene
        .links
        .iter()
        .take(scene.organs[0].elastic_links as usize);
    for link in springs {
        body.springs.push(Link {
            a: link.a,
            b: link.b,
            rest_length_m: link.rest_length_m,
            compliance_m_n: link.compliance_m_n,
        });
        body.edges.push(Edge {
            nodes: [link.a as usize, link.b as usize],
            length_m: link.rest_length_m,
            // This volume gives the edge the spring's stiffness.
            volume_m3: link.rest_length_m * link.rest_length_m
                / (15.0 * tissue.mu() as f32 * link.compliance_m_n),
        });
    }
    body
}

fn skin(made: &Prepared) -> ContactSkin {
    let scene = &made.scene;
    let vertices = scene.contact_vertices.iter().map(|v| SkinVertex {
        spheres: v.spheres,
        weights: v.weights,
        fan_start: v.fan[0],
        fan_count: v.fan[1],
        patch_m: v.patch_m,
        curvature_per_m: v.curvature_per_m,
    });
    ContactSkin {
        vertices: vertices.collect(),
        fans: scene.contact_fans.clone(),
        nearest: scene.contact_nearest.clone(),
    }
}

/// A mesh in a temporary file, which is removed on drop.
struct MeshFile(PathBuf);

impl MeshFile {
    fn new(mesh: &Mesh) -> Result<Self, String> {
        static NUMBER: AtomicUsize = AtomicUsize::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("calot-{}-{number}.obj", std::process::id());
        let file = Self(std::env::temp_dir().join(name));
        let mut text = String::new();
        for p in &mesh.vertices {
            text += &format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z);
        }
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|i| i + 1)) {
            text += &format!("f {a} {b} {c}\n");
        }
        std::fs::write(&file.0, text).map_err(|e| format!("{}: {e}", file.0.display()))?;
        Ok(file)
    }
}

impl Drop for MeshFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0); // it lies in the folder of temporary files
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::organ::Organ;

    /// Only the spheres on the plane and beyond it are held. Every sphere has an edge.
    #[test]
    fn an_organ_is_held_as_calot_holds_it() {
        let mesh = Organ::Liver.mesh().expect("built in");
        let axis = nalgebra::Vector3::z();
        let plane = Plane {
            point_m: axis * -0.02,
            normal: -axis,
        };
        let (body, skin) = prepared(&mesh, 200, Tissue::LIVER, &[plane]).expect("prepared");
        assert!(!skin.vertices.is_empty());
        let (mut on, mut joined) = (0, vec![false; body.rest_m.len()]);
        for (x, held) in body.rest_m.iter().zip(&body.supported) {
            assert_eq!(*held, x.z < -0.02 + 2e-6, "{x:?}");
            on += usize::from((x.z + 0.02).abs() < 1e-6);
        }
        assert!(on > 10, "{on} spheres on the plane");
        for edge in &body.edges {
            for n in edge.nodes {
                joined[n] = true;
            }
        }
        assert!(joined.iter().all(|joined| *joined));
        let mass: f32 = body.mass_kg.iter().sum();
        assert!((f64::from(mass) / (1060.0 * mesh.volume()) - 1.0).abs() < 1e-3);
    }
}
