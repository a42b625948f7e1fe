"""Images that were made for the screen: kept, so that going back to one costs nothing."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from app.jobs.jobs import Job, Jobs, Work
from app.widgets.image_view import Image, ImageView, photograph
from engine.capture.stack import ImageStack
from engine.core.colour import to_display8
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.images.decode import TransferChoice

#: The images used last are kept up to this size together, and always so many.
KEPT_BYTES, KEPT_ALWAYS = 512 * 2**20, 3

#: Dark photographs are brightened for marking until this share of the white level is reached by their bright parts.
BRIGHT, MAX_EV = 0.7, 7.0

#: Largest side of a thumbnail, in pixels.
THUMBNAIL_SIDE = 128

Key = tuple[Hashable, ...]


class Shelf:
    """Brings images to views: at once where they are kept, else by a job."""

    def __init__(self, jobs: Jobs) -> None:
        self.jobs = jobs
        self.kept: dict[Key, Image] = {}
        self._making: dict[ImageView, Job] = {}

    def show(self, view: ImageView, key: Key, title: str, make: Work, then: Callable[[], None] | None = None) -> None:
        """Show the image `key` in `view`, made by `make` where it is not kept; then call `then`."""
        self.drop(view)
        if key in self.kept:
            self.kept[key] = self.kept.pop(key)
            self._shown(view, self.kept[key], then)
            return
        job = self.jobs.submit(title, make, lane="screen")
        self._making[view] = job
        job.succeeded.connect(lambda image: self._made(view, job, key, image, then))

    def drop(self, view: ImageView) -> None:
        """Drop the image that is being made for `view`."""
        job = self._making.pop(view, None)
        if job is not None:
            self.jobs.cancel(job)

    def forget(self, kind: str) -> None:
        """Forget the images whose key begins with `kind`."""
        self.kept = {key: image for key, image in self.kept.items() if key[0] != kind}

    def _made(self, view: ImageView, job: Job, key: Key, image: Image, then: Callable[[], None] | None) -> None:
        self.kept[key] = image
        while len(self.kept) > KEPT_ALWAYS and sum(one.bytes for one in self.kept.values()) > KEPT_BYTES:
            self.kept.pop(next(iter(self.kept)))
        if self._making.get(view) is job:
            del self._making[view]
            self._shown(view, image, then)

    def _shown(self, view: ImageView, image: Image, then: Callable[[], None] | None) -> None:
        view.show_image(image)
        if then is not None:
            then()


def as_taken(path: Path, transfer: TransferChoice = "auto", *, brighten: bool = False) -> Steps[Image]:
    """The photograph in a file before any of its calibration, brightened where it is dark if `brighten`."""
    yield Step(0.0, "reading the photograph")
    from engine.capture.photograph.decode import read_photograph

    radiance = read_photograph(path, transfer=transfer).radiance
    exposure_ev = 0.0
    if brighten:
        bright = float(np.percentile(radiance[::4, ::4], 98.0))
        exposure_ev = min(MAX_EV, max(0.0, float(np.log2(BRIGHT / max(bright, 1e-6)))))
    return (yield from photograph(radiance, exposure_ev=exposure_ev))


def thumbnails(stack: ImageStack) -> Steps[None]:
    """A small image of each photograph of a stack that was not just imported: the steps bring name and uint8 sRGB.

    No more than the rows that are shown are read from the disk.
    """
    height, width = stack.radiance.shape[1:3]
    step = max(1, max(height, width) // THUMBNAIL_SIDE)
    for place, name in enumerate(stack.sources):
        rows = [stack.radiance[place, row][::step] for row in range(0, height, step)]
        yield Step((place + 1) / len(stack.sources), name, (name, to_display8(np.stack(rows))))
