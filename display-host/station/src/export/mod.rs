//! `calot export`: writes a session as tables that other programs read.

pub(crate) mod args;
mod columnar;
mod columns;
mod counted;
mod csv;
mod surfaces;
mod table;
mod ticks;

use std::cell::Cell as Shared;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use rt_process::replay::Replay;
use serde::Serialize;
use session::{Session, Times};

use self::args::ExportArgs;
use self::columnar::Columnar;
use self::counted::Counted;
use self::csv::Csv;
use self::surfaces::Surfaces;
use self::table::{Cell, Column, Sheet};
use self::ticks::Rows;
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::replay::judge::{Different, Judge};
use crate::replay::recorded::{LeftOut, scene_of, without_gap};
use crate::report;
use crate::say;
use crate::sessions;

/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(1);

/// Result of an export.
#[derive(Debug, Serialize)]
struct ExportOutcome {
    session: PathBuf,
    /// Files that were written.
    files: Vec<PathBuf>,
    ticks: u64,
    events: u64,
    /// Pictures in the file of surfaces.
    pictures: usize,
    /// True if ticks were computed again, all are equal to the recorded ones, and none is known to
    /// be missing.
    same: bool,
    first_difference: Option<Different>,
    #[serde(flatten)]
    left_out: LeftOut,
}

/// A folder of tables in one format.
struct Target<'a> {
    folder: &'a Path,
    extension: &'static str,
}

impl Target<'_> {
    fn file(&self, table: &str) -> PathBuf {
        self.folder.join(format!("{table}.{}", self.extension))
    }

    fn create(&self, table: &str, columns: &[Column]) -> Result<Box<dyn Sheet>, Problem> {
        let path = self.file(table);
        let made: std::io::Result<Box<dyn Sheet>> = match self.extension {
            CSV => Csv::create(&path, columns).map(|it| Box::new(it) as _),
            _ => Columnar::create(&path, columns).map(|it| Box::new(it) as _),
        };
        Ok(made.map_err(|error| format!("{}: {error}", path.display()))?)
    }
}

const CSV: &str = "csv";
const PARQUET: &str = "parquet";

/// A table in every requested format.
struct Tables {
    sheets: Vec<(PathBuf, Box<dyn Sheet>)>,
}

