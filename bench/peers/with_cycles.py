"""Blender's Cycles as the other renderer, through the module `bpy`. Run by `cargo xtask bench render --peers`."""

import math
import pathlib
import tempfile
import time

import bpy
import mathutils
import numpy as np

import scene as scenes
import turns


class Renderer:
    """One scene in Cycles, rendered any number of times. Each render makes its acceleration structures anew, so that their
    time is in the render's."""

    def __init__(self, path, size, threads):
        begin = time.perf_counter()
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.blender = bpy.context.scene
        scene = scenes.read(path)
        settings(self.blender, size or scene.size, scene.depth, threads)
        _Converter(self.blender, scene).add_all()
        self.folder = tempfile.TemporaryDirectory(prefix="etendue-bench-")
        self.load_seconds = time.perf_counter() - begin

    def render(self, spp, seed):
        """The image, float32 of shape (height, width, 3), rows from the top, and the seconds it took."""
        self.blender.cycles.samples = spp
        self.blender.cycles.seed = seed
        begin = time.perf_counter()
        bpy.ops.render.render()
        seconds = time.perf_counter() - begin
        path = f"{self.folder.name}/picture.exr"
        bpy.data.images["Render Result"].save_render(path)
        picture = bpy.data.images.load(path)
        picture.colorspace_settings.name = "Non-Color"
        width, height = picture.size
        values = np.empty(width * height * 4, np.float32)
        picture.pixels.foreach_get(values)
        bpy.data.images.remove(picture)
        return values.reshape(height, width, 4)[::-1, :, :3], seconds


def settings(blender, size, depth, threads):
    """The same film, filter and path length as the others; nothing that changes what is estimated."""
    blender.render.engine = "CYCLES"
    blender.render.resolution_x, blender.render.resolution_y = size
    blender.render.resolution_percentage = 100
    blender.render.threads_mode = "FIXED"
    blender.render.threads = threads
    blender.render.use_persistent_data = False
    image = blender.render.image_settings
    image.file_format = "OPEN_EXR"
    image.color_depth = "32"
    image.exr_codec = "NONE"
    cycles = blender.cycles
    cycles.device = "CPU"
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.light_sampling_threshold = 0
    cycles.use_guiding = False
    cycles.use_light_tree = True
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1
    bounces = 1024 if depth is None else depth - 2
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = bounces
    cycles.transmission_bounces = cycles.volume_bounces = cycles.transparent_max_bounces = bounces


