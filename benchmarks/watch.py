"""A capture that is being taken: seconds from the end of its last photograph until its stack is there, and its slope.

Photographs of a dome as JPEG are there but for the last, and have been decoded; then the last one is written. What is
measured is what a user waits for: that it is noticed, decoded and judged, and the import of all of them. The time of 64
photographs of 24 megapixels follows from a plane through smaller captures, c0 + c1 N + c2 N · megapixels, and is
compared with an import of the same folder that decodes anew. The stack is written at the end, 13 bytes a pixel, which
bounds it: 20 GB of the largest capture.
"""

from __future__ import annotations

import math
import time
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np

from benchmarks.measure import Accuracy
from engine.capture.arriving import Capture, Watching, arrive, decoding_options
from engine.capture.decoded import Decoded
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.core.steps import Step, Steps, drain
from engine.storage.atomic import make_folder, write_bytes
from engine.storage.notices import Notices

#: Numbers of photographs and megapixels of the captures that are measured, and those of the one that is told of.
CAPTURES, LARGEST = ((8, 1.0), (24, 1.0), (8, 4.0), (24, 4.0)), (64, 24.0)

#: Imports that are measured, and the seconds that a user may wait for the largest one, and for its last verdict.
KINDS = {"direct": ImportSettings(calibrate="none"), "calibrated": ImportSettings()}
LIMIT_S, VERDICT_LIMIT_S = 10.0, 2.0


def watch(folder: Path) -> Steps[list[Accuracy]]:
    """Seconds after the last photograph, in the working `folder`."""
    found: dict[str, list[float]] = {name: [] for name in (*KINDS, "again", "verdict")}
    for at, (count, megapixels) in enumerate(CAPTURES):
        yield Step(at / len(CAPTURES), f"{count} photographs of {megapixels:g} megapixels")
        place = _take(folder / f"{count}-{megapixels:g}", count, megapixels)
        for name, settings in KINDS.items():
            verdict_s, stack_s = _wait_for(place, count, settings, folder / f"stack-{at}-{name}")
            found[name].append(stack_s)
            if name == "direct":
                found["verdict"].append(verdict_s)
        begun_s = time.perf_counter()
        drain(import_stack(find([place]), KINDS["calibrated"], folder / f"again-{at}"))
        found["again"].append(time.perf_counter() - begun_s)
    largest = f"{LARGEST[0]} photographs of {LARGEST[1]:g} megapixels"
    results = []
    limits_s = {"direct": LIMIT_S, "calibrated": LIMIT_S, "verdict": VERDICT_LIMIT_S, "again": None}
    for name, limit_s in limits_s.items():
        what = {"again": "an import that decodes anew", "verdict": "the verdict on the last photograph"}.get(
            name, f"the stack ({name}) after the last photograph"
        )
        measured = ", ".join(f"{n} × {mp:g}: {s:.2g}" for (n, mp), s in zip(CAPTURES, found[name], strict=True))
        text = f"seconds until {what} of {largest}, from smaller captures ({measured})"
        found_s = _extrapolate(found[name], grows=name != "verdict")
        results.append(Accuracy(f"watch-{name}", found_s, text, limit_s))
    return results


def _take(place: Path, count: int, megapixels: float) -> Path:
    """The photographs of a dome, and the list of its lights, as if they had been there for long."""
    make_folder(place)
    height = round(math.sqrt(megapixels * 1e6 / 1.5))
    width = round(1.5 * height)
    random = np.random.default_rng(1)
    surface = cv2.resize(random.random((height // 6 + 1, width // 6 + 1), np.float32), (width, height))
    slopes = cv2.Sobel(surface, cv2.CV_32F, 1, 0), cv2.Sobel(surface, cv2.CV_32F, 0, 1)
    lines = [str(count)]
    for at in range(count):
        elevation, azimuth = math.radians(25.0 + 25.0 * (at % 3)), 2.0 * math.pi * at / count
        x, y, z = math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)
        shaded = np.clip(z - 0.2 * (x * slopes[0] - y * slopes[1]), 0.0, None) * (0.3 + 0.5 * surface)
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
    begun_s = 0.0
    with closing(Decoded(decoding_options(place, settings))) as decoded, closing(Notices(place)) as notices:

        def write_last(step: Step) -> None:
            nonlocal begun_s
            if not begun_s and isinstance(step.partial, Capture) and step.partial.count == count - 1:
                last.write_bytes(content)
                begun_s = time.perf_counter()

        drain(arrive(decoded, Watching(place), wait=notices.wait), write_last)
        verdict_s = time.perf_counter() - begun_s
        drain(import_stack(find([place]), settings, target))
        return verdict_s, time.perf_counter() - begun_s


def _extrapolate(seconds: list[float], *, grows: bool) -> float:
    """Seconds of the largest capture by the plane through those that were measured, none of whose parts falls; what
    does not grow with the number of photographs depends on the size of one alone."""
    from scipy.optimize import nnls

    rows = [(1.0, count * grows, (count if grows else 1.0) * size) for count, size in (*CAPTURES, LARGEST)]
    parts, _ = nnls(np.array(rows[:-1]), np.array(seconds))
    return float(parts @ np.array(rows[-1]))
