"""A BRDF without a shader of its own, as a texture: its table in half and difference angles, in float32.

Another BRDF than such a table is resampled to one first, which takes a second or, where it is scattered data, many;
a window that must not wait makes the table beforehand (`engine.brdf.resample`). Of what is not reciprocal both ways of
the light are kept, as two halves of a whole turn of phi_d. What that costs in accuracy, and what it cannot show, are
messages.

Factors on the graphics device: textures of 32-bit floats, a layer per term, that a shader looks up by hand. PBR maps
are four layers of one texture.

The counterparts of `engine.factor.separable_factors` and `engine.factor.homomorphic`: what the shader gives is what `f`
gives, to the rounding of 32-bit directions. Factors are recognised by their `kind`, so that a window that shows none
does not wait for the compiled kernels of those modules.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.models.multiple_scattering import SMOOTHEST
from engine.brdf.resample import SHAPE, table_from, whole_turn
from engine.brdf.table import HalfDifferenceTable
from engine.core.figure_text import percent
from engine.core.params import parameters
from engine.core.steps import drain
from engine.factor.projections import KINDS, LinearProjection
from engine.gl.context import Limits
from engine.gl.material_textures import define_level, write_rows
from engine.gl.program import find_uniform, set_uniforms
from engine.render.hex_tiling import prepare_tiles, run_at_once
from engine.render.mip_maps import pbr_layers, pbr_levels
from engine.scene.scene import TilingMode
from engine.surface.pbr_maps import PbrMaps

if TYPE_CHECKING:
    from engine.brdf.ceiling import Ceiling
    from engine.factor.homomorphic import HomomorphicFactors
    from engine.factor.separable_factors import SeparableFactors

#: Texture unit, above those of a material and the lights.
UNIT = 5

#: Bins for scattered data, and for anisotropic ones, of which only the mean is shown.
COARSE = (45, 45, 90)

#: The shader that looks the table up.
SOURCE = "table"


class TableTexture:
    """Owns the texture of one BRDF; `messages` say where it is not the BRDF itself that is shown."""

    def __init__(self, context: moderngl.Context, brdf: Brdf, limits: Limits) -> None:
        self.messages: list[str] = []
        self.turn = np.pi
        if isinstance(brdf, HalfDifferenceTable) and _fits(brdf, limits):
            lattice = brdf.lattice
        else:
            if brdf.reciprocal:
                table = table_from(brdf, _shape(brdf), dtype=np.float32)
                lattice, error = table.lattice, table.health.figures["resampling_rms_rel"]
            else:
                lattice, error = drain(whole_turn(brdf, _shape(brdf)))
                self.turn = 2.0 * np.pi
            self.messages.append(f"The BRDF is drawn from a table with an error of {percent(error)} RMS.")
        if not brdf.isotropic:
            self.messages.append(
                "The BRDF is anisotropic and is drawn as its mean over all azimuths; "
                "the renderer on the CPU (--renderer cpu) shows it as it is."
            )
        layers, height, width = lattice.shape[:3]
        texels = np.ascontiguousarray(lattice, np.float32)
        self.texture = context.texture_array((width, height, layers), 3, texels, dtype="f4")
        self.texture.filter = (context.NEAREST, context.NEAREST)

    def bind(self, program: moderngl.Program) -> None:
        self.texture.use(UNIT)
        find_uniform(program, "brdf_table").value = UNIT
        find_uniform(program, "brdf_turn").value = self.turn

    def release(self) -> None:
        self.texture.release()


def _shape(brdf: Brdf) -> tuple[int, int, int]:
    """The resolution of MERL data; half of it where every value is slow, and smooth beyond it."""
    from engine.brdf.scattered import ScatteredBrdf  # slow to load, and the window must open at once

    return COARSE if isinstance(brdf, ScatteredBrdf) or not brdf.isotropic else SHAPE


def _fits(table: HalfDifferenceTable, limits: Limits) -> bool:
    layers, height, width = table.lattice.shape[:3]
    return layers <= limits.layers and max(height, width) <= limits.texture_size


#: Terms that the shader of homomorphic factors has room for; a search finds no more.
MAX_TERMS = 16

#: Logarithms above this leave 32-bit floats.
LARGEST_LOG = 80.0

#: Texture units, above those of a material and the lights; the last is that of the ceiling.
UNITS = (5, 6, 9)


class CeilingTexture:
    """Owns the texture of the largest values of factors, of one black texel where they have none."""

    def __init__(self, context: moderngl.Context, ceiling: Ceiling | None) -> None:
        self._bounded = ceiling is not None
        self._texture = layers(context, ceiling.table if ceiling is not None else np.zeros((1, 1, 1, 3), np.float32))

    def bind(self, program: moderngl.Program) -> None:
        self._texture.use(UNITS[2])
        find_uniform(program, "brdf_ceiling").value = UNITS[2]
        find_uniform(program, "brdf_bounded").value = int(self._bounded)

    def release(self) -> None:
        self._texture.release()


class SeparableTextures:
    """Owns the textures of separable factors; `SOURCE` is the shader that looks them up."""

    SOURCE = "separable"

    def __init__(self, context: moderngl.Context, factors: SeparableFactors) -> None:
        self.messages: list[str] = []
        self._textures = [layers(context, side) for side in (factors.first, factors.second)]
        self._ceiling = CeilingTexture(context, factors.ceiling)
        self._values = {
            "brdf_terms": factors.terms,
            "brdf_map": factors.hemisphere_map.number,
            "brdf_size": factors.hemisphere_map.size,
            "brdf_of_half": int(factors.parametrisation == "half-diff"),
        }

    def bind(self, program: moderngl.Program) -> None:
        for unit, texture, name in zip(UNITS[:2], self._textures, ("brdf_first", "brdf_second"), strict=True):
            texture.use(unit)
            find_uniform(program, name).value = unit
        for name, value in self._values.items():
            find_uniform(program, name).value = value
        self._ceiling.bind(program)

    def release(self) -> None:
        for texture in self._textures:
            texture.release()
        self._ceiling.release()


class HomomorphicTextures:
    """Owns the textures of homomorphic factors; `SOURCE` is the shader that looks them up."""

    SOURCE = "homomorphic"

    def __init__(self, context: moderngl.Context, factors: HomomorphicFactors) -> None:
        self.messages: list[str] = []
        self._texture = layers(context, np.stack(factors.textures))
        self._ceiling = CeilingTexture(context, factors.ceiling)
        rows = np.zeros((MAX_TERMS, 2, 4), np.float32)
        kinds, twice = np.zeros(MAX_TERMS, int), np.zeros(MAX_TERMS, int)
        for term, projection in enumerate(factors.projections):
            if isinstance(projection, LinearProjection):
                rows[term] = projection.rows / projection.scale[:, None]
            else:
                kinds[term] = 1 + KINDS.index(projection.kind)
            conjugate = projection.conjugate(factors.parametrisation)
            twice[term] = factors.reciprocal and conjugate != projection
        self._values: dict[str, object] = {
            "brdf_terms": factors.terms,
            "brdf_kinds": kinds.tolist(),
            "brdf_twice": twice.tolist(),
            "brdf_rows": [tuple(row) for row in rows.reshape(-1, 4).tolist()],
            "brdf_of_half": int(factors.parametrisation == "half-diff"),
            "brdf_mean": tuple(factors.space.mean.tolist()),
            "brdf_highest": tuple(np.minimum(factors.space.highest, LARGEST_LOG).tolist()),
            "brdf_epsilon": factors.space.epsilon,
        }

    def bind(self, program: moderngl.Program) -> None:
        self._texture.use(UNITS[0])
        find_uniform(program, "brdf_textures").value = UNITS[0]
        for name, value in self._values.items():
            find_uniform(program, name).value = value
        self._ceiling.bind(program)

    def release(self) -> None:
        self._texture.release()
        self._ceiling.release()


class PbrTextures:
    """Owns the texture of PBR maps: repeating, with mip-maps; reduced, with a message, where the device is too small.

    Normals and the products of their components are filtered as numbers: mean normals, and how far normals differ.
    """

    SOURCE = "pbr-maps"

    #: Of the tables of hex tiling.
    TABLES_UNIT = 6

    def __init__(self, context: moderngl.Context, maps: PbrMaps, limits: Limits, mode: TilingMode = "grid") -> None:
        fitted, self.messages = within(pbr_layers(maps), limits.texture_size)
        sizes = pbr_levels(fitted)
        self._tables: moderngl.TextureArray | None = None
        if mode == "hex":
            tiles = run_at_once(prepare_tiles(maps, sizes))
            assert tiles.tables is not None
            sizes = tiles.levels
            levels, layers, entries, _ = tiles.tables.shape
            stored = np.ascontiguousarray(np.moveaxis(tiles.tables, 1, 0), np.float32)
            self._tables = context.texture_array((entries, levels, layers), 3, stored, dtype="f4")
            self._tables.filter = (context.LINEAR, context.LINEAR)
            self._tables.repeat_x = self._tables.repeat_y = False
            self._mean_normal = tuple(float(each) for each in tiles.mean_normal)
        count, height, width = sizes[0].shape[:3]
        self._texture = context.texture_array((width, height, count), 3, np.ascontiguousarray(sizes[0]), dtype="f4")
        for number, size in enumerate(sizes[1:], start=1):
            define_level(context, self._texture, number, (size.shape[2], size.shape[1]), count)
            for layer, image in enumerate(size):
                write_rows(context, self._texture, number, np.asarray(image, np.float32), 0, layer)
        self._texture.filter = (context.LINEAR_MIPMAP_LINEAR, context.LINEAR)
        self._texture.repeat_x = self._texture.repeat_y = True
        layers = maps.layers
        self._values: dict[str, Any] = {}
        if layers is not None:
            self._values = {f"brdf_{each.name}": getattr(layers, each.name) for each in parameters(layers)}

    def bind(self, program: moderngl.Program) -> None:
        self._texture.use(UNIT)
        find_uniform(program, "pbr_maps").value = UNIT
        set_uniforms(program, self._values)
        find_uniform(program, "pbr_smoothest").value = SMOOTHEST
        if self._tables is not None:
            self._tables.use(self.TABLES_UNIT)
            find_uniform(program, "hex_tables").value = self.TABLES_UNIT
            find_uniform(program, "hex_mean_normal").value = self._mean_normal

    def release(self) -> None:
        self._texture.release()
        if self._tables is not None:
            self._tables.release()


def within(images: NDArray[np.float32], most: int) -> tuple[NDArray[np.float32], list[str]]:
    """Images (N, H, W, 3) of at most so many texels a side, and a sentence where they were larger."""
    height, width = images.shape[1:3]
    if max(height, width) <= most:
        return np.ascontiguousarray(images), []
    import cv2

    size = tuple(max(1, round(side * most / max(height, width))) for side in (width, height))
    reduced = np.stack([cv2.resize(image, size, interpolation=cv2.INTER_AREA) for image in images])
    message = (
        f"The material of {width} × {height} texels is shown at {size[0]} × {size[1]}: "
        f"{most} is the largest texture of this graphics device."
    )
    return np.ascontiguousarray(reduced, np.float32), [message]


FactorTextures = SeparableTextures | HomomorphicTextures


#: The owner of the textures of each `kind` of factors.
OWNERS = {"separable factors": SeparableTextures, "homomorphic factors": HomomorphicTextures}


def factor_source(brdf: Brdf) -> type[FactorTextures] | None:
    """The owner of a BRDF's textures where it consists of factors."""
    return OWNERS.get(getattr(brdf, "kind", ""))


