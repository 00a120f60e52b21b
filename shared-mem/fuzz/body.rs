//! Body of the fuzz target. The reader may refuse any bytes, but it must never panic.

use shared_mem::scene::{NO_CELL, SceneFile};

/// Reads the bytes as they are. Then reads them again with a correct hash in the header, as a
/// forger would write it: now only the checks of the content can find a fault. In an accepted scene
/// every index must be inside its list.
pub(crate) fn scene_file(bytes: &[u8]) {
    let _ = SceneFile::from_bytes(bytes);
    let mut sealed = bytes.to_vec();
    if sealed.len() < 64 {
        return;
    }
    let identity = *blake3::hash(&sealed[64..]).as_bytes();
    sealed[16..48].copy_from_slice(&identity);
    let Ok(scene) = SceneFile::from_bytes(&sealed) else {
        return;
    };
    let spheres = scene.spheres().len();
    assert!(!scene.name().is_empty() || scene.room().name[0] == 0);
    for link in scene.links() {
        assert!((link.a as usize) < spheres && (link.b as usize) < spheres);
    }
    for t in scene.tetrahedra() {
        assert!(t.spheres.iter().all(|&i| usize::from(i) < spheres));
    }
    for v in scene.vertices() {
        assert!(v.spheres.iter().all(|&i| usize::from(i) < spheres));
    }
    for t in scene.triangles() {
        assert!(t.iter().all(|&v| (v as usize) < scene.vertices().len()));
    }
    for attachment in scene.attachments() {
        assert!((attachment.a as usize) < spheres);
    }
    for cell in scene.cells() {
        let corners = scene.cell_corners().len();
        assert!(cell.corners.iter().all(|&c| usize::from(c) < corners));
        assert!(cell.spheres.iter().all(|&i| usize::from(i) < spheres));
        let exists = |&n: &u16| n == NO_CELL || usize::from(n) < scene.cells().len();
        assert!(cell.neighbours.iter().all(exists));
    }
    for column in scene.cell_columns() {
        let exists = |&n: &u16| n == NO_CELL || usize::from(n) < scene.cells().len();
        assert!(column.cells.iter().all(exists));
    }
    let contact = scene.contact_vertices().len();
    for v in scene.contact_vertices() {
        let [first, n] = v.fan.map(|n| n as usize);
        assert!(first + n <= scene.contact_fans().len());
        assert!(v.spheres.iter().all(|&i| usize::from(i) < spheres));
    }
    for corner in scene.contact_fans().as_flattened() {
        assert!(usize::from(*corner) < contact);
    }
}
