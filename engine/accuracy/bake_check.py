"""Small images of a bake against the reference when it ends, under lights of which every program has some.

The images are `EDGE`² pixels from two sides, under environments that differ in how sharp their light is, and under one
direction; a scene adds its own. The reference is path-traced with `SAMPLES` paths a pixel, whose noise is taken off
what is stated. About 2 s of CPU time, whatever the model's size, besides its light.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import world_direction
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps, part
from engine.geometry.camera import Camera, frame
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of, meets_front
from engine.light.environment import EnvironmentMap
from engine.light.environment_file import open_environment
from engine.render.reference import ReferenceImage, reference
from engine.render.transported import image_of
from engine.scene.material import material_of_brdfs
from engine.scene.scene import Scene
from engine.transport.baking.check import (
    LAMP,
    MAX_NAME,
    Alternative,
    BakeCheck,
    LightCheck,
    write_check,
)
from engine.transport.baking.settings import BOUNCES
from engine.transport.method import Method, Subject, method_of
from engine.transport.relight import light_of

Floats = NDArray[np.float64]

#: Lights of a check by name: environments, and None for one direction.
Lights = Mapping[str, EnvironmentMap | None]

#: Pixels along a side of an image, sub-pixels along a side of a pixel, and paths of the reference in each.
EDGE, SUB_PIXELS, SAMPLES = 48, 2, 32

#: Directions from which the model is seen: angles from +Y, and from +Z towards +X, in degrees.
VIEWS = ((65.0, 25.0), (75.0, 150.0))

#: Environments of a check, from soft light to small bright sources.
ENVIRONMENTS = ("studio", "window", "noon")

#: Standard deviations that count as noise of a pixel, and radiance over the mean from which on it can look wrong.
NOISE, SEEN = 3.0, 0.05

#: The mode that is tried where another does not pass.
TRIED = "sh"

#: Vertices of the largest model for which it is tried: some ten seconds.
MAX_TRIED = 20_000


def check_lights(own: Sequence[EnvironmentMap] = ()) -> Lights:
    """The lights of a check: the `own` environments of a scene, those of the program, and one direction."""
    around = [*own, *(open_environment(name) for name in ENVIRONMENTS)]
    return {**{each.name[:MAX_NAME]: each for each in around}, LAMP: None}


def check_bake(
    transport: Any, method: Method, subject: Subject, settings: Any, own: Sequence[EnvironmentMap] = ()
) -> Steps[BakeCheck | None]:
    """Check a finished bake of `subject` by `method`; None where the reference cannot show it.

    `own` are environments of the scene. Where the bake does not pass under a light, the mode `TRIED` is baked as well,
    and named as an alternative where it passes.
    """
    if subject.variations or getattr(settings, "blend", ()) or getattr(settings, "albedo", None):
        return None
    views, lights = _views(subject), check_lights(own)
    depth = 1 + BOUNCES if getattr(settings, "interreflection", None) else 1
    yield Step(0.0, "checking the bake")
    references = yield from part(_references(subject, views, lights, depth), 0.0, 0.6)
    checks = yield from part(_compare(transport, method, subject, views, lights, references), 0.6, 0.8)
    found = BakeCheck(views=len(views), edge=EDGE, lights=tuple(checks))
    if not found.failed or method.name == TRIED:
        return found
    other = yield from part(_try(method_of(TRIED), subject, settings, views, lights, references), 0.8, 1.0)
    better = [each.light for each in other if each.passes]
    alternative = Alternative(mode=TRIED, lights=tuple(better)) if better else None
    return found.model_copy(update={"alternative": alternative})


def check_file(
    path: str | os.PathLike[str],
    transport: Any,
    method: Method,
    subject: Subject,
    settings: Any,
    own: Sequence[EnvironmentMap] = (),
) -> Steps[BakeCheck | None]:
    """Check a finished bake and keep the check in its file; OutputError where that cannot be written."""
    found = yield from check_bake(transport, method, subject, settings, own)
    if found is not None:
        write_check(path, found)
    return found


def compare_views(
    images: Sequence[NDArray[Any]],
    references: Sequence[ReferenceImage],
    light: str,
    fronts: Sequence[NDArray[np.bool_]] | None = None,
) -> LightCheck:
    """The deviation of images (H, W, 4) of a bake from the reference of each, under one light.

    Pixels count that show fronts (H, W) alone: backs that hardly see out are black in bakes, the reference lights them.
    """
    means, margins, dark, bright, squares, power, noise, pixels = [], [], 0, 0, 0.0, 0.0, 0.0, 0
    shown = fronts or [np.ones(image.shape[:2], np.bool_) for image in images]
    for image, truth, front in zip(images, references, shown, strict=True):
        covered = front & (image[..., 3] > 0.999) & (truth.image[..., 3] > 0.999)
        value, exact = (each[covered][:, :3].astype(np.float64) for each in (image, truth.image))
        if not exact.any():
            continue
        assert truth.variance is not None
        variance = truth.variance[covered]
        total = exact.sum()
        means.append((value.sum() - total) / total)
        margins.append(2.0 * np.sqrt(variance.sum()) / total)
        squares, power, noise = (
            squares + ((value - exact) ** 2).sum(),
            power + (exact**2).sum(),
            noise + variance.sum(),
        )
        low, high = _bounds(exact, variance)
        seen, sums = SEEN * total / len(exact), value.sum(axis=1)
        dark += int(((sums < 0.1 * low) & (low > seen)).sum())
        bright += int(((sums > 10.0 * high) & (sums > seen)).sum())
        pixels += len(exact)
    worst = int(np.argmax(np.abs(means))) if means else -1
    return LightCheck(
        light=light[:MAX_NAME],
        mean_rel=float(means[worst]) if means else 0.0,
        mean_uncertainty=float(margins[worst]) if means else 0.0,
        rmse_rel=float(np.sqrt(max(squares - noise, 0.0) / power)) if power > 0.0 else 0.0,
        dark=dark / pixels if pixels else 0.0,
        bright=bright / pixels if pixels else 0.0,
        pixels=pixels,
    )


def _bounds(exact: Floats, variance: Floats) -> tuple[Floats, Floats]:
    """Radiance (n,), channels summed, that the reference has at least and at most, but for noise.

    Its channels rise and fall together, so that their deviations add.
    """
    total, margin = exact.sum(axis=1), NOISE * np.sqrt(variance).sum(axis=1)
    return total - margin, total + margin


def _views(subject: Subject) -> list[Camera]:
    directions = (world_direction(*np.radians(angles)) for angles in VIEWS)
    return [frame(subject.mesh.positions, direction=direction) for direction in directions]


def find_fronts(surface: Mesh, camera: Camera, edge: int) -> NDArray[np.bool_]:
    """(edge, edge) whether all sub-pixels of a pixel show the front of a face of `surface`."""
    side = edge * SUB_PIXELS
    row, column = np.mgrid[0:side, 0:side].reshape(2, -1)
    rays = camera.rays(column + 0.5, row + 0.5, side, side)
    face = caster_of(surface).intersect(np.broadcast_to(camera.eye, rays.shape), rays).face
    seen = np.flatnonzero(face >= 0)
    front = np.zeros(len(rays), np.bool_)
    front[seen] = meets_front(surface.positions, surface.faces[face[seen]].astype(np.int64), rays[seen])
    shape = (edge, SUB_PIXELS, edge, SUB_PIXELS)
    return np.asarray(front.reshape(shape).all(axis=(1, 3)))


def _scene(subject: Subject, camera: Camera, around: EnvironmentMap | None) -> Scene:
    material = material_of_brdfs(subject.parts, subject.mesh.part_names) if subject.parts else None
    return Scene(subject.mesh, camera, subject.brdf, material, ground=subject.ground, environment=around)


def _references(
    subject: Subject, views: Sequence[Camera], lights: Lights, depth: int
) -> Steps[list[list[ReferenceImage]]]:
    """The reference of each view under each light."""
    found = []
    for number, around in enumerate(lights.values()):
        images = []
        for place, camera in enumerate(views):
            steps = reference(_scene(subject, camera, around), (EDGE, EDGE), samples=SAMPLES, max_depth=depth)
            start = number + place / len(views)
            images.append((yield from part(steps, start / len(lights), (start + 1 / len(views)) / len(lights))))
        found.append(images)
    return found


def _compare(
    transport: Any,
    method: Method,
    subject: Subject,
    views: Sequence[Camera],
    lights: Lights,
    references: Sequence[Sequence[ReferenceImage]],
) -> Steps[list[LightCheck]]:
    """The checks of a transport under each light."""
    found = []
    surface = _scene(subject, views[0], None).surface
    fronts = [find_fronts(surface, camera, EDGE) for camera in views]
    for number, ((name, around), truths) in enumerate(zip(lights.items(), references, strict=True)):
        yield Step(number / len(lights), "checking the bake")
        light = light_of(_scene(subject, views[0], around))
        relit = method.baking.relight_transport(transport, light, method.light())
        images = []
        for camera in views:
            images.append((yield from part(image_of(relit, camera, (EDGE, EDGE), SUB_PIXELS), 0.0, 1.0)).image)
        found.append(compare_views(images, truths, name, fronts))
    return found


def _try(
    method: Method,
    subject: Subject,
    like: Any,
    views: Sequence[Camera],
    lights: Lights,
    references: Sequence[Sequence[ReferenceImage]],
) -> Steps[list[LightCheck]]:
    """The checks of a bake by another method with its default settings; none where it is refused, or takes long."""
    baking = method.baking
    bounces = {"interreflection": getattr(like, "interreflection", None)}
    settings = method.with_values({name: value for name, value in bounces.items() if value is not None})
    try:
        work = yield from part(baking.prepare(subject, settings), 0.0, 0.2)
    except UsageError:
        return []
    if work.vertices > MAX_TRIED:
        return []
    with tempfile.TemporaryDirectory(prefix="lightarc-") as folder:
        made = yield from part(baking.bake(Path(folder) / "tried", work), 0.2, 0.8)
        return (yield from part(_compare(made.transport, method, subject, views, lights, references), 0.8, 1.0))
