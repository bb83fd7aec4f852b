"""Renders single views of a quiltd scene with Cycles, on request.

    blender -b --factory-startup --python-exit-code 1 --python cycles.py -- SCENE.json WIDTH HEIGHT THREADS STEP_RATE

Understands what the peers' scenes use (docs/reference/scene-format.md): grids, .obj meshes and quads, diffuse materials, a constant sky, distant
lights. Anything else ends it with a line that says what. Blender takes the scene's coordinates as they are: nothing in Cycles
prefers an axis, so y stays up.

Requests come on stdin, one JSON object a line: {"view": k, "samples": n, "seed": s, "file": "OUT.exr"}. Answers go to stdout as
PEERS {"cpu_seconds": c, "seconds": t}, of the whole call: reading the grid, building the hierarchy, rendering, writing the file.
What a sample costs is the difference between two counts of samples. Before any request there is an empty answer, PEERS {}.
"""

import json
import math
import os
import resource
import sys
import time

import bpy
from mathutils import Matrix, Vector


class Unsupported(Exception):
    pass


def known(where, thing, *keys):
    for key in thing:
        if key not in keys + ("comment", "$schema"):
            raise Unsupported(f"{where}: {key}: not translated for Cycles")


def grey(value):
    """A colour of the scene as red, green, blue."""
    return [value] * 3 if isinstance(value, (int, float)) else value


def rgba(value):
    return grey(value) + [1]


def transform_matrix(where, transform):
    """Scale, then rotations about x, y, z, then translation."""
    known(where, transform, "scale", "rotate", "translate")
    x, y, z = (Matrix.Rotation(math.radians(a), 4, axis) for a, axis in zip(transform.get("rotate", [0, 0, 0]), "XYZ"))
    scale = Matrix.Diagonal(rgba(transform.get("scale", 1)))
    return Matrix.Translation(transform.get("translate", [0, 0, 0])) @ z @ y @ x @ scale


def place(where, data, thing):
    found = bpy.data.objects.new(data.name, data)
    found.matrix_world = transform_matrix(where, thing.get("transform", {}))
    bpy.context.scene.collection.objects.link(found)
    return found


