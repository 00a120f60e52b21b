//! `evaluate force`: what a tool feels, over depth, against finite elements.

mod case;
mod reference;

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use case::Case;
use reference::{Curve, DEPTHS_MM};

/// Reference curves are solved by so many threads at once.
const THREADS: usize = 2;

/// Finds the reference of every case whose name contains `only`; kept in `folder`.
///
/// # Errors
/// In words.
fn references(
    cases: &[Case],
    folder: &Path,
    quick: bool,
) -> Result<Vec<Result<Curve, String>>, String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let next = AtomicUsize::new(0);
    let found: Vec<Mutex<Option<Result<Curve, String>>>> =
        cases.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(i) else { break };
                    eprintln!("reference {} of {}: {}", i + 1, cases.len(), case.name());
                    let curve = reference::curve(case, folder, quick);
                    if let Ok(mut slot) = found[i].lock() {
                        *slot = Some(curve);
                    }
                }
            });
        }
    });
    let take = |slot: Mutex<Option<_>>| {
        let inner = slot.into_inner().ok().flatten();
        inner.unwrap_or_else(|| Err("a reference's thread ended early".to_owned()))
    };
    Ok(found.into_iter().map(take).collect())
}

/// Everything; writes `force_depth.csv` into `out`.
///
/// # Errors
/// In words.
pub(crate) fn run(out: &Path, quick: bool, only: &str) -> Result<(), String> {
    let mut cases = Case::all();
    cases.retain(|case| case.name().contains(only));
    let curves = references(&cases, &out.join("reference"), quick)?;
    let mut text = "organ,site,tool,seen,nodes,depth_mm,reference_n,coarser_mesh_n\n".to_owned();
    for (case, curve) in cases.iter().zip(&curves) {
        let curve = match curve {
            Ok(curve) => curve,
            Err(why) => {
                eprintln!("  no reference: {why}");
                continue;
            }
        };
        for (i, (depth, force)) in DEPTHS_MM.iter().zip(&curve.force_n).enumerate() {
            let coarse = curve
                .coarse_n
                .get(i)
                .map_or_else(String::new, |f| format!("{f:.5}"));
            text += &format!(
                "{},{},\"{}\",{},{},{depth},{force:.5},{coarse}\n",
                case.site.subject.name(),
                case.site.name,
                case.tool.name(),
                case.site.seen,
                curve.nodes[1],
            );
        }
        eprintln!(
            "  {}: meshes differ by {:.1} %",
            case.name(),
            curve.doubt_pct()
        );
    }
    let path = out.join("force_depth.csv");
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
}
