"""A capture that is being taken: seconds from the end of its last photograph until stack and material are there.

Photographs of a dome as JPEG are there but for the last, and have been decoded, and written where that can be done
before all are there (`engine.capture.ahead`); then the last one is written. What is measured is what a user waits for:
that it is noticed, decoded and judged, the import of all of them, and their material. Captures have the size of the
largest one, and fewer photographs unless their number is given: the time of the largest follows from the line c0 + c1 N
through them, neither part below 0. It stands beside an import of the same folder that decodes anew, and the seconds
that the disk needs for the bytes of the largest stack, by a file of two gigabytes that is flushed.

Codes of all photographs but the last one are written before it is there, and the terms of a rig that is estimated are
applied whenever they are read, so that what is left is one reading of the codes for the report: 3 bytes a pixel, 4.6 GB
of the largest capture; in a lit room one more, for the light that is taken off.
"""

from __future__ import annotations

import math
import time
from contextlib import ExitStack, closing
from pathlib import Path

import cv2
import numpy as np

from app.commands.making import material_of
from app.document.document import Project
from benchmarks.measure import Accuracy
from engine.capture.ahead import WrittenAhead
from engine.capture.arriving import Capture, Watching, arrive, decoding_options
from engine.capture.decoded import Decoded
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.stack import open_stack
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps, drain
from engine.storage.atomic import atomic_file, discard, make_folder, write_bytes
from engine.storage.notices import Notices

#: Numbers of photographs of the captures that are measured and of the one that is told of, and megapixels of all.
COUNTS, LARGEST, MEGAPIXELS = (4, 8, 12), 64, 24.0

#: Bytes of a pixel in a stack of photographs of 8 bits.
PIXEL_BYTES = 3

#: Imports that are measured, each with the room light over that by a lamp, and the seconds that a user may wait for the
#: largest one, and for its last verdict.
KINDS = {
    "direct": (ImportSettings(calibrate="none"), 0.0),
    "calibrated": (ImportSettings(), 0.0),
    "lit": (ImportSettings(), 0.15),
}
LIMIT_S, VERDICT_LIMIT_S = 10.0, 2.0

#: What is measured, and its limit.
_SAID = {
    "direct-stack": ("the stack of a known rig after the last photograph", None),
    "direct": ("the material of a known rig after the last photograph", LIMIT_S),
    "calibrated-stack": ("the stack of a rig that is estimated after the last photograph", None),
    "calibrated": ("the material of a rig that is estimated after the last photograph", LIMIT_S),
    "lit-stack": ("the stack of a rig in a lit room after the last photograph", None),
    "lit": ("the material of a rig in a lit room after the last photograph", LIMIT_S),
    "verdict": ("the verdict on the last photograph", VERDICT_LIMIT_S),
    "again": ("a stack that is decoded anew", None),
}


def watch(folder: Path, *, photographs: int | None = None) -> Steps[list[Accuracy]]:
    """Seconds after the last photograph, in the working `folder`.

    `photographs` is the number of those of the one capture that is measured, from which nothing is extrapolated.
    UsageError for fewer than 4.
    """
    if photographs is not None and photographs < COUNTS[0]:
        raise UsageError(f"--photographs {photographs}: watch takes {COUNTS[0]} or more")
    counts, largest = (COUNTS, LARGEST) if photographs is None else ((photographs,), photographs)
    found: dict[str, list[float]] = {name: [] for name in _SAID}
    yield Step(0.0, "making kernels ready")
    for name, (settings, room) in KINDS.items():
        place = _take(folder / "first", COUNTS[-1], room)  # of fewer, not all of a rig is estimated
        _wait_for(place, COUNTS[-1], settings, folder / f"first-{name}")
        discard(place)
    for at, count in enumerate(counts):
        yield Step(at / len(counts), f"{count} photographs of {MEGAPIXELS:g} megapixels")
        place, shown = _take(folder / f"{count}", count, 0.0), 0.0
        for name, (settings, room) in KINDS.items():
            if room != shown:
                discard(place)
                place, shown = _take(folder / f"{count}", count, room), room
            target = folder / f"stack-{name}"
            verdict_s, stack_s = _wait_for(place, count, settings, target)
            found["verdict"].append(verdict_s)
            found[f"{name}-stack"].append(stack_s)
            found[name].append(stack_s + _make_material(target))
            discard(target)
            if name == "calibrated":
                begun_s = time.perf_counter()
                drain(import_stack(find([place]), settings, folder / "again"))
                found["again"].append(time.perf_counter() - begun_s)
                discard(folder / "again")
        discard(place)
    results = []
    for name, (said, limit_s) in _SAID.items():
        text = f"seconds until {said} of {largest} photographs of {MEGAPIXELS:g} megapixels"
        if name == "verdict":
            found_s = max(found[name])
        elif photographs is None:
            found_s = _extrapolate(found[name])
            text += f", from fewer ({', '.join(f'{n}: {s:.2g}' for n, s in zip(counts, found[name], strict=True))})"
        else:
            found_s = found[name][0]
        results.append(Accuracy(f"watch-{name}", found_s, text, limit_s))
    stack_gb = largest * MEGAPIXELS * PIXEL_BYTES / 1e3
    text = f"seconds that the disk takes for the {stack_gb:.2g} GB of the largest stack"
    return [*results, Accuracy("watch-disk", stack_gb * _flush_gigabyte(folder), text, None)]


