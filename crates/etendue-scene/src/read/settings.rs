//! Camera, film, sampler, integrator, accelerator.

use super::{
    fields::{Fields, Item},
    keys,
    values::Bounds,
};
use crate::{
    Origin,
    description::{
        Angle, ApertureRecord, CameraRecord, FilmRecord, Focus, FovAxis, IntegratorRecord, Lens, Located,
        SamplerRecord, View,
    },
    value::Data,
};
use etendue::{
    camera::MAX_BLADES,
    film::Aov,
    integrator::{Integrator, MAX_PARTS},
    math::DVec3,
    render::MAX_SPP,
    sampling::{Filter, Sampler},
    tonemap::{DisplayTransform, Encoding, ToneCurve},
};
use etendue_accel::{AcceleratorKind, KdTreeSplit};

/// Longest side of a picture, pixels.
pub const MAX_SIDE: u32 = 1 << 16;
/// Longest depth limit.
pub const MAX_DEPTH: u32 = 1 << 20;
const DEFAULT_FOV: f64 = 40.0;
/// Width of 35 mm film, millimetres.
const DEFAULT_SENSOR: f64 = 36.0;
const DEFAULT_BLADES: u32 = 6;
/// Focal lengths and sensors.
const MILLIMETRES: Bounds = Bounds::within(0.0, 1e6).above();
/// Angles of rotation, degrees.
const TURN: Bounds = Bounds::within(-1e6, 1e6);

/// What stands in for a camera that could not be read; an error has been reported.
pub fn any_camera(origin: &Origin) -> CameraRecord {
    CameraRecord {
        position: DVec3::ZERO,
        view: View::Direction(DVec3::NEG_Z),
        up: DVec3::Y,
        roll: 0.0,
        near_clip: 0.0,
        lens: Lens::Orthographic { height: 1.0 },
        origin: origin.clone(),
    }
}

/// The fields of a section that may be absent as a whole.
pub(super) fn section<'a>(file: &Fields<'a>, key: &str, section: &'static keys::Section) -> Option<Fields<'a>> {
    file.read(key, |item| item.table(section, &format!("[{key}]")))
}

/// `[camera]`.
pub fn camera(item: Item) -> Option<CameraRecord> {
    let mut fields = item.table(&keys::CAMERA, "[camera]")?;
    let origin = fields.origin.clone();
    let kind = fields.variant("type", &[("perspective", false), ("orthographic", true)], Some("perspective"));
    let position = fields.need("position", |i| i.point());
    let view = view(&fields, position);
    let up = fields.read("up", |i| i.direction()).unwrap_or(DVec3::Y);
    let roll = fields.read("roll", |i| i.number(TURN)).unwrap_or(0.0);
    let near_clip = fields.read("near_clip", |i| i.number(Bounds::LENGTH_OR_ZERO)).unwrap_or(0.0);
    let lens = match kind {
        Some(true) => fields.need("height", |i| i.number(Bounds::LENGTH)).map(|height| Lens::Orthographic { height }),
        Some(false) => Some(perspective(&fields, view)),
        None => None,
    };
    if let (Some(v), Some(p)) = (view, position) {
        let direction = match v {
            View::LookAt(target) => target - p,
            View::Direction(d) => d,
        };
        let parallel = direction.normalize_or_zero().cross(up.normalize()).length() < 1e-9;
        if parallel && direction != DVec3::ZERO {
            let place = fields.get("up").map_or(item, |i| i);
            place.error::<()>("`up` is parallel to the view direction", "give an `up` across the view");
        }
    }
    fields.finish();
    Some(CameraRecord { position: position?, view: view?, up, roll, near_clip, lens: lens?, origin })
}

