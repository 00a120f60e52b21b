//! Networks of their own on this machine.

use std::process::{Command, Stdio};

use system_tests::{calot, finish};

use super::process::Process;

/// Network namespaces joined to this one. They are removed on drop.
pub(super) struct Networks(Vec<String>);

impl Networks {
    /// Creates `count` networks. Each has an address range of its own (`address`), in which this
    /// end is `.1` and the network's end is `.2`. `None` if this user may not create networks.
    pub(super) fn of(count: u8) -> Option<Self> {
        let mut networks = Self(Vec::new());
        for number in 0..count {
            let pid = std::process::id();
            let (name, veth) = (format!("calot-{pid}-{number}"), format!("ca{pid}{number}"));
            let [ours, theirs] = [1, 2].map(|end| format!("{}/24", address(number, end)));
            let inside = |words: &str| format!("netns exec {name} ip {words}");
            if !ip(&format!("netns add {name}")) {
                return None;
            }
            networks.0.push(name.clone());
            let made = [
                format!("link add {veth} type veth peer name eth0 netns {name}"),
                format!("addr add {ours} dev {veth}"),
                format!("link set {veth} up"),
                inside(&format!("addr add {theirs} dev eth0")),
                inside("link set eth0 up"),
                inside("link set lo up"),
            ];
            if !made.iter().all(|words| ip(words)) {
                return None;
            }
        }
        Some(networks)
    }

    /// Starts `calot` in one of the networks.
    pub(super) fn calot(&self, number: usize, words: &[&str]) -> Process {
        let plain = calot();
        let mut command = Command::new("ip");
        command
            .args(["netns", "exec", &self.0[number]])
            .arg(plain.get_program())
            .args(words)
            .current_dir(system_tests::root());
        Process::start(&mut command)
    }

    /// True if a process in this network listens for TCP.
    pub(super) fn listens(&self, number: usize) -> bool {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.0[number], "cat"]);
        command.args(["/proc/net/tcp", "/proc/net/tcp6"]);
        let sockets = finish(&mut command);
        let text = String::from_utf8_lossy(&sockets.stdout).into_owned();
        assert!(text.contains("local_address"), "{text}");
        text.lines()
            .any(|it| it.split_whitespace().nth(3) == Some("0A"))
    }
}

impl Drop for Networks {
    fn drop(&mut self) {
        for name in &self.0 {
            ip(&format!("netns del {name}"));
        }
    }
}

pub(super) fn address(number: u8, end: u8) -> String {
    // The address depends on the process id, so that tests running side by side do not collide.
    let third = (std::process::id() % 60) as u8 * 4 + number;
    format!("10.231.{third}.{end}")
}

fn ip(words: &str) -> bool {
    let mut command = Command::new("ip");
    command.args(words.split_whitespace());
    let run = command.stderr(Stdio::null()).stdout(Stdio::null()).status();
    run.is_ok_and(|status| status.success())
}
