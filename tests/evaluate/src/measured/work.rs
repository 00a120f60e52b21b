//! Distributes jobs to threads.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::Builder;

use crate::STACK_BYTES;

/// Does `work` for every job, on as many threads as the machine runs in parallel. The results have
/// the order of the jobs.
///
/// # Errors
/// The first job's error.
pub(super) fn all<J: Sync, R: Send>(
    jobs: &[J],
    work: impl Fn(&J) -> Result<R, String> + Sync,
) -> Result<Vec<R>, String> {
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let take = || {
        let mut done = Vec::new();
        while let Some((index, job)) = {
            let index = next.fetch_add(1, Ordering::Relaxed);
            jobs.get(index).map(|job| (index, job))
        } {
            done.push((index, work(job)));
        }
        done
    };
    let mut found = std::thread::scope(|scope| {
        let start = |_| {
            let thread = Builder::new().stack_size(STACK_BYTES);
            thread.spawn_scoped(scope, take).map_err(|e| e.to_string())
        };
        let workers: Vec<_> = (0..threads).map(start).collect::<Result<_, String>>()?;
        let mut found = Vec::new();
        for worker in workers {
            found.extend(worker.join().map_err(|_| "a thread panicked".to_owned())?);
        }
        Ok::<_, String>(found)
    })?;
    found.sort_by_key(|(index, _)| *index);
    found.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn results_keep_the_order_of_the_jobs_and_an_error_is_told() {
        let jobs: Vec<u32> = (0..50).collect();
        let twice = super::all(&jobs, |n| Ok(2 * n)).unwrap();
        assert_eq!(twice, (0..50).map(|n| 2 * n).collect::<Vec<_>>());
        let fails = |n: &u32| match *n {
            7 => Err("seven".to_owned()),
            n => Ok(n),
        };
        assert_eq!(super::all(&jobs, fails).unwrap_err(), "seven");
    }
}
