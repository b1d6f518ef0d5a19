//! The columns of vertices in records of one size.

use super::{
    elements::{COLUMNS, channel_scales},
    fixed::{Field, bytes, unique},
    header::{Element, Kind, Scalar},
};
use crate::{
    positions::{Bounds, unit_normal, usable},
    vertex_colors::{self, WHITE},
};
use etendue_accel::zeroed_shared;
use glam::DVec3;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering::Relaxed},
};

/// Where the columns stand in a vertex.
pub(super) struct Columns {
    positions: [Field; 3],
    normals: Option<[Field; 3]>,
    uvs: Option<[Field; 2]>,
    colors: Option<Colors>,
}

/// Where a colour stands: red, green, blue, and opacity if there is one.
struct Colors {
    fields: [Field; 3],
    alpha: Option<Field>,
    scales: [f64; 4],
    /// If all channels are bytes: what each stands for, as colour and as opacity.
    of_bytes: Option<Box<[[f32; 2]; 256]>>,
}

/// What the columns become.
pub(super) struct Arrays {
    pub positions: Arc<[[f32; 3]]>,
    pub normals: Option<Arc<[[f32; 3]]>>,
    pub uvs: Option<Arc<[[f32; 2]]>>,
    pub colors: Option<Arc<[[f32; 4]]>>,
}

/// A run of each array; empty where there is none.
pub(super) struct VertexArrays<'a> {
    positions: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
    uvs: &'a mut [[f32; 2]],
    colors: &'a mut [[f32; 4]],
}

impl VertexArrays<'_> {
    /// How many vertices.
    pub fn len(&self) -> usize {
        self.positions.len()
    }
}

impl Columns {
    /// By the columns of each property; `None` if positions are missing.
    pub fn new(element: &Element, columns: &[Option<usize>]) -> Option<Self> {
        let mut fields = [None; COLUMNS];
        let mut at = 0;
        for (property, column) in element.properties.iter().zip(columns) {
            let Kind::Scalar(kind) = property.kind else { return None };
            if let Some(column) = *column {
                fields[column] = Some(Field { at, kind });
            }
            at += kind.size();
        }
        let [x, y, z, nx, ny, nz, u, v, red, green, blue, alpha] = fields;
        let colors = three([red, green, blue]).map(|fields| Colors {
            fields,
            alpha,
            scales: channel_scales(element, columns),
            of_bytes: (fields.iter().chain(&alpha).all(|field| field.kind == Scalar::U8)).then(colors_of_bytes),
        });
        let uvs = u.zip(v).map(|(u, v)| [u, v]);
        Some(Self { positions: three([x, y, z])?, normals: three([nx, ny, nz]), uvs, colors })
    }

    /// Arrays for so many vertices.
    pub fn allocate(&self, count: usize) -> Arrays {
        Arrays {
            positions: zeroed_shared(count),
            normals: self.normals.map(|_| zeroed_shared(count)),
            uvs: self.uvs.map(|_| zeroed_shared(count)),
            colors: self.colors.as_ref().map(|_| zeroed_shared(count)),
        }
    }

    /// Runs of `length` vertices with the number of their first, in order.
    pub fn split<'a>(
        &self,
        arrays: &'a mut Arrays,
        length: usize,
    ) -> impl Iterator<Item = (usize, VertexArrays<'a>)> + Send + use<'a> {
        let Arrays { positions, normals, uvs, colors } = arrays;
        let mut normals = normals.as_mut().map_or(&mut [][..], unique);
        let mut uvs = uvs.as_mut().map_or(&mut [][..], unique);
        let mut colors = colors.as_mut().map_or(&mut [][..], unique);
        unique(positions).chunks_mut(length).enumerate().map(move |(run, positions)| {
            let arrays = VertexArrays {
                positions,
                normals: split_off(&mut normals, length),
                uvs: split_off(&mut uvs, length),
                colors: split_off(&mut colors, length),
            };
            (run * length, arrays)
        })
    }

    /// Coordinates are the same numbers in `f32`.
    pub fn positions_are_exact(&self) -> bool {
        self.positions.iter().all(|field| !matches!(field.kind, Scalar::F64 | Scalar::I32 | Scalar::U32))
    }

    /// Reads the vertices of a block; false if one has a value that a message is about.
    pub fn decode<const BIG: bool>(
        &self,
        block: &[u8],
        stride: usize,
        arrays: &mut VertexArrays<'_>,
        bounds: &mut Bounds,
        zero_normals: &mut usize,
    ) -> bool {
        let mut good = if self.positions.iter().all(|field| field.kind == Scalar::F32) {
            let [x, y, z] = self.positions.map(|field| field.at);
            let float = |record: &[u8], at| f32::from_le_bytes(bytes::<4, BIG>(record, at));
            let positions = block.chunks_exact(stride);
            let positions = positions.map(|record| [float(record, x), float(record, y), float(record, z)]);
            decode_floats(positions, arrays.positions, bounds)
        } else {
            let positions = block.chunks_exact(stride).map(|record| {
                let [x, y, z] = self.positions.map(|field| field.of::<BIG>(record));
                DVec3::new(x, y, z)
            });
            decode_positions(positions, arrays.positions, bounds)
        };
        if let Some(fields) = self.normals {
            for (record, out) in block.chunks_exact(stride).zip(&mut *arrays.normals) {
                let [x, y, z] = fields.map(|field| field.of::<BIG>(record));
                *out = unit_normal(DVec3::new(x, y, z));
                *zero_normals += usize::from(*out == [0.0; 3]);
            }
        }
        if let Some(fields) = self.uvs {
            for (record, out) in block.chunks_exact(stride).zip(&mut *arrays.uvs) {
                *out = fields.map(|field| field.of::<BIG>(record) as f32);
                good &= out[0].is_finite() & out[1].is_finite();
            }
        }
        if let Some(colors) = &self.colors {
            good &= colors.decode::<BIG>(block, stride, arrays.colors);
        }
        good
    }

    /// Makes colours linear whose scale depends on all of them.
    pub fn finish_colors(&self, arrays: &mut Arrays) {
        if let (Some(Colors { of_bytes: None, .. }), Some(colors)) = (&self.colors, &mut arrays.colors) {
            vertex_colors::decode(unique(colors));
        }
    }
}

