//! Compares Calot with published measurements.
//!
//! ```text
//! published figures ─┐
//! DATA/*.csv ────────┼→ Row → measured.csv, measured.html
//! Calot's solver ────┘
//! ```
//!
//! Every row names its publication and has Calot's result under the same condition. Calot's results
//! come from runs of its solver on organs and specimens that its preparation makes.

mod beam;
mod grasp;
mod lung;
mod page;
mod plates;
mod port;
mod published;
mod silicone;
mod specimen;
mod tissue;
mod work;

use std::path::{Path, PathBuf};

use clap::Args;

use crate::page::Section;

/// Options of `evaluate measured`.
#[derive(Args)]
pub(crate) struct MeasuredArgs {
    /// Folder for measured.csv and measured.html.
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Folder with measurements as CSV files: lung_pressing_01.csv and lung_cutting_01.csv. Without
    /// it the rows of the lung are left out, and the page says so.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Makes a reduced run that takes seconds instead of minutes: few spheres, few materials.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Runs only the parts whose name contains this: silicone, beam, lung, tissue, port. Or runs
    /// one silicone by its name, such as EF10_75T.
    #[arg(long, value_name = "TEXT")]
    case: Option<String>,
}

/// Largest allowed difference from a published value without a range, per cent.
const ALLOWED_PCT: f64 = 7.0;

/// Condition for Calot's value to agree with the published one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bar {
    /// It differs by at most [`ALLOWED_PCT`].
    Percent,
    /// It lies in this range.
    Range(f64, f64),
}

/// A row of the CSV file.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    /// Publication, by DOI, PubMed number or repository.
    source: String,
    /// Quantity with its unit.
    quantity: String,
    condition: String,
    published: f64,
    /// Standard deviation of the published value, if it has one.
    published_sd: Option<f64>,
    /// Calot's value; `None` if Calot does not model the effect.
    calot: Option<f64>,
    bar: Bar,
}

impl Row {
    /// Difference from the published value, per cent; `None` if Calot's value is absent or the
    /// published one is zero.
    fn error_pct(&self) -> Option<f64> {
        let calot = self.calot.filter(|_| self.published.abs() > 0.0)?;
        Some((calot / self.published - 1.0) * 100.0)
    }

    fn within(&self) -> bool {
        match (self.bar, self.calot) {
            (_, None) => false,
            (Bar::Percent, Some(_)) => self.error_pct().is_some_and(|it| it.abs() <= ALLOWED_PCT),
            (Bar::Range(low, high), Some(calot)) => (low..=high).contains(&calot),
        }
    }

    fn csv(&self) -> String {
        let number = |it: Option<f64>| it.map_or_else(String::new, |it| format!("{it:.4}"));
        format!(
            "\"{}\",\"{}\",\"{}\",{:.4},{},{},{},{}\n",
            self.source,
            self.quantity,
            self.condition,
            self.published,
            number(self.published_sd),
            number(self.calot),
            self.error_pct()
                .map_or_else(String::new, |it| format!("{it:.1}")),
            self.within()
        )
    }
}

/// A part of the measurement, named on the command line by `--case`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Silicone,
    Beam,
    Lung,
    Tissue,
    Port,
}

impl Part {
    const ALL: [Self; 5] = [
        Self::Silicone,
        Self::Beam,
        Self::Lung,
        Self::Tissue,
        Self::Port,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Silicone => "silicone",
            Self::Beam => "beam",
            Self::Lung => "lung",
            Self::Tissue => "tissue",
            Self::Port => "port",
        }
    }
}

/// All results.
#[derive(Debug, Default)]
pub(crate) struct Measured {
    silicone: silicone::Found,
    beam: Vec<Row>,
    lung: Option<lung::Found>,
    tissue: Vec<Row>,
    port: Vec<Row>,
}

impl Measured {
    fn rows(&self) -> impl Iterator<Item = &Row> {
        let lung = self.lung.iter().flat_map(|it| &it.rows);
        let first = self.silicone.rows.iter().chain(&self.beam);
        first.chain(lung).chain(&self.tissue).chain(&self.port)
    }
}

