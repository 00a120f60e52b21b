//! Describes the machine of a measurement. Figures of different machines are not comparable.

use std::fs;

/// The kernel's description of this machine. A field that cannot be read is "unknown".
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Machine {
    /// Model of the processor.
    pub processor: String,
    /// Cores that this process may use.
    pub cores: usize,
    /// Memory, MiB.
    pub memory_mib: u64,
    /// Release of the kernel.
    pub kernel: String,
    /// Build line of the kernel. It names the kernel's preemption model.
    pub kernel_version: String,
    /// True if a hypervisor runs this machine.
    pub virtual_machine: bool,
    /// Clock source.
    pub clock_source: String,
    /// Frequency governor of the first core.
    pub governor: String,
    /// Load averages of 1, 5 and 15 minutes at the time of reading.
    pub load_average: String,
    /// Command line of the kernel: isolated cores, idle states, mitigations.
    #[serde(default = "unknown")]
    pub command_line: String,
    /// Revision of the processor's microcode.
    #[serde(default = "unknown")]
    pub microcode: String,
}

/// Value of a property that could not be read, or that an older file lacks.
fn unknown() -> String {
    "unknown".to_owned()
}

impl Machine {
    /// Reads the description.
    #[must_use]
    pub fn read() -> Self {
        let cpuinfo = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let memory = fs::read_to_string("/proc/meminfo").unwrap_or_default();
        let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
        let has_flag = |flag: &str| field(&cpuinfo, "flags").split(' ').any(|f| f == flag);
        let memory_kib = field(&memory, "MemTotal")
            .split(' ')
            .next()
            .and_then(|n| n.parse().ok());
        Self {
            processor: field(&cpuinfo, "model name").to_owned(),
            cores: std::thread::available_parallelism().map_or(0, usize::from),
            memory_mib: memory_kib.unwrap_or(0u64) / 1024,
            kernel: line("/proc/sys/kernel/osrelease"),
            kernel_version: line("/proc/sys/kernel/version"),
            virtual_machine: has_flag("hypervisor"),
            clock_source: line("/sys/devices/system/clocksource/clocksource0/current_clocksource"),
            governor: line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
            load_average: load.split(' ').take(3).collect::<Vec<_>>().join(" "),
            command_line: line("/proc/cmdline"),
            microcode: field(&cpuinfo, "microcode").to_owned(),
        }
    }
}

fn line(path: &str) -> String {
    match fs::read_to_string(path) {
        Ok(text) if !text.trim().is_empty() => text.trim().to_owned(),
        _ => unknown(),
    }
}

/// Value of the first line `name : value`.
fn field<'a>(text: &'a str, name: &str) -> &'a str {
    text.lines()
        .filter_map(|line| line.split_once(':'))
        .find(|(key, _)| key.trim() == name)
        .map_or("unknown", |(_, value)| value.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_by_their_whole_name() {
        let text = "model\t: 1\nmodel name\t: EPYC\nflags\t\t: fpu hypervisor\n";
        assert_eq!(field(text, "model name"), "EPYC");
        assert_eq!(field(text, "flags"), "fpu hypervisor");
        assert_eq!(field(text, "absent"), "unknown");
    }

    #[test]
    fn this_machine_has_cores_and_a_kernel() {
        let machine = Machine::read();
        assert!(machine.cores >= 1);
        assert_ne!(machine.kernel, "unknown");
        assert_ne!(machine.command_line, "unknown");
    }

    #[test]
    fn a_description_of_an_older_version_is_read() {
        let machine = Machine::read();
        let mut json = serde_json::to_value(&machine).unwrap();
        let fields = json.as_object_mut().unwrap();
        for name in ["command_line", "microcode"] {
            assert!(fields.remove(name).is_some());
        }
        let old: Machine = serde_json::from_value(json).unwrap();
        assert_eq!(
            (old.command_line.as_str(), old.kernel),
            ("unknown", machine.kernel)
        );
    }
}
