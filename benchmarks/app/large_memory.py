"""Memory and disk that large captures take: import with alignment and the calibration of the rig, `shade` to a bundle,
maps of the surface, and exports of the bundle: web pages with tiles, textures of games, and MaterialX. Each is a
process of its own, which may be given a limit (`--memory`).

Photographs of each size are made on the disk, as 16-bit TIFFs: ten under an arc of lamps, or more under a dome, of
which `shade` makes planes. The memory of the process and of its decoders is sampled ten times a second, in
proportional shares (PSS), so that what they share counts once. Two figures are told: that of all pages, and that
without the pages of mapped files, which the system takes back when it needs them. The slope is that of a line through
the peaks of all sizes, in bytes for each pixel of a photograph. Disk is that of the photographs, of all results, and of
the files without a name that the process has mapped. A verb that fails has `ended` 0, and its
message is told with its failures, of which none is allowed; the others go on, and those that need what it should have
made fail as well.
"""

from __future__ import annotations

import math
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import psutil

from benchmarks.app.hard_limit import hold_memory
from benchmarks.app.program import PHOTOGRAPHS, large_photographs
from benchmarks.measure import Accuracy
from engine.core.errors import InputError, MissingCapability, UsageError
from engine.core.steps import Step, Steps
from engine.images.encode import write_tiff16
from engine.storage.atomic import discard, make_folder, write_bytes

#: Memory that ten photographs of 150 megapixels, or 64 of 24, may take.
LIMIT_BYTES = 6 * 2**30

#: Sizes without `--megapixels`: from them the slope is known within minutes.
MEGAPIXELS = (6.0, 24.0, 48.0)

#: By how much the memory of a process and its decoders may exceed the limit that it is given.
BEYOND = 1.1

_INTERVAL_S = 0.1


class Peak(NamedTuple):
    """The most memory of a command at any moment: all pages, those of no mapped file; its disk, seconds and failure."""

    all_bytes: int
    without_files_bytes: int
    disk_bytes: int
    time_s: float
    failure: str = ""


def large_memory(
    folder: Path,
    megapixels: Sequence[float] = MEGAPIXELS,
    photographs: int = PHOTOGRAPHS,
    limit_bytes: int | None = None,
    hard_limit: bool = False,
) -> Steps[list[Accuracy]]:
    """Peaks in GiB at every size and their slope, for each of `_list_verbs`, of so many `photographs`.

    `limit_bytes` is the memory that each verb is told to take at most; `peak_of_limit` of the further figures is then
    the part of it that was taken at the largest size, and `ended` is 1 where the verb did its work at all of them. With
    a `hard_limit` the system lets none take more than `BEYOND` of it (`benchmarks.app.hard_limit`).
    `folder` needs room for some 280 bytes for each pixel of ten photographs, 42 GB for 150 megapixels, and for 20 bytes
    for each pixel of each photograph of a dome. Raises UsageError for less than `PHOTOGRAPHS`, and for a hard limit
    without a limit.
    """
    if hard_limit and limit_bytes is None:
        raise UsageError("--hard-limit needs a --limit, of which it is a tenth more")
    if photographs < PHOTOGRAPHS:
        raise UsageError(f"--photographs {photographs}: large-memory takes {PHOTOGRAPHS} or more")
    if not Path("/proc/self/smaps_rollup").exists():
        raise MissingCapability("This system does not tell the memory of a process by kind", "Measure on Linux")
    verbs = _list_verbs(folder)
    peaks: dict[str, list[Peak]] = {name: [] for name in verbs}
    limit = () if limit_bytes is None else ("--memory", f"{limit_bytes / 1e6:.6f}MB")
    for index, size in enumerate(sizes := sorted(megapixels)):
        place = folder / "photographs"
        yield Step(index / len(sizes), f"making photographs of {size:g} megapixels")
        shape = round(1000 * math.sqrt(size / 1.5)), round(1500 * math.sqrt(size / 1.5))
        yield from large_photographs(place, *shape) if photographs == PHOTOGRAPHS else _dome(place, *shape, photographs)
        for name, words in verbs.items():
            note = f"{name} of {photographs} × {size:g} megapixels"
            step = Step((index + 0.5) / len(sizes), note)
            held_bytes = round(BEYOND * limit_bytes) if hard_limit and limit_bytes is not None else None
            peaks[name].append((yield from _watch([*words, *limit], folder, step, held_bytes)))
            discard(place)
        for made in folder.iterdir():
            discard(made)
    bound = LIMIT_BYTES if limit_bytes is None else BEYOND * limit_bytes
    found = [_find(name, photographs, sizes, each, bound, limit_bytes, hard_limit) for name, each in peaks.items()]
    return [*found, *(_count_failures(name, sizes, of_verb) for name, of_verb in peaks.items())]


