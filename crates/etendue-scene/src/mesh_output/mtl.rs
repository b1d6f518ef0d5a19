//! Material libraries: for each material the keys that come nearest.

use super::obj::one_line;
use crate::{description::TextureRecord, mesh_file::NamedMaterial, output::EncodeError};
use etendue::{
    material::{Color, Material, Number, Parameter, Relief, Scattering},
    spectrum::Spectrum,
};
use std::{
    collections::BTreeSet,
    convert::Infallible,
    io::Write,
    path::{Component, Path, PathBuf},
};

/// Where names of textures start, and where they shall.
pub(super) struct Folders<'a> {
    pub from: &'a Path,
    pub to: &'a Path,
}

/// The names that materials get: different, and not empty.
pub(super) fn names(materials: &[NamedMaterial]) -> Vec<String> {
    let (mut names, mut taken) = (vec![], BTreeSet::new());
    for material in materials {
        let wanted = one_line(&material.name);
        let wanted = if wanted.is_empty() { "unnamed".to_owned() } else { wanted };
        let numbered = (2u32..).map(|number| format!("{wanted} {number}"));
        let free = std::iter::once(wanted.clone()).chain(numbered).find(|name| !taken.contains(name));
        let name = free.unwrap_or(wanted);
        taken.insert(name.clone());
        names.push(name);
    }
    names
}

pub(super) fn write(out: &mut impl Write, materials: &[NamedMaterial], folders: &Folders) -> Result {
    writeln!(out, "# Etendue")?;
    for (name, material) in names(materials).iter().zip(materials) {
        writeln!(out, "\nnewmtl {name}")?;
        Writer { out, folders }.material(&material.material)?;
    }
    Ok(())
}

type Result<T = ()> = std::result::Result<T, EncodeError>;

/// Parameters of a material by name, in their order.
type Named<V> = Vec<(&'static str, Parameter<V, TextureRecord>)>;

struct Writer<'a, W> {
    out: &'a mut W,
    folders: &'a Folders<'a>,
}

impl<W: Write> Writer<'_, W> {
    fn material(&mut self, material: &Material<TextureRecord>) -> Result {
        self.scattering(&material.scattering)?;
        if let Some(emission) = &material.emission {
            self.color("Ke", &emission.radiance)?;
        }
        if material.opacity != Number::from(1.0) {
            self.number("d", &material.opacity)?;
        }
        match &material.relief {
            None => Ok(()),
            Some(Relief::Bump { height }) => match &height.texture {
                Some(texture) => self.map("bump", &format!("-bm {} ", height.factor), texture),
                None => Ok(()),
            },
            Some(Relief::Normals { map, .. }) => self.map("norm", "", map),
        }
    }

    fn scattering(&mut self, scattering: &Scattering<Color<TextureRecord>, Number<TextureRecord>>) -> Result {
        let (mut colors, mut numbers): (Named<Spectrum>, Named<f32>) = (vec![], vec![]);
        let mapped: std::result::Result<Scattering<(), ()>, Infallible> = scattering.try_map(
            |name, _, color| {
                colors.push((name, color.clone()));
                Ok(())
            },
            |name, _, number| {
                numbers.push((name, number.clone()));
                Ok(())
            },
        );
        let Ok(_) = mapped;
        let color = |name| find(&colors, name).unwrap_or(Spectrum::BLACK.into());
        let number = |name, otherwise: f32| find(&numbers, name).unwrap_or(otherwise.into());
        let black = Color::from(Spectrum::BLACK);
        match scattering {
            Scattering::Black => self.lobes(&black, &black, None, 0),
            Scattering::Diffuse { .. } => self.lobes(&color("reflectance"), &black, None, 1),
            Scattering::Mirror { .. } => self.lobes(&black, &color("reflectance"), Some(&0.0.into()), 3),
            Scattering::Glass { .. } | Scattering::RoughGlass { .. } => {
                self.lobes(&black, &Spectrum::ONE.into(), Some(&number("alpha", 0.0)), 7)?;
                self.color("Tf", &color("transmission_tint"))?;
                self.number("Ni", &number("ior", 1.5))
            }
            Scattering::RoughMetal { .. } => {
                let tint = color("tint");
                let factor = mirrored(color("eta").factor, color("k").factor) * tint.factor;
                let specular = Color { factor, texture: tint.texture };
                self.lobes(&black, &specular, Some(&number("alpha", 0.1)), 2)
            }
            Scattering::BrushedMetal { .. } => {
                self.color("Kd", &black)?;
                self.color("Ks", &color("reflectance"))?;
                self.number("Ns", &number("exponent", 20.0))?;
                writeln!(self.out, "illum 2")?;
                Ok(())
            }
            Scattering::Mtl { .. } => {
                let refracts = color("transmission") != black;
                let illum = if refracts { 7 } else { 2 };
                self.lobes(&color("diffuse"), &color("specular"), Some(&number("alpha", 0.0)), illum)?;
                if refracts {
                    self.color("Tf", &color("transmission"))?;
                    self.number("Ni", &number("ior", 1.5))?;
                }
                Ok(())
            }
            Scattering::Phong(_) => {
                self.color("Kd", &color("diffuse"))?;
                self.color("Ks", &color("specular"))?;
                self.number("Ns", &number("exponent", 10.0))?;
                writeln!(self.out, "illum 2")?;
                Ok(())
            }
            Scattering::Principled(_) => {
                self.color("Kd", &color("base_color"))?;
                for (key, name) in
                    [("Pr", "roughness"), ("Pm", "metallic"), ("Pc", "coat"), ("Pcr", "coat_roughness"), ("Ni", "ior")]
                {
                    self.number(key, &number(name, 0.0))?;
                }
                self.number("aniso", &number("anisotropic", 0.0))?;
                self.number("anisor", &number("rotation", 0.0))
            }
        }
    }

    fn lobes(
        &mut self,
        diffuse: &Color<TextureRecord>,
        specular: &Color<TextureRecord>,
        alpha: Option<&Number<TextureRecord>>,
        illum: u32,
    ) -> Result {
        self.color("Kd", diffuse)?;
        if let Some(alpha) = alpha {
            self.color("Ks", specular)?;
            writeln!(self.out, "Ns {}", exponent(alpha.factor))?;
        }
        writeln!(self.out, "illum {illum}")?;
        Ok(())
    }

    fn color(&mut self, key: &str, color: &Color<TextureRecord>) -> Result {
        let [r, g, b] = color.factor.0;
        writeln!(self.out, "{key} {r} {g} {b}")?;
        color.texture.as_ref().map_or(Ok(()), |texture| self.map(&format!("map_{key}"), "", texture))
    }

    fn number(&mut self, key: &str, number: &Number<TextureRecord>) -> Result {
        writeln!(self.out, "{key} {}", number.factor)?;
        number.texture.as_ref().map_or(Ok(()), |texture| self.map(&format!("map_{key}"), "", texture))
    }

    fn map(&mut self, key: &str, options: &str, texture: &TextureRecord) -> Result {
        // Libraries have no words for others.
        let Some(image) = texture.first_image() else { return Ok(()) };
        let file = self.folders.relative(&image.file.value);
        writeln!(self.out, "{key} {options}{}", one_line(&file.to_string_lossy()))?;
        Ok(())
    }
}

