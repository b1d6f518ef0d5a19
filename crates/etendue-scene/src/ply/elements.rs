//! Vertices and faces out of PLY data.

use super::{
    header::{Element, Encoding, Header, Kind, Scalar},
    values::{ValueError, Values},
};
use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    indexed::{Indexed, Repair},
    positions::{unit_normal, usable},
    text::{Tally, counted, shown, tally::Finding},
    vertex_colors::{self, NONE},
};
use glam::DVec3;
use std::ops::Range;

/// What is skipped, approximated or repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Skipped {
    Element,
    Property,
    HalfColour,
    HalfNormal,
    RestOfLine,
    TrailingBytes,
    BadUv,
    BadColour,
    Repaired(Repair),
}

impl Finding for Skipped {
    fn describe(self, key: &str, count: usize) -> Diagnostic {
        let of = |thing: &str| counted(count, thing);
        match self {
            Self::Element => Diagnostic::note(format!("element `{key}` is not read ({count} of them)")),
            Self::Property => Diagnostic::note(format!("property `{key}` is not read")),
            Self::HalfColour => {
                Diagnostic::warning(format!("property `{key}` ignored: a colour needs red, green and blue"))
            }
            Self::BadColour => Diagnostic::warning(format!("{} not finite count as white", of("colour"))),
            Self::HalfNormal => Diagnostic::warning(format!("property `{key}` ignored: a normal needs nx, ny and nz")),
            Self::RestOfLine => Diagnostic::warning(format!("more numbers than the header says on {}", of("line"))),
            Self::TrailingBytes => Diagnostic::warning(format!("{} after the data ignored", of("byte"))),
            Self::BadUv => Diagnostic::warning(format!("{} not finite count as (0, 0)", of("texture coordinate"))),
            Self::Repaired(repair) => repair.describe(count),
        }
    }
}

/// What the data hold.
#[derive(Default)]
pub(super) struct Content {
    pub mesh: Indexed,
    /// Vertices whose position is not usable, and their places; the first ones.
    pub bad: Vec<(u32, Span)>,
}

/// Columns of a vertex: x y z, nx ny nz, u v, red green blue alpha.
pub(super) const COLUMNS: usize = 12;
const COLOURS: [[&str; 4]; 2] =
    [["red", "green", "blue", "alpha"], ["diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"]];
const UVS: [[&str; 2]; 4] = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

/// Most faces and vertices: indices fit in 32 bits.
pub(super) const MOST: u64 = u32::MAX as u64 - 1;

pub(super) struct Reader<'h, V> {
    pub header: &'h Header,
    pub file: FileId,
    pub values: V,
    pub found: Diagnostics,
    pub skipped: Tally<Skipped>,
}

/// What brings each channel of a colour to 1: numbers without sign count up to their largest.
pub(super) fn channel_scales(element: &Element, columns: &[Option<usize>]) -> [f64; 4] {
    [8, 9, 10, 11].map(|column| {
        let at = columns.iter().position(|c| *c == Some(column));
        match at.map(|at| element.properties[at].kind) {
            Some(Kind::Scalar(Scalar::U8)) => 1.0 / 255.0,
            Some(Kind::Scalar(Scalar::U16)) => 1.0 / 65535.0,
            _ => 1.0,
        }
    })
}

/// Stops the reading; the error is among what was found.
pub(super) struct Stop;

impl<'h, V: Values> Reader<'h, V> {
    pub fn new(header: &'h Header, file: FileId, values: V) -> Self {
        Self { header, file, values, found: Diagnostics::new(), skipped: Tally::new() }
    }

    pub fn read(&mut self) -> Result<Content, Stop> {
        let mut content = Content::default();
        let vertices = self.header.elements.iter().find(|element| element.name == "vertex").map_or(0, |e| e.count);
        for element in &self.header.elements {
            self.check_count(element)?;
            match element.name.as_str() {
                "vertex" => self.vertices(element, &mut content)?,
                "face" | "tristrips" => self.faces(element, vertices, &mut content)?,
                _ => self.skip_element(element)?,
            }
        }
        if self.header.encoding == Encoding::Ascii {
            self.values.begin();
        }
        let left = self.values.left();
        if left > 0 {
            let place = self.values.place().unwrap_or(0..0);
            self.skipped.add_many(Skipped::TrailingBytes, b"", left as usize, self.file, place);
        }
        Ok(content)
    }

    fn at(&self, element: &Element) -> Span {
        Span::new(self.file, self.values.place().unwrap_or(element.place.clone()))
    }

