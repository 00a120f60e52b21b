//! The sections of measured.html, for readers who know neither the program nor the tests.

use figures::panels::{self, Panel, Scale, Series};
use scene_prepare::recipe::sourced;
use shared_mem::scene::OrganKind;

use super::plates::{Ends, Pressed};
use super::published::STRAINS_PCT;
use super::silicone::{self, Run};
use super::{ALLOWED_PCT, Measured, Row, lung};
use crate::page::{Section, number, strings, table};

/// Largest allowed variation of the force while the plates rest, per cent of the force.
const UNSTEADY_PCT: f64 = 2.0;

/// The page's sections.
///
/// # Errors
/// The drawing library's message.
pub(super) fn sections(measured: &Measured) -> Result<Vec<Section>, String> {
    let mut all = Vec::new();
    if !measured.silicone.runs.is_empty() {
        all.push(silicones(&measured.silicone)?);
        all.push(departures(&measured.silicone)?);
    }
    if !measured.beam.is_empty() {
        all.push(beam(&measured.beam));
    }
    match &measured.lung {
        Some(found) => all.push(lung(found)?),
        None => all.push(without_lung()),
    }
    if !measured.tissue.is_empty() {
        all.push(tissue(&measured.tissue));
    }
    if !measured.port.is_empty() {
        all.push(port(&measured.port));
    }
    all.push(materials());
    all.push(everything(measured));
    Ok(all)
}

fn silicones(found: &silicone::Found) -> Result<Section, String> {
    let mut names: Vec<&str> = found.runs.iter().map(|run| run.silicone.name).collect();
    names.dedup();
    let mut all = Vec::new();
    for ends in Ends::ALL {
        for name in &names {
            let own = || {
                let mut runs = found.runs.iter();
                runs.find(|run| run.silicone.name == *name && run.ends == ends)
            };
            let Some(first) = own() else { continue };
            let measured = STRAINS_PCT.iter().zip(&first.silicone.force_n);
            let mut series = vec![Series {
                name: "measured".to_owned(),
                points: measured.map(|(pct, [mean, _])| [*pct, *mean]).collect(),
                is_thin: false,
            }];
            let here = found.runs.iter();
            series.extend(
                here.filter(|run| run.silicone.name == *name && run.ends == ends)
                    .map(course),
            );
            all.push(Panel {
                title: format!("{name}, {}", ends.name()),
                axes: ["strain, %".to_owned(), "force, N".to_owned()],
                scales: [Scale::Linear, Scale::Log],
                series,
            });
        }
    }
    let inside = |from: f64, to: f64| {
        let all = found.runs.iter().flat_map(|run| {
            let both = STRAINS_PCT.iter().zip(run.errors_pct());
            both.filter(|(pct, _)| (from..=to).contains(*pct))
                .map(|(_, error)| error.abs() <= ALLOWED_PCT)
                .collect::<Vec<_>>()
        });
        let all: Vec<bool> = all.collect();
        format!("{} of {}", all.iter().filter(|it| **it).count(), all.len())
    };
    let mut rows = vec![strings(["silicone", "ends", "spheres", "E, kPa"])];
    rows[0].extend(STRAINS_PCT.iter().map(|pct| format!("{pct} %")));
    rows[0].push("steady".to_owned());
    for run in &found.runs {
        let mut row = vec![
            run.silicone.name.to_owned(),
            run.ends.name().to_owned(),
            run.spheres.to_string(),
            number(run.young_pa / 1e3, 2),
        ];
        row.extend(run.errors_pct().map(|error| format!("{error:+.1}")));
        row.push(steady(run));
        rows.push(row);
    }
    Ok(Section {
        title: "Silicones pressed between plates".to_owned(),
        body: format!(
            "<p>Cylinders of silicone, 50 mm wide and 30 mm high, were pressed flat in a testing machine, ten times \
each. The softest is as soft as liver. Calot’s own preparation fills the same cylinder with spheres, and Calot’s own \
solver presses it. <b>One number is fitted: the modulus, to the force at {} % strain.</b> All other points are what \
the solver then gives. The publication does not say whether the ends slid, so both cases are shown.</p>\
<p>Within {ALLOWED_PCT} % of the mean: {} points from 5 to 40 % strain, {} at 50 and 60 %.</p>{}\
<details><summary>Errors, % of the published mean. “Steady”: up to this strain the force keeps within {UNSTEADY_PCT} % \
of its mean while the plates rest. Beyond, the solver shakes and the figure is a mean of the shaking.</summary>{}</details>",
            silicone::FITTED_PCT,
            inside(5.0, 40.0),
            inside(50.0, 60.0),
            panels::panels(&all, 4)?,
            table(&rows)
        ),
    })
}

