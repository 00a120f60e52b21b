//! Limits of the realtime process. A scene that exceeds one is refused when it loads; in the tick
//! they bound every loop.
//!
//! Five of them are also lengths of messages (`shared_mem::limits`). `border.rs` of `rt-process`
//! does not compile if the two differ.

/// Organs in a scene.
pub const MAX_ORGANS: usize = 16;
/// Spheres in a scene, all organs together.
pub const MAX_SPHERES: usize = 4096;
/// Links in a scene. The paper's liver has 3588 for 581 spheres (Table 1).
pub const MAX_LINKS: usize = 8 * MAX_SPHERES;
/// Batches of eight tetrahedra in a scene: Delaunay gives a sphere about five tetrahedra.
pub const MAX_BATCHES: usize = MAX_SPHERES;
/// Attachments between organs and to the world.
pub const MAX_ATTACHMENTS: usize = 1024;
/// Sutures in a scene that hang organs on the abdominal wall.
pub const MAX_SUTURES: usize = 8;
/// Capsules of all tools together.
pub const MAX_CAPSULES: usize = 16;
/// Spheres under a contact skin near tools that one tick keeps; the deepest stay. Both tools on
/// organs of the most spheres are near about 700.
pub const MAX_CONTACTS: usize = 1024;
/// Vertices of all contact skins together.
pub const MAX_SKIN_VERTICES: usize = 32_768;
/// Points along the instrument that are tested against the skin.
pub const INSTRUMENT_POINTS: usize = 64;
/// Points along all tools that are tested against the skin; the endoscope's follow the
/// instrument's.
pub const MAX_TOOL_POINTS: usize = INSTRUMENT_POINTS + 32;
/// Beads along organs without a contact skin.
pub const MAX_BEADS: usize = 4 * MAX_SPHERES;
/// Pairs of bead and tool part that are tracked from tick to tick.
pub const MAX_TUBE_CONTACTS: usize = 128;
/// Contact constraints of tools that one tick keeps; the deepest stay.
pub const MAX_CONTACT_CONSTRAINTS: usize = 64;
/// Pairs of unlinked spheres near each other; the first found stay.
pub const MAX_SPHERE_PAIRS: usize = 4096;
/// Pairs of those that may touch in a tick; the first found stay.
pub const MAX_CLOSE_PAIRS: usize = 1024;
/// Events that one tick can raise; further ones are counted and lost.
pub const MAX_EVENTS_PER_TICK: usize = 32;
/// Clips in the applier.
pub const CLIPS: u32 = 12;
/// Places of tubes on which clips can be, all clips together.
pub const MAX_CLIPPED: usize = 24;
/// Places where vessels, ducts and bags leak.
pub const MAX_HOLES: usize = 64;
/// Burnt places of walls that are tracked separately.
pub const MAX_SCORCHED: usize = 64;
/// Cells of layered tissue in a scene.
pub const MAX_CELLS: usize = 8192;
/// Spheres that a grasper can hold at once.
pub const MAX_GRASPED: usize = 64;

const _: () = assert!(
    MAX_SPHERES <= u16::MAX as usize + 1,
    "sphere indices are u16 in the skin binding"
);
