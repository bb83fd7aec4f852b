"""bench-gltf: glTF samples as quiltrender and as Cycles see them, under a white sky and under a sun.

    blender -b --factory-startup --python-exit-code 1 --python gltf.py -- FOLDER... [--samples NAME,...] [--modes MODE,...]
        [--lights LIGHT,...] [--build build] [--out build/bench/gltf] [--size 120x160] [--spp 64] [--samples-per-pixel 256]

The samples (Khronos' glTF-Sample-Models, in folders of their names, or NAME.glb) are looked for under the folders; what is not there
is told and skipped. Blender reads the files by its own importer. Both look through one camera, before black, at four versions of a
file, so that mistakes can be told from differences of the models:

    matte  every material diffuse (specularFactor 0, no metal), Cycles' Diffuse BSDF: colours, their textures, normals, alpha, what
           glows, geometry; must agree
    metal  every material a white metal of roughness 0.5, Cycles' GGX, of many reflections under the sky; must agree there, and but
           for what single reflections lack under the sun
    burley ours as matte, Cycles' Principled BSDF of roughness 1 without highlights: what its diffuse share has more than Lambert's
    layers roughness three tenths of the file's (of rough dielectrics Cycles' lobes have more than microfacets reflect), Cycles'
           Diffuse and Glossy BSDFs mixed by Fresnel's equation and by metallic: our model, but for highlights' Fresnel, which
           Cycles takes at the normal; coats, sheen and glass are not in it
    whole  as the file is, Cycles' Principled BSDF: differs by what the models are (docs/lab/samples.md)

One line each: the share of the picture that the thing covers, both means there, Cycles' over ours - 1, and the rms of 8x8 blocks,
relative to the mean.
"""

import argparse
import copy
import json
import math
import os
import shutil
import struct
import subprocess
import sys

import bpy
import numpy
from mathutils import Vector

numpy.bool = bool  # Blender 3.4's importer still calls it so, numpy 1.24 no longer does

SAMPLES = ("AlphaBlendModeTest", "AnimatedCube", "Avocado", "BoomBox", "BoxTextured", "BoxVertexColors", "BrainStem", "CesiumMan",
           "CesiumMilkTruck", "ClearCoatTest", "Corset", "DamagedHelmet", "Duck", "MetalRoughSpheres", "MultiUVTest",
           "NormalTangentMirrorTest", "NormalTangentTest", "OrientationTest", "SheenChair", "TextureCoordinateTest",
           "TextureSettingsTest", "TextureTransformTest", "TransmissionTest", "TwoSidedPlane", "VertexColorTest", "WaterBottle")
MODES = ("matte", "metal", "burley", "layers", "whole")
LIGHTS = ("sky", "sun")
KEPT = ("KHR_materials_unlit", "KHR_materials_emissive_strength")
SUN = (-0.5, -1, -0.7)
SUN_ANGLE = 5
ROUGHNESS = 0.5
LAYERS_ROUGHNESS = 0.3
BLOCK = 8


# -- files -------------------------------------------------------------------------------------------------------------------------


def find(folders, name):
    """The file of a sample: its glTF rather than its GLB; None where none of the folders has it."""
    for ending in (f"{name}.gltf", f"{name}.glb"):
        for folder in folders:
            found = sorted(os.path.join(where, ending) for where, _, files in os.walk(folder) if ending in files)
            plain = [path for path in found if os.path.basename(os.path.dirname(path)) in ("glTF", "glTF-Binary")]
            if found:
                return (plain or found)[0]
    return None


