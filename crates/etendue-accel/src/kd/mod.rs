//! The kd-tree: space is cut in two by planes, and primitives are in every leaf in whose cell a part of them is, triangles in packs of four.

mod arrays;
mod build;
mod list;
mod node;
mod plane;
mod reference;
mod rounds;
mod traverse;

use crate::accelerator::KdTreeSplit;
use crate::bounds::Bounds;
use crate::bvh::node::LANES;
use crate::error::BuildError;
use crate::geometry::World;
use crate::items;
use crate::levels;
use crate::source::Source;

use arrays::{Arrays, Lengths, Level, Root};
pub(crate) use traverse::Trace;

/// Most nodes on a way down a level.
const DEPTH_LIMIT: usize = 60;

/// A level over the world and one for each geometry that transformed instances use.
#[derive(Debug)]
pub(crate) struct KdTree {
    arrays: Arrays,
    top: Root,
    /// By geometry.
    objects: Vec<Option<Root>>,
    /// Where the top begins in the arrays.
    top_start: Lengths,
    split: KdTreeSplit,
}

impl KdTree {
    pub fn build(world: &World, split: KdTreeSplit) -> Result<Self, BuildError> {
        let mut arrays = Arrays::new();
        let bounds = items::object_bounds(world);
        let prepare = |items, source, padding| Level::new(items, source, padding, split);
        let objects = levels::objects(world, &bounds, prepare, |level| arrays.append(level))?;
        let top_start = arrays.lengths();
        let top = Self::top(&mut arrays, world, &bounds, split)?;
        Ok(Self { arrays, top, objects, top_start, split })
    }

    fn top(
        arrays: &mut Arrays,
        world: &World,
        objects: &[Option<Bounds>],
        split: KdTreeSplit,
    ) -> Result<Root, BuildError> {
        let (items, padding) = levels::top(world, objects)?;
        arrays.append(Level::new(items, Source::Top(world), padding, split)?)
    }

    /// Adapts to a world of which nothing has changed but the transforms of instances that had one and still have one.
    pub fn move_instances(&mut self, world: &World) -> Result<(), BuildError> {
        let objects: Vec<Option<Bounds>> =
            self.objects.iter().map(|root| root.as_ref().map(|root| root.bounds)).collect();
        self.arrays.truncate(&self.top_start);
        self.top = Self::top(&mut self.arrays, world, &objects, self.split)?;
        Ok(())
    }

    pub fn bounds(&self) -> Bounds {
        self.top.bounds
    }

    /// The corners of the triangle at a place, see [`crate::search::Found`].
    #[inline(always)]
    pub fn corners(&self, place: u32) -> Option<[[f32; 3]; 3]> {
        Some(self.arrays.packs.get(place as usize / LANES)?.get(place as usize % LANES))
    }

    pub fn nodes(&self) -> usize {
        self.arrays.nodes().len()
    }

    pub fn bytes(&self) -> usize {
        self.arrays.bytes()
    }

    pub fn depth(&self) -> usize {
        self.top.depth + self.objects.iter().flatten().map(|root| root.depth).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::node::{Leaf, Node};
    use super::*;
    use crate::isa::{Isa, dispatch};
    use crate::random::Random;
    use crate::search::Found;
    use crate::{Geometry, Instance, Place, PrimitiveId, Ray, Sphere, Transform, TriangleMesh};

    /// Triangles of a size at random places, every fifth in a plane across an axis.
    fn scattered(count: u32, size: f32) -> Geometry {
        let mut random = Random(7);
        let mut positions: Vec<[f32; 3]> = Vec::new();
        for face in 0..count {
            let place = random.point(1.0);
            let start = positions.len();
            positions.extend((0..3).map(|_| {
                let offset = random.point(size);
                std::array::from_fn(|a| place[a] + offset[a])
            }));
            if face % 5 == 0 {
                let axis = face as usize % 3;
                positions[start..].iter_mut().for_each(|p| p[axis] = 0.25);
            }
        }
        let indices: Vec<[u32; 3]> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Geometry::Triangles(TriangleMesh { positions: positions.into(), indices: indices.into() })
    }

    fn world(geometries: Vec<Geometry>, places: &[(u32, Place)]) -> World {
        let instances = places.iter().map(|(geometry, place)| Instance {
            geometry: *geometry,
            place: place.clone(),
            mask: u32::MAX,
        });
        World { instances: instances.collect(), geometries }
    }

    const SPLITS: [KdTreeSplit; 2] = [KdTreeSplit::SurfaceArea, KdTreeSplit::Midpoint];

    /// Large enough for halves that are built in parallel.
    #[test]
    fn threads_leave_no_trace() {
        let world = world(
            vec![scattered(30_000, 0.05)],
            &[(0, Place::World), (0, Place::Fixed(Transform::IDENTITY)), (0, Place::World)],
        );
        let bytes = |threads: usize| -> Vec<u8> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let tree = pool.install(|| KdTree::build(&world, KdTreeSplit::SurfaceArea)).unwrap();
            let (nodes, packs) = (bytemuck::cast_slice(tree.arrays.nodes()), bytemuck::cast_slice(&tree.arrays.packs));
            [nodes, packs].concat()
        };
        let one = bytes(1);
        assert!(one == bytes(2) && one == bytes(5));
    }

