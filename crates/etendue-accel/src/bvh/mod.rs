//! The 8-wide bounding volume hierarchy.

mod alone;
pub(crate) mod beam;
mod bins;
mod build;
mod collapse;
mod divide;
mod large;
pub(crate) mod node;
mod packets;
mod pieces;
mod ready;
mod refit;
mod rounds;
mod traverse;

use crate::bounds::Bounds;
use crate::error::BuildError;
use crate::flat::Flat;
use crate::geometry::World;
use crate::isa::Isa;
use crate::items::{self, Item};
use crate::levels;
use crate::padding::Padding;
use crate::simd::STACK_ROOM;
use crate::source::Source;

pub(crate) use alone::few;
use collapse::{Arrays, Lengths, Level, Root};
use large::Large;
use node::{Node, Pack};
pub(crate) use traverse::Trace;

/// A level over the world and one for each geometry that transformed instances use.
#[derive(Debug)]
pub(crate) struct Bvh {
    arrays: Arrays,
    top: Root,
    /// By geometry.
    objects: Vec<Option<Root>>,
    /// Where the top begins in the arrays.
    top_start: Lengths,
    /// The area of the top's boxes when it was built, if there are instances.
    built_area: f64,
    /// Words that a stack must have room for.
    stack_len: usize,
    /// Whether the structure fits into a cache.
    cached: bool,
    /// What the top has apart.
    large: Option<Large>,
    isa: Isa,
}

impl Bvh {
    /// For rays on an instruction set.
    pub fn build(world: &World, isa: Isa) -> Result<Self, BuildError> {
        let mut arrays = Arrays::default();
        let bounds = items::object_bounds(world);
        let prepare = |items, source, padding| Level::new(items, source, padding, 0, isa);
        let objects = levels::objects(world, &bounds, prepare, |level| arrays.append(level, false, isa))?;
        let top_start = arrays.lengths();
        let padding = Padding::new(&Bounds::EMPTY, []);
        let top = Root { word: None, bounds: Bounds::EMPTY, padding, depth: 0, others: None };
        let (built_area, stack_len, cached, large) = (0.0, 0, false, None);
        let mut bvh = Self { arrays, top, objects, top_start, built_area, stack_len, cached, large, isa };
        let (items, padding) = levels::top(world, &bounds)?;
        bvh.add_top(items, world, padding)?;
        Ok(bvh)
    }

    /// Builds the top behind the other levels.
    fn add_top(&mut self, mut items: Vec<Item>, world: &World, padding: Padding) -> Result<(), BuildError> {
        let apart = large::choose(&mut items, world, self.isa);
        let apart = if apart < items.len() { apart } else { 0 };
        let flat = (apart > 0).then(|| Flat::of_triangles(world, &items[..apart])).transpose()?;
        let top = Level::new(items, Source::Top(world), padding, apart, self.isa)?;
        self.top = self.arrays.append(top, true, self.isa)?;
        self.large = flat.map(|flat| Large { flat, boxes: self.boxes_of_others() });
        // Each node on the way replaces one entry by at most eight; a level has one at its bottom; vectors are stored whole.
        self.stack_len = (node::WIDTH - 1) * self.depth() + 3 + STACK_ROOM;
        self.cached = self.arrays.bytes() <= traverse::CACHED_BYTES;
        self.built_area = if self.arrays.instances.is_empty() { 0.0 } else { self.top_area() };
        Ok(())
    }

    /// The boxes of the geometries that have a level.
    fn object_bounds(&self) -> Vec<Option<Bounds>> {
        self.objects.iter().map(|root| root.as_ref().map(|root| root.bounds)).collect()
    }

    pub fn bounds(&self) -> Bounds {
        self.top.bounds
    }

    pub fn nodes(&self) -> usize {
        self.arrays.nodes.len()
    }

    pub fn bytes(&self) -> usize {
        self.arrays.bytes() + self.large.as_ref().map_or(0, |large| large.flat.bytes())
    }

    /// Child word of the top level, `None` if there is nothing.
    pub fn root(&self) -> Option<u32> {
        self.top.word
    }

