"""RGL measurements against a second evaluation, Mitsuba, and materials of which everything is known.

`Reference` computes values from the paper's definition in float64 and without the program's tables: it integrates the
bilinear density itself. Mitsuba 3 computes in float32, and errs by up to percents where one of the two directions lies
low. There 1 − x of the place x in the grid is a difference of nearly equal numbers, and as colours vanish at x = 1, the
horizon, that difference is the value; or the visible normals end between two rows of their table, and the place depends
on the half vector's azimuth by leaps. Both are shown pair by pair: its error is no larger than what moving those places
by some roundings of float32 does to the exact value. For isotropic files it also uses a symmetry that it never set
(`m_reduction` of its source), which turns the incident direction by chance; that shows where sigma depends on the
azimuth, as it must not in an isotropic file, and in no real one.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from engine.brdf.readers.rgl import RglBrdf, looks_like_rgl, read_rgl
from engine.brdf.readers.tensor_file import read_tensor_file
from engine.brdf.spectrum import srgb_from_spectra
from engine.core.errors import InputError
from tests.engine.brdf.readers.tensor_files import AnisotropicGgx, fields_of, tensor_bytes

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


def save(tmp_path: Path, fields: dict[str, NDArray[Any]]) -> Path:
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
        """The coordinates of the pair's value: incident angles, half vector's place, and its place in the grid."""
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
    """Mitsuba 3 in its scalar variants; the test is skipped where it is not installed or lacks a system library."""
    try:
        return importlib.import_module("mitsuba")
    except (ImportError, NameError) as error:  # NameError: what its own package makes of a library that is missing
        pytest.skip(f"Mitsuba cannot be loaded: {error}")


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
    """10,000 pairs to 1e-4 of their brightest channel: all that are higher than 10°, and lower ones as stated above."""
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
        effect = sum((np.abs(reference.spectrum(*pair, **cast(Any, rounding)) - exact)) for rounding in roundings)
        assert np.abs(other[index] - exact).max() < 1e-4 * exact.max() + np.max(effect), (pair, exact, other[index])


@pytest.mark.parametrize("name", FILES)
def test_real_files_are_sampled_as_mitsuba_does(shared_data: Callable[[str], Path], mitsuba: Any, name: str) -> None:
    """Directions to 1e-4 (one in 1000 to 1e-3) and densities to 1e-3 (one in 1000 to 5e-3), from the same numbers.

    Mitsuba's density is negative where a facet was drawn that faces away; there it belongs to the mirrored facet.
    """
    path = shared_data(f"brdf/rgl/{name}.bsdf")
    mitsuba.set_variant("scalar_rgb")
    plugin = mitsuba.load_dict({"type": "measured", "filename": str(path)})
    context, surface = mitsuba.BSDFContext(), mitsuba.SurfaceInteraction3f()
    wo, _ = pairs(2000)
    u = np.random.default_rng(2).random((2000, 2)).astype(np.float32).astype(np.float64)
    drawn, density = np.empty((2000, 3)), np.empty(2000)
    for index, (viewer, uniform) in enumerate(zip(wo.tolist(), u.tolist(), strict=True)):
        surface.wi = mitsuba.Vector3f(*viewer)
        sample, _ = plugin.sample(context, surface, 0.0, mitsuba.Point2f(*uniform))
        drawn[index], density[index] = list(sample.wo), sample.pdf
    brdf = read_rgl(path)
    wi = brdf.sample(wo, u)
    error = np.abs(wi - drawn).max(axis=1)
    assert (error < 1e-4).mean() > 0.999
    assert error.max() < 1e-3
    error = np.abs(brdf.pdf(wi, wo) / np.abs(density) - 1.0)
    assert (error < 1e-3).mean() > 0.999
    assert error.max() < 5e-3


def affine(circle: float, *, spectral: bool = False) -> dict[str, NDArray[Any]]:
    """A file whose value times the outgoing cosine is linear in everything it is interpolated in.

    The visible normals are equal everywhere, so that the place in the grid is the half vector's own.
    """
    phi_i, theta_i = -np.pi + np.linspace(0.0, circle, 5), np.radians([0.0, 20.0, 50.0, 90.0])
    phi, theta, y, x = np.meshgrid(phi_i, theta_i, np.linspace(0, 1, 4), np.linspace(0, 1, 4), indexing="ij")
    base = AFFINE @ np.stack([np.ones_like(x), phi, theta, y, x]).reshape(5, -1)
    bands = len(WAVELENGTHS) if spectral else 3
    values = base.reshape(1, *x.shape) * (1.0 + np.arange(bands)).reshape(-1, 1, 1, 1, 1)
    return fields_of(
        phi_i,
        theta_i,
        vndf=np.full((5, 4, 7, 6), 0.3),
        values=np.moveaxis(values, 0, 2),
        wavelengths=WAVELENGTHS if spectral else None,
    )


#: Coefficients of 1, phi_i, theta_i, y and x; positive in all.
AFFINE = np.array([4.0, 0.7, 0.5, 0.6, 0.8])


def affine_value(wi: NDArray[np.float64], wo: NDArray[np.float64], circle: str) -> NDArray[np.float64]:
    """f of the first band for pairs (N, 3)."""
    wi, wo = wi.copy(), wo.copy()
    if circle == "half turn":
        turned = wi[:, 1] > 0
        wi[turned, :2] *= -1.0
        wo[turned, :2] *= -1.0
    if circle == "two mirrors":
        for axis in (0, 1):
            mirrored = wi[:, axis] > 0
            wi[mirrored, axis] *= -1.0
            wo[mirrored, axis] *= -1.0
    half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    phi, theta = np.arctan2(wi[:, 1], wi[:, 0]), np.arccos(wi[:, 2])
    x = np.sqrt(np.arccos(half[:, 2]) * 2 / np.pi)
    y = (np.arctan2(half[:, 1], half[:, 0]) + np.pi) / (2 * np.pi)
    return np.asarray(AFFINE @ np.stack([np.ones_like(x), phi, theta, y, x]) / wo[:, 2])


@pytest.mark.parametrize("circle", CIRCLES)
def test_a_known_anisotropic_file_is_exact(tmp_path: Path, circle: str) -> None:
    brdf = read_rgl(save(tmp_path, affine(CIRCLES[circle])))
    assert not brdf.isotropic
    assert brdf.health.verdict == 0
    wi, wo = pairs(2000)
    wi, wo = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True) for vectors in (wi, wo))
    truth = affine_value(wi, wo, circle)
    np.testing.assert_allclose(brdf.f(wi, wo), truth[:, None] * [1.0, 2.0, 3.0], rtol=1e-6)


@pytest.mark.parametrize("circle", CIRCLES)
def test_a_known_anisotropic_file_equals_mitsuba(tmp_path: Path, mitsuba: Any, circle: str) -> None:
    path = save(tmp_path, affine(CIRCLES[circle]))
    wi, wo = pairs(2000)
    np.testing.assert_allclose(read_rgl(path).f(wi, wo), in_mitsuba(mitsuba, path, wi, wo), rtol=1e-5)


@pytest.mark.parametrize("circle", CIRCLES)
def test_a_known_spectral_file_is_exact(tmp_path: Path, circle: str) -> None:
    brdf = read_rgl(save(tmp_path, affine(CIRCLES[circle], spectral=True)))
    assert brdf.kind == "spectral RGL measurement"
    wi, wo = pairs(500)
    wi, wo = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True) for vectors in (wi, wo))
    colour = srgb_from_spectra(WAVELENGTHS, np.arange(1.0, 7.0))
    np.testing.assert_allclose(brdf.f(wi, wo), affine_value(wi, wo, circle)[:, None] * np.maximum(colour, 0), rtol=1e-6)


def test_a_spectral_file_equals_mitsuba_band_by_band(tmp_path: Path, mitsuba: Any) -> None:
    material = AnisotropicGgx(0.5, 0.5, 0.3 + 0.1 * np.arange(6))
    path = save(tmp_path, material.fields(np.array([0.0]), THETA, wavelengths=WAVELENGTHS, nodes=32))
    mitsuba.set_variant("scalar_spectral")
    plugin = mitsuba.load_dict({"type": "measured", "filename": str(path)})
    context, surface = mitsuba.BSDFContext(), mitsuba.SurfaceInteraction3f()
    wi, wo = high_pairs(500)
    spectra = np.empty((len(wi), len(WAVELENGTHS)))
    for index, (incident, outgoing) in enumerate(zip(wi.tolist(), wo.tolist(), strict=True)):
        surface.wi = mitsuba.Vector3f(*incident)
        for start in (0, 2):
            surface.wavelengths = WAVELENGTHS[start : start + 4]
            spectra[index, start : start + 4] = list(plugin.eval(context, surface, mitsuba.Vector3f(*outgoing)))
    truth = np.maximum(srgb_from_spectra(WAVELENGTHS, spectra / wo[:, 2:]), 0.0)
    np.testing.assert_allclose(read_rgl(path).f(wi, wo), truth, rtol=1e-4)


THETA = np.radians(np.linspace(0.0, 90.0, 10))


def high_pairs(count: int) -> Pairs:
    """Pairs higher than 10°, at unit length."""
    wi, wo = pairs(4 * count, 4)
    chosen = np.flatnonzero(np.minimum(wi[:, 2], wo[:, 2]) > np.sin(np.radians(10.0)))[:count]
    return wi[chosen], wo[chosen]


def ggx(circle: str) -> AnisotropicGgx:
    """The material of `ggx_files`: six bands where they are spectral, RGB in the others."""
    return AnisotropicGgx(0.4, 0.6, 0.3 + 0.1 * np.arange(6.0) if circle == "half turn" else [0.3, 0.5, 0.8])


@pytest.fixture(scope="module")
def ggx_files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """An anisotropic GGX measured every 22.5° over a quarter and half of the circle, or all of it; one is spectral."""
    files = {}
    for (circle, width), azimuths in zip(CIRCLES.items(), (17, 9, 5), strict=True):
        more: dict[str, Any] = {"wavelengths": WAVELENGTHS} if circle == "half turn" else {}
        fields = ggx(circle).fields(-np.pi + np.linspace(0.0, width, azimuths), THETA, **more)
        files[circle] = save(tmp_path_factory.mktemp("ggx"), fields)
    return files


@pytest.mark.parametrize("circle", CIRCLES)
def test_an_anisotropic_material_comes_back(ggx_files: dict[str, Path], circle: str) -> None:
    """Measured in 32 × 32 directions for light every 10° and 22.5°: better for that light than between."""
    brdf = read_rgl(ggx_files[circle])
    wi, wo = high_pairs(2000)
    random = np.random.default_rng(3)
    theta, phi = random.choice(THETA[:9], 2000), random.choice(np.radians(np.arange(-180.0, 180.0, 22.5)), 2000)
    measured = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    for incident, median, most in ((measured, 0.003, 0.02), (wi, 0.006, 0.05)):
        truth = ggx(circle).f(incident, wo)
        truth = srgb_from_spectra(WAVELENGTHS, truth) if circle == "half turn" else truth
        error = relative_error(brdf.f(incident, wo), np.maximum(truth, 0.0))
        assert np.median(error) < median
        assert np.percentile(error, 90) < most


@pytest.mark.parametrize("circle", ["whole", "two mirrors"])
def test_an_anisotropic_material_equals_mitsuba(ggx_files: dict[str, Path], mitsuba: Any, circle: str) -> None:
    wi, wo = high_pairs(2000)
    other = in_mitsuba(mitsuba, ggx_files[circle], wi, wo)
    np.testing.assert_allclose(read_rgl(ggx_files[circle]).f(wi, wo), other, rtol=1e-4)


def test_an_isotropic_material_may_be_turned(tmp_path: Path) -> None:
    brdf = read_rgl(save(tmp_path, AnisotropicGgx(0.5, 0.5, [0.2, 0.4, 0.6]).fields(np.array([0.0]), THETA, nodes=32)))
    assert brdf.isotropic
    wi, wo = high_pairs(500)
    cosine, sine = np.cos(2.1), np.sin(2.1)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(brdf.f(wi @ turn.T, wo @ turn.T), brdf.f(wi, wo), rtol=1e-9)


def test_M2_the_azimuth_of_a_half_vector_at_the_normal_is_nothing(shared_data: Callable[[str], Path]) -> None:
    brdf = read_rgl(shared_data("brdf/rgl/colodur_napoli_4f_rgb.bsdf"))
    phi = np.linspace(-np.pi, np.pi, 50)
    wi = np.stack([0.6 * np.cos(phi), 0.6 * np.sin(phi), np.full(50, 0.8)], axis=-1)
    wo = wi * (-1.0, -1.0, 1.0) + np.random.default_rng(0).uniform(-1e-15, 1e-15, (50, 3))
    np.testing.assert_allclose(brdf.f(wi, wo), np.broadcast_to(brdf.f(wi[0], wo[0]), (50, 3)), rtol=1e-6)


@pytest.mark.parametrize("circle", CIRCLES)
def test_BR9_a_reciprocal_material_stays_so_to_the_error_of_interpolation(
    ggx_files: dict[str, Path], circle: str
) -> None:
    brdf = read_rgl(ggx_files[circle])
    assert not brdf.reciprocal
    wi, wo = high_pairs(5000)
    assert np.median(relative_error(brdf.f(wi, wo), brdf.f(wo, wi))) < 0.012


@pytest.mark.parametrize(
    ("source", "theta"),
    [
        ("paper_white_rgb", 1.2),
        ("cc_ibiza_sunset_rgb", 0.3),
        ("whole", 0.3),
        ("two mirrors", 1.2),
        pytest.param("paper_white_rgb", 0.3, marks=pytest.mark.long),
        pytest.param("cc_ibiza_sunset_rgb", 1.2, marks=pytest.mark.long),
        pytest.param("whole", 1.2, marks=pytest.mark.long),
        pytest.param("two mirrors", 0.3, marks=pytest.mark.long),
    ],
)
def test_BR11_samples_follow_their_density(
    shared_data: Callable[[str], Path], ggx_files: dict[str, Path], source: str, theta: float
) -> None:
    """Chi-square over the whole sphere, below the horizon too, at Šidák's level for 0.01 in all 8 cases."""
    brdf = read_rgl(ggx_files[source] if source in ggx_files else shared_data(f"brdf/rgl/{source}.bsdf"))
    wo = np.array([np.sin(theta) * np.cos(0.7), np.sin(theta) * np.sin(0.7), np.cos(theta)])
    count, rows, columns, fine = 1_000_000, 16, 24, 32
    wi = brdf.sample(wo, np.random.default_rng(7).random((count, 3)))
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1.0, atol=1e-12)
    z = np.linspace(-1.0, 1.0, rows * fine * 2 + 1)[1::2]
    phi = np.linspace(-np.pi, np.pi, columns * fine * 2 + 1)[1::2]
    radius = np.sqrt(1.0 - z**2)[:, None]
    grid = np.stack(np.broadcast_arrays(radius * np.cos(phi), radius * np.sin(phi), z[:, None]), axis=-1)
    density = brdf.pdf(grid, wo).reshape(rows, fine, columns, fine).mean(axis=(1, 3))
    expected = density.ravel() * 4.0 * np.pi / (rows * columns) * count
    assert abs(expected.sum() / count - 1.0) < 0.01
    seen, *_ = np.histogram2d(wi[:, 2], np.arctan2(wi[:, 1], wi[:, 0]), (rows, columns), ((-1, 1), (-np.pi, np.pi)))
    order = np.argsort(expected)
    pool = np.searchsorted(np.cumsum(expected[order]), 20.0) + 1
    pooled = [np.append(cells[order][pool:], cells[order][:pool].sum()) for cells in (seen.ravel(), expected)]
    statistic = ((pooled[0] - pooled[1]) ** 2 / pooled[1]).sum()
    assert stats.chi2.sf(statistic, len(pooled[0]) - 1) > 1.0 - 0.99 ** (1.0 / 8.0), (statistic, len(pooled[0]))


