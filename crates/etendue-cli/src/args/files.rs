//! Arguments of the subcommands that look at files and turn them into others.

use super::DisplayArgs;
use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

const INFO_EXAMPLES: &str = "\
Examples:
  etendue info cow.obj                what is in a model, and what became of each key of its materials
  etendue info scene.toml             what is in a scene: objects, lights, textures, memory
  etendue info render.exr             size, channels and range of a picture
  etendue info cow.obj --json | jq '.keys[] | select(.status == \"ignored\")'";

/// Arguments of `etendue info`.
#[derive(Debug, Args)]
#[command(before_help = INFO_EXAMPLES)]
pub struct InfoArgs {
    /// Scene (.toml, .cfg), model (.obj, .ply, .stl, .off, also .gz) or picture (.png, .exr, .hdr, .jpg, ...)
    pub file: PathBuf,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

const CONVERT_EXAMPLES: &str = "\
Examples:
  etendue convert scan.stl scan.ply
  etendue convert cow.ply.gz cow.obj
  etendue convert render.exr render.png --exposure 1 --tonemap aces
  etendue convert render.exr albedo.png --layer Albedo
  etendue convert sky.exr sky.hdr

Models are written as OBJ (with MTL), PLY or STL, pictures as EXR, HDR, PNG or PFM, scripts of the
older renderer as scene files (.toml); the endings say which.
Models keep what the format can hold: materials only OBJ, normals and texture coordinates not STL.";

/// Arguments of `etendue convert`.
#[derive(Debug, Args)]
#[command(before_help = CONVERT_EXAMPLES, allow_negative_numbers = true)]
pub struct ConvertArgs {
    /// Model (.obj, .ply, .stl, .off, also .gz), script (.cfg) or picture (.exr, .hdr, .png, .pfm, .jpg, .tga, .bmp, .webp)
    pub input: PathBuf,

    /// File to write
    pub output: PathBuf,

    /// How pictures of 8 bits are made.
    #[command(flatten)]
    pub display: DisplayArgs,

    /// Layer of an .exr file, such as Albedo, N or Depth: its channels become red, green and blue
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  etendue completions bash > ~/.local/share/bash-completion/completions/etendue
  etendue completions zsh > ~/.zfunc/_etendue
  etendue completions fish > ~/.config/fish/completions/etendue.fish";

/// Arguments of `etendue completions`.
#[derive(Debug, Args)]
#[command(before_help = COMPLETIONS_EXAMPLES)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: Shell,
}

const MAN_EXAMPLES: &str = "\
Examples:
  etendue man | man -l -                           read it
  etendue man > ~/.local/share/man/man1/etendue.1
  etendue man render > etendue-render.1            the page of one subcommand";

/// Arguments of `etendue man`.
#[derive(Debug, Args)]
#[command(before_help = MAN_EXAMPLES)]
pub struct ManArgs {
    /// Subcommand [default: the program as a whole]
    pub subcommand: Option<String>,
}
