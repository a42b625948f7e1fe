"""Hard cases of files of strangers: numbers at the ends of their range, and text in two bytes a letter."""

from __future__ import annotations

import math

import numpy as np

from engine.core.errors import InputError
from engine.geometry.mesh_weld import without_gaps
from engine.geometry.unwrap import atlas
from engine.images.decode import LARGEST_RADIANCE, refuse_larger
from engine.light.environment_file import repair
from engine.selftest.case import Found, Question
from engine.selftest.light import sphere
from engine.storage.text import utf8


def _bright_neighbours() -> Found:
    """A texel that is not a number among texels near the largest one of 32 bits."""
    radiance = np.full((4, 8, 3), 3e38, np.float32)
    bad = np.zeros(radiance.shape, bool)
    bad[1:3, 2:4] = True
    repaired, left = repair(radiance, bad)
    return float(np.abs(repaired.astype(np.float64) / 3e38 - 1.0).max()) + left, 2.0**-23


def _thin_charts() -> Found:
    """A strip 1e7 times as long as wide; that xatlas refuses it is an answer too."""
    x = np.linspace(0.0, 1e7, 9)
    points = np.array([(along, across, 0.0) for along in x for across in (0.0, 1.0)])
    faces = np.array([(k, k + 1, k + 2) if k % 2 == 0 else (k + 1, k, k + 2) for k in range(16)])
    try:
        uv = atlas(points, faces)
    except InputError:
        return 0.0, 0.0
    return float((~np.isfinite(uv)).sum()), 0.0


def _gaps_are_closed() -> Found:
    """A closed model whose triangles have corners of their own, off by 1e-7 of its extent."""
    model = sphere()
    corners = model.positions[model.faces].reshape(-1, 3)
    moved = corners + np.random.default_rng(0).uniform(-1e-7, 1e-7, corners.shape)
    closed, _ = without_gaps(moved, np.arange(len(moved)).reshape(-1, 3))
    return float(len(np.unique(closed, axis=0)) - len(model.positions)), 0.0


def _two_bytes_a_letter() -> Found:
    text = "v 0.5 1e-3 -2\nf 1 2 3\n" * 20
    content = [utf8(text.encode(code)) for code in ("utf-8", "utf-16", "utf-16-le", "utf-16-be")]
    return float(sum(each != text.encode() for each in content)), 0.0


def _numbers_stay() -> Found:
    """Binary content, in which half of the bytes may be 0 as well, is not text."""
    content = [np.arange(500, dtype=kind).tobytes() for kind in (np.float32, np.float64, np.uint32)]
    return float(sum(utf8(each) != each for each in content)), 0.0


def _too_bright() -> Found:
    """Radiances of photographs that cannot be computed with are refused before a stack is written, and no others."""
    wrong = 0
    for radiance, is_refused in [(LARGEST_RADIANCE, False), *((each, True) for each in (1e16, 1e30, -1e30, math.nan))]:
        try:
            refuse_larger("photograph.exr", np.full((2, 2, 3), radiance, np.float32))
        except InputError:
            wrong += not is_refused
        else:
            wrong += is_refused
    return float(wrong), 0.0


QUESTIONS = (
    Question("N1", "relative error of damaged texels among texels of 3e38", _bright_neighbours),
    Question("N2", "texture coordinates of a strip of 1e7 to 1 that are not numbers", _thin_charts),
    Question("N3", "points too many in a model whose corners differ by 1e-7", _gaps_are_closed),
    Question("N4", "texts in UTF-16 that are not read", _two_bytes_a_letter),
    Question("N5", "tables of numbers that are taken for text in UTF-16", _numbers_stay),
    Question("N6", "radiances of photographs that are refused or taken wrongly, of 1e15 to 1e30", _too_bright),
)
