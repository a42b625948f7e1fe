"""The whole path on the built-in sample: photographs, shading map, compression, a rendered model, a bundle, a sheet.

`demo` goes the way that a user goes, with the same functions. A stage that fails in a way that is reported to
users (no OpenGL, a full disk) is noted with its sentence; what depends on it is left out and everything else is
made.
Cost: 18 s of CPU time, of which the simulation takes 7 s, and 25 s more where kernels must be compiled first.

The demo's contact sheet: photographs, slices, the compressed pair with its error, the model.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.bundle.bundle import save_bundle
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.stack import ImageStack
from engine.core.colour import to_display8, tone_map
from engine.core.errors import LightarcError, MissingCapability
from engine.core.figure_text import percent, size_text
from engine.core.steps import Step, Steps, part
from engine.figures.contact_sheet import Image, Panel, Row, draw_sheet, panel_width, plot, with_colour_bar
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.gl.context import create_context
from engine.gl.direct import DirectRenderer
from engine.images.encode import encode_png
from engine.render import direct
from engine.scene.material import Material, error_figures
from engine.scene.scene import SOURCES, Scene, Source
from engine.shading.power_law import PowerLawMap, fit
from engine.shading.shading_map import ShadingMap, build
from engine.simulate.arc import LightArc
from engine.simulate.simulate import Capture, simulate
from engine.storage.atomic import atomic_folder, write_bytes, write_json


@dataclass(frozen=True, eq=False)
class Shown:
    """Parts of the sheet; None for what could not be made."""

    name: str
    capture: Capture | None
    stack: ImageStack | None
    shading_map: ShadingMap | None
    power_law: PowerLawMap | None
    images: Mapping[Source, Image] | None


def sheet(shown: Shown, reason: str, time_s: float) -> Image:
    """(H, W, 3) uint8 contact sheet; `reason` stands where an image is missing."""
    rows = (
        _row("Photographs, by elevation of the lamp", _photographs(shown.stack), reason),
        _row("Shading map: slices whose mean radiance grows in equal steps", _slices(shown.shading_map), reason),
        _row("Compressed: in each texel and channel a scale and an exponent of r / r max", _pair(shown), reason),
        _row("On a model, under one lamp", _models(shown.images), reason, aspect=1.6),
    )
    return draw_sheet(f"{shown.name.capitalize()} sample", _subtitle(shown, time_s), rows)


def _row(heading: str, panels: tuple[Panel, ...], reason: str, aspect: float = 1.0) -> Row:
    """A row of panels, or a low band with the reason why there are none."""
    return Row(heading, panels, aspect) if panels else Row(heading, (Panel(None, reason or "not made"),), 16.0)


def _photographs(stack: ImageStack | None) -> tuple[Panel, ...]:
    if stack is None:
        return ()
    chosen = np.linspace(0, len(stack.elevation) - 1, min(len(stack.elevation), 10)).round().astype(int)
    gain = _gain(stack.radiance[-1])
    return tuple(Panel(_image(stack.radiance[i], gain), f"{stack.elevation_deg[i]:.4g}°") for i in chosen)


def _slices(shading_map: ShadingMap | None) -> tuple[Panel, ...]:
    if shading_map is None:
        return ()
    gain = _gain(shading_map.slices[-1])
    pairs = zip(shading_map.slices, shading_map.mean_radiance, strict=True)
    return tuple(Panel(_image(image, gain), f"r = {mean:.3f}") for image, mean in pairs)


def _pair(shown: Shown) -> tuple[Panel, ...]:
    if shown.power_law is None or shown.stack is None:
        return ()
    scale, error = shown.power_law.scale, shown.power_law.error_map
    size = panel_width(4)
    exponent = shown.power_law.exponent.mean(axis=2)
    curve = plot(
        shown.stack.elevation_deg, shown.stack.mean_radiance, "elevation of the lamp in °", "mean radiance", size
    )
    return (
        Panel(_image(scale, _gain(scale)), "scale: the brightest slice"),
        Panel(with_colour_bar(exponent, "exponent", size), "exponent, mean of the channels"),
        Panel(with_colour_bar(error, "RMS error in radiance", size), f"error of the compression: {_per_cent(shown)}"),
        Panel(curve, "mean radiance of the photographs"),
    )


def _models(images: Mapping[Source, Image] | None) -> tuple[Panel, ...]:
    captions: dict[Source, str] = {"slices": "from the slices", "power-law": "from the compressed pair"}
    return tuple(Panel(image, captions[source]) for source, image in (images or {}).items())


def _subtitle(shown: Shown, time_s: float) -> str:
    parts = []
    if shown.stack is not None:
        count, height, width = shown.stack.radiance.shape[:3]
        parts.append(f"{count} photographs of {width} × {height} pixels on the virtual light arc")
    if shown.power_law is not None and shown.shading_map is not None:
        before, after = shown.shading_map.slices.nbytes, shown.power_law.scale.nbytes + shown.power_law.exponent.nbytes
        parts.append(f"{size_text(before)} of slices become {size_text(after)}")
    return "   ·   ".join([*parts, f"made in {time_s:.1f} s"])


def _per_cent(shown: Shown) -> str:
    assert shown.power_law is not None
    return f"RMS {percent(shown.power_law.rms / shown.power_law.r_max, 3)} of r max"


def _image(radiance: NDArray[np.float32], gain: float) -> Image:
    return to_display8(np.asarray(radiance) * np.float32(gain))


def _gain(brightest: NDArray[np.float32]) -> float:
    """Makes the brightest parts of an image just not clip on the display."""
    top = float(np.percentile(brightest, 99.5))
    return 0.9 / top if top > 0 and math.isfinite(top) else 1.0


Result = TypeVar("Result")

#: By this file a folder is known to be a demo, which a later one may replace.
MARKER = "demo.json"

BRDF, MODEL, SLICES, REPEATS = "ggx:alpha=0.5", "cloth", 8, 3.0
IMAGE_SIZE = (1280, 800)
LIGHT, IRRADIANCE, GROUND = (-0.45, 0.6, 0.75), 2.2, 0.0123


@dataclass(frozen=True)
class Stage:
    """One part of the demo: how long it took, and the sentence of what went wrong."""

    name: str
    time_s: float
    error: str | None = None


@dataclass(frozen=True)
class Demo:
    """Files that the demo left in its folder; paths of what could not be made are absent.

    `warnings` are sentences of stages that failed, and of the health of the stack and the material.
    """

    bundle: Path | None
    images: tuple[Path, ...]
    stages: tuple[Stage, ...]
    warnings: tuple[str, ...] = ()


def demo(folder: Path, arc: LightArc | None = None) -> Steps[Demo]:
    """Make everything in `folder`, which is complete at the end or as it was before.

    Raises OutputError where the folder cannot be written or holds something else. All other failures that are
    reported to users become the `error` of their stage.
    """
    with atomic_folder(folder, MARKER) as making:
        stages, bundle, doubts = yield from _stages(making, arc or LightArc())
        stages = [replace(stage, error=_final(stage.error, making, folder)) for stage in stages]
        images = sorted(image.name for image in making.glob("*.png"))
        write_json(making / MARKER, {"images": images, "stages": [asdict(stage) for stage in stages]})
        yield Step(1.0, "Done")
    failed = [f"{stage.name}: {stage.error}" for stage in stages if stage.error]
    paths = tuple(folder / image for image in images)
    return Demo(folder / bundle.name if bundle else None, paths, tuple(stages), (*failed, *doubts))


def _stages(folder: Path, arc: LightArc) -> Steps[tuple[list[Stage], Path | None, list[str]]]:
    """Run all stages in order; what a failed one should have made is None, and stages that need it are left out.

    The last that is returned is what is doubtful about the stack and the material.
    """
    stages: list[Stage] = []

    def stage(name: str, until: float, work: Callable[..., Steps[Result]], *needed: object) -> Steps[Result | None]:
        return part(_attempt(stages, name, work, needed), until - 0.1, until)

    capture = yield from stage("simulate", 0.2, lambda: simulate(arc, folder / "capture"))
    stack = yield from stage("import", 0.5, partial(_import, folder / "stack"), capture)
    shading_map = yield from stage("shade", 0.6, partial(build, slices=SLICES), stack)
    power_law = yield from stage("compress", 0.7, fit, shading_map)
    material = None
    if stack is not None and shading_map is not None:
        material = _material(arc.sample, stack, shading_map, power_law)
    images = yield from stage("render", 0.8, partial(_render, folder), material)
    bundle = yield from stage("bundle", 0.9, partial(_bundle, folder), material, stack, images or ())
    shown = Shown(arc.sample, capture, stack, shading_map, power_law, images)
    yield from stage("contact sheet", 1.0, partial(_draw, folder, shown, tuple(stages)))
    doubts = [text for made in (stack, material) if made is not None for text in made.health.warnings]
    return stages, bundle, list(dict.fromkeys(doubts))


def _attempt(
    stages: list[Stage], name: str, work: Callable[..., Steps[Result]], needed: tuple[object, ...]
) -> Steps[Result | None]:
    """Do `work` with what it needs, and note in `stages` how long that took or why it could not be done."""
    if any(value is None for value in needed):
        stages.append(Stage(name, 0.0, "Left out, because an earlier stage failed."))
        return None
    start = time.perf_counter()
    try:
        result = yield from work(*needed)
    except LightarcError as error:
        stages.append(Stage(name, time.perf_counter() - start, str(error)))
        return None
    stages.append(Stage(name, time.perf_counter() - start))
    return result


def _import(folder: Path, capture: Capture) -> Steps[ImageStack]:
    """Import as from a tripod: the virtual camera wanders by half a pixel, and relief under a grazing lamp seems to
    move by more, so that aligning would blur what is sharp."""
    return import_stack(find([capture.folder]), ImportSettings(motion="none"), folder)


def _material(name: str, stack: ImageStack, shading_map: ShadingMap, power_law: PowerLawMap | None) -> Material:
    health = shading_map.health if power_law is None else shading_map.health.merge(power_law.health)
    elevation_deg = tuple(float(angle) for angle in stack.elevation_deg)
    return Material(shading_map, power_law, brdf=BRDF, elevation_deg=elevation_deg, name=name, health=health)


def _render(folder: Path, material: Material) -> Steps[dict[Source, Image]]:
    """The material on a model, from each form that it has, also as PNG files in `folder`."""
    yield Step(0.0, f"Preparing the {MODEL}")
    mesh = shape(MODEL)
    camera = frame(mesh.positions, IMAGE_SIZE[0] / IMAGE_SIZE[1])
    sources: list[Source] = ["slices"] if material.power_law is None else list(SOURCES)
    brdf = brdf_from_text(material.brdf)
    scenes = [Scene(mesh, camera, brdf, material, LIGHT, IRRADIANCE, source, repeats=REPEATS) for source in sources]
    radiances = yield from _radiances(scenes)
    images = {scene.source: _develop(radiance) for scene, radiance in zip(scenes, radiances, strict=True)}
    for source, image in images.items():
        write_bytes(folder / f"{MODEL}_{source}.png", encode_png(image))
    return images


def _radiances(scenes: list[Scene]) -> Steps[list[NDArray[np.float32]]]:
    """(H, W, 4) radiance and coverage of each scene: with OpenGL, or on the CPU where there is none."""
    radiances: list[NDArray[np.float32]] = []
    try:
        context = create_context()
    except MissingCapability:
        for index, scene in enumerate(scenes):
            steps = direct.radiance(scene, IMAGE_SIZE)
            radiances.append((yield from part(steps, index / len(scenes), (index + 1) / len(scenes))))
        return radiances
    try:
        renderer = DirectRenderer(context)
        for scene in scenes:
            yield Step(len(radiances) / len(scenes), f"Rendering from {scene.source}")
            radiances.append(renderer.radiance(scene, IMAGE_SIZE))
        renderer.release()
    finally:
        context.release()
    return radiances


def _develop(radiance: NDArray[np.float32]) -> Image:
    """Tone-mapped image of (H, W, 4) radiance and coverage, on a dark ground."""
    return to_display8(tone_map(radiance[..., :3]) + (1 - radiance[..., 3:]) * GROUND)


def _bundle(folder: Path, material: Material, stack: ImageStack, images: Mapping[Source, Image]) -> Steps[Path]:
    preview = encode_png(images["slices"]) if images else None
    path = folder / f"{material.name}.lightarc"
    return save_bundle(path, material, provenance=stack.provenance, figures=error_figures(material), preview=preview)


def _draw(folder: Path, shown: Shown, stages: tuple[Stage, ...]) -> Steps[Path]:
    """Draw the contact sheet; where an image is missing stands the sentence of the stage that failed first."""
    yield Step(0.0, "Drawing the contact sheet")
    reason = next((stage.error for stage in stages if stage.error), "")
    write_bytes(folder / "contact_sheet.png", encode_png(sheet(shown, reason, sum(stage.time_s for stage in stages))))
    return folder / "contact_sheet.png"


def _final(error: str | None, making: Path, folder: Path) -> str | None:
    """The sentence with the folder's final name in place of the hidden one that it had while it was made."""
    return error and error.replace(str(making), str(folder))