fn find<V: Clone>(named: &Named<V>, wanted: &str) -> Option<Parameter<V, TextureRecord>> {
    named.iter().find(|(name, _)| *name == wanted).map(|(_, parameter)| parameter.clone())
}

/// `Ns` of a GGX width, the inverse of what the reader makes of `Ns`; from 1000 on it reads a mirror.
fn exponent(alpha: f32) -> f32 {
    let alpha = f64::from(alpha);
    (2.0 / (alpha * alpha) - 2.0).clamp(0.0, 1000.0) as f32
}

/// Reflectance of a metal at normal incidence.
fn mirrored(eta: Spectrum, k: Spectrum) -> Spectrum {
    let channel = |c: usize| {
        let (eta, k) = (eta.0[c], k.0[c]);
        ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k)
    };
    Spectrum([0, 1, 2].map(channel))
}

impl Folders<'_> {
    /// A name as seen from the new folder. Where folders have nothing in common, the whole path.
    fn relative(&self, name: &Path) -> PathBuf {
        let absolute = |path: &Path| std::path::absolute(if path == Path::new("") { Path::new(".") } else { path });
        let (Ok(file), Ok(to)) = (absolute(&self.from.join(name)), absolute(self.to)) else {
            return name.to_owned();
        };
        let (file, to): (Vec<Component>, Vec<Component>) = (file.components().collect(), to.components().collect());
        let common = file.iter().zip(&to).take_while(|(a, b)| a == b).count();
        if !file[..common].iter().any(|c| matches!(c, Component::Normal(_))) {
            return file.iter().collect();
        }
        let up = to[common..].iter().map(|_| Component::ParentDir);
        up.chain(file[common..].iter().copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_textures_follow_the_library() {
        let relative = |from: &str, to: &str, name: &str| {
            Folders { from: Path::new(from), to: Path::new(to) }
                .relative(Path::new(name))
                .to_string_lossy()
                .into_owned()
        };
        assert_eq!(relative("/a/b", "/a/b", "t/x y.png"), "t/x y.png");
        assert_eq!(relative("/a/b", "/a/c/d", "x.png"), "../../b/x.png");
        assert_eq!(relative("/a/b", "/a", "x.png"), "b/x.png");
        assert_eq!(relative("/a", "/b", "x.png"), "/a/x.png");
        assert_eq!(relative("/a", "/a", "/c/x.png"), "/c/x.png");
        assert_eq!(relative("", "out", "x.png"), "../x.png");
    }

    #[test]
    fn widths_and_exponents() {
        for ns in [1.0f32, 10.0, 99.5, 999.0] {
            let alpha = (2.0 / (ns + 2.0)).sqrt();
            assert!((exponent(alpha) / ns - 1.0).abs() < 1e-5);
        }
        assert_eq!([exponent(0.0), exponent(1.0), exponent(1e-9)], [1000.0, 0.0, 1000.0]);
    }
}