def shader(name, kind, output, **inputs):
    """A material whose only node is of this kind."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    node = nodes.new(kind)
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    links.new(node.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs[output])
    return material


def add_volume(name, volume, folder):
    where = f"/volumes/{name}"
    known(where, volume, "file", "grid", "scale", "albedo", "g", "transform")
    data = bpy.data.volumes.new(name)
    data.filepath = os.path.join(folder, volume["file"])
    data.render.space = "WORLD"
    data.render.precision = "FULL"
    data.render.clipping = 0
    grid = volume.get("grid", "density")
    # the node multiplies its density by the grid's and scatters the share that its colour says, absorbing the rest
    material = shader(name, "ShaderNodeVolumePrincipled", "Volume", Color=rgba(volume.get("albedo", 1)),
                      Density=volume.get("scale", 1), Density_Attribute=grid, Anisotropy=volume.get("g", 0))
    material.cycles.volume_sampling = "MULTIPLE_IMPORTANCE"
    material.cycles.volume_interpolation = "LINEAR"
    data.materials.append(material)
    found = place(where, data, volume)
    if not data.grids.load() or grid not in [one.name for one in data.grids]:
        raise Unsupported(f"{data.filepath}: Blender finds no such grid: {data.grids.error_message}")
    # Cycles 3.4 puts the values of a grid in the middle between its indices, half a voxel too far along every axis
    to_object = next(one.matrix_object for one in data.grids if one.name == grid)
    found.matrix_world = found.matrix_world @ Matrix.Translation(to_object.to_3x3() @ Vector((-0.5, -0.5, -0.5)))


def quad():
    data = bpy.data.meshes.new("quad")
    data.from_pydata([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)], [], [(0, 1, 2, 3)])
    return data


def import_mesh(path):
    before = set(bpy.data.objects)
    bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
    found, = set(bpy.data.objects) - before
    data = found.data
    bpy.data.objects.remove(found)
    data.materials.clear()
    return data


def add_mesh(name, mesh, folder, materials):
    where = f"/meshes/{name}"
    known(where, mesh, "file", "shape", "material", "normals", "transform")
    if "file" in mesh:
        data = import_mesh(os.path.join(folder, mesh["file"]))
        if mesh.get("normals") != "flat":
            raise Unsupported(f"{where}: normals: flat ones alone are translated for Cycles")
        data.free_normals_split()
        data.polygons.foreach_set("use_smooth", [False] * len(data.polygons))
    elif mesh.get("shape") == "quad":
        data = quad()
    else:
        raise Unsupported(f"{where}: this shape is not translated for Cycles")
    data.materials.append(materials[mesh["material"]])
    place(where, data, mesh)


def make_material(name, material):
    known(f"/materials/{name}", material, "type", "albedo")
    if material.get("type", "diffuse") != "diffuse":
        raise Unsupported(f"/materials/{name}: type: diffuse alone is translated for Cycles")
    return shader(name, "ShaderNodeBsdfDiffuse", "Surface", Color=rgba(material.get("albedo", 0.5)), Roughness=0)


def add_light(name, light):
    where = f"/lights/{name}"
    if light["type"] == "environment":
        known(where, light, "type", "radiance")
        world = bpy.data.worlds.new(name)
        world.use_nodes = True
        world.node_tree.nodes["Background"].inputs["Color"].default_value = rgba(light["radiance"])
        bpy.context.scene.world = world
    elif light["type"] == "distant":
        known(where, light, "type", "direction", "irradiance", "angle")
        data = bpy.data.lights.new(name, "SUN")
        data.energy = 1
        data.color = grey(light["irradiance"])
        data.angle = math.radians(light.get("angle", 0))
        found = place(where, data, {})
        found.matrix_world = Vector(light["direction"]).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    else:
        raise Unsupported(f"{where}: type: {light['type']} is not translated for Cycles")


def add_camera(camera):
    known("/camera", camera, "target", "position", "up", "fov_y", "aspect", "views", "cone", "placement")
    data = bpy.data.cameras.new("view")
    data.sensor_fit = "VERTICAL"
    data.clip_start, data.clip_end = 1e-3, 1e5
    data.lens = data.sensor_height / (2 * math.tan(math.radians(camera.get("fov_y", 14)) / 2))
    found = bpy.data.objects.new("view", data)
    bpy.context.scene.collection.objects.link(found)
    bpy.context.scene.camera = found


def aim_camera(camera, view):
    """The off-axis frustum of a view: moved along the rig, and its window moved back by as much (in heights of the window)."""
    found = bpy.context.scene.camera
    position, target = Vector(camera.get("position", [0, 0, 5])), Vector(camera.get("target", [0, 0, 0]))
    back = (position - target).normalized()
    right = Vector(camera.get("up", [0, 1, 0])).cross(back).normalized()
    n, distance = camera.get("views", 45), (position - target).length
    share = view / (n - 1) if camera.get("placement", "centred") == "inclusive" else (view + 0.5) / n
    offset = distance * math.tan(math.radians((share - 0.5) * camera.get("cone", 40)))
    place_at = position + offset * right
    found.matrix_world = Matrix((right, back.cross(right), back)).transposed().to_4x4()
    found.matrix_world.translation = place_at
    window = 2 * distance * math.tan(math.radians(camera.get("fov_y", 14)) / 2)
    found.data.shift_x = -offset / window


def settings(width, height, threads, step_rate, depth):
    """No denoiser, no adaptive sampling, no clamping, box filter; paths as long as Cycles allows (1024)."""
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.threads_mode, render.threads = "FIXED", threads
    render.use_persistent_data = True
    image = render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGB", "32", "ZIP"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_auto_tile = cycles.use_guiding = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.pixel_filter_type = "BOX"
    cycles.volume_step_rate, cycles.volume_max_steps = step_rate, 65536
    for bounces in ("max", "diffuse", "volume", "transparent_max"):
        setattr(cycles, f"{bounces}_bounces", min(depth, 1024))


def build(path, width, height, threads, step_rate):
    with open(path, encoding="utf-8") as file:
        scene = json.load(file)
    known(path, scene, "quiltd", "camera", "volumes", "meshes", "materials", "lights", "film", "render")
    folder = os.path.dirname(os.path.abspath(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settings(width, height, threads, step_rate, scene.get("render", {}).get("max_depth", 1024))
    for name, volume in scene.get("volumes", {}).items():
        add_volume(name, volume, folder)
    materials = {name: make_material(name, material) for name, material in scene.get("materials", {}).items()}
    for name, mesh in scene.get("meshes", {}).items():
        add_mesh(name, mesh, folder, materials)
    for name, light in scene["lights"].items():
        add_light(name, light)
    add_camera(scene["camera"])
    return scene["camera"]


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def answer(request, camera):
    scene = bpy.context.scene
    aim_camera(camera, request["view"])
    scene.cycles.samples, scene.cycles.seed = request["samples"], request["seed"]
    scene.render.filepath = request["file"]
    cpu, start = cpu_seconds(), time.monotonic()
    bpy.ops.render.render(write_still=True)
    return {"cpu_seconds": cpu_seconds() - cpu, "seconds": time.monotonic() - start}


def main(arguments):
    camera = build(arguments[0], int(arguments[1]), int(arguments[2]), int(arguments[3]), float(arguments[4]))
    print("PEERS {}", flush=True)
    for line in sys.stdin:
        print("PEERS " + json.dumps(answer(json.loads(line), camera)), flush=True)


try:
    main(sys.argv[sys.argv.index("--") + 1:])
except (Unsupported, OSError, ValueError) as problem:
    print(f"cycles.py: {problem}", file=sys.stderr)
    sys.exit(1)