/// Largest strain up to which the force is steady, as text.
fn steady(run: &Run) -> String {
    let is_still = |it: &&(&f64, &Pressed)| it.1.unsteady_n <= UNSTEADY_PCT / 100.0 * it.1.force_n;
    let all = STRAINS_PCT.iter().zip(&run.pressed).collect::<Vec<_>>();
    let still = all.iter().take_while(|it| is_still(it)).last();
    still.map_or_else(|| "nowhere".to_owned(), |(pct, _)| format!("to {pct} %"))
}

fn course(run: &Run) -> Series {
    let forces = STRAINS_PCT.iter().zip(&run.pressed);
    Series {
        name: format!("Calot, {} spheres", run.spheres),
        points: forces.map(|(pct, it)| [*pct, it.force_n]).collect(),
        is_thin: true,
    }
}

/// Section about the reasons of the differences: the law, and the solver's settings.
fn departures(found: &silicone::Found) -> Result<Section, String> {
    let head = || {
        let mut row = strings(["silicone", "solver", "spheres"]);
        row.extend(STRAINS_PCT.iter().map(|pct| format!("{pct} %")));
        row
    };
    let cells = |errors: Vec<f64>| errors.into_iter().map(|error| format!("{error:+.1}"));
    let mut rows = vec![head()];
    let mut last = "";
    for run in &found.runs {
        if run.silicone.name != last {
            last = run.silicone.name;
            let mut row = strings([last, "none: closed form of the law", ""]);
            row.extend(cells(run.law_errors_pct()?));
            rows.push(row);
        }
    }
    let first = found.runs.first().map(|run| run.silicone.name);
    let shipped = found.runs.iter().filter(|run| {
        Some(run.silicone.name) == first && run.ends == Ends::Free && !found.causes.is_empty()
    });
    let mut volumes = vec![head()];
    for run in shipped.chain(&found.causes) {
        let setting = format!(
            "{}, {}",
            match run.setting.finer {
                1 => "substeps as shipped".to_owned(),
                times => format!("{times} times the substeps"),
            },
            match run.setting.is_viscous {
                true => "viscosity as shipped",
                false => "no viscosity",
            }
        );
        let name = run.silicone.name.to_owned();
        let mut row = vec![name, setting, run.spheres.to_string()];
        volumes.push(row.clone());
        row.extend(cells(run.errors_pct().collect()));
        rows.push(row);
        if let Some(row) = volumes.last_mut() {
            row.extend(run.pressed.iter().map(|it| number(it.least_volume, 2)));
        }
    }
    Ok(Section {
        title: "Why it departs".to_owned(),
        body: format!(
            "<p>Two causes can be told apart. <b>The law:</b> its closed form with free ends, fitted at the same point, \
needs no solver. It does not stiffen as silicone does above 40 % strain. <b>The solver:</b> the other rows press the \
softest silicone with free ends, with finer substeps and without viscosity. Errors are per cent of the published mean.</p>{}\
<p>Smallest volume of a tetrahedron over its volume at rest. Below 0 tissue is inside out, and the force is no longer \
the material’s.</p>{}",
            table(&rows),
            table(&volumes)
        ),
    })
}

fn beam(rows: &[Row]) -> Section {
    Section {
        title: "A block that swings".to_owned(),
        body: format!(
            "<p>A block of 120 by 30 by 30 mm is held at one end and swings by 1 mm in its first mode. Beam theory \
(Timoshenko’s, with shear and the turning of sections) gives the frequency. Without damping asked for, whatever decays \
is the solver’s own damping. With the product’s damping, the decay should be what was asked for: half of the drag on \
velocity, and the viscosity’s share.</p>{}",
            listed(rows)
        ),
    }
}

fn lung(found: &lung::Found) -> Result<Section, String> {
    let course = |name: &str, trials: &[lung::Trial]| {
        let trials = trials.iter().map(|trial| Series {
            name: name.to_owned(),
            points: trial.course.iter().step_by(8).copied().collect(),
            is_thin: true,
        });
        trials.collect::<Vec<_>>()
    };
    let mut pressed = course("lung, pressed", &found.pressing);
    pressed.push(Series {
        name: "Calot’s liver, strain in %".to_owned(),
        points: found.calot.clone(),
        is_thin: false,
    });
    let panel = |title: &str, series: Vec<Series>| Panel {
        title: title.to_owned(),
        axes: ["depth, mm".to_owned(), "force, N".to_owned()],
        scales: [Scale::Linear, Scale::Log],
        series,
    };
    let panels = [
        panel("porcine lung, pressed", pressed),
        panel("porcine lung, cut", course("lung, cut", &found.cutting)),
    ];
    let [slow, fast] = found.speeds_mm_s;
    Ok(Section {
        title: "Porcine lung, pressed and cut".to_owned(),
        body: format!(
            "<p>Lung in a testing machine. The publication states neither the sample’s size nor the blade, so only the \
shape is compared: by which factor the force grows when the depth doubles. Calot’s specimen is a cylinder of liver; \
1 % of its height stands for each mm, as if the lung were 100 mm thick. <b>Lung stiffens, Calot’s law hardly does.</b></p>\
<p>In these files the machine moves at {slow:.2} to {fast:.2} mm/s and rests at no place for longer than {:.1} s, so \
they hold neither the dependence on the rate nor relaxation.</p>{}{}",
            found.rest_s,
            panels::panels(&panels, 2)?,
            listed(&found.rows)
        ),
    })
}

