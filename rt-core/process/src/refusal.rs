//! Refusals of realtime: which rule of Linux refused a call, and the remedy.
//!
//! This module does not predict. It explains a call that Linux has refused. The error number alone
//! does not give the cause: EPERM may come from a limit, a control group, a user namespace or a
//! seccomp filter. So this module reads the state of the process and tries the rules in the
//! kernel's order. It names the first rule that refuses. `calot check` and the controller both use
//! it.

use std::fmt;
use std::path::Path;

use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};
use serde::Serialize;

/// Rule that refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The resource limit (`rtprio`, `memlock`) is too low, and the process lacks the capability
    /// that would lift it. For `SCHED_DEADLINE`: it lacks the capability.
    Limit,
    /// The process has the capability inside a user namespace only, where it does not count.
    UserNamespace,
    /// The control group has no realtime runtime.
    ControlGroup,
    /// The process may not use the core. For `SCHED_DEADLINE`: it may not use all cores.
    CpuSet,
    /// A seccomp filter refused the call.
    Seccomp,
    /// Other `SCHED_DEADLINE` threads have reserved the processor time.
    Busy,
    /// `kernel.sched_rt_runtime_us` leaves realtime threads too little time, or none.
    Throttle,
    /// No rule above explains the refusal.
    Unknown,
}

/// Call that was refused.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub enum Call {
    /// `sched_setscheduler` to `SCHED_FIFO` of this priority.
    Fifo(u8),
    /// `sched_setattr` to `SCHED_DEADLINE`.
    Deadline,
    /// `mlockall`.
    Lock,
    /// `sched_setaffinity` to these cores.
    Pin(Vec<usize>),
}

/// A refused call, its cause and the remedy.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Refusal {
    /// The call.
    pub call: Call,
    /// The rule that refused it.
    pub cause: Cause,
    /// The cause in words, with the values found.
    pub why: String,
    /// The remedy.
    pub mend: String,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.call {
            Call::Fifo(priority) => write!(f, "SCHED_FIFO priority {priority} was refused")?,
            Call::Deadline => f.write_str("SCHED_DEADLINE was refused")?,
            Call::Lock => f.write_str("memory is not locked")?,
            Call::Pin(cores) => write!(f, "the thread is not pinned to core {cores:?}")?,
        }
        write!(f, ": {}; {}", self.why, self.mend)
    }
}

/// State of the process and the machine by which Linux grants or refuses realtime.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Circumstances {
    /// The process has the effective capability `CAP_SYS_NICE`.
    pub may_nice: bool,
    /// The process has the effective capability `CAP_IPC_LOCK`.
    pub may_lock: bool,
    /// Soft limit `RLIMIT_RTPRIO`, the highest realtime priority; `None`: unlimited.
    pub rtprio: Option<u64>,
    /// Soft limit `RLIMIT_MEMLOCK`, the memory that may be locked, bytes; `None`: unlimited.
    pub memlock: Option<u64>,
    /// The process is in a user namespace other than the initial one. Its capabilities do not count
    /// for these calls.
    pub user_namespace: bool,
    /// The process is in a container.
    pub container: bool,
    /// A seccomp filter checks the system calls of the process.
    pub seccomp: bool,
    /// Realtime runtime of the process's control group of version 1, µs, and the file that holds
    /// this number.
    pub rt_runtime: Option<(i64, String)>,
    /// The process's control group of version 2, if that group or one above it has a file
    /// `cpu.weight`. The root group has no such file.
    pub shared_group: Option<String>,
    /// Cores that the calling thread may use, as the kernel lists them.
    pub cores: String,
    /// Cores that are online, as the kernel lists them.
    pub online: String,
    /// `kernel.sched_rt_runtime_us` and `kernel.sched_rt_period_us`; a negative runtime sets no
    /// limit.
    pub throttle_us: Option<[i64; 2]>,
}

const CAP_IPC_LOCK: u64 = 1 << 14;
const CAP_SYS_NICE: u64 = 1 << 23;
const DOCKER: &str = "start the container with `--cap-add SYS_NICE --cap-add IPC_LOCK --ulimit \
                      rtprio=99 --ulimit memlock=-1`";
const SYSCTL: &str =
    "sudo sysctl kernel.sched_rt_period_us=1000000 kernel.sched_rt_runtime_us=950000";
/// Share of a core's time that the tick asks for under `SCHED_DEADLINE`.
const DEADLINE_SHARE: f64 = 0.9;
const LIMITS: &str = "run `sudo setcap cap_ipc_lock,cap_sys_nice+ep $(command -v calot)`, or \
                      `calot check --install | sudo sh` and log in again";

