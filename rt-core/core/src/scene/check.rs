//! Validation of a scene: the conditions on which the tick relies.

use core::fmt;

use crate::capacity::{
    MAX_ATTACHMENTS, MAX_BATCHES, MAX_LINKS, MAX_ORGANS, MAX_SPHERES, MAX_SUTURES,
    TROCAR_FRICTION_MAX_N, TROCAR_WALL_MAX_NM_RAD,
};
use crate::math::{self, Pose, Vec3};
use crate::scene::{
    Anchor, Attachment, Layers, Link, Material, Organ, RestSphere, Room, SUBSTEPS_MAX, Scene, Skin,
    Stones, TetraBatch, Trocar, is_suture,
};

/// Reason why a scene is refused. Indices refer to the caller's arrays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SceneError {
    /// More of `what` than [`crate::capacity`] allows.
    TooMany {
        /// Name of the items, such as spheres.
        what: &'static str,
        /// Number in the scene.
        count: usize,
        /// Largest number.
        limit: usize,
    },
    /// An organ's range ends beyond the scene's items, or does not follow the range before it.
    Range {
        /// The organ.
        organ: usize,
        /// Name of the items: spheres, links or batches.
        what: &'static str,
        /// First item of the range.
        start: u32,
        /// Number of items in the range.
        count: u32,
        /// Start that the range should have.
        expected_start: usize,
        /// Number in the scene.
        available: usize,
    },
    /// A value is not finite or out of its range.
    Value {
        /// Name of the value.
        what: &'static str,
        /// Index of the item that has the value; 0 for the room.
        index: usize,
        /// The value.
        value: f32,
        /// Allowed range.
        allowed: &'static str,
    },
    /// A link joins a sphere of another organ, or a sphere with itself.
    Link {
        /// The link.
        link: usize,
        /// Its spheres.
        spheres: [u32; 2],
        /// First sphere of the organ.
        first: u32,
        /// One past the organ's last sphere.
        end: u32,
    },
    /// An item names a sphere, vertex or cell that does not exist or that it may not name.
    Foreign {
        /// Name of the item, such as attachment.
        what: &'static str,
        /// Its index.
        index: usize,
        /// Index of the sphere, vertex or cell.
        sphere: u32,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooMany { what, count, limit } => write!(
                f,
                "scene has {count} {what}, the limit is {limit}: prepare it with fewer spheres"
            ),
            Self::Range {
                organ,
                what,
                start,
                count,
                expected_start,
                available,
            } => write!(
                f,
                "organ {organ}: {what} (start {start}, count {count}) should start at {expected_start} \
                 and end within {available}: prepare the scene again"
            ),
            Self::Value {
                what,
                index,
                value,
                allowed,
            } => write!(
                f,
                "{what} (index {index}) is {value}, allowed is {allowed}: correct the recipe \
                 and prepare the scene again"
            ),
            Self::Link {
                link,
                spheres: [a, b],
                first,
                end,
            } => write!(
                f,
                "link {link} joins spheres {a} and {b}, but its organ has {first}..{end}: \
                 prepare the scene again"
            ),
            Self::Foreign {
                what,
                index,
                sphere,
            } => write!(
                f,
                "{what} {index} names index {sphere}, which does not exist or is not of its organ: \
                 prepare the scene again"
            ),
        }
    }
}

impl core::error::Error for SceneError {}