def _take(place: Path, count: int, room: float) -> Path:
    """The photographs of a dome, and the list of its lights, as if they had been there for long; with so much `room`
    light from above over that by a lamp."""
    make_folder(place)
    height = round(math.sqrt(MEGAPIXELS * 1e6 / 1.5))
    width = round(1.5 * height)
    random = np.random.default_rng(1)
    surface = cv2.resize(random.random((height // 6 + 1, width // 6 + 1), np.float32), (width, height))
    slopes = cv2.Sobel(surface, cv2.CV_32F, 1, 0), cv2.Sobel(surface, cv2.CV_32F, 0, 1)
    lines = [str(count)]
    for at in range(count):
        elevation, azimuth = math.radians(25.0 + 25.0 * (at % 3)), 2.0 * math.pi * at / count
        x, y, z = math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)
        shaded = (np.clip(z - 0.2 * (x * slopes[0] - y * slopes[1]), 0.0, None) + room) * (0.3 + 0.5 * surface)
        grey = (255.0 * np.clip(shaded, 0.0, 1.0) ** (1.0 / 2.2)).astype(np.uint8)
        codes = np.repeat(grey[..., None], 3, axis=2)
        write_bytes(place / f"{at:03}.jpg", cv2.imencode(".jpg", codes)[1].tobytes())
        lines.append(f"{at:03}.jpg {x:.6f} {y:.6f} {z:.6f}")
    write_bytes(place / "lights.lp", "\n".join(lines).encode())
    return place


def _wait_for(place: Path, count: int, settings: ImportSettings, target: Path) -> tuple[float, float]:
    """Seconds from the end of the last photograph until the verdict on it, and until the stack is there."""
    last = sorted(place.glob("*.jpg"))[-1]
    content = last.read_bytes()
    last.unlink()
    begun_s, there = 0.0, 0
    with ExitStack() as held:
        decoded = held.enter_context(closing(Decoded(decoding_options(place, settings))))
        ahead = held.enter_context(closing(WrittenAhead(target, settings, decoded.options)))
        notices = held.enter_context(closing(Notices(place)))

        def write_last(step: Step) -> None:
            nonlocal begun_s, there
            if isinstance(step.partial, Capture):
                there = step.partial.count
            if not begun_s and there == count - 1 and ahead.count == count - 1:
                last.write_bytes(content)
                begun_s = time.perf_counter()

        drain(arrive(decoded, Watching(place), wait=notices.wait, ahead=ahead), write_last)
        verdict_s = time.perf_counter() - begun_s
        drain(import_stack(find([place]), settings, target))
        return verdict_s, time.perf_counter() - begun_s


def _make_material(folder: Path) -> float:
    """Seconds until the material of the stack in `folder` is there, as a project has it."""
    project = Project(name="material", stack=open_stack(folder, verify=False))
    drain(material_of(project))
    begun_s = time.perf_counter()
    drain(material_of(project))
    return time.perf_counter() - begun_s


def _flush_gigabyte(folder: Path) -> float:
    """Seconds that a gigabyte takes until it is on the disk."""
    begun_s = time.perf_counter()
    with atomic_file(folder / "flushed") as file:
        for _ in range(128):
            file.write(bytes(1 << 24))
    return (time.perf_counter() - begun_s) / (128 * (1 << 24) / 1e9)


def _extrapolate(seconds: list[float]) -> float:
    """Seconds of the largest capture by the line through those that were measured, neither part of which is below 0."""
    from scipy.optimize import nnls

    parts, _ = nnls(np.array([(1.0, count) for count in COUNTS]), np.array(seconds))
    return float(parts @ (1.0, LARGEST))