impl Circumstances {
    /// Reads the circumstances of this process.
    #[must_use]
    pub fn read() -> Self {
        Self {
            rtprio: getrlimit(Resource::Rtprio).current,
            memlock: getrlimit(Resource::Memlock).current,
            ..Self::of_files(Path::new("/"))
        }
    }

    /// Reads the circumstances from the files below `root`. The resource limits are not among them.
    #[must_use]
    pub fn of_files(root: &Path) -> Self {
        let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap_or_default();
        // Each thread has its own affinity, so this reads the thread's file.
        let status = read("proc/thread-self/status");
        let number = |path: &str| read(path).trim().parse::<i64>().ok();
        let throttle_us = number("proc/sys/kernel/sched_rt_runtime_us")
            .zip(number("proc/sys/kernel/sched_rt_period_us"))
            .map(<[i64; 2]>::from);
        let field = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            line.map_or("", |line| line.trim_start_matches(':').trim())
        };
        let capabilities = u64::from_str_radix(field("CapEff"), 16).unwrap_or(0);
        let map = read("proc/self/uid_map");
        let whole = ["0", "0", "4294967295"];
        let cgroup = read("proc/self/cgroup");
        let of_cpu = cgroup.lines().find_map(|line| {
            let mut parts = line.splitn(3, ':').skip(1);
            let controllers = parts.next()?;
            let path = parts.next()?;
            controllers.split(',').any(|it| it == "cpu").then_some(path)
        });
        let rt_runtime = of_cpu.and_then(|path| {
            let file = format!("sys/fs/cgroup/cpu{path}/cpu.rt_runtime_us");
            let us = read(&file).trim().parse().ok()?;
            Some((us, format!("/{file}")))
        });
        let shared_group = cgroup.lines().find_map(|line| line.strip_prefix("0::"));
        let shared_group = shared_group.filter(|path| shares_processor(root, path));
        let first = read("proc/1/cgroup");
        let container = ["docker", "kubepods", "libpod", "lxc"];
        Self {
            may_nice: capabilities & CAP_SYS_NICE != 0,
            may_lock: capabilities & CAP_IPC_LOCK != 0,
            rtprio: None,
            memlock: None,
            user_namespace: !map.is_empty() && !map.split_whitespace().eq(whole),
            container: root.join(".dockerenv").exists()
                || root.join("run/.containerenv").exists()
                || container.iter().any(|it| first.contains(it)),
            seccomp: field("Seccomp") == "2",
            rt_runtime,
            shared_group: shared_group.map(str::to_owned),
            cores: field("Cpus_allowed_list").to_owned(),
            online: read("sys/devices/system/cpu/online").trim().to_owned(),
            throttle_us,
        }
    }

    /// Finds the cause of a refused call, and the remedy.
    #[must_use]
    pub fn judge(&self, call: Call, error: Errno) -> Refusal {
        let (cause, why) = match &call {
            Call::Fifo(priority) => self.fifo(*priority, error),
            Call::Deadline => self.deadline(error),
            Call::Lock => self.lock(error),
            Call::Pin(_) => (
                match error {
                    Errno::INVAL => Cause::CpuSet,
                    _ => self.filter(),
                },
                format!("{error}; allowed are cores {}", self.cores),
            ),
        };
        Refusal {
            mend: self.mend(&call, cause),
            call,
            cause,
            why,
        }
    }

    fn fifo(&self, priority: u8, error: Errno) -> (Cause, String) {
        let by_limit = self.rtprio.is_none_or(|limit| limit >= priority.into());
        let by_right = self.may_nice && !self.user_namespace;
        let limit = shown(self.rtprio);
        match &self.rt_runtime {
            // The kernel checks the control group after the limit and the capability.
            Some((0, file)) if error == Errno::PERM && (by_limit || by_right) => {
                (Cause::ControlGroup, format!("{error}: {file} is 0"))
            }
            _ if error != Errno::PERM || by_limit || by_right => self.other_fifo(error),
            _ if self.may_nice => (
                Cause::UserNamespace,
                format!(
                    "{error}: CAP_SYS_NICE counts inside this user namespace only, and the limit rtprio is {limit}"
                ),
            ),
            _ => (
                Cause::Limit,
                format!("{error}: the limit rtprio is {limit}, without CAP_SYS_NICE"),
            ),
        }
    }

    /// Explains a refusal that no file explains. A kernel with `CONFIG_RT_GROUP_SCHED` gives
    /// control groups of version 2 no realtime runtime. On Linux 6.18, `SCHED_FIFO` was refused in
    /// a group and granted in the root group.
    fn other_fifo(&self, error: Errno) -> (Cause, String) {
        match &self.shared_group {
            Some(group) if error == Errno::PERM && !self.seccomp => (
                Cause::ControlGroup,
                format!(
                    "{error}: limits and capabilities allow it, but this process is in the control group \
                     {group}, and a kernel with CONFIG_RT_GROUP_SCHED grants realtime in the root group only"
                ),
            ),
            _ => self.other(error),
        }
    }

    /// The kernel checks in this order: the capability; the affinity (all cores of the scheduling
    /// domain) and a realtime share above zero; the time that other deadline threads leave.
    fn deadline(&self, error: Errno) -> (Cause, String) {
        let is_whole = self.cores == self.online || self.online.is_empty();
        let throttle = self.throttle_us.filter(|[runtime, _]| *runtime >= 0);
        let share = throttle.map_or(1.0, |[runtime, period]| runtime as f64 / period as f64);
        let settings = throttle.map_or(String::new(), |[runtime, period]| {
            format!("kernel.sched_rt_runtime_us is {runtime} of {period} µs")
        });
        match error {
            Errno::BUSY if share < DEADLINE_SHARE => (
                Cause::Throttle,
                format!("{error}: {settings}, and the tick asks for 90 % of a core"),
            ),
            Errno::BUSY => (
                Cause::Busy,
                format!("{error}: other deadline threads have the time"),
            ),
            Errno::PERM if !self.may_nice => {
                (Cause::Limit, format!("{error}: it takes CAP_SYS_NICE"))
            }
            Errno::PERM if self.user_namespace => (
                Cause::UserNamespace,
                format!("{error}: CAP_SYS_NICE counts inside this user namespace only"),
            ),
            Errno::PERM if share <= 0.0 => (Cause::Throttle, format!("{error}: {settings}")),
            Errno::PERM if !is_whole => (
                Cause::CpuSet,
                format!(
                    "{error}: it takes all cores, which are {}, and allowed are {}{}",
                    self.online,
                    self.cores,
                    match self.seccomp {
                        true => "; or the seccomp filter refused",
                        false => "",
                    }
                ),
            ),
            _ => self.other(error),
        }
    }

    fn lock(&self, error: Errno) -> (Cause, String) {
        let by_right = self.may_lock && !self.user_namespace;
        let limit = match self.memlock {
            Some(bytes) => format!("{} KiB", bytes >> 10),
            None => "unlimited".to_owned(),
        };
        let limited = [Errno::NOMEM, Errno::PERM, Errno::AGAIN].contains(&error);
        match self.memlock {
            Some(_) if limited && !by_right && self.may_lock => (
                Cause::UserNamespace,
                format!(
                    "{error}: CAP_IPC_LOCK counts inside this user namespace only, and the limit memlock is {limit}"
                ),
            ),
            Some(_) if limited && !by_right => (
                Cause::Limit,
                format!("{error}: the limit memlock is {limit}, without CAP_IPC_LOCK"),
            ),
            _ => self.other(error),
        }
    }

    fn other(&self, error: Errno) -> (Cause, String) {
        let cause = self.filter();
        let by = match cause {
            Cause::Seccomp => "limits and capabilities allow it, so the seccomp filter refused",
            _ => "limits and capabilities allow it, so the kernel or a security module refused",
        };
        (cause, format!("{error}: {by}"))
    }

    fn filter(&self) -> Cause {
        match self.seccomp {
            true => Cause::Seccomp,
            false => Cause::Unknown,
        }
    }

    fn mend(&self, call: &Call, cause: Cause) -> String {
        match cause {
            Cause::Limit if *call == Call::Deadline => match self.container {
                true => "start the container with `--cap-add SYS_NICE`, or take --scheduler fifo".to_owned(),
                false => "run `sudo setcap cap_ipc_lock,cap_sys_nice+ep $(command -v calot)` (no limit of \
                    the user allows it), or take --scheduler fifo"
                    .to_owned(),
            },
            Cause::UserNamespace if *call == Call::Deadline => {
                "no capability given inside helps, nor does a limit of the user: take --scheduler fifo"
                    .to_owned()
            }
            Cause::Throttle => SYSCTL.to_owned(),
            Cause::Limit if self.container => format!("{DOCKER}; outside of a container {LIMITS}"),
            Cause::Limit => LIMITS.to_owned(),
            Cause::UserNamespace => "no capability given inside helps: raise rtprio to 95 and \
                memlock to unlimited for this user outside (`calot check --install` there), or use \
                a container that is not rootless"
                .to_owned(),
            Cause::ControlGroup if self.rt_runtime.is_none() => {
                "run `echo $$ | sudo tee /sys/fs/cgroup/cgroup.procs` and start calot from that shell; in a \
                 container, have its host do so"
                    .to_owned()
            }
            Cause::ControlGroup => {
                let file = self.rt_runtime.as_ref().map_or("", |(_, file)| file);
                format!("echo 950000 | sudo tee {file}   # Docker: --cpu-rt-runtime=950000")
            }
            Cause::CpuSet if *call == Call::Deadline => {
                "let the process use all cores (`taskset -p $$`), or take --scheduler fifo"
                    .to_owned()
            }
            Cause::CpuSet => format!("choose one of {} with --core", self.cores),
            Cause::Seccomp => "allow sched_setscheduler, sched_setattr, sched_setaffinity and mlockall in the \
                profile (Docker: --security-opt seccomp=PROFILE)"
                .to_owned(),
            Cause::Busy => "end them (`ps -eo cls,pid,comm | grep DLN`)".to_owned(),
            Cause::Unknown => "look for the cause in the system's journal (`journalctl -k`)".to_owned(),
        }
    }
}

