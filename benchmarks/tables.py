"""A million values of measured tables of the published sizes, made up here, and reading a MERL file."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.brdf.readers.merl import SHAPE, read_merl, write_merl
from engine.brdf.readers.utia import PHI, THETA
from engine.brdf.resample import random_pairs
from engine.brdf.table import DirectionTable, HalfDifferenceTable

PAIRS = 1_000_000


def merl_values() -> Measure:
    """Interpolated values of a MERL table against a copy of the bytes that are read and written."""
    return _values("merl-values", _half_table())


def utia_values() -> Measure:
    """Interpolated values of a UTIA table against the same."""
    shape = (len(THETA), len(PHI), len(THETA), len(PHI))
    values = np.random.default_rng(0).random((*shape, 3))
    return _values("utia-values", DirectionTable(THETA, PHI, THETA, PHI, values, np.zeros(shape, bool)))


def merl_read() -> Measure:
    """Reading a MERL file of which a fifth is missing, against reading its bytes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made-up.binary"
        write_merl(path, _half_table())
        time_s = best_of(lambda: read_merl(path), repeats=3)
        limit_s = best_of(path.read_bytes, repeats=3)
    return Measure("merl-read", time_s, limit_s, "reading the file's bytes", {"bins": int(np.prod(SHAPE))})


def _half_table() -> HalfDifferenceTable:
    random = np.random.default_rng(0)
    return HalfDifferenceTable(random.random((*SHAPE, 3)), random.random(SHAPE) < 0.2)


def _values(name: str, table: HalfDifferenceTable | DirectionTable) -> Measure:
    wi, wo = random_pairs(PAIRS)
    values = table.f(wi, wo)
    time_s = best_of(lambda: table.f(wi, wo), repeats=5)
    limit_s = best_of(lambda: (wi.copy(), wo.copy(), values.copy()), repeats=5)
    return Measure(name, time_s, limit_s, "copying a million pairs and values", {"pairs": PAIRS})