fn view(fields: &Fields, position: Option<DVec3>) -> Option<View> {
    fields.exclusive("look_at", "direction");
    let direction = fields.read("direction", |i| i.direction());
    let Some(item) = fields.get("look_at") else {
        if fields.get("direction").is_none() {
            fields.lacks("`look_at` or `direction`");
        }
        return direction.map(View::Direction);
    };
    let target = item.point()?;
    if Some(target) == position {
        return item.error("`look_at` is the camera's own position", "expected another point");
    }
    Some(View::LookAt(target))
}

fn perspective(fields: &Fields, view: Option<View>) -> Lens {
    let focal_length = fields.read("focal_length", |i| i.number(MILLIMETRES));
    for key in ["sensor", "f_number"] {
        if fields.get(key).is_some() && fields.get("focal_length").is_none() {
            fields.lacks(&format!("`focal_length` for its `{key}`"));
        }
    }
    fields.exclusive("lens_radius", "f_number");
    let f_number = fields.read("f_number", |i| i.number(Bounds::within(0.01, 1e6)));
    let radius = match (fields.read("lens_radius", |i| i.number(Bounds::LENGTH_OR_ZERO)), f_number, focal_length) {
        (Some(radius), ..) => radius,
        (None, Some(number), Some(length)) => 0.5e-3 * length / number,
        _ => 0.0,
    };
    let focus = focus(fields);
    if radius > 0.0 && matches!((&focus, view), (Focus::Target, Some(View::Direction(_)))) {
        let lacks = FOCUS.iter().all(|key| fields.get(key).is_none());
        if lacks {
            let choices = "`focus_distance`, `focus_point` or `focus_object`";
            fields.lacks(&format!("{choices} for its lens, or `look_at` instead of `direction`"));
        }
    }
    Lens::Perspective { angle: angle(fields, focal_length), radius, aperture: aperture(fields), focus }
}

fn angle(fields: &Fields, focal_length: Option<f64>) -> Angle {
    const AXES: [(&str, FovAxis); 4] =
        [("x", FovAxis::X), ("y", FovAxis::Y), ("smaller", FovAxis::Smaller), ("larger", FovAxis::Larger)];
    fields.exclusive("focal_length", "fov");
    fields.exclusive("focal_length", "fov_axis");
    let fov = fields.read("fov", |i| i.number(Bounds::within(0.0, 180.0).above().below())).unwrap_or(DEFAULT_FOV);
    let axis = fields.read("fov_axis", |i| i.choice(&AXES)).unwrap_or(FovAxis::X);
    let sensor = fields.read("sensor", |i| match i.value.data {
        Data::Array(_) => i.numbers(MILLIMETRES).map(|[width, height]| (width, Some(height))),
        _ => i.number(MILLIMETRES).map(|width| (width, None)),
    });
    let (width, height) = sensor.unwrap_or((DEFAULT_SENSOR, None));
    focal_length.map_or(Angle::Field { fov, axis }, |length| Angle::Focal { length, width, height })
}

fn aperture(fields: &Fields) -> ApertureRecord {
    let kinds = [("round", 0), ("square", 1), ("polygon", 2)];
    let kind = fields.read("aperture", |i| i.choice(&kinds)).unwrap_or(0);
    let blades = fields.read("blades", |i| i.integer_u32(3, MAX_BLADES)).unwrap_or(DEFAULT_BLADES);
    let rotation = fields.read("aperture_rotation", |i| i.number(TURN)).unwrap_or(0.0);
    let unused = |key: &str, of: &str| {
        if let Some(item) = fields.get(key) {
            item.error::<()>(format!("`{key}` belongs to {of}"), format!("leave it out, or set `aperture` to {of}"));
        }
    };
    match kind {
        0 => {
            unused("blades", "`polygon`");
            unused("aperture_rotation", "`square` or `polygon`");
            ApertureRecord::Round
        }
        1 => {
            unused("blades", "`polygon`");
            ApertureRecord::Square { rotation }
        }
        _ => ApertureRecord::Polygon { blades, rotation },
    }
}

/// The keys that say what a lens is focused on.
const FOCUS: [&str; 3] = ["focus_distance", "focus_point", "focus_object"];

