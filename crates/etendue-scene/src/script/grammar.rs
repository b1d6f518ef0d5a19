//! From the text of a script to its statements.

use super::camera::{ScriptCamera, ScriptLens};
use crate::{
    Diagnostic, Diagnostics, FileId, Origin, Severity, Span,
    description::{Located, Step},
    obj::number_error,
    read::{Bounds, MAX_DEPTH, MAX_RECORDS, MAX_SIDE},
    text::{Cursor, NumberError, shown},
};
use etendue::{math::DVec3, render::MAX_SPP};
use std::ops::Range;

/// What a script says. Of statements that may stand once the last one counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// Light where rays leave the scene.
    pub ambient: Option<Located<[f64; 3]>>,
    /// In order.
    pub objects: Vec<ScriptObject>,
    /// As its moves have left it.
    pub camera: Option<Located<ScriptCamera>>,
    /// Samples per pixel.
    pub samples: Option<Located<PixelSampler>>,
    /// Recursion of rays.
    pub depth: Option<Located<u32>>,
    /// Width and height, pixels.
    pub size: Option<Located<[u32; 2]>>,
    /// Factors of the picture.
    pub filter: Option<Located<[f64; 3]>>,
    /// `intersectionTester`.
    pub tester: Option<Origin>,
    /// `threading`.
    pub threads: Option<Origin>,
    /// `writeRaw`.
    pub write_raw: Option<Origin>,
    /// `fromRaw`.
    pub from_raw: Option<Origin>,
}

/// `object`, or a list of objects, with the statements that move it.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptObject {
    /// As written.
    pub file: Located<String>,
    /// It is a script that lists objects; the last of them is moved.
    pub is_list: bool,
    /// In order.
    pub transform: Vec<Located<Step>>,
}

/// `pixelSampler`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelSampler {
    /// So many times so many.
    Stratified(u32),
    /// So many.
    LatinCube(u32),
}

impl PixelSampler {
    /// Samples per pixel.
    pub fn spp(self) -> u32 {
        match self {
            Self::Stratified(side) => side * side,
            Self::LatinCube(number) => number,
        }
    }
}

/// Reads a script, or a list of objects, that nothing but its bytes is needed for. Findings are told to `found`.
pub fn parse(bytes: &[u8], file: FileId, found: &mut Diagnostics) -> Script {
    let mut parser = Parser { cursor: Cursor::new(bytes), file, start: 0, script: Script::default(), found };
    while !parser.cursor.is_done() && !parser.found.is_full(Severity::Error) {
        parser.statement();
        parser.cursor.next_line();
    }
    parser.script
}

macro_rules! keys {
    ($($key:ident $name:literal),* $(,)?) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        enum Key { $($key),* }

        /// The keys of scripts, as they are usually written.
        pub const KEYS: &[&str] = &[$($name),*];

        impl Key {
            /// By its name, in any case.
            fn of(word: &[u8]) -> Option<Self> {
                const ALL: &[Key] = &[$(Key::$key),*];
                KEYS.iter().zip(ALL).find(|(name, _)| name.as_bytes().eq_ignore_ascii_case(word)).map(|(_, key)| *key)
            }
        }
    };
}
keys! {
    Ambient "ambient",
    Object "object",
    List "scene",
    Relocate "relocate",
    Scale "scale",
    Rotate "rotate",
    Camera "camera",
    Move "camera::move",
    PixelSampler "pixelSampler",
    Tester "intersectionTester",
    RaySampler "rayTraceSampler",
    Threading "threading",
    ImageSize "imageSize",
    Filter "filter",
    WriteRaw "writeRaw",
    FromRaw "fromRaw",
}

/// True if a word is a key of scripts.
pub fn is_key(word: &[u8]) -> bool {
    Key::of(word).is_some()
}

/// Distances that a camera is moved, and tangents of the angles that it is turned by.
const MOVE: Bounds = Bounds::within(-1e6, 1e6);
/// Lengths on the window.
const WINDOW: Bounds = Bounds::within(0.0, 1e6).above();
/// Factors of the picture.
const FACTOR: Bounds = Bounds::LIGHT;
/// Turns in units of pi.
const TURN: Bounds = Bounds::within(-5000.0, 5000.0);

