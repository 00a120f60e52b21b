//! `calot report`: reports the results of recorded sessions as a page or as JSON.

pub(crate) mod args;
pub(crate) mod pictures;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use assess::report::{CLOSE_MAX, Chapter, Lesson, Outlines, Ticks, close_picture, html};
use assess::{Anatomy, Assessment, Difficulty, Metric, Rules, Task};
use display_host::words::{Language, Words};
use session::{Assignment, End, Operation};
use store::Hand;

use self::args::ReportArgs;
pub(crate) use self::pictures::Wanted;
use crate::args::LanguageName;
use crate::document;
use crate::output::{self, CLOSE, Format};
use crate::problem::Problem;
use crate::say;
use crate::sessions;

/// Largest number of pictures of a session in the page.
const PICTURES_MAX: usize = 12;
/// Largest picture in the page, bytes. Larger ones are left out.
const PICTURE_MAX_BYTES: u64 = 8 << 20;
/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(1);

pub(crate) fn run(args: &ReportArgs) -> Result<ExitCode, Problem> {
    if args.metrics {
        for metric in Metric::ALL {
            say::answer(format_args!(
                "{:<20} {:<4} {} [{}]",
                metric.name(),
                metric.unit(),
                metric.definition(),
                metric.source()
            ));
        }
        return Ok(ExitCode::SUCCESS);
    }
    if args.rules_file {
        say::answer(Rules::built_in().trim_end());
        return Ok(ExitCode::SUCCESS);
    }
    let rules = args.rules.as_deref().map(Rules::read).transpose()?;
    let out = match args.json {
        true => None,
        false => {
            let named = args.out.as_deref();
            Some(output::file(
                named,
                "debrief.html",
                Format::Page,
                args.overwrite,
            )?)
        }
    };
    let words = Words::new(LanguageName::or_users(args.language));
    let mut chapters = Vec::new();
    let (mut found, mut whole) = (Vec::new(), true);
    for typed in &args.sessions {
        let session = &sessions::find(typed)?;
        let Found {
            mut chapter,
            left_out,
            file,
            wanted,
            ..
        } = chapter(session, rules.as_ref(), args.task)?;
        if !chapter.is_scripted {
            chapter.trainee = sessions::trainee(typed, session);
        }
        if args.pictures {
            let drawn = pictures::draw(&file, &wanted, &words)?;
            let drawn = drawn.into_iter().map(|it| (it.caption, it.png));
            chapter.pictures.splice(0..0, drawn);
        }
        for warning in left_out.in_words() {
            say::note(format_args!("warning: {}: {warning}", chapter.name));
        }
        whole &= left_out.damaged().is_none();
        if args.json {
            found.push(with_left_out(&chapter, &left_out)?);
        }
        chapters.push(chapter);
    }
    match &out {
        None => document::REPORT.array(found)?,
        Some(out) => write(&chapters, words.language(), out)?,
    }
    Ok(if whole {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Result of reading a recording.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) chapter: Chapter,
    pub(crate) left_out: LeftOut,
    /// File of the recording.
    file: PathBuf,
    /// Task and settings of the session. `None`: it had no task.
    pub(crate) assignment: Option<Assignment>,
    /// Start of the session, s since 1970.
    pub(crate) began_unix_s: u64,
    /// Pictures to draw.
    pub(crate) wanted: Vec<Wanted>,
}

/// Data known to be missing from a recording.
#[derive(Debug, Default, serde::Serialize)]
pub(crate) struct LeftOut {
    /// Place where the recording breaks off, for example because its recorder was killed.
    broken_off: Option<String>,
    /// Place and kind of damage.
    damaged: Option<String>,
    /// Messages and spans that the recording lost before it was repaired.
    lost: Option<String>,
    /// Ticks that ran and were not recorded.
    missing_ticks: u64,
    /// Events that happened and were not recorded.
    missing_events: u64,
}

impl LeftOut {
    fn of(operation: &Operation) -> Self {
        let (mut broken_off, mut damaged, mut lost) = (None, None, None);
        match operation.end() {
            Some(End::BrokenOff(why)) => broken_off = Some(why.clone()),
            Some(End::Damaged(why)) => damaged = Some(why.clone()),
            Some(End::Lost(what)) => lost = Some(what.clone()),
            Some(End::Whole) | None => {}
        }
        Self {
            broken_off,
            damaged,
            lost,
            missing_ticks: operation.finish().map_or(0, |it| it.missing),
            missing_events: operation.finish().map_or(0, |it| it.missing_events),
        }
    }

    /// Reason for an early end of the recording, or a hole in it, if any.
    pub(crate) fn cut_short(&self) -> Option<&String> {
        self.damaged().or(self.broken_off.as_ref())
    }

    /// Place and kind of damage, or the parts that it destroyed, if any.
    pub(crate) fn damaged(&self) -> Option<&String> {
        self.damaged.as_ref().or(self.lost.as_ref())
    }

    /// One warning per kind of missing data.
    pub(crate) fn in_words(&self) -> Vec<String> {
        let after = "what came after is not in the figures";
        let lost = self.lost.as_ref();
        let lost = lost.map(|what| format!("the session was damaged: {what}; the figures lack it"));
        let damaged = self.damaged.as_ref();
        let damaged = damaged.map(|why| format!("the session is damaged {why}; {after}"));
        let broken_off = self.broken_off.as_ref();
        let broken_off = broken_off.map(|why| format!("the session breaks off ({why}); {after}"));
        let missing = (self.missing_ticks > 0)
            .then(|| format!("{} ticks ran and were not recorded", self.missing_ticks));
        let events = (self.missing_events > 0).then(|| {
            let events = self.missing_events;
            format!("{events} events happened and were not recorded; they are not in the figures")
        });
        let early = damaged.into_iter().chain(lost).chain(broken_off);
        early.chain(missing).chain(events).collect()
    }
}

/// Result of a session as JSON, with the missing data of its recording.
fn with_left_out(chapter: &Chapter, left_out: &LeftOut) -> Result<serde_json::Value, Problem> {
    let mut value = serde_json::to_value(&chapter.assessed)?;
    if let Some(object) = value.as_object_mut() {
        object.insert("session".to_owned(), chapter.name.clone().into());
        object.insert("case".to_owned(), serde_json::to_value(&chapter.case)?);
        object.insert("hand".to_owned(), hand(chapter.is_scripted).name().into());
        let cut_short = serde_json::to_value(left_out.cut_short())?;
        object.insert("cut_short".to_owned(), cut_short);
        object.insert("left_out".to_owned(), serde_json::to_value(left_out)?);
    }
    Ok(value)
}

/// The hand that worked a session.
pub(crate) fn hand(is_scripted: bool) -> Hand {
    match is_scripted {
        true => Hand::Scripted,
        false => Hand::Person,
    }
}

/// Writes the page in a language, and prints its path.
pub(crate) fn write(chapters: &[Chapter], language: Language, out: &Path) -> Result<(), Problem> {
    let page = html(chapters, &Words::new(language));
    let write = || {
        let mut file = session::create_private(out)?;
        std::io::Write::write_all(&mut file, page.as_bytes())
    };
    write().map_err(|error: std::io::Error| {
        format!(
            "{}: {error}; choose another place with --out",
            out.display()
        )
    })?;
    say::note(format_args!("wrote {}", out.display()));
    Ok(())
}

/// Writes a close picture of each lesson's first error next to the page, for the launcher. Leaves
/// out lessons after the first [`CLOSE_MAX`], and pictures that cannot be written.
pub(crate) fn write_close(chapter: &Chapter, folder: &Path) {
    let it = &chapter.assessed;
    for lesson in Lesson::of(&it.alarms).iter().take(CLOSE_MAX) {
        let Some((number, alarm)) = lesson
            .alarms
            .first()
            .and_then(|number| Some((*number, it.alarms.get(*number)?)))
        else {
            continue;
        };
        let hands = it.hands.get(number).and_then(Option::as_ref);
        let picture = close_picture(
            &chapter.outlines,
            (alarm.organ.as_deref(), alarm.at_m),
            hands,
        );
        let written = picture.map_or(Ok(()), |picture| {
            let file = session::create_private(&close_file(folder, number))?;
            display_host::picture::write_png(&picture, file)
        });
        if let Err(error) = written {
            say::note(format_args!("calot: a close picture is missing: {error}"));
        }
    }
}

/// Path of the close picture of the alarm with this number.
pub(crate) fn close_file(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("{CLOSE}{number:04}.png"))
}