    /// The triangles in the leaves whose closed cells hold a point.
    fn at(tree: &KdTree, point: [f64; 3]) -> Vec<u32> {
        let (nodes, mut found) = (tree.arrays.nodes(), Vec::new());
        let mut pending = vec![tree.top.node.unwrap()];
        while let Some(node) = pending.pop() {
            let Node { at, word } = nodes[node as usize];
            if word & 3 != Node::LEAF {
                let (x, pair) = (point[(word & 3) as usize], (word >> 4) * 2);
                pending.extend((x <= f64::from(at) && word >> 2 & 1 == 0).then_some(pair));
                pending.extend((x >= f64::from(at) && word >> 3 & 1 == 0).then_some(pair + 1));
            } else if let Leaf::Packs { first, count } = nodes[node as usize].as_leaf() {
                let packs = &tree.arrays.packs[first as usize..(first + count) as usize];
                found.extend(packs.iter().flat_map(|pack| {
                    (0..4).filter(|&lane| !pack.corners[0][0][lane].is_nan()).map(|lane| pack.primitive[lane])
                }));
            }
        }
        found
    }

    #[test]
    fn every_point_of_a_triangle_is_in_a_leaf_with_it() {
        for (size, split) in [0.03, 0.6].into_iter().flat_map(|size| SPLITS.map(|split| (size, split))) {
            let world = world(vec![scattered(1500, size)], &[(0, Place::World)]);
            let tree = KdTree::build(&world, split).unwrap();
            let Geometry::Triangles(mesh) = &world.geometries[0] else { panic!("there are triangles") };
            for face in 0..mesh.indices.len() {
                let [a, b, c] = mesh.corners(face).map(|corner| corner.map(f64::from));
                for (i, j) in (0..=16).flat_map(|i| (0..=16 - i).map(move |j| (i, j))) {
                    let (v, w) = (f64::from(i) / 16.0, f64::from(j) / 16.0);
                    let p = std::array::from_fn(|x| a[x] + v * (b[x] - a[x]) + w * (c[x] - a[x]));
                    assert!(at(&tree, p).contains(&(face as u32)), "{split:?} {size} {face}: {p:?}");
                }
            }
        }
    }

    /// Cells that a triangle's box meets and the triangle does not were once referred to it.
    #[test]
    fn boxes_alone_put_no_triangle_into_a_cell() {
        let corners = vec![[0.0, 0.0, 0.0], [16.0, 16.0, 16.0], [16.0, 16.0, 16.1]];
        let mut positions = corners;
        let mut indices = vec![[0, 1, 2]];
        for i in 0..64_u32 {
            let place = [0.0, 4.0, 8.0, 12.0].map(|x| x + 2.0);
            let p = [place[i as usize % 4], place[i as usize / 4 % 4], place[i as usize / 16]];
            positions.extend([p, [p[0] + 0.1, p[1], p[2]], [p[0], p[1] + 0.1, p[2]]]);
            indices.push([3 + 3 * i, 4 + 3 * i, 5 + 3 * i]);
        }
        let mesh = TriangleMesh { positions: positions.into(), indices: indices.into() };
        let world = world(vec![Geometry::Triangles(mesh)], &[(0, Place::World)]);
        let tree = KdTree::build(&world, KdTreeSplit::SurfaceArea).unwrap();
        let with_it = tree
            .arrays
            .packs
            .iter()
            .flat_map(|p| (0..4).filter(|&l| !p.corners[0][0][l].is_nan() && p.primitive[l] == 0));
        assert!(with_it.count() <= 12);
    }

    #[test]
    fn references_and_depth_are_bounded() {
        let mut random = Random(3);
        let balls: Vec<Sphere> =
            (0..2000).map(|_| Sphere { center: random.point(0.2), radius: 0.5 + 0.4 * random.unit() }).collect();
        let many = 4000;
        let world =
            world(vec![Geometry::Spheres(balls.into()), scattered(2000, 1.0)], &[(0, Place::World), (1, Place::World)]);
        for split in SPLITS {
            let tree = KdTree::build(&world, split).unwrap();
            let lanes = tree.arrays.packs.iter().flat_map(|pack| pack.corners[0][0]).filter(|x| !x.is_nan()).count();
            let references = tree.arrays.others.len() + lanes;
            assert!((many..=6 * many).contains(&references), "{split:?}: {references}");
            assert!(tree.depth() <= DEPTH_LIMIT, "{split:?}: {}", tree.depth());
        }
    }

    /// Fewer rays than slots, as many, and more; some that miss everything by definition.
    #[test]
    fn every_ray_is_finished_once() {
        let world = world(vec![scattered(3000, 0.1)], &[(0, Place::World), (0, Place::Fixed(Transform::IDENTITY))]);
        let tree = KdTree::build(&world, KdTreeSplit::SurfaceArea).unwrap();
        let mut random = Random(11);
        for count in [0, 1, 2, 15, 16, 31, 32, 33, 64, 500] {
            let ray = |i: usize| Ray {
                origin: if i % 7 == 3 { [f32::NAN; 3] } else { random.point(2.0) },
                direction: random.point(1.0),
                t_min: 0.0,
                t_max: if i % 5 == 4 { 0.0 } else { f32::INFINITY },
                time: 0.0,
                mask: u32::MAX,
                skip: PrimitiveId::NONE,
            };
            let rays: Vec<Ray> = (0..count).map(ray).collect();
            let mut finished = vec![0; count];
            let finish = |index: usize, _: Found| finished[index] += 1;
            dispatch(Isa::detect(), Trace::<_, false> { world: &world, tree: &tree, rays: &rays, finish });
            assert!(finished.iter().all(|&times| times == 1), "{count}: {finished:?}");
        }
    }
}