impl<'a> Scene<'a> {
    /// Checks every condition on which the tick relies: counts within [`crate::capacity`], ranges
    /// that partition the arrays in order, values within their ranges, links within their organ.
    ///
    /// # Errors
    /// The first violation, with its place, value and allowed range.
    pub fn new(
        organs: &'a [Organ],
        spheres: &'a [RestSphere],
        links: &'a [Link],
        room: Room,
    ) -> Result<Self, SceneError> {
        at_most("organs", organs.len(), MAX_ORGANS)?;
        at_most("spheres", spheres.len(), MAX_SPHERES)?;
        at_most("links", links.len(), MAX_LINKS)?;
        check_room(&room)?;
        for (i, sphere) in spheres.iter().enumerate() {
            check_sphere(i, sphere)?;
        }
        let (mut next_sphere, mut next_link) = (0, 0);
        for (i, organ) in organs.iter().enumerate() {
            check_organ(i, organ)?;
            let (start, count) = (organ.sphere_start, organ.sphere_count);
            next_sphere = check_range(i, "spheres", start, count, next_sphere, spheres.len())?;
            let (start, count) = (organ.link_start, organ.link_count);
            let first_link = next_link;
            next_link = check_range(i, "links", start, count, next_link, links.len())?;
            for (j, link) in links.iter().enumerate().take(next_link).skip(first_link) {
                check_link(j, link, organ)?;
            }
        }
        let check_end = |what, used: usize, available: usize| {
            let organ = organs.len();
            let rest = (available - used) as u32;
            check_range(organ, what, available as u32, rest, used, available).map(|_| ())
        };
        if next_sphere != spheres.len() {
            check_end("spheres", next_sphere, spheres.len())?;
        }
        if next_link != links.len() {
            check_end("links", next_link, links.len())?;
        }
        Ok(Self {
            organs,
            spheres,
            links,
            batches: &[],
            attachments: &[],
            skin: Skin::default(),
            layers: Layers::default(),
            stones: Stones::NONE,
            room,
        })
    }

    /// Adds the organs' tetrahedra, in batches made by [`crate::scene::batches`], organ by organ.
    ///
    /// # Errors
    /// If there are too many, the organs' ranges do not partition them, or a batch names a sphere
    /// of another organ.
    pub fn with_tetrahedra(mut self, batches: &'a [TetraBatch]) -> Result<Self, SceneError> {
        at_most("batches of tetrahedra", batches.len(), MAX_BATCHES)?;
        let (what, mut next) = ("batches of tetrahedra", 0);
        for (i, organ) in self.organs.iter().enumerate() {
            let first = next;
            next = check_range(
                i,
                what,
                organ.batch_start,
                organ.batch_count,
                next,
                batches.len(),
            )?;
            let own = organ.sphere_start..organ.sphere_start + organ.sphere_count;
            for (index, batch) in batches.iter().enumerate().take(next).skip(first) {
                let mut corners = batch.spheres.as_flattened().iter().map(|&s| u32::from(s));
                if let Some(sphere) = corners.find(|sphere| !own.contains(sphere)) {
                    let what = "batch of tetrahedra";
                    return Err(SceneError::Foreign {
                        what,
                        index,
                        sphere,
                    });
                }
            }
        }
        if next != batches.len() {
            let rest = (batches.len() - next) as u32;
            let start = batches.len() as u32;
            check_range(self.organs.len(), what, start, rest, next, batches.len())?;
        }
        self.batches = batches;
        Ok(self)
    }

    /// Adds attachments between organs and to the world.
    ///
    /// # Errors
    /// If there are too many, one names a sphere that does not exist or joins a sphere to itself,
    /// or a value is out of range.
    pub fn with_attachments(mut self, attachments: &'a [Attachment]) -> Result<Self, SceneError> {
        at_most("attachments", attachments.len(), MAX_ATTACHMENTS)?;
        let sutures = attachments.iter().filter(|it| is_suture(it)).count();
        at_most("sutures to the world", sutures, MAX_SUTURES)?;
        for (i, attachment) in attachments.iter().enumerate() {
            check_attachment(i, attachment, self.spheres.len())?;
        }
        self.attachments = attachments;
        Ok(self)
    }
}

fn check_attachment(i: usize, it: &Attachment, spheres: usize) -> Result<(), SceneError> {
    let foreign = |sphere| SceneError::Foreign {
        what: "attachment",
        index: i,
        sphere,
    };
    if it.sphere as usize >= spheres {
        return Err(foreign(it.sphere));
    }
    match it.to {
        Anchor::Sphere(other) if other as usize >= spheres || other == it.sphere => {
            return Err(foreign(other));
        }
        Anchor::Sphere(_) => {}
        Anchor::World(at_m) => check_position("anchor", i, &at_m)?,
    }
    in_range("rest length", i, it.rest_length_m, (0.0, 10.0), "0 to 10 m")?;
    in_range("tear energy", i, it.tear_j, (0.0, 1.0e3), "0 to 1000 J")?;
    check_compliance(i, it.compliance_m_n)
}

