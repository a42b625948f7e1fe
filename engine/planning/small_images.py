"""Errors of a few settings, measured on a small image of the scene before a plan answers.

The image is that of the scene's own camera, of `SIZE` pixels, against a path-traced reference of direct light whose
noise is known and taken off. Of the pixels that the model covers completely some count, drawn at random until their
faces have `MAX_VERTICES` vertices: these alone are baked, on one set of rays for all settings, and relit and drawn by
the code of every image. Beside the noise of the reference a figure has that of the choice of pixels, known from
resamples of them (Efron1979).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import remember
from engine.core.steps import Step, Steps, drain, relay
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.planning.bake_group import bake_alone, bake_group, groups, relight_transport
from engine.planning.costs.setting import Setting
from engine.planning.effects.mode_error import factors_by_terms
from engine.render.direct import radiance
from engine.render.reference import reference
from engine.render.transported import image_of
from engine.scene.mode import MODES, is_traced
from engine.scene.scene import Scene
from engine.transport import method as transport

#: Pixels (width, height), sub-pixels along a side of each, samples of the reference, and vertices that are baked.
SIZE, SUB_PIXELS, SAMPLES, MAX_VERTICES = (64, 48), 2, 256, 600

#: Models of so many times the vertices that are baked are cut.
LARGE = 4

#: Words for the measurement.
NOTE = "measuring small images"

#: Coverage from which a pixel is taken to be covered completely, and resamples of the pixels.
COVERED, RESAMPLES = 0.999, 64

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """The relative error of a setting on a small image, and the deviation (1 sigma) of its natural logarithm."""

    error_rel: float
    deviation: float


@dataclass(frozen=True, eq=False)
class _Pixels:
    """P pixels that count: their place in the image (P,), and the vertices that they show."""

    flat: NDArray[np.int64]
    vertices: NDArray[np.int64]


def measure_small(scene: Scene, settings: Sequence[Setting], *, seed: int = 0) -> Steps[dict[Setting, Measured]]:
    """The errors of those of `settings` that can be measured; nothing where the camera sees too little of the model."""
    if not settings:
        return {}
    kept = _recall(scene, seed)
    if not kept:
        kept.append((yield from relay(_look(scene, seed), lambda step: Step(0.5 * step.done, NOTE))))
    pixels, truth, noise = kept[0]
    if len(pixels.flat) < RESAMPLES:
        return {}
    found = {}
    for number, (setting, image) in enumerate(_images(scene, settings, pixels)):
        yield Step(0.5 + 0.5 * number / len(settings), NOTE)
        shown = np.asarray(image[..., :3], np.float64).reshape(-1, 3)[pixels.flat]
        measured = compare_pixels(shown, truth, noise)
        if measured is not None:
            found[setting] = measured
    return found


def _look(scene: Scene, seed: int) -> Steps[tuple[_Pixels, Array, Array]]:
    """The pixels that count, their radiance (P, 3) and its variance."""
    exact = yield from reference(scene, SIZE, samples=SAMPLES, max_depth=1, seed=seed)
    assert exact.variance is not None
    pixels = _choose_pixels(scene, exact.image[..., 3] >= COVERED, seed)
    truth = exact.image[..., :3].reshape(-1, 3)[pixels.flat].astype(np.float64)
    return pixels, truth, exact.variance.reshape(-1, 3)[pixels.flat]


@remember(2)
def _recall(_scene: Scene, _seed: int) -> list[tuple[_Pixels, Array, Array]]:
    """What `_look` found for these arguments; empty at first."""
    return []


def compare_pixels(shown: Array, truth: Array, noise: Array) -> Measured | None:
    """The error of pixels (P, 3) against `truth` with variances `noise`; None where noise hides it."""
    apart = ((shown - truth) ** 2 - noise).sum(axis=1)
    power = (truth**2 - noise).sum(axis=1)
    rows = np.random.default_rng(0).integers(len(shown), size=(RESAMPLES, len(shown)))
    share = apart.sum() / max(float(power.sum()), 1e-300)
    # the noise of a squared difference is that of a product with it, beside its own square
    own = np.sqrt((4.0 * np.maximum(apart, 0.0) * noise.sum(axis=1) + 2.0 * noise.sum(axis=1) ** 2).sum())
    own /= max(float(power.sum()), 1e-300)
    again = apart[rows].sum(axis=1) / np.maximum(power[rows].sum(axis=1), 1e-300)
    deviation = math.hypot(float(again.std()), own)
    if share <= 2.0 * deviation:  # hidden by noise: the error is small, and hardly more is known
        return Measured(math.sqrt(max(share, 0.0) + deviation), 1.0) if deviation > 0.0 else None
    return Measured(math.sqrt(share), min(0.5 * deviation / share, 1.0))


def _choose_pixels(scene: Scene, covered: NDArray[np.bool_], seed: int) -> _Pixels:
    """Pixels that the model covers completely, in random order, until their faces have enough vertices."""
    (width, height), surface, first = SIZE, scene.surface, len(scene.mesh.faces)
    row, column = np.mgrid[0 : height * SUB_PIXELS, 0 : width * SUB_PIXELS].reshape(2, -1) + 0.5
    directions = scene.camera.rays(column, row, width * SUB_PIXELS, height * SUB_PIXELS).reshape(-1, 3)
    caster = caster_of(surface)
    face = caster.intersect(np.broadcast_to(scene.camera.eye, directions.shape), directions).face
    blocks = face.reshape(height, SUB_PIXELS, width, SUB_PIXELS).transpose(0, 2, 1, 3).reshape(height * width, -1)
    whole = np.flatnonzero(((blocks >= 0) & (blocks < first)).all(axis=1) & covered.ravel())
    order = np.random.default_rng((41, seed)).permutation(whole)
    corners = surface.faces[np.maximum(blocks[order], 0)].reshape(len(order), 3 * SUB_PIXELS**2)
    new = np.zeros(len(surface.positions), np.bool_)
    count, kept = 0, 0
    for some in corners:
        fresh = np.unique(some[~new[some]])
        if count + len(fresh) > MAX_VERTICES and kept >= RESAMPLES:
            break
        new[fresh] = True
        count, kept = count + len(fresh), kept + 1
    return _Pixels(np.sort(order[:kept]), np.flatnonzero(new))


def _cut_out(scene: Scene, pixels: _Pixels) -> tuple[Scene, NDArray[np.int64]]:
    """The faces around the vertices of `pixels` as a model of its own, and these vertices there.

    Rows of matrices of a large model would take a gigabyte, for some hundred vertices that are baked.
    """
    mesh = scene.mesh
    wanted = np.zeros(len(mesh.positions), np.bool_)
    wanted[pixels.vertices] = True
    faces = mesh.faces[wanted[mesh.faces].any(axis=1)]
    used, place = np.unique(faces, return_inverse=True)
    corners = place.reshape(-1, 3).astype(np.int32)
    part = Mesh(mesh.positions[used], mesh.normals[used], mesh.uv[used], corners, mesh.name)
    return dataclasses.replace(scene, mesh=part, ground=None), np.searchsorted(used, pixels.vertices)


def _images(scene: Scene, settings: Sequence[Setting], pixels: _Pixels) -> Iterator[tuple[Setting, NDArray[Any]]]:
    baked = [each for each in settings if each.mode in transport.names()]
    known: dict[Any, Any] = {}
    if any("terms" in each.parameters for each in baked):
        known |= factors_by_terms(scene.brdf)  # prediction has made them
    is_large = len(scene.mesh.positions) > LARGE * MAX_VERTICES
    # rows of methods that take another BRDF are matrices, of which a large model has a gigabyte
    large = [each for each in baked if is_large and transport.method_of(each.mode).takes_brdf]
    part, shown = _cut_out(scene, pixels)
    for place, some, vertices, caster in (
        (scene, [each for each in baked if each not in large], pixels.vertices, None),
        (part, large, shown, caster_of(scene.surface)),
    ):
        for group in groups(some):
            for bake in drain(bake_group(place, group, shown=vertices, known=known, caster=caster))[0]:
                lit = relight_transport(bake, scene)
                yield bake.setting, drain(image_of(lit, scene.camera, SIZE, SUB_PIXELS)).image
    for setting in baked:
        if not transport.method_of(setting.mode).shares_rays:
            for bake in drain(bake_alone(scene, setting, shown=pixels.vertices))[0]:
                lit = relight_transport(bake, scene)
                yield setting, drain(image_of(lit, scene.camera, SIZE, SUB_PIXELS)).image
    for each in settings:
        if each.mode in MODES and not is_traced(each.mode):
            drawn = dataclasses.replace(MODES[each.mode].adapt(scene), directions=each["directions"], relit=None)
            yield each, drain(radiance(drawn, SIZE, samples=SUB_PIXELS))


def as_record(found: Mapping[Setting, Measured]) -> list[dict[str, Any]]:
    """The figures as JSON."""
    return [{**setting.as_json(), **dataclasses.asdict(each)} for setting, each in found.items()]
