//! Rays that come alone: their numbers stay in registers, and what is next does not wait for the stack.

use std::arch::x86_64::*;
use std::hint::black_box;

use super::x86::{COMPRESS, compress_avx512, order_of};
use crate::bvh::node::{LANES, Node, Pack, WIDTH};
use crate::local_ray::{Axis, COORDINATE_LIMIT, DIRECTION_LIMIT, LocalRay};
use crate::padding::{FLATTEST, Padding, SlabRay};
use crate::ray::Ray;

/// Four numbers, the last of no meaning.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
struct Four([f32; 4]);

impl Four {
    /// # Safety
    /// The processor has AVX.
    #[inline(always)]
    unsafe fn new(x: __m128) -> Self {
        let mut four = Self([0.0; 4]);
        // SAFETY: there is room for four numbers, aligned as they are.
        unsafe { _mm_store_ps(four.0.as_mut_ptr(), x) };
        four
    }

    /// The first three, each in all lanes.
    ///
    /// # Safety
    /// The processor has AVX.
    #[inline(always)]
    unsafe fn eight(&self) -> [__m256; 3] {
        let [x, y, z, _] = &self.0;
        // SAFETY: the caller says so.
        unsafe { [_mm256_broadcast_ss(x), _mm256_broadcast_ss(y), _mm256_broadcast_ss(z)] }
    }

    /// # Safety
    /// The processor has AVX.
    #[inline(always)]
    unsafe fn four(&self) -> [__m128; 3] {
        let [x, y, z, _] = &self.0;
        // SAFETY: the caller says so.
        unsafe { [_mm_broadcast_ss(x), _mm_broadcast_ss(y), _mm_broadcast_ss(z)] }
    }
}

/// What nodes and packs ask of a ray.
#[derive(Debug)]
pub(crate) struct Aim {
    rate: Four,
    /// Starts times rates as in [`SlabRay`], negated.
    near: Four,
    far: Four,
    octant: usize,
    /// By the axes of the shear, as those are in [`LocalRay`].
    origin: Four,
    shear: Four,
    /// Where a corner's coordinates begin, counted in numbers.
    axes: &'static [usize; 3],
}

/// What nodes ask of it, in all lanes.
pub(crate) struct Slabs {
    rate: [__m256; 3],
    near: [__m256; 3],
    far: [__m256; 3],
    /// Where rows begin, counted in numbers: of near planes and of far ones by axis.
    rows: [[usize; 3]; 2],
    octant: usize,
}

/// For each octant, what [`crate::bvh::node::rows_of`] says.
static ROWS: [[[usize; 3]; 2]; 8] = {
    let mut rows = [[[0; 3]; 2]; 8];
    let mut i = 0;
    while i < 24 {
        let (octant, axis) = (i % 8, i / 8);
        let negative = octant >> axis & 1;
        rows[octant][0][axis] = WIDTH * (2 * axis + negative);
        rows[octant][1][axis] = WIDTH * (2 * axis + 1 - negative);
        i += 1;
    }
    rows
};

/// Where the coordinates along the axes of the shear begin, by the axis of the direction's largest component.
static AXES: [[usize; 3]; 3] = [[LANES, 2 * LANES, 0], [2 * LANES, 0, LANES], [0, LANES, 2 * LANES]];

/// The same axes as lanes.
static ORDERS: [[i32; 4]; 3] = [[1, 2, 0, 3], [2, 0, 1, 3], [0, 1, 2, 3]];

/// The axis of the largest component, by bits that say whether x < y, x < z, y < z.
static MAJOR: [u8; 8] = [0, 1, 1, 1, 0, 2, 2, 2];

/// The largest of the first three lanes, which are no NaNs, in the first.
///
/// # Safety
/// The processor has AVX.
#[inline(always)]
unsafe fn largest(x: __m128) -> __m128 {
    // SAFETY: the caller says so.
    unsafe { _mm_max_ss(_mm_max_ss(x, _mm_permute_ps::<0x55>(x)), _mm_permute_ps::<0xaa>(x)) }
}

