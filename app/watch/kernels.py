"""Kernels that the import of a capture and its material need, made ready while its photographs are awaited.

On a new machine they would be compiled when the last photograph is there: 30 s of one core. They are called with noise
in arrays like those of photographs instead, by a thread of its own, and are then in the cache, from which loading them
takes 0.1 s. It begins when two photographs have been judged: what that needs is there by then, and no verdict waits for
the compiler, which serves one thread at a time. What every import needs comes first, the glossy texels that few need
last; nothing more is begun when the photographs have ended.

Where memory is limited, or two threads must not enter kernels at once, they are compiled when they are called.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from engine.capture.arriving import Capture
from engine.capture.calibration.rig import TERMS, Kind, Rig, Sample, fit, measure_held_out
from engine.capture.coded_pixels import Curve, Decoding, FallOff, Window, decode_rows
from engine.capture.import_plan import ImportSettings
from engine.core.budget import has_memory_limit
from engine.core.directions import surface_direction
from engine.core.kernels import serial_kernels, threads_are_shared
from engine.core.one_thread import one_thread
from engine.core.steps import Step, Steps, relay
from engine.shading.directional.codes_kernel import look_up_codes, write_codes
from engine.shading.directional.planes_kernel import round_values, shorten_values
from engine.shading.shading_map import sample_slices

#: Photographs that have been judged when kernels are made ready, and lamps and texels of the noise.
BEGUN_AT, LAMPS, TEXELS = 2, 9, 48


def load_kernels_beside(arriving: Steps[Capture], settings: ImportSettings) -> Steps[Capture]:
    """The steps of a capture that is being taken, while kernels for its import by `settings` are made ready."""
    ended = threading.Event()
    begun: list[threading.Thread] = []

    def begin(step: Step) -> Step:
        if not begun and isinstance(step.partial, Capture) and step.partial.count >= BEGUN_AT:
            begun.append(threading.Thread(target=load_kernels, args=(settings, ended.is_set), name="kernels"))
            begun[0].start()
        return step

    try:
        return (yield from relay(arriving, begin))
    finally:
        ended.set()


def load_kernels(settings: ImportSettings, is_ended: Callable[[], bool] = lambda: False) -> None:
    """Load or compile the kernels of an import by `settings` and of a material, until it `is_ended`."""
    if has_memory_limit() or not threads_are_shared():
        return
    pieces: list[Callable[[], object]] = [_decode_codes, _make_maps]
    if settings.calibrate != "none":
        pieces = [lambda: _fit_rig("matte"), *pieces, lambda: _fit_rig("glossy")]
    for piece in pieces:
        if not is_ended():
            with one_thread(), serial_kernels():
                piece()


def _fit_rig(kind: Kind) -> None:
    random = np.random.default_rng(0)
    values = random.uniform(0.5, 1.5, (TEXELS, LAMPS))
    usable, block = np.ones(values.shape, np.bool_), np.arange(TEXELS, dtype=np.int64)
    sample = Sample(values, usable, random.uniform(-0.5, 0.5, (TEXELS, 2)), np.ones(TEXELS), block)
    directions = surface_direction(np.full(LAMPS, 0.6), np.arange(LAMPS) * 0.7)
    rig = fit(sample, directions, TERMS, Rig.plain(LAMPS), kind).rig
    measure_held_out(sample, directions, rig, kind)


def _decode_codes() -> None:
    codes = np.zeros((2, TEXELS, 3), np.uint8)
    near = Decoding(Curve(np.zeros((1, 256), np.float32), 255), found=FallOff(4.0, 0.6, 0.7))
    decode_rows(codes, 0, near, Window(2, TEXELS), np.empty((2, TEXELS, 3), np.float32))


def _make_maps() -> None:
    """Kernels of shading maps, and of planes."""
    radiance = np.ones((LAMPS, 2, TEXELS, 3), np.float32)
    sample_slices(radiance, np.linspace(0.1, 1.0, LAMPS), 4)
    pivot, codes = np.zeros(3, np.float32), np.empty((3, TEXELS), np.float32)
    write_codes(radiance[0, :1], 0, np.zeros(TEXELS, np.float32), np.float32(1.0), pivot, codes)
    look_up_codes(np.zeros((1, 1, TEXELS, 3), np.uint8), 0, 1, np.zeros((3, 256), np.float32), codes)
    planes, inside = np.empty((3, 1, TEXELS), np.uint8), np.ones((1, TEXELS), np.bool_)
    low, kept = np.zeros((3, 1, 2), np.float32), np.empty(planes.shape, np.uint16)
    of_rows = low, low + np.float32(1.0)
    shorten_values(codes[:, None], inside, *of_rows, kept)
    round_values(kept, *of_rows, 0, pivot, pivot + np.float32(1.0), inside, planes, np.empty(3))
