//! Reading a compiled scene: the file is mapped into memory, checked, and read in place.

use std::path::{Path, PathBuf};

use bytemuck::Pod;

use super::error::SceneError;
use super::header::{HEADER_BYTES, Header, SECTIONS, SECTIONS_MIN, Section, head_bytes};
use super::levels;
use super::{
    AttachmentRecord, BINDINGS, CellColumnRecord, CellRecord, ContactVertexRecord, LAYOUT_VERSION,
    LinkRecord, MAGIC, OrganRecord, RoomRecord, SceneId, SphereRecord, StonesRecord, TetraRecord,
    TrocarRecord, VertexRecord, str_from_name,
};

/// A checked, read-only compiled scene, mapped from a file or copied from bytes in memory.
#[derive(Debug)]
pub struct SceneFile {
    bytes: Bytes,
    id: SceneId,
    pub(super) sections: [Section; SECTIONS],
}

#[derive(Debug)]
enum Bytes {
    Mapped(memmap2::Mmap),
    /// The bytes in `u64` words, for alignment, and the number of bytes. The last word may have
    /// unused bytes.
    Owned(Vec<u64>, usize),
}

impl Bytes {
    fn get(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Owned(words, len) => &bytemuck::cast_slice(words)[..*len],
        }
    }
}

