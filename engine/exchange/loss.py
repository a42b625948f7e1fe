"""Error of leaving a material's own maps: images of an exported representation against those of the material itself.

The images show a ball from afar, its texture projected from the front, so that one pixel shows one texel, under each
of three environments, each in place as `LIGHTS` directional lights; a ball casts no shadow on itself. The reference
looks the material up within the sum over lights, as `engine.render.direct` does; it takes the slices where the material
has them. Nothing is filtered: what differs is the representation. Against the photographs, a representation is lit as
each lamp of the stack lit it and seen from straight above. About 1 s a representation on one core.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.accuracy.compare import comparison
from engine.brdf.brdf import Brdf
from engine.capture.report import grid_step
from engine.core.colour import to_display8
from engine.core.directions import normalize
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps, part
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.light.environment import DistantLights
from engine.light.light_tree import choose_lights
from engine.light.sky import make_built_in
from engine.render.direct import Terms, sample
from engine.render.hex_tiling import Maps
from engine.render.mip_maps import full_size
from engine.scene.material import Material
from engine.scene.scene import Scene, Source
from engine.surface.layered import reflect_maps
from engine.surface.pbr_maps import PbrMaps

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack

Floats = NDArray[np.float64]

#: Environments of the reference images: soft light from a room, a low sun, and an even sky.
ENVIRONMENTS = ("studio", "noon", "overcast")

#: Directional lights that stand for an environment, and the ball's diameter in pixels.
LIGHTS, DIAMETER = 48, 160

#: Error below which files show the material itself: that of rounded numbers of 32 bits.
EXACT = 1e-6


@dataclass(frozen=True, eq=False)
class View:
    """Points of surface that are seen: their texels, their frames, and the viewer in these.

    Attributes
    ----------
    row, column : (N,) texels. frame : (N, 3, 3) with columns tangent, bitangent, normal. wo : (N, 3) in the frame.
    mask : (H, W) bool, the pixels that the points lie in, in their order.
    """

    row: NDArray[np.int64]
    column: NDArray[np.int64]
    frame: Floats
    wo: Floats
    mask: NDArray[np.bool_]

    def image(self, values: Floats) -> NDArray[np.float32]:
        """(H, W, 3) with the values (N, 3) of the points, 0 elsewhere."""
        image = np.zeros((*self.mask.shape, 3), np.float32)
        image[self.mask] = values
        return image


#: A representation: radiance (N, 3) of the points of a view under lights.
Shown = Callable[[View, DistantLights], Floats]


@dataclass(frozen=True)
class Loss:
    """Relative RMSE and mean ꟻLIP under each environment, by name, and radiance (N, 3) of the ball under the first."""

    rmse_rel: dict[str, float]
    flip: dict[str, float]
    first: Floats

    @property
    def mean_rmse_rel(self) -> float:
        """Root of the mean square over the environments."""
        return float(np.sqrt(np.mean(np.square(list(self.rmse_rel.values())))))

    @property
    def mean_flip(self) -> float:
        return float(np.mean(list(self.flip.values())))

    @property
    def figures(self) -> dict[str, Any]:
        """The errors as the record of an export names them; relative ones are None beside a black material."""
        defined = {name: error if np.isfinite(error) else None for name, error in self.rmse_rel.items()}
        whole = self.mean_rmse_rel
        return {
            "rmse_rel_reference": whole if np.isfinite(whole) else None,
            "flip": self.mean_flip,
            "by_environment": {name: {"rmse_rel": defined[name], "flip": self.flip[name]} for name in defined},
        }


def sphere(height: int, width: int, diameter: int = DIAMETER) -> View:
    """A ball of so many pixels over the middle of maps of `height` x `width` texels, which repeat."""
    place = (np.arange(diameter) + 0.5) / (0.5 * diameter) - 1.0
    x, y = np.meshgrid(place, -place)
    mask = x**2 + y**2 < 0.97
    x, y = x[mask], y[mask]
    z = np.sqrt(1.0 - x**2 - y**2)
    rows, columns = np.nonzero(mask)
    normal = np.column_stack([x, y, z])
    tangent = normalize(np.column_stack([z, np.zeros_like(x), -x]))
    frames = np.stack([tangent, np.cross(normal, tangent), normal], axis=2)
    return View(
        row=(rows + (height - diameter) // 2) % height,
        column=(columns + (width - diameter) // 2) % width,
        frame=frames,
        wo=np.ascontiguousarray(frames[:, 2, :]),
        mask=mask,
    )


def material_shown(material: Material, source: Source = "slices") -> Shown:
    """The material as its slices or its power law show it, or as its PBR maps do."""
    if material.pbr is not None:
        return maps_shown(material.pbr)
    scene = scene_of(material, source)
    assert scene.shading is not None
    maps = Maps([full_size(scene.shading)])
    height, width = maps.levels[0].shape[1:3]

    def show(view: View, lights: DistantLights) -> Floats:
        def terms() -> Terms:
            for lit, wi, irradiance in find_lit_points(view, lights):
                yield lit, scene.brdf.f(wi, view.wo[lit]), wi[:, 2], irradiance, wi[:, :2]

        uv = np.column_stack([(view.column + 0.5) / width, (view.row + 0.5) / height])
        return sample(scene, maps, uv, [np.zeros_like(uv)] * 2, terms())

    return show


def scene_of(material: Material, source: Source = "slices") -> Scene:
    """A scene with the material, which says its sigma and its look-up; its model and camera are any."""
    mesh = shape("plane")
    return Scene(mesh, frame(mesh.positions, 1.0), material.reflectance, material, source=source)


def maps_shown(maps: PbrMaps, gain: float = 1.0) -> Shown:
    """PBR maps: f cos summed over lights, in the frame that the map of normals bends, times `gain`."""

    def show(view: View, lights: DistantLights) -> Floats:
        at = (view.row, view.column)
        normal = maps.normal[at].astype(np.float64)
        value = np.zeros((len(view.row), 3))
        bent = replace(view, frame=_bend(view.frame, normal))
        wo = np.einsum("nij,ni->nj", bent.frame, np.einsum("nij,nj->ni", view.frame, view.wo))
        for lit, wi, irradiance in find_lit_points(bent, lights):
            there = (at[0][lit], at[1][lit])
            upright = np.einsum("nij,ni->nj", bent.frame[lit], view.frame[lit, :, 2])
            product = reflect_maps(
                maps,
                wi,
                wo[lit],
                maps.base_colour[there],
                maps.roughness[there],
                maps.metallic[there],
                maps.f0[there],
                upright,
            )
            value[lit] += product * irradiance
        return gain * value

    return show


def brdf_shown(brdf: Brdf) -> Shown:
    """One BRDF at all texels."""

    def show(view: View, lights: DistantLights) -> Floats:
        value = np.zeros((len(view.row), 3))
        for lit, wi, irradiance in find_lit_points(view, lights):
            value[lit] += brdf.f(wi, view.wo[lit]) * wi[:, 2:] * irradiance
        return value

    return show


def mean_brdf_loss(material: Material) -> Steps[Loss]:
    """The error of the one BRDF of a material in place of its PBR maps, against these under each environment."""
    wanted = yield from part(references(material), 0.0, 0.5)
    return (yield from part(loss(brdf_shown(material.reflectance), wanted, material.size), 0.5, 1.0))


def references(material: Material) -> Steps[dict[str, Floats]]:
    """Radiance (N, 3) of the ball of the material under each environment."""
    return (yield from _images(material_shown(material), material.size))


def _images(shown: Shown, size: tuple[int, int]) -> Steps[dict[str, Floats]]:
    images, view = {}, sphere(*size, DIAMETER)
    for index, name in enumerate(ENVIRONMENTS):
        yield Step(index / len(ENVIRONMENTS), f"Reference, {name}")
        images[name] = shown(view, environment_lights(name))
    return images


def brdf_loss(found: Brdf, wanted: Brdf) -> Steps[Loss]:
    """The error of a ball of one BRDF against that of another under each environment."""
    images = yield from part(_images(brdf_shown(wanted), (1, 1)), 0.0, 0.5)
    return (yield from part(loss(brdf_shown(found), images, (1, 1)), 0.5, 1.0))


def loss(
    shown: Shown, wanted: dict[str, Floats], size: tuple[int, int], mask: NDArray[np.bool_] | None = None
) -> Steps[Loss]:
    """The error of a representation of maps of `size` (H, W) against the images that `references` made.

    Of texels outside the `mask` (H, W) of an object nothing counts, unless the ball shows no others.
    """
    view = sphere(*size, DIAMETER)
    counted = np.ones(len(view.row), np.bool_) if mask is None else mask[view.row, view.column]
    counted |= not counted.any()
    compared = view.image(np.repeat(counted[:, None], 3, axis=1))[..., 0] > 0.0
    rmse_rel, flip, first = {}, {}, np.zeros((0, 3))
    for index, (name, values) in enumerate(wanted.items()):
        yield Step(index / len(wanted), f"Comparing under {name}")
        found = shown(view, environment_lights(name))
        image, reference = (view.image(np.where(counted[:, None], each, 0.0)) for each in (found, values))
        comparing = comparison(image, reference, compared)
        error = yield from part(comparing, (index + 0.5) / len(wanted), (index + 1.0) / len(wanted))
        rmse_rel[name], flip[name] = error.rmse_rel, error.flip
        first = first if index else found
    return Loss(rmse_rel, flip, first)


def display_sphere(values: Floats, wanted: Floats, size: tuple[int, int]) -> NDArray[np.uint8]:
    """(H, W, 4) sRGB codes and coverage of radiance (N, 3) of the ball, exposed so that `wanted` fills the range.

    All images of a material have the exposure of its own, or else their differences in brightness were hidden.
    """
    view = sphere(*size, DIAMETER)
    bright = float(np.quantile(wanted, 0.995)) if wanted.size else 0.0
    gain = 1.0 / bright if bright > 0.0 else 1.0
    cover = np.where(view.mask, 255, 0).astype(np.uint8)
    return np.dstack([to_display8(gain * view.image(values)), cover])


def photograph_error(shown: Shown, stack: ImageStack, mask: NDArray[np.bool_] | None = None) -> Steps[float]:
    """Relative RMSE of a representation of the size of the stack's photographs, each under its own lamp from above.

    On a regular grid of at most 65,536 texels, of which those outside the `mask` (H, W) of an object do not count. A
    stack without azimuths is of an arc towards +x.
    """
    height, width = stack.radiance.shape[1:3]
    step = grid_step(height, width)
    rows, columns = np.arange(step // 2, height, step), np.arange(step // 2, width, step)
    row, column = (grid.ravel() for grid in np.meshgrid(rows, columns, indexing="ij"))
    frames = np.broadcast_to(np.eye(3), (len(row), 3, 3))
    above = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (len(row), 3))
    view = View(row, column, frames, above, np.ones((len(rows), len(columns)), np.bool_))
    counted = np.ones(len(row), np.bool_) if mask is None else mask[row, column]
    azimuth = np.zeros(len(stack.elevation)) if stack.azimuth is None else stack.azimuth
    apart = whole = 0.0
    for index, (elevation, around) in enumerate(zip(stack.elevation, azimuth, strict=True)):
        yield Step(index / len(azimuth), "comparing with the photographs")
        across = np.cos(elevation)
        lamp = np.array([[across * np.cos(around), across * np.sin(around), np.sin(elevation)]])
        found = shown(view, DistantLights(lamp, np.ones((1, 3))))
        photograph = [stack.radiance[index, line : line + 1, step // 2 : width : step][0] for line in rows]
        wanted = np.concatenate(photograph).astype(np.float64)
        apart += float(np.sum((found - wanted)[counted] ** 2))
        whole += float(np.sum(wanted[counted] ** 2))
    return float(np.sqrt(apart / whole)) if whole > 0.0 else 0.0


@lru_cache(maxsize=len(ENVIRONMENTS))
def environment_lights(name: str) -> DistantLights:
    """The directional lights that stand for a built-in environment."""
    return choose_lights(make_built_in(name), LIGHTS)


def find_lit_points(view: View, lights: DistantLights) -> Iterator[tuple[NDArray[np.int64], Floats, Floats]]:
    """For each light the points that it reaches, its direction (M, 3) in their frames, and its irradiance (3,)."""
    for direction, irradiance in zip(lights.direction, lights.irradiance, strict=True):
        wi = np.einsum("nij,i->nj", view.frame, direction)
        lit = np.flatnonzero(wi[:, 2] > 0.0)
        if lit.size:
            yield lit, wi[lit], irradiance


def _bend(frames: Floats, normal: Floats) -> Floats:
    """Frames (N, 3, 3) whose normal is the one that a map says in them (N, 3), their tangent turned as little."""
    up = np.einsum("nij,nj->ni", frames, normal)
    tangent = normalize(frames[..., 0] - up * np.sum(frames[..., 0] * up, axis=1, keepdims=True))
    return np.stack([tangent, np.cross(up, tangent), up], axis=2)


def statement(errors: dict[str, Any]) -> str:
    """The errors of a representation as a sentence in plain ASCII, for files and pages."""
    if errors["flip"] is None:
        return "It shows no image of the surface."
    under, error = ", ".join(errors["by_environment"]), errors["rmse_rel_reference"]
    relative = (
        "relative RMSE undefined, as the material is black" if error is None else f"relative RMSE {percent(error, 3)}"
    )
    shown = f"{relative}, FLIP {number(errors['flip'])}"
    words = f"Error of what these files show, against the material under {under}: {shown}"
    if errors["rmse_rel"] is not None:
        words += f"; against the photographs: relative RMSE {percent(errors['rmse_rel'], 3)}"
    return f"{words}."


def meaning(errors: dict[str, Any]) -> str:
    """The meaning of the figures of an entry, in words: of those that are null, the reason."""
    if errors["flip"] is None:
        return "these files show no image of the surface, so that there is nothing to compare"
    words = f"rmse_rel_reference and flip: a ball of the material under {', '.join(errors['by_environment'])}"
    if errors["rmse_rel_reference"] is None:
        words += ", which is black, so that rmse_rel_reference is null"
    photographs = "null without photographs of these texels" if errors["rmse_rel"] is None else "the photographs"
    return f"{words}; rmse_rel: {photographs}"


def away(errors: dict[str, Any], others: dict[str, Any]) -> list[str]:
    """Sentences on what files show in place of the material; none where they show the material itself."""
    error, said = errors["rmse_rel_reference"], list[str]()
    under = ", ".join(errors["by_environment"])
    if errors["flip"] is not None and error is None:
        said.append(f"these files show light where the material is black (FLIP {number(errors['flip'])} under {under})")
    if error is not None and error >= EXACT:
        said.append(
            f"what these files show is {percent(error, 3)} away from the material (relative RMSE under {under})"
        )
    for name, figures in others.items():
        if figures["rmse_rel_reference"] is None:
            continue
        of_it = percent(figures["rmse_rel_reference"], 3)
        if name == "slices":
            said.append(
                f"these are the errors of the power law; the slices next to it are {of_it} away in GLSL and HLSL"
            )
        elif name == "power_law_alone":
            said.append(f"the power law without the tiles that keep their slices is {of_it} away in HLSL and OSL")
        elif figures["rmse_rel_reference"] >= EXACT:
            said.append(f"the power law behind Shader to RGB is {of_it} away from the material")
    return said