/// Path of a session's recording: the session itself, or the file `session.mcap` in it if it is a
/// folder.
pub(crate) fn recording(session: &Path) -> PathBuf {
    match session.is_dir() {
        true => session.join("session.mcap"),
        false => session.to_owned(),
    }
}

/// Assesses a session: a file, or a folder with `session.mcap` and perhaps pictures. `rules` and
/// `task` replace those of the session. Also returns the missing data.
pub(crate) fn chapter(
    session: &Path,
    rules: Option<&Rules>,
    task: Option<Task>,
) -> Result<Found, Problem> {
    let (file, folder) = (recording(session), session.is_dir().then_some(session));
    let mut operation = Operation::open(&file)?;
    let assigned = operation.assignment.clone().unwrap_or_default();
    let (mut assessment, rules) = assessment(&operation, &file, rules, task)?;
    let mut watch = pictures::Watch::default();
    let mut began_ns = None;
    let mut said = Instant::now();
    while let Some(entry) = operation.next() {
        began_ns.get_or_insert(entry.at_ns);
        assessment.take(&entry);
        watch.look(entry.tick, &assessment);
        if said.elapsed() >= PROGRESS {
            let share = 100.0 * operation.done();
            say::note(format_args!("{}: {share:.0} %", file.display()));
            said = Instant::now();
        }
    }
    let wall_ns = began_ns
        .unwrap_or(0)
        .saturating_add_signed(operation.info.wall_from_host_ns);
    let began_unix_s = wall_ns / 1_000_000_000;
    let left_out = LeftOut::of(&operation);
    let chapter = Chapter {
        name: file.display().to_string(),
        trainee: None,
        technical: None,
        scene: operation.info.scene.clone(),
        case: crate::scene::case(&operation.info.scene),
        build: operation.info.build.clone(),
        when: utc(began_unix_s),
        assessed: assessment.end(),
        rules,
        outlines: Outlines::of(&operation.scene),
        pictures: folder.map(pictures_in).unwrap_or_default(),
        ticks: folder.and_then(ticks),
        is_scripted: assigned.is_scripted,
        cut_short: left_out.cut_short().cloned(),
        past: Vec::new(),
        sheet: Vec::new(),
    };
    Ok(Found {
        chapter,
        left_out,
        file,
        assignment: operation.assignment.take(),
        began_unix_s,
        wanted: watch.end(),
    })
}

