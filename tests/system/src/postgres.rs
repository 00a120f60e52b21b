//! A real server of PostgreSQL with data of its own, for one test.

use std::net::TcpListener;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::process::Signal;

use crate::{finish, said, wait_until};

/// Owner of the databases.
pub const OWNER: &str = "owner";
/// Password of every user.
pub const PASSWORD: &str = "pass'word";
/// User as whom a server runs if this test is root's: PostgreSQL refuses root.
const NOBODY: u32 = 65_534;

/// A server that runs, or that was stopped.
pub struct Postgres {
    folder: PathBuf,
    programs: PathBuf,
    port: u16,
    server: Option<Child>,
}

impl Postgres {
    /// Starts a server. `None` if none is installed, which is printed.
    ///
    /// # Panics
    ///
    /// If an installed server does not start.
    #[must_use]
    pub fn start() -> Option<Self> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let Some(programs) = programs() else {
            println!(
                "skipped: no server of PostgreSQL is installed (Debian: apt install postgresql)"
            );
            return None;
        };
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("calot-pg-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir(&folder).expect("a folder");
        let free = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let mut server = Self {
            folder,
            programs,
            port: free.local_addr().expect("an address").port(),
            server: None,
        };
        server.make_data();
        drop(free);
        server.resume();
        server.sql("postgres", "CREATE DATABASE calot");
        Some(server)
    }

    fn make_data(&self) {
        let secret = self.folder.join("password");
        std::fs::write(&secret, PASSWORD).expect("written");
        if is_root() {
            std::os::unix::fs::chown(&self.folder, Some(NOBODY), Some(NOBODY)).expect("root may");
        }
        let mode = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(&self.folder, mode).expect("own folder");
        let mut make = self.command("initdb");
        make.args([
            "--auth=scram-sha-256",
            "-U",
            OWNER,
            "--no-sync",
            "--encoding=UTF8",
            "--locale=C",
            "-D",
            "data",
        ]);
        make.arg("--pwfile").arg(&secret);
        let made = finish(&mut make);
        assert!(made.status.success(), "{}", said(&made));
    }

    /// A program of the server, as a user who is not root.
    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(self.programs.join(program));
        command.current_dir(&self.folder).stdin(Stdio::null());
        if is_root() {
            command.uid(NOBODY).gid(NOBODY);
        }
        command
    }

    /// Starts the server again.
    ///
    /// # Panics
    ///
    /// If it does not start.
    pub fn resume(&mut self) {
        let mut command = self.command("postgres");
        let port = self.port.to_string();
        command.args([
            "-D",
            "data",
            "-k",
            ".",
            "-p",
            &port,
            "-c",
            "listen_addresses=127.0.0.1",
        ]);
        command.args(["-c", "fsync=off"]);
        if self.folder.join("server.pem").exists() {
            command.args([
                "-c",
                "ssl=on",
                "-c",
                "ssl_cert_file=../server.pem",
                "-c",
                "ssl_key_file=../server.key",
            ]);
        }
        let log = std::fs::File::options();
        let log = { log }
            .create(true)
            .append(true)
            .open(self.folder.join("log"));
        command.stdout(Stdio::null()).stderr(log.expect("a log"));
        self.server = Some(command.spawn().expect("the server starts"));
        wait_until("the server answers", || {
            let mut ask = self.psql("postgres");
            ask.args(["-c", "SELECT 1"])
                .output()
                .is_ok_and(|it| it.status.success())
        });
    }

    /// Stops the server: `INT` ends connections in order, `QUIT` does not.
    ///
    /// # Panics
    ///
    /// If it does not run.
    pub fn stop(&mut self, how: Signal) {
        let mut server = self.server.take().expect("it runs");
        let process = rustix::process::Pid::from_child(&server);
        rustix::process::kill_process(process, how).expect("a signal");
        server.wait().expect("it ends");
    }

    /// Gives the server a certificate and its key, in PEM, and starts it again.
    ///
    /// # Panics
    ///
    /// If the files cannot be copied.
    pub fn encrypt(&mut self, certificate: &Path, key: &Path) {
        self.stop(Signal::INT);
        for (from, name) in [(certificate, "server.pem"), (key, "server.key")] {
            let to = self.folder.join(name);
            std::fs::copy(from, &to).expect("copied");
            if is_root() {
                std::os::unix::fs::chown(&to, Some(NOBODY), Some(NOBODY)).expect("root may");
            }
            let mode = std::fs::Permissions::from_mode(0o600);
            std::fs::set_permissions(&to, mode).expect("own file");
        }
        self.resume();
    }

    fn psql(&self, database: &str) -> Command {
        let mut command = self.command("psql");
        let port = self.port.to_string();
        command.args([
            "-X",
            "-q",
            "-A",
            "-t",
            "-v",
            "ON_ERROR_STOP=1",
            "-h",
            "127.0.0.1",
            "-p",
            &port,
            "-U",
            OWNER,
        ]);
        command.args(["-d", database]).env("PGPASSWORD", PASSWORD);
        command
    }

    /// Rows that a query of the owner returns, with `|` between columns.
    ///
    /// # Panics
    ///
    /// If the query fails.
    #[must_use]
    pub fn rows(&self, query: &str) -> Vec<String> {
        let text = self.sql("calot", query);
        text.lines().map(str::to_owned).collect()
    }

    /// Runs SQL as the owner and returns what it prints.
    ///
    /// # Panics
    ///
    /// If it fails.
    pub fn sql(&self, database: &str, text: &str) -> String {
        let done = finish(self.psql(database).args(["-c", text]));
        assert!(done.status.success(), "{text}: {}", said(&done));
        String::from_utf8_lossy(&done.stdout).into_owned()
    }

    /// Address for a user, without a password.
    #[must_use]
    pub fn address(&self, user: &str) -> String {
        format!("postgres://{user}@127.0.0.1:{}/calot", self.port)
    }

    /// Port of the server.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }
}

impl Drop for Postgres {
    fn drop(&mut self) {
        if let Some(mut server) = self.server.take() {
            let process = rustix::process::Pid::from_child(&server);
            let _ = rustix::process::kill_process(process, Signal::QUIT);
            let _ = server.wait();
        }
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn is_root() -> bool {
    std::fs::metadata("/proc/self").is_ok_and(|it| it.uid() == 0)
}

/// Folder of the newest server's programs, where Debian or others put them.
fn programs() -> Option<PathBuf> {
    let versions = std::fs::read_dir("/usr/lib/postgresql")
        .into_iter()
        .flatten();
    let mut folders: Vec<PathBuf> = versions.flatten().map(|it| it.path().join("bin")).collect();
    folders.sort();
    folders.extend(["/usr/bin", "/usr/local/bin"].map(PathBuf::from));
    folders.retain(|it| it.join("initdb").is_file());
    let newest = folders
        .iter()
        .rev()
        .find(|it| it.starts_with("/usr/lib/postgresql"));
    newest.or_else(|| folders.first()).cloned()
}
