"""Importing photographs of 24 megapixels, against what decodes the same files alone, and how near alignment comes.

Ten photographs are made in a working folder: Bayer DNGs as the virtual light arc writes them, or 16-bit TIFFs.
LibRaw decodes the DNGs with its own bilinear interpolation and linear output, two files at once.
Cost: some minutes, 4 GB of disk.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import psutil
from numpy.typing import NDArray

from benchmarks.measure import Accuracy, Measure
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.registration.align import align
from engine.capture.registration.texture import reduce, reduction
from engine.core.steps import Step, Steps, drain
from engine.images.encode import write_tiff16
from engine.simulate.camera import Levels, dng_bytes
from engine.storage.atomic import make_folder, write_bytes
from engine.storage.untrusted import CHILDREN

COUNT, HEIGHT, WIDTH = 10, 4000, 6000
MEMORY_LIMIT_BYTES = 2 * 2**30
ALIGNMENT_LIMIT_S = 1.0
SHIFT_LIMIT_PX = 0.05
_LEVELS = Levels(black=((512, 512), (512, 512)), white=16383)
_STILL = ImportSettings(motion="none")

#: How often memory is looked at, which takes milliseconds and would lengthen the import itself.
_INTERVAL_S = 0.1

_EXPOSURES_S = (1 / 240, 1 / 60)


def import_raw(folder: Path) -> Measure:
    """Ten RAW files without alignment, against LibRaw alone on the same files; all lie in the working `folder`."""
    files = _photographs(folder / "raw", ".dng", _write_dng)
    limit_s = _time(lambda: _libraw(files))
    time_s, memory = _import(files[0].parent, _STILL)
    return Measure("import-raw-24mp", time_s, limit_s, "LibRaw alone decoding the ten files, two at once", memory)


def import_aligned(folder: Path) -> Measure:
    """Ten RAW files a pixel or two apart, aligned, against importing them as they lie."""
    files = _photographs(folder / "raw", ".dng", _write_dng, wander=True)
    limit_s, _ = _import(files[0].parent, _STILL)
    time_s, memory = _import(files[0].parent, ImportSettings(motion="euclidean"))
    memory["alignment_s_per_photograph"] = (time_s - limit_s) / len(files)
    return Measure("import-aligned-24mp", time_s, limit_s, "importing the same files without alignment", memory)


def import_bracketed(folder: Path) -> Measure:
    """Five lights with two exposures each, merged, against LibRaw alone on the same files."""
    files = _brackets(folder / "raw")
    limit_s = _time(lambda: _libraw(files))
    time_s, memory = _import(files[0].parent, _STILL)
    return Measure("import-bracketed-24mp", time_s, limit_s, "LibRaw alone decoding the files, two at once", memory)


def import_tiff(folder: Path) -> Measure:
    """Ten 16-bit TIFFs without alignment, against reading and writing as many bytes."""
    files = _photographs(folder / "tiff", ".tif", _write_tiff)
    limit_s = _time(lambda: _copy(files, folder / "copy"))
    time_s, memory = _import(files[0].parent, _STILL)
    limit = "reading the files and writing as many bytes as the stack has"
    return Measure("import-tiff-24mp", time_s, limit_s, limit, memory)


def align_large() -> Measure:
    """The alignment of a photograph of 24 megapixels, coarse to fine, as part of a stack of ten."""
    greys = []
    for index in range(COUNT):
        image = _image(index, index % 3, -(index % 2))
        greys.append(reduce(image, reduction(HEIGHT, WIDTH)).copy())
    steps = align(greys, [str(index) for index in range(COUNT)], "euclidean", reduction(HEIGHT, WIDTH))
    time_s = _time(lambda: drain(steps)) / COUNT
    return Measure("align-24mp", time_s, ALIGNMENT_LIMIT_S, "what is promised for a photograph")


def alignment(folder: Path) -> Steps[list[Accuracy]]:
    """The worst error of recovered sub-pixel shifts at a signal-to-noise ratio of 30 dB; `folder` is not used."""
    rng = np.random.default_rng(1)
    surface = cv2.GaussianBlur(rng.normal(size=(640, 640)).astype(np.float32), (0, 0), 1.5)
    surface = 0.5 + 0.15 * surface / float(surface.std())
    shift = np.array([0.37, -0.81])
    move = np.array([[1, 0, shift[0]], [0, 1, shift[1]]])
    moved = cv2.warpAffine(surface, move, (640, 640), flags=cv2.INTER_LANCZOS4)
    noise = 10 ** (-30 / 20) * float(surface.std())
    images = [
        image[20:-20, 20:-20] + np.float32(noise) * rng.standard_normal((600, 600), np.float32)
        for image in (surface, moved)
    ]
    found = yield from align(images, ["still", "moved"], "translation")
    error_px = float(np.abs(found.matrix[1][:2, 2] - found.matrix[0][:2, 2] - shift).max())
    return [Accuracy("alignment-px", error_px, "a shift of (0.37, -0.81) px at 30 dB, pixels", SHIFT_LIMIT_PX)]


def _time(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _import(folder: Path, settings: ImportSettings) -> tuple[float, dict[str, float]]:
    """Seconds, and the largest sum of the memory of this process (beyond what it had) and of its decoders."""
    own = psutil.Process()
    before, largest, looked_s = own.memory_info().rss, 0, -math.inf

    def watch(_: Step) -> None:
        nonlocal largest, looked_s
        if time.perf_counter() < looked_s + _INTERVAL_S:
            return
        looked_s = time.perf_counter()
        largest = max(largest, own.memory_info().rss + sum(_resident(child) for child in own.children()))

    sources = find([folder])
    first = find(list(sources.photographs[:2]), [10.0, 20.0])
    drain(import_stack(first, settings, folder.parent / "first"))  # compiles what a new installation has to
    steps = import_stack(sources, settings, folder.parent / "stack")
    time_s = _time(lambda: drain(steps, watch))
    return time_s, {
        "peak_memory_bytes": largest,
        "memory_before_bytes": before,
        "memory_limit_bytes": MEMORY_LIMIT_BYTES,
    }


def _resident(process: psutil.Process) -> int:
    try:
        resident: int = process.memory_info().rss
    except psutil.Error:
        return 0
    return resident


def _libraw(files: list[Path]) -> None:
    import rawpy

    def decode(path: Path) -> None:
        with rawpy.imread(str(path)) as raw:
            raw.postprocess(
                demosaic_algorithm=rawpy.DemosaicAlgorithm.LINEAR,
                output_bps=16,
                gamma=(1, 1),
                no_auto_bright=True,
                use_camera_wb=True,
            )

    with ThreadPoolExecutor(CHILDREN) as pool:
        list(pool.map(decode, files))


def _copy(files: list[Path], target: Path) -> None:
    """As many bytes as the stack has: the codes of three 16-bit channels."""
    for path in files:
        content = path.read_bytes()
        write_bytes(target, (content * 3)[: HEIGHT * WIDTH * 6])


def _photographs(
    folder: Path, suffix: str, write: Callable[[Path, NDArray[np.float32], int], None], wander: bool = False
) -> list[Path]:
    make_folder(folder)
    files = [folder / f"cloth_{9 * index + 5:02}deg{suffix}" for index in range(COUNT)]
    for index, path in enumerate(files):
        write(path, _image(index, index % 3 * wander, -(index % 2) * wander), index)
    return files


def _brackets(folder: Path) -> list[Path]:
    """As many photographs, of each light one to an exposure, and the `capture.toml` that says so."""
    make_folder(folder)
    files, notes = [], []
    for index in range(COUNT):
        light, exposure_s = index // len(_EXPOSURES_S), _EXPOSURES_S[index % len(_EXPOSURES_S)]
        files.append(folder / f"cloth_{index:02}.dng")
        _write_dng(files[-1], np.float32(exposure_s * 60) * _image(light, 0, 0), index)
        notes.append(f"[[photographs]]\nfile = '{files[-1].name}'\nelevation_deg = {9 * light + 5}")
        notes.append(f"exposure_s = {exposure_s}\n")
    write_bytes(folder / "capture.toml", "\n".join(notes).encode())
    return files


def _image(index: int, right: int, down: int) -> NDArray[np.float32]:
    """(HEIGHT, WIDTH) a textured surface in [0, 1], moved by whole pixels, lit from 5 + 9 `index` degrees."""
    fine = np.random.default_rng(0).random((HEIGHT // 8 + 2, WIDTH // 8 + 2), np.float32)
    surface = cv2.resize(fine, None, fx=8, fy=8, interpolation=cv2.INTER_LINEAR)
    light = math.sin(math.radians(9 * index + 5))
    return (0.1 + 0.6 * light * surface)[8 - down : 8 - down + HEIGHT, 8 - right : 8 - right + WIDTH]


def _write_dng(path: Path, image: NDArray[np.float32], index: int) -> None:
    noise = np.random.default_rng(index).standard_normal(image.shape, np.float32)
    samples = np.clip(512 + (image + np.float32(0.004) * noise) * (16383 - 512), 0, 16383).astype(np.uint16)
    write_bytes(path, dng_bytes(samples, _LEVELS, exposure_s=1 / 60))


def _write_tiff(path: Path, image: NDArray[np.float32], index: int) -> None:
    codes = (image * 60000).astype(np.uint16) + np.uint16(index)
    write_tiff16(path, np.repeat(codes[..., None], 3, axis=2), transfer="srgb")