def test_BR1_BR2_BR3_values_are_finite_everywhere(
    shared_data: Callable[[str], Path], ggx_files: dict[str, Path]
) -> None:
    """Zero at and below the horizon and for what is no direction; never NaN, negative or infinite."""
    edge = np.array([0.0, -0.0, 1e-300, 1e-9, 1e-4, 0.5, 1.0])
    z = np.concatenate([edge, -edge, [np.nan, np.inf]])
    radius = np.sqrt(np.maximum(1.0 - np.nan_to_num(z, posinf=0.0) ** 2, 0.0))
    every = np.concatenate([np.stack([radius * np.cos(phi), radius * np.sin(phi), z], -1) for phi in (0.0, 1.0, np.pi)])
    files = [shared_data("brdf/rgl/cc_ibiza_sunset_rgb.bsdf"), *ggx_files.values()]
    for brdf in map(read_rgl, files):
        values = brdf.f(every[:, None], every)
        above = every[:, 2] > 0.0
        assert values.shape == (len(every), len(every), 3)
        assert np.isfinite(values).all()
        assert (values >= 0.0).all()
        assert (values[~(above & np.isfinite(every[:, 2]))] == 0.0).all()
        assert (values[:, ~(above & np.isfinite(every[:, 2]))] == 0.0).all()
        u = np.random.default_rng(0).random((len(every), 3))
        assert np.isfinite(brdf.sample(every, u)).all()
        assert (brdf.pdf(every[:, None], every) >= 0.0).all()