    /// Entries that a traversal's stack may need.
    pub fn stack_len(&self) -> usize {
        self.stack_len
    }

    #[inline(always)]
    pub fn node(&self, index: u32) -> &Node {
        &self.arrays.nodes[index as usize]
    }

    #[inline(always)]
    pub fn packs(&self, first: u32, count: u32) -> &[Pack] {
        &self.arrays.packs[first as usize..(first + count) as usize]
    }

    pub fn depth(&self) -> usize {
        self.top.depth + self.objects.iter().flatten().map(|root| root.depth).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Geometry, Instance, Place, Transform, TriangleMesh};

    /// Triangles of a size at random places in a unit cube.
    fn scattered(count: u32, size: f32) -> World {
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut positions: Vec<[f32; 3]> = Vec::new();
        for _ in 0..count {
            let place = [random(), random(), random()].map(|x| (1.0 - size) * x);
            positions.extend((0..3).map(|_| place.map(|x| x + size * random())));
        }
        let indices: Vec<[u32; 3]> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh { positions: positions.into(), indices: indices.into() };
        let placed = Instance { geometry: 0, place: Place::Fixed(Transform::IDENTITY), mask: 1 };
        let instances = vec![Instance { geometry: 0, place: Place::World, mask: 3 }, placed];
        World { geometries: vec![Geometry::Triangles(mesh)], instances }
    }

