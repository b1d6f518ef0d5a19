//! Tables made, and large arrays gone through, on several threads.

use glam::DVec3;
use std::{
    num::NonZero,
    ops::Range,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

/// More threads than this take longer to start than tables take to make.
const MOST_THREADS: usize = 16;

/// Elements of an array that a thread takes at once. Smaller arrays are not worth a second thread.
const PIECE: usize = 1 << 16;

fn threads(parts: usize) -> usize {
    thread::available_parallelism().map_or(1, NonZero::get).min(MOST_THREADS).min(parts)
}

/// `make(0)`, `make(1)`, ... `make(count - 1)`, in this order, found on all cores.
pub(crate) fn map<T: Send>(count: usize, make: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let threads = threads(count);
    let next = AtomicUsize::new(0);
    let worker = || -> Vec<(usize, T)> {
        let numbers =
            std::iter::from_fn(|| Some(next.fetch_add(1, Ordering::Relaxed)).filter(|number| *number < count));
        numbers.map(|number| (number, make(number))).collect()
    };
    let mut made = thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(worker)).collect();
        let mut made = worker();
        for other in others {
            match other.join() {
                Ok(other) => made.extend(other),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        made
    });
    made.sort_unstable_by_key(|(number, _)| *number);
    made.into_iter().map(|(_, value)| value).collect()
}

/// What `make` makes of each piece of so many elements, in order, found on all cores.
pub(crate) fn pieces<T: Send>(length: usize, make: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    map(length.div_ceil(PIECE), |piece| make(piece * PIECE..((piece + 1) * PIECE).min(length)))
}

/// `make(0)`, `make(1)`, ... `make(count - 1)` for rows of so many elements, in this order, found on all cores if they are many
/// together.
pub(crate) fn rows<T: Send>(count: usize, length: usize, make: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let together = (PIECE / 4).div_ceil(length.max(1));
    let group = |group: usize| -> Vec<T> { (group * together..count.min((group + 1) * together)).map(&make).collect() };
    map(count.div_ceil(together), group).into_iter().flatten().collect()
}

/// Whether something is true of any element.
pub(crate) fn any<T: Sync>(elements: &[T], is: impl Fn(&T) -> bool + Sync) -> bool {
    pieces(elements.len(), |range| elements[range].iter().any(&is)).contains(&true)
}

/// The least and the largest coordinates of what each element is at; infinite if there are none.
pub(crate) fn bounds<T: Sync>(elements: &[T], at: impl Fn(&T) -> DVec3 + Sync) -> [DVec3; 2] {
    let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let of_piece = |range: Range<usize>| {
        elements[range].iter().map(&at).fold(empty, |[low, high], point| [low.min(point), high.max(point)])
    };
    let join = |[low, high]: [DVec3; 2], [a, b]: [DVec3; 2]| [low.min(a), high.max(b)];
    pieces(elements.len(), of_piece).into_iter().fold(empty, join)
}

/// What `make` makes of each element of an array, put into `made`, an array of as many zeros that nobody shares yet.
pub(crate) fn shared<T: Sync, U: Send>(mut made: Arc<[U]>, elements: &[T], make: impl Fn(&T) -> U + Sync) -> Arc<[U]> {
    if let Some(all) = Arc::get_mut(&mut made) {
        let jobs = Mutex::new(all.chunks_mut(PIECE).zip(elements.chunks(PIECE)));
        let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
        let worker = |_| {
            while let Some((to, from)) = next() {
                to.iter_mut().zip(from).for_each(|(to, from)| *to = make(from));
            }
        };
        map(threads(elements.len().div_ceil(PIECE)), worker);
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_accel::zeroed_shared;

    #[test]
    fn results_come_in_order() {
        for count in [0, 1, 2, 1000] {
            let squares: Vec<usize> = (0..count).map(|i| i * i).collect();
            assert_eq!(map(count, |i| i * i), squares);
            assert!([0, 1, 500, usize::MAX].into_iter().all(|length| rows(count, length, |i| i * i) == squares));
        }
    }
    /// Of lengths about the pieces' borders.
    #[test]
    fn arrays_are_gone_through_to_their_ends() {
        for length in [0, 1, PIECE - 1, PIECE, PIECE + 1, 5 * PIECE + 7] {
            let numbers: Vec<u32> = (0..length as u32).collect();
            let made = shared(zeroed_shared(length), &numbers, |&n| [n, n + 1]);
            assert!(made.len() == length && (0..).zip(&*made).all(|(n, made)| *made == [n, n + 1]));
            let covered: Vec<usize> = pieces(length, |range| range).into_iter().flatten().collect();
            assert!(covered.into_iter().eq(0..length));
            for searched in [0, length / 2, length.saturating_sub(1), length] {
                assert_eq!(any(&numbers, |&n| n == searched as u32), searched < length);
            }
            let [low, high] = bounds(&numbers, |&n| DVec3::new(f64::from(n), 1.0, -f64::from(n)));
            let last = length as f64 - 1.0;
            let expected = [DVec3::new(0.0, 1.0, -last), DVec3::new(last, 1.0, 0.0)];
            assert!(length == 0 && low.x > high.x || [low, high] == expected);
        }
    }
}