impl Aim {
    /// The numbers of [`LocalRay::new`] and [`SlabRay::new`].
    ///
    /// # Safety
    /// The processor has AVX2.
    #[inline(always)]
    pub unsafe fn new(ray: &Ray, padding: &Padding) -> Option<Self> {
        // SAFETY: the caller says so; a ray has four numbers from its origin on, and from its direction on.
        unsafe {
            let start = (&raw const *ray).cast::<f32>();
            let (origin, direction) = (_mm_loadu_ps(start), _mm_loadu_ps(start.add(4)));
            let (sign, one) = (_mm_set1_ps(-0.0), _mm_set1_ps(1.0));
            let (reach, length) = (_mm_andnot_ps(sign, origin), _mm_andnot_ps(sign, direction));
            let small = _mm_and_ps(
                _mm_cmple_ps(reach, _mm_set1_ps(COORDINATE_LIMIT)),
                _mm_cmple_ps(length, _mm_set1_ps(1.0 / DIRECTION_LIMIT)),
            );
            let longest = largest(length);
            if _mm_movemask_ps(small) & 7 != 7 || _mm_comilt_ss(longest, _mm_set1_ps(DIRECTION_LIMIT)) != 0 {
                return None;
            }
            // That of the direction's largest component is known before which it is.
            let flattest = _mm_mul_ps(_mm_permute_ps::<0>(longest), _mm_set1_ps(FLATTEST));
            let negative = _mm_and_ps(sign, direction);
            let rate = _mm_div_ps(one, _mm_or_ps(_mm_max_ps(length, flattest), negative));
            let forward = _mm_or_ps(_mm_set1_ps(padding.at(_mm_cvtss_f32(largest(reach)))), negative);
            let behind = _mm_xor_ps(sign, origin);
            let near = _mm_mul_ps(_mm_sub_ps(behind, forward), rate);
            let far = _mm_mul_ps(_mm_add_ps(behind, forward), rate);
            let less = _mm_cmplt_ps(_mm_permute_ps::<0b01_00_00>(length), _mm_permute_ps::<0b10_10_01>(length));
            let major = usize::from(MAJOR[_mm_movemask_ps(less) as usize & 7]);
            let order = _mm_loadu_si128(ORDERS[major].as_ptr().cast());
            let sheared = _mm_permutevar_ps(direction, order);
            let shear = _mm_div_ps(_mm_blend_ps::<0b1100>(sheared, one), _mm_permute_ps::<0xaa>(sheared));
            let octant = _mm_movemask_ps(direction) as usize & 7;
            Some(Self {
                rate: Four::new(rate),
                near: Four::new(near),
                far: Four::new(far),
                octant,
                origin: Four::new(_mm_permutevar_ps(origin, order)),
                shear: Four::new(shear),
                axes: &AXES[major],
            })
        }
    }

    /// A ray inside of an instance.
    #[inline(always)]
    pub fn inside(ray: &LocalRay, slab: &SlabRay) -> Self {
        let four = |[x, y, z]: [f32; 3]| Four([x, y, z, 0.0]);
        Self {
            rate: four(slab.rate),
            near: four(slab.near.map(|x| -x)),
            far: four(slab.far.map(|x| -x)),
            octant: slab.octant as usize & 7,
            origin: four(Axis::of(ray.axes, &ray.origin)),
            shear: four(ray.shear),
            axes: &AXES[ray.axes[2] as usize],
        }
    }

    /// # Safety
    /// The processor has AVX.
    #[inline(always)]
    pub unsafe fn slabs(&self) -> Slabs {
        // Loaded here and not kept from descent to descent, which would be in memory all the same, and stay there.
        let aim = black_box(self);
        let octant = aim.octant & 7;
        // SAFETY: the caller says so.
        unsafe {
            Slabs { rate: aim.rate.eight(), near: aim.near.eight(), far: aim.far.eight(), rows: ROWS[octant], octant }
        }
    }
}

impl Slabs {
    /// Entry and exit distances of the eight boxes.
    ///
    /// # Safety
    /// The processor has AVX2 and FMA.
    #[inline(always)]
    unsafe fn intervals(&self, node: &Node, (t_min, t_max): (f32, f32)) -> (__m256, __m256) {
        // SAFETY: the caller says so; rows of eight floats begin where the table says, and the loads need no alignment.
        unsafe {
            let row = |start: usize| _mm256_loadu_ps(node.rows.as_ptr().cast::<f32>().add(start));
            let near = |axis: usize| _mm256_fmadd_ps(row(self.rows[0][axis]), self.rate[axis], self.near[axis]);
            let far = |axis: usize| _mm256_fmadd_ps(row(self.rows[1][axis]), self.rate[axis], self.far[axis]);
            let enter = _mm256_max_ps(_mm256_max_ps(near(0), near(1)), _mm256_max_ps(near(2), _mm256_set1_ps(t_min)));
            let exit = _mm256_min_ps(_mm256_min_ps(far(0), far(1)), _mm256_min_ps(far(2), _mm256_set1_ps(t_max)));
            (enter, exit)
        }
    }

