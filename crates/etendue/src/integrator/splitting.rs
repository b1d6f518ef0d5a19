//! Splitting: a sample's path goes on in several parts from its first vertex that scatters into more than single directions.
//!
//! The way from the camera to that vertex costs as much as any of the rays that follow, but often adds next to nothing to the error:
//! so several parts share it, each with a light sample and a way on of its own.

use super::{paths::Paths, wave::Context};

/// Most parts of a sample.
pub const MAX_PARTS: u32 = 16;

/// Into how many parts a sample is split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Splitting {
    /// From 1 to [`MAX_PARTS`].
    pub parts: u32,
    /// The parts draw from point sets of their own, and are as good as independent of each other. Else the parts of consecutive samples
    /// share one set, as so many consecutive samples would.
    pub apart: bool,
}

/// Calls `push` with all paths that path `path` becomes at a vertex with continuous lobes: with itself alone unless it is to be split
/// there.
#[inline]
pub(super) fn each_part(context: &Context, paths: &mut Paths, path: usize, mut push: impl FnMut(&mut Paths, usize)) {
    let Splitting { parts, apart } = context.splitting;
    if parts == 1 || !paths.progress[path].is_whole {
        return push(paths, path);
    }
    paths.split(path, parts);
    let key = paths.samples[path].key.split_off();
    // The path itself comes last: `push` may take it on, and the others begin like it.
    for part in (0..parts).rev() {
        let at = if part == 0 { path } else { paths.branch(path) };
        let id = &mut paths.samples[at];
        id.key = if apart { key.apart(part) } else { key.part(part, parts) };
        id.part = part;
        push(paths, at);
    }
}