def read_gltf(path):
    """The JSON of a file, and what follows it in a GLB."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"glTF":
        return json.loads(data), None
    size, = struct.unpack("<I", data[12:16])
    return json.loads(data[20:20 + size]), data[20 + size:]


def write_gltf(path, gltf, rest):
    text = json.dumps(gltf).encode()
    if rest is not None:
        text += b" " * (-len(text) % 4)
        text = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest
    with open(path, "wb") as file:
        file.write(text)


def simple(material, mode):
    """The material as a matte or a metal one."""
    material = copy.deepcopy(material)
    pbr = material.setdefault("pbrMetallicRoughness", {})
    kept = {key: value for key, value in material.get("extensions", {}).items() if key in KEPT}
    pbr.pop("metallicRoughnessTexture", None)
    material.pop("occlusionTexture", None)
    if mode != "metal":
        pbr["metallicFactor"] = 0
        kept["KHR_materials_specular"] = {"specularFactor": 0}
    else:
        pbr.update(metallicFactor=1, roughnessFactor=ROUGHNESS, baseColorFactor=[1, 1, 1, 1])
        for key in ("emissiveFactor", "emissiveTexture", "alphaMode"):
            material.pop(key, None)
        pbr.pop("baseColorTexture", None)
        kept = {}
    material["extensions"] = kept
    return material


def prepare(path, mode, out):
    """A copy of the file in a mode, with all that lies beside it."""
    gltf, rest = read_gltf(path)
    folder = os.path.join(out, "file")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name in os.listdir(os.path.dirname(path)) if rest is None else []:
        os.symlink(os.path.join(os.path.abspath(os.path.dirname(path)), name), os.path.join(folder, name))
    found = os.path.join(folder, "sample." + ("gltf" if rest is None else "glb"))
    if mode == "metal":
        for one in (one for mesh in gltf["meshes"] for one in mesh["primitives"]):
            one["attributes"].pop("COLOR_0", None)
    for material in gltf.get("materials", []) if mode == "layers" else []:
        pbr = material.setdefault("pbrMetallicRoughness", {})
        pbr["roughnessFactor"] = LAYERS_ROUGHNESS * pbr.get("roughnessFactor", 1)
    if mode not in ("whole", "layers"):
        gltf["materials"] = [simple(material, mode) for material in gltf.get("materials", [])]
        used = set(gltf.get("extensionsUsed", [])) | {"KHR_materials_specular"}
        gltf["extensionsUsed"] = sorted(used)
    write_gltf(found, gltf, rest)
    return found


# -- Cycles ------------------------------------------------------------------------------------------------------------------------


def to_blender(v):
    """y up to z up, as Blender's importer has it."""
    return Vector((v[0], -v[2], v[1]))


def settings(options):
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = options.size
    render.resolution_percentage = 100
    render.image_settings.file_format, render.image_settings.color_mode = "OPEN_EXR", "RGBA"
    render.image_settings.color_depth = "32"
    render.film_transparent = True
    cycles.device, cycles.samples = "CPU", options.samples_per_pixel
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.pixel_filter_type = "BOX"
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 64
    cycles.transparent_max_bounces = 256


def box():
    """Of all that is seen, in glTF's axes."""
    graph = bpy.context.evaluated_depsgraph_get()
    points = []
    for one in graph.object_instances:
        if one.object.type == "MESH":
            mesh = one.object.to_mesh()
            coordinates = numpy.empty(3 * len(mesh.vertices), dtype=numpy.float32)
            mesh.vertices.foreach_get("co", coordinates)
            matrix = numpy.array(one.matrix_world)
            points.append(coordinates.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])
            one.object.to_mesh_clear()
    points = numpy.concatenate(points)
    low, high = points.min(axis=0), points.max(axis=0)
    return [low[0], low[2], -high[1]], [high[0], high[2], -low[1]]


def camera_for(options):
    """A camera that sees the box, as a scene file has it."""
    low, high = (numpy.array(corner, dtype=float) for corner in box())
    middle, half = (low + high) / 2, (high - low) / 2
    width, height = options.size
    fov, pitch, yaw = 30.0, math.radians(15), math.radians(options.yaw)
    tangent = math.tan(math.radians(fov) / 2)
    towards = numpy.array([math.sin(yaw) * math.cos(pitch), math.sin(pitch), math.cos(yaw) * math.cos(pitch)])
    distance = max(half[1] / tangent, max(half[0], half[2]) / (tangent * width / height)) + max(half[2], half[0] * abs(towards[0]))
    return {"target": middle.tolist(), "position": (middle + 1.1 * distance * towards).tolist(), "fov_y": fov,
            "aspect": width / height, "views": 1, "cone": 1}


