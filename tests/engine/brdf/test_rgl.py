"""RGL measurements against a second evaluation, Mitsuba, and materials of which everything is known.

`Reference` computes values from the paper's definition in float64 and without the program's tables: it integrates the
bilinear density itself. Mitsuba 3 computes in float32, and errs by up to percents where one of the two directions lies
low. There 1 − x of the place x in the grid is a difference of nearly equal numbers, and as colours vanish at x = 1, the
horizon, that difference is the value; or the visible normals end between two rows of their table, and the place depends
on the half vector's azimuth by leaps. Both are shown pair by pair: its error is no larger than what moving those places
by some roundings of float32 does to the exact value.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.rgl import read_rgl
from engine.brdf.tensor_file import read_tensor_file
from tests.engine.brdf.tensor_files import tensor_bytes

FILES = ("cc_ibiza_sunset_rgb", "colodur_napoli_4f_rgb", "paper_white_rgb", "satin_rosaline_rgb")
WAVELENGTHS = np.array([400.0, 460.0, 500.0, 560.0, 600.0, 680.0])
CIRCLES = {"whole": 2.0 * np.pi, "half turn": np.pi, "two mirrors": 0.5 * np.pi}

Pairs = tuple[NDArray[np.float64], NDArray[np.float64]]


def pairs(count: int, seed: int = 0) -> Pairs:
    """Pairs of directions equally spread over the hemisphere, of float32 numbers."""
    vectors = np.random.default_rng(seed).normal(size=(2, count, 3))
    vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
    vectors[..., 2] = np.abs(vectors[..., 2])
    single = vectors.astype(np.float32).astype(np.float64)
    return single[0], single[1]


def saved(tmp_path: Path, fields: dict[str, NDArray[Any]]) -> Path:
    path = tmp_path / "made.bsdf"
    path.write_bytes(tensor_bytes(fields))
    return path


def relative_error(values: NDArray[np.float64], truth: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,), the worst channel; equal where both are 0."""
    scale = np.where(truth == 0.0, 1.0, np.abs(truth))
    return np.asarray((np.abs(values - truth) / scale).max(axis=-1))