    /// The word of the nearest child of those that have a bit, which are in the order of [`Node::order_of`].
    #[inline(always)]
    fn nearest<const ANY: bool>(&self, node: &Node, entered: u32) -> u32 {
        let above = entered.leading_zeros();
        // The three bits at three times 31 less that, moved to the top.
        let child = if ANY { above ^ 31 } else { node.order[self.octant].wrapping_shl(3 * above) >> 29 };
        node.children[child as usize & 7]
    }
}

/// # Safety
/// The processor has the features of [`super::x86::Avx2`].
#[inline(always)]
pub(super) unsafe fn visit_avx2<const ANY: bool>(
    node: &Node,
    slabs: &Slabs,
    range: (f32, f32),
    entries: &mut [f32; WIDTH],
    words: &mut [u32; WIDTH],
) -> (usize, u32) {
    // SAFETY: the caller says so; arrays hold eight elements, and loads and stores need no alignment.
    unsafe {
        let (enter, exit) = slabs.intervals(node, range);
        let mut entered = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, exit);
        // Only the lowest three bits of an index count.
        let order = order_of(node, slabs.octant as u32);
        if !ANY {
            entered = _mm256_permutevar8x32_ps(entered, order);
        }
        let entered = _mm256_movemask_ps(entered) as u32;
        let mut places = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(COMPRESS[entered as usize & 255] as i64));
        if !ANY {
            places = _mm256_permutevar8x32_epi32(order, places);
        }
        let children = _mm256_loadu_si256(node.children.as_ptr().cast());
        _mm256_storeu_ps(entries.as_mut_ptr(), _mm256_permutevar8x32_ps(enter, places));
        _mm256_storeu_si256(words.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(children, places));
        (entered.count_ones() as usize, slabs.nearest::<ANY>(node, entered))
    }
}

/// # Safety
/// The processor has the features of [`super::x86::Avx512`].
#[inline(always)]
pub(super) unsafe fn visit_avx512<const ANY: bool>(
    node: &Node,
    slabs: &Slabs,
    range: (f32, f32),
    entries: &mut [f32; WIDTH],
    words: &mut [u32; WIDTH],
) -> (usize, u32) {
    // SAFETY: as in `visit_avx2`.
    unsafe {
        let intervals = slabs.intervals(node, range);
        let entered = compress_avx512::<ANY>(node, slabs.octant as u32, intervals, entries, words);
        (entered.count_ones() as usize, slabs.nearest::<ANY>(node, u32::from(entered)))
    }
}

/// The sheared corners as they come: x, y, z of each, x and y sheared, z not yet a ray parameter.
///
/// # Safety
/// The processor has AVX.
#[inline(always)]
unsafe fn sheared(pack: &Pack, aim: &Aim) -> [[__m128; 3]; 3] {
    // SAFETY: the caller says so; there are three axes, arrays hold four floats, and the loads need no alignment.
    unsafe {
        let start = pack.corners.as_ptr().cast::<f32>();
        let [ox, oy, oz] = aim.origin.four();
        let [sx, sy, _] = aim.shear.four();
        let corner = |start: *const f32| {
            let z = _mm_sub_ps(_mm_loadu_ps(start.add(aim.axes[2])), oz);
            let x = _mm_sub_ps(_mm_loadu_ps(start.add(aim.axes[0])), ox);
            let y = _mm_sub_ps(_mm_loadu_ps(start.add(aim.axes[1])), oy);
            [_mm_sub_ps(x, _mm_mul_ps(sx, z)), _mm_sub_ps(y, _mm_mul_ps(sy, z)), z]
        };
        [corner(start), corner(start.add(3 * LANES)), corner(start.add(6 * LANES))]
    }
}

