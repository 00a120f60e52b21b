//! Compares published values of organs and instruments with Calot's results under the same
//! condition. Also lists effects that Calot does not model.

use rt_core::scene::Relaxation;
use rt_core::tool::{Capsule, Role};
use scene_prepare::recipe::Material;
use shared_mem::scene::OrganKind;

use super::plates::{Ends, Setting, press};
use super::published::{MISSING, Missing};
use super::silicone::SPECIMEN;
use super::specimen::Cylinder;
use super::{Bar, Row, grasp};
use crate::body::{Tissue, V3};
use crate::methods::{Parts, Surroundings};

/// A piece of liver on a table, under an indenter.
const PIECE: Cylinder = Cylinder {
    radius_m: 0.060,
    height_m: 0.050,
};
/// Radius of the indenter, m.
const INDENTER_M: f64 = 0.005;
const DEPTHS_MM: [f64; 3] = [1.0, 3.0, 6.0];
/// Speed of the indenter, m/s.
const SPEED_M_S: f64 = 0.02;
/// Time for which the indenter stays at a depth before its force is read, s.
const REST_S: f64 = 0.5;
/// Time for which the last depth is held, s.
const HOLD_S: f64 = 10.0;
/// Smallest relative fall of the force of a held press that counts as relaxation.
const RELAXES: f64 = 0.02;
/// A duct or vessel in tension.
const TUBE: Cylinder = Cylinder {
    radius_m: 0.002,
    height_m: 0.040,
};
const BEADS: usize = 20;
/// Length of tube in each grip, m. Preparation makes the last beads thin, because they lie in the
/// tube's round end.
const GRIPPED_M: f64 = 0.006;
/// Strains between which the modulus of a tube is measured. Below the first, its beads still align.
const TUBE_STRAINS: [f64; 2] = [0.03, 0.06];
/// Strain of solids at which a modulus is measured.
const SMALL_STRAIN: f64 = 0.02;
/// Time constants of a held press, s (Kerdok 2006).
const TIMES_S: [f64; 2] = [1.86, 51.3];
/// Shares of the stress that the two terms lose. Assumed: the source's abstract gives none.
const LOST_SHARES: [f32; 2] = [0.3, 0.3];
/// Times of a held press between which its slow term and its fast one are found, s. At the first
/// three, the fast term is over.
const SLOW_AT_S: [f64; 3] = [20.0, 60.0, 100.0];
const FAST_AT_S: [f64; 2] = [0.5, 2.5];
/// Source of the shear moduli: one table.
const SHEAR: &str = "PMC6925591, Table 1";
const KERDOK: &str = "Kerdok 2006, PMID 16126215";
const BARRIE: &str = "Barrie, eprints.whiterose.ac.uk 87750";
/// Time for which retracting surgeons hold bowel, s (same source).
const RETRACT_S: f64 = 3.87;

/// Measures, and adds the rows of effects that Calot does not model.
///
/// # Errors
/// Calot's message if it refuses a specimen.
pub(super) fn run(quick: bool) -> Result<Vec<Row>, String> {
    let spheres = if quick { 250 } else { 581 };
    let mut rows = solids(spheres)?;
    rows.extend(tubes()?);
    rows.extend(indentation(spheres)?);
    rows.extend(relaxation(spheres, if quick { 0.1 } else { 1.0 })?);
    let seeds = if quick { 1 } else { 5 };
    rows.extend(retraction(seeds, false)?);
    rows.extend(retraction(seeds, true)?);
    rows.extend(MISSING.iter().map(missing));
    Ok(rows)
}

/// Material of a kind of organ in the built-in scenes.
fn typical(kind: OrganKind) -> Tissue {
    let material = Material::typical(kind);
    Tissue {
        young_pa: material.young_pa,
        poisson: material.poisson,
        density_kg_m3: material.density_kg_m3,
    }
}

fn row(source: &str, quantity: &str, condition: String) -> Row {
    Row {
        source: source.to_owned(),
        quantity: quantity.to_owned(),
        condition,
        published: 0.0,
        published_sd: None,
        calot: None,
        bar: Bar::Percent,
    }
}

