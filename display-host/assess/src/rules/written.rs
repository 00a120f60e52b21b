//! Content of a rules file before it is checked. The module `check` makes the checked rules from
//! it. Their types in `limits`, `weights`, `injury` and `published` document the values.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) version: Spanned<u32>,
    pub(super) alarm: Alarm,
    pub(super) done: Done,
    /// `None` in older files: no view has to be shown.
    pub(super) view: Option<View>,
    /// `None` in older files: the built-in rule applies.
    pub(super) show: Option<Show>,
    #[serde(default)]
    pub(super) flow_ml_min: BTreeMap<Spanned<String>, Spanned<f64>>,
    /// `None` in older files: the built-in rules apply.
    pub(super) injury: Option<Vec<Injury>>,
    #[serde(default)]
    pub(super) penalty: Vec<Penalty>,
    /// Additional pass rules for an exam. `None` in older files.
    pub(super) exam: Option<Exam>,
    #[serde(default)]
    pub(super) task: BTreeMap<Spanned<String>, Task>,
    #[serde(default)]
    pub(super) reference: Vec<Reference>,
    /// Texts in other languages: the language's code, the text of this file, and its translation.
    #[serde(default)]
    pub(super) translation: BTreeMap<String, BTreeMap<String, String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Alarm {
    pub(super) touch: Vec<Spanned<String>>,
    pub(super) burn: Vec<Spanned<String>>,
    pub(super) quiet_s: Spanned<f64>,
    /// `None` in older files: any heat counts.
    pub(super) burn_j: Option<Spanned<f64>>,
    /// `None` in older files: any touch counts.
    pub(super) touch_n: Option<Spanned<f64>>,
    /// Empty in older files: no press on another structure counts.
    #[serde(default)]
    pub(super) press_n: BTreeMap<Spanned<String>, Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Done {
    pub(super) triangle: Spanned<f64>,
    pub(super) lower_bed: Spanned<f64>,
    pub(super) bed: Spanned<f64>,
    pub(super) clips: Spanned<u32>,
    pub(super) settle_s: Spanned<f64>,
    pub(super) leak: Spanned<f64>,
    pub(super) look_s: Spanned<f64>,
    /// `None` in older files: a task ends with its last step.
    pub(super) collect_s: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct View {
    pub(super) hold_s: Spanned<f64>,
    pub(super) side_deg: Spanned<f64>,
    pub(super) front: Least,
    pub(super) behind: Least,
    pub(super) sway_mm_s: Spanned<f64>,
    pub(super) tilt_deg: Spanned<f64>,
    pub(super) source: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Least {
    pub(super) triangle: Spanned<f64>,
    pub(super) lower_bed: Spanned<f64>,
    pub(super) two: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Show {
    pub(super) visible: Spanned<f64>,
    pub(super) large: Spanned<f64>,
    pub(super) small: Spanned<f64>,
    pub(super) off: Spanned<f64>,
    pub(super) sway_mm_s: Spanned<f64>,
    pub(super) tilt_deg: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Injury {
    pub(super) organ: Spanned<String>,
    pub(super) open: Spanned<String>,
    pub(super) burn_j: Option<Spanned<f64>>,
    /// `None` in older files: only the heat counts (`burn_j`).
    pub(super) burn_mm: Option<Spanned<f64>>,
    pub(super) source: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Penalty {
    pub(super) metric: Spanned<String>,
    pub(super) free: Option<Spanned<f64>>,
    pub(super) each: Spanned<f64>,
    pub(super) most: Spanned<f64>,
    pub(super) source: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Task {
    pub(super) time_max_s: Option<Spanned<f64>>,
    pub(super) time_source: Option<String>,
    pub(super) pass: Vec<Condition>,
    pub(super) penalty: Option<Vec<Penalty>>,
    /// Empty in older files: the task forbids to burn what `[alarm]` names, and no more.
    #[serde(default)]
    pub(super) burn: Vec<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Exam {
    pub(super) pass: Vec<Condition>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Condition {
    pub(super) metric: Spanned<String>,
    pub(super) at_least: Option<Spanned<f64>>,
    pub(super) at_most: Option<Spanned<f64>>,
    pub(super) source: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Reference {
    pub(super) task: Spanned<String>,
    pub(super) metric: Spanned<String>,
    pub(super) value: Spanned<f64>,
    pub(super) who: String,
    pub(super) source: String,
}
