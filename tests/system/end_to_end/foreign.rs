//! Programs of other people open a session: Foxglove's reader, the official MCAP reader with
//! protobuf, pandas, DuckDB and Rerun, from their registries; R and GNU Octave, where they are
//! installed. The code of the page about sessions runs as it stands there.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use system_tests::{calot, finish, said, station_name};

use super::foxglove;
use super::registry::Python;

/// Packages from the Python registry, at the versions that were tried.
const PACKAGES: [&str; 6] = [
    "mcap==1.6.0",
    "mcap-protobuf-support==0.6.0",
    "pandas==3.1.1",
    "duckdb==2.0.1",
    "pyarrow==26.0.1",
    "rerun-sdk==0.41.0",
];

/// Checks with the plain MCAP reader, and with DuckDB and pyarrow on the tables.
const CHECKS: &str = r#"
import sys, math, duckdb, pandas, calot
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

path, tables, copy, organs, damaged = sys.argv[1:6]
newest, seen = {}, {}
with open(path, "rb") as file:
    reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
    for schema, channel, message, decoded in reader.iter_decoded_messages(
            topics=["/tf", "/tip", "/tool", "/events", "/log", "/stages", "/timing"]):
        assert newest.get(channel.topic, 0) <= message.log_time, channel.topic
        newest[channel.topic] = message.log_time
        seen[channel.topic] = schema.name
assert seen["/tf"] == "foxglove.FrameTransforms" and seen["/tool"] == "calot.Tool", seen

ticks = pandas.read_csv(f"{tables}/ticks.csv")
same = pandas.read_parquet(f"{tables}/ticks.parquet")
assert list(ticks.columns) == list(same.columns) and len(ticks) == len(same)
# A 32-bit number in CSV reads back as the bits of the Parquet file.
for name in ["force_x_n", "tip_y_m", "instrument_qw"]:
    assert (ticks[name].astype("float32") == same[name]).all(), name
assert same.force_x_n.dtype == "float32" and (ticks.tick.diff().dropna() == 1).all()
assert (ticks.solve_ns <= ticks.tick_ns).all()

[(count,)] = duckdb.sql(f"SELECT count(*) FROM '{tables}/ticks.parquet'").fetchall()
assert count == len(ticks)

session = calot.Session(path)
tool = session.frame("/tool")
joined = tool.merge(ticks, on="tick")
assert len(joined) > 0.9 * len(tool) > 0
force = (joined[["force_x_n", "force_y_n", "force_z_n"]] ** 2).sum(axis=1) ** 0.5
assert (abs(force - joined.force_n) < 1e-5).all()
# Both count time from the first tick.
assert (abs(joined.time_s_x - joined.time_s_y) < 0.01).all(), (joined.time_s_x - joined.time_s_y).abs().max()
stages = session.stages()
assert len(stages) == len(ticks)
assert (stages.motion_to_force_ns.isna() == ticks.motion_to_force_ns.isna()).all()
try:
    session.frame("/setup")
    raise AssertionError("packed bytes became a table")
except ValueError as error:
    assert "calot export" in str(error)

# A copy that was cut off and repaired opens like any other.
assert sum(1 for _ in calot.Session(copy).messages("/tool")) > 0

# Of a damaged session, what lies before and behind the damage is there, and the file says what is
# not. Both files count from the same first tick.
mended = calot.Session(damaged)
assert mended.info["calot.repaired"]["lost"].startswith("lost "), mended.info
whole, rest = tool, mended.frame("/tool")
lost = int(mended.info["calot.repaired"]["lost /tool"])
assert len(rest) == len(whole) - lost and lost > 0
assert set(rest.tick) < set(whole.tick)
assert rest.tick.iloc[-1] == whole.tick.iloc[-1] and rest.time_s.diff().max() > 0.5