class Reference:
    """The format's definition for one pair at a time, by integrating the bilinear density where it is asked."""

    def __init__(self, path: Path) -> None:
        self.fields = {name: np.asarray(field) for name, field in read_tensor_file(path, 1 << 26).items()}
        self.phi_i, self.theta_i = (self.fields[name].astype(np.float64) for name in ("phi_i", "theta_i"))
        values = self.fields["spectra" if "spectra" in self.fields else "rgb"]
        self.values = np.moveaxis(values, 2, -1).astype(np.float64)
        self.vndf = self.fields["vndf"].astype(np.float64)
        self.vndf /= self._integral(self.vndf)[..., None, None]

    @staticmethod
    def _integral(table: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(
            np.trapezoid(np.trapezoid(table, axis=-1), axis=-1) / np.prod(np.subtract(table.shape[-2:], 1))
        )

    def _between(self, table: NDArray[np.float64], phi: float, theta: float) -> NDArray[np.float64]:
        """The slice of (P, T, …) at an incident direction, linear in both angles."""
        for axis, angle in ((self.phi_i, phi), (self.theta_i, theta)):
            place = np.interp(angle, axis, np.arange(len(axis)))
            low = min(int(place), max(len(axis) - 2, 0))
            high = min(low + 1, len(axis) - 1)
            table = table[low] + (place - low) * (table[high] - table[low])
        return table

    def place(self, wi: NDArray[np.float64], wo: NDArray[np.float64], *, azimuth: float = 0.0) -> tuple[Any, ...]:
        """What the pair's value is made of: incident angles, half vector's place, and its place in the grid."""
        wi, wo = wi.copy(), wo.copy()
        if len(self.phi_i) > 2:
            quarters = round((self.phi_i[-1] - self.phi_i[0]) / (0.5 * np.pi))
            if quarters == 2 and wi[1] > 0:
                wi[:2], wo[:2] = -wi[:2], -wo[:2]
            for axis in (0, 1):
                if quarters == 1 and wi[axis] > 0:
                    wi[axis], wo[axis] = -wi[axis], -wo[axis]
        half = (wi + wo) / np.linalg.norm(wi + wo)
        theta, phi = np.arctan2(np.hypot(*wi[:2]), wi[2]), np.arctan2(wi[1], wi[0])
        turn = np.arctan2(half[1], half[0]) - (phi if len(self.phi_i) <= 2 else 0.0)
        x = np.sqrt(np.arctan2(np.hypot(*half[:2]), half[2]) * 2 / np.pi)
        y = (turn / (2 * np.pi) + 0.5 + azimuth) % 1.0
        density = self._between(self.vndf, phi, theta)
        line = bilinear_row(density, y)
        column = integral(line, x) / integral(line, 1.0)
        row = integral(np.trapezoid(density, axis=1) / (density.shape[1] - 1), y)
        return phi, theta, x, y, column, row

    def spectrum(
        self, wi: NDArray[np.float64], wo: NDArray[np.float64], *, azimuth: float = 0.0, grid: float = 0.0
    ) -> NDArray[np.float64]:
        """The file's bands of f (B,); with the half vector's azimuth and the place in the grid moved by so much."""
        phi, theta, x, y, column, row = self.place(wi, wo, azimuth=azimuth)
        value = bilinear(self._between(self.values, phi, theta), column + grid, row) / wo[2]
        if self.fields["jacobian"][0]:
            u, v = np.sqrt(theta * 2 / np.pi), (phi + np.pi) / (2 * np.pi)
            value = value * bilinear(self.fields["ndf"], x, y) / (4 * bilinear(self.fields["sigma"], u, v))
        return np.asarray(value)


def bilinear_row(table: NDArray[np.float64], y: float) -> NDArray[np.float64]:
    place = min(max(y, 0.0), 1.0) * (len(table) - 1)
    low = min(int(place), len(table) - 2)
    return np.asarray(table[low] + (place - low) * (table[low + 1] - table[low]))


def bilinear(table: NDArray[Any], x: float, y: float) -> NDArray[np.float64]:
    """(Y, X, …) at a place of the unit square."""
    return bilinear_row(bilinear_row(table.astype(np.float64), y), x)


def integral(nodes: NDArray[np.float64], end: float) -> float:
    """∫₀^end of the broken line through `nodes` on [0, 1]."""
    at = np.linspace(0.0, 1.0, len(nodes))
    inside = np.append(at[at < end], end)
    return float(np.trapezoid(np.interp(inside, at, nodes), inside))


@pytest.fixture(scope="session")
def mitsuba() -> Any:
    """Mitsuba 3 in its scalar variants; the test is skipped where it is not installed."""
    return pytest.importorskip("mitsuba", reason="Mitsuba has no wheel for this system")


def in_mitsuba(mitsuba: Any, path: Path, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3): what its plugin `measured` gives for an RGB file, divided by the cosine that it includes."""
    mitsuba.set_variant("scalar_rgb")
    plugin = mitsuba.load_dict({"type": "measured", "filename": str(path)})
    context, surface = mitsuba.BSDFContext(), mitsuba.SurfaceInteraction3f()
    values = np.empty((len(wi), 3))
    for index, (incident, outgoing) in enumerate(zip(wi.tolist(), wo.tolist(), strict=True)):
        surface.wi = mitsuba.Vector3f(*incident)
        values[index] = list(plugin.eval(context, surface, mitsuba.Vector3f(*outgoing)))
    return values / wo[:, 2:]


@pytest.mark.parametrize("name", FILES)
def test_real_files_equal_the_definition(shared_data: Callable[[str], Path], name: str) -> None:
    path = shared_data(f"brdf/rgl/{name}.bsdf")
    reference, brdf = Reference(path), read_rgl(path)
    wi, wo = pairs(400)
    wi[:200], wo[:100] = wi[:200] * (1, 1, 0.05), wo[:100] * (1, 1, 0.05)
    wi, wo = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True) for vectors in (wi, wo))
    truth = np.maximum([reference.spectrum(*pair) for pair in zip(wi, wo, strict=True)], 0.0)
    assert (truth > 0.0).mean() > 0.7
    np.testing.assert_allclose(brdf.f(wi, wo), truth, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("name", FILES)
def test_real_files_equal_mitsuba(shared_data: Callable[[str], Path], mitsuba: Any, name: str) -> None:
    """10,000 pairs to 1e-4 of their brightest channel: all that are higher than 10°, and lower ones as told above."""
    path = shared_data(f"brdf/rgl/{name}.bsdf")
    wi, wo = pairs(10_000)
    other = in_mitsuba(mitsuba, path, wi, wo)
    values = read_rgl(path).f(wi, wo)
    error = np.abs(values - np.maximum(other, 0.0)).max(axis=1) / np.maximum(values.max(axis=1), 1e-30)
    high = np.minimum(wi[:, 2], wo[:, 2]) > np.sin(np.radians(10.0))
    assert high.sum() > 6000
    assert error[high].max() < 1e-4
    assert (error < 1e-4).mean() > 0.985
    reference, step = Reference(path), 2.0**-21
    for index in np.flatnonzero(error >= 1e-4):
        pair = wi[index], wo[index]
        exact = reference.spectrum(*pair)
        np.testing.assert_allclose(values[index], np.maximum(exact, 0.0), rtol=1e-8, atol=1e-12)
        roundings = [{key: sign * step} for key in ("azimuth", "grid") for sign in (-1.0, 1.0)]
        effect = sum(np.abs(reference.spectrum(*pair, **rounding) - exact) for rounding in roundings)
        assert np.abs(other[index] - exact).max() < 1e-4 * exact.max() + np.max(effect), (pair, exact, other[index])