fn three<T>([a, b, c]: [Option<T>; 3]) -> Option<[T; 3]> {
    Some([a?, b?, c?])
}

/// Takes the first values, at most `length`.
fn split_off<'a, T>(values: &mut &'a mut [T], length: usize) -> &'a mut [T] {
    let all = std::mem::take(values);
    let (first, rest) = all.split_at_mut(length.min(all.len()));
    *values = rest;
    first
}

/// Writes positions that are `f32`; false if one is not usable.
#[inline(always)]
fn decode_floats(positions: impl Iterator<Item = [f32; 3]>, out: &mut [[f32; 3]], bounds: &mut Bounds) -> bool {
    let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    let mut good = true;
    for (position, out) in positions.zip(out) {
        for axis in 0..3 {
            let x = position[axis];
            // Not true for NaN.
            good &= x.abs() <= LARGEST_FLOAT;
            min[axis] = if x < min[axis] { x } else { min[axis] };
            max[axis] = if x > max[axis] { x } else { max[axis] };
        }
        *out = position;
    }
    bounds.add_all(&Bounds { min: DVec3::from(min.map(f64::from)), max: DVec3::from(max.map(f64::from)) });
    good
}

/// The largest `f32` that is not above [`crate::positions::LARGEST`].
const LARGEST_FLOAT: f32 = f32::from_bits(0x5d5e_0b6b);

fn decode_positions(positions: impl Iterator<Item = DVec3>, out: &mut [[f32; 3]], bounds: &mut Bounds) -> bool {
    let mut good = true;
    for (position, out) in positions.zip(out) {
        good &= usable(position);
        bounds.add(position);
        *out = position.as_vec3().to_array();
    }
    good
}

impl Colors {
    /// False if one is not finite.
    fn decode<const BIG: bool>(&self, block: &[u8], stride: usize, out: &mut [[f32; 4]]) -> bool {
        let records = block.chunks_exact(stride).zip(out);
        if let Some(table) = &self.of_bytes {
            let [r, g, b] = self.fields.map(|field| field.at);
            for (record, out) in records {
                let channel = |at: usize| table[record[at] as usize][0];
                let alpha = self.alpha.map_or(1.0, |field| table[record[field.at] as usize][1]);
                *out = [channel(r), channel(g), channel(b), alpha];
            }
            return true;
        }
        let mut good = true;
        for (record, out) in records {
            let [r, g, b] = self.fields.map(|field| field.of::<BIG>(record));
            let alpha = self.alpha.map_or(1.0, |field| field.of::<BIG>(record));
            let values = [r, g, b, alpha];
            *out = std::array::from_fn(|i| (values[i] * self.scales[i]) as f32);
            good &= out.iter().all(|c| c.is_finite());
        }
        good
    }
}

/// What each byte stands for as a channel, and as opacity.
fn colors_of_bytes() -> Box<[[f32; 2]; 256]> {
    let mut colors: [[f32; 4]; 256] = std::array::from_fn(|byte| [(byte as f64 * (1.0 / 255.0)) as f32; 4]);
    debug_assert!(colors[255] == WHITE);
    vertex_colors::decode(&mut colors);
    Box::new(colors.map(|[r, _, _, a]| [r, a]))
}

impl Arrays {
    /// Leaves out the vertices that are not used and numbers the others anew, in their order; returns their bounds.
    pub fn leave_out(&mut self, used: &[AtomicBool], indices: &mut [[u32; 3]]) -> Bounds {
        let mut next = 0;
        let number = |used: &AtomicBool| {
            let number = next;
            next += u32::from(used.load(Relaxed));
            number
        };
        let numbers: Vec<u32> = used.iter().map(number).collect();
        fn keep<T: Copy>(values: &mut Arc<[T]>, used: &[AtomicBool]) {
            let kept = values.iter().zip(used).filter(|(_, used)| used.load(Relaxed));
            let kept: Vec<T> = kept.map(|(value, _)| *value).collect();
            *values = kept.into();
        }
        keep(&mut self.positions, used);
        self.normals.iter_mut().for_each(|normals| keep(normals, used));
        self.uvs.iter_mut().for_each(|uvs| keep(uvs, used));
        self.colors.iter_mut().for_each(|colors| keep(colors, used));
        indices.iter_mut().flatten().for_each(|corner| *corner = numbers[*corner as usize]);
        let mut bounds = Bounds::default();
        self.positions.iter().for_each(|p| bounds.add(DVec3::from(p.map(f64::from))));
        bounds
    }
}
