//! Large arrays that several threads fill and others share.

use bytemuck::Zeroable;
use std::sync::Arc;

/// An array of zeros, to be filled before it is shared. A large one costs nothing yet: the system makes its pages when they are
/// first touched, on the thread that touches them.
pub fn zeroed_shared<T: Zeroable>(length: usize) -> Arc<[T]> {
    let zeros = Arc::<[T]>::new_zeroed_slice(length);
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
