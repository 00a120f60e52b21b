//! Options of a single mesh. A recipe sets the same options for each organ, by the same names.

use clap::Args;
use scene_prepare::recipe::{Axes, Closing, MeshOptions, Pieces, Unit, organ_kind};
use shared_mem::scene::OrganKind;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "A single mesh")]
pub(crate) struct MeshArgs {
    /// Unit of the mesh: m, cm, mm or in [default: m, or mm for a mesh more than 2 m across]
    #[arg(long, value_name = "UNIT", value_parser = |text: &str| named("unit", &UNITS, text))]
    unit: Option<Unit>,
    /// Factor by which the mesh is also scaled, 0.001 to 1000
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_scale)]
    scale: f64,
    /// Directions of the mesh's axes: LSA (left, head, front; glTF), LPS (left, back, head; DICOM)
    /// or RAS (right, front, head; NIfTI, 3D Slicer)
    #[arg(long, value_name = "AXES", default_value = "LSA", value_parser = |text: &str| named("axes", &AXES, text))]
    axes: Axes,
    /// Kind of organ, which gives its material: liver, gallbladder, stomach, fat, …
    #[arg(long, value_name = "KIND", default_value = "liver", value_parser = organ_kind)]
    kind: OrganKind,
    /// Treatment of separate pieces: `near` links pieces that nearly touch and refuses others,
    /// `join` links all, `largest` keeps the largest
    #[arg(long, value_name = "HOW", default_value = "near", value_parser = |text: &str| named("pieces", &PIECES, text))]
    pieces: Pieces,
    /// Treatment of holes: `auto` fills them and wraps a mesh that stays open, `fill` only fills,
    /// `wrap` and `solid` build a new surface, `refuse` refuses the mesh
    #[arg(long, value_name = "HOW", default_value = "auto", value_parser = |text: &str| named("closing", &CLOSINGS, text))]
    closing: Closing,
    /// Take only this named part of the file; can be given several times [default: all]
    #[arg(long, value_name = "NAME")]
    part: Vec<String>,
}

const UNITS: [(&str, Unit); 4] = [
    ("m", Unit::Metre),
    ("cm", Unit::Centimetre),
    ("mm", Unit::Millimetre),
    ("in", Unit::Inch),
];
const AXES: [(&str, Axes); 3] = [("LSA", Axes::Lsa), ("LPS", Axes::Lps), ("RAS", Axes::Ras)];
const PIECES: [(&str, Pieces); 3] = [
    ("near", Pieces::Near),
    ("join", Pieces::Join),
    ("largest", Pieces::Largest),
];
const CLOSINGS: [(&str, Closing); 5] = [
    ("auto", Closing::Auto),
    ("fill", Closing::Fill),
    ("wrap", Closing::Wrap),
    ("solid", Closing::Solid),
    ("refuse", Closing::Refuse),
];

impl MeshArgs {
    pub(crate) fn options(&self) -> MeshOptions {
        MeshOptions {
            unit: self.unit,
            scale: self.scale,
            axes: self.axes,
            kind: self.kind,
            pieces: self.pieces,
            closing: self.closing,
            parts: self.part.clone(),
        }
    }
}

/// The value of this name. The error lists all names.
fn named<T: Copy>(what: &str, table: &[(&str, T)], text: &str) -> Result<T, String> {
    let found = table
        .iter()
        .find(|(name, _)| name.eq_ignore_ascii_case(text));
    let names = || table.iter().map(|(name, _)| *name).collect::<Vec<_>>();
    found
        .map(|(_, value)| *value)
        .ok_or_else(|| format!("{what}: one of {}", names().join(", ")))
}

fn parse_scale(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(scale) if (1e-3..=1e3).contains(&scale) => Ok(scale),
        _ => Err("a scale is 0.001 to 1000".into()),
    }
}