fn focus(fields: &Fields) -> Focus {
    for (i, first) in FOCUS.into_iter().enumerate() {
        FOCUS[i + 1..].iter().for_each(|second| fields.exclusive(first, second));
    }
    let distance = fields.read("focus_distance", |i| i.number(Bounds::LENGTH)).map(Focus::Distance);
    let point = fields
        .read("focus_point", |i| Some(Located { value: i.point()?, origin: i.value.origin.clone() }))
        .map(Focus::Point);
    let object = fields
        .read("focus_object", |i| Some(Located { value: i.name_text()?.to_owned(), origin: i.value.origin.clone() }))
        .map(Focus::Object);
    distance.or(point).or(object).unwrap_or(Focus::Target)
}

/// `[film]`.
pub fn film(file: &Fields) -> FilmRecord {
    let mut film = FilmRecord {
        size: [512, 512],
        crop: None,
        filter: Filter::default(),
        display: DisplayTransform::default(),
        aovs: Vec::new(),
        transparent: false,
    };
    let Some(fields) = section(file, "film", &keys::FILM) else { return film };
    let side = |i: Item| i.integer_u32(1, MAX_SIDE);
    let size = fields.read("size", |i| i.fixed("an array of 2 whole numbers", side));
    film.size = size.unwrap_or(film.size);
    film.crop = fields.read("crop", |i| crop(i, film.size));
    film.filter = fields.read("filter", filter).unwrap_or(film.filter);
    film.display = display(&fields);
    film.aovs = fields.read("aovs", aovs).unwrap_or_default();
    film.transparent = fields.read("transparent", |i| i.boolean()).unwrap_or(film.transparent);
    fields.finish();
    film
}

/// How the picture becomes 8 bits.
fn display(fields: &Fields) -> DisplayTransform {
    let default = DisplayTransform::default();
    let curves = ToneCurve::ALL.map(|t| (t.name(), t));
    let encodings = Encoding::ALL.map(|e| (e.name(), e));
    DisplayTransform {
        exposure: fields.read("exposure", |i| i.number_f32(Bounds::within(-64.0, 64.0))).unwrap_or(default.exposure),
        balance: fields.read("balance", |i| i.colour(Bounds::LIGHT)).unwrap_or(default.balance),
        curve: fields.read("tonemap", |i| i.choice(&curves)).unwrap_or(default.curve),
        encoding: fields.read("encoding", |i| i.choice(&encodings)).unwrap_or(default.encoding),
    }
}

fn crop(item: Item, [width, height]: [u32; 2]) -> Option<Located<[u32; 4]>> {
    let value: [u32; 4] = item.fixed("[x0, y0, x1, y1], whole numbers", |i| i.integer_u32(0, MAX_SIDE))?;
    let [x0, y0, x1, y1] = value;
    if x0 >= x1 || y0 >= y1 || x1 > width || y1 > height {
        return item.error("`crop` is empty or leaves the picture", format!("the picture is {width} x {height}"));
    }
    Some(Located { value, origin: item.value.origin.clone() })
}

fn filter(item: Item) -> Option<Filter> {
    let kinds = Filter::ALL.map(|f| (f.name(), f));
    if let Data::String(_) = item.value.data {
        return item.choice(&kinds);
    }
    let mut fields = item.table(&keys::FILTER, "a name such as `gaussian`, or { type = \"gaussian\", sigma = 0.5 }")?;
    let mut filter = fields.variant("type", &kinds, None);
    let length = |key: &str, value: &mut f32| {
        *value = fields.read(key, |i| i.number_f32(Bounds::within(0.01, 16.0))).unwrap_or(*value);
    };
    let share = |key: &str, value: &mut f32| {
        *value = fields.read(key, |i| i.number_f32(Bounds::UNIT)).unwrap_or(*value);
    };
    match &mut filter {
        Some(Filter::Box { radius } | Filter::Tent { radius } | Filter::Lanczos { radius }) => length("radius", radius),
        Some(Filter::Gaussian { sigma, radius }) => {
            length("sigma", sigma);
            length("radius", radius);
        }
        Some(Filter::Mitchell { b, c, radius }) => {
            share("b", b);
            share("c", c);
            length("radius", radius);
        }
        None => {}
    }
    fields.finish();
    filter
}