fn without_lung() -> Section {
    Section {
        title: "Porcine lung: not compared".to_owned(),
        body: "<p>The measurements of lung are not part of the program. Give their folder with --data.</p>"
            .to_owned(),
    }
}

fn tissue(rows: &[Row]) -> Section {
    Section {
        title: "Organs and instruments".to_owned(),
        body: format!(
            "<p>Published figures of organs and instruments. Calot’s figures come from runs of its solver, with the \
materials of its built-in scenes, and of its whole simulation. “Not modelled”: Calot lacks the effect, or this \
program cannot read it; the condition says which.</p>\
<p><b>Why moduli of liver differ fifty-fold.</b> Small strains, as of ultrasound and gentle presses, meet the soft \
sponge of cells and blood: some 2 to 15 kPa. Carter’s 270 kPa are a secant under a small indenter that is pressed \
hard. There the capsule and the strained network carry, and the force grows exponentially. Perfused liver pressed by half \
(Kerdok) lies between them. <b>A tool feels both:</b> at a depth of a few millimetres the soft modulus, as Calot gives \
it; pressed hard, much more than Calot gives, because Calot’s law does not stiffen.</p>{}",
            listed(rows)
        ),
    }
}

fn port(rows: &[Row]) -> Section {
    Section {
        title: "The port".to_owned(),
        body: format!(
            "<p>A shaft moves by 50 mm in and out through the trocar at 50 mm/s, away from tissue. The whole tick \
computes the force, and the emulated Touch renders it to a firm hand. A scene or a station file asks for the trocar; \
without one, and on a rig with a real trocar, nothing is rendered.</p>{}",
            listed(rows)
        ),
    }
}

/// The materials of the built-in scenes, with their sources.
fn materials() -> Section {
    let mut rows = vec![strings(["tissue", "value", "", "source"])];
    for kind in OrganKind::ALL {
        let name = format!("{kind:?}");
        rows.extend(sourced(kind).map(|it| {
            let value = it.value.to_string();
            vec![
                name.clone(),
                it.name.to_owned(),
                value,
                it.source.to_owned(),
            ]
        }));
    }
    Section {
        title: "Materials of the built-in scenes".to_owned(),
        body: format!(
            "<p>Every value of every material has a source, or says that it is assumed, and why.</p>\
<details><summary>All values, SI</summary>{}</details>",
            table(&rows)
        ),
    }
}

fn everything(measured: &Measured) -> Section {
    let (all, inside) = measured.rows().fold((0, 0), |(all, inside), row| {
        (all + 1, inside + usize::from(row.within()))
    });
    let rows: Vec<Row> = measured.rows().cloned().collect();
    Section {
        title: "All rows".to_owned(),
        body: format!(
            "<p>{inside} of {all} rows are within the published figure: within {ALLOWED_PCT} % of it, or within the \
range that the publication gives.</p><details><summary>measured.csv as a table</summary>{}</details>",
            listed(&rows)
        ),
    }
}

/// Rows as a table.
fn listed(rows: &[Row]) -> String {
    let mut all = vec![strings([
        "quantity",
        "condition",
        "published",
        "± SD",
        "Calot",
        "error %",
        "within",
        "source",
    ])];
    for row in rows {
        all.push(vec![
            row.quantity.clone(),
            row.condition.clone(),
            short(row.published),
            row.published_sd.map_or_else(String::new, short),
            row.calot.map_or_else(|| "not modelled".to_owned(), short),
            row.error_pct()
                .map_or_else(String::new, |error| format!("{error:+.1}")),
            if row.within() { "yes" } else { "no" }.to_owned(),
            row.source.clone(),
        ]);
    }
    table(&all)
}

/// A number with three significant digits or more.
fn short(value: f64) -> String {
    let digits = match value.abs() {
        it if it >= 100.0 => 0,
        it if it >= 10.0 => 1,
        it if it >= 1.0 => 2,
        _ => 3,
    };
    number(value, digits)
}
