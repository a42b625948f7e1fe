"""Makes two materials of Blender from the textures beside this file, and saves them as an asset library.

In Blender: workspace Scripting, Text > Open, this file, Text > Run Script. The materials are then in the open scene,
and {{NAME}}.blend beside this file holds them for other scenes (File > Append, or the folder as an asset library in
the preferences). Without a window:

    blender --background --python {{NAME}}.py

or `python {{NAME}}.py` with Blender's own module: `pip install bpy==5.0.1` (Python 3.11). It writes {{NAME}}.blend, or
the file that is named after `--`, with a ball in the scene.

PBR is a Principled BSDF for Cycles and EEVEE. The power law looks the material up outside the integral, by what Shader
to RGB has gathered, so it is for EEVEE alone: r = sigma * luminance(light), S = scale * (r / r_max) ** exponent.

{{LOSS}}
"""

import json
import sys
from pathlib import Path

import bpy

MATERIAL = json.loads(r"""{{MATERIAL}}""")
FILE = "{{NAME}}.py"
LUMINANCE = (0.21263900587151036, 0.71516867876775593, 0.072192315360733714)


def find_folder():
    """The folder of this file; Blender's text editor gives it no place of its own, but knows which file it opened."""
    opened = [Path(bpy.path.abspath(text.filepath)) for text in bpy.data.texts if text.filepath]
    for file in [Path(__file__).resolve(), *opened]:
        if file.name == FILE and (file.parent / "textures").is_dir():
            return file.parent
    raise FileNotFoundError(f"The folder textures does not lie beside {FILE}: copy both together")


HERE = find_folder()


def new_material(name):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.node_tree.nodes.clear()
    made.use_fake_user = True
    return made, made.node_tree.nodes, made.node_tree.links


def place(nodes, links):
    """Texture coordinates that repeat the material."""
    coordinates, mapping = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMapping")
    mapping.label = "Repeats"
    mapping.inputs["Scale"].default_value = (MATERIAL["repeats"],) * 3
    links.new(coordinates.outputs["UV"], mapping.inputs["Vector"])
    return mapping.outputs["Vector"]


def texture(nodes, links, where, file, space):
    node = nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(str(HERE / "textures" / file), check_existing=True)
    node.image.colorspace_settings.name = space
    node.interpolation, node.extension = "Linear", "REPEAT"
    links.new(where, node.inputs["Vector"])
    return node.outputs["Color"]


def pbr():
    made, nodes, links = new_material(MATERIAL["name"])
    if hasattr(made, "cycles"):
        made.cycles.use_bump_map_correction = False  # it darkens steep slopes, which were measured as they look
    where, surface = place(nodes, links), nodes.new("ShaderNodeBsdfPrincipled")
    surface.distribution = "GGX"
    surface.inputs["IOR"].default_value = MATERIAL["ior"]
    links.new(texture(nodes, links, where, "base_color.png", "sRGB"), surface.inputs["Base Color"])
    for name in ("Roughness", "Metallic"):
        links.new(texture(nodes, links, where, f"{name.lower()}.png", "Non-Color"), surface.inputs[name])
    bent = nodes.new("ShaderNodeNormalMap")
    links.new(texture(nodes, links, where, "normal.png", "Non-Color"), bent.inputs["Color"])
    links.new(bent.outputs["Normal"], surface.inputs["Normal"])
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    return made


def number(nodes, links, operation, *inputs):
    node = nodes.new("ShaderNodeMath")
    node.operation = operation
    for at, value in enumerate(inputs):
        if isinstance(value, (int, float)):
            node.inputs[at].default_value = value
        else:
            links.new(value, node.inputs[at])
    return node.outputs["Value"]


def channels(nodes, links, colour):
    node = nodes.new("ShaderNodeSeparateColor")
    links.new(colour, node.inputs["Color"])
    return [node.outputs[name] for name in ("Red", "Green", "Blue")]


def look_up(nodes, links, light, scale, exponent):
    """Emission of the colours S(r) L / r, for L = sigma * light and r its luminance."""
    parts = channels(nodes, links, light)
    weighed = [number(nodes, links, "MULTIPLY", part, share) for part, share in zip(parts, LUMINANCE, strict=True)]
    luminance = number(nodes, links, "ADD", number(nodes, links, "ADD", weighed[0], weighed[1]), weighed[2])
    share = number(nodes, links, "MULTIPLY", luminance, MATERIAL["sigma"] / MATERIAL["r_max"])
    share = number(nodes, links, "MINIMUM", number(nodes, links, "MAXIMUM", share, 0.0), 1.0)
    above_zero = number(nodes, links, "MAXIMUM", luminance, 1e-12)
    joined = nodes.new("ShaderNodeCombineColor")
    each = zip(
        parts, channels(nodes, links, scale), channels(nodes, links, exponent), ("Red", "Green", "Blue"), strict=True
    )
    for part, factor, power, name in each:
        value = number(nodes, links, "MULTIPLY", factor, number(nodes, links, "POWER", share, power))
        hue = number(nodes, links, "DIVIDE", part, above_zero)
        links.new(number(nodes, links, "MULTIPLY", value, hue), joined.inputs[name])
    return joined.outputs["Color"]


def power_law():
    made, nodes, links = new_material(MATERIAL["name"] + " (power law)")
    where = place(nodes, links)
    surface, gathered = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeShaderToRGB")
    surface.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    surface.inputs["Roughness"].default_value = 0.0
    links.new(surface.outputs["BSDF"], gathered.inputs["Shader"])
    maps = [texture(nodes, links, where, file, "Non-Color") for file in ("scale.exr", "exponent.exr")]
    emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    links.new(look_up(nodes, links, gathered.outputs["Color"], *maps), emission.inputs["Color"])
    links.new(emission.outputs["Emission"], output.inputs["Surface"])
    return made


def make_materials():
    made = [pbr()] + ([power_law()] if MATERIAL["r_max"] else [])
    for each in made:
        each.asset_mark()
        each.asset_data.description = MATERIAL["loss"]
    return made


def make(path):
    """Save a scene with a ball and the materials."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = make_materials()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    bpy.context.object.data.materials.append(made[0])
    bpy.ops.object.shade_smooth()
    bpy.ops.file.pack_all()
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)


def add(path):
    """Add the materials to the open scene, which stays as it is, and save them alone."""
    made = make_materials()
    for each in made:
        for node in each.node_tree.nodes:
            if node.type == "TEX_IMAGE":
                node.image.pack()
    bpy.data.libraries.write(str(path), set(made), fake_user=True, compress=True)


if __name__ == "__main__":
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    target = Path(given[0]).resolve() if given else HERE / "{{NAME}}.blend"
    if bpy.app.background:
        make(target)
    else:
        add(target)