    /// Refuses counts that the bytes left cannot hold, before anything is allocated for them.
    fn check_count(&mut self, element: &Element) -> Result<(), Stop> {
        let size = element.least_size(self.header.encoding);
        let needed = u128::from(size) * u128::from(element.count);
        // The last line of a text may lack its end.
        let left = u128::from(self.values.left()) + u128::from(self.header.encoding == Encoding::Ascii);
        if needed <= left && (element.count <= MOST || size == 0) {
            return Ok(());
        }
        let error = Diagnostic::error(format!(
            "{} elements `{}` need at least {needed} bytes, but {} are left",
            element.count,
            shown(element.name.as_bytes()),
            self.values.left(),
        ));
        self.found.push(error.at(Span::new(self.file, element.place.clone())).help("the file may be truncated"));
        Err(Stop)
    }

    /// The next number of element `index`; an error ends the reading of binary data, and counts in text.
    fn number(&mut self, kind: Scalar, element: &Element, index: u64) -> Result<f64, Stop> {
        self.values.number(kind).map_err(|error| self.bad_number(error, element, index))
    }

    #[cold]
    fn bad_number(&mut self, error: ValueError, element: &Element, index: u64) -> Stop {
        let of = format!("{} {index}", shown(element.name.as_bytes()));
        let message = match error {
            ValueError::Truncated => format!("the data end in {of} of {}", element.count),
            ValueError::Missing => format!("a number of {of} is missing"),
            ValueError::Malformed => format!("`{}` is not a number ({of})", shown(self.values.word())),
        };
        let error = Diagnostic::error(message).at(self.at(element));
        self.found.push(error);
        Stop
    }

    fn end_of_element(&mut self) {
        // After an error the rest of the line is no surprise.
        if self.values.end() && !self.found.has_errors() {
            let place = self.values.place().unwrap_or(0..0);
            self.skipped.add(Skipped::RestOfLine, b"", self.file, place);
        }
    }

    /// Counts an element that is not read.
    pub fn note_element(&mut self, element: &Element) {
        let name = element.name.as_bytes();
        let count = usize::try_from(element.count).unwrap_or(usize::MAX);
        self.skipped.add_many(Skipped::Element, name, count, self.file, element.place.clone());
    }

    fn skip_element(&mut self, element: &Element) -> Result<(), Stop> {
        self.note_element(element);
        if element.properties.is_empty() {
            return Ok(());
        }
        if element.properties.iter().all(|property| matches!(property.kind, Kind::Scalar(_))) {
            let bytes = element.least_size(self.header.encoding) * element.count;
            match self.values.skip(bytes) {
                Some(Ok(())) => return Ok(()),
                Some(Err(error)) => return Err(self.bad_number(error, element, element.count)),
                None => {}
            }
        }
        for index in 0..element.count {
            self.values.begin();
            for property in &element.properties {
                self.skip_property(property.kind, element, index)?;
            }
            self.end_of_element();
        }
        Ok(())
    }

    fn skip_property(&mut self, kind: Kind, element: &Element, index: u64) -> Result<(), Stop> {
        match kind {
            Kind::Scalar(scalar) => self.number(scalar, element, index).map(|_| ()),
            Kind::List { length, item } => {
                let count = self.list_length(length, item, element, index)?;
                for _ in 0..count {
                    self.number(item, element, index)?;
                }
                Ok(())
            }
        }
    }

    /// The length of a list, of which the bytes left can hold as many items.
    fn list_length(&mut self, length: Scalar, item: Scalar, element: &Element, index: u64) -> Result<u64, Stop> {
        let place = self.at(element);
        let count = self.number(length, element, index)?;
        let size = if self.header.encoding == Encoding::Ascii { 2 } else { item.size() as u64 };
        let left = self.values.left() + u64::from(self.header.encoding == Encoding::Ascii);
        if count.fract() == 0.0 && count >= 0.0 && count <= (left / size) as f64 {
            return Ok(count as u64);
        }
        let of = format!("{} {index}", shown(element.name.as_bytes()));
        let error = Diagnostic::error(format!("a list of {count} items in {of}")).at(place);
        self.found.push(error.label(format!("{} bytes are left", self.values.left())));
        Err(Stop)
    }