/// The assessment of the operation in `file` before its first entry, and its rules. `rules` and
/// `task` replace those of the session.
pub(crate) fn assessment(
    operation: &Operation,
    file: &Path,
    rules: Option<&Rules>,
    task: Option<Task>,
) -> Result<(Assessment, Rules), Problem> {
    let assigned = operation.assignment.clone().unwrap_or_default();
    let task = task.or_else(|| Task::from_name(&assigned.task));
    let rules = match rules {
        Some(rules) => rules.clone(),
        None if assigned.rules.is_empty() => Rules::default(),
        None => {
            Rules::parse(&assigned.rules).map_err(|error| format!("{}: {error}", file.display()))?
        }
    };
    let assessment = Assessment::new(
        task.unwrap_or(Task::Free),
        Difficulty::from_name(&assigned.difficulty).unwrap_or_default(),
        rules.clone(),
        Anatomy::of(&operation.scene),
    );
    Ok((assessment, rules))
}

/// Tick times from the summary in a session's folder.
pub(crate) fn ticks(folder: &Path) -> Option<Ticks> {
    let text = std::fs::read(folder.join("summary.json")).ok()?;
    serde_json::from_slice(&text).ok()
}

/// Pictures in a session's folder.
fn pictures_in(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder);
    chosen(entries.into_iter().flatten().flatten().map(|it| it.path()))
}