impl Tables {
    fn create(targets: &[Target<'_>], table: &str, columns: &[Column]) -> Result<Self, Problem> {
        let one = |target: &Target<'_>| Ok((target.file(table), target.create(table, columns)?));
        let sheets = targets.iter().map(one).collect::<Result<_, Problem>>()?;
        Ok(Self { sheets })
    }

    fn add(&mut self, row: &[Cell]) -> Result<(), Problem> {
        for (path, sheet) in &mut self.sheets {
            let added = sheet.add(row);
            added.map_err(|error| format!("{}: {error}", path.display()))?;
        }
        Ok(())
    }

    /// Completes the files. Returns their paths.
    fn end(self) -> Result<Vec<PathBuf>, Problem> {
        let mut paths = Vec::new();
        for (path, sheet) in self.sheets {
            let ended = sheet.end();
            ended.map_err(|error| format!("{}: {error}", path.display()))?;
            paths.push(path);
        }
        Ok(paths)
    }
}

pub(crate) fn run(args: &ExportArgs) -> Result<ExitCode, Problem> {
    let args = &ExportArgs {
        session: sessions::find(&args.session)?,
        ..args.clone()
    };
    let file = report::recording(&args.session);
    let wanted = [(&args.csv, CSV), (&args.parquet, PARQUET)];
    let mut targets = Vec::new();
    for (folder, extension) in wanted {
        let Some(folder) = folder else { continue };
        let option = format!("--{extension}");
        output::check_folder(&option, folder, Format::of_export, args.overwrite)?;
        targets.push(Target { folder, extension });
    }
    if let Some(path) = &args.surfaces {
        output::check("--surfaces", path, Format::Surfaces, args.overwrite)?;
    }
    let mut session = Session::open(&file)?;
    let scene = scene_of(&mut session, args.scene.as_deref())?;
    for target in &targets {
        let made = std::fs::create_dir_all(target.folder);
        made.map_err(|error| format!("{}: {error}", target.folder.display()))?;
    }
    let replay = Replay::new(&scene, &session.setup)?;
    let mut surfaces = match &args.surfaces {
        Some(path) => Some(Surfaces::create(path, args.surfaces_hz, &scene)?),
        None => None,
    };
    let written = write_ticks(&replay, &mut session, &file, &targets, surfaces.as_mut());
    let (mut outcome, first_ns) = written?;
    let wall_from_host_ns = session.info.wall_from_host_ns;
    if let Some(mut surfaces) = surfaces {
        if args.pictures {
            outcome.pictures = surfaces.pictures(&args.session, wall_from_host_ns)?;
        }
        outcome.files.push(surfaces.end()?);
    }
    write_events(
        &mut outcome,
        &file,
        &targets,
        replay.organs(),
        first_ns,
        wall_from_host_ns,
    )?;
    write_metrics(&mut outcome, &file, &targets)?;
    write_columns(&mut outcome, &targets)?;
    if args.json {
        document::EXPORT.answer(&outcome)?;
    }
    for line in in_words(&outcome) {
        say::note(line);
    }
    Ok(match outcome.same {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

/// Writes the table of ticks. Returns the outcome so far, and the host time of the first tick.
fn write_ticks(
    replay: &Replay,
    session: &mut Session,
    file: &Path,
    targets: &[Target<'_>],
    mut surfaces: Option<&mut Surfaces>,
) -> Result<(ExportOutcome, u64), Problem> {
    let mut tables = Tables::create(targets, "ticks", &ticks::columns())?;
    let mut times = Times::open(file)?;
    let mut counted = Counted::open(file)?;
    let wall_from_host_ns = session.info.wall_from_host_ns;
    let mut rows = Rows::new(wall_from_host_ns);
    let (done, gap) = (Shared::new(0.0), Shared::new(None));
    let (mut said, mut count, mut failed) = (Instant::now(), 0, None);
    let mut judge = Judge::default();
    replay.run(without_gap(session, &gap, &done), |replayed| {
        count += 1;
        let tick = replayed.view.tick;
        let row = rows.row(replayed, counted.at_tick(tick), times.of(tick));
        let now_ns = replayed.record.now_ns;
        let passed = columns::seconds(rows.first_ns(), now_ns);
        let wall_ns = now_ns.saturating_add_signed(wall_from_host_ns);
        let surfaces = surfaces.as_deref_mut();
        let added = tables
            .add(&row)
            .and_then(|()| surfaces.map_or(Ok(()), |it| it.take(replayed, passed, wall_ns)));
        if let Err(problem) = added {
            failed = Some(problem);
            return false;
        }
        if said.elapsed() >= PROGRESS {
            said = Instant::now();
            say::note(format_args!("exporting {:3.0} %", done.get() * 100.0));
        }
        judge.look(replayed, passed, replay.organs());
        true
    })?;
    if let Some(problem) = failed {
        return Err(problem);
    }
    let left_out = LeftOut::of(session, gap.get());
    let outcome = ExportOutcome {
        session: file.to_owned(),
        files: tables.end()?,
        ticks: count,
        events: 0,
        pictures: 0,
        same: count > 0 && judge.first.is_none() && !left_out.is_known(),
        first_difference: judge.first,
        left_out,
    };
    Ok((outcome, rows.first_ns()))
}

fn write_events(
    outcome: &mut ExportOutcome,
    file: &Path,
    targets: &[Target<'_>],
    organs: &[String],
    first_ns: u64,
    wall_from_host_ns: i64,
) -> Result<(), Problem> {
    let mut tables = Tables::create(targets, "events", &columns::events())?;
    let mut counted = Counted::open(file)?;
    while let Some((entry, counted)) = counted.entry() {
        let row = columns::event((&entry, counted), organs, first_ns, wall_from_host_ns);
        if let Some(row) = row {
            outcome.events += 1;
            tables.add(&row)?;
        }
    }
    outcome.files.extend(tables.end()?);
    Ok(())
}

fn write_metrics(
    outcome: &mut ExportOutcome,
    file: &Path,
    targets: &[Target<'_>],
) -> Result<(), Problem> {
    let mut tables = Tables::create(targets, "metrics", &columns::metrics())?;
    let found = report::chapter(file, None, None)?;
    for row in columns::metric_rows(&found.chapter.assessed) {
        tables.add(&row)?;
    }
    outcome.files.extend(tables.end()?);
    Ok(())
}

/// Writes the table that explains the columns of the other tables.
fn write_columns(outcome: &mut ExportOutcome, targets: &[Target<'_>]) -> Result<(), Problem> {
    let mut tables = Tables::create(targets, "columns", &columns::columns())?;
    for (table, of) in [
        ("ticks", ticks::columns()),
        ("events", columns::events()),
        ("metrics", columns::metrics()),
    ] {
        for row in columns::column_rows(table, &of) {
            tables.add(&row)?;
        }
    }
    outcome.files.extend(tables.end()?);
    Ok(())
}

fn in_words(outcome: &ExportOutcome) -> Vec<String> {
    let (ticks, events) = (outcome.ticks, outcome.events);
    let files = outcome
        .files
        .iter()
        .map(|it| format!("wrote {}", it.display()));
    let words = match &outcome.first_difference {
        Some(first) => format!(
            "{}. This program does not compute what was recorded: the tables hold what it computes; \
             export with the program that recorded",
            first.in_words()
        ),
        None => format!("{ticks} ticks and {events} events; the ticks came out as recorded"),
    };
    let pictures = (outcome.pictures > 0).then(|| format!("{} pictures", outcome.pictures));
    let left_out = outcome.left_out.in_words();
    files
        .chain([words])
        .chain(pictures)
        .chain(left_out)
        .collect()
}
