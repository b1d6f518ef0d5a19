"""Mitsuba 3 as the other renderer: finding it, giving it a scene, timing it. Run by `cargo xtask bench render --peers`."""

import os
import pathlib
import sys
import tempfile
import time

import numpy as np

import scene as scenes
import turns

VERSION = "3.9.1"
VARIANT = "llvm_ad_rgb"
# The fastest to equal error of its samplers: half the error of independent samples in the same time on the Cornell box at 64.
SAMPLER = "multijitter"
# Of thousands of instances the vectorised variant takes many minutes to make its kernels.
VARIANT_OF_INSTANCES = "scalar_rgb"
LLVM_NAMES = ("libLLVM-19.so", "libLLVM.so.19.1")
LLVM_FOLDERS = (
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib/llvm-19/lib",
    "/usr/lib64",
    "/usr/lib",
)
INSTALL_LLVM = """Mitsuba's llvm variants need LLVM 19 (older ones fail to load or abort):
    apt-get install libllvm19
or set DRJIT_LIBLLVM_PATH to a libLLVM-19.so."""

# A mesh that more objects than this share is instanced; fewer copies are faster without.
FEW_COPIES = 16
# Samples per pixel of one call: more do not fit into its 32-bit count of lanes at 1024 x 1024.
MOST_SAMPLES = 1024


def start(variant, threads):
    """The `mitsuba` module, set up. Ends with instructions if something is missing."""
    if variant.startswith("llvm") and "DRJIT_LIBLLVM_PATH" not in os.environ:
        found = [p for f in LLVM_FOLDERS for n in LLVM_NAMES if (p := pathlib.Path(f) / n).exists()]
        if not found:
            sys.exit(INSTALL_LLVM)
        os.environ["DRJIT_LIBLLVM_PATH"] = str(found[0])
    import mitsuba as mi

    if mi.__version__ != VERSION:
        sys.exit(f"Mitsuba {VERSION} is wanted, this is {mi.__version__}")
    mi.set_variant(variant)
    import drjit as dr

    # With one thread its pool has been seen to hang: to compare single threads, pin two to one core.
    dr.set_thread_count(max(2, threads))
    mi.set_log_level(mi.LogLevel.Warn)
    return mi


def fresh_kernel_cache():
    """Compiled kernels are kept in the home directory: an empty one makes the first render's time mean something."""
    home = tempfile.TemporaryDirectory(prefix="etendue-bench-")
    os.environ["HOME"] = home.name
    return home