def factor_textures(context: moderngl.Context, brdf: Brdf) -> FactorTextures | None:
    """The textures of a BRDF that consists of factors; None for any other."""
    owner: Callable[[moderngl.Context, Any], FactorTextures] | None = factor_source(brdf)
    return owner(context, brdf) if owner else None


def pack(context: moderngl.Context, numbers: NDArray[np.float32]) -> moderngl.TextureArray:
    """Textures of one number (N, rows, columns), four in each of the layers of one."""
    count, rows, columns = numbers.shape
    texels = np.zeros((-(-count // 4) * 4, rows, columns), np.float32)
    texels[:count] = numbers
    texels = np.ascontiguousarray(np.moveaxis(texels.reshape(-1, 4, rows, columns), 1, 3))
    texture = context.texture_array((columns, rows, len(texels)), 4, texels, dtype="f4")
    texture.filter = (context.NEAREST, context.NEAREST)
    return texture


def layers(context: moderngl.Context, textures: ArrayLike) -> moderngl.TextureArray:
    """Textures (K, rows, columns, 3) as the layers of one."""
    texels = _in_fours(textures)
    layers, rows, columns, _ = texels.shape
    texture = context.texture_array((columns, rows, layers), 4, texels, dtype="f4")
    texture.filter = (context.NEAREST, context.NEAREST)
    return texture


def plain(context: moderngl.Context, texels: ArrayLike) -> moderngl.Texture:
    """A texture (rows, columns, 3): one that is not a layer costs a vertex less to read."""
    filled = _in_fours(texels)
    texture = context.texture(filled.shape[1::-1], 4, filled, dtype="f4")
    texture.filter = (context.NEAREST, context.NEAREST)
    return texture


def _in_fours(texels: ArrayLike) -> NDArray[np.float32]:
    """Texels (…, 3) with a fourth number: a frame of llvmpipe that reads threes at each vertex takes a tenth longer."""
    threes: NDArray[np.float32] = np.asarray(texels, np.float32)
    return np.concatenate([threes, np.zeros_like(threes[..., :1])], axis=-1)
