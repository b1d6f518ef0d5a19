"""An Etendue scene file as a Mitsuba 3 scene.

Reads the TOML itself, so that both renderers work from the same numbers. Converts what it can convert exactly and
ends with an error for everything else: a comparison of two different scenes is worse than none. What the command
line of a comparison decides (size, filter, samples, depth) is not read from the file.
"""

import hashlib
import json
import math
import pathlib
import tomllib

# These parts decide the picture; the others are settings of a renderer.
PICTURE = ("camera", "materials", "meshes", "objects", "lights", "environment")
SETTINGS = ("film", "sampler", "integrator", "accelerator")


# Triangles of a box, outward; bit k of a corner's number chooses between the box's ends on axis k.
BOX = [
    [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5], [0, 1, 5], [0, 5, 4],
    [2, 6, 7], [2, 7, 3], [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6],
]  # fmt: skip


class Unsupported(Exception):
    """The scene uses something this converter does not know."""


class Table:
    """A TOML table of which every key must be used."""

    def __init__(self, values, where):
        if not isinstance(values, dict):
            raise Unsupported(f"{where}: expected a table")
        self.values = dict(values)
        self.where = where

    def take(self, key, *default):
        """The value of a key, removed from the table; without a default the key is required."""
        if key in self.values:
            return self.values.pop(key)
        if not default:
            raise Unsupported(f"{self.where}: no {key}")
        return default[0]

    def done(self):
        """Every key must have been taken by now."""
        if self.values:
            raise Unsupported(f"{self.where}: cannot convert {', '.join(sorted(self.values))}")


def read(path):
    """The scene file as nested dictionaries."""
    with open(path, "rb") as file:
        return tomllib.load(file)


def digest(source):
    """A hash of what decides the picture: comments and renderer settings do not change it."""
    picture = {key: source[key] for key in PICTURE if key in source}
    return hashlib.sha256(json.dumps(picture, sort_keys=True).encode()).hexdigest()


def convert(mi, source, scratch, folder, size, max_depth):
    """The dictionary for `mi.load_dict`.

    Inline meshes pass through files in the directory `scratch`; mesh files are looked up from `folder`. `max_depth`
    counts path edges, the camera segment included, in both programs; None is no limit.
    """
    unknown = set(source) - set(PICTURE) - set(SETTINGS)
    if unknown:
        raise Unsupported(f"cannot convert {', '.join(sorted(unknown))}")
    if source.get("integrator", {}).get("type", "path") != "path":
        raise Unsupported("integrator: only path is compared")
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1 if max_depth is None else max_depth},
        "sensor": _camera(mi, Table(source.get("camera"), "camera"), size),
    }
    materials = source.get("materials", {})
    meshes = _Meshes(source.get("meshes", {}), pathlib.Path(scratch), pathlib.Path(folder))
    for index, entry in enumerate(source.get("objects", [])):
        scene[f"object{index}"] = _object(mi, Table(entry, f"objects[{index}]"), materials, meshes)
    for index, entry in enumerate(source.get("lights", [])):
        scene[f"light{index}"] = _light(Table(entry, f"lights[{index}]"))
    if "environment" in source:
        environment = Table(source["environment"], "environment")
        scene["environment"] = {"type": "constant", "radiance": _rgb(environment.take("radiance"), environment.where)}
        environment.done()
    return scene


def _rgb(value, where):
    """A colour, linear sRGB: three numbers, or one for all."""
    if isinstance(value, (int, float)):
        value = [value] * 3
    if not isinstance(value, list) or len(value) != 3 or not all(isinstance(v, (int, float)) for v in value):
        raise Unsupported(f"{where}: only colours of numbers are converted")
    return {"type": "rgb", "value": [float(v) for v in value]}


def _camera(mi, camera, size):
    if camera.take("type", "perspective") != "perspective":
        raise Unsupported("camera: only perspective is converted")
    if camera.take("lens_radius", 0) != 0:
        raise Unsupported("camera: only a pinhole is converted")
    camera.take("focus_distance", None)
    position = camera.take("position")
    if "look_at" in camera.values:
        target = camera.take("look_at")
    else:
        target = [p + d for p, d in zip(position, camera.take("direction"))]
    up = camera.take("up", [0, 1, 0])
    fov, axis = camera.take("fov"), camera.take("fov_axis", "x")
    camera.done()
    return {
        "type": "perspective",
        "fov": float(fov),
        "fov_axis": axis,
        "to_world": mi.ScalarTransform4f().look_at(origin=position, target=target, up=up),
        "near_clip": 1e-3,
        "far_clip": 1e5,
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent"},
    }


def _object(mi, entry, materials, meshes):
    entry.take("name", None)
    shape = _shape(entry, meshes)
    name = entry.take("material")
    if name not in materials:
        raise Unsupported(f"{entry.where}: no material {name}")
    shape |= _material(Table(materials[name], f"materials.{name}"))
    shape["to_world"] = _transform(mi, entry.take("transform", []), entry.where)
    entry.done()
    return shape


