//! Data of a glTF file: buffers (from the GLB, from a file beside it, or embedded as text), and the
//! elements of accessors, sparse accessors included.

use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};
use percent_encoding::percent_decode_str;

use super::extensions::blame;
use super::malformed;
use crate::error::MeshProblem;
use crate::mesh::read::{BYTES_MAX, content};

/// Base64 with or without padding: programs write both.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Buffers, and the names of the extensions that the file uses. An extension may explain missing
/// data.
pub(super) struct Data {
    buffers: Vec<Vec<u8>>,
    used: Vec<String>,
}

impl Data {
    pub(super) fn read(
        file: &gltf::Document,
        mut blob: Option<Vec<u8>>,
        folder: &Path,
    ) -> Result<Self, MeshProblem> {
        let announced = file.buffers().map(|buffer| buffer.length() as u64);
        let announced = announced.fold(0, u64::saturating_add);
        if announced > BYTES_MAX {
            let detail =
                format!("announces {announced} bytes of data; allowed: at most {BYTES_MAX}");
            return Err(malformed("glTF", &detail));
        }
        let mut data = Self {
            buffers: Vec::new(),
            used: file.extensions_used().map(str::to_owned).collect(),
        };
        for buffer in file.buffers() {
            let mut bytes = match buffer.source() {
                gltf::buffer::Source::Bin => blob.take().unwrap_or_default(),
                gltf::buffer::Source::Uri(uri) => match uri.strip_prefix("data:") {
                    Some(embedded) => decoded(embedded)?,
                    None => beside(uri, folder)?,
                },
            };
            if bytes.len() < buffer.length() {
                let detail = format!(
                    "truncated: buffer {} has {} bytes, but announces {}",
                    buffer.index(),
                    bytes.len(),
                    buffer.length()
                );
                return Err(data.blamed(malformed("glTF", &detail)));
            }
            // Bytes beyond the announced length are unused. They are cut off, because many buffers
            // may name one large file.
            bytes.truncate(buffer.length());
            bytes.shrink_to_fit();
            data.buffers.push(bytes);
        }
        Ok(data)
    }

    fn blamed(&self, otherwise: MeshProblem) -> MeshProblem {
        blame(self.used.iter().map(String::as_str), otherwise)
    }

    pub(super) fn positions(
        &self,
        accessor: &gltf::Accessor<'_>,
    ) -> Result<Vec<[f32; 3]>, MeshProblem> {
        self.check(accessor, Dimensions::Vec3, &[DataType::F32])?;
        let bytes = self.elements(accessor)?;
        let numbers = bytes.as_chunks::<4>().0.iter();
        let numbers: Vec<f32> = numbers.map(|b| f32::from_le_bytes(*b)).collect();
        Ok(numbers.as_chunks::<3>().0.to_vec())
    }

    pub(super) fn indices(&self, accessor: &gltf::Accessor<'_>) -> Result<Vec<u32>, MeshProblem> {
        let whole = [DataType::U8, DataType::U16, DataType::U32];
        self.check(accessor, Dimensions::Scalar, &whole)?;
        let bytes = self.elements(accessor)?;
        Ok(whole_numbers(&bytes, accessor.size()))
    }

    fn check(
        &self,
        accessor: &gltf::Accessor<'_>,
        shape: Dimensions,
        types: &[DataType],
    ) -> Result<(), MeshProblem> {
        let (found, element) = (accessor.dimensions(), accessor.data_type());
        if found == shape && types.contains(&element) {
            return Ok(());
        }
        let detail = format!(
            "accessor {} is {found:?} of {element:?}; it must be {shape:?} of one of {types:?}",
            accessor.index()
        );
        Err(self.blamed(malformed("glTF", &detail)))
    }

