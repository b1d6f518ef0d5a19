//! The automatic scene of a model: a picture of a mesh file that one would show, without a scene file.
//!
//! It is made as the text of a scene file. That text is what `etendue scene` writes, and what rendering a model reads, so that
//! both are the same scene.

mod light;
mod material;
mod survey;
mod view;

use crate::{
    description::UpAxis,
    mesh_file::MeshFile,
    write_toml::{number, rounded_vector, text, vector},
};
use etendue::math::{DMat3, DVec3};
pub use light::brightness;
pub use material::ModelMaterial;
use std::path::{Path, PathBuf};
use survey::{Model, Survey};
pub use view::ModelView;
use view::{Room, Stand};

/// An equirectangular image that lights the model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelEnvironment {
    /// File name as the scene file will have it.
    pub file: PathBuf,
    /// Irradiance that a ground below it receives, divided by pi: how bright it is.
    pub brightness: f64,
}

/// What a model is made of, instead of its own materials.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelSurface {
    /// A material by name.
    Material(ModelMaterial),
    /// Matt, coloured by a picture on the model's texture coordinates; its file name as the scene file will have it.
    Picture(PathBuf),
}

/// What an automatic scene may be asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelOptions {
    /// File name of the model as the scene file will have it.
    pub file: PathBuf,
    /// Light; absent: a soft sky and a lamp, or what the model itself emits.
    pub environment: Option<ModelEnvironment>,
    /// Up in the model.
    pub up: UpAxis,
    /// Whether it stands on a ground; a model that lights itself has none.
    pub ground: bool,
    /// Nothing but the model shows; implies no ground.
    pub transparent: bool,
    /// Where it is looked at from; absent: chosen by what the model is.
    pub view: Option<ModelView>,
    /// Replaces the model's own materials; absent: those, or clay.
    pub surface: Option<ModelSurface>,
    /// Width and height of the picture, pixels; absent: chosen.
    pub size: Option<[u32; 2]>,
}

/// Models that cannot be looked at.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// No faces and no spheres.
    #[error("the model has no faces: there is nothing to look at")]
    Empty,
    /// All faces are points or lines.
    #[error("the faces of the model have no area: there is nothing to look at")]
    NoArea,
    /// A picture is to be laid on, but nothing says where.
    #[error("the model has no texture coordinates for the picture to lie on")]
    NoCoordinates,
    /// Too far apart for single precision, or too far away.
    #[error("the model is too large or too far from its origin: it reaches to {0:e}")]
    TooFar(f64),
    /// A file name that TOML cannot hold.
    #[error("the file name {0:?} is not UTF-8, and a scene file cannot name it; rename the file")]
    Name(PathBuf),
}

/// Default size of the picture: its area and, where the view does not ask for another shape, its width and height.
const SIZE: [u32; 2] = [800, 600];

/// The text of the scene file of a model, in TOML.
///
/// # Errors
/// [`ModelError`] if there is nothing to see.
pub fn model_scene(mesh: &MeshFile, options: &ModelOptions) -> Result<String, ModelError> {
    if mesh.mesh.indices.is_empty() && mesh.spheres.is_empty() {
        return Err(ModelError::Empty);
    }
    if matches!(options.surface, Some(ModelSurface::Picture(_))) && mesh.mesh.uvs.is_none() {
        return Err(ModelError::NoCoordinates);
    }
    let upright = match options.up {
        UpAxis::Y => DMat3::IDENTITY,
        UpAxis::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
    };
    let model = Model::new(mesh, upright);
    let scale = scale(&model)?;
    let model = model.scaled(scale);
    let survey = model.survey(options.surface.is_none());
    if survey.area <= 0.0 || survey.size().length() <= 0.0 {
        return Err(ModelError::NoArea);
    }
    let scene = Plan::new(&model, &survey, mesh, options);
    scene.write(scale)
}

