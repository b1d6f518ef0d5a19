//! The keys of scene files: one list that the reader checks against and the manual is tested against.

/// One key of a section.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// As written.
    pub name: &'static str,
    /// Values of the section's `type` (`shape` of objects) that use it; empty: all.
    pub types: &'static [&'static str],
}

/// A table of the scene file.
#[derive(Debug)]
pub struct Section {
    /// As the manual and messages call it.
    pub name: &'static str,
    /// The keys it may have.
    pub keys: &'static [Key],
}

impl Section {
    /// The key with this name.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|k| k.name == name)
    }
}

/// A key of all types.
const fn all(name: &'static str) -> Key {
    Key { name, types: &[] }
}

/// A key of some types.
const fn of(name: &'static str, types: &'static [&'static str]) -> Key {
    Key { name, types }
}

/// The file itself.
pub static FILE: Section = Section {
    name: "the scene file",
    keys: &[
        all("camera"),
        all("film"),
        all("sampler"),
        all("integrator"),
        all("accelerator"),
        all("environment"),
        all("media"),
        all("world"),
        all("textures"),
        all("materials"),
        all("meshes"),
        all("objects"),
        all("lights"),
        all("animation"),
        all("physics"),
        all("joints"),
    ],
};

/// The view.
pub static CAMERA: Section = Section {
    name: "[camera]",
    keys: &[
        all("type"),
        all("position"),
        all("look_at"),
        all("direction"),
        all("up"),
        all("roll"),
        all("near_clip"),
        of("fov", &["perspective"]),
        of("fov_axis", &["perspective"]),
        of("focal_length", &["perspective"]),
        of("sensor", &["perspective"]),
        of("lens_radius", &["perspective"]),
        of("f_number", &["perspective"]),
        of("aperture", &["perspective"]),
        of("blades", &["perspective"]),
        of("aperture_rotation", &["perspective"]),
        of("focus_distance", &["perspective"]),
        of("focus_point", &["perspective"]),
        of("focus_object", &["perspective"]),
        of("height", &["orthographic"]),
    ],
};

/// The picture.
pub static FILM: Section = Section {
    name: "[film]",
    keys: &[
        all("size"),
        all("filter"),
        all("crop"),
        all("exposure"),
        all("balance"),
        all("tonemap"),
        all("encoding"),
        all("aovs"),
        all("transparent"),
    ],
};

/// Reconstruction.
pub static FILTER: Section = Section {
    name: "film.filter",
    keys: &[all("type"), all("radius"), of("sigma", &["gaussian"]), of("b", &["mitchell"]), of("c", &["mitchell"])],
};

/// Random numbers.
pub static SAMPLER: Section = Section { name: "[sampler]", keys: &[all("type"), all("spp"), all("seed")] };

/// Integrators that solve the rendering equation.
const SOLVERS: &[&str] = &["path", "light-split", "brute"];

/// Light transport.
pub static INTEGRATOR: Section = Section {
    name: "[integrator]",
    keys: &[all("type"), of("depth", SOLVERS), of("splitting", SOLVERS), of("distance", &["ao"])],
};

/// Ray traversal.
pub static ACCELERATOR: Section = Section { name: "[accelerator]", keys: &[all("type"), of("split", &["kdtree"])] };

/// Light from infinity.
pub static ENVIRONMENT: Section = Section {
    name: "[environment]",
    keys: &[
        all("type"),
        of("radiance", &["constant"]),
        of("image", &["image"]),
        of("strength", &["image", "sky"]),
        of("rotation", &["image"]),
        of("top", &["gradient"]),
        of("horizon", &["gradient"]),
        of("bottom", &["gradient"]),
        of("up", &["image", "gradient", "sky"]),
        of("sun", &["sky"]),
        of("elevation", &["sky"]),
        of("azimuth", &["sky"]),
        of("date", &["sky"]),
        of("time", &["sky"]),
        of("utc_offset", &["sky"]),
        of("latitude", &["sky"]),
        of("longitude", &["sky"]),
        of("north", &["sky"]),
        of("turbidity", &["sky"]),
        of("ground", &["sky"]),
        of("sun_size", &["sky"]),
        of("sun_disk", &["sky"]),
    ],
};

/// What fills space outside of bodies.
pub static WORLD: Section = Section { name: "[world]", keys: &[all("medium")] };

/// What fills space.
pub static MEDIUM: Section = Section {
    name: "[media.NAME]",
    keys: &[
        all("absorption"),
        all("scattering"),
        all("extinction"),
        all("mean_free_path"),
        all("albedo"),
        all("color"),
        all("at_distance"),
        all("preset"),
        all("emission"),
        all("phase"),
        all("density"),
    ],
};

/// Where scattered light goes.
pub static PHASE: Section =
    Section { name: "phase", keys: &[all("type"), of("g", &["henyey-greenstein"]), all("weight")] };

/// Density that varies.
pub static DENSITY: Section = Section {
    name: "density",
    keys: &[
        all("file"),
        all("min"),
        all("max"),
        all("transform"),
        all("scale"),
        all("axes"),
        all("size"),
        all("sample"),
        all("byte_order"),
    ],
};

/// Types of materials whose surface is seen.
const SEEN: &[&str] = &[
    "diffuse",
    "mirror",
    "glass",
    "rough-metal",
    "rough-glass",
    "brushed-metal",
    "mtl",
    "phong",
    "principled",
    "black",
];

/// A material.
pub static MATERIAL: Section = Section {
    name: "[materials.NAME]",
    keys: &[
        all("type"),
        all("interior"),
        all("priority"),
        of("emission", SEEN),
        of("opacity", SEEN),
        of("bump", SEEN),
        of("normal_map", SEEN),
        of("normal_scale", SEEN),
        of("normal_y", SEEN),
        of("tangent", SEEN),
        of("reflectance", &["diffuse", "mirror", "brushed-metal"]),
        of("transmittance", &["diffuse"]),
        of("ior", &["glass", "rough-glass", "mtl", "phong", "principled"]),
        of("reflection_tint", &["glass", "rough-glass"]),
        of("transmission_tint", &["glass", "rough-glass"]),
        of("thin", &["glass"]),
        of("metal", &["rough-metal"]),
        of("eta", &["rough-metal"]),
        of("k", &["rough-metal"]),
        of("tint", &["rough-metal"]),
        of("alpha", &["rough-metal", "rough-glass", "mtl"]),
        of("diffuse", &["mtl", "phong"]),
        of("specular", &["mtl", "phong", "principled"]),
        of("exponent", &["brushed-metal", "phong"]),
        of("form", &["brushed-metal"]),
        of("diffuse_transmission", &["phong"]),
        of("transmission", &["mtl", "phong", "principled"]),
        of("transmission_exponent", &["phong"]),
        of("base_color", &["principled"]),
        of("metallic", &["principled"]),
        of("roughness", &["principled"]),
        of("anisotropic", &["principled"]),
        of("rotation", &["principled"]),
        of("coat", &["principled"]),
        of("coat_roughness", &["principled"]),
        of("sheen", &["principled"]),
        of("sheen_roughness", &["principled"]),
    ],
};

/// Directions over a surface.
pub static TANGENT: Section = Section {
    name: "tangent",
    keys: &[
        all("type"),
        of("direction", &["constant"]),
        of("center", &["radial", "tangential"]),
        of("axis", &["radial", "tangential"]),
        all("rotation"),
    ],
};

/// Types of textures that are placed by texture coordinates, or computed at points.
const PLACED: &[&str] = &["image", "checker", "grid", "noise", "wood", "marble", "gradient"];
/// Those of two colours.
const TWO_COLORS: &[&str] = &["checker", "grid", "noise", "wood", "marble", "mix", "multiply"];

/// A function over surfaces.
pub static TEXTURE: Section = Section {
    name: "[textures.NAME]",
    keys: &[
        all("type"),
        of("file", &["image"]),
        of("encoding", &["image"]),
        all("channel"),
        of("filter", &["image"]),
        of("wrap", &["image"]),
        of("coordinates", &["checker", "grid", "noise", "wood", "marble", "gradient"]),
        of("scale", PLACED),
        of("rotate", PLACED),
        of("offset", PLACED),
        all("gain"),
        all("base"),
        of("color1", TWO_COLORS),
        of("color2", TWO_COLORS),
        of("weight", &["mix"]),
        of("width", &["grid"]),
        of("octaves", &["noise"]),
        of("roughness", &["noise"]),
        of("turbulence", &["noise"]),
        of("distortion", &["wood", "marble"]),
        of("axis", &["wood", "marble"]),
        of("seed", &["noise", "wood", "marble"]),
        of("stops", &["gradient"]),
        of("radial", &["gradient"]),
        of("from", &["gradient"]),
        of("to", &["gradient"]),
    ],
};

/// A colour of a gradient.
pub static STOP: Section = Section { name: "a stop", keys: &[all("at"), all("color")] };

/// A parameter that varies over the surface.
pub static PARAMETER: Section =
    Section { name: "a textured parameter", keys: &[all("texture"), all("file"), all("factor")] };

/// A texture alone.
pub static TEXTURE_REFERENCE: Section = Section { name: "normal_map", keys: &[all("texture"), all("file")] };

/// What a material emits.
pub static EMISSION: Section = Section { name: "emission", keys: &[all("radiance"), all("two_sided")] };

/// Geometry to be shared.
pub static MESH: Section = Section {
    name: "[meshes.NAME]",
    keys: &[
        all("file"),
        all("positions"),
        all("indices"),
        all("normals"),
        all("uvs"),
        all("colors"),
        all("crease_angle"),
        all("simplify"),
    ],
};

/// Fewer faces.
pub static SIMPLIFY: Section = Section {
    name: "simplify",
    keys: &[
        all("faces"),
        all("ratio"),
        all("max_error"),
        all("method"),
        all("placement"),
        all("sigma"),
        all("keep_boundary"),
        all("crease_angle"),
        all("fast"),
        all("polish"),
        all("seed"),
    ],
};

/// A thing in the scene.
pub static OBJECT: Section = Section {
    name: "[[objects]]",
    keys: &[
        all("shape"),
        all("name"),
        all("material"),
        of("materials", &["mesh"]),
        all("transform"),
        all("motion"),
        all("body"),
        of("mesh", &["mesh"]),
        of("file", &["mesh"]),
        of("crease_angle", &["mesh"]),
        of("simplify", &["mesh"]),
        of("center", &["sphere"]),
        of("radius", &["sphere", "disk"]),
        of("size", &["rectangle", "box"]),
        of("corner", &["rectangle"]),
        of("u", &["rectangle"]),
        of("v", &["rectangle"]),
        of("min", &["box"]),
        of("max", &["box"]),
        of("segments", &["disk"]),
    ],
};

/// How an object moves and collides.
pub static BODY: Section = Section {
    name: "body",
    keys: &[
        all("kind"),
        all("shape"),
        all("friction"),
        all("restitution"),
        all("group"),
        of("mass", &["dynamic"]),
        of("density", &["dynamic"]),
        of("linear_velocity", &["dynamic"]),
        of("angular_velocity", &["dynamic"]),
        of("linear_damping", &["dynamic"]),
        of("angular_damping", &["dynamic"]),
        of("gravity_scale", &["dynamic"]),
    ],
};

/// What holds for all bodies.
pub static PHYSICS: Section = Section {
    name: "[physics]",
    keys: &[
        all("gravity"),
        all("step"),
        all("substeps"),
        all("iterations"),
        all("start"),
        all("duration"),
        all("warm_up"),
        all("friction_rule"),
        all("restitution_rule"),
        all("length_unit"),
        all("contact_frequency"),
        all("contact_damping"),
        all("sleep"),
        all("ignore"),
    ],
};

/// Joints that leave something free that can be measured.
const AXIAL: &[&str] = &["hinge", "slider"];

/// What joins two bodies.
pub static JOINT: Section = Section {
    name: "[[joints]]",
    keys: &[
        all("type"),
        all("bodies"),
        all("anchor"),
        of("axis", AXIAL),
        of("limits", AXIAL),
        of("motor", AXIAL),
        all("collide"),
    ],
};

/// What drives a joint.
pub static MOTOR: Section = Section {
    name: "motor",
    keys: &[all("velocity"), all("position"), all("stiffness"), all("damping"), all("max_force")],
};

/// One step of a transform.
pub static STEP: Section = Section {
    name: "a step of transform",
    keys: &[all("translate"), all("rotate"), all("scale"), all("matrix"), all("look_at"), all("relocate")],
};

/// A rotation.
pub static ROTATE: Section = Section { name: "rotate", keys: &[all("axis"), all("angle")] };

/// A placement by aim.
pub static LOOK_AT: Section = Section { name: "look_at", keys: &[all("position"), all("target"), all("up")] };

/// A light without extent.
pub static LIGHT: Section = Section {
    name: "[[lights]]",
    keys: &[
        all("type"),
        of("position", &["point", "spot"]),
        of("intensity", &["point", "spot"]),
        of("target", &["spot"]),
        of("direction", &["spot", "directional"]),
        of("angle", &["spot"]),
        of("blend", &["spot"]),
        of("irradiance", &["directional"]),
    ],
};

/// Time.
pub static ANIMATION: Section = Section {
    name: "[animation]",
    keys: &[
        all("start"),
        all("speed"),
        all("fps"),
        all("frames"),
        all("duration"),
        all("shutter"),
        all("shutter_curve"),
        all("keyframes"),
    ],
};

/// Poses from a file.
pub static KEYFRAMES: Section = Section {
    name: "keyframes",
    keys: &[all("file"), all("objects"), all("times"), all("start"), all("fps"), all("interpolation"), all("relative")],
};

/// The motion of an object.
pub static MOTION: Section = Section { name: "motion", keys: &[all("translate"), all("rotate"), all("pivot")] };

/// A value that changes over time.
pub static KEYED: Section = Section { name: "a value with keys", keys: &[all("keys"), all("interpolation")] };

/// Every section, in the order of the manual.
pub static SECTIONS: [&Section; 34] = [
    &FILE,
    &CAMERA,
    &FILM,
    &FILTER,
    &SAMPLER,
    &INTEGRATOR,
    &ACCELERATOR,
    &ENVIRONMENT,
    &WORLD,
    &MEDIUM,
    &PHASE,
    &DENSITY,
    &TEXTURE,
    &STOP,
    &MATERIAL,
    &PARAMETER,
    &TEXTURE_REFERENCE,
    &EMISSION,
    &TANGENT,
    &MESH,
    &SIMPLIFY,
    &OBJECT,
    &BODY,
    &STEP,
    &ROTATE,
    &LOOK_AT,
    &MOTION,
    &LIGHT,
    &ANIMATION,
    &KEYFRAMES,
    &KEYED,
    &PHYSICS,
    &JOINT,
    &MOTOR,
];
