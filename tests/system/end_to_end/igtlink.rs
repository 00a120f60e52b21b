//! `calot igtlink` as a client sees it: the real program beside a real station.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use bytemuck::Zeroable as _;
use hardware::igtlink::wire::{self, HEADER_BYTES, Header, Version};
use rustix::process::Signal;
use serde_json::Value;
use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::service::{Host, Station};
use system_tests::{calot, finish, said, signal, station_name, wait_until};

use crate::devices::Emulated;
use crate::reference;
use crate::registry::Python;

/// Client in Python: the instrument comes, poses are rigid, and stamps go forward. pyigtl reads no
/// `SENSOR` and no `POLYDATA`; the reference library's own clients do.
const CLIENT: &str = r#"
import sys, numpy, pyigtl
host, port = sys.argv[1].split(":")
client = pyigtl.OpenIGTLinkClient(host, int(port))
instrument = client.wait_for_message("Instrument", timeout=60)
assert instrument.string == "grasper", instrument
stamps = []
for _ in range(20):
    pose = client.wait_for_message("ToolToReference", timeout=60)
    assert pose.matrix[3].tolist() == [0, 0, 0, 1], pose
    turn = pose.matrix[:3, :3]
    assert numpy.allclose(turn @ turn.T, numpy.eye(3), atol=1e-3), turn
    assert numpy.linalg.det(turn) > 0
    stamps.append(pose.timestamp)
assert stamps == sorted(stamps) and stamps[0] < stamps[-1], stamps
print("all checks passed")
"#;

/// A message that arrived.
struct Told {
    kind: String,
    name: String,
    stamp: u64,
    content: Vec<u8>,
}

impl Told {
    fn floats(&self) -> Vec<f32> {
        let four = |it: &[u8]| f32::from_be_bytes(it.try_into().expect("four"));
        self.content.chunks_exact(4).map(four).collect()
    }
}

/// A client of the program.
struct Reader(TcpStream);

impl Reader {
    fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).expect("it listens");
        let patience = Some(Duration::from_secs(120));
        stream.set_read_timeout(patience).expect("a time limit");
        Self(stream)
    }

    fn ask(&mut self, kind: &str, content: &[u8]) {
        let request = wire::pack(Version::One, kind, "", 0, content);
        self.0.write_all(&request).expect("it is sent");
    }

    fn read(&mut self) -> Told {
        let mut head = [0; HEADER_BYTES];
        self.0.read_exact(&mut head).expect("a message");
        let header = Header::read(&head).expect("a header");
        assert_eq!(header.version, 1);
        let mut content = vec![0; usize::try_from(header.body_bytes).expect("short")];
        self.0.read_exact(&mut content).expect("its body");
        assert_eq!(wire::checksum(&content), header.checksum);
        let stamp = u64::from_be_bytes(head[34..42].try_into().expect("eight"));
        let (kind, name) = (header.kind, header.name);
        Told {
            kind,
            name,
            stamp,
            content,
        }
    }

    /// Reads until a message of this type and name comes.
    fn find(&mut self, kind: &str, name: &str) -> Told {
        loop {
            let told = self.read();
            if told.kind == kind && told.name == name {
                return told;
            }
        }
    }

    /// Reads until a status of this code comes; returns the number of transforms before it.
    fn until_status(&mut self, code: u8) -> usize {
        let mut transforms = 0;
        loop {
            let told = self.read();
            transforms += usize::from(told.kind == "TRANSFORM");
            if told.kind == "STATUS" && told.content[1] == code {
                return transforms;
            }
        }
    }
}

/// Starts the program with additional arguments; returns it and its address.
fn serve(name: &str, errors: &Path, more: &[&str]) -> (Emulated, String) {
    let mut server = calot()
        .args([
            "igtlink",
            "--station",
            name,
            "--listen",
            "127.0.0.1:0",
            "--json",
        ])
        .args(more)
        .stdout(Stdio::piped())
        .stderr(std::fs::File::create(errors).expect("a file"))
        .spawn()
        .expect("it starts");
    let mut line = String::new();
    let mut told = BufReader::new(server.stdout.take().expect("piped"));
    told.read_line(&mut line).expect("a line");
    let told: Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!(told["frame"], "ras");
    let address = told["listening"].as_str().expect("an address").to_owned();
    (Emulated(server), address)
}

#[test]
fn other_programs_are_told_what_a_station_does_until_it_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let errors = folder.path().join("errors");
    let name = station_name("igtlink");
    let mut run = Emulated::run(folder.path(), &name);
    let host = Host::open(&Station::new(&name).expect("a plain name")).expect("a host");
    let mut tools = ToolFrame::zeroed();
    wait_until("it runs", || {
        host.newest_tools(&mut tools) && tools.tick > 500
    });
    let (_server, address) = serve(&name, &errors, &[]);
    let mut reader = Reader::connect(&address);
    reader.until_status(1);
    poses_are_right(&mut reader, &host, &mut tools);
    requests_are_answered(&mut reader);
    a_foreign_client_reads(&address);
    surfaces_are_sent(&name, &host, &folder.path().join("surfaces"));

    signal(run.0.id(), Signal::INT);
    run.0.wait().expect("it ends");
    reader.until_status(19);
    // It ended: only its condition is repeated.
    reader.ask("GET_TRANS", b"");
    assert_eq!(reader.until_status(13), 0, "old poses are not sent");
    assert_eq!(reader.until_status(19), 0);
    let said = std::fs::read_to_string(&errors).expect("its words");
    assert!(said.contains("has ended; data stop"), "{said}");
}

