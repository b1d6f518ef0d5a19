//! What is told of every face, packed: its number of corners, and values that change rarely.

/// Corners of each face, in order.
pub(super) enum Faces {
    /// So many triangles.
    Triangles(u32),
    /// The numbers of corners.
    Mixed(Vec<u32>),
}

impl Faces {
    pub fn count(&self) -> u32 {
        match self {
            Faces::Triangles(count) => *count,
            Faces::Mixed(sizes) => sizes.len() as u32,
        }
    }

    pub fn size(&self, face: u32) -> u32 {
        match self {
            Faces::Triangles(_) => 3,
            Faces::Mixed(sizes) => sizes[face as usize],
        }
    }

    #[inline(always)]
    pub fn push(&mut self, size: u32) {
        match self {
            Faces::Triangles(count) if size == 3 => *count += 1,
            Faces::Triangles(count) => {
                let mut sizes = vec![3; *count as usize];
                sizes.push(size);
                *self = Faces::Mixed(sizes);
            }
            Faces::Mixed(sizes) => sizes.push(size),
        }
    }
}

/// A value for each face that changes rarely.
#[derive(Clone)]
pub(super) struct Runs<T> {
    pub current: T,
    pub runs: Vec<(u32, T)>,
}

impl<T: Clone + PartialEq> Runs<T> {
    pub fn new(first: T) -> Self {
        Self { current: first, runs: Vec::new() }
    }

    #[inline(always)]
    pub fn face(&mut self, face: u32) {
        if self.runs.last().is_none_or(|(_, last)| *last != self.current) {
            self.runs.push((face, self.current.clone()));
        }
    }

    /// Appends runs of faces that follow, the first of which is number `first`, with values of another kind.
    pub fn append<U>(&mut self, other: Runs<U>, first: u32, value: impl Fn(U) -> T) {
        for (face, run) in other.runs {
            self.current = value(run);
            self.face(first + face);
        }
        self.current = value(other.current);
    }

    /// The value of `face`, moving `run`, the number of the run of a face before it.
    pub fn at(&self, face: u32, run: &mut usize) -> &T {
        while self.runs.get(*run + 1).is_some_and(|(first, _)| *first <= face) {
            *run += 1;
        }
        &self.runs[*run].1
    }
}