def _list_verbs(folder: Path) -> dict[str, list[str]]:
    """Words of the command line by what is measured, each of which takes what the one before it has made."""
    place, stack, bundle, maps, exported = (
        str(folder / name) for name in ("photographs", "stack", "material.lightarc", "surface", "exported")
    )
    return {
        "import": ["import", place, "-o", stack],
        "shade": ["shade", stack, "-o", bundle],
        "maps": ["normals", stack, "-o", maps, "--no-errors"],
        "tiles": ["export", bundle, "--to", "web", "-o", f"{exported}-web"],
        "textures": ["export", bundle, "--to", "textures", "-o", f"{exported}-textures"],
        "materialx": ["export", bundle, "--to", "materialx", "-o", f"{exported}-materialx"],
    }


def _dome(folder: Path, height: int, width: int, count: int) -> Steps[None]:
    """A matte, smooth relief of many colours, a pixel or two apart, under `count` lamps, which its `.lp` places."""
    make_folder(folder)
    random = np.random.default_rng(0)
    albedo = np.kron(random.random((-(-height // 8), -(-width // 8)), np.float32), np.ones((8, 8), np.float32))
    albedo = albedo[:height, :width]
    coarse = random.random((-(-height // 64), -(-width // 64)), np.float32)
    relief = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    right, down = (12.0 * np.diff(relief, axis=axis, append=relief.take([-1], axis=axis)) for axis in (1, 0))
    lines = [f"{count}\n"]
    for index in range(count):
        yield Step(index / count, "making photographs")
        z = 0.2 + 0.75 * (index + 0.5) / count
        x, y = (math.sqrt(1.0 - z * z) * of(math.pi * (3.0 - math.sqrt(5.0)) * index) for of in (math.cos, math.sin))
        lit = (0.4 + 0.6 * albedo) * np.maximum(z - x * right + y * down, 0.0) / np.sqrt(1.0 + right**2 + down**2)
        codes = np.roll(45000.0 * lit, (index % 3, index % 2), axis=(0, 1)).astype(np.uint16)
        write_tiff16(folder / f"dome_{index:03}.tif", np.repeat(codes[..., None], 3, axis=2), transfer="linear")
        lines.append(f"dome_{index:03}.tif {x:.6f} {y:.6f} {z:.6f}\n")
    write_bytes(folder / "lamps.lp", "".join(lines).encode())


def _find(
    verb: str,
    photographs: int,
    sizes: Sequence[float],
    peaks: Sequence[Peak],
    bound_bytes: float,
    limit_bytes: int | None,
    hard_limit: bool = False,
) -> Accuracy:
    pixels = 1e6 * np.asarray(sizes)
    slopes = [
        float(np.polyfit(pixels, [getattr(peak, kind) for peak in peaks], 1)[0]) if len(peaks) > 1 else None
        for kind in ("all_bytes", "without_files_bytes")
    ]
    table = "; ".join(
        f"{size:g} megapixels: {peak.all_bytes / 2**30:.2f} GiB, {peak.without_files_bytes / 2**30:.2f} without mapped "
        f"files, {peak.disk_bytes / 1e9:.1f} GB of disk, {peak.time_s:.0f} s"
        for size, peak in zip(sizes, peaks, strict=True)
    )
    slope = f"{slopes[0]:.1f} bytes a pixel ({slopes[1]:.1f} without mapped files); " if len(peaks) > 1 else ""
    held = ", where the system lets it take no more than its bound" if hard_limit else ""
    what = f"GiB at {photographs} × {sizes[-1]:g} megapixels{held}; {slope}{table}"
    more = {
        "photographs": photographs,
        "megapixels": list(sizes),
        "peak_bytes": [peak.all_bytes for peak in peaks],
        "peak_without_mapped_files_bytes": [peak.without_files_bytes for peak in peaks],
        "disk_bytes": [peak.disk_bytes for peak in peaks],
        "time_s": [peak.time_s for peak in peaks],
        "slope_bytes_per_pixel": slopes[0],
        "slope_without_mapped_files_bytes_per_pixel": slopes[1],
        "ended": int(not any(peak.failure for peak in peaks)),
        "peak_of_limit": None if limit_bytes is None else peaks[-1].all_bytes / limit_bytes,
    }
    return Accuracy(f"{verb}-memory", peaks[-1].all_bytes / 2**30, what, bound_bytes / 2**30, more)


def _count_failures(verb: str, sizes: Sequence[float], peaks: Sequence[Peak]) -> Accuracy:
    failures = [f"{size:g} megapixels: {peak.failure}" for size, peak in zip(sizes, peaks, strict=True) if peak.failure]
    what = "; ".join(failures) or f"sizes at which {verb} failed"
    return Accuracy(f"{verb}-failures", float(len(failures)), what, 0.0)


def _watch(words: Sequence[str], folder: Path, step: Step, held_bytes: int | None) -> Steps[Peak]:
    """Run a verb, in `held_bytes` of the system, and look at its memory, and at the disk that it and `folder` take."""
    start, most, max_without, max_disk = time.monotonic(), 0, 0, 0

    def look(process: int) -> None:
        nonlocal most, max_without, max_disk
        everything, files = memory_of(process)
        most, max_without = max(most, everything), max(max_without, everything - files)
        max_disk = max(max_disk, _on_disk(folder) + _nameless(process))

    command, failure = [sys.executable, "-m", "app.__main__", *words], ""
    with ExitStack() as held:
        within, count_ended = ([], int) if held_bytes is None else held.enter_context(hold_memory(held_bytes))
        try:
            yield from run_watched([*within, *command], words[1], look, step)
        except InputError as error:
            failure = error.problem
        if ended := count_ended():
            failure = f"the system ended {ended} of its processes for want of memory"
    return Peak(most, max_without, max_disk, time.monotonic() - start, failure)


def run_watched(
    command: Sequence[str],
    subject: str,
    look: Callable[[int], None],
    step: Step,
    environment: Mapping[str, str] | None = None,
) -> Steps[None]:
    """Run a command and `look` at its process every `_INTERVAL_S`; InputError about `subject` where it fails."""
    streams: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, env=environment, **streams) as process:
        try:
            while process.poll() is None:
                look(process.pid)
                yield step
                time.sleep(_INTERVAL_S)
        finally:
            process.kill()
        message = process.stderr.read() if process.stderr else ""
    if process.returncode:
        raise InputError(subject, f"could not be measured: {message.strip()[-300:]}", "Make room, or measure less")


def memory_of(pid: int) -> tuple[int, int]:
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


def _on_disk(folder: Path) -> int:
    """Bytes of the blocks of all files below `folder`."""
    total = 0
    for path in folder.rglob("*"):
        try:
            total += 512 * path.stat().st_blocks
        except OSError:  # it has just been renamed or deleted
            continue
    return total


def _nameless(pid: int) -> int:
    """Bytes of the files in folders of temporary files that a process has mapped and that have no name any more."""
    try:
        lines = Path(f"/proc/{pid}/maps").read_text().splitlines()
    except OSError:  # it has ended
        return 0
    sizes: dict[str, int] = {}
    for line in lines:
        if line.endswith("(deleted)") and not any(place in line for place in ("/dev/", "/memfd:", "/SYSV")):
            first, last = (int(end, 16) for end in line.split()[0].split("-"))
            inode = line.split()[4]
            sizes[inode] = max(sizes.get(inode, 0), last - first)
    return sum(sizes.values())
