//! The threads that structures are built on. They are kept for the process: starting some takes as long as building the tree of a
//! small mesh, and a film builds one for each frame.

use std::num::NonZero;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::BuildError;

/// Those that were used last. They sleep while nothing is built.
static KEPT: Mutex<Option<Arc<ThreadPool>>> = Mutex::new(None);

/// Does work on so many threads (0: as many as there are processors).
pub(crate) fn on<R: Send>(
    threads: usize,
    work: impl FnOnce() -> Result<R, BuildError> + Send,
) -> Result<R, BuildError> {
    pool(threads)?.install(work)
}

/// The threads that are kept, if they are as many, or new ones to keep in their place.
fn pool(threads: usize) -> Result<Arc<ThreadPool>, BuildError> {
    let threads = if threads == 0 { thread::available_parallelism().map_or(1, NonZero::get) } else { threads };
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = kept.as_ref().filter(|pool| pool.current_num_threads() == threads) {
        return Ok(pool.clone());
    }
    let started = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|index| format!("build-{index}"))
        .build()
        .map_err(|error| BuildError::Threads { threads, reason: error.to_string() })?;
    Ok(kept.insert(Arc::new(started)).clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_done_on_as_many_threads_as_asked_for() {
        for threads in [2, 2, 1, 5, 1] {
            let count = on(threads, || Ok(rayon::current_num_threads())).unwrap();
            assert_eq!(count, threads);
        }
        assert!(on(0, || Ok(rayon::current_num_threads())).unwrap() > 0);
        assert_eq!(on(3, || on(2, || Ok(rayon::current_num_threads()))).unwrap(), 2);
        let failed = BuildError::Places { places: 1, instances: 2 };
        assert_eq!(on(2, || Err::<(), _>(failed.clone())), Err(failed));
    }
}