fn check_compliance(i: usize, compliance_m_n: f32) -> Result<(), SceneError> {
    in_range(
        "compliance",
        i,
        compliance_m_n,
        (0.0, 1.0e6),
        "0 to 1e6 m/N",
    )
}

fn check_organ(i: usize, organ: &Organ) -> Result<(), SceneError> {
    check_material(i, &organ.material)?;
    // The next allowed value: a power of two from 1 to 16. It equals `substeps` only if `substeps`
    // is allowed.
    let allowed = organ.substeps.clamp(1, SUBSTEPS_MAX).next_power_of_two() as f32;
    let substeps = organ.substeps as f32;
    in_range(
        "substeps",
        i,
        substeps,
        (allowed, allowed),
        "1, 2, 4, 8 or 16",
    )?;
    let elastic = organ.elastic_links as f32;
    let links = (0.0, organ.link_count as f32);
    in_range("elastic links", i, elastic, links, "0 to the organ's links")?;
    in_range(
        "gravity share",
        i,
        organ.gravity_share,
        (0.0, 1.0),
        "0 to 1",
    )?;
    for &breath in &organ.breath_m {
        in_range("breath", i, breath, (-0.1, 0.1), "-0.1 to 0.1 m")?;
    }
    Ok(())
}

fn at_most(what: &'static str, count: usize, limit: usize) -> Result<(), SceneError> {
    if count > limit {
        Err(SceneError::TooMany { what, count, limit })
    } else {
        Ok(())
    }
}

/// End of this range, which must start where the last range ended.
fn check_range(
    organ: usize,
    what: &'static str,
    start: u32,
    count: u32,
    expected_start: usize,
    available: usize,
) -> Result<usize, SceneError> {
    let end = start as usize + count as usize;
    if start as usize == expected_start && end <= available {
        Ok(end)
    } else {
        Err(SceneError::Range {
            organ,
            what,
            start,
            count,
            expected_start,
            available,
        })
    }
}

fn in_range(
    what: &'static str,
    index: usize,
    value: f32,
    (low, high): (f32, f32),
    allowed: &'static str,
) -> Result<(), SceneError> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(SceneError::Value {
            what,
            index,
            value,
            allowed,
        })
    }
}

fn check_position(what: &'static str, index: usize, v: &Vec3) -> Result<(), SceneError> {
    v.iter()
        .try_for_each(|&x| in_range(what, index, x, (-10.0, 10.0), "-10 to 10 m"))
}

pub(super) fn check_pose(what: &'static str, pose: &Pose) -> Result<(), SceneError> {
    check_position(what, 0, &pose.translation.vector)?;
    if math::is_rigid(pose) {
        Ok(())
    } else {
        let value = pose.rotation.coords.norm_squared();
        Err(SceneError::Value {
            what,
            index: 0,
            value,
            allowed: "a unit quaternion",
        })
    }
}

fn check_room(room: &Room) -> Result<(), SceneError> {
    for &g in &room.gravity_m_s2 {
        in_range("gravity", 0, g, (-100.0, 100.0), "-100 to 100 m/s^2")?;
    }
    check_pose("world_from_device", &room.world_from_device)?;
    check_pose("world_from_tracker", &room.world_from_tracker)?;
    check_pose("world_from_camera", &room.world_from_camera)?;
    check_position("instrument port", 0, &room.instrument_port_m)?;
    check_position("endoscope port", 0, &room.endoscope_port_m)?;
    in_range("breath", 0, room.breath_s, (0.0, 60.0), "0 to 60 s")?;
    check_trocar(&room.trocar)?;
    in_range(
        "instrument length",
        0,
        room.instrument_length_m,
        (0.05, 1.0),
        "0.05 to 1 m",
    )
}

