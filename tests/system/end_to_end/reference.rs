//! Example clients of the reference library for OpenIGTLink, compiled as its authors wrote them.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Sources of the examples, as Debian's package `openigtlink-examples` installs them.
const SOURCES: &str = "/usr/share/doc/openigtlink-examples/examples";
/// Headers of the library, from `libopenigtlink-dev`.
const HEADERS: &str = "/usr/include/openigtlink";
/// A client runs at most this long: some never end by themselves.
const LONG: Duration = Duration::from_secs(5);

/// Clients: source, arguments after host and port, and words that each must say.
const CLIENTS: [(&str, &[&str], &[&str]); 9] = [
    (
        "Receiver/ReceiveClient",
        &[],
        &["Receiving TRANSFORM data type", "Receiving : SENSOR"],
    ),
    (
        "TrackingData/TrackingDataClient",
        &["50"],
        &["Name       : Tool"],
    ),
    (
        "QuaternionTrackingData/QuaternionTrackingDataClient",
        &["50"],
        &["Name       : Tool"],
    ),
    (
        "PolyData/PolyDataClient",
        &[],
        &["Receiving POLYDATA data type"],
    ),
    ("Capability/CapabilityClient", &[], &[]),
    ("Status/StatusClient", &[], &[]),
    ("String/StringClient", &["20"], &["Sending string"]),
    ("Tracker/TrackerClient", &["20"], &[]),
    ("Tracker/TrackerClient2", &["20"], &[]),
];

/// Runs all clients beside each other, as far as there are places. None may lose its connection.
pub(super) fn clients_are_served(address: &str) {
    let Some(folder) = folder() else { return };
    let (host, port) = address.split_once(':').expect("an address");
    for group in CLIENTS.chunks(4) {
        let mut running = Vec::new();
        for (source, words, said) in group {
            let program = compiled(source, &folder);
            let told = program.with_extension("txt");
            let file = || std::fs::File::create(&told).expect("a file");
            let output = file();
            let mut client = Command::new(&program);
            client.args([host, port]).args(*words).stdin(Stdio::null());
            client
                .stdout(output.try_clone().expect("a file"))
                .stderr(output);
            running.push((client.spawn().expect("it starts"), told, said));
        }
        std::thread::sleep(LONG);
        for (mut client, told, said) in running {
            let _ = client.kill();
            client.wait().expect("it ends");
            let told = std::fs::read_to_string(told).unwrap_or_default();
            let shown: String = told.chars().take(2000).collect();
            for words in *said {
                assert!(told.contains(words), "{words}: {shown}");
            }
            for trouble in ["Invalid response", "Connection closed", "Cannot connect"] {
                assert!(!told.contains(trouble), "{trouble}: {shown}");
            }
        }
    }
}

/// Folder for the programs; `None` if the library is not installed.
fn folder() -> Option<PathBuf> {
    if !Path::new(SOURCES).is_dir() || !Path::new(HEADERS).is_dir() {
        println!(
            "skipped: the reference library is not installed (Debian: apt install \
             libopenigtlink-dev openigtlink-examples)"
        );
        return None;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("openigtlink");
    std::fs::create_dir_all(&folder).expect("a folder in target");
    Some(folder)
}

/// Compiles a client, unless an earlier test did.
fn compiled(source: &str, folder: &Path) -> PathBuf {
    let path = Path::new(SOURCES).join(source).with_extension("cxx");
    let program = folder.join(path.file_stem().expect("a name"));
    if program.exists() {
        return program;
    }
    let mut compile = Command::new("c++");
    compile.arg("-I").arg(HEADERS).arg("-I");
    compile.arg(Path::new(HEADERS).join("igtlutil")).arg(&path);
    let output = compile
        .arg("-o")
        .arg(&program)
        .arg("-lOpenIGTLink")
        .output();
    let output = output.expect("a compiler");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {said}", path.display());
    program
}