def aim(camera):
    data = bpy.data.cameras.new("peer")
    data.sensor_fit = "VERTICAL"
    data.lens = data.sensor_height / (2 * math.tan(math.radians(camera["fov_y"]) / 2))
    found = bpy.data.objects.new("peer", data)
    bpy.context.scene.collection.objects.link(found)
    position, target = to_blender(camera["position"]), to_blender(camera["target"])
    distance = (position - target).length
    data.clip_start, data.clip_end = distance / 1e3, distance * 1e3
    found.location = position
    found.rotation_euler = (target - position).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = found


def light(kind):
    world = bpy.data.worlds.new("peer")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"].inputs
    background["Color"].default_value = (1, 1, 1, 1)
    background["Strength"].default_value = 1 if kind == "sky" else 0
    bpy.context.scene.world = world
    if kind == "sun":
        data = bpy.data.lights.new("peer", "SUN")
        data.energy, data.angle = math.pi, math.radians(SUN_ANGLE)
        found = bpy.data.objects.new("peer", data)
        found.rotation_euler = to_blender(SUN).to_track_quat("-Z", "Y").to_euler()
        bpy.context.scene.collection.objects.link(found)


def same_input(tree, source, target):
    if source.is_linked:
        tree.links.new(source.links[0].from_socket, target)
    elif hasattr(source, "default_value") and target.type != "VECTOR":
        target.default_value = source.default_value


def fair_textures(tree):
    """Cycles interpolates codes of sRGB and makes light of them afterwards, which darkens every edge in a picture; the nearest
    texel has no such error, and all texels of a pixel have one mean. Where alpha does not count, colours are as they are."""
    for node in tree.nodes:
        if node.type == "TEX_IMAGE" and node.image:
            node.interpolation = "Closest"
            node.image.alpha_mode = "CHANNEL_PACKED"


def mask(material, tree, node):
    """Cycles knows no cut-off: the importer leaves it to Eevee."""
    alpha = node.inputs["Alpha"]
    if material.blend_method == "CLIP" and alpha.is_linked:
        cut = tree.nodes.new("ShaderNodeMath")
        cut.operation = "GREATER_THAN"
        tree.links.new(alpha.links[0].from_socket, cut.inputs[0])
        cut.inputs[1].default_value = material.alpha_threshold
        tree.links.new(cut.outputs[0], alpha)


def glossy(tree, node, kind):
    """White, as rough as the node says."""
    found = tree.nodes.new("ShaderNodeBsdfGlossy")
    found.distribution = "MULTI_GGX" if kind == "sky" else "GGX"
    found.inputs["Color"].default_value = (1, 1, 1, 1)
    same_input(tree, node.inputs["Roughness"], found.inputs["Roughness"])
    same_input(tree, node.inputs["Normal"], found.inputs["Normal"])
    return found


def matte(tree, node):
    found = tree.nodes.new("ShaderNodeBsdfDiffuse")
    found.inputs["Roughness"].default_value = 0
    same_input(tree, node.inputs["Base Color"], found.inputs["Color"])
    same_input(tree, node.inputs["Normal"], found.inputs["Normal"])
    return found


def mixed(tree, share, first, second):
    """share: a socket, or a number."""
    found = tree.nodes.new("ShaderNodeMixShader")
    if isinstance(share, float):
        found.inputs[0].default_value = share
    else:
        tree.links.new(share, found.inputs[0])
    tree.links.new(first.outputs[0], found.inputs[1])
    tree.links.new(second.outputs[0], found.inputs[2])
    return found