class _Converter:
    """A neutral scene as Blender's objects; coordinates stay as they are, y up."""

    def __init__(self, blender, scene):
        self.blender, self.scene = blender, scene
        self.materials = {name: self.material(name, value) for name, value in scene.materials.items()}
        self.meshes = {}

    def add_all(self):
        self.camera()
        for index, entry in enumerate(self.scene.objects):
            thing = bpy.data.objects.new(f"object{index}", self.mesh(entry))
            thing.matrix_world = mathutils.Matrix(entry.matrix.tolist())
            self.blender.collection.objects.link(thing)
        if self.scene.points:
            raise scenes.Unsupported("lights without extent are not converted")
        self.world()

    def camera(self):
        camera = self.scene.camera
        data = bpy.data.cameras.new("camera")
        data.sensor_fit = "HORIZONTAL"
        data.angle = math.radians(camera.fov)
        data.clip_start, data.clip_end = 1e-3, 1e5
        position, target, up = (mathutils.Vector(v) for v in (camera.position, camera.target, camera.up))
        back = (position - target).normalized()
        right = up.cross(back).normalized()
        rows = zip(right, back.cross(right), back, position)
        thing = bpy.data.objects.new("camera", data)
        thing.matrix_world = mathutils.Matrix([*map(list, rows), [0, 0, 0, 1]])
        self.blender.collection.objects.link(thing)
        self.blender.camera = thing

    def mesh(self, entry):
        """Blender's mesh; objects that share one are instances."""
        key = entry.mesh, entry.material
        if key not in self.meshes:
            source = self.scene.meshes[entry.mesh]
            mesh = bpy.data.meshes.new(f"mesh{len(self.meshes)}")
            corners = source.faces.reshape(-1)
            mesh.vertices.add(len(source.vertices))
            mesh.vertices.foreach_set("co", source.vertices.reshape(-1))
            mesh.loops.add(len(corners))
            mesh.loops.foreach_set("vertex_index", corners)
            mesh.polygons.add(len(source.faces))
            mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
            if source.uvs is not None:
                layer = mesh.uv_layers.new(name="uv")
                layer.uv.foreach_set("vector", source.uvs[corners].reshape(-1))
            mesh.update(calc_edges=True)
            mesh.shade_flat()
            mesh.materials.append(self.materials[entry.material])
            self.meshes[key] = mesh
        return self.meshes[key]

    def material(self, name, value):
        material = bpy.data.materials.new(name)
        tree = _Tree(material.node_tree)
        surface = self.surface(tree, value)
        if value.emission:
            material.cycles.emission_sampling = "FRONT"
            front = tree.emission(value.emission)
            if surface is not None:
                front = tree.join("ShaderNodeAddShader", surface, front)
            front_or_back = tree.add("ShaderNodeMixShader")
            tree.link(tree.add("ShaderNodeNewGeometry").outputs["Backfacing"], front_or_back.inputs[0])
            tree.link(front, front_or_back.inputs[1])
            if surface is not None:
                tree.link(surface, front_or_back.inputs[2])
            surface = front_or_back.outputs[0]
        if surface is not None:
            tree.link(surface, tree.add("ShaderNodeOutputMaterial").inputs["Surface"])
        return material

    def surface(self, tree, value):
        """What scatters, as an output of a node; None where nothing does."""
        roughness = math.sqrt(value.alpha)
        if value.kind == "black":
            return None
        if value.kind == "diffuse":
            node = tree.add("ShaderNodeBsdfDiffuse")
            node.inputs["Roughness"].default_value = 0
            self.color(tree, value.color, node.inputs["Color"])
        elif value.kind == "mirror":
            node = tree.add("ShaderNodeBsdfAnisotropic")
            node.distribution = "GGX"
            node.inputs["Roughness"].default_value = 0
            self.color(tree, value.color, node.inputs["Color"])
        elif value.kind in ("glass", "rough-glass"):
            node = tree.add("ShaderNodeBsdfGlass")
            node.distribution = "GGX"
            node.inputs["Color"].default_value = (1, 1, 1, 1)
            node.inputs["Roughness"].default_value = roughness
            node.inputs["IOR"].default_value = value.ior
        else:
            node = tree.add("ShaderNodeBsdfMetallic")
            node.distribution = "GGX"
            node.fresnel_type = "PHYSICAL_CONDUCTOR"
            node.inputs["Roughness"].default_value = roughness
            node.inputs["IOR"].default_value = value.eta
            node.inputs["Extinction"].default_value = value.k
        return node.outputs[0]

    def color(self, tree, value, socket):
        if isinstance(value, scenes.Texture):
            node = tree.add("ShaderNodeTexImage")
            node.image = bpy.data.images.load(str(value.file), check_existing=True)
            node.image.colorspace_settings.name = "Non-Color"
            node.interpolation = "Linear"
            tree.link(node.outputs["Color"], socket)
        else:
            socket.default_value = (*value, 1)

    def world(self):
        world = self.blender.world = bpy.data.worlds.new("world")
        tree = _Tree(world.node_tree)
        output = tree.add("ShaderNodeOutputWorld")
        background = tree.add("ShaderNodeBackground")
        environment = self.scene.environment
        if isinstance(environment, pathlib.Path):
            picture = tree.add("ShaderNodeTexEnvironment")
            picture.image = bpy.data.images.load(str(environment))
            picture.image.colorspace_settings.name = "Linear Rec.709"
            # Its panoramas have z up and +x in the middle, ours y up and +z.
            turn = tree.add("ShaderNodeMapping")
            turn.inputs["Rotation"].default_value = (math.pi / 2, 0, math.pi / 2)
            tree.link(tree.add("ShaderNodeTexCoord").outputs["Generated"], turn.inputs["Vector"])
            tree.link(turn.outputs[0], picture.inputs["Vector"])
            tree.link(picture.outputs["Color"], background.inputs["Color"])
        else:
            background.inputs["Color"].default_value = (*(environment or (0, 0, 0)), 1)
        tree.link(background.outputs[0], output.inputs["Surface"])
        if self.scene.medium:
            tree.link(self.fog(tree), output.inputs["Volume"])

    def fog(self, tree):
        """Grey coefficients, as two nodes that add up."""
        medium = self.scene.medium
        if len({*medium.scattering}) != 1 or len({*medium.absorption}) != 1:
            raise scenes.Unsupported("only grey media are converted")
        scatter = tree.add("ShaderNodeVolumeScatter")
        scatter.inputs["Color"].default_value = (1, 1, 1, 1)
        scatter.inputs["Density"].default_value = medium.scattering[0]
        scatter.inputs["Anisotropy"].default_value = medium.g
        absorb = tree.add("ShaderNodeVolumeAbsorption")
        absorb.inputs["Color"].default_value = (0, 0, 0, 1)
        absorb.inputs["Density"].default_value = medium.absorption[0]
        return tree.join("ShaderNodeAddShader", scatter.outputs[0], absorb.outputs[0])


class _Tree:
    """An empty tree of nodes."""

    def __init__(self, tree):
        self.tree = tree
        tree.nodes.clear()

    def add(self, kind):
        return self.tree.nodes.new(kind)

    def link(self, output, socket):
        self.tree.links.new(output, socket)

    def join(self, kind, a, b):
        node = self.add(kind)
        self.link(a, node.inputs[0])
        self.link(b, node.inputs[1])
        return node.outputs[0]

    def emission(self, radiance):
        """Colours above 1 are clipped by some nodes: the strength carries the size."""
        node = self.add("ShaderNodeEmission")
        strength = max(radiance)
        node.inputs["Color"].default_value = (*(r / strength for r in radiance), 1)
        node.inputs["Strength"].default_value = strength
        return node.outputs[0]


def main():
    state = {}

    def load(request):
        renderer = state["renderer"] = Renderer(request["scene"], request["size"], request["threads"])
        return {"load": renderer.load_seconds, "build": 0.0, "name": f"Cycles {bpy.app.version_string}"}

    def render(request):
        image, seconds = state["renderer"].render(request["spp"], request["seed"])
        scenes.write_pfm(request["output"], image)
        return {"render": seconds}

    turns.serve(load, render)


if __name__ == "__main__":
    main()