def test_negative_values_are_counted_and_give_no_negative_light(shared_data: Callable[[str], Path]) -> None:
    path = shared_data("brdf/rgl/cc_ibiza_sunset_rgb.bsdf")
    brdf = read_rgl(path)
    rgb = read_tensor_file(path, 1 << 26)["rgb"]
    count = int((rgb < 0.0).any(axis=2).sum())
    assert brdf.invalid_samples == brdf.health.figures["negative"] == count > 0
    assert brdf.samples == 8 * 32 * 32
    assert brdf.name == "TeckWrap vinyl wrapping film (Ibiza Sunset RD02)"
    assert f"{count} of 8192 measured directions have a negative value" in brdf.health.findings[0].text
    wi, wo = pairs(5000)
    reference = Reference(path)
    negative = [reference.spectrum(*pair).min() <= 0.0 for pair in zip(wi[:300], wo[:300], strict=True)]
    assert any(negative)
    assert ((brdf.f(wi, wo)[:300] == 0.0).any(axis=1) == negative).all()


def test_values_that_are_not_finite_count_as_zero(tmp_path: Path) -> None:
    fields = affine(CIRCLES["whole"])
    fields["rgb"][1, 2, 0, 3, 3] = np.nan
    brdf = read_rgl(save(tmp_path, fields))
    assert brdf.invalid_samples == brdf.health.figures["not finite"] == 1
    assert brdf.health.warnings == [
        "1 of 320 measured directions have a value that is not a finite number; it is taken as 0"
    ]
    assert np.isfinite(brdf.f(*pairs(2000))).all()


