//! What the system should know about large arrays.

/// The size of a huge page on most machines.
#[cfg(target_os = "linux")]
const HUGE_PAGE: usize = 2 << 20;

/// Asks for huge pages under the room that a vector has left, best before it is filled: fewer translations of addresses
/// are missed where rays go everywhere.
pub(crate) fn ask_for_huge_pages<T>(vector: &mut Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        let room = vector.spare_capacity_mut();
        let (start, end) = (room.as_mut_ptr().addr(), room.as_mut_ptr_range().end.addr());
        let (first, last) = (start.next_multiple_of(HUGE_PAGE), end - end % HUGE_PAGE);
        if first < last {
            let place = room.as_mut_ptr().wrapping_byte_add(first - start).cast();
            // SAFETY: the range lies within memory that the vector owns; the advice changes no content. Failure is no harm.
            let _ = unsafe { rustix::mm::madvise(place, last - first, rustix::mm::Advice::LinuxHugepage) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = vector;
}
