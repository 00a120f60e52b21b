//! Choice of the number of spheres: few that keep an error budget, or many that keep a time budget.

use shared_mem::scene::SceneError;

use crate::error::PrepareError;
use crate::held::Plane;
use crate::mesh::Mended;
use crate::pack::Quality;
use crate::prepared::Prepared;
use crate::recipe::{OrganPlan, Packing, Recipe, SPHERES_MAX, SPHERES_MIN};
use crate::skeleton::{interior, skeleton};

/// Number of an organ's spheres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Count {
    pub(crate) spheres: usize,
    /// Reason for this number, in words.
    pub(crate) because: String,
    /// True if a time budget must not change the number: an error budget chose it, or the organ is
    /// a tube, which always has few spheres.
    pub(crate) is_fixed: bool,
}

/// Largest number of packings that the search for an error budget's count tries.
const TRIES: usize = 6;

/// Finds the smallest of the tried counts whose gap keeps the error budget. Estimates the next
/// count to try: the gap is about proportional to the spacing of the spheres, and the spacing to
/// the inverse cube root of the count. Without an error budget, returns the recipe's count.
///
/// # Errors
/// When no tried count keeps the budget.
pub(crate) fn by_error(
    plan: &OrganPlan,
    surface: &Mended,
    planes: &[Plane],
) -> Result<Count, PrepareError> {
    let Some(budget_m) = plan.gap_95_m else {
        return Ok(Count {
            spheres: plan.spheres,
            because: "the recipe says so".into(),
            is_fixed: plan.packing == Packing::Line,
        });
    };
    let mut kept: Option<(usize, f64)> = None;
    let mut missed: Option<(usize, f64)> = None;
    let mut count = plan.spheres;
    for _ in 0..TRIES {
        let interior = interior(plan, surface, count)?;
        let balls = skeleton(plan, &interior, surface.volume_m3, count, planes).balls;
        let gap_m = Quality::measure(&interior, &surface.mesh, &balls).gap_95_m;
        let side = if gap_m <= budget_m {
            &mut kept
        } else {
            &mut missed
        };
        let closer = side.is_none_or(|(known, _)| (count < known) == (gap_m <= budget_m));
        if closer {
            *side = Some((count, gap_m));
        }
        let estimate = count as f64 * (gap_m / budget_m).powi(3) * 1.02;
        let next = (estimate.ceil() as usize).clamp(SPHERES_MIN, SPHERES_MAX);
        count = match (kept, missed) {
            (Some((high, _)), Some((low, _))) if high <= low + 1 + low / 50 => break,
            (Some((high, _)), Some((low, _))) if next <= low || next >= high => (low + high) / 2,
            _ if next == count => break,
            _ => next,
        };
    }
    let mm = |m: f64| 1e3 * m;
    let Some((count, gap_m)) = kept else {
        let (count, gap_m) = missed.unwrap_or((plan.spheres, f64::NAN));
        return Err(PrepareError::Organ {
            organ: plan.name.clone(),
            problem: format!(
                "cannot keep gap_95_mm = {:.2}: {count} spheres still leave {:.2} mm; give the organ a \
                 larger gap_95_mm",
                mm(budget_m),
                mm(gap_m)
            ),
        });
    };
    let fewer = missed.map_or(String::new(), |(count, gap_m)| {
        format!("; {count} leave {:.2} mm", mm(gap_m))
    });
    let because = format!(
        "a 95 % gap of {:.2} mm keeps the budget of {:.2} mm{fewer}",
        mm(gap_m),
        mm(budget_m)
    );
    Ok(Count {
        spheres: count,
        because,
        is_fixed: true,
    })
}

/// Largest number of scenes that the search for a time budget tries. Each has another share of the
/// recipe's counts.
const TIME_TRIES: usize = 8;
/// The search ends when the predicted tick keeps the budget and takes at least this share of it.
const USED: f64 = 0.95;

