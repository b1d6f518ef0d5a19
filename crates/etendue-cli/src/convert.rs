//! `etendue convert`: models and pictures into other formats.

use crate::{
    args::ConvertArgs,
    exit::{Exit, Failure},
    model, model_output, report, scene_input, software,
};
use etendue::{
    image::{Channel, ChannelData, Image},
    tonemap::DisplayTransform,
};
use etendue_scene::{
    Limits, SourceMap,
    image_file::{self, read_image},
    import::Import,
    mesh_output::MeshOutputFormat,
    output::{Format, Metadata, atomic, write_image},
    script::is_script,
};
use std::path::Path;

/// Converts as the arguments say.
pub fn run(args: &ConvertArgs) -> Result<Exit, Failure> {
    let (input, output) = (&args.input, &args.output);
    model_output::refuse_unread_kind(input)?;
    if input.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        let message = format!("{} is a scene, which convert does not take", input.display());
        return Err(Failure::new(Exit::Usage, message).hint("etendue render makes pictures of scenes"));
    }
    if is_script(input) {
        refuse_picture_options(args, "a script")?;
        model::check_ending(output)?;
        return scene_input::write_script_scene(input, Some(output));
    }
    if model::is_model(input) { mesh(args, input, output) } else { picture(args, input, output) }
}

fn mesh(args: &ConvertArgs, input: &Path, output: &Path) -> Result<Exit, Failure> {
    let format = model_output::format_of(output)?;
    refuse_picture_options(args, "a model")?;
    atomic::check_writable(output)?;
    let mut sources = SourceMap::new();
    let mesh = model::read(input, &mut sources, &Limits::default())?;
    model_output::tell_losses(format, &mesh);
    model_output::write(output, format, &mesh, input, &sources)?;
    let written = Import { keys: Vec::new(), ..Import::new(output, &mesh) };
    report::say(written.to_string());
    Ok(Exit::Done)
}

fn refuse_picture_options(args: &ConvertArgs, what: &str) -> Result<(), Failure> {
    match args.display.first_given().or(args.layer.as_ref().map(|_| "--layer")) {
        None => Ok(()),
        Some(option) => {
            let message = format!("{option} is for pictures, but {} is {what}", args.input.display());
            Err(Failure::new(Exit::Usage, message).hint(format!("leave {option} out")))
        }
    }
}

fn picture(args: &ConvertArgs, input: &Path, output: &Path) -> Result<Exit, Failure> {
    let format = Format::of_path(output).map_err(|error| {
        let hint = match MeshOutputFormat::of_path(output) {
            Some(_) => "models are read from .obj, .ply, .stl and .off files, also .gz",
            None => "pictures are written as .png, .exr, .hdr and .pfm",
        };
        Failure::from(error).hint(hint)
    })?;
    if let Some(option) = args.display.first_given().filter(|_| format != Format::Png) {
        let message = format!("{option} is for pictures of 8 bits, but .{} is linear", format.ending());
        return Err(Failure::new(Exit::Usage, message).hint("write a .png"));
    }
    atomic::check_writable(output)?;
    let image = read_image(input, &image_file::Limits::default())?;
    let image = match &args.layer {
        None => image,
        Some(name) => layer(image, name, input)?,
    };
    let image = if format == Format::Exr { image } else { with_colour(image, input)? };
    let mut display = DisplayTransform::default();
    args.display.replace_in(&mut display);
    let encode = display.encoder();
    let metadata = Metadata { software: software(), encoding: display.encoding, ..Metadata::default() };
    write_image(output, format, &image, &metadata, &encode)?;
    report::say(format!("{}: {} x {} pixels", output.display(), image.width, image.height));
    Ok(Exit::Done)
}

/// The channels of a layer, as colour where they are three or one.
fn layer(image: Image, name: &str, input: &Path) -> Result<Image, Failure> {
    let of_layer =
        |channel: &Channel| channel.name == name || channel.name.rsplit_once('.').is_some_and(|(l, _)| l == name);
    let mut layers: Vec<String> = image
        .channels
        .iter()
        .map(|c| c.name.rsplit_once('.').map_or(&c.name[..], |(layer, _)| layer).to_owned())
        .collect();
    layers.dedup();
    let Image { width, height, channels } = image;
    let found: Vec<Channel> = channels.into_iter().filter(of_layer).collect();
    if found.is_empty() {
        let message = format!("{} has no layer `{name}`", input.display());
        return Err(Failure::new(Exit::BadInput, message).hint(format!("it has {}", layers.join(", "))));
    }
    Ok(Image { width, height, channels: named_as_colour(found) })
}

/// Names channels R, G, B in the order that they have as colours or as coordinates.
fn named_as_colour(mut channels: Vec<Channel>) -> Vec<Channel> {
    let last = |channel: &Channel| channel.name.rsplit('.').next().unwrap_or_default().to_owned();
    let order = |channel: &Channel| ["R", "G", "B", "X", "Y", "Z", "U", "V"].iter().position(|n| *n == last(channel));
    channels.sort_by_key(|channel| order(channel).unwrap_or(usize::MAX));
    let floats = |channel: Channel| match channel.data {
        ChannelData::F32(data) => data,
        ChannelData::U32(data) => data.into_iter().map(|v| v as f32).collect(),
    };
    let mut data: Vec<Vec<f32>> = channels.into_iter().take(3).map(floats).collect();
    match data.len() {
        1 => data = vec![data[0].clone(), data[0].clone(), data.remove(0)],
        2 => data.push(vec![0.0; data[0].len()]),
        _ => {}
    }
    let names = ["R", "G", "B"].into_iter();
    names.zip(data).map(|(name, data)| Channel { name: name.to_owned(), data: ChannelData::F32(data) }).collect()
}

/// A picture with colour; of one without, the only layer stands for it.
fn with_colour(image: Image, input: &Path) -> Result<Image, Failure> {
    if ["R", "G", "B"].iter().all(|name| image.f32_channel(name).is_some()) {
        return Ok(image);
    }
    if let [grey] = &image.channels[..] {
        let channels = named_as_colour(vec![grey.clone()]);
        return Ok(Image { channels, ..image });
    }
    let names: Vec<&str> = image.channels.iter().map(|c| &c.name[..]).collect();
    let message = format!("{} has no colour", input.display());
    Err(Failure::new(Exit::BadInput, message)
        .hint(format!("pick a layer with --layer: there are {}", names.join(", "))))
}
