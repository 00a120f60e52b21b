//! Says in one sentence how a run went.

use figures::Quantiles;

use crate::report::Report;

/// The sentence. It begins with the verdict: on time, late, not realtime, or nothing measured.
pub fn sentence(report: &Report) -> String {
    let count = |name: &str| report.counts.get(name).copied().unwrap_or(0);
    let wake = report.times.get("wake_latency_ns");
    let wake = wake.map_or_else(Quantiles::default, figures::Distribution::quantiles);
    if wake.count == 0 {
        return "Nothing was measured.".to_owned();
    }
    let us = |ns: u64| match ns {
        0..10_000 => format!("{:.1} µs", ns as f64 / 1e3),
        10_000..10_000_000 => format!("{:.0} µs", ns as f64 / 1e3),
        _ => format!("{:.0} ms", ns as f64 / 1e6),
    };
    let missed = count("deadline_misses");
    let periods = count("ticks").saturating_add(missed);
    let verdict = match (report.about.realtime, missed) {
        (false, _) => "Not realtime",
        (true, 0) => "On time",
        (true, _) => "Late",
    };
    let misses = match missed {
        0 => format!("none of {periods} periods was missed"),
        _ => format!(
            "{missed} of {periods} periods were missed ({:.0} in a million)",
            report.misses_per_million()
        ),
    };
    let floor = report
        .ratios()
        .into_iter()
        .find(|it| it.program == "station");
    let floor = floor.map_or(String::new(), |it| {
        format!(", {:.2} times cyclictest's in the same minutes", it.p99)
    });
    let cause = report.causes.first().map_or(String::new(), |cause| {
        let lost: u64 = report.causes.iter().map(|it| it.lost_us).sum();
        let share = 100.0 * cause.lost_us as f64 / lost.max(1) as f64;
        let guess = match report.why.as_ref().is_some_and(|why| why.is_coarse) {
            true => ", at a guess,",
            false => "",
        };
        format!(
            "; late ticks lost{guess} {share:.0} % of their time to {} ({})",
            cause.what.name(),
            cause.name
        )
    });
    let resting = count("ticks_not_following") as f64 / count("ticks").max(1) as f64;
    let rested = match resting {
        ..0.01 => String::new(),
        _ => format!(
            " In at least {:.0} % of the ticks --follow-device rested, because the device's samples came too \
             irregularly.",
            100.0 * resting
        ),
    };
    format!(
        "{verdict}: {misses}, 99 % of the wake-ups came within {}{floor}, and the latest came after \
         {}{cause}.{rested}",
        us(wake.p99),
        us(wake.max)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;
    use crate::why::{Cause, Source, What};

    #[test]
    fn one_sentence_tells_verdict_misses_floor_and_cause() {
        let mut report = sample();
        let late = sentence(&report);
        assert!(
            late.starts_with("Late: 10 of 2000 periods were missed (5000 in a million), "),
            "{late}"
        );
        assert!(
            late.contains("within 198 µs, 1.20 times cyclictest's"),
            "{late}"
        );
        assert!(late.ends_with("the latest came after 200 µs."), "{late}");
        report.causes.push(Cause {
            what: What::Thread,
            name: "kworker/1:0".to_owned(),
            lost_us: 30,
            ticks: 1,
        });
        let because = sentence(&report);
        assert!(
            because.ends_with("lost 100 % of their time to thread (kworker/1:0)."),
            "{because}"
        );
        report.why = Some(Source {
            name: "counters".to_owned(),
            is_coarse: true,
            missing: "root".to_owned(),
            events: 0,
            lost_events: 0,
            late_ticks: 1,
        });
        assert!(sentence(&report).contains("late ticks lost, at a guess, 100 % of"));
        report.counts.insert("deadline_misses".to_owned(), 0);
        assert!(sentence(&report).starts_with("On time: none of 1990 periods was missed, "));
        assert!(!sentence(&report).contains("rested"));
        report.counts.insert("ticks_not_following".to_owned(), 995);
        assert!(
            sentence(&report).contains(". In at least 50 % of the ticks --follow-device rested, ")
        );
        report.about.realtime = false;
        assert!(sentence(&report).starts_with("Not realtime: "));
        report.times.clear();
        assert_eq!(sentence(&report), "Nothing was measured.");
    }
}
