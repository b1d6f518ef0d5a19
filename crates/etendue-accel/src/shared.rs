//! Large arrays that several threads fill and others share.

use bytemuck::Zeroable;
use std::sync::Arc;

/// The size of a huge page on most machines.
#[cfg(target_os = "linux")]
const HUGE_PAGE: usize = 2 << 20;

/// An array of zeros, to be filled before it is shared. A large one costs nothing yet: the system makes its pages when they are
/// first touched, on the thread that touches them, and is asked for huge ones, of which it has to make fewer.
pub fn zeroed_shared<T: Zeroable>(length: usize) -> Arc<[T]> {
    let mut zeros = Arc::<[T]>::new_zeroed_slice(length);
    #[cfg(target_os = "linux")]
    if let Some(room) = Arc::get_mut(&mut zeros) {
        let range = room.as_mut_ptr_range();
        let (start, end) = (range.start.addr(), range.end.addr());
        let (first, last) = (start.next_multiple_of(HUGE_PAGE), end - end % HUGE_PAGE);
        if first < last {
            let place = range.start.wrapping_byte_add(first - start).cast();
            // SAFETY: the range lies within the array, which nothing else uses; the advice changes no content, and its
            // failure is no harm.
            let _ = unsafe { rustix::mm::madvise(place, last - first, rustix::mm::Advice::LinuxHugepage) };
        }
    }
    // SAFETY: every byte is zero, which is a value of any `Zeroable` type.
    unsafe { zeros.assume_init() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_zeros_and_nobody_elses() {
        for length in [0, 1, 3, 1 << 20] {
            let mut array = zeroed_shared::<[u32; 3]>(length);
            assert!(array.len() == length && array.iter().all(|v| *v == [0; 3]));
            assert!(Arc::get_mut(&mut array).is_some());
        }
    }
}