fn check_trocar(trocar: &Trocar) -> Result<(), SceneError> {
    let (sliding_n, breakaway_n) = (trocar.sliding_n, trocar.breakaway_n);
    let most = (0.0, TROCAR_FRICTION_MAX_N);
    in_range("trocar's sliding friction", 0, sliding_n, most, "0 to 8 N")?;
    let most = (sliding_n, TROCAR_FRICTION_MAX_N);
    let allowed = "the sliding friction to 8 N";
    in_range(
        "trocar's break-away friction",
        0,
        breakaway_n,
        most,
        allowed,
    )?;
    let most = (0.0, TROCAR_WALL_MAX_NM_RAD);
    in_range(
        "trocar's wall",
        0,
        trocar.wall_nm_rad,
        most,
        "0 to 2 N m/rad",
    )?;
    let length = math::norm(&trocar.axis);
    let least = if trocar.wall_nm_rad > 0.0 { 0.999 } else { 0.0 };
    let allowed = "1 (a unit vector), or 0 without a wall";
    in_range(
        "length of the trocar's axis",
        0,
        length,
        (least, 1.001),
        allowed,
    )
}

fn check_sphere(i: usize, sphere: &RestSphere) -> Result<(), SceneError> {
    check_position("sphere centre", i, &sphere.center_m)?;
    in_range(
        "sphere radius",
        i,
        sphere.radius_m,
        (1.0e-5, 1.0),
        "0.01 mm to 1 m",
    )?;
    in_range(
        "sphere mass",
        i,
        sphere.mass_kg,
        (1.0e-9, 100.0),
        "1e-9 to 100 kg",
    )
}

fn check_material(i: usize, material: &Material) -> Result<(), SceneError> {
    in_range(
        "Young's modulus",
        i,
        material.young_pa,
        (0.0, 1.0e9),
        "0 to 1e9 Pa",
    )?;
    in_range(
        "Poisson's ratio",
        i,
        material.poisson,
        (0.0, 0.4999),
        "0 to 0.4999",
    )?;
    in_range(
        "retardation",
        i,
        material.retardation_s,
        (0.0, 1.0),
        "0 to 1 s",
    )?;
    in_range(
        "stretch stiffness",
        i,
        material.stretch_stiffness,
        (0.0, 1.0),
        "0 to 1",
    )?;
    in_range(
        "laplacian stiffness",
        i,
        material.laplacian_stiffness,
        (0.0, 1.0),
        "0 to 1",
    )?;
    in_range(
        "damping",
        i,
        material.damping_per_s,
        (0.0, 1000.0),
        "0 to 1000 per s",
    )?;
    let contact = material.contact_stiffness_n_m;
    in_range(
        "contact stiffness",
        i,
        contact,
        (0.0, 1.0e6),
        "0 to 1e6 N/m",
    )?;
    in_range("friction", i, material.friction, (0.0, 2.0), "0 to 2")?;
    in_range(
        "toughness",
        i,
        material.toughness_j_m2,
        (0.0, 1.0e6),
        "0 to 1e6 J/m2",
    )
}

