"""Run by Blender's Python: radiance that a shader in OSL gives, four pixels a side for each set of its inputs, as EXR.

evaluate_osl.py SHADER.osl INPUTS.json OUTPUT.exr
"""

import json
import sys
from pathlib import Path

import bpy

# The library that reads compiled shaders lies where Blender's own Python, but no other, looks for it.
sys.path += map(str, Path(bpy.utils.resource_path("LOCAL"), "python", "lib").glob("*/site-packages"))

shader, inputs, output = sys.argv[1:]
cases = json.loads(Path(inputs).read_text())
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.device, scene.cycles.shading_system, scene.cycles.samples = "CPU", True, 1
scene.cycles.use_denoising = False
scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01
for place, case in enumerate(cases):
    bpy.ops.mesh.primitive_plane_add(size=1.0, location=(place + 0.5 - len(cases) / 2.0, 0.0, 0.0))
    material = bpy.data.materials.new(str(place))
    bpy.context.object.data.materials.append(material)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    script = nodes.new("ShaderNodeScript")
    script.mode, script.filepath = "EXTERNAL", shader
    for name, value in case.items():
        script.inputs[name].default_value = value
    emission, end = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    links.new(script.outputs["radiance"], emission.inputs["Color"])
    links.new(emission.outputs["Emission"], end.inputs["Surface"])
bpy.ops.object.camera_add(location=(0.0, 0.0, 4.0))
scene.camera = bpy.context.object
scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", float(len(cases))
scene.render.resolution_x, scene.render.resolution_y = 4 * len(cases), 4
scene.render.filepath = output
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
scene.view_settings.view_transform = "Raw"
bpy.ops.render.render(write_still=True)
