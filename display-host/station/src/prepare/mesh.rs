//! What `calot prepare` is told about a single mesh.

use clap::Args;
use scene_prepare::recipe::{self, Axes, Closing, MeshOptions, Pieces, Unit};
use shared_mem::scene::OrganKind;

#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "For a single mesh (a recipe has the same keys)")]
pub(crate) struct MeshArgs {
    /// Unit of its numbers: m, cm, mm or in [default: m, or mm for a mesh more than 2 m across]
    #[arg(long, value_name = "UNIT", value_parser = parse_unit)]
    unit: Option<Unit>,
    /// Factor on all lengths, 0.001 to 1000. Without --unit it is metres per unit of the file
    #[arg(long, value_name = "FACTOR", value_parser = parse_scale)]
    scale: Option<f64>,
    /// Directions of its axes: lsa (x left, y to the head, z to the front; also y-up, as glTF), ras
    /// (x right, y front, z head), lps (x left, y back, z head; also z-up) [default: lsa]
    #[arg(long, value_name = "AXES", value_parser = parse_axes)]
    axes: Option<Axes>,
    /// Kind of organ, which gives its material, packing and expected size, e.g. gallbladder
    /// [default: liver]
    #[arg(long, value_name = "KIND", value_parser = parse_kind)]
    kind: Option<OrganKind>,
    /// Take only this solid, object, group or node of the file; may be repeated
    #[arg(long, value_name = "NAME")]
    part: Vec<String>,
    /// Separate pieces: near (link those no farther apart than the spheres, refuse others), join
    /// (link all), largest (drop the others) [default: near]
    #[arg(long, value_name = "WHICH", value_parser = parse_pieces)]
    pieces: Option<Pieces>,
    /// Open surfaces: refuse, fill (patch each hole), auto (patch, or wrap what is still open, and
    /// make hollow organs solid), wrap (a new surface around it), solid (the outer side alone)
    /// [default: auto]
    #[arg(long, value_name = "HOW", value_parser = parse_closing)]
    closing: Option<Closing>,
}

impl MeshArgs {
    /// The options for the scene maker.
    pub(crate) fn options(&self) -> MeshOptions {
        MeshOptions {
            unit: self.unit,
            scale: self.scale,
            axes: self.axes.unwrap_or_default(),
            kind: self.kind,
            parts: self.part.clone(),
            closing: self.closing,
            pieces: self.pieces.unwrap_or_default(),
        }
    }

    /// The first option that was given, with the key that a recipe has for it.
    pub(crate) fn given(&self) -> Option<[&'static str; 2]> {
        let all = [
            (self.unit.is_some(), ["--unit", "unit"]),
            (self.scale.is_some(), ["--scale", "scale"]),
            (self.axes.is_some(), ["--axes", "axes"]),
            (self.kind.is_some(), ["--kind", "kind"]),
            (!self.part.is_empty(), ["--part", "parts"]),
            (self.pieces.is_some(), ["--pieces", "pieces"]),
            (self.closing.is_some(), ["--closing", "closing"]),
        ];
        let given = all.into_iter().find(|(given, _)| *given);
        given.map(|(_, names)| names)
    }
}

/// The value with this name.
fn one_of<T: Copy>(what: &str, text: &str, all: &[(&str, T)]) -> Result<T, String> {
    let found = all.iter().find(|(name, _)| *name == text);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        format!("{what} is one of {}", names.join(", "))
    })
}

fn parse_unit(text: &str) -> Result<Unit, String> {
    let all = [
        ("m", Unit::Metre),
        ("cm", Unit::Centimetre),
        ("mm", Unit::Millimetre),
        ("in", Unit::Inch),
    ];
    one_of("a unit", text, &all)
}

fn parse_scale(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(scale) if (1e-3..=1e3).contains(&scale) => Ok(scale),
        _ => Err("a scale is 0.001 to 1000".into()),
    }
}

fn parse_axes(text: &str) -> Result<Axes, String> {
    let all = [
        ("lsa", Axes::Lsa),
        ("y-up", Axes::Lsa),
        ("ras", Axes::Ras),
        ("lps", Axes::Lps),
        ("z-up", Axes::Lps),
    ];
    one_of("a set of axes", &text.to_ascii_lowercase(), &all)
}

fn parse_kind(text: &str) -> Result<OrganKind, String> {
    recipe::kind_named(text).ok_or_else(|| {
        let names: Vec<&str> = recipe::kind_names().collect();
        format!("a kind is one of {}", names.join(", "))
    })
}

fn parse_pieces(text: &str) -> Result<Pieces, String> {
    let all = [
        ("near", Pieces::Near),
        ("join", Pieces::Join),
        ("largest", Pieces::Largest),
    ];
    one_of("a treatment of pieces", text, &all)
}

fn parse_closing(text: &str) -> Result<Closing, String> {
    let all = [
        ("refuse", Closing::Refuse),
        ("fill", Closing::Fill),
        ("auto", Closing::Auto),
        ("wrap", Closing::Wrap),
        ("solid", Closing::Solid),
    ];
    one_of("a treatment of open surfaces", text, &all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_option_that_a_message_recommends_is_known_and_others_are_named() {
        assert_eq!(parse_unit("in"), Ok(Unit::Inch));
        assert_eq!(parse_axes("RAS"), Ok(Axes::Ras));
        assert_eq!(parse_kind("gallbladder"), Ok(OrganKind::Gallbladder));
        assert_eq!(parse_pieces("largest"), Ok(Pieces::Largest));
        assert_eq!(parse_closing("solid"), Ok(Closing::Solid));
        assert!(parse_unit("ft").unwrap_err().contains("m, cm, mm, in"));
        assert!(parse_kind("spleen").unwrap_err().contains("cystic-duct"));
        for bad in ["0", "nan", "-1", "inf", ""] {
            assert!(parse_scale(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn an_option_that_was_given_is_named_with_its_key() {
        assert_eq!(MeshArgs::default().given(), None);
        let args = MeshArgs {
            part: vec!["a".into()],
            ..MeshArgs::default()
        };
        assert_eq!(args.given(), Some(["--part", "parts"]));
    }
}
