//! The keys of material libraries.

/// What follows a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `r [g b]`, at least 0, at most this.
    Colour(f64),
    /// A number in a range.
    Number(f64, f64),
    /// The number of an illumination model.
    Illum,
    /// Options and the name of an image.
    Map,
    /// The name of an image and the colours that it multiplies.
    Texture,
    /// Whatever it is has no use.
    Rest,
}

macro_rules! keys {
    ($($key:ident $name:literal $kind:expr;)*) => {
        /// A key that is known.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Key {
            $(#[doc = $name] $key,)*
        }

        impl Key {
            const ALL: &[Key] = &[$(Key::$key),*];

            /// As it is written.
            pub fn name(self) -> &'static str {
                match self { $(Key::$key => $name),* }
            }

            /// What follows it.
            pub fn kind(self) -> Kind {
                match self { $(Key::$key => $kind),* }
            }
        }
    };
}

const ANY: f64 = f64::INFINITY;

keys! {
    Ambient "Ka" Kind::Colour(ANY);
    Diffuse "Kd" Kind::Colour(1.0);
    Specular "Ks" Kind::Colour(1.0);
    Emission "Ke" Kind::Colour(ANY);
    Filter "Tf" Kind::Colour(1.0);
    Exponent "Ns" Kind::Number(0.0, ANY);
    Index "Ni" Kind::Number(-ANY, ANY);
    Opacity "d" Kind::Number(0.0, 1.0);
    Transparency "Tr" Kind::Number(0.0, 1.0);
    Illum "illum" Kind::Illum;
    Roughness "Pr" Kind::Number(0.0, 1.0);
    Metallic "Pm" Kind::Number(0.0, 1.0);
    Sheen "Ps" Kind::Number(0.0, 1.0);
    Coat "Pc" Kind::Number(0.0, 1.0);
    CoatRoughness "Pcr" Kind::Number(0.0, 1.0);
    Anisotropy "aniso" Kind::Number(0.0, 1.0);
    Rotation "anisor" Kind::Number(-1.0, 1.0);
    DiffuseTransmission "Td" Kind::Colour(1.0);
    Transmission "Ts" Kind::Colour(1.0);
    TransmissionExponent "Nst" Kind::Number(0.0, ANY);
    DialectIndex "n" Kind::Number(-ANY, ANY);
    Texture "texture" Kind::Texture;
    Scatter "scatter" Kind::Rest;
    Brdf "BRDF" Kind::Rest;
    MapAmbient "map_Ka" Kind::Map;
    MapDiffuse "map_Kd" Kind::Map;
    MapSpecular "map_Ks" Kind::Map;
    MapEmission "map_Ke" Kind::Map;
    MapExponent "map_Ns" Kind::Map;
    MapOpacity "map_d" Kind::Map;
    MapDiffuseTransmission "map_Td" Kind::Map;
    MapTransmission "map_Ts" Kind::Map;
    MapRoughness "map_Pr" Kind::Map;
    MapMetallic "map_Pm" Kind::Map;
    MapSheen "map_Ps" Kind::Map;
    MapCoat "map_Pc" Kind::Map;
    MapCoatRoughness "map_Pcr" Kind::Map;
    Bump "bump" Kind::Map;
    Normals "norm" Kind::Map;
    Displacement "disp" Kind::Rest;
    Decal "decal" Kind::Rest;
    Reflection "refl" Kind::Rest;
    Sharpness "sharpness" Kind::Rest;
    Antialiasing "map_aat" Kind::Rest;
}

/// Other spellings.
const ALIASES: [(&str, Key); 7] = [
    ("map_bump", Key::Bump),
    ("map_norm", Key::Normals),
    ("map_Kn", Key::Normals),
    ("map_disp", Key::Displacement),
    ("map_decal", Key::Decal),
    ("map_refl", Key::Reflection),
    ("map_opacity", Key::MapOpacity),
];

impl Key {
    /// The key that a word is, and whether it is written as it should be. Maps may be in any case: programs differ.
    pub fn of(word: &[u8]) -> Option<(Key, bool)> {
        let is = |name: &str| name.as_bytes().eq_ignore_ascii_case(word);
        let named = Key::ALL.iter().map(|key| (key.name(), *key)).chain(ALIASES);
        let (name, key) = named.into_iter().find(|(name, _)| is(name))?;
        Some((key, name.as_bytes() == word || matches!(key.kind(), Kind::Map | Kind::Rest)))
    }

    /// True if a file with this key is in the old renderer's dialect.
    pub fn is_of_dialect(self) -> bool {
        matches!(
            self,
            Key::DiffuseTransmission
                | Key::Transmission
                | Key::TransmissionExponent
                | Key::DialectIndex
                | Key::Texture
                | Key::Scatter
                | Key::Brdf
        )
    }

    /// True if a material with this key is physically based.
    pub fn is_of_pbr(self) -> bool {
        matches!(
            self,
            Key::Roughness
                | Key::Metallic
                | Key::Sheen
                | Key::Coat
                | Key::CoatRoughness
                | Key::Anisotropy
                | Key::Rotation
                | Key::MapRoughness
                | Key::MapMetallic
                | Key::MapSheen
                | Key::MapCoat
                | Key::MapCoatRoughness
        )
    }
}
