//! Work in many parts, on threads of its own.

use std::{
    num::NonZero,
    sync::{
        Mutex, MutexGuard,
        atomic::{AtomicBool, Ordering},
    },
    thread,
};

/// More threads would only wait for memory.
const MOST_THREADS: usize = 16;

/// How many threads take part in work of so many parts.
pub(crate) fn threads(parts: usize) -> usize {
    thread::available_parallelism().map_or(1, NonZero::get).min(MOST_THREADS).min(parts).max(1)
}

/// Hands the jobs out in order to so many threads, this one among them; each has a state of its own. Returns the states, in no
/// order that means anything.
///
/// # Errors
/// One of those that `work` returned; no job is begun after it.
pub(crate) fn run<J: Send, S: Send, E: Send>(
    threads: usize,
    jobs: impl Iterator<Item = J> + Send,
    state: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, J) -> Result<(), E> + Sync,
) -> Result<Vec<S>, E> {
    let jobs = Mutex::new(jobs);
    let stopped = AtomicBool::new(false);
    let worker = || {
        let mut own = state();
        while !stopped.load(Ordering::Relaxed) {
            let Some(job) = lock(&jobs).next() else { break };
            if let Err(error) = work(&mut own, job) {
                stopped.store(true, Ordering::Relaxed);
                return Err(error);
            }
        }
        Ok(own)
    };
    thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(worker)).collect();
        let first = worker();
        let others = others.into_iter().map(|other| match other.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        // All are joined before an error is passed on.
        let others: Vec<_> = others.collect();
        std::iter::once(first).chain(others).collect()
    })
}

/// Calls both at once.
pub(crate) fn both<A, B: Send>(a: impl FnOnce() -> A, b: impl FnOnce() -> B + Send) -> (A, B) {
    thread::scope(|scope| {
        let other = scope.spawn(b);
        let a = a();
        match other.join() {
            Ok(b) => (a, b),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Without a second panic if another thread had one, which the join passes on.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_is_done_once() {
        for threads in [1, 2, 5] {
            let mut done = vec![0u32; 1000];
            let jobs = done.iter_mut().enumerate();
            let sums = run(
                threads,
                jobs,
                || 0,
                |sum, (number, slot)| {
                    *slot += 1;
                    *sum += number;
                    Ok::<_, ()>(())
                },
            );
            assert_eq!(sums.unwrap().into_iter().sum::<usize>(), 999 * 1000 / 2);
            assert!(done.iter().all(|&count| count == 1));
        }
    }

    #[test]
    fn an_error_ends_the_work() {
        for threads in [1, 3] {
            let begun = Mutex::new(vec![]);
            let result = run(
                threads,
                0..1_000_000,
                || (),
                |(), job| {
                    lock(&begun).push(job);
                    if job == 10 { Err(job) } else { Ok(()) }
                },
            );
            assert_eq!(result, Err(10));
            assert!(begun.into_inner().unwrap().len() < 500_000);
        }
    }
}