impl SceneFile {
    /// Maps and checks a file, or one level of detail in it. `FILE` and `FILE#0` name the finest
    /// level, `FILE#1` the next coarser one. Do not change a file in place while it is mapped.
    /// Replace it by renaming a new file, as [`super::SceneData::write`] does.
    ///
    /// # Errors
    /// The error names the fault and its place in the file.
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        let (path, level) = levels::split(path);
        let io = |source| SceneError::Io {
            path: path.clone(),
            source,
        };
        let mut file = std::fs::File::open(&path).map_err(io)?;
        let found = levels::find(&mut file).map_err(io)?;
        let Some(&(offset, bytes)) = found.get(level) else {
            return Err(match found.len() {
                0 => SceneError::NotAScene("too short"),
                levels => SceneError::NoSuchLevel { level, levels },
            });
        };
        #[expect(unsafe_code, reason = "mapping a file is unsafe in memmap2")]
        // SAFETY: the map is read-only. Writers replace the file and never change it in place (see
        // `SceneData::write`). All content is plain old data and is checked below.
        let map = unsafe {
            memmap2::MmapOptions::new()
                .offset(offset)
                .len(bytes)
                .map(&file)
        }
        .map_err(io)?;
        Self::check(Bytes::Mapped(map))
    }

    /// The levels of detail in a file, finest first, as paths for [`SceneFile::open`]. Returns
    /// `path` alone if it names a coarser level or a file that cannot be read; opening that file
    /// then reports the error.
    #[must_use]
    pub fn levels(path: &Path) -> Vec<PathBuf> {
        let (file, level) = levels::split(path);
        if level > 0 {
            return vec![path.to_owned()];
        }
        let found = std::fs::File::open(&file).and_then(|mut file| levels::find(&mut file));
        let count = found.map_or(1, |found| found.len().max(1));
        let name = |level| levels::join(&file, level);
        std::iter::once(path.to_owned())
            .chain((1..count).map(name))
            .collect()
    }

    /// Copies and checks the bytes of a scene, one level of detail.
    ///
    /// # Errors
    /// As [`SceneFile::open`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SceneError> {
        let mut words = vec![0u64; bytes.len().div_ceil(8)];
        bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
        Self::check(Bytes::Owned(words, bytes.len()))
    }

    fn check(bytes: Bytes) -> Result<Self, SceneError> {
        let all = bytes.get();
        if all.len() < head_bytes(SECTIONS_MIN) {
            return Err(SceneError::NotAScene("too short"));
        }
        let header: Header = *bytemuck::from_bytes(&all[..HEADER_BYTES]);
        if header.magic != MAGIC {
            return Err(SceneError::NotAScene("wrong magic"));
        }
        if header.version != LAYOUT_VERSION {
            return Err(SceneError::Version {
                found: header.version,
            });
        }
        let count = header.sections as usize;
        let head = head_bytes(count.min(SECTIONS));
        let is_known = (SECTIONS_MIN..=SECTIONS).contains(&count);
        if !is_known || all.len() < head || header.bytes != all.len() as u64 {
            return Err(SceneError::NotAScene("wrong length"));
        }
        if *blake3::hash(&all[HEADER_BYTES..]).as_bytes() != header.identity {
            return Err(SceneError::Identity);
        }
        // A section that the file lacks is empty.
        let mut sections = [Section {
            kind: 0,
            element_bytes: 0,
            offset: 0,
            count: 0,
            reserved: 0,
        }; SECTIONS];
        sections[..count].copy_from_slice(bytemuck::cast_slice(&all[HEADER_BYTES..head]));
        for (i, section) in sections[..count].iter().enumerate() {
            let bytes = section.count.checked_mul(u64::from(section.element_bytes));
            let end = bytes.and_then(|n| section.offset.checked_add(n));
            if section.kind as usize != i + 1
                || section.element_bytes as usize != ELEMENT_BYTES[i]
                || section.offset % 64 != 0
                || end.is_none_or(|end| end > all.len() as u64)
            {
                return Err(SceneError::NotAScene("broken section table"));
            }
        }
        let scene = Self {
            id: header.identity,
            sections,
            bytes,
        };
        scene.check_content()?;
        Ok(scene)
    }

    fn section<T: Pod>(&self, index: usize) -> &[T] {
        let Section { offset, count, .. } = self.sections[index];
        let start = offset as usize;
        bytemuck::cast_slice(&self.bytes.get()[start..start + count as usize * size_of::<T>()])
    }

    /// Bytes of the scene, equal to those in the file. [`SceneFile::from_bytes`] reads them.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get()
    }

    /// Identity of the scene.
    #[must_use]
    pub fn id(&self) -> SceneId {
        self.id
    }

    /// First half of the identity. Frames contain this half.
    #[must_use]
    pub fn short_id(&self) -> [u8; 16] {
        let mut short = [0; 16];
        short.copy_from_slice(&self.id[..16]);
        short
    }

    /// The scene's name.
    #[must_use]
    pub fn name(&self) -> &str {
        str_from_name(&self.section::<RoomRecord>(0)[0].name).unwrap_or("?")
    }

    /// Positions and poses of devices, ports and target.
    #[must_use]
    pub fn room(&self) -> &RoomRecord {
        &self.section(0)[0]
    }

    /// Organs.
    #[must_use]
    pub fn organs(&self) -> &[OrganRecord] {
        self.section(1)
    }

    /// Spheres, organ by organ.
    #[must_use]
    pub fn spheres(&self) -> &[SphereRecord] {
        self.section(2)
    }

    /// Links, organ by organ.
    #[must_use]
    pub fn links(&self) -> &[LinkRecord] {
        self.section(3)
    }

    /// Skin vertices, organ by organ.
    #[must_use]
    pub fn vertices(&self) -> &[VertexRecord] {
        self.section(4)
    }

    /// Skin triangles, organ by organ; indices into [`SceneFile::vertices`].
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.section(5)
    }

    /// Tetrahedra, organ by organ.
    #[must_use]
    pub fn tetrahedra(&self) -> &[TetraRecord] {
        self.section(6)
    }

    /// Attachments of organs to each other and to the world.
    #[must_use]
    pub fn attachments(&self) -> &[AttachmentRecord] {
        self.section(7)
    }

    /// Vertices of the contact skins.
    #[must_use]
    pub fn contact_vertices(&self) -> &[ContactVertexRecord] {
        self.section(8)
    }

    /// The two other corners of every triangle around each contact vertex, vertex by vertex.
    #[must_use]
    pub fn contact_fans(&self) -> &[[u16; 2]] {
        self.section(9)
    }

    /// For each sphere, the nearest contact vertex or `NO_CONTACT_VERTEX`; empty if no organ has a
    /// contact skin.
    #[must_use]
    pub fn contact_nearest(&self) -> &[u16] {
        self.section(10)
    }

    /// Cells of layered tissue, organ by organ.
    #[must_use]
    pub fn cells(&self) -> &[CellRecord] {
        self.section(11)
    }

    /// Corners of the cells.
    #[must_use]
    pub fn cell_corners(&self) -> &[VertexRecord] {
        self.section(12)
    }

    /// For each contact vertex, the cells under it; empty if the scene has no cells.
    #[must_use]
    pub fn cell_columns(&self) -> &[CellColumnRecord] {
        self.section(13)
    }

    /// The instrument's trocar, if the scene has one.
    #[must_use]
    pub fn trocar(&self) -> Option<&TrocarRecord> {
        self.section(14).first()
    }

    /// The stones in the gallbladder, if the scene has any.
    #[must_use]
    pub fn stones(&self) -> Option<&StonesRecord> {
        self.section(15).first()
    }
}

const ELEMENT_BYTES: [usize; SECTIONS] = [
    size_of::<RoomRecord>(),
    size_of::<OrganRecord>(),
    size_of::<SphereRecord>(),
    size_of::<LinkRecord>(),
    size_of::<VertexRecord>(),
    size_of::<[u32; 3]>(),
    size_of::<TetraRecord>(),
    size_of::<AttachmentRecord>(),
    size_of::<ContactVertexRecord>(),
    size_of::<[u16; 2]>(),
    size_of::<u16>(),
    size_of::<CellRecord>(),
    size_of::<VertexRecord>(),
    size_of::<CellColumnRecord>(),
    size_of::<TrocarRecord>(),
    size_of::<StonesRecord>(),
];

const _: () = assert!(BINDINGS == 8 && size_of::<VertexRecord>() == 56);
