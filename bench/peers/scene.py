"""A scene file of the benchmark in plain arrays, for renderers that read other formats.

Reads the TOML itself, so that all renderers work from the same numbers. Converts what can be converted exactly and ends
with an error for everything else: a comparison of two different scenes is worse than none.
"""

import dataclasses
import hashlib
import json
import math
import pathlib
import tomllib

import numpy as np

# These parts decide the picture; the others are settings of a renderer.
PICTURE = ("camera", "materials", "media", "meshes", "objects", "lights", "environment", "textures", "world")
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


@dataclasses.dataclass
class Camera:
    """A pinhole; `fov` in degrees along the width."""

    position: list
    target: list
    up: list
    fov: float


@dataclasses.dataclass
class Mesh:
    """`vertices` (n, 3) float32, `faces` (m, 3) int32 counter-clockwise from the front, `uvs` (n, 2) float32 or None, v
    upward. Faces are flat."""

    vertices: np.ndarray
    faces: np.ndarray
    uvs: np.ndarray | None = None

    def placed(self, matrix):
        """A copy in the world; products in double precision."""
        moved = self.vertices.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        faces = self.faces if np.linalg.det(matrix[:3, :3]) > 0 else self.faces[:, [0, 2, 1]]
        return Mesh(moved.astype(np.float32), faces, self.uvs)


@dataclasses.dataclass
class Texture:
    """A picture of linear values, looked up bilinearly, repeated."""

    file: pathlib.Path


@dataclasses.dataclass
class Material:
    """`kind` is diffuse, black, mirror, glass, rough-glass or rough-metal; `color` is the reflectance, three numbers or a
    Texture; `emission` three numbers or None, on the front alone."""

    kind: str
    color: object = None
    ior: float = 1.5
    alpha: float = 0.0
    eta: list | None = None
    k: list | None = None
    emission: list | None = None


@dataclasses.dataclass
class Object:
    """A mesh by its number, placed by a 4 x 4 matrix."""

    mesh: int
    material: str
    matrix: np.ndarray


@dataclasses.dataclass
class Medium:
    """Fills the world: coefficients per metre, three numbers each, and the mean cosine of scattering."""

    scattering: list
    absorption: list
    g: float


@dataclasses.dataclass
class Scene:
    """All of it. `environment` is None, three numbers, or the path of a panorama."""

    size: tuple
    depth: int | None
    camera: Camera
    meshes: list
    objects: list
    materials: dict
    environment: object = None
    medium: Medium | None = None
    points: list = dataclasses.field(default_factory=list)


def read_toml(path):
    """The scene file as nested dictionaries."""
    with open(path, "rb") as file:
        return tomllib.load(file)


def digest(source):
    """A hash of what decides the picture: comments and renderer settings do not change it."""
    picture = {key: source[key] for key in PICTURE if key in source}
    return hashlib.sha256(json.dumps(picture, sort_keys=True).encode()).hexdigest()


def read(path):
    """The scene of a file."""
    path = pathlib.Path(path)
    source = read_toml(path)
    unknown = set(source) - set(PICTURE) - set(SETTINGS)
    if unknown:
        raise Unsupported(f"cannot convert {', '.join(sorted(unknown))}")
    if source.get("integrator", {}).get("type", "path") != "path":
        raise Unsupported("integrator: only path is compared")
    meshes = _Meshes(source.get("meshes", {}), path.parent)
    objects = [_object(Table(o, f"objects[{i}]"), meshes) for i, o in enumerate(source.get("objects", []))]
    textures = {n: _texture(Table(t, f"textures.{n}"), path.parent) for n, t in source.get("textures", {}).items()}
    materials = {n: _material(Table(m, f"materials.{n}"), textures) for n, m in source.get("materials", {}).items()}
    for entry in objects:
        if entry.material not in materials:
            raise Unsupported(f"no material {entry.material}")
    return Scene(
        size=tuple(source.get("film", {}).get("size", (512, 512))),
        depth=source.get("integrator", {}).get("depth"),
        camera=_camera(Table(source.get("camera"), "camera")),
        meshes=meshes.all,
        objects=objects,
        materials=materials,
        environment=_environment(source, path.parent),
        medium=_medium(source),
        points=[_point(Table(light, f"lights[{i}]")) for i, light in enumerate(source.get("lights", []))],
    )


