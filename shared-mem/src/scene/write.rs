//! Writing a compiled scene.

use std::io::Read;
use std::path::Path;

use bytemuck::Pod;

use super::error::SceneError;
use super::file::SceneFile;
use super::header::{
    ALIGN, HEADER_BYTES, Header, SECTIONS, SECTIONS_MIN, SECTIONS_WITH_TROCAR, Section, head_bytes,
};
use super::{
    AttachmentRecord, CellColumnRecord, CellRecord, ContactVertexRecord, LAYOUT_VERSION,
    LinkRecord, MAGIC, OrganRecord, RoomRecord, SceneId, SphereRecord, StonesRecord, TetraRecord,
    TrocarRecord, VertexRecord,
};

/// A scene as preparation builds it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SceneData {
    /// Positions and poses of devices, ports and target.
    pub room: Option<RoomRecord>,
    /// Organs.
    pub organs: Vec<OrganRecord>,
    /// Spheres, organ by organ.
    pub spheres: Vec<SphereRecord>,
    /// Links, organ by organ.
    pub links: Vec<LinkRecord>,
    /// Skin vertices, organ by organ.
    pub vertices: Vec<VertexRecord>,
    /// Skin triangles, organ by organ; indices into `vertices`.
    pub triangles: Vec<[u32; 3]>,
    /// Tetrahedra, organ by organ.
    pub tetrahedra: Vec<TetraRecord>,
    /// Attachments of organs to each other and to the world.
    pub attachments: Vec<AttachmentRecord>,
    /// Vertices of the contact skins.
    pub contact_vertices: Vec<ContactVertexRecord>,
    /// The two other corners of every triangle around each contact vertex, vertex by vertex.
    pub contact_fans: Vec<[u16; 2]>,
    /// For each sphere, the nearest contact vertex or [`super::NO_CONTACT_VERTEX`]; empty if no
    /// organ has a contact skin.
    pub contact_nearest: Vec<u16>,
    /// Cells of layered tissue, organ by organ.
    pub cells: Vec<CellRecord>,
    /// Corners of the cells.
    pub cell_corners: Vec<VertexRecord>,
    /// For each contact vertex, the cells under it; empty if the scene has no cells.
    pub cell_columns: Vec<CellColumnRecord>,
    /// The instrument's trocar; `None`: it neither rubs nor resists tilting.
    pub trocar: Option<TrocarRecord>,
    /// Stones in the gallbladder; `None`: there are none.
    pub stones: Option<StonesRecord>,
}

impl SceneData {
    /// Bytes of the scene, as the file contains them. Equal scenes give equal bytes.
    ///
    /// # Errors
    /// [`SceneError::MissingRoom`], or the error with which [`SceneFile::from_bytes`] refuses the
    /// bytes.
    pub fn to_bytes(&self) -> Result<Vec<u8>, SceneError> {
        let room = self.room.ok_or(SceneError::MissingRoom)?;
        let sections = match (self.trocar, self.stones) {
            (_, Some(_)) => SECTIONS,
            (Some(_), None) => SECTIONS_WITH_TROCAR,
            (None, None) => SECTIONS_MIN,
        };
        let mut body = Body {
            head: head_bytes(sections),
            table: Vec::new(),
            bytes: Vec::new(),
        };
        body.push(1, core::slice::from_ref(&room));
        body.push(2, &self.organs);
        body.push(3, &self.spheres);
        body.push(4, &self.links);
        body.push(5, &self.vertices);
        body.push(6, &self.triangles);
        body.push(7, &self.tetrahedra);
        body.push(8, &self.attachments);
        body.push(9, &self.contact_vertices);
        body.push(10, &self.contact_fans);
        body.push(11, &self.contact_nearest);
        body.push(12, &self.cells);
        body.push(13, &self.cell_corners);
        body.push(14, &self.cell_columns);
        if sections >= SECTIONS_WITH_TROCAR {
            body.push(15, self.trocar.as_slice());
        }
        if sections >= SECTIONS {
            body.push(16, self.stones.as_slice());
        }

        let table: &[u8] = bytemuck::cast_slice(&body.table);
        let mut hash = blake3::Hasher::new();
        hash.update(table).update(&body.bytes);
        let header = Header {
            magic: MAGIC,
            version: LAYOUT_VERSION,
            sections: sections as u32,
            identity: *hash.finalize().as_bytes(),
            bytes: (HEADER_BYTES + table.len() + body.bytes.len()) as u64,
            reserved: 0,
        };
        let mut file = bytemuck::bytes_of(&header).to_vec();
        file.extend_from_slice(table);
        file.extend_from_slice(&body.bytes);
        SceneFile::from_bytes(&file)?;
        Ok(file)
    }