fn solids(spheres: usize) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let liver = typical(OrganKind::Liver);
    let body = SPECIMEN.body(spheres, liver)?;
    let depths_m = [SMALL_STRAIN, 0.5].map(|it| it * SPECIMEN.height_m);
    let shear_kpa = |force_n: f64| force_n / SPECIMEN.area_m2() / SMALL_STRAIN / 3e3;
    let pressed = press(&body, liver, Ends::Free, Setting::SHIPPED, &depths_m)?;
    rows.push(Row {
        published: 1.8,
        published_sd: Some(0.4),
        calot: Some(shear_kpa(pressed[0].force_n)),
        bar: Bar::Range(1.8 - 2.0 * 0.4, 1.8 + 2.0 * 0.4),
        ..row(
            SHEAR,
            "shear modulus, kPa",
            "liver, small strain; Calot: a third of the modulus between plates".to_owned(),
        )
    });
    rows.push(Row {
        published: 34.7,
        calot: Some(pressed[1].force_n / SPECIMEN.area_m2() / 1e3),
        ..row(
            KERDOK,
            "nominal stress at 50 % nominal strain, kPa",
            "perfused porcine liver, pressed; Calot: liver between plates, ends free".to_owned(),
        )
    });
    let gallbladder = typical(OrganKind::Gallbladder);
    let pressed = press(
        &body,
        gallbladder,
        Ends::Free,
        Setting::SHIPPED,
        &depths_m[..1],
    )?;
    rows.push(Row {
        published: 85.0,
        calot: Some(shear_kpa(pressed[0].force_n)),
        ..row(
            SHEAR,
            "shear modulus, kPa",
            "wall of the gallbladder; Calot: a solid that bends as the wall and bile do".to_owned(),
        )
    });
    Ok(rows)
}

fn tubes() -> Result<Vec<Row>, String> {
    let tube = |kind: OrganKind, name: &str, published: f64| {
        let tissue = typical(kind);
        let (body, length_m) = TUBE.tube(kind, BEADS, GRIPPED_M, tissue)?;
        let depths_m = TUBE_STRAINS.map(|it| -it * length_m);
        let pulled = press(&body, tissue, Ends::Bonded, Setting::SHIPPED, &depths_m)?;
        let more_n = pulled[0].force_n - pulled[1].force_n;
        let modulus_pa = more_n / TUBE.area_m2() / (TUBE_STRAINS[1] - TUBE_STRAINS[0]);
        Ok::<_, String>(Row {
            published,
            calot: Some(modulus_pa / 3e3),
            ..row(
                SHEAR,
                "shear modulus, kPa",
                format!(
                    "{name}; Calot: a third of the modulus in tension, over the whole cross-section"
                ),
            )
        })
    };
    Ok(vec![
        tube(OrganKind::CysticDuct, "bile duct", 166.0)?,
        tube(OrganKind::CysticArtery, "hepatic artery", 210.0)?,
    ])
}

/// Presses a ball into a piece of liver, and holds the last depth.
fn indentation(spheres: usize) -> Result<Vec<Row>, String> {
    let liver = typical(OrganKind::Liver);
    let (body, skin) = PIECE.on_table(spheres, liver)?;
    let around = Surroundings::weightless(&liver);
    let mut parts = Parts::new(&body, &around, None)
        .map_err(|e| e.to_string())?
        .with_skin(skin);
    let mut solved = parts.bare().map_err(|e| e.to_string())?;
    let mut at = |depth_m: f64| {
        let center_m = V3::new(0.0, 0.0, (PIECE.height_m + INDENTER_M - depth_m) as f32);
        let tip = Capsule {
            a_m: center_m,
            b_m: center_m,
            radius_m: INDENTER_M as f32,
            role: Role::Tip,
        };
        f64::from(solved.press(&[tip]).force_n.z)
    };
    let mut rows = Vec::new();
    let (mut from_m, mut first_n) = (0.0, 0.0);
    for depth_mm in DEPTHS_MM {
        let to_m = depth_mm * 1e-3;
        let ticks = ((to_m - from_m) / SPEED_M_S * 1e3).ceil() as usize;
        for i in 1..=ticks {
            at(from_m + (to_m - from_m) * i as f64 / ticks as f64);
        }
        from_m = to_m;
        for _ in 0..(REST_S * 1e3) as usize {
            first_n = at(to_m);
        }
        // Modulus for which Hertz's law gives this force.
        let hertz_pa = 0.75 * first_n * (1.0 - liver.poisson * liver.poisson)
            / (INDENTER_M.sqrt() * to_m.powf(1.5));
        rows.push(Row {
            published: 270.0,
            calot: Some(hertz_pa / 1e3),
            ..row(
                "Carter 2001, strathprints",
                "Young's modulus under a small indenter, kPa",
                format!(
                    "human liver in vivo; Calot: by Hertz's law under a ball of {:.0} mm radius, \
                     {depth_mm} mm deep",
                    INDENTER_M * 1e3
                ),
            )
        });
    }
    let mut last_n = first_n;
    for _ in 0..(HOLD_S * 1e3) as usize {
        last_n = at(from_m);
    }
    let lost = 1.0 - last_n / first_n;
    // A time constant exists only if the force of the held press falls.
    let constant_s = (lost > RELAXES).then(|| -HOLD_S / (1.0 - lost).ln());
    for published in [1.86, 51.3] {
        rows.push(Row {
            published,
            calot: constant_s,
            ..row(
                KERDOK,
                "time constant of relaxation, s",
                format!(
                    "perfused porcine liver; Calot: held {from_m_mm} mm deep for {HOLD_S} s, force \
                     changed by {changed:.2} %",
                    from_m_mm = DEPTHS_MM[DEPTHS_MM.len() - 1],
                    changed = lost.abs() * 100.0
                ),
            )
        });
    }
    Ok(rows)
}

