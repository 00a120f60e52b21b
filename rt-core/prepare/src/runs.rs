//! Checks that the realtime process will accept the scene. The realtime process checks more than
//! the file's reader.

use rt_core::scene::SceneError;
use scene_load::{Records, SceneStorage};
use shared_mem::scene::{SceneData, SceneError as FileError};

use crate::error::PrepareError;
use crate::mesh::Mesh;
use crate::recipe::OrganPlan;

/// Refuses a scene that the realtime process would refuse. `skins` are the skins of the `organs`.
pub(crate) fn check(
    scene: &SceneData,
    organs: &[OrganPlan],
    skins: &[Mesh],
) -> Result<(), PrepareError> {
    let records = Records::of_data(scene).ok_or(PrepareError::Scene(FileError::MissingRoom))?;
    let loaded = SceneStorage::new(records);
    let Err(error) = loaded.and_then(|loaded| loaded.scene().map(|_| ())) else {
        return Ok(());
    };
    if let SceneError::TooMany { what, count, limit } = error {
        let (found, min, max) = (count, 0, limit);
        return Err(PrepareError::Scene(FileError::Count {
            what,
            found,
            min,
            max,
        }));
    }
    let Some((plan, skin)) = organ_of(&error, scene).and_then(|i| organs.get(i).zip(skins.get(i)))
    else {
        return Err(PrepareError::Refused(error));
    };
    let [low, high] = skin.bounds();
    let problem = format!(
        "the realtime process would refuse it: {error}; the organ is {:.1} mm across: check its unit, or \
         give it fewer spheres",
        1e3 * (high - low).max()
    );
    Err(PrepareError::Organ {
        organ: plan.name.clone(),
        problem,
    })
}

/// The organ that an error concerns, if the error says so.
fn organ_of(error: &SceneError, scene: &SceneData) -> Option<usize> {
    let of_sphere = |sphere: u32| {
        let mut organs = scene.organs.iter();
        organs.position(|it| (it.spheres[0]..it.spheres[0] + it.spheres[1]).contains(&sphere))
    };
    let of_vertex = |index: usize| {
        let vertex = scene.contact_vertices.get(index)?;
        of_sphere(u32::from(vertex.spheres[0]))
    };
    match *error {
        SceneError::Range { organ, .. } => Some(organ),
        SceneError::Link { first, .. } => of_sphere(first),
        SceneError::Value { what, index, .. } => match what {
            "sphere centre" | "sphere radius" | "sphere mass" => of_sphere(index as u32),
            "vertex of the contact skin" => of_vertex(index),
            "Young's modulus" | "Poisson's ratio" | "retardation" | "damping" | "friction"
            | "toughness" | "substeps" | "gravity share" => Some(index),
            _ => None,
        },
        SceneError::Foreign { what, index, .. } => match what {
            "nearest vertex" => of_sphere(index as u32),
            "vertex of the contact skin" | "triangle of the contact skin" => of_vertex(index),
            _ => None,
        },
        SceneError::TooMany { .. } => None,
    }
}
