//! Tests whether organs stay in their places. A pseudo-random hand presses, pulls and sweeps at
//! random places of every organ. Two seconds after it has left the tissue, every organ must be at
//! rest, outside its neighbours and attached as before.

mod sample;
mod snapshot;
mod trial;

use std::fmt::Write as _;

use scene_prepare::{Recipe, prepare};
use shared_mem::scene::{SceneFile, str_from_name};

use crate::csv::split;
use crate::page::{Section, table};
pub(crate) use sample::Sample;
use snapshot::Worst;
use trial::{Found, Work};

/// Speed below which tissue is at rest, m/s.
const STILL_M_S: f32 = 1e-4;
/// Largest depth of an organ in another, m.
const INSIDE_M: f32 = 0.002;
/// Largest growth of an attachment that did not tear, m.
const LOOSE_M: f32 = 0.002;
/// Number of places of each organ at which each kind of work is done.
const PLACES: u64 = 5;

/// A line of `stay.csv`.
pub(crate) struct Row {
    scene: &'static str,
    organ: String,
    work: Work,
    seed: u64,
    /// Names of the organs with the largest speed, depth in another organ, growth of an attachment
    /// and displacement.
    names: [String; 4],
    found: Found,
}

impl Row {
    /// True if the aim is met. Cut or torn tissue may hang anywhere.
    fn stays(&self) -> bool {
        let it = &self.found;
        !it.is_touched
            && it.speed_m_s.value <= STILL_M_S
            && it.inside_m.value <= INSIDE_M
            && (it.is_torn || it.loose_m.value <= LOOSE_M && !it.is_told)
    }
}

/// Works at every organ of the built-in scenes. Only cases whose name contains `only` run.
///
/// # Errors
/// When a scene cannot be prepared or run, in words.
pub(crate) fn run(quick: bool, only: &str) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let places = if quick { 1 } else { PLACES };
    for (name, is_variant) in [("triangle", false), ("variant triangle", true)] {
        let scene = compiled(is_variant)?;
        for organ in 0..scene.organs().len() {
            for work in Work::ALL {
                for seed in 1..=places {
                    let case = format!("{name}, {}, {}", organ_name(&scene, organ), work.name());
                    if case.contains(only) {
                        rows.extend(row(&scene, name, organ, work, seed)?);
                    }
                }
            }
        }
    }
    Ok(rows)
}

fn compiled(is_variant: bool) -> Result<SceneFile, String> {
    let recipe = Recipe::triangle(is_variant).map_err(|e| e.to_string())?;
    let prepared = prepare(&recipe, &mut |_| {}).map_err(|e| e.to_string())?;
    let bytes = prepared.scene.to_bytes().map_err(|e| e.to_string())?;
    SceneFile::from_bytes(&bytes).map_err(|e| e.to_string())
}

fn row(
    scene: &SceneFile,
    scene_name: &'static str,
    organ: usize,
    work: Work,
    seed: u64,
) -> Result<Option<Row>, String> {
    let Some(found) = trial::run(scene, organ, work, seed)? else {
        return Ok(None);
    };
    let whose = |worst: Worst| {
        let [one, other] = worst.organs.map(|number| organ_name(scene, number));
        match one == other {
            true => one,
            false => format!("{one} / {other}"),
        }
    };
    let row = Row {
        scene: scene_name,
        organ: organ_name(scene, organ),
        work,
        seed,
        names: [
            found.speed_m_s,
            found.inside_m,
            found.loose_m,
            found.moved_m,
        ]
        .map(whose),
        found,
    };
    eprintln!("stay: {}", words(&row));
    Ok(Some(row))
}

fn organ_name(scene: &SceneFile, number: usize) -> String {
    let name = scene.organs().get(number).map(|it| it.name);
    let name = name.as_ref().and_then(|it| str_from_name(it));
    name.unwrap_or_default().to_owned()
}

/// Result of a row in words.
fn words(row: &Row) -> String {
    let it = &row.found;
    let [fast, inside, loose, moved] = &row.names;
    let verdict = if row.stays() { "stays" } else { "LEAVES" };
    let notes = [
        (it.is_torn, ", torn"),
        (it.is_told, ", told"),
        (it.is_touched, ", the tool still touches"),
        (!it.is_held && row.work == Work::Pull, ", nothing held"),
    ];
    let notes: String = notes.iter().filter(|it| it.0).map(|it| it.1).collect();
    format!(
        "{}, {}, {} {}: {verdict}, {:.3} mm/s ({fast}), {:.1} mm inside ({inside}), {:.1} mm loose \
         ({loose}), {:.1} mm moved ({moved}){notes}",
        row.scene,
        row.organ,
        row.work.name(),
        row.seed,
        it.speed_m_s.value * 1e3,
        it.inside_m.value * 1e3,
        it.loose_m.value * 1e3,
        it.moved_m.value * 1e3,
    )
}

/// The rows as `stay.csv`.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = "scene,organ,work,seed,stays,speed_mm_s,moving,inside_mm,inside,loose_mm,loose,\
                    moved_mm,moved,held,torn,told,touched\n"
        .to_owned();
    for row in rows {
        let it = &row.found;
        let [fast, inside, loose, moved] = &row.names;
        let _ = writeln!(
            text,
            "\"{}\",\"{}\",{},{},{},{:.3},\"{fast}\",{:.2},\"{inside}\",{:.2},\"{loose}\",{:.2},\"{moved}\",\
             {},{},{},{}",
            row.scene,
            row.organ,
            row.work.name(),
            row.seed,
            row.stays(),
            it.speed_m_s.value * 1e3,
            it.inside_m.value * 1e3,
            it.loose_m.value * 1e3,
            it.moved_m.value * 1e3,
            it.is_held,
            it.is_torn,
            it.is_told,
            it.is_touched,
        );
    }
    text
}

/// The rows as a section of the page.
pub(crate) fn section(rows: &[Row]) -> Section {
    let text = csv(rows);
    let cells: Vec<_> = text.lines().map(split).collect();
    let staying = rows.iter().filter(|row| row.stays()).count();
    Section {
        title: "Organs stay where they belong".to_owned(),
        body: format!(
            "<p>A hand presses 8 mm deep, pulls a grasped fold by 30 mm or sweeps 30 mm along the \
             skin, at random places of every organ, at 30 or 150 mm/s. Each row tells what is left \
             2 s after it has gone: the largest speed of a sphere, the largest depth in another \
             organ, the largest growth of an attachment, and the largest distance of a sphere from \
             where it lay. The aim: 0.1 mm/s; 2 mm inside; 2 mm loose, unless tissue was cut or \
             torn. {staying} of {} rows meet it. <em>told</em>: the product itself said that an \
             organ left its place. <em>touched</em>: the tool was caught on its way out, so the \
             row says nothing of rest.</p>{}",
            rows.len(),
            table(&cells)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> SceneFile {
        let recipe = Recipe::triangle(false).expect("a recipe");
        let prepared = prepare(&recipe, &mut |_| {}).expect("a scene");
        let bytes = prepared.scene.to_bytes().expect("bytes");
        SceneFile::from_bytes(&bytes).expect("a scene")
    }

    #[test]
    fn organs_stay_where_they_belong_after_work_on_the_liver() {
        let scene = triangle();
        assert_eq!(organ_name(&scene, 0), "liver");
        for work in Work::ALL {
            let row = row(&scene, "triangle", 0, work, 1).expect("a run");
            let row = row.expect("a place");
            assert!(row.stays(), "{}", words(&row));
            assert!(row.found.moved_m.value < 0.005, "{}", words(&row));
        }
    }
}
