"""MaterialX in a process of its own: draws a document with MaterialXRenderGlsl, which opens a window of its own.

Arguments: the document, the category of its surface, the square as .obj, width and height in pixels, the shares of the
square that they show, and the direction towards the lamp. Only the library of MaterialX and NumPy are loaded. On
standard output follow, after `MARK`, "valid" or the complaint in a line, and the image as float32, rows from the top.
The environment is black: direct light alone.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import MaterialX as mx
import MaterialX.PyMaterialXGenGlsl as glsl
import MaterialX.PyMaterialXGenShader as generation
import MaterialX.PyMaterialXRender as rendering
import MaterialX.PyMaterialXRenderGlsl as drawing
import numpy as np

MARK = b"--- image ---\n"


def main(words: list[str]) -> int:
    document, surface, square = Path(words[0]), words[1], words[2]
    width, height = int(words[3]), int(words[4])
    shares, lamp = [float(word) for word in words[5:7]], [float(word) for word in words[7:10]]
    search = mx.getDefaultDataSearchPath()
    search.append(str(document.parent))
    library, found = mx.createDocument(), mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), search, library)
    mx.readFromXmlFile(found, str(document))
    found.setDataLibrary(library)
    is_valid, message = found.validate()
    light = found.addNode("directional_light", "lamp", "lightshader")
    light.setInputValue("direction", mx.Vector3(*(-each for each in lamp)))
    light.setInputValue("color", mx.Color3(1.0, 1.0, 1.0))
    light.setInputValue("intensity", math.pi)
    renderer = drawing.GlslRenderer.create(width, height, rendering.FLOAT)
    renderer.initialize()
    renderer.setImageHandler(drawing.GLTextureHandler.create(rendering.StbImageLoader.create()))
    renderer.getImageHandler().setSearchPath(search)
    generator = glsl.GlslShaderGenerator.create()
    context = _context(generator, search, library)
    _put_light(renderer, found, light, context)
    _put_square(renderer, square, (width, height), shares)
    shaders = (mx.getShaderNodes(material)[0] for material in found.getMaterialNodes())
    shader = next(node for node in shaders if node.getCategory() == surface)
    renderer.createProgram(generator.generate("drawn", shader, context))
    renderer.validateInputs()
    renderer.render()
    image = rendering.Image.create(width, height, 4, rendering.FLOAT)
    image.createResourceBuffer()
    image = renderer.captureImage(image)
    pixels = [[image.getTexelColor(x, y).asTuple()[:3] for x in range(width)] for y in range(height)]
    verdict = "valid" if is_valid else f"not valid: {' '.join(message.split())}"
    sys.stdout.buffer.write(MARK + verdict.encode() + b"\n" + np.array(pixels, np.float32)[::-1].tobytes())
    return 0


def _context(generator: Any, search: Any, library: Any) -> Any:
    context = generation.GenContext(generator)
    context.registerSourceCodeSearchPath(search)
    colours = generation.DefaultColorManagementSystem.create(generator.getTarget())
    colours.loadLibrary(library)
    generator.setColorManagementSystem(colours)
    options = context.getOptions()
    options.hwMaxActiveLightSources = 1
    options.hwSrgbEncodeOutput = False
    options.fileTextureVerticalFlip = True
    return context


def _put_light(renderer: Any, document: Any, light: Any, context: Any) -> None:
    handler = rendering.LightHandler.create()
    handler.registerLights(document, [light], context)
    handler.setLightSources([light])
    handler.setIndirectLighting(False)
    black = rendering.createUniformImage(2, 2, 3, rendering.FLOAT, mx.Color4(0.0, 0.0, 0.0, 1.0))
    handler.setEnvRadianceMap(black)
    handler.setEnvIrradianceMap(black)
    renderer.setLightHandler(handler)


def _put_square(renderer: Any, square: str, size: tuple[int, int], shares: list[float]) -> None:
    geometry = rendering.GeometryHandler.create()
    geometry.addLoader(rendering.TinyObjLoader.create())
    geometry.loadGeometry(square, False)
    renderer.setGeometryHandler(geometry)
    across, up_to = shares
    camera = rendering.Camera.create()
    camera.setViewportSize(mx.Vector2(*size))
    above, middle, up = mx.Vector3(0.0, 0.0, 100.0), mx.Vector3(0.0, 0.0, 0.0), mx.Vector3(0.0, 1.0, 0.0)
    camera.setViewMatrix(rendering.Camera.createViewMatrix(above, middle, up))
    camera.setProjectionMatrix(rendering.Camera.createOrthographicMatrix(-across, across, -up_to, up_to, 50.0, 150.0))
    renderer.setCamera(camera)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