/// Presses a piece of liver that relaxes, holds it, and finds the two time constants in its force.
/// The constants asked for, and all times, are the published ones times `scale`.
fn relaxation(spheres: usize, scale: f64) -> Result<Vec<Row>, String> {
    let liver = typical(OrganKind::Liver);
    let (body, skin) = PIECE.on_table(spheres, liver)?;
    let around = Surroundings::weightless(&liver);
    let asked = Relaxation {
        shares: LOST_SHARES,
        times_s: TIMES_S.map(|s| (s * scale) as f32),
    };
    let parts = Parts::new(&body, &around, None).map_err(|e| e.to_string())?;
    let mut parts = parts.with_skin(skin).relaxing(asked);
    let mut solved = parts.bare().map_err(|e| e.to_string())?;
    let depth_m = DEPTHS_MM[DEPTHS_MM.len() - 1] * 1e-3;
    let mut at = |depth_m: f64| {
        let center_m = V3::new(0.0, 0.0, (PIECE.height_m + INDENTER_M - depth_m) as f32);
        let tip = Capsule {
            a_m: center_m,
            b_m: center_m,
            radius_m: INDENTER_M as f32,
            role: Role::Tip,
        };
        f64::from(solved.press(&[tip]).force_n.z)
    };
    let ticks = (depth_m / SPEED_M_S * 1e3).ceil() as usize;
    for i in 1..=ticks {
        at(depth_m * i as f64 / ticks as f64);
    }
    let tick_of = |at_s: f64| (at_s * scale * 1e3) as usize;
    let held_n: Vec<f64> = (0..=tick_of(SLOW_AT_S[2])).map(|_| at(depth_m)).collect();
    let force_n = |at_s: f64| held_n[tick_of(at_s)];
    let [early_n, middle_n, late_n] = SLOW_AT_S.map(force_n);
    let [early_s, middle_s, _] = SLOW_AT_S;
    let kept = (middle_n - late_n) / (early_n - middle_n);
    let slow_s = -(middle_s - early_s) / kept.ln();
    let lost_n = (early_n - middle_n) / (1.0 - kept);
    let slow_n = |at_s: f64| lost_n * ((early_s - at_s) / slow_s).exp();
    let fast_n = FAST_AT_S.map(|at_s| force_n(at_s) - (early_n - lost_n) - slow_n(at_s));
    let fast_s = -(FAST_AT_S[1] - FAST_AT_S[0]) / (fast_n[1] / fast_n[0]).ln();
    let rows = TIMES_S.into_iter().zip([fast_s, slow_s]);
    let rows = rows.map(|(published, found_s)| Row {
        published,
        calot: Some(found_s),
        ..row(
            KERDOK,
            "time constant of relaxation, s",
            format!(
                "perfused porcine liver; Calot: liver that asks for these times and loses shares of {} and {}, \
                 held 6 mm deep for {} s",
                LOST_SHARES[0], LOST_SHARES[1], SLOW_AT_S[2]
            ),
        )
    });
    Ok(rows.collect())
}

/// Pulls at the gallbladder of the built-in scene with a grasper.
fn retraction(seeds: u64, relaxes: bool) -> Result<Vec<Row>, String> {
    let asked = relaxes.then_some((LOST_SHARES, TIMES_S.map(|s| s as f32)));
    let pulls = grasp::pulls("gallbladder", seeds, RETRACT_S, asked)?;
    let largest: Vec<f64> = pulls.iter().map(|it| it.largest_n).collect();
    let left: Vec<f64> = pulls.iter().filter_map(|it| it.left).collect();
    let condition = format!(
        "porcine gallbladder, at the handle; Calot: built-in scene{}, {} places pulled by 30 mm, {} \
         slipped, as the emulated Touch renders it",
        if relaxes {
            " whose gallbladder relaxes as perfused liver"
        } else {
            ""
        },
        pulls.len(),
        pulls.len() - left.len()
    );
    let peak = Row {
        published: 50.7,
        published_sd: Some(3.8),
        calot: Some(statistics::median(&largest)),
        ..row(
            BARRIE,
            "largest force of a retraction, N",
            condition.clone(),
        )
    };
    // The source states root mean squares of less than 10 to 25 N.
    let rest = Row {
        published: 25.0 / 50.7,
        calot: (!left.is_empty()).then(|| statistics::median(&left)),
        bar: Bar::Range(0.0, 25.0 / 50.7),
        ..row(
            BARRIE,
            "force left in a held retraction over its peak",
            format!("{condition}, held for {RETRACT_S} s; published: at most"),
        )
    };
    Ok(vec![peak, rest])
}

fn missing(it: &Missing) -> Row {
    Row {
        published: it.published,
        published_sd: it.sd,
        ..row(
            it.source,
            it.quantity,
            format!("{}; Calot: {}", it.condition, it.reason),
        )
    }
}
