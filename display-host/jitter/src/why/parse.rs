//! Reads lines of the kernel's trace (`trace_pipe`).

use super::What;
use super::course::Event;

/// Time by `CLOCK_MONOTONIC` and event of a line. `None` if the line has no event that tells what
/// runs. A note about lost events has time 0.
pub fn line(text: &str) -> Option<(u64, Event<'_>)> {
    if let Some(count) = lost(text) {
        return Some((0, Event::Lost(count)));
    }
    // TASK-PID [CPU] FLAGS TIME: EVENT: …; a task's name may contain blanks and brackets.
    let (_, rest) = text.split_once("] ")?;
    let (before, rest) = rest.split_once(": ")?;
    let at_ns = time_ns(before.split_whitespace().last()?)?;
    let (name, rest) = rest.split_once(':')?;
    Some((at_ns, event(name.trim(), rest.trim())?))
}

/// Number of events that were lost: `CPU:1 [LOST 123 EVENTS]`.
fn lost(text: &str) -> Option<u64> {
    let (_, rest) = text.trim().strip_prefix("CPU:")?.split_once("[LOST ")?;
    rest.strip_suffix(" EVENTS]")?.parse().ok()
}

/// Time `1234.567890` in ns.
fn time_ns(word: &str) -> Option<u64> {
    let (seconds, fraction) = word.split_once('.')?;
    let digits = u32::try_from(fraction.len()).ok().filter(|&n| n <= 9)?;
    let unit = 10u64.pow(9 - digits);
    let seconds: u64 = seconds.parse().ok()?;
    let fraction: u64 = fraction.parse().ok()?;
    seconds
        .checked_mul(1_000_000_000)?
        .checked_add(fraction * unit)
}

fn event<'a>(name: &'a str, rest: &'a str) -> Option<Event<'a>> {
    let value = |key: &str| {
        let (_, after) = rest.split_once(key)?;
        Some(after.split([' ', ']']).next().unwrap_or(after))
    };
    match name {
        "sched_switch" => {
            let (_, next) = rest.split_once("==> next_comm=")?;
            let next = next.rsplit_once(" next_pid=")?.0;
            Some(Event::Switch { next })
        }
        "irq_handler_entry" => Some(Event::Enter(What::Interrupt, value("name=")?)),
        "irq_handler_exit" => Some(Event::Leave(What::Interrupt)),
        "softirq_entry" => Some(Event::Enter(What::Softirq, value("action=")?)),
        "softirq_exit" => Some(Event::Leave(What::Softirq)),
        // nmi_handler: perf_event_nmi_handler() delta_ns: 1234 handled: 1
        "nmi_handler" => {
            let (handler, _) = rest.split_once("()")?;
            Some(Event::Over(handler, value("delta_ns: ")?.parse().ok()?))
        }
        // Interrupts of the processor itself: local_timer_entry, reschedule_entry, ….
        _ if !rest.starts_with("vector=") => None,
        _ => match (name.strip_suffix("_entry"), name.strip_suffix("_exit")) {
            (Some(interrupt), _) => Some(Event::Enter(What::Interrupt, interrupt)),
            (_, Some(_)) => Some(Event::Leave(What::Interrupt)),
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAPTURED: &str = include_str!("captured.txt");

    #[test]
    fn captured_text_of_a_kernel_is_read_line_by_line() {
        let lines: Vec<&str> = CAPTURED
            .lines()
            .filter(|line| !line.starts_with('#'))
            .collect();
        let read: Vec<_> = lines.iter().map(|text| (*text, line(text))).collect();
        for (text, found) in &read {
            assert!(found.is_some(), "not read: {text}");
        }
        let times: Vec<u64> = read.iter().filter_map(|it| Some(it.1?.0)).collect();
        assert!(times.is_sorted() && times[0] > 0);
        let count = |is_it: fn(&Event<'_>) -> bool| {
            let events = read.iter().filter_map(|it| it.1);
            events.filter(|it| is_it(&it.1)).count()
        };
        let switches = count(|it| matches!(it, Event::Switch { .. }));
        let entered = count(|it| matches!(it, Event::Enter(What::Interrupt, "local_timer")));
        let softirqs = count(|it| matches!(it, Event::Enter(What::Softirq, _)));
        assert!(switches > 0 && entered > 0 && softirqs > 0);
    }

    #[test]
    fn each_event_is_told_by_its_words() {
        let all = [
            (
                "          <idle>-0       [001] dNh1.  1234.567890: local_timer_entry: vector=236",
                (
                    1_234_567_890_000,
                    Event::Enter(What::Interrupt, "local_timer"),
                ),
            ),
            (
                "   Web Content-77      [003] d.h.. 2.000001: irq_handler_entry: irq=26 name=xhci_hcd",
                (2_000_001_000, Event::Enter(What::Interrupt, "xhci_hcd")),
            ),
            (
                " a-1 [001] ..s1. 2.5: softirq_entry: vec=3 [action=NET_RX]",
                (2_500_000_000, Event::Enter(What::Softirq, "NET_RX")),
            ),
            (
                " a-1 [001] d..2. 3.000000: sched_switch: prev_comm=a prev_pid=1 prev_prio=120 \
                 prev_state=R+ ==> next_comm=Web Content next_pid=77 next_prio=120",
                (
                    3_000_000_000,
                    Event::Switch {
                        next: "Web Content",
                    },
                ),
            ),
            (
                " a-1 [001] d.Z1. 4.000000: nmi_handler: perf_event_nmi_handler() delta_ns: 1234 \
                 handled: 1",
                (4_000_000_000, Event::Over("perf_event_nmi_handler", 1234)),
            ),
            ("CPU:1 [LOST 4523 EVENTS]", (0, Event::Lost(4523))),
        ];
        for (text, expected) in all {
            assert_eq!(line(text), Some(expected), "{text}");
        }
    }

    #[test]
    fn other_lines_are_passed_over() {
        for text in [
            "",
            "# tracer: nop",
            "nonsense",
            " a-1 [001] d..2. 3.000000: sched_wakeup: comm=b pid=2 prio=120 target_cpu=001",
            " a-1 [001] d..2. later: softirq_exit: vec=1 [action=TIMER]",
            " a-1 [001] d..2. 3.0000000000: softirq_exit: vec=1 [action=TIMER]",
            " a-1 [001] d..2. 3.0: sched_switch: cut off",
            "CPU:1 [LOST many EVENTS]",
        ] {
            assert_eq!(line(text), None, "{text}");
        }
    }
}