    /// Large enough for parallel bins and parallel halves, and cut in pieces.
    #[test]
    fn threads_and_instruction_sets_leave_no_trace() {
        let world = scattered(100_000, 1.0);
        let bytes = |threads: usize, isa: Isa| -> Vec<u8> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let bvh = pool.install(|| Bvh::build(&world, isa)).unwrap();
            let collapse::Owners::Each { lanes, .. } = &bvh.arrays.owners else { panic!("there are two instances") };
            let (nodes, packs) = (bytemuck::cast_slice(&bvh.arrays.nodes), bytemuck::cast_slice(&bvh.arrays.packs));
            [nodes, packs, bytemuck::cast_slice(lanes)].concat()
        };
        let one = bytes(1, Isa::Portable);
        assert!(one == bytes(2, Isa::Portable) && one == bytes(5, Isa::Portable));
        assert!(Isa::available().into_iter().all(|isa| one == bytes(3, isa)));
    }

    /// So many geometries, each placed by a transform.
    fn shared(sizes: impl Iterator<Item = u32>) -> World {
        let geometries: Vec<Geometry> = sizes.map(|size| scattered(size, 0.01).geometries.remove(0)).collect();
        let place = Place::Fixed(Transform::IDENTITY);
        let instances =
            (0..geometries.len() as u32).map(|geometry| Instance { geometry, place: place.clone(), mask: 1 });
        World { instances: instances.collect(), geometries }
    }

    /// More than are built side by side, some empty.
    #[test]
    fn geometries_built_side_by_side_stay_in_their_order() {
        let sizes = [40, 70_000, 0, 3, 90_000, 120_000, 1, 9000, 0];
        let world = shared(sizes.into_iter());
        let built = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Bvh::build(&world, Isa::detect())).unwrap()
        };
        let (one, many) = (built(1), built(5));
        assert!(bytemuck::cast_slice::<_, u8>(&one.arrays.nodes) == bytemuck::cast_slice::<_, u8>(&many.arrays.nodes));
        assert!(bytemuck::cast_slice::<_, u8>(&one.arrays.packs) == bytemuck::cast_slice::<_, u8>(&many.arrays.packs));
        let mut pack = 0;
        for (size, object) in sizes.into_iter().zip(&one.objects) {
            let object = object.unwrap();
            assert_eq!(object.word.is_none(), size == 0);
            let mut seen = 0;
            let mut pending: Vec<u32> = object.word.into_iter().collect();
            while let Some(word) = pending.pop() {
                match node::Child::of(word) {
                    node::Child::Node(index) => pending.extend(one.arrays.nodes[index as usize].used().map(|c| c.1)),
                    node::Child::Packs { first, count } => {
                        assert!(first >= pack);
                        let packs = &one.arrays.packs[first as usize..(first + count) as usize];
                        seen += packs.iter().flat_map(|p| p.corners[0][0]).filter(|x| !x.is_nan()).count();
                    }
                    _ => panic!("there are only triangles"),
                }
            }
            assert_eq!(seen, size as usize);
            pack += size.div_ceil(node::LANES as u32);
        }
    }

    /// Each level once made room for itself alone, and all nodes before it were moved.
    #[test]
    fn arrays_of_many_geometries_are_not_moved_for_each() {
        let world = shared((0..400).map(|_| 60));
        let bounds = items::object_bounds(&world);
        let (mut arrays, mut moves) = (Arrays::default(), 0);
        let prepare = |items, source, padding| Level::new(items, source, padding, 0, Isa::Portable);
        levels::objects(&world, &bounds, prepare, |level| {
            let before = (arrays.nodes.capacity(), arrays.packs.capacity());
            let root = arrays.append(level, false, Isa::Portable);
            moves += usize::from(before != (arrays.nodes.capacity(), arrays.packs.capacity()));
            root
        })
        .unwrap();
        assert!(arrays.packs.len() > 400 && moves < 40, "moved {moves} times");
    }

    /// The boxes of the leaves that each triangle of the first instance is in. Boxes hold those of their children.
    fn leaves(bvh: &Bvh, count: usize) -> Vec<Vec<Bounds>> {
        let arrays = &bvh.arrays;
        let mut leaves = vec![Vec::new(); count];
        let mut pending = vec![(bvh.top.word.unwrap(), bvh.top.bounds)];
        while let Some((word, bounds)) = pending.pop() {
            match node::Child::of(word) {
                node::Child::Node(index) => {
                    for (inner, child) in arrays.nodes[index as usize].used() {
                        assert_eq!(bounds.join(&inner), bounds);
                        pending.push((child, inner));
                    }
                }
                node::Child::Packs { first, count } => {
                    for pack in &arrays.packs[first as usize..(first + count) as usize] {
                        for lane in (0..node::LANES).filter(|&lane| !pack.corners[0][0][lane].is_nan()) {
                            leaves[pack.primitive[lane] as usize].push(bounds);
                        }
                    }
                }
                node::Child::Spheres { .. } => panic!("there are no spheres"),
                node::Child::Instance(index) => assert_eq!(arrays.instances[index as usize], 1),
            }
        }
        leaves
    }

    #[test]
    fn every_small_triangle_is_in_one_leaf() {
        let world = scattered(50_000, 0.01);
        let bvh = Bvh::build(&world, Isa::detect()).unwrap();
        let Geometry::Triangles(mesh) = &world.geometries[0] else { panic!("there are triangles") };
        for (face, leaves) in leaves(&bvh, mesh.indices.len()).iter().enumerate() {
            assert_eq!(leaves.len(), 1);
            assert_eq!(leaves[0].join(&Bounds::of_points(mesh.corners(face))), leaves[0]);
        }
    }

    #[test]
    fn every_point_of_a_triangle_in_pieces_is_in_a_leaf_with_it() {
        let world = scattered(5_000, 1.0);
        let bvh = Bvh::build(&world, Isa::detect()).unwrap();
        let Geometry::Triangles(mesh) = &world.geometries[0] else { panic!("there are triangles") };
        let all = leaves(&bvh, mesh.indices.len());
        assert!(all.iter().map(Vec::len).sum::<usize>() > 6_000, "some are cut");
        for (face, leaves) in all.iter().enumerate() {
            let [a, b, c] = mesh.corners(face).map(|corner| corner.map(f64::from));
            for (i, j) in (0..=12).flat_map(|i| (0..=12 - i).map(move |j| (i, j))) {
                let (v, w) = (f64::from(i) / 12.0, f64::from(j) / 12.0);
                let p: [f64; 3] = std::array::from_fn(|x| a[x] + v * (b[x] - a[x]) + w * (c[x] - a[x]));
                let holds =
                    |leaf: &Bounds| (0..3).all(|x| f64::from(leaf.min[x]) <= p[x] && p[x] <= f64::from(leaf.max[x]));
                assert!(leaves.iter().any(holds), "{face}: {p:?}");
            }
        }
    }
}