/// The text of the least scene file that reads a model: for a look at what the model holds.
///
/// # Errors
/// [`ModelError::Name`].
pub fn bare(model: &Path) -> Result<String, ModelError> {
    let file = text(name(model)?);
    Ok(format!("camera = {{ position = [0, 0, 1], look_at = [0, 0, 0] }}\n[[objects]]\nfile = {file}\n"))
}

/// A power of ten that brings models of the size of galaxies or molecules to where single precision can work on them: 1 for
/// all others.
fn scale(model: &Model) -> Result<f64, ModelError> {
    const LARGEST: f64 = 1e10;
    const SMALLEST: f64 = 1e-9;
    let reach = model.reach(&[DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z]);
    let farthest = reach.iter().fold(0.0, |far: f64, r| far.max(r.abs()));
    let size = (0..3).map(|axis| reach[axis] + reach[axis + 3]).fold(0.0, f64::max);
    if size <= 0.0 {
        return Err(ModelError::NoArea);
    }
    if farthest < LARGEST && size > SMALLEST {
        return Ok(1.0);
    }
    let scale = libm::pow(10.0, -libm::floor(libm::log10(size)));
    let usable = scale.is_finite() && (1e-17..1e17).contains(&scale) && farthest * scale < LARGEST;
    if usable { Ok(scale) } else { Err(ModelError::TooFar(farthest)) }
}

/// A power of ten as factors that a scene file takes, which refuses such as could be meant to be 0.
fn scale_steps(scale: f64) -> Vec<f64> {
    const STEP: f64 = 1e10;
    let mut steps = Vec::new();
    let mut left = scale;
    while left < 1.0 / STEP {
        steps.push(1.0 / STEP);
        left *= STEP;
    }
    // Rounding of the products must not show in the file.
    let left = libm::pow(10.0, libm::round(libm::log10(left)));
    if left != 1.0 {
        steps.push(left);
    }
    steps
}

/// What is decided about a scene.
struct Plan<'a> {
    survey: &'a Survey,
    options: &'a ModelOptions,
    size: [u32; 2],
    stand: Stand,
    /// The model emits, and nothing else was asked to light it.
    lights_itself: bool,
    surface: Option<ModelSurface>,
    /// Faces without normals, which may be smoothed.
    is_faceted: bool,
    faces: usize,
}

impl<'a> Plan<'a> {
    fn new(model: &Model, survey: &'a Survey, mesh: &MeshFile, options: &'a ModelOptions) -> Self {
        let default = ModelSurface::Material(ModelMaterial::DEFAULT);
        let emits = survey.emitted > 0.0;
        let room = if emits { Room::of(survey) } else { Room::No };
        let aspect = if options.view.is_none() { room.aspect(survey) } else { None };
        let size = options.size.unwrap_or_else(|| aspect.map_or(SIZE, size_of_aspect));
        Self {
            survey,
            options,
            size,
            stand: view::stand(model, survey, options.view, room, size),
            lights_itself: emits && options.environment.is_none(),
            surface: options.surface.clone().or(mesh.materials.is_empty().then_some(default)),
            is_faceted: mesh.mesh.normals.is_none() && !mesh.mesh.indices.is_empty(),
            faces: mesh.mesh.indices.len() + mesh.spheres.len(),
        }
    }

    fn has_ground(&self) -> bool {
        let wanted = self.options.ground && !self.options.transparent && self.survey.emitted == 0.0;
        // Seen from below, a ground would hide the model.
        wanted && self.stand.back.y > -0.01
    }

    fn write(&self, scale: f64) -> Result<String, ModelError> {
        let mut parts = vec![self.head()?, self.camera(), self.film()];
        parts.push("[sampler]\nspp = 64\n".to_owned());
        parts.extend(self.environment()?);
        parts.push(self.model(scale)?);
        if self.has_ground() {
            parts.push(light::ground(self.survey));
        }
        if !self.lights_itself && self.options.environment.is_none() {
            parts.push(light::lamp(self.survey, &self.stand));
        }
        Ok(parts.join("\n"))
    }

