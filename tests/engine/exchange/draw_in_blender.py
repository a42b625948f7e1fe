"""Run by Blender's Python: draws a square with a material of a .blend under one sun, straight from above, as EXR.

draw_in_blender.py FILE.blend MATERIAL ENGINE OUTPUT SIDE SAMPLES
"""

import math
import sys

import bpy

file, material, engine, output, side, samples = sys.argv[1:]
bpy.ops.wm.open_mainfile(filepath=file)
for each in list(bpy.data.objects):
    bpy.data.objects.remove(each)
bpy.ops.mesh.primitive_plane_add(size=2.0)
bpy.context.object.data.materials.append(bpy.data.materials[material])
bpy.ops.object.light_add(type="SUN", rotation=(0.0, math.radians(40.0), 0.0))
bpy.context.object.data.energy = 1.0
bpy.context.object.data.angle = 0.0
bpy.ops.object.camera_add(location=(0.0, 0.0, 4.0))
camera = bpy.context.object
camera.data.angle = math.radians(24.0)
scene = bpy.context.scene
scene.camera = camera
scene.render.engine = engine
scene.render.resolution_x = scene.render.resolution_y = int(side)
scene.render.film_transparent = True
scene.view_settings.view_transform = "Raw"
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = output
scene.render.filter_size = 1.0
if engine == "CYCLES":
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = int(samples), False, "CPU"
    scene.cycles.pixel_filter_type = "BOX"
else:
    scene.eevee.taa_render_samples = int(samples)
bpy.ops.render.render(write_still=True)
