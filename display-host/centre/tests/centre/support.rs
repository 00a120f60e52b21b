//! Keys, and the programs of a centre and its stations.

use std::io::{BufRead as _, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU16, Ordering::Relaxed};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Time after which a test gives up waiting. It is generous because it is no performance limit.
const PATIENCE: Duration = Duration::from_secs(400);

/// Password of the instructor 'bo'.
pub(crate) const PASSWORD: &str = "correct horse";

/// A process that is killed with its owner.
pub(crate) struct Killed(pub(crate) Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Root folder of the checkout.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The program `calot`, which the product's workspace builds beside the centre's. Its runs share a
/// cache with that workspace's tests.
pub(crate) fn calot() -> Command {
    let folder = Path::new(env!("CARGO_BIN_EXE_calot-centre")).parent();
    let folder = folder.expect("a folder");
    let program = folder.join("calot");
    assert!(
        program.is_file(),
        "build {} first: cargo build --workspace --bin calot",
        program.display()
    );
    let mut command = Command::new(program);
    command.current_dir(root()).stdin(Stdio::null());
    command.env("XDG_CACHE_HOME", folder.join("cache"));
    command
}

pub(crate) fn centre_program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_calot-centre"));
    command.stdin(Stdio::null());
    command
}

/// Keys of one authority: a folder for each name.
pub(crate) fn make_keys(folder: &Path, centre: &str, members: &[String]) {
    let script = root().join("display-host/link/make_keys.sh");
    let run = |words: &[&str]| {
        let made = Command::new("sh")
            .arg(&script)
            .args(words)
            .current_dir(folder)
            .output();
        let made = made.expect("a shell");
        let said = String::from_utf8_lossy(&made.stderr);
        assert!(made.status.success(), "{words:?}: {said}");
    };
    run(&["authority"]);
    run(&["centre", centre, "IP:127.0.0.1"]);
    members.iter().for_each(|it| run(&["member", it]));
    for name in members.iter().map(String::as_str).chain([centre]) {
        let own = folder.join("keys").join(name);
        std::fs::create_dir_all(&own).expect("a folder");
        for file in [
            format!("{name}.pem"),
            format!("{name}.key"),
            "ca.pem".to_owned(),
        ] {
            std::fs::copy(folder.join(&file), own.join(&file)).expect("copied");
        }
    }
}

/// A port at which nobody listens. It lies below the ports that the system gives to outgoing
/// connections. Otherwise a station that tries to reach an absent centre would, now and then, reach
/// itself.
pub(crate) fn free_port() -> u16 {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    loop {
        let seed = u16::try_from(std::process::id() % 1000).expect("small") * 11;
        let port = 20_000 + (seed + NEXT.fetch_add(1, Relaxed)) % 12_000;
        if TcpListener::bind(("127.0.0.1", port)).is_ok() {
            return port;
        }
    }
}

/// A running centre.
pub(crate) struct Centre {
    folder: PathBuf,
    pub(crate) stations: String,
    pub(crate) page: String,
    process: Killed,
}

impl Centre {
    /// Starts a centre for these stations in a folder that [`make_keys`] filled.
    pub(crate) fn start(folder: &Path, stations: &[&str]) -> Self {
        write_list(folder, stations);
        loop {
            let [stations, page] = [(); 2].map(|()| format!("127.0.0.1:{}", free_port()));
            if let Some(centre) = Self::start_at(folder, &stations, &page) {
                return centre;
            }
            // Another program took a port meanwhile.
        }
    }

    /// Starts a centre at these addresses. `None`: it does not listen.
    pub(crate) fn start_at(folder: &Path, stations: &str, page: &str) -> Option<Self> {
        let file = |name: &str| folder.join(name);
        let mut command = centre_program();
        command.arg("serve").arg("--list").arg(file("centre.toml"));
        command.arg("--keys").arg(file("keys/centre"));
        command.arg("--store").arg(file("centre.sqlite"));
        command.arg("--log").arg(file("log"));
        command.args(["--stations", stations, "--page", page, "--json"]);
        let mut child = command.stdout(Stdio::piped()).spawn().expect("a centre");
        let mut line = String::new();
        let output = child.stdout.take().expect("its output");
        BufReader::new(output).read_line(&mut line).expect("a line");
        let process = Killed(child);
        line.contains(page).then(|| Self {
            folder: folder.to_owned(),
            stations: stations.to_owned(),
            page: page.to_owned(),
            process,
        })
    }

    /// Entries of the log.
    pub(crate) fn log(&self) -> Vec<Value> {
        let text = std::fs::read_to_string(self.folder.join("log")).expect("a log");
        text.lines()
            .filter_map(|it| serde_json::from_str(it).ok())
            .collect()
    }

    pub(crate) fn kill(&mut self) {
        let _ = self.process.0.kill();
        let _ = self.process.0.wait();
    }

    pub(crate) fn id(&self) -> u32 {
        self.process.0.id()
    }

    /// Entries of one kind.
    pub(crate) fn logged(&self, what: &str) -> Vec<Value> {
        let all = self.log().into_iter();
        all.filter(|it| it["what"] == what).collect()
    }
}

/// Writes the list of a centre: these stations, and the instructor 'bo'.
pub(crate) fn write_list(folder: &Path, stations: &[&str]) {
    static HASH: LazyLock<String> =
        LazyLock::new(|| centre::roster::hashed(PASSWORD).expect("a hash"));
    let mut list = format!("[[instructor]]\nname = 'bo'\npassword = '{}'\n", *HASH);
    for name in stations {
        list += &format!("[[station]]\nname = '{name}'\n");
    }
    write_text(folder, &list);
}

/// Writes this text as the list of a centre.
pub(crate) fn write_text(folder: &Path, list: &str) {
    let new = folder.join("centre.new");
    std::fs::write(&new, list).expect("a list");
    std::fs::rename(new, folder.join("centre.toml")).expect("a list");
}

/// Waits until `found` finds something.
pub(crate) fn wait<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(it) = found() {
            return it;
        }
        assert!(start.elapsed() < PATIENCE, "never: {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}