def color(value, where):
    """A colour, linear sRGB: three numbers, or one for all."""
    if isinstance(value, (int, float)):
        value = [value] * 3
    if not isinstance(value, list) or len(value) != 3 or not all(isinstance(v, (int, float)) for v in value):
        raise Unsupported(f"{where}: only colours of numbers are converted")
    return [float(v) for v in value]


def _camera(camera):
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
    if camera.take("fov_axis", "x") != "x":
        raise Unsupported("camera: only fov_axis x is converted")
    result = Camera(position, target, camera.take("up", [0, 1, 0]), float(camera.take("fov")))
    camera.done()
    return result


def _environment(source, folder):
    if "environment" not in source:
        return None
    table = Table(source["environment"], "environment")
    result = folder / table.take("image") if "image" in table.values else color(table.take("radiance"), table.where)
    table.done()
    return result


def _medium(source):
    if "world" not in source:
        return None
    table = Table(source["world"], "world")
    name = table.take("medium")
    table.done()
    medium = Table(source["media"][name], f"media.{name}")
    phase = Table(medium.take("phase", {"type": "henyey-greenstein", "g": 0.0}), f"{medium.where}.phase")
    if phase.take("type") != "henyey-greenstein":
        raise Unsupported(f"{phase.where}: only henyey-greenstein is converted")
    scattering = color(medium.take("scattering", 0), medium.where)
    result = Medium(scattering, color(medium.take("absorption", 0), medium.where), float(phase.take("g")))
    phase.done()
    medium.done()
    return result


def _point(light):
    if light.take("type", "point") != "point":
        raise Unsupported(f"{light.where}: only point lights are converted")
    light.take("name", None)
    point = light.take("position"), color(light.take("intensity"), light.where)
    light.done()
    return point


def _texture(table, folder):
    if table.take("type", "image") != "image" or table.take("filter", "trilinear") != "bilinear":
        raise Unsupported(f"{table.where}: only bilinear images are converted")
    if table.take("encoding", "srgb") != "linear":
        raise Unsupported(f"{table.where}: only linear images are converted")
    result = Texture(folder / table.take("file"))
    table.done()
    return result


def _material(table, textures):
    kind = table.take("type")
    if table.take("opacity", 1) != 1:
        raise Unsupported(f"{table.where}: only opaque materials are converted")
    material = Material(kind)
    if kind in ("diffuse", "mirror"):
        value = table.take("reflectance", 0.5 if kind == "diffuse" else 1)
        if isinstance(value, dict):
            value = Table(value, f"{table.where}.reflectance")
            material.color = textures[value.take("texture")]
            value.done()
        else:
            material.color = color(value, table.where)
    elif kind in ("glass", "rough-glass"):
        material.ior = float(table.take("ior", 1.5))
        material.alpha = float(table.take("alpha", 0.1)) if kind == "rough-glass" else 0.0
    elif kind == "rough-metal":
        material.eta, material.k = (color(table.take(key), table.where) for key in ("eta", "k"))
        material.alpha = float(table.take("alpha", 0.1))
    elif kind != "black":
        raise Unsupported(f"{table.where}: cannot convert the type {kind}")
    emission = table.take("emission", None)
    if emission is not None:
        emission = Table(emission if isinstance(emission, dict) else {"radiance": emission}, f"{table.where}.emission")
        if emission.take("two_sided", False):
            raise Unsupported(f"{emission.where}: only lights of one side are converted")
        material.emission = color(emission.take("radiance"), emission.where)
        emission.done()
    table.done()
    return material


def _object(entry, meshes):
    entry.take("name", None)
    mesh = _shape(entry, meshes)
    matrix = _transform(entry.take("transform", []), entry.where)
    result = Object(mesh, entry.take("material"), matrix)
    entry.done()
    return result


