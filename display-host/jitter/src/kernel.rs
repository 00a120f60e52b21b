//! Reads counters that only the kernel has: interrupts on the tick's core, context switches of the
//! tick's thread, system management interrupts.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;

/// Name of the tick's thread.
pub const TICK_THREAD: &str = "calot-tick";
/// Model-specific register that counts system management interrupts (Intel).
const SMI_COUNT: u64 = 0x34;
/// Unit of times in `/proc/stat`, ms: 1/USER_HZ, which is 1/100 s for every program.
const USER_TICK_MS: u64 = 10;

/// Kernel counters at one moment.
#[derive(Debug, Clone, Default)]
pub struct Counters(BTreeMap<String, u64>);

impl Counters {
    /// Reads all counters that are accessible. `process` is the process of the tick's thread.
    pub fn read(core: usize, process: Option<u32>) -> Self {
        let mut all = BTreeMap::new();
        let table = fs::read_to_string("/proc/interrupts").unwrap_or_default();
        let mut sum = 0;
        for (name, count) in interrupts(&table, core) {
            sum += count;
            all.insert(format!("interrupts.{name}"), count);
        }
        if sum > 0 {
            all.insert("interrupts.all".to_owned(), sum);
        }
        if let Some(count) = process.and_then(voluntary_switches) {
            all.insert("voluntary_switches".to_owned(), count);
        }
        if let Some(count) = smi_count(core) {
            all.insert("smis".to_owned(), count);
        }
        Self(all)
    }

    /// Increase of each counter since `start`. Omits interrupts that did not occur.
    pub fn since(&self, start: &Self) -> Vec<(String, u64)> {
        let added = self.0.iter().map(|(name, count)| {
            let before = start.0.get(name).copied().unwrap_or(0);
            (name.clone(), count.saturating_sub(before))
        });
        added
            .filter(|(name, count)| *count > 0 || !name.starts_with("interrupts."))
            .collect()
    }

    /// True if system management interrupts are counted.
    pub fn knows_smis(&self) -> bool {
        self.0.contains_key("smis")
    }
}

/// Memory that this program holds, KiB.
pub fn resident_kib() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Time that the hypervisor took from a core since the machine started, ms, in steps of 10. `None`
/// if `/proc/stat` has no such figure for the core.
pub fn stolen_ms(core: usize) -> Option<u64> {
    stolen(&fs::read_to_string("/proc/stat").ok()?, core)
}

/// Parses the stolen time from `/proc/stat`.
fn stolen(table: &str, core: usize) -> Option<u64> {
    let wanted = format!("cpu{core}");
    let mut lines = table.lines().map(str::split_whitespace);
    let mut words = lines.find_map(|mut words| (words.next()? == wanted).then_some(words))?;
    // user nice system idle iowait irq softirq steal
    let ticks: u64 = words.nth(7)?.parse().ok()?;
    Some(ticks * USER_TICK_MS)
}

/// Name and count of each interrupt on a core, from `/proc/interrupts` or `/proc/softirqs`.
pub(crate) fn interrupts(table: &str, core: usize) -> Vec<(String, u64)> {
    let mut lines = table.lines();
    let heading = lines.next().unwrap_or_default();
    let wanted = format!("CPU{core}");
    let cores: Vec<&str> = heading.split_whitespace().collect();
    let Some(column) = cores.iter().position(|&name| name == wanted) else {
        return Vec::new();
    };
    let read = |line: &str| -> Option<(String, u64)> {
        let (number, rest) = line.split_once(':')?;
        let words: Vec<&str> = rest.split_whitespace().collect();
        let count: u64 = words.get(column)?.parse().ok()?;
        // A device's line starts with a number and ends with its name. A kernel interrupt's line
        // starts with its name.
        let named = number.trim();
        let name = match named.parse::<u32>() {
            Ok(_) => words.last().copied().unwrap_or(named),
            Err(_) => named,
        };
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        Some((name.chars().map(plain).collect(), count))
    };
    lines
        .filter_map(read)
        .filter(|(_, count)| *count > 0)
        .collect()
}

