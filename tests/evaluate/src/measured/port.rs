//! Compares the rendered friction of the trocar with published figures.

use rt_core::scene::Trocar;

use super::{Bar, Row};
use crate::haptics::strokes;

const DOBBELSTEEN: &str = "10.1007/s00464-006-9105-8";
const ALAZMANI: &str = "PMID 25825419";
const SLIDING: &str = "friction of the sliding shaft, N";
const JUMP: &str = "fluctuation of the friction at a start or reversal, N";
/// Sliding friction and jump that a scene asks for to reproduce the published ends of a range, N.
const ENDS_N: [[f32; 2]; 2] = [[0.25, 0.2], [3.0, 0.2]];
const WEAK_SEAL_N: f32 = 0.7;
const LARGEST_JUMP_N: f32 = 2.5;
const LARGEST_12_MM_N: f32 = 8.0;

/// Strokes through seals at the ends of the published ranges, and through the shipped ones.
///
/// # Errors
/// The message of the scene's check.
pub(super) fn run() -> Result<Vec<Row>, String> {
    let seal = |sliding_n: f32, jump_n: f32| {
        strokes(Trocar {
            sliding_n,
            breakaway_n: sliding_n + jump_n,
            ..Trocar::NONE
        })
    };
    let of = |published: f64, calot: f64, bar: Bar, source: &str, quantity: &str, seal: &str| Row {
        source: source.to_owned(),
        quantity: quantity.to_owned(),
        condition: format!("{seal}, as the emulated Touch renders it"),
        published,
        published_sd: None,
        calot: Some(calot),
        bar,
    };
    let mut rows = Vec::new();
    for [sliding_n, jump_n] in ENDS_N {
        let found = seal(sliding_n, jump_n)?;
        let condition = format!("5 mm shaft; Calot: a seal of {sliding_n} N");
        let (published, calot) = (f64::from(sliding_n), found.sliding_n);
        rows.push(of(
            published,
            calot,
            Bar::Percent,
            DOBBELSTEEN,
            SLIDING,
            &condition,
        ));
        if sliding_n < 1.0 {
            let (published, calot) = (f64::from(jump_n), found.reversal_n);
            rows.push(of(
                published,
                calot,
                Bar::Percent,
                DOBBELSTEEN,
                JUMP,
                &condition,
            ));
        }
    }
    let found = seal(WEAK_SEAL_N, LARGEST_JUMP_N)?;
    let condition = format!("5 mm shaft; Calot: a seal of {WEAK_SEAL_N} N with the largest jump");
    for calot in [found.start_n, found.reversal_n] {
        rows.push(of(
            LARGEST_JUMP_N.into(),
            calot,
            Bar::Percent,
            DOBBELSTEEN,
            JUMP,
            &condition,
        ));
    }
    let found = seal(LARGEST_12_MM_N, 0.0)?;
    let condition = "12 mm trocars; Calot: a seal of 8 N, beyond the Touch's 3.3 N";
    let published = f64::from(LARGEST_12_MM_N);
    rows.push(of(
        published,
        found.sliding_n,
        Bar::Percent,
        ALAZMANI,
        SLIDING,
        condition,
    ));
    rows.extend(shipped(of)?);
    Ok(rows)
}

/// The trocars that a station file names.
fn shipped(of: impl Fn(f64, f64, Bar, &str, &str, &str) -> Row) -> Result<Vec<Row>, String> {
    let tilted = |trocar: Trocar| strokes(trocar);
    let (dry, wet) = (tilted(Trocar::DRY)?, tilted(Trocar::WET)?);
    let mut rows = Vec::new();
    for (name, found) in [("dry", dry), ("wet", wet)] {
        let condition = format!("5 mm shaft, 0.25 to 3 N; Calot: trocar = '{name}'");
        let (mean_n, calot) = (0.87, found.sliding_n);
        rows.push(of(
            mean_n,
            calot,
            Bar::Range(0.25, 3.0),
            DOBBELSTEEN,
            SLIDING,
            &condition,
        ));
        let condition = format!("5 mm shaft, 0.2 to 2.5 N; Calot: trocar = '{name}'");
        let (mean_n, calot) = (0.71, found.reversal_n);
        rows.push(of(
            mean_n,
            calot,
            Bar::Range(0.2, 2.5),
            DOBBELSTEEN,
            JUMP,
            &condition,
        ));
        let condition = format!("a passive seal gives none; Calot: trocar = '{name}'");
        let given = "work of the motors on the hand, J";
        let passive = Bar::Range(f64::MIN, 0.0);
        rows.push(of(
            0.0,
            found.given_j,
            passive,
            DOBBELSTEEN,
            given,
            &condition,
        ));
        let condition = format!("a shaft at rest; Calot: trocar = '{name}', a firm hand");
        let still = Bar::Range(0.0, 0.11);
        let swing_mm = found.swing_m * 1e3;
        let swing = "swing of the handle, mm";
        rows.push(of(0.0, swing_mm, still, DOBBELSTEEN, swing, &condition));
    }
    rows.push(of(
        0.7,
        wet.sliding_n / dry.sliding_n,
        Bar::Range(0.55, 0.85),
        DOBBELSTEEN,
        "friction of a moist shaft over a dry one",
        "5 mm shaft, 15 to 45 % less; Calot: trocar = 'wet' over 'dry'",
    ));
    Ok(rows)
}