def _shape(entry, meshes):
    is_mesh = "mesh" in entry.values or "file" in entry.values
    kind = entry.take("shape", *(["mesh"] if is_mesh else []))
    if kind == "mesh":
        path = meshes.named(entry.take("mesh")) if "mesh" in entry.values else meshes.file(entry.take("file"))
        if path.suffix not in (".obj", ".ply"):
            raise Unsupported(f"{entry.where}: cannot convert {path}")
        # Without this Mitsuba invents smooth normals for a mesh that has none.
        return {"type": path.suffix[1:], "filename": str(path), "face_normals": not _has_normals(path)}
    if kind == "sphere":
        return {"type": "sphere", "center": entry.take("center", [0, 0, 0]), "radius": float(entry.take("radius", 1))}
    if kind == "rectangle":
        if "corner" in entry.values:
            corner, u, v = (entry.take(key) for key in ("corner", "u", "v"))
        else:
            x, y = entry.take("size", [1, 1])
            corner, u, v = [-x / 2, -y / 2, 0], [x, 0, 0], [0, y, 0]
        corners = [[c + a * x + b * y for c, x, y in zip(corner, u, v)] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
        return _inline(meshes.write(corners, [[0, 1, 2], [0, 2, 3]]))
    if kind == "box":
        if "min" in entry.values:
            ends = entry.take("min"), entry.take("max")
        else:
            size = entry.take("size", 1)
            size = [size] * 3 if isinstance(size, (int, float)) else size
            ends = [-x / 2 for x in size], [x / 2 for x in size]
        corners = [[ends[(i >> axis) & 1][axis] for axis in range(3)] for i in range(8)]
        return _inline(meshes.write(corners, BOX))
    raise Unsupported(f"{entry.where}: cannot convert the shape {kind}")


def _inline(path):
    return {"type": "obj", "filename": str(path), "face_normals": True}


def _has_normals(path):
    """Whether an OBJ or PLY file has vertex normals."""
    with open(path, "rb") as file:
        if path.suffix == ".obj":
            return any(line.startswith(b"vn ") for line in file)
        for line in file:
            if line.split() in ([b"property", b"float", b"nx"], [b"property", b"float32", b"nx"]):
                return True
            if line.strip() == b"end_header":
                return False
    return False


def _material(material):
    kind = material.take("type")
    if material.take("opacity", 1) != 1:
        raise Unsupported(f"{material.where}: only opaque materials are converted")
    if kind == "diffuse":
        bsdf = {"type": "diffuse", "reflectance": _rgb(material.take("reflectance"), material.where)}
    elif kind == "black":
        bsdf = {"type": "diffuse", "reflectance": _rgb(0, material.where)}
    else:
        raise Unsupported(f"{material.where}: cannot convert the type {kind}")
    # Mitsuba's own diffuse is black from behind.
    parts = {"bsdf": {"type": "twosided", "bsdf": bsdf}}
    emission = material.take("emission", None)
    if emission is not None:
        whole = emission if isinstance(emission, dict) else {"radiance": emission}
        emission = Table(whole, f"{material.where}.emission")
        if emission.take("two_sided", False):
            raise Unsupported(f"{emission.where}: Mitsuba's area lights have one side")
        parts["emitter"] = {"type": "area", "radiance": _rgb(emission.take("radiance"), emission.where)}
        emission.done()
    material.done()
    return parts


def _light(light):
    if light.take("type") != "point":
        raise Unsupported(f"{light.where}: only point lights are converted")
    point = {
        "type": "point",
        "position": light.take("position"),
        "intensity": _rgb(light.take("intensity"), light.where),
    }
    light.take("name", None)
    light.done()
    return point


def _transform(mi, steps, where):
    """The steps of a transform, each applied after those before it."""
    whole = mi.ScalarTransform4f()
    for index, entry in enumerate(steps if isinstance(steps, list) else [steps]):
        step = Table(entry, f"{where}.transform[{index}]")
        one = mi.ScalarTransform4f()
        if "translate" in step.values:
            one = one.translate(step.take("translate"))
        elif "scale" in step.values:
            one = one.scale(step.take("scale"))
        elif "rotate" in step.values:
            rotation = Table(step.take("rotate"), f"{step.where}.rotate")
            axis = rotation.take("axis")
            axis = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}.get(axis, axis) if isinstance(axis, str) else axis
            one = one.rotate(axis, rotation.take("angle"))
            rotation.done()
        step.done()
        whole = one @ whole
    return whole


class _Meshes:
    """The meshes of a scene; what is not a file of its own is written as OBJ, with all digits a float32 has."""

    def __init__(self, tables, scratch, folder):
        self.tables = tables
        self.scratch = scratch
        self.folder = folder
        self.written = 0

    def file(self, name):
        """The path of a mesh file as the scene names it."""
        return self.folder / name

    def named(self, name):
        """The path of one of the scene's shared meshes."""
        if name not in self.tables:
            raise Unsupported(f"no mesh {name}")
        mesh = Table(self.tables[name], f"meshes.{name}")
        path = self.file(mesh.take("file")) if "file" in mesh.values else None
        if path is None:
            path = self.write(mesh.take("positions"), mesh.take("indices"))
        mesh.done()
        return path

    def write(self, positions, faces):
        """The path of a new OBJ file with these faces; quadrilaterals are cut from the first corner to the third."""
        if any(not math.isfinite(x) for point in positions for x in point):
            raise Unsupported("a position is not finite")
        if any(len(face) not in (3, 4) for face in faces):
            raise Unsupported("a face has neither 3 nor 4 corners")
        lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in positions]
        triangles = [(f[0], *pair) for f in faces for pair in zip(f[1:], f[2:])]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
        path = self.scratch / f"{self.written}.obj"
        path.write_text("\n".join(lines) + "\n")
        self.written += 1
        return path
