//! Limits of the simulation. They bound every array and every loop of a tick.
//!
//! - Limits of a scene: `MAX_ORGANS`, `MAX_SPHERES`, `MAX_LINKS`, `MAX_BATCHES`, `MAX_ATTACHMENTS`,
//!   `MAX_SUTURES`, `MAX_SKIN_VERTICES`, `MAX_CELLS`, `MAX_STONES`. A scene that exceeds one is
//!   refused when it loads.
//! - Limits of a scene's tubes: `MAX_BEADS`, `MAX_TUBE_LINKS`. A scene may exceed them. A tube
//!   without room for its beads collides at its spheres only, carries no flow and takes no clip.
//!   Links beyond `MAX_TUBE_LINKS` are drawn as intact.
//! - Limits of a tick: `MAX_CONTACTS`, `INSTRUMENT_POINTS`, `MAX_TOOL_POINTS`, `MAX_TUBE_CONTACTS`,
//!   `MAX_CONTACT_CONSTRAINTS`, `MAX_SPHERE_PAIRS`, `MAX_CLOSE_PAIRS`, `MAX_EVENTS_PER_TICK`,
//!   `MAX_GRASPED`. A tick drops the excess and raises a fault. Only excess tool points raise none.
//! - Limits until the next reset: `MAX_HOLES`, `MAX_CLIPPED`, `MAX_SCORCHED`. Further leaks and
//!   clipped places are dropped. A further burnt place replaces the least burnt one.
//! - `MAX_CAPSULES` is never reached: both tools together have four capsules at most.
//! - `CLIPS` is the number of clips that the applier holds.
//! - `TROCAR_FRICTION_MAX_N` and `TROCAR_WALL_MAX_NM_RAD` bound the friction and the elasticity of
//!   the port that a scene may ask for.
//!
//! Nine of the limits are also limits of messages and files (`shared_mem::limits`).
//! `border.rs` of `rt-process` does not compile if one of them differs.

/// Organs in a scene.
pub const MAX_ORGANS: usize = 16;
/// Spheres in a scene, all organs together.
pub const MAX_SPHERES: usize = 4096;
/// Links in a scene. The liver of the inner-sphere paper has 3588 links for 581 spheres (its Table
/// 1).
pub const MAX_LINKS: usize = 8 * MAX_SPHERES;
/// Batches of eight tetrahedra in a scene. A Delaunay mesh has about five tetrahedra a sphere.
pub const MAX_BATCHES: usize = MAX_SPHERES;
/// Attachments between organs and to the world.
pub const MAX_ATTACHMENTS: usize = 1024;
/// Sutures in a scene that hang organs on the abdominal wall.
pub const MAX_SUTURES: usize = 8;
/// Capsules of all tools together.
pub const MAX_CAPSULES: usize = 16;
/// Spheres under a contact skin that are near a tool in a tick; if there are more, the deepest are
/// kept. With both tools on the organs that have the most spheres, about 700 are near.
pub const MAX_CONTACTS: usize = 1024;
/// Vertices of all contact skins together.
pub const MAX_SKIN_VERTICES: usize = 32_768;
/// Points along the instrument that are tested against the skin.
pub const INSTRUMENT_POINTS: usize = 64;
/// Points along all tools that are tested against the skin: first the instrument's, then the
/// endoscope's.
pub const MAX_TOOL_POINTS: usize = INSTRUMENT_POINTS + 32;
/// Beads along organs without a contact skin.
pub const MAX_BEADS: usize = 4 * MAX_SPHERES;
/// Pairs of bead and tool part that are tracked from tick to tick.
pub const MAX_TUBE_CONTACTS: usize = 128;
/// Contact constraints of tools in a tick; if there are more, the deepest are kept.
pub const MAX_CONTACT_CONSTRAINTS: usize = 64;
/// Pairs of unlinked spheres near each other; if there are more, the pairs that were found first
/// are kept.
pub const MAX_SPHERE_PAIRS: usize = 4096;
/// Pairs of unlinked spheres that may touch in a tick; if there are more, the pairs that were found
/// first are kept.
pub const MAX_CLOSE_PAIRS: usize = 1024;
/// Events that one tick can raise; further events are dropped, and a fault counts the tick.
pub const MAX_EVENTS_PER_TICK: usize = 32;
/// Clips in the applier.
pub const CLIPS: u32 = 12;
/// Places on tubes that clips close, all clips together; a clip over two tubes takes two.
pub const MAX_CLIPPED: usize = 24;
/// Links of tubes whose state is published: the first ones in the scene. Later links are drawn as
/// intact.
pub const MAX_TUBE_LINKS: usize = 2048;
/// Places where vessels, ducts and bags leak.
pub const MAX_HOLES: usize = 64;
/// Burnt places of walls that are tracked separately.
pub const MAX_SCORCHED: usize = 64;
/// Stones in the gallbladder.
pub const MAX_STONES: usize = 30;
/// Cells of layered tissue in a scene.
pub const MAX_CELLS: usize = 8192;
/// Spheres that a grasper can hold at once.
pub const MAX_GRASPED: usize = 64;

/// Largest friction that a scene may ask for, N: the largest that was measured in trocars of 12 mm
/// (Alazmani and others 2015, doi:10.1177/0954411915576769, 0.25 to 8 N).
pub const TROCAR_FRICTION_MAX_N: f32 = 8.0;
/// Largest elasticity of the wall that a scene may ask for, N m/rad. Assumed.
pub const TROCAR_WALL_MAX_NM_RAD: f32 = 2.0;

const _: () = assert!(
    MAX_SPHERES <= u16::MAX as usize + 1,
    "sphere indices are u16 in the skin binding"
);
