//! Writes the black box as a trace for Perfetto (ui.perfetto.dev) or chrome://tracing. The trace
//! shows the ticks around each of the most delayed ones, with their wake-up latencies and stages.
//! With `--why` it also shows everything that ran on their core.

use serde_json::{Value, json};
use shared_mem::message::{STAGE_NAMES, TickRecord};

use crate::blackbox::{Incident, Tick};

/// Row of the wake-up latencies. Each slice goes from the due time of a tick to the time at which
/// the tick began.
const DUE: u32 = 1;
/// Row of the ticks.
const TICK: u32 = 2;
/// Row of the stages of the ticks.
const STAGES: u32 = 3;
/// Row of what ran on the core.
const CORE: u32 = 4;

/// Returns the trace as JSON. Each incident is a process of its own with time 0 at the due time of
/// its first tick, so that the viewer aligns all incidents.
pub fn json(incidents: &[Incident]) -> Value {
    let mut events = Vec::new();
    for (number, incident) in incidents.iter().enumerate() {
        let Some(first) = incident.ticks.first() else {
            continue;
        };
        let pid = number + 1;
        let name = format!("worst {pid}, at {:.3} s", incident.at_ms as f64 / 1e3);
        events.push(meta("process_name", pid, 0, &name));
        for (row, name) in [(DUE, "due"), (TICK, "tick"), (STAGES, "stages")] {
            events.push(meta("thread_name", pid, row, name));
        }
        if !incident.slices.is_empty() {
            events.push(meta("thread_name", pid, CORE, "ran on the core"));
        }
        for slice in &incident.slices {
            let at_ns = slice.from_ns as f64 - first.scheduled_ns as f64;
            events.push(json!({
                "ph": "X", "pid": pid, "tid": CORE, "name": slice.name, "cat": slice.what.name(),
                "ts": at_ns.max(0.0) / 1e3,
                "dur": (slice.for_ns as f64 + at_ns.min(0.0)) / 1e3,
            }));
        }
        for tick in &incident.ticks {
            events.extend(slices(tick, first.scheduled_ns, pid));
        }
    }
    // `--overwrite` recognises the file as Calot's by the name of the program.
    let program = concat!("calot ", env!("CARGO_PKG_VERSION"));
    json!({
        "displayTimeUnit": "ns",
        "otherData": { "program": program },
        "traceEvents": events,
    })
}

fn meta(what: &str, pid: usize, row: u32, name: &str) -> Value {
    json!({"ph": "M", "name": what, "pid": pid, "tid": row, "args": {"name": name}})
}

fn slices(tick: &Tick, zero_ns: u64, pid: usize) -> Vec<Value> {
    let slice = |row: u32, name: &str, at_ns: u64, for_ns: u64, args: Value| {
        json!({
            "ph": "X", "pid": pid, "tid": row, "name": name, "args": args,
            "ts": at_ns as f64 / 1e3, "dur": for_ns as f64 / 1e3,
        })
    };
    let due_ns = tick.scheduled_ns.saturating_sub(zero_ns);
    let begun_ns = due_ns + u64::from(tick.wake_latency_ns);
    let name = format!("tick {}", tick.tick);
    let args = json!({
        "wake_latency_ns": tick.wake_latency_ns,
        "tick_ns": tick.tick_ns,
        "missed": tick.missed,
        "overran": tick.bits & TickRecord::OVERRAN != 0,
        "contact": tick.bits & TickRecord::CONTACT != 0,
    });
    let waiting = json!({"missed": tick.missed});
    let mut slices = vec![
        slice(DUE, "wake-up", due_ns, tick.wake_latency_ns.into(), waiting),
        slice(TICK, &name, begun_ns, tick.tick_ns.into(), args),
    ];
    let mut at_ns = begun_ns;
    for (name, &ns) in STAGE_NAMES.iter().zip(&tick.stage_ns) {
        slices.push(slice(STAGES, name, at_ns, ns.into(), json!({})));
        at_ns += u64::from(ns);
    }
    if tick.is_miss() {
        slices.push(json!({
            "ph": "i", "s": "p", "pid": pid, "tid": TICK, "name": "deadline missed",
            "ts": due_ns as f64 / 1e3,
        }));
    }
    slices
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::why::What;
    use crate::why::tests::slice;

    #[test]
    fn every_tick_is_there_with_its_stages_in_order_and_a_miss_is_marked() {
        let tick = |n: u64, missed| Tick {
            tick: n,
            scheduled_ns: n * 1_000_000,
            wake_latency_ns: 5000,
            tick_ns: 70_000,
            missed,
            stage_ns: [10_000; 7],
            bits: 0,
        };
        let incident = Incident {
            at_ms: 1500,
            worst: 1,
            ticks: vec![tick(9, 0), tick(10, 2), tick(13, 0)],
            slices: vec![
                slice(What::Idle, "swapper/1", 8_990_000, 12_000),
                slice(What::Thread, "kworker/1:0", 9_002_000, 3000),
            ],
        };
        let trace = super::json(&[incident]);
        let events = trace["traceEvents"].as_array().unwrap();
        let of = |ph: &str| events.iter().filter(|e| e["ph"] == ph).count();
        assert_eq!((of("M"), of("X"), of("i")), (5, 3 * 9 + 2, 1));
        let on_core: Vec<_> = events
            .iter()
            .filter(|e| e["tid"] == 4 && e["ph"] == "X")
            .collect();
        assert_eq!(
            (&on_core[0]["ts"], &on_core[0]["dur"]),
            (&json!(0.0), &json!(2.0))
        );
        assert_eq!(
            (&on_core[1]["name"], &on_core[1]["cat"]),
            (&json!("kworker/1:0"), &json!("thread"))
        );
        assert_eq!(
            (&on_core[1]["ts"], &on_core[1]["dur"]),
            (&json!(2.0), &json!(3.0))
        );
        for event in events.iter().filter(|e| e["ph"] == "X") {
            assert!(event["ts"].as_f64().unwrap() >= 0.0 && event["dur"].as_f64().is_some());
        }
        let stages: Vec<_> = events
            .iter()
            .filter(|e| e["tid"] == 3 && e["ph"] == "X")
            .collect();
        for pair in stages[..7].windows(2) {
            let end = pair[0]["ts"].as_f64().unwrap() + pair[0]["dur"].as_f64().unwrap();
            assert!((pair[1]["ts"].as_f64().unwrap() - end).abs() < 1e-9);
        }
        assert_eq!(stages[0]["ts"], 5.0);
    }
}
