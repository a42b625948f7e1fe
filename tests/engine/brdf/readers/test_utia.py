"""UTIA files: plane order and angles, an anisotropic model back within its bound, wrong files refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from engine.brdf.half_difference import polar
from engine.brdf.models.microfacet import Ggx
from engine.brdf.readers.read import read_brdf
from engine.brdf.readers.utia import PHI, SIZE_BYTES, THETA, read_utia
from engine.core.directions import surface_direction
from engine.core.errors import InputError
from tests.engine.brdf.test_half_difference import random_directions

MODEL = Ggx(kd=(0.1, 0.2, 0.3), alpha=0.9, f0=(0.3, 0.2, 0.1))


def model_planes() -> NDArray[np.float64]:
    """(3, 6, 48, 6, 48): a broad highlight, brighter for light along the tangent than across it."""
    direction = surface_direction(THETA[:, None], PHI)
    values = MODEL.f(direction[:, :, None, None], direction)
    along = (1.0 + 0.5 * np.cos(2.0 * PHI))[None, :, None, None, None]
    return np.moveaxis(values * along, -1, 0).copy()


def test_planes_rows_and_columns_are_where_they_belong(tmp_path: Path) -> None:
    """The published look-up: plane · 288² + 288 (48 theta_i + phi_i) + 48 theta_v + phi_v."""
    planes = model_planes()
    path = tmp_path / "m001_fabric.bin"
    path.write_bytes(planes.astype("<f8").tobytes())
    assert path.stat().st_size == SIZE_BYTES
    table = read_brdf(path)
    numbers = np.frombuffer(path.read_bytes(), "<f8")
    random = np.random.default_rng(0)
    for i, j, k, m in random.integers((1, 0, 1, 0), (6, 48, 6, 48), (200, 4)):
        wi = surface_direction(np.radians(15.0 * i), np.radians(7.5 * j))
        wo = surface_direction(np.radians(15.0 * k), np.radians(7.5 * m))
        stored = [numbers[plane * 288**2 + 288 * (48 * i + j) + 48 * k + m] for plane in range(3)]
        assert table.f(wi, wo) == pytest.approx(stored, rel=1e-10)
    assert (table.name, table.kind, table.samples) == ("m001_fabric", "UTIA table", 288 * 288)
    assert table.invalid_samples == 0
    assert not table.isotropic


def test_a_smooth_model_comes_back_between_the_nodes(tmp_path: Path) -> None:
    path = tmp_path / "smooth.bin"
    path.write_bytes(model_planes().astype("<f8").tobytes())
    table = read_utia(path)
    assert not table.reciprocal
    wi, wo = random_directions(20_000), random_directions(20_000, 1)
    inner = (wi[:, 2] > np.cos(THETA[-1])) & (wo[:, 2] > np.cos(THETA[-1]))
    wanted = MODEL.f(wi, wo) * (1.0 + 0.5 * np.cos(2.0 * np.arctan2(wi[:, 1], wi[:, 0])))[:, None]
    closed = np.r_[PHI, 2.0 * np.pi]
    around = table.values.take(np.arange(49) % 48, axis=1).take(np.arange(49) % 48, axis=3)
    oracle = RegularGridInterpolator((THETA, closed, THETA, closed), around)
    angles = [np.stack(polar(direction), axis=-1) % (2.0 * np.pi) for direction in (wi[inner], wo[inner])]
    assert table.f(wi, wo)[inner] == pytest.approx(oracle(np.concatenate(angles, axis=-1)), rel=1e-9)
    assert np.median(np.abs(table.f(wi, wo) / wanted - 1.0)[inner]) < 0.01
    assert np.all(table.f(wi, wo)[~inner] >= 0.0)


def test_negative_entries_are_missing_counted_and_never_used(tmp_path: Path) -> None:
    planes = model_planes()
    planes[1, 2, 3, 4, 5] = -0.01
    planes[:, 4, 5, 3] = -1.0
    path = tmp_path / "holes.bin"
    path.write_bytes(planes.astype("<f8").tobytes())
    table = read_utia(path)
    assert table.invalid_samples == 49
    assert "49 of 82,944 entries are missing" in table.health.findings[0].text
    assert table.values[2, 3, 4, 5] == pytest.approx(0.5 * (planes[:, 2, 3, 4, 4] + planes[:, 2, 3, 4, 6]))
    assert np.array_equal(table.values[4, 5, 3], table.values[4, 5, 2])


@pytest.mark.parametrize("order", ["float32", "cut", "swapped", "negative", "nan", "huge", "text"])
def test_fault_7_a_wrong_file_is_refused_with_the_reason(tmp_path: Path, order: str) -> None:
    planes = model_planes()
    if order == "nan":
        planes[0, 1, 2, 3, 4] = np.nan
    content, message = {
        "float32": (planes.astype("<f4").tobytes(), "has 995,328 bytes where a UTIA table has 1,990,656"),
        "cut": (planes.astype("<f8").tobytes()[:-1], "has 1,990,655 bytes"),
        "swapped": (planes.astype(">f8").tobytes(), "looks big-endian"),
        "negative": (np.full(planes.shape, -1.0).tobytes(), "holds only negative entries"),
        "nan": (planes.tobytes(), "holds values that are not numbers"),
        "huge": ((planes + 1e31).tobytes(), "absurdly large"),
        "text": (b"only words", "is not a measured BRDF of a known format"),
    }[order]
    path = tmp_path / "wrong.bin"
    path.write_bytes(content)
    with pytest.raises(InputError) as error:
        read_brdf(path)
    assert message in str(error.value)