fn check_link(j: usize, link: &Link, organ: &Organ) -> Result<(), SceneError> {
    let (first, end) = (organ.sphere_start, organ.sphere_start + organ.sphere_count);
    let own = first..end;
    if !own.contains(&link.a) || !own.contains(&link.b) || link.a == link.b {
        return Err(SceneError::Link {
            link: j,
            spheres: [link.a, link.b],
            first,
            end,
        });
    }
    in_range(
        "rest length",
        j,
        link.rest_length_m,
        (1.0e-6, 10.0),
        "1 um to 10 m",
    )?;
    check_compliance(j, link.compliance_m_n)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scene::tests::{organ, room, sphere};
    use std::string::ToString;

    const LINK: Link = Link {
        a: 0,
        b: 1,
        rest_length_m: 0.01,
        compliance_m_n: 0.0,
    };

    fn two() -> [RestSphere; 2] {
        [sphere(Vec3::zeros(), 0.01), sphere(Vec3::x() * 0.01, 0.01)]
    }

    #[test]
    fn valid_scene_and_empty_scene_are_accepted() {
        assert!(Scene::new(&[organ(0, 2, 0, 1)], &two(), &[LINK], room()).is_ok());
        assert!(Scene::new(&[], &[], &[], room()).is_ok());
    }

    #[test]
    fn every_refusal_names_place_and_value() {
        let good = organ(0, 2, 0, 1);
        let refused = |organs: &[Organ], spheres: &[RestSphere], links: &[Link], word: &str| {
            let error = Scene::new(organs, spheres, links, room()).unwrap_err();
            assert!(error.to_string().contains(word), "{error}");
        };
        refused(&[good; MAX_ORGANS + 1], &two(), &[LINK], "17 organs");
        refused(&[organ(1, 1, 0, 0)], &two(), &[], "should start at 0");
        refused(&[organ(0, 3, 0, 0)], &two(), &[], "end within 2");
        refused(&[organ(0, u32::MAX, 0, 0)], &two(), &[], "end within 2");
        refused(&[organ(0, 1, 0, 0)], &two(), &[], "should start at 1");
        refused(
            &[organ(0, 2, 0, 0)],
            &two(),
            &[LINK],
            "links (start 1, count 1) should start at 0",
        );
        refused(&[good], &two(), &[Link { b: 2, ..LINK }], "spheres 0 and 2");
        refused(&[good], &two(), &[Link { b: 0, ..LINK }], "spheres 0 and 0");
        refused(
            &[good],
            &two(),
            &[Link {
                rest_length_m: 0.0,
                ..LINK
            }],
            "rest length",
        );
        for (change, word) in [
            (
                RestSphere {
                    mass_kg: 0.0,
                    ..two()[1]
                },
                "sphere mass (index 1) is 0",
            ),
            (
                RestSphere {
                    radius_m: f32::NAN,
                    ..two()[1]
                },
                "radius (index 1) is NaN",
            ),
            (
                RestSphere {
                    center_m: Vec3::x() * 1.0e9,
                    ..two()[1]
                },
                "centre (index 1)",
            ),
        ] {
            refused(&[good], &[two()[0], change], &[LINK], word);
        }
        let mut stiff = good;
        stiff.material.stretch_stiffness = 1.5;
        refused(
            &[stiff],
            &two(),
            &[LINK],
            "stretch stiffness (index 0) is 1.5",
        );
    }

    #[test]
    fn invalid_room_is_refused() {
        let refused = |room: Room| Scene::new(&[], &[], &[], room).is_err();
        let trocar = |sliding_n: f32, breakaway_n: f32, wall_nm_rad: f32, length: f32| {
            let trocar = Trocar {
                sliding_n,
                breakaway_n,
                wall_nm_rad,
                axis: Vec3::x() * length,
            };
            let error = Scene::new(&[], &[], &[], Room { trocar, ..room() });
            error.map_or_else(|error| error.to_string(), |_| std::string::String::new())
        };
        assert_eq!(trocar(1.0, 2.0, 0.3, 1.0), "");
        for (made, words) in [
            (trocar(9.0, 9.0, 0.0, 0.0), "trocar's sliding friction"),
            (trocar(2.0, 1.0, 0.0, 0.0), "trocar's break-away friction"),
            (trocar(0.0, 0.0, f32::NAN, 1.0), "trocar's wall"),
            (trocar(0.0, 0.0, 0.3, 0.5), "length of the trocar's axis"),
        ] {
            assert!(made.contains(words), "{words}: {made}");
        }
        assert!(refused(Room {
            instrument_length_m: f32::INFINITY,
            ..room()
        }));
        assert!(refused(Room {
            gravity_m_s2: Vec3::repeat(f32::NAN),
            ..room()
        }));
        let mut crooked = room();
        crooked.world_from_device.rotation.as_mut_unchecked().coords *= 2.0;
        assert!(refused(crooked));
    }
}