    /// Where each property of a vertex goes.
    pub fn columns(&mut self, element: &Element) -> Result<Vec<Option<usize>>, Stop> {
        let has = |name: &str| element.properties.iter().any(|p| p.name == name && matches!(p.kind, Kind::Scalar(_)));
        let missing: Vec<&str> = ["x", "y", "z"].into_iter().filter(|name| !has(name)).collect();
        if !missing.is_empty() && element.count > 0 {
            let error = Diagnostic::error(format!("vertices without {}", missing.join(", ")));
            self.found.push(error.at(Span::new(self.file, element.place.clone())).label("expected properties x, y, z"));
            return Err(Stop);
        }
        let normals = ["nx", "ny", "nz"].iter().all(|name| has(name));
        let uvs = UVS.into_iter().find(|pair| pair.iter().all(|name| has(name))).unwrap_or([""; 2]);
        let colours = COLOURS.into_iter().find(|names| names[..3].iter().all(|name| has(name))).unwrap_or([""; 4]);
        let mut columns = vec![];
        for property in &element.properties {
            let name = property.name.as_str();
            let place = property.place.clone();
            let scalar = matches!(property.kind, Kind::Scalar(_));
            let column = match name {
                _ if !scalar => None,
                "x" => Some(0),
                "y" => Some(1),
                "z" => Some(2),
                "nx" if normals => Some(3),
                "ny" if normals => Some(4),
                "nz" if normals => Some(5),
                _ if name == uvs[0] => Some(6),
                _ if name == uvs[1] => Some(7),
                _ => colours.iter().position(|colour| *colour == name).map(|channel| 8 + channel),
            };
            // Of a property that is there twice, the first counts.
            let column = column.filter(|column| !columns.contains(&Some(*column)));
            let skipped = match name {
                _ if column.is_some() => None,
                "red" | "green" | "blue" => Some((Skipped::HalfColour, name.as_bytes())),
                "nx" | "ny" | "nz" => Some((Skipped::HalfNormal, name.as_bytes())),
                _ => Some((Skipped::Property, name.as_bytes())),
            };
            if let Some((kind, key)) = skipped {
                self.skipped.add(kind, key, self.file, place);
            }
            columns.push(column);
        }
        Ok(columns)
    }

    fn vertices(&mut self, element: &Element, content: &mut Content) -> Result<(), Stop> {
        let columns = self.columns(element)?;
        // With no properties at all there is nothing to read, whatever the count.
        let count = if element.properties.is_empty() { 0 } else { element.count as usize };
        content.mesh.positions = Vec::with_capacity(count);
        content.mesh.normals = columns.contains(&Some(3)).then(|| Vec::with_capacity(count));
        content.mesh.uvs = columns.contains(&Some(6)).then(|| Vec::with_capacity(count));
        content.mesh.colors = columns.contains(&Some(8)).then(|| Vec::with_capacity(count));
        let scales = channel_scales(element, &columns);
        for index in 0..count as u64 {
            self.values.begin();
            let place = self.values.place();
            match self.row(element, &columns, index) {
                Ok(row) => self.push_vertex(content, row, &scales, place, element),
                Err(Stop) => self.go_on()?,
            }
            self.end_of_element();
        }
        content.mesh.colors.iter_mut().for_each(|colors| vertex_colors::decode(colors));
        Ok(())
    }

    #[inline(always)]
    fn row(&mut self, element: &Element, columns: &[Option<usize>], index: u64) -> Result<[f64; COLUMNS], Stop> {
        let mut row = [0.0; COLUMNS];
        // Opaque, if nothing else is said.
        row[COLUMNS - 1] = 1.0;
        for (property, column) in element.properties.iter().zip(columns) {
            match (property.kind, *column) {
                (Kind::Scalar(scalar), Some(column)) => row[column] = self.number(scalar, element, index)?,
                (kind, _) => self.skip_property(kind, element, index)?,
            }
        }
        Ok(row)
    }

    /// After an error, text goes on with the next line, to find more of them.
    fn go_on(&self) -> Result<(), Stop> {
        let text = self.header.encoding == Encoding::Ascii;
        if text && self.values.left() > 0 && !self.found.is_full(Severity::Error) { Ok(()) } else { Err(Stop) }
    }

    #[inline(always)]
    fn push_vertex(
        &mut self,
        content: &mut Content,
        [x, y, z, nx, ny, nz, u, v, red, green, blue, alpha]: [f64; COLUMNS],
        scales: &[f64; 4],
        place: Option<Range<usize>>,
        element: &Element,
    ) {
        let position = DVec3::new(x, y, z);
        if !usable(position) && content.bad.len() < Diagnostics::KEPT {
            let place = Span::new(self.file, place.unwrap_or(element.place.clone()));
            content.bad.push((content.mesh.positions.len() as u32, place));
        }
        content.mesh.positions.push(position);
        if let Some(normals) = &mut content.mesh.normals {
            normals.push(unit_normal(DVec3::new(nx, ny, nz)));
        }
        if let Some(uvs) = &mut content.mesh.uvs {
            let mut uv = [u as f32, v as f32];
            if !(uv[0].is_finite() && uv[1].is_finite()) {
                self.skipped.add(Skipped::BadUv, b"", self.file, element.place.clone());
                uv = [0.0; 2];
            }
            uvs.push(uv);
        }
        if let Some(colors) = &mut content.mesh.colors {
            let [r, g, b, a] = scales;
            let mut color = [red * r, green * g, blue * b, alpha * a].map(|c| c as f32);
            if color.iter().any(|c| !c.is_finite()) {
                self.skipped.add(Skipped::BadColour, b"", self.file, element.place.clone());
                color = NONE;
            }
            colors.push(color);
        }
    }

