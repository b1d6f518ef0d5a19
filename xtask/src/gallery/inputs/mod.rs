//! What the scenes of the gallery need and the project makes itself.

mod balloons;
mod block;
mod bowl;
mod canvas;
mod curve;
mod dragon;
mod gate;
mod hand;
mod jigsaw;
mod mesh;
mod painting;
mod paper;
mod polygonise;
mod random;
mod shapes;
mod solids;

pub use canvas::Canvas;
pub use random::{Random, noise};

/// What the scenes scale the dragon's file by, as they write it.
pub const DRAGON_SCALE: &str = "0.00009375";

/// The compressed PLY file of a dragon of about so many faces.
pub fn dragon(faces: usize) -> Vec<u8> {
    dragon::mesh(faces).ply_gz(dragon::QUANTUM)
}

/// An input: its place from `gallery/inputs`, and what makes its bytes.
pub struct Input {
    pub name: &'static str,
    pub make: fn() -> Vec<u8>,
}

/// All of them.
pub const INPUTS: &[Input] = &[
    Input { name: "paper.png", make: paper::png },
    Input { name: "balloons.png", make: balloons::png },
    Input { name: "jigsaw.png", make: jigsaw::png },
    Input { name: "painting.png", make: painting::png },
    Input { name: "dragon.ply.gz", make: || dragon(dragon::FACES) },
    Input { name: "gate.ply.gz", make: gate::ply_gz },
    Input { name: "block.ply.gz", make: block::ply_gz },
    Input { name: "bowl.ply.gz", make: bowl::bowl_ply_gz },
    Input { name: "gem.ply.gz", make: bowl::gem_ply_gz },
    Input { name: "ring.ply.gz", make: bowl::ring_ply_gz },
    // A scene with some hundreds of bodies, beside the others.
    Input { name: "../bowl.toml", make: bowl::scene },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root;
    use std::fs;

    #[test]
    fn making_inputs_again_changes_nothing() {
        // The dragon takes longest; its parts are tested beside it.
        for input in INPUTS.iter().filter(|input| input.name != "dragon.ply.gz") {
            let kept = fs::read(root().join("gallery/inputs").join(input.name)).unwrap();
            assert!((input.make)() == kept, "{}: run `cargo xtask gallery inputs`", input.name);
        }
    }

    #[test]
    fn inputs_are_small() {
        let sizes: Vec<u64> = INPUTS
            .iter()
            .map(|input| fs::metadata(root().join("gallery/inputs").join(input.name)).unwrap().len())
            .collect();
        assert!(sizes.iter().sum::<u64>() < 4 << 20 && sizes.iter().all(|size| *size < 600 << 10), "{sizes:?}");
    }
}