/// Pictures among these files, except close and large ones, sorted by name. If there are too many,
/// an even selection.
pub(crate) fn chosen(files: impl Iterator<Item = PathBuf>) -> Vec<(String, Vec<u8>)> {
    let is_picture = |path: &PathBuf| {
        let small = path
            .metadata()
            .is_ok_and(|it| it.len() <= PICTURE_MAX_BYTES);
        let name = path.file_name().map(|it| it.to_string_lossy());
        let is_close = name.is_some_and(|it| it.starts_with(CLOSE));
        path.extension().is_some_and(|it| it == "png") && small && !is_close
    };
    let mut paths: Vec<PathBuf> = files.filter(is_picture).collect();
    paths.sort();
    let every = paths.len().div_ceil(PICTURES_MAX).max(1);
    let chosen = paths.iter().step_by(every);
    let read = chosen.filter_map(|path| {
        let name = path.file_stem()?.to_string_lossy().replace('_', " ");
        Some((name, std::fs::read(path).ok()?))
    });
    read.collect()
}

/// Date and time as text: UTC, to the minute.
pub(crate) fn utc(unix_s: u64) -> String {
    let (days, seconds) = (unix_s / 86_400, unix_s % 86_400);
    // Howard Hinnant's civil_from_days, for days since 1970.
    let shifted = days + 719_468;
    let (era, of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 {
        shifted_month + 3
    } else {
        shifted_month - 9
    };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute) = (seconds / 3600, seconds % 3600 / 60);
    format!("{year}-{month:02}-{day:02} {hour:02}:{minute:02} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_the_calendar() {
        for (unix_s, text) in [
            (0, "1970-01-01 00:00 UTC"),
            (951_782_400, "2000-02-29 00:00 UTC"),
            (1_795_311_059, "2026-11-22 01:30 UTC"),
            (4_102_444_799, "2099-12-31 23:59 UTC"),
        ] {
            assert_eq!(utc(unix_s), text);
        }
    }

    #[test]
    fn a_file_that_is_no_session_is_refused_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let error = chapter(folder.path(), None, None).unwrap_err().to_string();
        assert!(error.contains("session.mcap"), "{error}");
    }

    #[test]
    fn missing_parts_of_a_session_are_reported() {
        let damaged = LeftOut {
            damaged: Some("at byte 7: x".to_owned()),
            ..LeftOut::default()
        };
        assert!(damaged.cut_short().is_some());
        assert!(damaged.in_words()[0].contains("damaged at byte 7"));
        let lost = LeftOut {
            lost: Some("before its repair lost 9 messages".to_owned()),
            ..LeftOut::default()
        };
        assert_eq!(lost.damaged(), lost.cut_short());
        assert!(lost.in_words()[0].contains("lost 9 messages"));
        let missing = LeftOut {
            missing_ticks: 3,
            ..LeftOut::default()
        };
        assert!(missing.cut_short().is_none());
        assert!(missing.in_words()[0].contains("3 ticks"));
        let events = LeftOut {
            missing_events: 2,
            ..LeftOut::default()
        };
        assert!(events.in_words()[0].contains("2 events"));
        assert!(LeftOut::default().in_words().is_empty());
    }

    #[test]
    fn ticks_come_from_the_summary_if_there_is_one() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(ticks(folder.path()), None);
        let spread = r#"{"count":9,"p50":1,"p90":2,"p99":3,"p999":4,"p9999":5,"max":6}"#;
        let text = format!(
            r#"{{"tick_ns":{spread},"stage_ns":{{"solve":{spread}}},"deadline_misses":1,"overruns":2,"realtime":true}}"#
        );
        std::fs::write(folder.path().join("summary.json"), text).unwrap();
        let ticks = ticks(folder.path()).unwrap();
        assert_eq!((ticks.tick_ns.max, ticks.stage_ns["solve"].p99), (6, 3));
    }

    #[test]
    fn pictures_are_chosen_evenly() {
        let folder = tempfile::tempdir().unwrap();
        for number in 0..30 {
            let path = folder.path().join(format!("frame_{number:04}.png"));
            std::fs::write(path, [number]).unwrap();
        }
        std::fs::write(folder.path().join("summary.json"), "{}").unwrap();
        std::fs::write(close_file(folder.path(), 1), [1]).unwrap();
        let found = pictures_in(folder.path());
        assert_eq!(found.len(), 10);
        assert_eq!(found[1], ("frame 0003".to_owned(), vec![3]));
    }
}
