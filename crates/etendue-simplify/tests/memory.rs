//! How much memory simplification takes beside its input. Alone in its process, because the allocator counts for all threads.

// What is made is measured, never compared bit by bit with another machine's.
#![allow(clippy::disallowed_methods)]

mod shapes;

use etendue_simplify::{Options, Target, simplify};
use peak_alloc::PeakAlloc;
use shapes::{carry_on, torus};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

#[test]
fn bytes_per_face() {
    let mesh = torus(800, 400);
    let faces = mesh.faces.len();
    // 30 million faces have to fit into 8 GiB with their input: 286 bytes a face, of which the input takes 18.
    for (polish, most) in [(false, 200), (true, 260)] {
        let options = Options { polish, ..Options::new(Target::Ratio(0.01)) };
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let result = simplify(&mesh.as_ref(), &options, &mut carry_on).unwrap();
        let used = (ALLOCATOR.peak_usage() - before) / faces;
        println!("polish {polish}: {used} bytes a face of {faces}");
        assert!(used < most, "polish {polish}: {used} bytes a face");
        assert!(result.mesh.faces.len() <= faces / 100);
    }
}