def layers(tree, node, kind):
    """Metal of the base colour, which is white where light grazes (Schlick), and a dielectric over a matte base."""
    metal, coat = glossy(tree, node, kind), glossy(tree, node, kind)
    facing, fifth, tint = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("LayerWeight", "Math", "MixRGB"))
    fifth.operation = "POWER"
    fifth.inputs[1].default_value = 5
    same_input(tree, node.inputs["Normal"], facing.inputs["Normal"])
    tree.links.new(facing.outputs["Facing"], fifth.inputs[0])
    tree.links.new(fifth.outputs[0], tint.inputs[0])
    same_input(tree, node.inputs["Base Color"], tint.inputs[1])
    tint.inputs[2].default_value = (1, 1, 1, 1)
    tree.links.new(tint.outputs[0], metal.inputs["Color"])
    fresnel = tree.nodes.new("ShaderNodeFresnel")
    fresnel.inputs["IOR"].default_value = 1.5
    same_input(tree, node.inputs["Normal"], fresnel.inputs["Normal"])
    plastic = mixed(tree, fresnel.outputs[0], matte(tree, node), coat)
    metallic = node.inputs["Metallic"]
    return mixed(tree, metallic.links[0].from_socket if metallic.is_linked else metallic.default_value, plastic, metal)


def replace(tree, node, mode, kind):
    """Instead of the Principled BSDF simpler ones, and what glows and is not there beside them."""
    if mode == "metal":
        for link in list(node.inputs["Roughness"].links):
            tree.links.remove(link)
        node.inputs["Roughness"].default_value = ROUGHNESS
    base = layers(tree, node, kind) if mode == "layers" else glossy(tree, node, kind) if mode == "metal" else matte(tree, node)
    glow, both = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeAddShader")
    same_input(tree, node.inputs["Emission"], glow.inputs["Color"])
    same_input(tree, node.inputs["Emission Strength"], glow.inputs["Strength"])
    tree.links.new(base.outputs[0], both.inputs[0])
    tree.links.new(glow.outputs[0], both.inputs[1])
    clear, mix = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeMixShader")
    same_input(tree, node.inputs["Alpha"], mix.inputs[0])
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(both.outputs[0], mix.inputs[2])
    for link in list(node.outputs[0].links):
        tree.links.new(mix.outputs[0], link.to_socket)
    tree.nodes.remove(node)