    fn head(&self) -> Result<String, ModelError> {
        let [low, high] = self.survey.bounds;
        let digits = |p| vector(rounded_vector(p, self.survey.size().length()));
        Ok(format!(
            "# The automatic scene of {}: what `etendue render` shows of that file alone. Edit it as you like;\n\
             # the manual of scene files tells every key. Lengths are the model's own.\n\
             # The model has {} faces, from {} to {}, {} up.\n",
            text(name(&self.options.file)?),
            self.faces,
            digits(low),
            digits(high),
            self.options.up.name(),
        ))
    }

    fn camera(&self) -> String {
        let Stand { position, target, fov, up, words, .. } = self.stand;
        let size = self.survey.size().length();
        let up = if up == DVec3::Y { String::new() } else { format!("up = {}\n", vector(up)) };
        format!(
            "# {words}\n[camera]\nposition = {}\nlook_at = {}\n{up}fov = {}\nfov_axis = \"larger\"\n",
            vector(rounded_vector(position, size)),
            vector(rounded_vector(target, size)),
            number(fov),
        )
    }

    fn film(&self) -> String {
        let [width, height] = self.size;
        let mut film = format!("[film]\nsize = [{width}, {height}]\n");
        let exposure = match (&self.options.environment, self.lights_itself) {
            (Some(environment), _) => light::stops(0.6 / environment.brightness),
            (None, true) => light::own_exposure(self.survey),
            (None, false) => 0.0,
        };
        film += &format!("exposure = {} # stops: more is brighter\n", number(exposure));
        if self.options.transparent {
            film += "transparent = true\n";
        }
        film
    }

    fn environment(&self) -> Result<Option<String>, ModelError> {
        Ok(match &self.options.environment {
            Some(environment) => Some(format!(
                "[environment]\ntype = \"image\"\nimage = {}\nrotation = 0 # degrees about the vertical\n",
                text(name(&environment.file)?)
            )),
            None if self.lights_itself => None,
            None => Some(light::sky(self.has_ground())),
        })
    }

    fn model(&self, scale: f64) -> Result<String, ModelError> {
        let mut lines = String::new();
        let keys = match &self.surface {
            None => None,
            Some(ModelSurface::Material(material)) => Some(material.keys()),
            Some(ModelSurface::Picture(file)) => {
                Some(format!("type = \"diffuse\"\nreflectance = {{ file = {} }}", text(name(file)?)))
            }
        };
        if let Some(keys) = &keys {
            lines += &format!("[materials.model]\n{keys}\n\n");
        }
        lines += &format!("[[objects]]\nname = \"model\"\nfile = {}\n", text(name(&self.options.file)?));
        if keys.is_some() {
            lines += "material = \"model\"\n";
        }
        if self.is_faceted {
            lines += "crease_angle = 30 # the file has no normals: smooth where faces meet at less than this\n";
        }
        let mut steps = Vec::new();
        steps.extend(scale_steps(scale).into_iter().map(|step| format!("{{ scale = {} }}", number(step))));
        if self.options.up == UpAxis::Z {
            steps.push("{ rotate = { axis = \"x\", angle = -90 } }".to_owned());
        }
        if !steps.is_empty() {
            lines += &format!("transform = [{}]\n", steps.join(", "));
        }
        Ok(lines)
    }
}

/// A size of about the default's area.
fn size_of_aspect(aspect: f64) -> [u32; 2] {
    let aspect = aspect.clamp(0.5, 2.0);
    let height = libm::sqrt(f64::from(SIZE[0] * SIZE[1]) / aspect);
    // Even numbers, as videos want them.
    [height * aspect, height].map(|side| 2 * libm::round(side / 2.0) as u32)
}

fn name(path: &Path) -> Result<&str, ModelError> {
    path.to_str().ok_or_else(|| ModelError::Name(path.to_owned()))
}