fn aovs(item: Item) -> Option<Vec<Aov>> {
    let choices = Aov::ALL.map(|a| (a.name(), a));
    let mut aovs = Vec::new();
    for layer in item.array("an array of names")? {
        if let Some(aov) = layer.choice(&choices) {
            if aovs.contains(&aov) {
                layer.error::<()>(format!("layer `{}` is named twice", aov.name()), "keep one of them");
            } else {
                aovs.push(aov);
            }
        }
    }
    Some(aovs)
}

/// `[sampler]`.
pub fn sampler(file: &Fields) -> SamplerRecord {
    let mut record = SamplerRecord { sampler: Sampler::Sobol, spp: 64, seed: 0 };
    let Some(mut fields) = section(file, "sampler", &keys::SAMPLER) else { return record };
    let kinds = Sampler::ALL.map(|s| (s.name(), s));
    record.sampler = fields.variant("type", &kinds, Some("sobol")).unwrap_or(record.sampler);
    record.spp = fields.read("spp", |i| i.integer_u32(1, MAX_SPP)).unwrap_or(record.spp);
    record.seed = fields.read("seed", |i| i.integer(0, i64::MAX)).map_or(record.seed, |s| s as u64);
    fields.finish();
    record
}

/// `[integrator]`.
pub fn integrator(file: &Fields) -> IntegratorRecord {
    let mut record = IntegratorRecord { integrator: Integrator::Path, depth: None, splitting: Some(1) };
    let Some(mut fields) = section(file, "integrator", &keys::INTEGRATOR) else { return record };
    let kinds = Integrator::ALL.map(|i| (i.name(), i));
    record.integrator = fields.variant("type", &kinds, Some("path")).unwrap_or(record.integrator);
    match &mut record.integrator {
        Integrator::Ao { distance } => *distance = fields.read("distance", |i| i.number_f32(Bounds::LENGTH)),
        Integrator::Path | Integrator::LightSplit | Integrator::Brute => {
            record.depth = fields.read("depth", |i| i.integer_u32(1, MAX_DEPTH));
            record.splitting = fields.read("splitting", |i| splitting(&i)).unwrap_or(record.splitting);
        }
        Integrator::Normal | Integrator::Uv | Integrator::Depth | Integrator::Ids => {}
    }
    fields.finish();
    record
}

/// Parts of a sample; the inner `None` for `"auto"`.
fn splitting(item: &Item) -> Option<Option<u32>> {
    if let Data::String(_) = item.value.data {
        item.choice(&[("auto", None)])
    } else {
        item.integer_u32(1, MAX_PARTS).map(Some)
    }
}

/// `[accelerator]`.
pub fn accelerator(file: &Fields) -> AcceleratorKind {
    let mut kind = AcceleratorKind::Bvh;
    let Some(mut fields) = section(file, "accelerator", &keys::ACCELERATOR) else { return kind };
    let kinds = [
        ("bvh", AcceleratorKind::Bvh),
        ("kdtree", AcceleratorKind::KdTree(KdTreeSplit::SurfaceArea)),
        ("brute", AcceleratorKind::Brute),
    ];
    kind = fields.variant("type", &kinds, Some("bvh")).unwrap_or(kind);
    if let AcceleratorKind::KdTree(split) = &mut kind {
        let splits = [("sah", KdTreeSplit::SurfaceArea), ("midpoint", KdTreeSplit::Midpoint)];
        *split = fields.read("split", |i| i.choice(&splits)).unwrap_or(*split);
    }
    fields.finish();
    kind
}