class Renderer:
    """One scene in Mitsuba, rendered any number of times."""

    def __init__(self, mi, path, size=None, max_depth=None, sampler="independent"):
        self.mi = mi
        begin = time.perf_counter()
        scene = scenes.read(path)
        with tempfile.TemporaryDirectory(prefix="etendue-bench-") as scratch:
            parts = _Converter(mi, scene, pathlib.Path(scratch)).parts(size, max_depth, sampler)
        loaded = time.perf_counter()
        self.scene = mi.load_dict(parts)
        self.load_seconds = loaded - begin
        self.build_seconds = time.perf_counter() - loaded

    def render(self, spp, seed):
        """The image, float32 of shape (height, width, 3), and the seconds it took."""
        import drjit as dr

        begin = time.perf_counter()
        calls = -(-spp // MOST_SAMPLES)
        image = 0
        for call in range(calls):
            part = spp // calls + (call < spp % calls)
            image += np.array(self.mi.render(self.scene, spp=part, seed=seed * 4096 + call)) * (part / spp)
            dr.sync_thread()
        return image, time.perf_counter() - begin


class _Converter:
    """A neutral scene as Mitsuba's objects."""

    def __init__(self, mi, scene, scratch):
        self.mi, self.scene, self.scratch = mi, scene, scratch
        self.medium = None

    def parts(self, size, max_depth, sampler):
        """The dictionary for `mi.load_dict`: meshes are loaded, nothing is built."""
        scene = self.scene
        depth = scene.depth if max_depth is None else max_depth
        integrator = {"type": "volpath" if scene.medium else "path", "max_depth": -1 if depth is None else depth}
        result = {"type": "scene", "integrator": integrator}
        if scene.medium:
            result["medium"] = self.medium = self.mi.load_dict(self.fog())
        result["sensor"] = self.sensor(size or scene.size, sampler)
        copies = counts(scene)
        groups = {}
        for index, entry in enumerate(scene.objects):
            if copies[entry.mesh] <= FEW_COPIES:
                result[f"object{index}"] = self.mi.load_dict(self.shape(entry, index))
                continue
            if entry.mesh not in groups:
                shape = self.shape(scenes.Object(entry.mesh, entry.material, np.eye(4)), index)
                groups[entry.mesh] = self.mi.load_dict({"type": "shapegroup", "shape": shape})
                result[f"group{entry.mesh}"] = groups[entry.mesh]
            place = self.mi.ScalarTransform4f(entry.matrix)
            result[f"object{index}"] = {"type": "instance", "to_world": place, "group": groups[entry.mesh]}
        for index, (position, intensity) in enumerate(scene.points):
            result[f"light{index}"] = {"type": "point", "position": position, "intensity": rgb(intensity)}
        if isinstance(scene.environment, pathlib.Path):
            result["sky"] = {"type": "envmap", "filename": str(scene.environment)}
        elif scene.environment is not None:
            result["sky"] = {"type": "constant", "radiance": rgb(scene.environment)}
        return result

    def sensor(self, size, sampler):
        camera = self.scene.camera
        look = self.mi.ScalarTransform4f().look_at(origin=camera.position, target=camera.target, up=camera.up)
        sensor = {
            "type": "perspective",
            "fov": camera.fov,
            "fov_axis": "x",
            "to_world": look,
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
            "sampler": {"type": sampler},
        }
        if self.medium:
            sensor["medium"] = self.medium
        return sensor

    def fog(self):
        medium = self.scene.medium
        total = [s + a for s, a in zip(medium.scattering, medium.absorption)]
        if len(set(total)) != 1:
            raise scenes.Unsupported("only grey media are converted")
        albedo = [s / t for s, t in zip(medium.scattering, total)]
        phase = {"type": "hg", "g": medium.g} if medium.g else {"type": "isotropic"}
        return {"type": "homogeneous", "sigma_t": total[0], "albedo": rgb(albedo), "phase": phase}

    def shape(self, entry, index):
        mesh = self.scene.meshes[entry.mesh].placed(entry.matrix)
        path = self.scratch / f"{index}.ply"
        write_ply(path, mesh)
        material = self.scene.materials[entry.material]
        shape = {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": self.bsdf(material)}
        if material.emission:
            shape["emitter"] = {"type": "area", "radiance": rgb(material.emission)}
            if self.medium:
                shape["exterior"] = self.medium
                shape["emitter"]["medium"] = self.medium
        return shape

    def bsdf(self, material):
        kind = material.kind
        if kind in ("glass", "rough-glass"):
            body = {"int_ior": material.ior, "ext_ior": 1.0}
            rough = {"type": "roughdielectric", "distribution": "ggx", "alpha": material.alpha}
            return ({"type": "dielectric"} if kind == "glass" else rough) | body
        if kind == "rough-metal":
            bsdf = {"type": "roughconductor", "distribution": "ggx", "alpha": material.alpha}
            bsdf |= {"eta": rgb(material.eta), "k": rgb(material.k)}
        elif kind == "mirror":
            bsdf = {"type": "conductor", "material": "none", "specular_reflectance": self.color(material.color)}
        else:
            reflectance = rgb([0.0] * 3) if kind == "black" else self.color(material.color)
            bsdf = {"type": "diffuse", "reflectance": reflectance}
        # What is opaque is black from behind otherwise.
        return {"type": "twosided", "bsdf": bsdf}

    def color(self, value):
        if isinstance(value, scenes.Texture):
            return {"type": "bitmap", "filename": str(value.file), "raw": True, "filter_type": "bilinear"}
        return rgb(value)


def counts(scene):
    """How many objects have each mesh."""
    return np.bincount([o.mesh for o in scene.objects], minlength=len(scene.meshes))


def rgb(value):
    return {"type": "rgb", "value": [float(v) for v in value]}


def write_ply(path, mesh):
    """A PLY file; its texture coordinates run downward in Mitsuba."""
    fields = [("p", "<f4", 3)] + ([("t", "<f4", 2)] if mesh.uvs is not None else [])
    vertices = np.zeros(len(mesh.vertices), np.dtype(fields))
    vertices["p"] = mesh.vertices
    names = ["x", "y", "z"]
    if mesh.uvs is not None:
        vertices["t"] = mesh.uvs * [1, -1] + [0, 1]
        names += ["s", "t"]
    faces = np.zeros(len(mesh.faces), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    faces["n"], faces["i"] = 3, mesh.faces
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
    header += "".join(f"property float {name}\n" for name in names)
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    path.write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())


def main():
    cache = fresh_kernel_cache()
    state = {}

    def load(request):
        if "mi" not in state:
            state["mi"] = start(VARIANT, request["threads"])
        state.pop("renderer", None)
        many = counts(scenes.read(request["scene"])).max() > FEW_COPIES
        variant = VARIANT_OF_INSTANCES if many else VARIANT
        state["mi"].set_variant(variant)
        renderer = state["renderer"] = Renderer(state["mi"], request["scene"], request["size"], sampler=SAMPLER)
        name = f"Mitsuba {VERSION} {variant}"
        return {"load": renderer.load_seconds, "build": renderer.build_seconds, "name": name}

    def render(request):
        image, seconds = state["renderer"].render(request["spp"], request["seed"])
        scenes.write_pfm(request["output"], image)
        return {"render": seconds}

    turns.serve(load, render)
    cache.cleanup()


if __name__ == "__main__":
    main()