struct Parser<'a> {
    cursor: Cursor<'a>,
    file: FileId,
    /// Where the statement begins.
    start: usize,
    script: Script,
    found: &'a mut Diagnostics,
}

impl Parser<'_> {
    fn statement(&mut self) {
        let word = self.cursor.word();
        let bytes = self.cursor.bytes;
        let name = &bytes[word.clone()];
        if name.is_empty() {
            return;
        }
        self.start = word.start;
        let Some(key) = Key::of(name) else {
            let name = shown(name);
            let warning = Diagnostic::warning(format!("unknown key `{name}` ignored")).at(Span::new(self.file, word));
            return self.found.push(warning.suggest(&name, KEYS.iter().copied()));
        };
        let done = match key {
            Key::Ambient => self.three(FACTOR).map(|value| self.script.ambient = Some(value)),
            Key::Filter => self.three(FACTOR).map(|value| self.script.filter = Some(value)),
            Key::Object | Key::List => return self.object(key == Key::List),
            Key::Relocate | Key::Scale | Key::Rotate => self.step(key),
            Key::Camera => self.camera(),
            Key::Move => self.move_camera(),
            Key::PixelSampler => self.pixel_sampler(),
            Key::RaySampler => self.ray_sampler(),
            Key::ImageSize => self.image_size(),
            Key::Tester => return self.script.tester = Some(self.whole_line()),
            Key::Threading => return self.script.threads = Some(self.whole_line()),
            Key::WriteRaw => return self.script.write_raw = Some(self.whole_line()),
            Key::FromRaw => return self.script.from_raw = Some(self.whole_line()),
        };
        if done.is_some() {
            self.nothing_more();
        }
    }

    /// Says so if the line goes on.
    fn nothing_more(&mut self) {
        let end = self.cursor.at;
        let word = self.cursor.word();
        if !word.is_empty() {
            let key = shown(self.key(end));
            let warning = Diagnostic::warning(format!("`{key}` takes no more: the rest of the line is ignored"));
            self.found.push(warning.at(Span::new(self.file, word)));
        }
    }

    /// The first word of the statement.
    fn key(&self, end: usize) -> &[u8] {
        let statement = &self.cursor.bytes[self.start..end];
        statement.split(|b| b.is_ascii_whitespace()).next().unwrap_or_default()
    }

    /// The statement as far as it has been read.
    fn place(&self) -> Origin {
        Span::new(self.file, self.start..self.cursor.at).into()
    }

    fn located<T>(&self, value: T) -> Located<T> {
        Located { value, origin: self.place() }
    }

    fn whole_line(&mut self) -> Origin {
        while !self.cursor.word().is_empty() {}
        Span::new(self.file, self.start..self.cursor.bytes[..self.cursor.at].trim_ascii_end().len()).into()
    }

    fn error<T>(&mut self, place: Range<usize>, message: impl Into<String>, label: impl Into<String>) -> Option<T> {
        self.found.push(Diagnostic::error(message).at(Span::new(self.file, place)).label(label));
        None
    }

    fn number(&mut self, what: &str, bounds: Bounds) -> Option<f64> {
        self.cursor.skip_blanks();
        let here = self.cursor.here();
        match self.cursor.number() {
            Ok(value) if bounds.holds(value) => Some(value),
            Ok(value) => self.error(here, format!("{what} is out of range: {value}"), format!("must be {bounds}")),
            Err(error) => {
                // What is missing is missing after the last word.
                let end = self.cursor.bytes[..here.start].trim_ascii_end().len().max(self.start);
                let here = if error == NumberError::Missing { end..end } else { here };
                let word = shown(&self.cursor.bytes[here.clone()]);
                self.found.push(number_error(error, &word, what).at(Span::new(self.file, here)));
                None
            }
        }
    }

    fn integer(&mut self, what: &str, low: u32, high: u32) -> Option<u32> {
        self.cursor.skip_blanks();
        let here = self.cursor.here();
        let value = self.number(what, Bounds::within(low.into(), high.into()))?;
        if value != libm::trunc(value) {
            return self.error(here, format!("{what} is not a whole number: {value}"), "expected a whole number");
        }
        Some(value as u32)
    }

    fn numbers<const N: usize>(&mut self, what: [&str; N], bounds: Bounds) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for (value, what) in values.iter_mut().zip(what) {
            *value = self.number(what, bounds)?;
        }
        Some(values)
    }

    fn three(&mut self, bounds: Bounds) -> Option<Located<[f64; 3]>> {
        let value = self.numbers(["red", "green", "blue"], bounds)?;
        Some(self.located(value))
    }

    fn point(&mut self) -> Option<DVec3> {
        self.numbers(["x", "y", "z"], Bounds::COORDINATE).map(DVec3::from_array)
    }

    /// True if the line has another word.
    fn has_more(&mut self) -> bool {
        self.cursor.skip_blanks();
        !self.cursor.at_line_end()
    }

    fn object(&mut self, is_list: bool) {
        self.cursor.skip_blanks();
        if self.cursor.at_line_end() {
            self.error::<()>(self.start..self.cursor.at, "the name of a file is missing", "expected a file");
            return;
        }
        let rest = self.cursor.name();
        let bytes = self.cursor.bytes;
        // Names may hold blanks, but no word that begins with `#`.
        let comment = bytes[rest.clone()].windows(2).position(|pair| pair[0].is_ascii_whitespace() && pair[1] == b'#');
        let end = rest.start + comment.unwrap_or(rest.len());
        let name = bytes[rest.start..end].trim_ascii_end();
        let place = rest.start..rest.start + name.len();
        if self.script.objects.len() == MAX_RECORDS {
            self.error::<()>(place, format!("more than {MAX_RECORDS} objects"), "too many");
            return;
        }
        let value = String::from_utf8_lossy(name).into_owned();
        let file = Located { value, origin: Span::new(self.file, place).into() };
        self.script.objects.push(ScriptObject { file, is_list, transform: Vec::new() });
    }

    fn step(&mut self, key: Key) -> Option<()> {
        let step = match key {
            Key::Relocate => Step::Relocate(self.point()?),
            Key::Scale => Step::Scale(DVec3::splat(self.factor()?)),
            _ => self.rotation()?,
        };
        let step = self.located(step);
        let Some(object) = self.script.objects.last_mut() else {
            let error = Diagnostic::error("there is no object yet to be moved").at(step.origin);
            self.found.push(error.help("it acts on the `object` before it"));
            return None;
        };
        object.transform.push(step);
        Some(())
    }

    fn factor(&mut self) -> Option<f64> {
        self.cursor.skip_blanks();
        let here = self.cursor.here();
        let factor = self.number("the factor", Bounds::COORDINATE)?;
        if factor.abs() < 1e-12 {
            return self.error(here, "a scale of 0 flattens the object", "expected a factor other than 0");
        }
        Some(factor)
    }

    /// Right-handed about x and z, and the other way about y: it turned the first of the two other axes to the second.
    fn rotation(&mut self) -> Option<Step> {
        let axis = self.integer("the axis", 0, 2)?;
        let angle = 180.0 * self.number("the angle", TURN)?;
        Some(match axis {
            0 => Step::Rotate { axis: DVec3::X, angle },
            1 => Step::Rotate { axis: DVec3::Y, angle: -angle },
            _ => Step::Rotate { axis: DVec3::Z, angle },
        })
    }

    fn camera(&mut self) -> Option<()> {
        let position = self.point()?;
        let (direction, up) = (self.point()?, self.point()?);
        let view = self.cursor.at;
        let distance = self.number("the distance of the window", WINDOW)?;
        let window = self.numbers(["the width of the window", "the height of the window"], WINDOW)?;
        let step = self.number("the step", WINDOW)?;
        let Some(mut camera) = ScriptCamera::new(position, direction, up, distance, window, step) else {
            let label = "expected two directions across each other";
            return self.error(self.start..view, "direction or up is zero, or they are parallel", label);
        };
        if self.has_more() {
            camera.lens = self.lens(distance)?;
        }
        self.script.camera = Some(self.located(camera));
        Some(())
    }

    fn lens(&mut self, distance: f64) -> Option<Option<ScriptLens>> {
        let here = self.cursor.here();
        let focus = self.number("the focal plane", WINDOW)?;
        let aperture = self.number("the aperture", Bounds::within(0.0, 1e6))?;
        if focus <= distance * (1.0 + 1e-6) {
            let label = format!("must be beyond the window at {distance}");
            return self.error(here, "the focal plane lies before the window", label);
        }
        Some((aperture > 0.0).then_some(ScriptLens { focus, aperture }))
    }

    fn move_camera(&mut self) -> Option<()> {
        type Turn = fn(&mut ScriptCamera, f64);
        const TURNS: [(&str, Turn); 4] = [
            ("zoomIn", ScriptCamera::zoom_in),
            ("tiltUp", ScriptCamera::tilt_up),
            ("tiltRight", ScriptCamera::tilt_right),
            ("rotate", ScriptCamera::rotate),
        ];
        let mut ahead = self.cursor.clone();
        let word = ahead.word();
        let name = &self.cursor.bytes[word.clone()];
        let turn = TURNS.iter().find(|(known, _)| known.as_bytes().eq_ignore_ascii_case(name));
        let by = match turn {
            Some(_) => {
                self.cursor = ahead;
                [self.number("how far", MOVE)?, 0.0, 0.0]
            }
            None if name.first().is_some_and(u8::is_ascii_alphabetic) => {
                let error = Diagnostic::error(format!("the camera cannot `{}`", shown(name)));
                let error = error.at(Span::new(self.file, word)).label("expected zoomIn, tiltUp, tiltRight or rotate");
                self.found.push(error.suggest(&shown(name), TURNS.iter().map(|(name, _)| *name)));
                return None;
            }
            None => self.numbers(["forward", "right", "up"], MOVE)?,
        };
        let place = self.start..self.cursor.at;
        let Some(camera) = &mut self.script.camera else {
            return self.error(place, "there is no camera yet to be moved", "expected after `camera`");
        };
        match turn {
            Some((_, turn)) => turn(&mut camera.value, by[0]),
            None => camera.value.shift(by),
        }
        if !camera.value.is_sound() {
            return self.error(place, "the camera is turned until its view and up are parallel", "turn it less");
        }
        Some(())
    }

    fn pixel_sampler(&mut self) -> Option<()> {
        const KINDS: [&str; 2] = ["Stratified", "LatinCube"];
        let word = self.cursor.word();
        let name = &self.cursor.bytes[word.clone()];
        let kind = KINDS.iter().position(|kind| kind.as_bytes().eq_ignore_ascii_case(name));
        let Some(kind) = kind else {
            let error = Diagnostic::error(format!("`{}` is no sampler of pixels", shown(name)));
            let error = error.at(Span::new(self.file, word)).label("expected Stratified or LatinCube");
            self.found.push(error.suggest(&shown(name), KINDS));
            return None;
        };
        let most = if kind == 0 { MAX_SPP.isqrt() } else { MAX_SPP };
        let number = self.integer("the number of samples", 1, most)?;
        let sampler = if kind == 0 { PixelSampler::Stratified(number) } else { PixelSampler::LatinCube(number) };
        self.script.samples = Some(self.located(sampler));
        Some(())
    }

    /// A sampler's name, which has no meaning here, the depth, and the number of samples of a reflection, which has none.
    fn ray_sampler(&mut self) -> Option<()> {
        self.cursor.word();
        let depth = self.integer("the depth", 1, MAX_DEPTH - 1)?;
        if self.has_more() {
            self.number("the size", Bounds::within(0.0, 1e9))?;
        }
        self.script.depth = Some(self.located(depth));
        Some(())
    }

    fn image_size(&mut self) -> Option<()> {
        let size = [self.integer("the width", 1, MAX_SIDE)?, self.integer("the height", 1, MAX_SIDE)?];
        self.script.size = Some(self.located(size));
        Some(())
    }
}