/// # Safety
/// The processor has AVX2.
#[inline(always)]
pub(super) unsafe fn candidates(pack: &Pack, aim: &Aim, skip: u32) -> u32 {
    // SAFETY: the caller says so; the load needs no alignment.
    unsafe {
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = sheared(pack, aim);
        let u = _mm_sub_ps(_mm_mul_ps(cx, by), _mm_mul_ps(cy, bx));
        let v = _mm_sub_ps(_mm_mul_ps(ax, cy), _mm_mul_ps(ay, cx));
        let w = _mm_sub_ps(_mm_mul_ps(bx, ay), _mm_mul_ps(by, ax));
        let zero = _mm_setzero_ps();
        let none_positive = _mm_cmple_ps(_mm_max_ps(_mm_max_ps(u, v), w), zero);
        let none_negative = _mm_cmpge_ps(_mm_min_ps(_mm_min_ps(u, v), w), zero);
        let primitives = _mm_loadu_si128(pack.primitive.as_ptr().cast());
        let skipped = _mm_castsi128_ps(_mm_cmpeq_epi32(primitives, _mm_set1_epi32(skip as i32)));
        _mm_movemask_ps(_mm_andnot_ps(skipped, _mm_or_ps(none_positive, none_negative))) as u32
    }
}

/// # Safety
/// The processor has AVX2.
#[inline(always)]
pub(super) unsafe fn within(
    pack: &Pack,
    aim: &Aim,
    (t_min, t_max): (f32, f32),
    candidates: u32,
) -> (u32, [[[f32; LANES]; 3]; 3]) {
    // SAFETY: the caller says so; arrays hold four floats, and the stores need no alignment.
    unsafe {
        let [a, b, c] = sheared(pack, aim);
        let depth = |z: __m128| _mm_mul_ps(_mm_broadcast_ss(&aim.shear.0[2]), z);
        let [da, db, dc] = [depth(a[2]), depth(b[2]), depth(c[2])];
        let (low, high) = (_mm_min_ps(_mm_min_ps(da, db), dc), _mm_max_ps(_mm_max_ps(da, db), dc));
        let may = _mm_and_ps(_mm_cmpgt_ps(high, _mm_set1_ps(t_min)), _mm_cmple_ps(low, _mm_set1_ps(t_max)));
        let numbers = |x: __m128| {
            let mut numbers = [0.0; LANES];
            _mm_storeu_ps(numbers.as_mut_ptr(), x);
            numbers
        };
        let corner = |[x, y, _]: [__m128; 3], depth: __m128| [numbers(x), numbers(y), numbers(depth)];
        (candidates & _mm_movemask_ps(may) as u32, [corner(a, da), corner(b, db), corner(c, dc)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Isa;
    use crate::bounds::Bounds;
    use crate::ray::PrimitiveId;

    #[test]
    fn lanes_have_the_bits_of_plain_code() {
        if Isa::detect() < Isa::Avx2 {
            return;
        }
        let padding = Padding::new(&Bounds { min: [-3.0; 3], max: [5.0; 3] }, []);
        let numbers = [0.0, -0.0, 1.0, -2.5, 1e-20, -3e-30, 7.0, f32::INFINITY, f32::NAN, 1e30, -4.0, 0.3, 7.0];
        let edges = [DIRECTION_LIMIT, -DIRECTION_LIMIT, 1.0 / DIRECTION_LIMIT, COORDINATE_LIMIT, -COORDINATE_LIMIT];
        let numbers: Vec<f32> =
            numbers.into_iter().chain(edges.into_iter().flat_map(|x| [x, x.next_up(), x.next_down()])).collect();
        let mut draws = (0_u32..).map(|i| numbers[(i.wrapping_mul(2_654_435_761) >> 8) as usize % numbers.len()]);
        let mut three = || [0; 3].map(|_| draws.next().unwrap());
        let (mut some, mut none) = (0, 0);
        for _ in 0..20_000 {
            let (origin, direction) = (three(), three());
            let (t_min, t_max) = (f32::NAN, f32::NEG_INFINITY);
            let ray = Ray { origin, direction, t_min, t_max, time: 0.0, mask: 0, skip: PrimitiveId::NONE };
            // SAFETY: the processor has AVX2.
            let aim = unsafe { Aim::new(&ray, &padding) };
            let plain = LocalRay::new(origin, direction).map(|ray| Aim::inside(&ray, &SlabRay::new(&ray, &padding)));
            let bits = |aim: Aim| {
                let fours = [aim.rate, aim.near, aim.far, aim.origin, aim.shear];
                (fours.map(|Four([x, y, z, _])| [x, y, z].map(f32::to_bits)), aim.octant, *aim.axes)
            };
            assert_eq!(aim.map(bits), plain.map(bits), "{ray:?}");
            *if LocalRay::new(origin, direction).is_some() { &mut some } else { &mut none } += 1;
        }
        assert!(some > 500 && none > 500, "{some} {none}");
    }
}