/// True if the control group of version 2, or one above it, has the file `cpu.weight`. The real
/// root group has no such file. A container may see its own group as the root; that group has the
/// file.
fn shares_processor(root: &Path, group: &str) -> bool {
    let folder = Path::new(group.trim_start_matches('/'));
    let mut groups = folder.ancestors();
    groups.any(|group| {
        let folder = root.join("sys/fs/cgroup").join(group);
        folder.join("cpu.weight").exists()
    })
}

fn shown(limit: Option<u64>) -> String {
    limit.map_or("unlimited".to_owned(), |limit| limit.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poor() -> Circumstances {
        Circumstances {
            rtprio: Some(0),
            memlock: Some(8 << 20),
            cores: "0-1".to_owned(),
            ..Circumstances::default()
        }
    }

    #[track_caller]
    fn is(of: &Circumstances, call: Call, error: Errno, cause: Cause, words: &[&str]) {
        let refusal = of.judge(call, error);
        assert_eq!(refusal.cause, cause, "{refusal}");
        for word in words {
            assert!(refusal.to_string().contains(word), "{word}: {refusal}");
        }
    }

    #[test]
    fn a_refusal_names_the_rule_that_refused() {
        let fifo = || Call::Fifo(80);
        is(
            &poor(),
            fifo(),
            Errno::PERM,
            Cause::Limit,
            &["rtprio is 0", "setcap"],
        );
        is(
            &poor(),
            Call::Lock,
            Errno::NOMEM,
            Cause::Limit,
            &["8192 KiB", "setcap"],
        );
        let mut docker = poor();
        docker.container = true;
        is(
            &docker,
            fifo(),
            Errno::PERM,
            Cause::Limit,
            &["--cap-add SYS_NICE", "--ulimit rtprio=99"],
        );
        is(
            &docker,
            Call::Lock,
            Errno::NOMEM,
            Cause::Limit,
            &["--cap-add IPC_LOCK", "memlock=-1"],
        );
        let mut rootless = poor();
        (
            rootless.may_nice,
            rootless.may_lock,
            rootless.user_namespace,
        ) = (true, true, true);
        is(
            &rootless,
            fifo(),
            Errno::PERM,
            Cause::UserNamespace,
            &["inside this user namespace"],
        );
        is(
            &rootless,
            Call::Lock,
            Errno::NOMEM,
            Cause::UserNamespace,
            &["CAP_IPC_LOCK"],
        );
        is(
            &rootless,
            Call::Deadline,
            Errno::PERM,
            Cause::UserNamespace,
            &["user namespace"],
        );
        is(
            &poor(),
            Call::Pin(vec![7]),
            Errno::INVAL,
            Cause::CpuSet,
            &["0-1", "--core"],
        );
        is(
            &poor(),
            Call::Deadline,
            Errno::BUSY,
            Cause::Busy,
            &["deadline"],
        );
    }

    #[test]
    fn refused_deadline_scheduler_is_explained_by_the_rule_that_refused() {
        let deadline = || Call::Deadline;
        let perm = Errno::PERM;
        let words = ["takes CAP_SYS_NICE", "no limit of the user", "setcap"];
        is(&poor(), deadline(), perm, Cause::Limit, &words);
        let mut boxed = poor();
        boxed.container = true;
        let words = ["--cap-add SYS_NICE", "--scheduler fifo"];
        is(&boxed, deadline(), perm, Cause::Limit, &words);
        let mut root = poor();
        (root.may_nice, root.online) = (true, "0-1".to_owned());
        root.throttle_us = Some([950_000, 1_000_000]);
        let words = ["security module", "journalctl"];
        is(&root, deadline(), perm, Cause::Unknown, &words);
        root.seccomp = true;
        let words = ["the seccomp filter refused", "sched_setattr"];
        is(&root, deadline(), perm, Cause::Seccomp, &words);
        root.online = "0-3".to_owned();
        let words = [
            "which are 0-3",
            "allowed are 0-1; or the seccomp",
            "taskset",
        ];
        is(&root, deadline(), perm, Cause::CpuSet, &words);
        root.throttle_us = Some([0, 1_000_000]);
        let words = ["sched_rt_runtime_us is 0 of 1000000 µs", "sudo sysctl"];
        is(&root, deadline(), perm, Cause::Throttle, &words);
        root.throttle_us = Some([950_000, 2_000_000]);
        let words = ["950000 of 2000000 µs", "90 % of a core"];
        is(&root, deadline(), Errno::BUSY, Cause::Throttle, &words);
        root.throttle_us = Some([-1, 1_000_000]);
        is(&root, deadline(), Errno::BUSY, Cause::Busy, &["end them"]);
    }

    #[test]
    fn a_control_group_without_runtime_is_not_explained_by_capabilities() {
        let mut root = poor();
        (root.may_nice, root.may_lock) = (true, true);
        root.rt_runtime = Some((0, "/sys/fs/cgroup/cpu/box/cpu.rt_runtime_us".to_owned()));
        let words = ["/sys/fs/cgroup/cpu/box/cpu.rt_runtime_us is 0", "950000"];
        is(
            &root,
            Call::Fifo(80),
            Errno::PERM,
            Cause::ControlGroup,
            &words,
        );
        root.rt_runtime = None;
        is(
            &root,
            Call::Fifo(80),
            Errno::PERM,
            Cause::Unknown,
            &["security module"],
        );
        root.seccomp = true;
        is(
            &root,
            Call::Fifo(80),
            Errno::PERM,
            Cause::Seccomp,
            &["seccomp filter"],
        );
        (root.seccomp, root.shared_group) = (false, Some("/box/7".to_owned()));
        is(
            &root,
            Call::Fifo(80),
            Errno::PERM,
            Cause::ControlGroup,
            &["/box/7", "CONFIG_RT_GROUP_SCHED", "cgroup.procs"],
        );
        root.seccomp = true;
        let text = root.judge(Call::Lock, Errno::PERM).to_string();
        assert!(
            !text.contains("setcap") && text.contains("seccomp"),
            "{text}"
        );
    }

    #[test]
    fn circumstances_are_read_from_the_kernels_files() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        write(
            "proc/thread-self/status",
            "Name:\tcalot\nCapEff:\t0000000000804000\nSeccomp:\t2\nCpus_allowed_list:\t0,2-3\n",
        );
        write("proc/self/uid_map", "         0       1000          1\n");
        write("proc/self/cgroup", "4:cpu,cpuacct:/box\n1:name=systemd:/\n");
        write("proc/1/cgroup", "0::/docker/12\n");
        write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
        write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
        write("sys/devices/system/cpu/online", "0-3\n");
        write("sys/fs/cgroup/cpu/box/cpu.rt_runtime_us", "0\n");
        let found = Circumstances::of_files(folder.path());
        assert!(found.may_nice && found.may_lock && found.user_namespace);
        assert!(found.container && found.seccomp);
        assert_eq!((&*found.cores, &*found.online), ("0,2-3", "0-3"));
        assert_eq!(found.throttle_us, Some([950_000, 1_000_000]));
        let file = "/sys/fs/cgroup/cpu/box/cpu.rt_runtime_us";
        assert_eq!(found.rt_runtime, Some((0, file.to_owned())));
        assert_eq!(found.shared_group, None);
        write("proc/self/cgroup", "0::/box/7\n");
        assert_eq!(Circumstances::of_files(folder.path()).shared_group, None);
        write("sys/fs/cgroup/box/cpu.weight", "100\n");
        let found = Circumstances::of_files(folder.path());
        assert_eq!(found.shared_group.as_deref(), Some("/box/7"));
        write("proc/self/uid_map", "         0          0 4294967295\n");
        assert!(!Circumstances::of_files(folder.path()).user_namespace);
    }
}