fn poses_are_right(reader: &mut Reader, host: &Host, tools: &mut ToolFrame) {
    let mut before = 0;
    for _ in 0..100 {
        let tool = reader.find("TRANSFORM", "ToolToReference");
        assert!(tool.stamp >= before, "stamps go back");
        before = tool.stamp;
    }
    for name in [
        "ToolToReference",
        "HandleToReference",
        "EndoscopeToReference",
    ] {
        let numbers = reader.find("TRANSFORM", name).floats();
        let [a, b, c, d, e, f, ..] = numbers[..] else {
            panic!("{name}: {numbers:?}");
        };
        let across = a * d + b * e + c * f;
        assert!(across.abs() < 1e-4, "{name}: columns at right angles");
        assert!((a * a + b * b + c * c - 1.0).abs() < 1e-3, "{name}");
    }
    // The camera rests, so the message, in mm and R-A-S, must be near the frame's pose.
    let camera = reader.find("TRANSFORM", "EndoscopeToReference").floats();
    host.newest_tools(tools);
    let [left, head, front] = tools.world_from_camera.position_m;
    for (told_mm, at_m) in camera[9..].iter().zip([-left, front, head]) {
        assert!(
            (told_mm - at_m * 1e3).abs() < 60.0,
            "{told_mm} mm, {at_m} m"
        );
    }
    let force = reader.find("SENSOR", "Force");
    assert_eq!(force.content[2..10], 0x02C4_0000_0000_0000u64.to_be_bytes());
    assert_eq!((force.content[0], force.content.len()), (3, 34));
}

/// A round of surfaces has each organ once, all of one moment, at the places of its spheres.
fn surfaces_are_sent(name: &str, host: &Host, errors: &Path) {
    let (_server, address) = serve(name, errors, &["--surfaces", "5"]);
    let mut reader = Reader::connect(&address);
    let first = reader.find("POLYDATA", "liver");
    let next = reader.find("POLYDATA", "liver");
    assert!(next.stamp > first.stamp, "surfaces go on");
    let gallbladder = reader.find("POLYDATA", "gallbladder");
    assert_eq!(gallbladder.stamp, next.stamp, "a round shows one moment");
    let word = |at: usize| {
        let four = first.content[at..at + 4].try_into().expect("four");
        u32::from_be_bytes(four) as usize
    };
    let (points, triangles) = (word(0), word(20));
    assert!(points > 500 && triangles > 1000, "{points}, {triangles}");
    assert_eq!(first.content.len(), 40 + 12 * points + 16 * triangles);
    for triangle in 0..triangles {
        let at = 40 + 12 * points + 16 * triangle;
        assert_eq!(word(at), 3);
        assert!((1..4).all(|corner| word(at + 4 * corner) < points));
    }
    let mut state: Box<StateFrame> = bytemuck::zeroed_box();
    wait_until("a state", || host.newest_state(&mut state));
    let spheres = state.spheres().expect("they fit");
    let points_mm: Vec<f32> = first.content[40..40 + 12 * points]
        .chunks_exact(4)
        .map(|it| f32::from_be_bytes(it.try_into().expect("four")))
        .collect();
    // R-A-S, mm: the liver's spheres lie within its surface's bounds, 20 mm wider for the motion.
    let bounds = |axis: usize| {
        let along = || points_mm.iter().skip(axis).step_by(3).copied();
        let [low, high] = [
            along().fold(f32::MAX, f32::min),
            along().fold(f32::MIN, f32::max),
        ];
        low - 20.0..high + 20.0
    };
    let [left, head, front] = spheres[0].center_m;
    for (axis, at_m) in [-left, front, head].into_iter().enumerate() {
        assert!(
            bounds(axis).contains(&(at_m * 1e3)),
            "axis {axis}: {at_m} m"
        );
    }
    reader.ask("GET_POLYDATA", b"");
    reader.find("POLYDATA", "liver");
    reference::clients_are_served(&address);
}

fn requests_are_answered(reader: &mut Reader) {
    reader.ask("GET_CAPABIL", b"");
    let kinds = reader.find("CAPABILITY", "Calot").content;
    assert!(String::from_utf8_lossy(&kinds).contains("SENSOR"));
    reader.ask("STT_TDATA", &[0; 36]);
    assert_eq!(reader.find("RTS_TDATA", "Calot").content, [0]);
    assert_eq!(reader.find("TDATA", "Calot").content.len(), 3 * 70);
    reader.ask("STP_TDATA", b"");
    assert_eq!(reader.find("RTS_TDATA", "Calot").content, [0]);
    reader.ask("STT_QTDATA", &[0; 36]);
    assert_eq!(reader.find("RTS_QTDATA", "Calot").content, [0]);
    let element = reader.find("QTDATA", "Calot").content;
    assert_eq!(element.len(), 3 * 50);
    reader.ask("STP_QTDATA", b"");
    assert_eq!(reader.find("RTS_QTDATA", "Calot").content, [0]);
    reader.ask("GET_IMAGE", b"");
    reader.until_status(12);
}

/// Lets clients written by others read: pyigtl, from the Python registry.
fn a_foreign_client_reads(address: &str) {
    let Some(python) = Python::with("igtl", &["pyigtl==0.3.4"]) else {
        return;
    };
    let mut client = Command::new(python.program());
    let output = finish(client.args(["-c", CLIENT, address]));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(told.trim(), "all checks passed", "{output:?}");
}

#[test]
fn a_station_that_never_was_is_told_and_the_program_fails() {
    let name = station_name("nosuch");
    let words = ["--seconds", "4.5", "--listen", "127.0.0.1:0"];
    let output = finish(calot().args(["igtlink", "--station", &name]).args(words));
    assert_eq!(output.status.code(), Some(1));
    let said = said(&output);
    let advice = format!("calot run --station {name}");
    assert!(said.contains("runs so far"), "{said}");
    assert!(said.contains("nothing was sent"), "{said}");
    assert!(said.contains(&advice), "{said}");
}