    /// Which property of a face, or of strips, is its list of vertices; `None` if there are no faces. The others are counted.
    pub fn face_indices(&mut self, element: &Element) -> Result<Option<usize>, Stop> {
        let is_indices = |kind: Kind, name: &str| {
            matches!(kind, Kind::List { .. }) && ["vertex_indices", "vertex_index"].contains(&name)
        };
        let Some(indices) = element.properties.iter().position(|p| is_indices(p.kind, &p.name)) else {
            if element.count > 0 {
                let error = Diagnostic::error(format!("element `{}` has no list vertex_indices", element.name));
                self.found.push(error.at(Span::new(self.file, element.place.clone())));
                return Err(Stop);
            }
            return Ok(None);
        };
        for (i, property) in element.properties.iter().enumerate() {
            if i != indices {
                self.skipped.add(Skipped::Property, property.name.as_bytes(), self.file, property.place.clone());
            }
        }
        Ok(Some(indices))
    }

    fn faces(&mut self, element: &Element, vertices: u64, content: &mut Content) -> Result<(), Stop> {
        let Some(indices) = self.face_indices(element)? else { return Ok(()) };
        let strips = element.name == "tristrips";
        if !strips {
            content.mesh.corners.reserve(element.count as usize * 3);
        }
        let mut strip = strips.then(Vec::new);
        for index in 0..element.count {
            self.values.begin();
            if let Err(Stop) = self.face(element, indices, index, vertices, content, strip.as_mut()) {
                self.go_on()?;
            }
            self.end_of_element();
        }
        Ok(())
    }

    #[inline(always)]
    fn face(
        &mut self,
        element: &Element,
        indices: usize,
        index: u64,
        vertices: u64,
        content: &mut Content,
        mut strip: Option<&mut Vec<u32>>,
    ) -> Result<(), Stop> {
        for (i, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { length, item } if i == indices => {
                    let count = self.list_length(length, item, element, index)?;
                    match &mut strip {
                        Some(strip) => {
                            self.strip(count, item, element, index, vertices, strip)?;
                            add_strip(strip, content);
                        }
                        None => self.polygon(count, item, element, index, vertices, content)?,
                    }
                }
                kind => self.skip_property(kind, element, index)?,
            }
        }
        Ok(())
    }

    /// One index; [`RESTART`] for -1 where that is allowed.
    #[inline(always)]
    fn index(&mut self, item: Scalar, element: &Element, face: u64, vertices: u64, restart: bool) -> Result<u32, Stop> {
        let value = self.number(item, element, face)?;
        if value >= 0.0 && value < vertices as f64 && value.fract() == 0.0 {
            return Ok(value as u32);
        }
        if restart && value == -1.0 {
            return Ok(RESTART);
        }
        let of = format!("{} {face}", shown(element.name.as_bytes()));
        let error = Diagnostic::error(format!("no vertex {value} for {of}")).at(self.at(element));
        self.found.push(error.label(format!("expected a whole number from 0 to below {vertices}")));
        // The rest of the data can still be read, and searched for more of these.
        if self.found.is_full(Severity::Error) { Err(Stop) } else { Ok(0) }
    }

    #[inline(always)]
    fn polygon(
        &mut self,
        count: u64,
        item: Scalar,
        element: &Element,
        face: u64,
        vertices: u64,
        content: &mut Content,
    ) -> Result<(), Stop> {
        for _ in 0..count {
            let index = self.index(item, element, face, vertices, false)?;
            content.mesh.corners.push(index);
        }
        content.mesh.end_polygon(count as u32);
        Ok(())
    }

    fn strip(
        &mut self,
        count: u64,
        item: Scalar,
        element: &Element,
        face: u64,
        vertices: u64,
        strip: &mut Vec<u32>,
    ) -> Result<(), Stop> {
        strip.clear();
        for _ in 0..count {
            strip.push(self.index(item, element, face, vertices, true)?);
        }
        Ok(())
    }
}

/// -1 in a list of strips: the next strip begins.
const RESTART: u32 = u32::MAX;

/// Adds the triangles of strips: every other one turns the other way. Repeated corners only turn the strip.
fn add_strip(strips: &[u32], content: &mut Content) {
    let mut triangles = 0;
    for strip in strips.split(|&index| index == RESTART) {
        for (i, corners) in strip.windows(3).enumerate() {
            let [a, b, c] = [corners[0], corners[1], corners[2]];
            if a != b && b != c && c != a {
                content.mesh.corners.extend(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                triangles += 1;
            }
        }
    }
    if let Some(sizes) = &mut content.mesh.sizes {
        sizes.extend(std::iter::repeat_n(3, triangles));
    }
}