def _shape(entry, meshes):
    """The number of the object's mesh."""
    kind = entry.take("shape", *(["mesh"] if {"mesh", "file"} & set(entry.values) else []))
    if kind == "mesh":
        return meshes.named(entry.take("mesh")) if "mesh" in entry.values else meshes.file(entry.take("file"))
    if kind == "rectangle":
        if "corner" in entry.values:
            corner, u, v = (np.array(entry.take(key), float) for key in ("corner", "u", "v"))
        else:
            x, y = entry.take("size", [1, 1])
            corner, u, v = np.array([-x / 2, -y / 2, 0]), np.array([x, 0, 0]), np.array([0, y, 0])
        return meshes.add([corner, corner + u, corner + u + v, corner + v], [[0, 1, 2], [0, 2, 3]])
    if kind == "box":
        if "min" in entry.values:
            ends = entry.take("min"), entry.take("max")
        else:
            size = entry.take("size", 1)
            size = [size] * 3 if isinstance(size, (int, float)) else size
            ends = [-x / 2 for x in size], [x / 2 for x in size]
        return meshes.add([[ends[(i >> axis) & 1][axis] for axis in range(3)] for i in range(8)], BOX)
    raise Unsupported(f"{entry.where}: cannot convert the shape {kind}")


def _transform(steps, where):
    """The steps of a transform, each applied after those before it: a 4 x 4 matrix."""
    whole = np.eye(4)
    for index, entry in enumerate(steps if isinstance(steps, list) else [steps]):
        step = Table(entry, f"{where}.transform[{index}]")
        one = np.eye(4)
        if "translate" in step.values:
            one[:3, 3] = step.take("translate")
        elif "scale" in step.values:
            one[[0, 1, 2], [0, 1, 2]] = step.take("scale")
        elif "rotate" in step.values:
            rotation = Table(step.take("rotate"), f"{step.where}.rotate")
            one[:3, :3] = _rotation(rotation.take("axis"), math.radians(rotation.take("angle")))
            rotation.done()
        step.done()
        whole = one @ whole
    return whole


def _rotation(axis, angle):
    """Rodrigues' formula."""
    axis = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}[axis] if isinstance(axis, str) else axis
    x, y, z = np.array(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * (cross @ cross)


class _Meshes:
    """The meshes of a scene, each once."""

    def __init__(self, tables, folder):
        self.tables = tables
        self.folder = folder
        self.all = []
        self.known = {}

    def add(self, positions, faces, uvs=None):
        """A new mesh; faces of four corners are cut from the first to the third."""
        triangles = []
        for face in faces:
            triangles += [face] if len(face) == 3 else [face[:3], [face[0], face[2], face[3]]]
        uvs = None if uvs is None else np.array(uvs, np.float32)
        self.all.append(Mesh(np.array(positions, np.float32), np.array(triangles, np.int32), uvs))
        return len(self.all) - 1

    def file(self, name):
        """The mesh of a file as the scene names it."""
        if name not in self.known:
            self.all.append(read_ply(self.folder / name))
            self.known[name] = len(self.all) - 1
        return self.known[name]

    def named(self, name):
        """One of the scene's shared meshes."""
        if name not in self.tables:
            raise Unsupported(f"no mesh {name}")
        table = Table(self.tables[name], f"meshes.{name}")
        if "file" in table.values:
            number = self.file(table.take("file"))
        elif ("name", name) in self.known:
            return self.known["name", name]
        else:
            number = self.add(table.take("positions"), table.take("indices"), table.take("uvs", None))
            self.known["name", name] = number
        table.done()
        return number


HEADER = (
    "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
    "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
)


def read_ply(path):
    """A PLY file as `cargo xtask bench scenes` writes them."""
    data = pathlib.Path(path).read_bytes()
    end = data.find(b"end_header\n") + len(b"end_header\n")
    words = data[:end].split()
    vertices, faces = (int(words[words.index(element) + 1]) for element in (b"vertex", b"face"))
    if data[:end].decode() != HEADER.format(vertices, faces):
        raise Unsupported(f"{path}: not a PLY file of the benchmark")
    positions = np.frombuffer(data, "<f4", 3 * vertices, end).reshape(-1, 3)
    rows = np.frombuffer(data, np.dtype([("n", "u1"), ("i", "<i4", 3)]), faces, end + 12 * vertices)
    return Mesh(positions, rows["i"])


def write_pfm(path, image):
    """An image (height, width, 3), rows from the top, as PFM."""
    height, width, _ = image.shape
    with open(path, "wb") as file:
        file.write(f"PF\n{width} {height}\n-1.0\n".encode())
        file.write(np.ascontiguousarray(image[::-1], "<f4").tobytes())
