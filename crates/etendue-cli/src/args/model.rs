//! How a model is shown that comes without a scene file.

use super::{names, parse_size};
use clap::{
    Arg, Args, Command,
    builder::{PossibleValue, TypedValueParser},
    error::ErrorKind,
};
use etendue_scene::{
    description::UpAxis,
    model_scene::{ModelMaterial, ModelSurface, ModelView},
};
use std::{ffi::OsStr, path::PathBuf};

/// Options of the automatic scene.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Without a scene file")]
pub struct ModelArgs {
    /// Light the model by this equirectangular picture (.hdr, .exr) instead of a soft sky and a lamp
    #[arg(long, value_name = "FILE")]
    pub env: Option<PathBuf>,

    /// Axis of the model that points up [default: y]; much of what comes from CAD wants z
    #[arg(long, value_name = "AXIS", value_parser = names(&UpAxis::ALL, UpAxis::name))]
    pub up: Option<UpAxis>,

    /// No ground below the model
    #[arg(long)]
    pub no_ground: bool,

    /// Where the model is seen from [default: iso; a flat model from its front, a room through its open side]
    #[arg(long, value_name = "VIEW", value_parser = names(&ModelView::ALL, ModelView::name))]
    pub view: Option<ModelView>,

    /// Make the model of this, whatever its own materials are; or lay on a picture (.png, .jpg, ...) by its texture coordinates
    #[arg(long, value_name = "M", value_parser = SurfaceParser)]
    pub material: Option<ModelSurface>,
}

impl ModelArgs {
    /// The first option given, as it is spelt.
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--env", self.env.is_some()),
            ("--up", self.up.is_some()),
            ("--no-ground", self.no_ground),
            ("--view", self.view.is_some()),
            ("--material", self.material.is_some()),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }
}

/// Names of materials, and of picture files.
#[derive(Clone)]
struct SurfaceParser;

impl TypedValueParser for SurfaceParser {
    type Value = ModelSurface;

    fn parse_ref(&self, command: &Command, _: Option<&Arg>, value: &OsStr) -> Result<ModelSurface, clap::Error> {
        let known = ModelMaterial::all().find(|m| Some(m.name()) == value.to_str());
        if let Some(material) = known {
            return Ok(ModelSurface::Material(material));
        }
        let path = PathBuf::from(value);
        if path.extension().is_some() || path.is_file() {
            return Ok(ModelSurface::Picture(path));
        }
        let names: Vec<&str> = ModelMaterial::all().map(ModelMaterial::name).collect();
        let message = format!(
            "no material is called `{}`\n  [possible values: {}, or a picture file]\n",
            path.display(),
            names.join(", ")
        );
        Err(clap::Error::raw(ErrorKind::InvalidValue, message).with_cmd(command))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(ModelMaterial::all().map(|m| PossibleValue::new(m.name()).help(m.words()))))
    }
}

const SCENE_EXAMPLES: &str = "\
Examples:
  etendue scene bunny.obj -o bunny.toml            then edit it, and etendue render bunny.toml
  etendue scene part.stl --up z --view front       the scene on standard output
  etendue scene cow.obj --env sky.hdr --material gold -o cow.toml
  etendue scene cow.obj --material cow.png -o cow.toml

What is written is exactly what `etendue render MODEL` with the same options shows.";

/// Arguments of `etendue scene`.
#[derive(Debug, Args)]
#[command(before_help = SCENE_EXAMPLES)]
pub struct SceneArgs {
    /// Model (.obj, .ply, .stl, .off, also .gz), or a script of the older renderer (.cfg)
    pub model: PathBuf,

    /// Scene file to write (.toml) [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,

    /// Nothing but the model in the picture: it gets an alpha channel
    #[arg(long)]
    pub transparent: bool,

    /// How the model is shown.
    #[command(flatten)]
    pub look: ModelArgs,
}