# The debrief's time: it begins with the first movement, never goes back here, and ends with the
# metric. Events stand at the same time in both ways of counting.
counted = ticks.dropna(subset="debrief_s")
assert counted.debrief_s.iloc[0] < 0.02 and (counted.debrief_s.diff().dropna() >= 0).all()
metrics = pandas.read_csv(f"{tables}/metrics.csv").set_index("name").value
assert abs(metrics["time_s"] - counted.debrief_s.max()) < 0.02, (metrics["time_s"], counted.debrief_s.max())
events = pandas.read_csv(f"{tables}/events.csv").dropna(subset="debrief_s")
assert len(events) > 0
at = events.merge(ticks[["tick", "debrief_s"]], on="tick").dropna()
assert (abs(at.debrief_s_x - at.debrief_s_y) < 0.03).all(), at

# The organs move, and their surfaces stay whole: every index has its point.
updates = [update for _, update in calot.Session(organs).messages("/organs")]
assert len(updates) >= 3
names = [entity.id for entity in updates[0].entities]
assert "liver" in names, names
for update in updates:
    for entity in update.entities:
        (part,) = entity.triangles
        assert len(part.points) > 0 and max(part.indices) < len(part.points)
first, last = (update.entities[names.index("liver")].triangles[0].points for update in (updates[0], updates[-1]))
moved = max(math.dist((a.x, a.y, a.z), (b.x, b.y, b.z)) for a, b in zip(first, last))
assert 0.0001 < moved < 0.1, moved
print("all checks passed")
"#;

/// Python with the packages and Calot's own; `None` if the registry cannot be reached.
fn python() -> Option<PathBuf> {
    let python = Python::with("python", &PACKAGES)?;
    let package = root().join("display-host/session/python");
    // A copy, because building would leave files in the sources.
    let copy = python.folder().join("calot");
    let _ = std::fs::remove_dir_all(&copy);
    std::fs::create_dir_all(copy.join("calot")).expect("a folder");
    for file in ["pyproject.toml", "calot/__init__.py"] {
        std::fs::copy(package.join(file), copy.join(file)).expect("copied");
    }
    let copy = copy.to_str().expect("a path");
    assert!(python.install(&["--force-reinstall", "--no-deps", copy]));
    Some(python.program())
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn succeeded(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}\n{}", said(output));
    text
}

/// Code blocks of a language in a document.
fn blocks(document: &str, language: &str) -> Vec<String> {
    let opening = format!("```{language}\n");
    let parts = document.split(&opening).skip(1);
    let code = parts.filter_map(|part| part.split_once("\n```"));
    code.map(|(code, _)| code.to_owned()).collect()
}

/// Runs the page's only block of a language. `None` if its interpreter is not installed.
fn interpreted(page: &str, language: &str, call: &[&str; 2], folder: &Path) -> Option<String> {
    let [code] = &blocks(page, language)[..] else {
        panic!("one block of {language}");
    };
    let mut command = Command::new(call[0]);
    command.args([call[1], code]).current_dir(folder);
    match command.output() {
        Ok(output) => Some(succeeded(&output)),
        Err(_) => {
            println!("skipped: {} is not installed", call[0]);
            None
        }
    }
}

/// Damages a chunk of a session, repairs it, and returns the repaired session.
fn damaged(session: &Path, folder: &Path) -> PathBuf {
    let damaged = folder.join("damaged.mcap");
    let mut bytes = std::fs::read(session).expect("a session");
    // About two seconds before the end.
    let place = bytes.len() - 300_000;
    bytes[place..place + 512].fill(0);
    std::fs::write(&damaged, bytes).expect("written");
    let mut repair = calot();
    repair
        .arg("replay")
        .arg(&damaged)
        .args(["--repair", "--json"]);
    let told = succeeded(&finish(&mut repair));
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    let lost = &told["lost"];
    assert!(lost["topics"]["/inputs"].as_u64() > Some(0), "{told:#}");
    assert!(lost["topics"]["/tool"].as_u64() > Some(0), "{told:#}");
    let [from, to] = [0, 1].map(|end| lost["spans_s"][0][end].as_f64().expect("a time"));
    assert!(0.0 < from && from < to && to < 4.5, "{told:#}");
    folder.join("damaged-repaired.mcap")
}