/// Voluntary context switches of the thread `calot-tick` of a process.
fn voluntary_switches(process: u32) -> Option<u64> {
    let status = fs::read_to_string(task(process, TICK_THREAD)?.join("status")).ok()?;
    switches(&status, "voluntary_ctxt_switches")
}

/// Folder of the thread `name` of a process.
pub(crate) fn task(process: u32, name: &str) -> Option<PathBuf> {
    let tasks = fs::read_dir(format!("/proc/{process}/task")).ok()?;
    let mut folders = tasks.flatten().map(|task| task.path());
    folders.find(|folder| {
        fs::read_to_string(folder.join("comm")).is_ok_and(|comm| comm.trim() == name)
    })
}

/// Count of context switches in the text of a thread's `status`.
pub(crate) fn switches(status: &str, kind: &str) -> Option<u64> {
    let mut fields = status.lines().filter_map(|line| line.split_once(':'));
    let (_, count) = fields.find(|(name, _)| *name == kind)?;
    count.trim().parse().ok()
}

fn smi_count(core: usize) -> Option<u64> {
    let vendor = fs::read_to_string("/proc/cpuinfo").ok()?;
    if !vendor.contains("GenuineIntel") {
        return None;
    }
    let registers = fs::File::open(format!("/dev/cpu/{core}/msr")).ok()?;
    let mut bytes = [0; 8];
    registers.read_exact_at(&mut bytes, SMI_COUNT).ok()?;
    Some(u64::from_le_bytes(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "           CPU0       CPU1       
  1:          0          9   IO-APIC   1-edge      i8042
 24:        100          7   PCI-MSIX-0000:00:01.0   0-edge      virtio0-config
LOC:       5000       6000   Local timer interrupts
ERR:          0
";

    #[test]
    fn interrupts_of_one_core_by_name() {
        let found = interrupts(TABLE, 1);
        let expected = [("i8042", 9), ("virtio0_config", 7), ("LOC", 6000)];
        assert_eq!(found, expected.map(|(name, n)| (name.to_owned(), n)));
        assert_eq!(interrupts(TABLE, 0).len(), 2);
        assert!(interrupts(TABLE, 7).is_empty());
        assert!(interrupts("", 0).is_empty());
    }

    #[test]
    fn softirqs_have_the_same_form_and_switches_are_found_by_their_whole_name() {
        let table = "                    CPU0       CPU1\n          HI:          0          3\n";
        assert_eq!(interrupts(table, 1), [("HI".to_owned(), 3)]);
        let status = "Name:\tx\nvoluntary_ctxt_switches:\t150\nnonvoluntary_ctxt_switches:\t5\n";
        assert_eq!(switches(status, "voluntary_ctxt_switches"), Some(150));
        assert_eq!(switches(status, "nonvoluntary_ctxt_switches"), Some(5));
        assert_eq!(switches("", "voluntary_ctxt_switches"), None);
    }

    #[test]
    fn this_program_holds_memory() {
        assert!(resident_kib().is_some_and(|kib| kib > 100));
    }

    #[test]
    fn stolen_time_of_one_core() {
        let table = "cpu  9 9 9 9 9 9 9 99\ncpu0 1 2 3 4 5 6 7 8 9 10\ncpu1 1 2 3 4 5 6 7 0 9 10\n";
        assert_eq!(stolen(table, 0), Some(80));
        assert_eq!(stolen(table, 1), Some(0));
        assert_eq!(stolen(table, 2), None);
        assert_eq!(stolen("cpu0 1 2 3", 0), None);
    }

    #[test]
    fn counters_tell_only_what_was_added() {
        let counters = |pairs: &[(&str, u64)]| {
            Counters(pairs.iter().map(|&(k, v)| (k.to_owned(), v)).collect())
        };
        let before = counters(&[("interrupts.LOC", 5), ("interrupts.x", 1), ("smis", 3)]);
        let after = counters(&[("interrupts.LOC", 9), ("interrupts.x", 1), ("smis", 3)]);
        let expected = [("interrupts.LOC".to_owned(), 4), ("smis".to_owned(), 0)];
        assert_eq!(after.since(&before), expected);
        assert!(after.knows_smis());
    }
}
