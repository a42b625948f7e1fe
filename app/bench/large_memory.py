"""Memory that large captures take: import with alignment, and `shade` to a bundle, each in a process of its own.

Ten photographs of each size are made on the disk, as 16-bit TIFFs. The memory of the process and of its decoders is
sampled ten times a second, in proportional shares (PSS), so that what they share counts once. Two figures are told:
that of all pages, and that without the pages of mapped files, which the system takes back when it needs them.
The slope is that of a line through the peaks of all sizes, in bytes for each pixel of a photograph.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil

from app.bench.program import PHOTOGRAPHS, large_photographs
from engine.bench.measure import Accuracy
from engine.core.errors import InputError, MissingCapability
from engine.core.steps import Step, Steps
from engine.storage.atomic import discard

#: Memory that ten photographs of 150 megapixels may take.
LIMIT_BYTES = 6 * 2**30

#: Sizes without `--megapixels`: from them the slope is known within minutes.
MEGAPIXELS = (6.0, 24.0, 48.0)

_INTERVAL_S = 0.1


class Peak(NamedTuple):
    """The most memory of a command at any moment, in bytes: all pages, those of no mapped file; and its seconds."""

    all_bytes: int
    without_files_bytes: int
    time_s: float


def large_memory(folder: Path, megapixels: Sequence[float] = MEGAPIXELS) -> Steps[list[Accuracy]]:
    """Peaks in GiB at every size and their slope, for `import` and for `shade`.

    `folder` needs room for some 350 bytes for each pixel of a photograph: 50 GB for 150 megapixels.
    """
    if not Path("/proc/self/smaps_rollup").exists():
        raise MissingCapability("This system does not tell the memory of a process by kind", "Measure on Linux")
    peaks: dict[str, list[Peak]] = {"import": [], "shade": []}
    for index, size in enumerate(sizes := sorted(megapixels)):
        place, stack, bundle = (folder / name for name in ("photographs", "stack", "material.lightarc"))
        yield Step(index / len(sizes), f"making photographs of {size:g} megapixels")
        yield from large_photographs(place, round(1000 * np.sqrt(size / 1.5)), round(1500 * np.sqrt(size / 1.5)))
        for verb, words in (("import", (place, "-o", stack)), ("shade", (stack, "-o", bundle))):
            note = f"{verb} of {PHOTOGRAPHS} × {size:g} megapixels"
            peaks[verb].append((yield from _watched([verb, *map(str, words)], (index + 0.5) / len(sizes), note)))
            discard(place)
        for made in (stack, bundle):
            discard(made)
    return [_found(verb, sizes, of_verb) for verb, of_verb in peaks.items()]


def _found(verb: str, sizes: Sequence[float], peaks: Sequence[Peak]) -> Accuracy:
    pixels = 1e6 * np.asarray(sizes)
    slopes = [
        float(np.polyfit(pixels, [getattr(peak, kind) for peak in peaks], 1)[0]) if len(peaks) > 1 else None
        for kind in ("all_bytes", "without_files_bytes")
    ]
    table = "; ".join(
        f"{size:g} megapixels: {peak.all_bytes / 2**30:.2f} GiB, {peak.without_files_bytes / 2**30:.2f} without mapped "
        f"files, {peak.time_s:.0f} s"
        for size, peak in zip(sizes, peaks, strict=True)
    )
    slope = f"{slopes[0]:.1f} bytes a pixel ({slopes[1]:.1f} without mapped files); " if len(peaks) > 1 else ""
    what = f"GiB at {sizes[-1]:g} megapixels; {slope}{table}"
    more = {
        "megapixels": list(sizes),
        "peak_bytes": [peak.all_bytes for peak in peaks],
        "peak_without_mapped_files_bytes": [peak.without_files_bytes for peak in peaks],
        "time_s": [peak.time_s for peak in peaks],
        "slope_bytes_per_pixel": slopes[0],
        "slope_without_mapped_files_bytes_per_pixel": slopes[1],
    }
    return Accuracy(f"{verb}-memory", peaks[-1].all_bytes / 2**30, what, LIMIT_BYTES / 2**30, more)


def _watched(words: Sequence[str], done: float, note: str) -> Steps[Peak]:
    """Run a verb and look at its memory."""
    start, most, most_without = time.monotonic(), 0, 0
    command = [sys.executable, "-m", "app.__main__", *words]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        try:
            while process.poll() is None:
                everything, files = _memory(process.pid)
                most, most_without = max(most, everything), max(most_without, everything - files)
                yield Step(done, note)
                time.sleep(_INTERVAL_S)
        finally:
            process.kill()
        message = process.stderr.read() if process.stderr else ""
    if process.returncode:
        raise InputError(words[1], f"could not be measured: {message.strip()[-300:]}", "Make room, or measure less")
    return Peak(most, most_without, time.monotonic() - start)


def _memory(pid: int) -> tuple[int, int]:
    """Proportional bytes of a process and its children: of all pages, and of those of mapped files."""
    everything = files = 0
    try:
        family = [pid, *(child.pid for child in psutil.Process(pid).children(recursive=True))]
    except psutil.Error:
        return 0, 0
    for one in family:
        try:
            text = Path(f"/proc/{one}/smaps_rollup").read_text()
        except OSError:  # it has ended
            continue
        sizes = {line.split(":")[0]: 1024 * int(line.split()[1]) for line in text.splitlines()[1:]}
        everything += sizes["Pss"]
        files += sizes["Pss_File"]
    return everything, files
