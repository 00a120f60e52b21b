//! The page `report.html`: self-contained and understandable without prior knowledge.

use core::fmt::Write as _;
use std::path::Path;

use figures::html::{STYLE, escape, machine_table};
use figures::{Quantiles, times};
use shared_mem::message::STAGE_NAMES;

use super::{Recorder, Summary};
use crate::headless::{Ended, RunOutcome};

/// Text of the page. Pictures in `folder` are linked by their relative names.
pub(super) fn render(
    summary: &Summary,
    recorder: &Recorder,
    outcome: &RunOutcome,
    folder: &Path,
) -> String {
    let mut page = Page(String::new());
    page.add(format_args!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot: {scene}</title><style>{STYLE}</style>\
         <h1>Calot run: {scene}</h1><p class=\"lead\">{program}, scene {id}. {ended}</p>",
        scene = escape(&summary.scene),
        program = escape(&summary.program),
        id = &summary.scene_id[..summary.scene_id.len().min(12)],
        ended = ended(summary.ended),
    ));
    if summary.task.is_some() {
        page.add(format_args!("{DEBRIEF}"));
    }
    verdict(&mut page, summary);
    times(&mut page, summary);
    charts(&mut page, recorder);
    devices(&mut page, summary);
    counters(&mut page, summary);
    pictures(&mut page, outcome, folder);
    machine(&mut page, summary);
    page.0 + "</html>\n"
}

/// Points trainees and instructors to their page: this one is about the station.
const DEBRIEF: &str = "<p class=\"lead\">This page is for technicians: it is about the station and its timing. The \
                       debrief for trainee and instructor is <a href=\"debrief.html\">debrief.html</a>.</p>";

struct Page(String);

impl Page {
    fn add(&mut self, text: core::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(text);
    }
}

fn ended(how: Ended) -> &'static str {
    match how {
        Ended::TimeOver => "It ran for its full time.",
        Ended::TaskOver => "It ended with the outcome of its task.",
        Ended::Stopped => "It was stopped by the user.",
        Ended::ControllerGone => "<b>The controller stopped responding before the end.</b>",
        Ended::ProcessDied => "<b>A process of the station died: see the warnings.</b>",
        Ended::DisplayLost => "<b>The display was lost before the end: see the warnings.</b>",
    }
}

fn verdict(page: &mut Page, s: &Summary) {
    if s.realtime {
        page.add(format_args!(
            "<p class=\"good\">The controller ran with SCHED_FIFO, locked memory and a core of \
             its own: these are realtime figures of this machine.</p>"
        ));
    } else {
        let lacks = s.not_realtime.join(", ");
        page.add(format_args!(
            "<p class=\"bad\"><b>Not realtime.</b> The controller lacked: {}. These figures say \
             little about a station that meets these conditions.</p>",
            escape(&lacks)
        ));
    }
    if s.machine.virtual_machine {
        page.add(format_args!(
            "<p class=\"lead\">This is a virtual machine: its host adds delays that no setting \
             inside it removes.</p>"
        ));
    }
    for warning in &s.warnings {
        page.add(format_args!("<p class=\"bad\">{}</p>", escape(warning)));
    }
}

fn times(page: &mut Page, s: &Summary) {
    page.add(format_args!(
        "<h2>Times</h2><table><tr><th>µs<th>p50<th>p99<th>p99.9<th>max<th>count</tr>"
    ));
    let mut row = |name: &str, q: &Quantiles| {
        let us = |ns: u64| match q.count {
            0 => "–".to_owned(),
            _ => format!("{:.1}", ns as f64 / 1e3),
        };
        page.add(format_args!(
            "<tr><td>{name}<td>{}<td>{}<td>{}<td>{}<td>{}</tr>",
            us(q.p50),
            us(q.p99),
            us(q.p999),
            us(q.max),
            q.count
        ));
    };
    row(
        "wake latency (actual − scheduled start)",
        &s.wake_latency_ns,
    );
    row("whole tick", &s.tick_ns);
    for name in STAGE_NAMES {
        row(&format!("&nbsp;&nbsp;{name}"), &s.stage_ns[name]);
    }
    row(
        "motion to force (sample arrived → force written)",
        &s.motion_to_force_ns,
    );
    row("publish to frame submitted", &s.publish_to_frame_ns);
    row(
        "motion to picture (sample arrived → picture handed over)",
        &s.motion_to_picture_ns,
    );
    row(
        "motion to presentation (sample arrived → picture presented)",
        &s.motion_to_presentation_ns,
    );
    page.add(format_args!(
        "</table><p class=\"lead\">Motion to picture ends when the picture is handed to the screen, motion \
         to presentation when the window system presents it ({}). The time until the screen lights up is in \
         neither: <code>calot photon</code> measures it.</p>",
        escape(&s.presentation.said())
    ));
}