#[test]
fn a_session_opens_in_the_programs_of_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let run = finish(
        calot()
            .args(["run", "--headless", "--frames", "0", "--seconds", "4"])
            .args(["--station", &station_name("foreign"), "--out"])
            .arg(&out),
    );
    succeeded(&run);
    let (session, tables) = (out.join("session.mcap"), folder.path().join("tables"));
    let mut export = calot();
    export.arg("export").arg(&out).arg("--csv").arg(&tables);
    let organs = folder.path().join("organs.mcap");
    export.arg("--parquet").arg(&tables);
    export
        .args(["--surfaces-hz", "1", "--surfaces"])
        .arg(&organs);
    succeeded(&finish(&mut export));

    // A copy without its end: as if its recorder had been killed.
    let cut = folder.path().join("cut.mcap");
    let bytes = std::fs::read(&session).expect("a session");
    std::fs::write(&cut, &bytes[..bytes.len() * 9 / 10]).expect("written");
    succeeded(&finish(calot().arg("replay").arg(&cut).arg("--repair")));
    let repaired = folder.path().join("cut-repaired.mcap");
    let damaged = damaged(&session, folder.path());

    if let Some(channels) = foxglove::channels(&[&session, &repaired, &damaged, &organs]) {
        for channel in [
            "/tf .foxglove.FrameTransforms",
            "/tool .calot.Tool",
            "/log .foxglove.Log",
            "/organs .foxglove.SceneUpdate",
        ] {
            assert!(channels.contains(channel), "{channel}: {channels}");
        }
    }
    let page = root().join("display-host/session/README.md");
    let page = std::fs::read_to_string(page).expect("the page");
    let greatest = [
        interpreted(&page, "r", &["Rscript", "-e"], folder.path()),
        interpreted(&page, "matlab", &["octave-cli", "--eval"], folder.path()),
    ];
    let Some(python) = python() else { return };
    let mut checks = Command::new(&python);
    checks.args(["-c", CHECKS]).arg(&session).arg(&tables);
    let told = succeeded(
        &checks
            .arg(&repaired)
            .arg(&organs)
            .arg(&damaged)
            .output()
            .expect("it runs"),
    );
    assert!(told.contains("all checks passed"), "{told}");

    let code = blocks(&page, "python");
    assert_eq!(code.len(), 3, "blocks of Python on the page");
    let told = code.iter().map(|code| {
        let mut command = Command::new(&python);
        command.args(["-c", code]).current_dir(folder.path());
        succeeded(&command.output().expect("it runs"))
    });
    let told: Vec<String> = told.collect();
    assert!(!told[2].is_empty());
    assert!(told[0].contains("s in the session"), "{told:?}");
    for greatest in greatest.into_iter().flatten() {
        assert!(told[1].contains(greatest.trim()), "{greatest}: {told:?}");
    }
    let [query] = &blocks(&page, "sql")[..] else {
        panic!("one query");
    };
    let mut command = Command::new(&python);
    command.args([
        "-c",
        "import duckdb, sys; print(duckdb.sql(sys.argv[1]))",
        query,
    ]);
    let told = command.current_dir(folder.path()).output();
    assert!(succeeded(&told.expect("it runs")).contains("liver"));

    // Rerun decodes poses, the log and Calot's own messages; `check` finds no disorder.
    let rerun = python.with_file_name("rerun");
    let recording = folder.path().join("session.rrd");
    let call = |words: &[&str], path: &Path| {
        let mut command = Command::new(&rerun);
        command.args(words).arg(path).current_dir(folder.path());
        succeeded(&command.output().expect("it runs"))
    };
    for file in [&session, &organs, &damaged] {
        let checked = call(&["mcap", "check"], file);
        assert!(!checked.contains("PROBLEM"), "{checked}");
    }
    call(&["mcap", "convert", "-o", "session.rrd"], &session);
    let told = call(&["rrd", "stats"], &recording);
    for part in [
        "Transform3D:translation",
        "TextLog:text",
        "calot.Tool:message",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
}