/// Finds a number of spheres whose predicted tick keeps the budget and nearly uses it up
/// ([`USED`]). The organs share the spheres in the proportions of the recipe's counts.
///
/// # Errors
/// When no scene tried keeps the budget, and all errors of `assemble`.
pub(crate) fn by_time(
    recipe: &Recipe,
    budget_us: f64,
    counts: &[Count],
    assemble: &mut dyn FnMut(&[Count]) -> Result<Prepared, PrepareError>,
) -> Result<Prepared, PrepareError> {
    let free: usize = free(counts).sum();
    let fixed = counts.iter().map(|count| count.spheres).sum::<usize>() - free;
    let largest = SPHERES_MAX.saturating_sub(fixed) as f64 / free.max(1) as f64;
    let mut kept: Option<(f64, Prepared)> = None;
    // The last share that missed the budget or a capacity, and this result in words.
    let mut missed: Option<(f64, String)> = None;
    let mut fewest_us = f64::INFINITY;
    let mut share = f64::min(1.0, largest);
    let mut tried: Vec<Vec<usize>> = Vec::new();
    for _ in 0..TIME_TRIES {
        let scaled = scale(counts, share);
        let total = scaled.iter().map(|count| count.spheres).sum::<usize>();
        let these: Vec<usize> = scaled.iter().map(|count| count.spheres).collect();
        if tried.contains(&these) {
            break;
        }
        tried.push(these);
        let ratio = match assemble(&scaled) {
            Ok(prepared) => {
                let tick_us = prepared.report.tick_us;
                fewest_us = fewest_us.min(tick_us);
                if tick_us <= budget_us {
                    kept = Some((share, prepared));
                } else {
                    missed = Some((share, format!("{total} would need {tick_us:.0} µs")));
                }
                tick_us / budget_us
            }
            // The scene exceeds a capacity of the realtime process.
            Err(PrepareError::Scene(error @ SceneError::Count { .. })) => {
                missed = Some((share, format!("with {total}, the {error}")));
                1.25
            }
            Err(error) => return Err(error),
        };
        if (USED..=1.0).contains(&ratio) {
            break;
        }
        // The factor 0.98 makes it likely that the next tick keeps the budget.
        let guess = (0.98 * share / ratio).min(largest);
        share = match (&kept, &missed) {
            (Some((low, _)), Some((high, _))) if guess <= *low || guess >= *high => {
                (low + high) / 2.0
            }
            _ => guess,
        };
    }
    let Some((_, mut prepared)) = kept else {
        let problem = match missed {
            Some((_, missed)) if fewest_us.is_infinite() => missed,
            _ => format!("even the fewest spheres tried need {fewest_us:.0} µs"),
        };
        return Err(PrepareError::Organ {
            organ: recipe.name.clone(),
            problem: format!(
                "cannot keep tick_us = {budget_us}: {problem}; allow more time, or leave organs out"
            ),
        });
    };
    let report = &mut prepared.report;
    let more = missed.map_or(String::new(), |(_, missed)| format!("; {missed}"));
    let why = format!(
        "its share of the {} that a tick of {:.0} µs takes, of {budget_us} µs allowed{more}",
        report.spheres, report.tick_us
    );
    for (organ, count) in report.organs.iter_mut().zip(counts) {
        if !count.is_fixed {
            organ.spheres_because.clone_from(&why);
        }
    }
    Ok(prepared)
}

fn free(counts: &[Count]) -> impl Iterator<Item = usize> {
    let free = counts.iter().filter(|count| !count.is_fixed);
    free.map(|count| count.spheres)
}

fn scale(counts: &[Count], share: f64) -> Vec<Count> {
    let scaled = |count: &Count| Count {
        spheres: match count.is_fixed {
            true => count.spheres,
            false => ((count.spheres as f64 * share) as usize).max(SPHERES_MIN),
        },
        ..count.clone()
    };
    counts.iter().map(scaled).collect()
}
