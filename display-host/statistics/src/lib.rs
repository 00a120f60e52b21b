//! Statistics of studies: pure functions of numbers. They know no trainee and no metric.
//!
//! ```text
//! compare     two groups: medians, quartiles, Mann and Whitney, effect size; Holm's correction
//! learning    one person's course from session to session: plateau and rate
//! agreement   raters and items: ICC(2,1), Cronbach's alpha
//! ```

mod agreement;
mod compare;
mod learning;

pub use agreement::{Agreement, cronbach_alpha, icc};
pub use compare::{Compared, compare, holm, median, quantile};
pub use learning::{Learning, learning};
