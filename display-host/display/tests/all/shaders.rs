//! Every shader parses and validates, and its structs have the layout of Rust's. Needs no graphics
//! device.

use display_host::render::layout::{Disc, Frame, Look, SHADERS, Stains, Tree, shader};
use display_host::skinning::dent::Dent;
use display_host::skinning::gpu::SHADER as SKINNING;
use display_host::skinning::{RestVertex, SkinnedVertex, Touch};
use naga::valid::{Capabilities, ValidationFlags, Validator};

fn parse(name: &str, source: &str) -> naga::Module {
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|error| panic!("{name}\n{}", error.emit_to_string(source)));
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{name}\n{}", error.emit_to_string(source)));
    module
}

#[test]
fn every_shader_validates() {
    for (name, source) in SHADERS {
        assert!(!parse(name, source).entry_points.is_empty(), "{name}");
    }
    assert_eq!(parse("skinning", SKINNING).entry_points.len(), 2);
}

fn compare(module: &naga::Module, name: &str, size: usize, fields: &[(&str, usize)]) {
    let (_, found) = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("no struct {name}"));
    let naga::TypeInner::Struct { members, span } = &found.inner else {
        panic!("{name} is no struct");
    };
    assert_eq!(*span as usize, size, "size of {name}");
    let there: Vec<_> = members
        .iter()
        .map(|m| (m.name.as_deref().unwrap_or(""), m.offset as usize))
        .collect();
    assert_eq!(there, fields, "fields of {name}");
}

macro_rules! same_layout {
    ($module:expr, $name:literal, $type:ty, [$($field:ident),* $(,)?]) => {
        compare(
            $module,
            $name,
            size_of::<$type>(),
            &[$((stringify!($field), core::mem::offset_of!($type, $field))),*],
        )
    };
}

#[test]
fn structs_lie_as_in_rust() {
    for name in ["tissue", "rigid", "scope mask", "exposure", "lens"] {
        let module = parse(name, shader(name));
        same_layout!(
            &module,
            "Frame",
            Frame,
            [
                clip_from_world,
                shadow_from_world,
                camera,
                forward,
                up,
                light,
                light_axis,
                scope,
                adapt,
                film,
                wear,
                counts,
                capsules,
                stones,
            ]
        );
    }
    let tissue = parse("tissue", shader("tissue"));
    same_layout!(
        &tissue,
        "Look",
        Look,
        [low, high, streak, slope, wet, scatter, lobule, cell, veil]
    );
    same_layout!(&tissue, "Tree", Tree, [origin, scale]);
    same_layout!(
        &tissue,
        "Stains",
        Stains,
        [places, count, window, scale, up]
    );
    let effects = parse("effects", shader("effects"));
    same_layout!(&effects, "Disc", Disc, [at, colour, look, along]);
    let skinning = parse("skinning", SKINNING);
    same_layout!(
        &skinning,
        "RestVertex",
        RestVertex,
        [position, look, normal, ambient, spheres, weights,]
    );
    same_layout!(
        &skinning,
        "SkinnedVertex",
        SkinnedVertex,
        [position, normal]
    );
    same_layout!(&skinning, "Dent", Dent, [a, b, into, spheres]);
    same_layout!(&skinning, "Touch", Touch, [count, dents]);
}
