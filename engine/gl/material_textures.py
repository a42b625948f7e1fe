"""A shading map or its compression as textures: float32, repeating, with mip-maps.

Textures that a device cannot hold are reduced, and a message says so: nothing is silently smaller.
"""

from __future__ import annotations

import ctypes
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.gl.context import Limits
from engine.gl.program import set_uniforms
from engine.render.mip_maps import planes_by_three
from engine.shading.directional.effective_light import TILTS, TURNS
from engine.shading.directional.planes import DirectionalMap
from engine.shading.kept_tiles import KeptTiles
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap

_TEXTURE_2D_ARRAY, _UNPACK_ALIGNMENT, _RGB, _HALF_FLOAT = 0x8C1A, 0x0CF5, 0x1907, 0x140B


def write_level(context: Any, texture: Any, level: int, layers: NDArray[np.float16]) -> None:
    """Write layers (L, h, w, 3) of an array texture at a mip level, which moderngl has no words for."""
    load = context.mglo._context.load_opengl_function
    unpacked = ctypes.CFUNCTYPE(None, ctypes.c_uint, ctypes.c_int)(load("glPixelStorei"))
    written = ctypes.CFUNCTYPE(None, ctypes.c_uint, *[ctypes.c_int] * 7, ctypes.c_uint, ctypes.c_uint, ctypes.c_void_p)
    pixels = np.ascontiguousarray(layers, np.float16)
    count, height, width = pixels.shape[:3]
    texture.use(0)
    unpacked(_UNPACK_ALIGNMENT, 1)
    area = (level, 0, 0, 0, width, height, count)
    written(load("glTexSubImage3D"))(_TEXTURE_2D_ARRAY, *area, _RGB, _HALF_FLOAT, pixels.ctypes.data)


class MaterialTextures:
    """Owns the textures of one material; `messages` say what had to be reduced."""

    def __init__(self, context: Any, shading: ShadingMap | PowerLawMap | DirectionalMap, limits: Limits) -> None:
        self.r_max = shading.r_max
        self.lowest_cosine = 1.0
        self.messages: list[str] = []
        self.textures: dict[str, Any] = {}
        smaller: list[NDArray[np.float16]] = []
        if isinstance(shading, DirectionalMap):
            smaller = self._planes(context, shading, limits)
        elif isinstance(shading, ShadingMap):
            self.source = "SOURCE_SLICES"
            slices = self._fit_layers(shading, limits.layers)
            images = np.stack([self._fit_size(image, limits.texture_size) for image in slices])
            self.layers = len(images)
            height, width = images.shape[1:3]
            self.textures["slices"] = context.texture_array((width, height, self.layers), 3, images, dtype="f4")
        else:
            self.source = "SOURCE_POWER_LAW"
            self.layers = 0
            if shading.kept is not None:
                self._keep(context, shading, shading.kept, limits)
            for name, image in (("scale_map", shading.scale), ("exponent_map", shading.exponent)):
                image = self._fit_size(image, limits.texture_size)
                self.textures[name] = context.texture(image.shape[1::-1], 3, np.ascontiguousarray(image), dtype="f4")
        for name, texture in self.textures.items():
            if name == "plane_weights":
                texture.filter, texture.repeat_x, texture.repeat_y = (context.LINEAR, context.LINEAR), True, False
                continue
            texture.build_mipmaps()
            for level, layers in enumerate(smaller if name == "planes" else (), start=1):
                write_level(context, texture, level, layers)
            texture.filter = (context.LINEAR_MIPMAP_LINEAR, context.LINEAR)
            texture.repeat_x = texture.repeat_y = True

    def _planes(self, context: Any, directional: DirectionalMap, limits: Limits) -> list[NDArray[np.float16]]:
        """Planes by three as half floats, which keep fractions of codes, and the weights of all directions.

        Returns the layers of the smaller sizes.
        """
        self.source, self.lowest_cosine = "SOURCE_PLANES", directional.lowest
        sizes: list[NDArray[Any]] = [directional.planes, *directional.smaller]
        fitting = [planes for planes in sizes if max(planes.shape[1:]) <= limits.texture_size]
        if len(fitting) < len(sizes):
            self._say_smaller(directional.planes.shape[1:], fitting[0].shape[1:], limits.texture_size)
        layers, *smaller = ((planes_by_three(planes) / 255.0).astype(np.float16) for planes in fitting)
        self.layers = len(layers)
        size = (*layers.shape[2:0:-1], self.layers)
        self.textures["planes"] = context.texture_array(size, 3, layers, dtype="f2", alignment=1)
        weights = np.zeros((1 + 3 * self.layers, TILTS, TURNS, 3), np.float32)
        weights[: directional.table.shape[-1]] = np.moveaxis(directional.table, 3, 0)
        self.textures["plane_weights"] = context.texture_array((TURNS, TILTS, len(weights)), 3, weights, dtype="f4")
        return smaller

    def _keep(self, context: Any, power_law: PowerLawMap, kept: KeptTiles, limits: Limits) -> None:
        """Kept tiles as slices that are 0 elsewhere, with their coverage in alpha."""
        height, width = power_law.error_map.shape
        slices = kept.slice_images(height, width)
        if len(slices) > limits.layers:
            self._say("Tiles that keep their slices are shown by the power law: the slices are too many.")
            return
        covered = kept.covers(height, width).astype(np.float32)[..., None]
        images = [self._fit_size(np.concatenate([image, covered], axis=2), limits.texture_size) for image in slices]
        self.source, self.layers = "SOURCE_MIXED", len(images)
        size = (*images[0].shape[1::-1], self.layers)
        self.textures["kept_tiles"] = context.texture_array(size, 4, np.stack(images), dtype="f4")

    def _fit_layers(self, shading: ShadingMap, most: int) -> NDArray[np.float32]:
        if len(shading.slices) <= most:
            return shading.slices
        self._say(f"The {len(shading.slices)} slices are shown as {most}, the most that this graphics device can hold.")
        return np.stack([shading.slice_image(r) for r in np.linspace(0.0, shading.r_max, most)])

    def _fit_size(self, image: NDArray[np.float32], most: int) -> NDArray[np.float32]:
        height, width = image.shape[:2]
        if max(height, width) <= most:
            return image

        factor = most / max(height, width)
        size = (max(1, round(width * factor)), max(1, round(height * factor)))
        self._say_smaller((height, width), (size[1], size[0]), most)
        reduced: NDArray[np.float32] = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        return reduced

    def _say_smaller(self, whole: tuple[int, ...], shown: tuple[int, ...], most: int) -> None:
        """Say that a material of `whole` rows and columns is `shown` smaller."""
        self._say(
            f"The material of {whole[1]} × {whole[0]} texels is shown at {shown[1]} × {shown[0]}: "
            f"{most} is the largest texture of this graphics device."
        )

    def _say(self, message: str) -> None:
        if message not in self.messages:
            self.messages.append(message)

    def bind(self, program: Any) -> None:
        for unit, (name, texture) in enumerate(self.textures.items()):
            texture.use(unit)
            set_uniforms(program, {name: unit})

    def release(self) -> None:
        for texture in self.textures.values():
            texture.release()
        self.textures.clear()
