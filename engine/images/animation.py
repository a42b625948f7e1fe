"""Frames to a film: MP4 with VP9, animated WebP, or a folder of PNG, by what the name ends with.

VP9 is the codec that the libraries of the program bring along on every system without a licence, and that browsers,
VLC and editors play. WebP keeps transparency and loops in every browser; a folder of PNG is without loss.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.core.errors import MissingCapability, OutputError, UsageError
from engine.images.encode import encode_png
from engine.storage.atomic import atomic_folder, atomic_path, write_bytes, write_json

#: Largest side of a frame: that of WebP.
MAX_PX = 16383

#: The file by which a folder of frames is known.
MARKER = "turntable.json"

Frame = NDArray[np.uint8]
Frames = Generator[int, Frame, None]

#: Effort and quality of WebP: 0 … 6 and 0 … 100, as libwebp has them.
WEBP_EFFORT, WEBP_QUALITY = 4, 88


def kind_of(path: str | Path) -> str:
    """'mp4', 'webp' or 'folder' by the ending of `path`; UsageError for any other ending."""
    suffix = Path(path).suffix.lower()
    if suffix not in ("", ".mp4", ".webp"):
        raise UsageError(f"a film is an .mp4, a .webp or a folder of PNG, not a {suffix} file")
    return suffix[1:] or "folder"


@contextmanager
def film(path: str | Path, size: tuple[int, int], fps: float, *, software: str = "") -> Iterator[Any]:
    """A function that takes the frames (H, W, 3 or 4) uint8 one after the other; `path` is complete, or absent.

    `size` is (width, height) of all of them. MP4 has neither transparency, which raises ValueError, nor odd sizes: the
    last row or column is then left out.
    """
    if max(size) > MAX_PX or min(size) < 2:
        raise UsageError(f"a film of {size[0]} × {size[1]} pixels is not possible (2 … {MAX_PX})")
    if kind_of(path) == "folder":
        with atomic_folder(path, MARKER) as folder:
            taken = 0

            def keep(frame: Frame) -> None:
                nonlocal taken
                write_bytes(folder / f"frame-{taken:05}.png", encode_png(frame, software=software))
                taken += 1

            yield keep
            write_json(folder / MARKER, {"frames": taken, "frames_per_second": fps, "size": list(size)})
        return
    with atomic_path(path) as partial:
        steps = _mp4(partial, size, fps) if kind_of(path) == "mp4" else _webp(partial, fps)
        next(steps)
        try:
            yield steps.send
        finally:
            steps.close()
        if not partial.exists() or not partial.stat().st_size:
            raise OutputError(path, "no frame was written", "Choose another name or kind of film")


def _mp4(path: Path, size: tuple[int, int], fps: float) -> Frames:
    width, height = size[0] // 2 * 2, size[1] // 2 * 2
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*"vp09"), fps, (width, height))
    if not writer.isOpened():
        raise MissingCapability("VP9 cannot be encoded here", "Choose a .webp file or a folder of PNG")
    try:
        taken = 0
        while True:
            frame = yield taken
            if frame.shape[2] != 3:
                raise ValueError("MP4 has no transparency")
            writer.write(np.ascontiguousarray(frame[:height, :width, ::-1]))
            taken += 1
    finally:
        writer.release()


def _webp(path: Path, fps: float) -> Frames:
    """Frames are kept until the end, where Pillow writes them: 4 bytes for each pixel of each."""
    from PIL import Image

    kept: list[Any] = []
    try:
        while True:
            frame = yield len(kept)
            kept.append(Image.fromarray(frame))
    finally:
        if kept:
            options = {"quality": WEBP_QUALITY, "method": WEBP_EFFORT, "duration": round(1000.0 / fps), "loop": 0}
            kept[0].save(path, "WEBP", save_all=True, append_images=kept[1:], **options)