    /// Writes a temporary file in the folder of `path` and renames it to `path`, so that a reader
    /// never sees half a scene. Returns the scene's identity.
    ///
    /// # Errors
    /// Errors of [`SceneData::to_bytes`] and of the file system, and an error if `path` is
    /// something other than a compiled scene or an empty file.
    pub fn write(&self, path: &Path) -> Result<SceneId, SceneError> {
        Self::write_levels(std::slice::from_ref(self), path)
    }

    /// Writes a file of one or more levels of detail, finest first. Returns the identity of the
    /// finest.
    ///
    /// # Errors
    /// Errors of [`SceneData::write`], and an error if there is no level or more than
    /// [`super::LEVELS_MAX`].
    pub fn write_levels(levels: &[Self], path: &Path) -> Result<SceneId, SceneError> {
        if !(1..=super::LEVELS_MAX).contains(&levels.len()) {
            return Err(SceneError::Count {
                what: "levels of detail",
                found: levels.len(),
                min: 1,
                max: super::LEVELS_MAX,
            });
        }
        let mut bytes = Vec::new();
        let mut finest = None;
        for level in levels {
            bytes.resize(bytes.len().next_multiple_of(ALIGN), 0);
            let level = level.to_bytes()?;
            bytes.extend_from_slice(&level);
            finest.get_or_insert(identity(&level));
        }
        check_place(path)?;
        let partial = path.with_extension(format!("partial-{}", std::process::id()));
        let written = std::fs::write(&partial, &bytes);
        let written = written.and_then(|()| std::fs::rename(&partial, path));
        written.map_err(|source| {
            // If removing the file fails too, the first error is reported.
            let _ = std::fs::remove_file(&partial);
            unwritable(path, source)
        })?;
        Ok(finest.unwrap_or_default())
    }
}

fn unwritable(path: &Path, source: std::io::Error) -> SceneError {
    SceneError::Unwritable {
        path: path.to_owned(),
        source,
    }
}

/// Refuses to replace anything other than a compiled scene or an empty file. A mistyped path may
/// name the mesh that the scene was made of, or a device.
fn check_place(path: &Path) -> Result<(), SceneError> {
    let Ok(there) = std::fs::metadata(path) else {
        return Ok(());
    };
    let refuse = |why: &str| Err(unwritable(path, std::io::Error::other(why)));
    if !there.is_file() {
        return refuse("it is there and is not a plain file");
    }
    let mut magic = [0; MAGIC.len()];
    let mut file = std::fs::File::open(path).map_err(|source| unwritable(path, source))?;
    if there.len() > 0 && (file.read_exact(&mut magic).is_err() || magic != MAGIC) {
        return refuse("it is there and is not a compiled scene");
    }
    Ok(())
}

/// The identity in the header of a scene's bytes.
fn identity(bytes: &[u8]) -> SceneId {
    let header: Header = bytemuck::pod_read_unaligned(&bytes[..HEADER_BYTES]);
    header.identity
}

struct Body {
    /// Bytes before the first section.
    head: usize,
    table: Vec<Section>,
    bytes: Vec<u8>,
}

impl Body {
    fn push<T: Pod>(&mut self, kind: u32, records: &[T]) {
        let offset = (self.head + self.bytes.len()).next_multiple_of(ALIGN);
        self.bytes.resize(offset - self.head, 0);
        self.bytes.extend_from_slice(bytemuck::cast_slice(records));
        self.table.push(Section {
            kind,
            element_bytes: size_of::<T>() as u32,
            offset: offset as u64,
            count: records.len() as u64,
            reserved: 0,
        });
    }
}