    /// The elements' bytes, one after the other.
    fn elements(&self, accessor: &gltf::Accessor<'_>) -> Result<Vec<u8>, MeshProblem> {
        let outside = || {
            let detail = format!("accessor {} reaches beyond its data", accessor.index());
            self.blamed(malformed("glTF", &detail))
        };
        let (count, size) = (accessor.count(), accessor.size());
        let mut elements = match (accessor.view(), accessor.sparse()) {
            (Some(view), _) => {
                let elements = self.strided(&view, accessor.offset(), count, size);
                elements.ok_or_else(outside)?
            }
            // All elements are zero, except those that the sparse list names.
            (None, Some(_)) => vec![0; count.saturating_mul(size)],
            (None, None) => return Err(outside()),
        };
        let Some(sparse) = accessor.sparse() else {
            return Ok(elements);
        };
        let (places, values) = (sparse.indices(), sparse.values());
        let place_size = match places.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let number = sparse.count();
        let values = self.strided(&values.view(), values.offset(), number, size);
        let places = self.strided(&places.view(), places.offset(), number, place_size);
        let (values, places) = values.zip(places).ok_or_else(outside)?;
        for (place, value) in whole_numbers(&places, place_size)
            .into_iter()
            .zip(values.chunks_exact(size))
        {
            let at = (place as usize).saturating_mul(size);
            let element = elements.get_mut(at..at.saturating_add(size));
            element.ok_or_else(outside)?.copy_from_slice(value);
        }
        Ok(elements)
    }

    /// Elements of a view, without the gaps between them; `None` if the view does not hold all of
    /// them.
    fn strided(
        &self,
        view: &gltf::buffer::View<'_>,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Option<Vec<u8>> {
        let end = view.offset().checked_add(view.length())?;
        let buffer = self.buffers.get(view.buffer().index())?;
        let bytes = buffer.get(view.offset()..end)?.get(offset..)?;
        let stride = view.stride().unwrap_or(size);
        let Some(last) = count.checked_sub(1) else {
            return Some(Vec::new());
        };
        let needed = last.checked_mul(stride)?.checked_add(size)?;
        if stride < size || needed > bytes.len() {
            return None;
        }
        let elements = bytes[..needed].chunks(stride);
        Some(
            elements
                .flat_map(|element| &element[..size])
                .copied()
                .collect(),
        )
    }
}

/// Numbers of one, two or four bytes each.
fn whole_numbers(bytes: &[u8], size: usize) -> Vec<u32> {
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |n, b| n << 8 | u32::from(*b));
    bytes.chunks_exact(size).map(number).collect()
}

/// Data of a `data:` URI.
fn decoded(embedded: &str) -> Result<Vec<u8>, MeshProblem> {
    let bad = |why: &str| malformed("glTF", &format!("its embedded data are damaged: {why}"));
    let (kind, text) = embedded.split_once(',').ok_or_else(|| bad("no comma"))?;
    let mut bytes: Vec<u8> = percent_decode_str(text).collect();
    if !kind.to_ascii_lowercase().ends_with(";base64") {
        return Ok(bytes);
    }
    bytes.retain(|b| !b.is_ascii_whitespace());
    BASE64
        .decode(bytes)
        .map_err(|error| bad(&error.to_string()))
}

/// Data of a file in the glTF file's folder or below. The file's name may be percent-encoded.
fn beside(uri: &str, folder: &Path) -> Result<Vec<u8>, MeshProblem> {
    let name = percent_decode_str(uri).decode_utf8_lossy();
    let mut path = PathBuf::from(&*name);
    let is_below = |path: &Path| {
        let mut steps = path.components();
        steps.all(|step| matches!(step, Component::Normal(_) | Component::CurDir))
    };
    if name.contains(['\\', '\0']) || !is_below(&path) {
        let detail = format!("its data '{uri}' are not below its folder; put the file beside it");
        return Err(malformed("glTF", &detail));
    }
    // Some programs do not encode a name, even if it has percent signs.
    if !folder.join(&path).exists() && is_below(Path::new(uri)) {
        path = uri.into();
    }
    content(&folder.join(path))
        .map_err(|problem| malformed("glTF", &format!("its data '{name}' {problem}")))
}