fn charts(page: &mut Page, recorder: &Recorder) {
    page.add(format_args!("<h2>Histograms</h2>"));
    let mut figure = |svg: Option<String>, caption: &str| {
        let picture = svg.unwrap_or_else(|| "<p>Nothing was recorded.</p>".to_owned());
        page.add(format_args!(
            "<figure>{picture}<figcaption>{caption}</figcaption></figure>"
        ));
    };
    figure(
        times::histogram(&recorder.wake_latency, None),
        "Wake latency: how late a tick began. Both axes are logarithmic, so that one late tick \
         in a million is seen.",
    );
    figure(
        times::histogram(&recorder.tick, Some(1000.0)),
        "Whole tick; the blue line is the period of 1 ms.",
    );
    figure(
        times::histogram(&recorder.motion_to_force, None),
        "Motion to force: from the arrival of a device sample at this computer until the force \
         that answers it is written. It contains the time that the sample waited for the tick, up \
         to a period.",
    );
    figure(
        times::course(&recorder.force_course(), "N"),
        "Force on the hand over time.",
    );
    figure(
        times::course(&recorder.tick_course(), "µs"),
        "Longest tick of each second.",
    );
    figure(
        times::course(&recorder.wake_course(), "µs"),
        "Latest wake-up of each second.",
    );
}

fn devices(page: &mut Page, s: &Summary) {
    if s.devices.is_empty() {
        return;
    }
    page.add(format_args!(
        "<h2>Devices</h2><table><tr><th>device<th>line<th>name<th>serial<th>good<th>bad<th>lost\
         <th>refused<th>unread<th>declares</tr>"
    ));
    for device in &s.devices {
        let declared = device.capabilities.iter();
        let declared: Vec<String> = declared.map(|(name, is)| format!("{name} {is}")).collect();
        let serial = match device.serial {
            0 => "–".to_owned(),
            serial => serial.to_string(),
        };
        let line = &device.line;
        page.add(format_args!(
            "<tr><td>{}<td>{}<td>{}<td>{serial}<td>{}<td>{}<td>{}<td>{}<td>{}<td>{}</tr>",
            escape(&device.kind),
            escape(&device.path.display().to_string()),
            escape(&device.name),
            line.frames,
            line.bad_frames,
            line.lost_frames,
            line.dropped_writes,
            line.unread_bytes,
            escape(&declared.join(", "))
        ));
    }
    page.add(format_args!("</table>"));
}

fn counters(page: &mut Page, s: &Summary) {
    page.add(format_args!("<h2>Counters</h2><table>"));
    let per_million = match s.ticks + s.missed_periods {
        0 => 0.0,
        periods => s.missed_periods as f64 * 1e6 / periods as f64,
    };
    let rows = [
        ("ticks", s.ticks.to_string()),
        (
            "periods missed",
            format!("{} ({per_million:.0} in a million)", s.missed_periods),
        ),
        ("ticks that ended late", s.late_ticks.to_string()),
        (
            "allocations of the tick's thread since its first tick",
            s.allocations_after_start
                .map_or("not counted".to_owned(), |n| n.to_string()),
        ),
        (
            "page faults of the tick's thread since its first tick",
            s.page_faults_after_start.to_string(),
        ),
        (
            "involuntary context switches of the tick's thread",
            s.involuntary_switches.to_string(),
        ),
        (
            "force on the hand, N",
            format!("{:.3} to {:.3}", s.force_n.min, s.force_n.max),
        ),
        ("pictures", s.frames.to_string()),
        ("timing records read", s.timing_records.to_string()),
        ("timing batches lost", s.timing_batches_lost.to_string()),
        ("events lost", s.events_lost.to_string()),
    ];
    for (name, value) in rows {
        page.add(format_args!("<tr><td>{name}<td>{value}</tr>"));
    }
    for (name, count) in &s.events {
        page.add(format_args!("<tr><td>event: {name}<td>{count}</tr>"));
    }
    for (name, count) in &s.faults {
        page.add(format_args!(
            "<tr><td>ticks with fault: {}<td>{count}</tr>",
            escape(name)
        ));
    }
    page.add(format_args!("</table>"));
}

fn pictures(page: &mut Page, outcome: &RunOutcome, folder: &Path) {
    let files: Vec<&Path> = outcome
        .frames
        .iter()
        .filter_map(|f| f.path.as_deref())
        .collect();
    if files.is_empty() {
        return;
    }
    page.add(format_args!("<h2>Pictures</h2><div class=\"frames\">"));
    for file in files {
        let name = file.strip_prefix(folder).unwrap_or(file).to_string_lossy();
        let name = escape(&name);
        page.add(format_args!(
            "<figure><img src=\"{name}\" alt=\"{name}\"><figcaption>{name}</figcaption></figure>"
        ));
    }
    page.add(format_args!("</div>"));
}

fn machine(page: &mut Page, s: &Summary) {
    let graphics = s.adapter.as_deref().unwrap_or("none");
    page.0 += &machine_table(&s.machine, &[("graphics", graphics)]);
}
