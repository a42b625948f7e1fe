"""Blender in a process of its own: draws the square of the proof with a material of a `.blend`, as EXR.

Arguments: the file, the material, the engine (`CYCLES` or `BLENDER_EEVEE`), the image, and as JSON `size` (H, W) of
the maps in texels, `window` (height, width) of the texels in the middle that are drawn, `repeats` of the material over
one unit of texture coordinates, `tilt_deg` and `azimuth_deg` of the sun, and its `irradiance`. A pixel shows the middle
of a texel alone: filters of pixels have no width, and the sun has no size, so that one sample holds no noise.
"""

import json
import math
import sys

import bpy

file, material, engine, output, asked = sys.argv[1:]
given = json.loads(asked)
(height, width), (window_height, window_width) = given["size"], given["window"]
unit = 2.0 / max(height, width)

bpy.ops.wm.open_mainfile(filepath=file)
for each in list(bpy.data.objects):
    bpy.data.objects.remove(each)
bpy.ops.mesh.primitive_plane_add(size=1.0)
square = bpy.context.object
for vertex in square.data.vertices:  # a scale of the object would bend its normals
    vertex.co.x, vertex.co.y = unit * width * vertex.co.x, unit * height * vertex.co.y
square.data.materials.append(bpy.data.materials[material])
for corner in square.data.uv_layers.active.data:
    corner.uv = [value / given["repeats"] for value in corner.uv]

turn = (0.0, math.radians(given["tilt_deg"]), math.radians(given["azimuth_deg"]))
bpy.ops.object.light_add(type="SUN", rotation=turn)
sun = bpy.context.object.data
sun.energy, sun.angle, sun.use_shadow = given["irradiance"], 0.0, False
bpy.ops.object.camera_add(location=(0.0, 0.0, 4.0))
camera = bpy.context.object
camera.data.type, camera.data.ortho_scale = "ORTHO", unit * max(window_height, window_width)

scene = bpy.context.scene
scene.camera = camera
scene.render.engine = engine
scene.render.resolution_x, scene.render.resolution_y = window_width, window_height
scene.render.resolution_percentage = 100
scene.render.filter_size = 0.01
scene.render.filepath = output
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
scene.view_settings.view_transform = "Raw"
if engine == "CYCLES":
    scene.cycles.device, scene.cycles.samples = "CPU", 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01
    scene.cycles.max_bounces = 0
else:
    scene.eevee.taa_render_samples = 1
bpy.ops.render.render(write_still=True)
