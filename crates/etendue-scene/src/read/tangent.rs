//! `tangent` of materials.

use super::{
    fields::{Fields, Item},
    keys, texture,
    values::Bounds,
};
use crate::{description::TextureRecord, value::Data};
use etendue::material::{Tangent, TangentField};

/// Degrees.
const ANGLE: Bounds = Bounds::within(-3600.0, 3600.0);

#[derive(Clone, Copy)]
enum Kind {
    Uv,
    Constant,
    Radial,
    Tangential,
}

const KINDS: [(&str, Kind); 4] =
    [("uv", Kind::Uv), ("constant", Kind::Constant), ("radial", Kind::Radial), ("tangential", Kind::Tangential)];

/// A direction field: `"uv"`, or a table.
pub fn tangent(item: Item) -> Option<TangentField<TextureRecord>> {
    if let Data::String(_) = item.value.data {
        return item.choice(&[("uv", ())]).map(|()| TangentField::default());
    }
    let mut fields = item.table(&keys::TANGENT, "\"uv\" or { type = \"radial\", center = [0, 0, 0] }")?;
    let kind = fields.variant("type", &KINDS, Some("uv"));
    let direction = kind.and_then(|kind| direction(&fields, kind));
    let mut rotation = fields.read("rotation", |i| texture::number(i, ANGLE)).unwrap_or(0.0.into());
    rotation.factor = rotation.factor.to_radians();
    fields.finish();
    Some(TangentField { direction: direction?, rotation })
}

fn direction(fields: &Fields, kind: Kind) -> Option<Tangent> {
    let center = || fields.need("center", |i| i.point());
    let axis = || fields.read("axis", |i| i.axis());
    Some(match kind {
        Kind::Uv => Tangent::Uv,
        Kind::Constant => Tangent::Constant(fields.need("direction", |i| i.axis())?),
        Kind::Radial => {
            let axis = axis();
            Tangent::Radial { center: center()?, axis }
        }
        Kind::Tangential => {
            let axis = axis();
            Tangent::Tangential { center: center()?, axis }
        }
    })
}
