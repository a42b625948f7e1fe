"""A shading map or its compression as textures: float32, repeating, with mip-maps.

Textures that a device cannot hold are reduced, and a message says so: nothing is silently smaller. They are filled in
short pieces, and their mip levels are computed here: a driver without a graphics card makes them all at once, in 0.1 s
for a small material.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.gl.context import Limits
from engine.gl.program import set_uniforms
from engine.render.gains import compare_means, gains_of, interpolate
from engine.render.hex_tiling import in_slices, prepare_tiles
from engine.render.mip_maps import Levels, half, halves, mip_levels, planes_by_three, power_law_levels
from engine.scene.scene import TilingMode
from engine.shading.directional.effective_light import TILTS, TURNS
from engine.shading.directional.planes import DirectionalMap
from engine.shading.kept_tiles import KeptTiles
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap

_TEXTURE_2D, _TEXTURE_2D_ARRAY, _UNPACK_ALIGNMENT = 0x0DE1, 0x8C1A, 0x0CF5

#: OpenGL's names of formats, by the number of channels, and of types and internal formats, by the dtype.
_FORMATS = {3: 0x1907, 4: 0x1908}
_TYPES = {"f4": 0x1406, "f2": 0x140B}
_INTERNAL = {(3, "f4"): 0x8815, (4, "f4"): 0x8814, (3, "f2"): 0x881B}

#: Bytes that are written at once, some milliseconds.
PIECE_BYTES = 4 << 20

Shading = ShadingMap | PowerLawMap | DirectionalMap

Maps = moderngl.Texture | moderngl.TextureArray

Layers = NDArray[np.float32] | NDArray[np.float16]


def _function(context: moderngl.Context, name: str, integers: int) -> Callable[..., None]:
    """A function of OpenGL with a target, so many integers, a format, a type and a pointer to pixels."""
    kinds = (ctypes.c_uint, *[ctypes.c_int] * integers, ctypes.c_uint, ctypes.c_uint, ctypes.c_void_p)
    return ctypes.CFUNCTYPE(None, *kinds)(context.mglo._context.load_opengl_function(name))


def define_level(context: moderngl.Context, texture: Maps, level: int, size: tuple[int, int], layers: int) -> None:
    """Give `texture` a mip level of `size` (width, height), which moderngl has no words for; `layers` is 0 for none."""
    internal = _INTERNAL[texture.components, texture.dtype]
    names = (_FORMATS[texture.components], _TYPES[texture.dtype])
    texture.use(0)
    if layers:
        _function(context, "glTexImage3D", 6)(_TEXTURE_2D_ARRAY, level, internal, *size, layers, 0, *names, None)
    else:
        _function(context, "glTexImage2D", 5)(_TEXTURE_2D, level, internal, *size, 0, *names, None)


def write_rows(
    context: moderngl.Context, texture: Maps, level: int, rows: Layers, first: int, layer: int | None
) -> None:
    """Write rows (h, w, channels) of a mip level from the row `first` on, into a `layer` of an array texture."""
    aligned = ctypes.CFUNCTYPE(None, ctypes.c_uint, ctypes.c_int)
    pixels = np.ascontiguousarray(rows)
    height, width = pixels.shape[:2]
    names = (_FORMATS[texture.components], _TYPES[texture.dtype], pixels.ctypes.data)
    texture.use(0)
    aligned(context.mglo._context.load_opengl_function("glPixelStorei"))(_UNPACK_ALIGNMENT, 1)
    if layer is None:
        _function(context, "glTexSubImage2D", 5)(_TEXTURE_2D, level, 0, first, width, height, *names)
    else:
        area = (0, first, layer, width, height, 1)
        _function(context, "glTexSubImage3D", 7)(_TEXTURE_2D_ARRAY, level, *area, *names)


class MaterialTextures:
    """Owns the textures of one material, which `fill` fills; `messages` say what had to be reduced."""

    def __init__(self, context: moderngl.Context, shading: Shading, limits: Limits, mode: TilingMode = "grid") -> None:
        self.r_max = shading.r_max
        self.lowest_cosine = 1.0
        self.layers = 0
        self.messages: list[str] = []
        self.textures: dict[str, Maps] = {}
        self._context = context
        self._levels: dict[str, list[Layers]] = {}
        self._tiled = in_slices(shading) if mode == "hex" else None
        shading = self._tiled or shading
        if isinstance(shading, DirectionalMap):
            self._planes(shading, limits)
        elif isinstance(shading, ShadingMap):
            self.source = "SOURCE_SLICES"
            slices = self._fit_layers(shading, limits.layers)
            images = [self._fit_size(image, limits.texture_size) for image in slices]
            self.layers = len(images)
            self._allocate("slices", [np.stack(images) if images[0] is not slices[0] else slices])
        else:
            self.source = "SOURCE_POWER_LAW"
            if shading.kept is not None:
                self._keep(shading, shading.kept, limits)
            pair = np.stack([self._fit_size(image, limits.texture_size) for image in (shading.scale, shading.exponent)])
            levels = power_law_levels(pair)
            for number, name in enumerate(("scale_map", "exponent_map")):
                self._allocate(name, [level[number] for level in levels])
            if mode == "grid":
                self._set_share_gains(self._power_gains(shading, levels))

    def _allocate(self, name: str, levels: list[Layers]) -> None:
        """Make a texture for `levels`, layers (L, h, w, channels) or one image (h, w, channels) each; the smaller
        levels that are not given are halves of the last."""
        shape, dtype = levels[0].shape, "f2" if levels[0].dtype == np.float16 else "f4"
        if len(shape) == 4:
            texture: Maps = self._context.texture_array((shape[2], shape[1], shape[0]), shape[3], dtype=dtype)
        else:
            texture = self._context.texture((shape[1], shape[0]), shape[2], dtype=dtype)
        self.textures[name], self._levels[name] = texture, levels

    def fill(self) -> Iterator[None]:
        """Write all levels of all textures, in pieces of some milliseconds."""
        if self._tiled is not None:
            yield from self._blend(self._tiled)
        for name, levels in self._levels.items():
            yield from self._fill(self.textures[name], levels)
        self._levels.clear()

    def _blend(self, maps: Shading) -> Iterator[None]:
        """Put Gaussian numbers in the place of values, and the tables of values beside them."""
        is_pair = self.source == "SOURCE_POWER_LAW"
        if is_pair:
            pair = zip(self._levels["scale_map"], self._levels["exponent_map"], strict=True)
            values: Levels = [np.stack(each) for each in pair]
        elif self.source == "SOURCE_PLANES":
            values = [255.0 * np.asarray(level, np.float32) for level in self._levels["planes"]]
        else:
            values = halves(np.asarray(self._levels["slices"][0], np.float32))
        tiles = yield from prepare_tiles(maps, values)
        for number, (name, levels) in enumerate(self._levels.items()):
            numbers = [level[number] if is_pair else level for level in tiles.levels]
            dtype: Any = levels[0].dtype
            self._levels[name] = [np.asarray(each, dtype) for each in numbers]
        assert tiles.tables is not None
        self.textures["hex_tables"] = self._table(np.moveaxis(tiles.tables, 1, 0))
        if is_pair:
            self._set_share_gains(tiles.gains)
        elif isinstance(maps, DirectionalMap):
            self._set_plane_weights(maps, tiles.gains)

    def _power_gains(self, power_law: PowerLawMap, levels: Levels) -> NDArray[np.float32]:
        """Gains of the pair where tiles are not kept, at the sizes that the device holds."""
        height, width = power_law.error_map.shape
        if power_law.kept is None or self.source == "SOURCE_POWER_LAW":
            same = levels[0].shape[1:3] == (height, width)
            return gains_of(power_law, levels) if same else compare_means(power_law, [*map(interpolate, levels)])
        covered = np.repeat(power_law.kept.covers(height, width)[..., None].astype(np.float32), 3, axis=2)
        shown = halves(self._fit_size(covered, max(levels[0].shape[1:3]))[None])
        return compare_means(power_law, [interpolate(np.concatenate(each)) for each in zip(levels, shown, strict=True)])

    def _set_share_gains(self, gains: NDArray[np.float32]) -> None:
        self.textures["share_gains"] = self._table(np.moveaxis(gains, 1, 0))

    def _table(self, values: NDArray[np.float32]) -> moderngl.TextureArray:
        """An array texture of values (layers, rows, columns, 3) that does not repeat."""
        layers, rows, columns = values.shape[:3]
        stored = np.ascontiguousarray(values, np.float32)
        texture = self._context.texture_array((columns, rows, layers), 3, stored, dtype="f4")
        texture.filter = (self._context.LINEAR, self._context.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        return texture

    def _fill(self, texture: Maps, levels: list[Layers]) -> Iterator[None]:
        is_array = levels[0].ndim == 4
        whole = [level if is_array else level[None] for level in levels]
        count, height, width = whole[0].shape[:3]
        sizes = [(width, height)]
        while max(sizes[-1]) > 1:
            sizes.append((max(1, sizes[-1][0] // 2), max(1, sizes[-1][1] // 2)))
            define_level(self._context, texture, len(sizes) - 1, sizes[-1], count if is_array else 0)
        texture.filter = (self._context.LINEAR_MIPMAP_LINEAR, self._context.LINEAR)
        texture.repeat_x = texture.repeat_y = True
        for layer in range(count):
            image = whole[0][layer]
            for level in range(len(sizes)):
                if level:
                    image = whole[level][layer] if level < len(whole) else half(image)
                rows = max(1, PIECE_BYTES // max(1, image[0].nbytes))
                for first in range(0, len(image), rows):
                    part = image[first : first + rows].astype(whole[0].dtype, copy=False)
                    write_rows(self._context, texture, level, part, first, layer if is_array else None)
                    if rows < len(image):
                        yield
            yield

    def _planes(self, directional: DirectionalMap, limits: Limits) -> None:
        """Planes by three as half floats, which keep fractions of codes, and the weights of all directions."""
        self.source, self.lowest_cosine = "SOURCE_PLANES", directional.lowest
        sizes: list[NDArray[Any]] = [directional.planes, *directional.smaller]
        fitting = [planes for planes in sizes if max(planes.shape[1:]) <= limits.texture_size]
        if len(fitting) < len(sizes):
            self._say_smaller(directional.planes.shape[1:], fitting[0].shape[1:], limits.texture_size)
        levels: list[Layers] = [(planes_by_three(planes) / 255.0).astype(np.float16) for planes in fitting]
        self.layers = len(levels[0])
        self._allocate("planes", levels)
        if self._tiled is None:
            gains = gains_of(directional, mip_levels(directional))
            self._set_plane_weights(directional, gains[-len(fitting) :])

    def _set_plane_weights(self, directional: DirectionalMap, gains: NDArray[np.float32]) -> None:
        """The weights of planes for all directions, and after them the gains of all sizes."""
        weights = np.zeros((1 + 3 * self.layers, TILTS, TURNS, 3), np.float32)
        weights[: directional.table.shape[-1]] = np.moveaxis(directional.table, 3, 0)
        texture = self._table(np.concatenate([weights, gains]))
        texture.repeat_x = True
        self.textures["plane_weights"] = texture

    def _keep(self, power_law: PowerLawMap, kept: KeptTiles, limits: Limits) -> None:
        """Kept tiles as slices that are 0 elsewhere, with their coverage in alpha."""
        height, width = power_law.error_map.shape
        slices = kept.slice_images(height, width)
        if len(slices) > limits.layers:
            self._say("Tiles that keep their slices are shown by the power law: the slices are too many.")
            return
        covered = kept.covers(height, width).astype(np.float32)[..., None]
        images = [self._fit_size(np.concatenate([image, covered], axis=2), limits.texture_size) for image in slices]
        self.source, self.layers = "SOURCE_MIXED", len(images)
        self._allocate("kept_tiles", [np.stack(images)])

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
        import cv2  # 30 MB that an idle window does without

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

    def bind(self, program: moderngl.Program) -> None:
        for unit, (name, texture) in enumerate(self.textures.items()):
            texture.use(unit)
            set_uniforms(program, {name: unit})

    def release(self) -> None:
        for texture in self.textures.values():
            texture.release()
        self.textures.clear()