def translate(material, mode, kind):
    tree = material.node_tree
    fair_textures(tree)
    for node in [node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"]:
        mask(material, tree, node)
        node.distribution = "MULTI_GGX"
        if mode == "burley":
            for link in list(node.inputs["Roughness"].links):
                tree.links.remove(link)
            node.inputs["Specular"].default_value, node.inputs["Roughness"].default_value = 0, 1
        elif mode != "whole":
            replace(tree, node, mode, kind)


def load(path, mode, kind, options):
    """The file in Blender, lit; its camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settings(options)
    bpy.ops.import_scene.gltf(filepath=path)
    for one in list(bpy.data.objects):
        if one.type in ("CAMERA", "LIGHT") or one.name.startswith("Icosphere"):
            bpy.data.objects.remove(one)
    for material in bpy.data.materials:
        if material.use_nodes:
            translate(material, mode, kind)
    bpy.context.scene.frame_set(0)
    camera = camera_for(options)
    aim(camera)
    light(kind)
    return camera


# -- both --------------------------------------------------------------------------------------------------------------------------


def render_ours(path, camera, kind, out, options):
    lights = {"sky": {"type": "environment", "radiance": 1}} if kind == "sky" else {
        "sun": {"type": "distant", "direction": SUN, "irradiance": math.pi, "angle": SUN_ANGLE}}
    scene = {"camera": camera, "meshes": {"sample": {"file": path}}, "lights": lights, "backdrop": 0, "render": {"max_depth": 64}}
    file = os.path.join(out, "scene.json")
    with open(file, "w", encoding="utf-8") as text:
        json.dump(scene, text)
    width, height = options.size
    stats = os.path.join(out, "stats.json")
    subprocess.run([os.path.join(options.build, "quiltrender"), file, "-o", os.path.join(out, "ours.exr"), "--quilt", "1x1",
                    "--view-size", f"{width}x{height}", "--spp", str(options.spp), "--stats", stats],
                   check=True, capture_output=True)
    found, = (name for name in os.listdir(out) if name.startswith("ours") and name.endswith(".exr"))
    return pixels(os.path.join(out, found)), stats


def render_cycles(out):
    path = os.path.join(out, "cycles.exr")
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return pixels(path)


def pixels(path):
    """[height][width][4], linear, the bottom row first."""
    image = bpy.data.images.load(path, check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    width, height = image.size
    found = numpy.empty(width * height * 4, dtype=numpy.float32)
    image.pixels.foreach_get(found)
    bpy.data.images.remove(image)
    return found.reshape(height, width, 4).astype(float)


def blocks(values):
    height, width = (side // BLOCK * BLOCK for side in values.shape[:2])
    cut = values[:height, :width]
    return cut.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, -1).mean(axis=(1, 3))


def compare(ours, theirs):
    """Where Cycles sees something: share, means, ratio - 1, rms of blocks."""
    seen = theirs[:, :, 3]
    a, b = ours[:, :, :3], theirs[:, :, :3]
    mean_a, mean_b = (x.sum() / (3 * seen.sum()) for x in (a, b))
    where = blocks(seen)[:, :, 0] > 0.5
    difference = (blocks(b) - blocks(a))[where]
    rms = math.sqrt((difference ** 2).mean()) / mean_a if len(difference) else math.nan
    return seen.mean(), mean_a, mean_b, mean_b / mean_a - 1, rms


def measure(name, path, mode, kind, options):
    out = os.path.join(os.path.abspath(options.out), f"{name}-{mode}-{kind}")
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    file = prepare(path, mode, out)
    camera = load(file, mode, kind, options)
    ours, stats = render_ours(file, camera, kind, out, options)
    share, a, b, ratio, rms = compare(ours, render_cycles(out))
    with open(stats, encoding="utf-8") as text:
        cpu = json.load(text)["cpu_seconds"]
    say(f"{name:24} {mode:6} {kind:4} {100 * share:6.1f} %  {a:8.4f} {b:8.4f}  {100 * ratio:+7.2f} %  {100 * rms:6.2f} %  {cpu:7.2f} s")


def say(text):
    print("GLTF " + text, flush=True)


def parse(arguments):
    parser = argparse.ArgumentParser(prog="gltf.py")
    add = parser.add_argument
    words = lambda text: text.split(",")
    add("folders", nargs="+", metavar="FOLDER")
    add("--samples", type=words, default=SAMPLES)
    add("--modes", type=words, default=MODES)
    add("--lights", type=words, default=LIGHTS)
    add("--build", default="build")
    add("--out", default="build/bench/gltf")
    add("--size", type=lambda text: [int(side) for side in text.split("x")], default=[120, 160])
    add("--yaw", type=float, default=20)
    add("--spp", type=int, default=64)
    add("--samples-per-pixel", type=int, default=256)
    return parser.parse_args(arguments)


def main():
    options = parse(sys.argv[sys.argv.index("--") + 1:])
    say(f"{'sample':24} {'mode':6} light seen        ours   Cycles  Cycles/ours-1  rms of blocks  CPU")
    for name in options.samples:
        path = find(options.folders, name)
        if not path:
            say(f"{name:24} not under {' '.join(options.folders)}: skipped")
            continue
        for mode in options.modes:
            for kind in options.lights:
                try:
                    measure(name, path, mode, kind, options)
                except (RuntimeError, subprocess.CalledProcessError, OSError) as problem:
                    said = getattr(problem, "stderr", None) or str(problem).encode()
                    say(f"{name:24} {mode:6} {kind:4} {said.decode().strip().splitlines()[-1]}")
                    break


main()
