"""Bakes of a bumpy sphere in every mode, cold of visibility, beside the seconds of an earlier version.

Seconds of two versions are of two runs, so the ratio says something only of an idle machine of that kind.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.measure import Measure
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import grid_mesh
from engine.transport.method import Subject, method_of

BRDF = "ggx:alpha=0.3"

#: Rows and columns of the sphere, 41,000 vertices and 300, which warm up.
LARGE, SMALL = (144, 285), (12, 25)

#: Seconds of that version on two idle cores, and the share of them that is promised.
BEFORE_S = {"sh": (28.0, 1.0), "wavelet": (70.0, 2.0 / 3.0), "gaussian": (263.0, 0.5)}


def bumpy_sphere(rows: int, columns: int) -> Mesh:
    """A sphere of radius 1 with bumps a tenth as high, open at its poles, of `rows` and `columns` of vertices."""
    polar = np.linspace(0.02, np.pi - 0.02, rows)[:, None]
    around = np.linspace(0.0, 2.0 * np.pi, columns)[None, :]
    radius = 1.0 + 0.1 * np.sin(7.0 * polar) * np.sin(8.0 * around) * np.sin(polar)
    across = radius * np.sin(polar)
    positions = np.stack([across * np.cos(around), radius * np.cos(polar), -across * np.sin(around)], axis=-1)
    down, along = np.gradient(positions, axis=(0, 1))
    normals = np.cross(along, down)
    normals *= np.sign((normals * positions).sum(axis=-1, keepdims=True))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    place = np.broadcast_arrays(around / (2.0 * np.pi), polar / np.pi)
    return grid_mesh("bumpy-sphere", positions, normals, np.stack(place, axis=-1))


def bake_41k_sh() -> Measure:
    """Spherical harmonics with their default settings."""
    return _bake("sh")


def bake_41k_wavelet() -> Measure:
    """Wavelets with their default settings."""
    return _bake("wavelet")


def bake_41k_gaussian() -> Measure:
    """Gaussians with their default settings."""
    return _bake("gaussian")


def _bake(mode: str) -> Measure:
    before_s, share = BEFORE_S[mode]
    _bake_s(mode, bumpy_sphere(*SMALL))
    time_s, cpu_s, size_bytes = _bake_s(mode, bumpy_sphere(*LARGE))
    more = {"vertices": LARGE[0] * LARGE[1], "cpu_s": cpu_s, "size_bytes": size_bytes, "target_ratio": share}
    return Measure(f"bake-41k-{mode}", time_s, before_s, "seconds of an earlier version on two idle cores", more)


def _bake_s(mode: str, mesh: Mesh) -> tuple[float, float, int]:
    """Wall clock and CPU seconds from the laid out bake to its open file, and the bytes of it."""
    method = method_of(mode)
    with tempfile.TemporaryDirectory() as folder:
        started, cpu = time.perf_counter(), time.process_time()
        subject = Subject(mesh, brdf_from_text(BRDF), kept=Path(folder) / "visibility")
        work = drain(method.baking.prepare(subject, method.settings()))
        baked = drain(method.baking.bake(Path(folder) / "bench.transport", work))
        return time.perf_counter() - started, time.process_time() - cpu, baked.file.size_bytes