/// Runs the requested parts.
///
/// # Errors
/// The first fault, with its file if it has one, and the remedy.
pub(crate) fn run(asked: &MeasuredArgs) -> Result<Measured, String> {
    let only = asked.case.as_deref().unwrap_or_default();
    let silicones = published::SILICONES.iter();
    let named = silicones.map(|it| it.name).find(|name| *name == only);
    let is_asked = |part: &Part| match named {
        Some(_) => *part == Part::Silicone,
        None => part.name().contains(only),
    };
    let parts = Part::ALL.into_iter().filter(is_asked);
    let mut measured = Measured::default();
    let mut any = false;
    for part in parts {
        any = true;
        eprintln!("{}", part.name());
        match part {
            Part::Silicone => measured.silicone = silicone::run(asked.quick, named)?,
            Part::Beam => measured.beam = beam::run(asked.quick)?,
            Part::Lung => {
                let read = |folder: &Path| lung::run(folder, asked.quick);
                measured.lung = asked.data.as_deref().map(read).transpose()?;
            }
            Part::Tissue => measured.tissue = tissue::run(asked.quick)?,
            Part::Port => measured.port = port::run()?,
        }
    }
    match any {
        true => Ok(measured),
        false => Err(format!(
            "--case {only} names no part; allowed are parts of: silicone, beam, lung, tissue, port; or \
             the name of a silicone, such as EF10_75T"
        )),
    }
}

/// The CSV file.
pub(crate) fn csv(measured: &Measured) -> String {
    let head = "source,quantity,condition,published,published_sd,calot,error_pct,within\n";
    measured
        .rows()
        .fold(head.to_owned(), |text, row| text + &row.csv())
}

/// The sections of the page.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn sections(measured: &Measured) -> Result<Vec<Section>, String> {
    page::sections(measured)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::csv::split;

    fn asked(case: Option<&str>) -> MeasuredArgs {
        MeasuredArgs {
            out: PathBuf::new(),
            data: None,
            quick: true,
            case: case.map(str::to_owned),
        }
    }

    #[test]
    fn a_reduced_run_measures_every_part() {
        let measured = run(&asked(None)).expect("measured");
        let text = csv(&measured);
        assert!(text.lines().all(|line| split(line).len() == 8), "{text}");
        let find = |what: &str| {
            let mut rows = measured.rows();
            rows.find(|row| format!("{} {}", row.quantity, row.condition).contains(what))
                .unwrap_or_else(|| panic!("no row of {what} in {text}"))
        };
        // The modulus is fitted at 10 % strain; the law still holds at twice this strain.
        assert!(find("EF10_100T, 10 % strain, ends free").within());
        assert!(find("EF10_100T, 20 % strain, ends free").within());
        assert!(find("natural frequency").within());
        assert!(find("damping ratio").within());
        assert!(find("hepatic artery").calot.is_some_and(|it| it > 100.0));
        assert!(find("small strain").within());
        let relaxes = find("time constant of relaxation");
        assert!(relaxes.calot.is_none() && !relaxes.within());
        let dry = find("sliding shaft, N 5 mm shaft, 0.25 to 3 N; Calot: trocar = 'dry'");
        assert!(dry.within() && dry.calot.is_some_and(|it| (it - 0.87).abs() < 0.05));
        assert!(find("reversal, N 5 mm shaft, 0.2 to 2.5 N").within());
        assert!(find("work of the motors").within() && find("swing of the handle").within());
        assert!(find("moist shaft").within());
        assert!(find("retraction, N").calot.is_some_and(|it| it > 0.5));
        let pages = sections(&measured).expect("a page");
        let body: String = pages.iter().map(|it| it.body.as_str()).collect();
        assert!(body.contains("not modelled") && body.contains("--data"));
    }

    #[test]
    fn a_row_is_within_its_bar() {
        let row = |published, calot, bar| Row {
            source: "S, 1".to_owned(),
            quantity: "q".to_owned(),
            condition: "c".to_owned(),
            published,
            published_sd: None,
            calot,
            bar,
        };
        let close = row(100.0, Some(106.9), Bar::Percent);
        assert!(close.within());
        assert_eq!(
            close.csv(),
            "\"S, 1\",\"q\",\"c\",100.0000,,106.9000,6.9,true\n"
        );
        assert!(!row(100.0, Some(107.2), Bar::Percent).within());
        assert!(!row(100.0, None, Bar::Percent).within());
        let zero = row(0.0, Some(0.002), Bar::Range(-0.01, 0.01));
        assert!(zero.within() && zero.error_pct().is_none());
        assert!(!row(0.0, Some(0.02), Bar::Range(-0.01, 0.01)).within());
    }

    #[test]
    fn a_case_that_names_nothing_is_told() {
        let told = run(&asked(Some("wood"))).map(|_| ()).unwrap_err();
        assert!(told.contains("--case wood names no part"), "{told}");
    }
}