def test_unmeasured_light_is_reported(tmp_path: Path) -> None:
    fields = affine(CIRCLES["half turn"])
    fields["theta_i"] = np.radians(np.array([10.0, 20.0, 50.0, 70.0], np.float32))
    fields["phi_i"] = fields["phi_i"] + np.float32(0.5)
    assert read_rgl(save(tmp_path, fields)).health.warnings == [
        "light was measured from 10° to 70°; beyond, the nearest measurement is taken",
        "azimuths were measured from -151° to 29°; beyond, the nearest measurement is taken",
    ]


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (
            {"rgb": None},
            "is a tensor_file without measured reflectance; its fields are description, jacobian, luminance",
        ),
        ({"vndf": None}, "lacks the field 'vndf' of an RGL measurement"),
        ({"ndf": np.ones((2, 2))}, "has a field 'ndf' of 2 × 2 float64: it is damaged"),
        (
            {"theta_i": np.array([0, 2, 1, 3], np.float32)},
            "has 'theta_i' that are not angles in rising order: it is damaged",
        ),
        (
            {"theta_i": np.array([0, 1, 2, 3], np.float32)},
            "has 'theta_i' that are not angles in rising order: it is damaged",
        ),
        ({"phi_i": np.array([0, 0.5, 1, 1.5, 2], np.float32)}, "covers 115° of azimuth, and 360, 180 or 90 are known"),
        (
            {"vndf": np.zeros((5, 4, 2, 2), np.float32)},
            "has 'vndf' that is 0 for some incident direction: it is damaged",
        ),
        (
            {"sigma": np.array([[1, -1], [1, 1]], np.float32)},
            "has 'sigma' that is not a table of positive numbers: it is damaged",
        ),
        ({"jacobian": np.array([1, 1], np.uint8)}, "has 2 numbers as 'jacobian', not one: it is damaged"),
        ({"rgb": np.ones((5, 4, 2, 4, 4), np.float32)}, "has 'rgb' in 2 bands, and 3 wavelengths: it is damaged"),
        (
            {"luminance": np.ones((4, 4, 2, 2), np.float32)},
            "has 'luminance' for 4 × 4 incident directions, not 5 × 4: it is damaged",
        ),
        (
            {"spectra": np.ones((5, 4, 2, 4, 4), np.float32), "wavelengths": np.array([900, 950], np.float32)},
            "has wavelengths that cannot be used: no wavelength lies between 400 and 700 nm",
        ),
        (
            {"spectra": np.ones((5, 4, 2, 4, 4), np.float32), "wavelengths": np.array([300, 390], np.float32)},
            "has wavelengths that cannot be used: no wavelength lies between 400 and 700 nm",
        ),
    ],
)
def test_fault7_fields_that_contradict_each_other(tmp_path: Path, change: dict[str, Any], problem: str) -> None:
    fields = {name: field for name, field in (affine(CIRCLES["whole"]) | change).items() if field is not None}
    with pytest.raises(InputError) as caught:
        read_rgl(save(tmp_path, fields))
    assert caught.value.problem.startswith(problem)


def test_a_tensor_file_is_recognised_by_its_content() -> None:
    content = tensor_bytes(affine(CIRCLES["whole"]))
    assert looks_like_rgl(content[:4096], len(content), "some.binary")
    assert not looks_like_rgl(b"MERL" + content[:4092], len(content), "some.bsdf")


def test_arrays_are_read_only(tmp_path: Path) -> None:
    brdf: RglBrdf = read_rgl(save(tmp_path, affine(CIRCLES["whole"])))
    tables = (brdf.phi_i, brdf.theta_i, brdf.ndf, brdf.sigma, brdf.colours, brdf.visible.density, brdf.luminance.rows)
    assert not any(table.flags.writeable for table in tables)
