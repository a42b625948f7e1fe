"""MERL files: made from a model, read back, against the published look-up written again, and refused where wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import correlate1d, maximum_filter

from engine.brdf.half_difference import half_difference
from engine.brdf.models.microfacet import Ggx
from engine.brdf.readers.merl import SCALE, SHAPE, SIZE_BYTES, read_merl, write_merl
from engine.brdf.readers.read import open_brdf, read_brdf
from engine.brdf.resample import random_pairs, table_from
from engine.brdf.table import RULE, HalfDifferenceTable, bin_centres, bin_directions
from engine.core.errors import InputError
from tests.engine.brdf.test_half_difference import random_directions

MODEL = Ggx(kd=(0.1, 0.2, 0.3), alpha=0.25, f0=(0.3, 0.2, 0.1))


def content_of(planes: NDArray[np.float64], dimensions: tuple[int, ...] = SHAPE, order: str = "<") -> bytes:
    return np.array(dimensions, f"{order}i4").tobytes() + planes.astype(f"{order}f8").tobytes()


@pytest.fixture(scope="module")
def planes() -> NDArray[np.float64]:
    """(3, 90, 90, 180) entries of a model; below the horizon, and in a hundredth of the bins, various negatives."""
    wi, wo = bin_directions(SHAPE)
    above = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
    values = np.moveaxis(MODEL.f(wi, wo) / SCALE, -1, 0).copy()
    random = np.random.default_rng(0)
    values[:, ~above] = -1.0
    holes = random.random(SHAPE) < 0.01
    values[int(random.integers(3)), holes] = -random.random(int(holes.sum()))
    return values


@pytest.fixture(scope="module")
def merl(planes: NDArray[np.float64], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    path = tmp_path_factory.mktemp("merl") / "painted-metal.binary"
    path.write_bytes(content_of(planes))
    yield path
    path.unlink()


@pytest.fixture(scope="module")
def table(merl: Path) -> HalfDifferenceTable:
    return read_merl(merl)


def find_published_bin(theta_h: float, theta_d: float, phi_d: float) -> tuple[int, int, int]:
    """The bin of the look-up that was published with the data, written again from its description."""
    degrees = theta_h / (math.pi / 2.0) * 90.0
    h = 0 if theta_h <= 0.0 else min(max(int(math.sqrt(degrees * 90.0)), 0), 89)
    d = min(max(int(theta_d / (math.pi * 0.5) * 90), 0), 89)
    phi_d = phi_d + math.pi if phi_d < 0.0 else phi_d
    p = min(max(int(phi_d / math.pi * 360 / 2), 0), 179)
    return h, d, p


def test_M7_every_bin_centre_maps_to_itself() -> None:
    """1,458,000 of 1,458,000, from angles and, where no horizon is in the way, from directions."""
    theta_h, theta_d, phi_d = bin_centres(SHAPE)
    bins = [
        find_published_bin(theta_h[h], theta_d[d], phi_d[p])
        for h, d, p in zip(*[range(90)] * 2, range(90), strict=True)
    ]
    assert bins == [(k, k, k) for k in range(90)]
    assert [find_published_bin(0.0, 0.0, phi)[2] for phi in phi_d] == list(range(180))
    angles = half_difference(*cast(Any, bin_directions(SHAPE)))
    assert np.array_equal(
        np.sqrt(angles.theta_h / (np.pi / 2) * 8100).astype(int), np.broadcast_to(np.arange(90)[:, None, None], SHAPE)
    )
    assert np.array_equal(
        (angles.theta_d / (np.pi / 2) * 90).astype(int), np.broadcast_to(np.arange(90)[:, None], SHAPE)
    )
    turn = np.where(angles.phi_d < 0.0, angles.phi_d + np.pi, angles.phi_d)
    assert np.array_equal((turn / np.pi * 180).astype(int), np.broadcast_to(np.arange(180), SHAPE))


def test_M7_bins_are_exact_at_their_centres_and_missing_ones_are_counted(
    table: HalfDifferenceTable, planes: NDArray[np.float64]
) -> None:
    missing = np.any(planes < 0.0, axis=0)
    assert np.array_equal(table.missing, missing)
    assert (table.samples, table.invalid_samples) == (1_458_000, int(missing.sum()))
    assert table.health.figures["missing"] == missing.sum()
    assert RULE in table.health.findings[0].text
    scaled = np.moveaxis(planes, 0, -1) * (1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0)
    assert np.array_equal(table.values[~missing], scaled[~missing])
    assert table.values.min() >= 0.0
    theta_h, theta_d, phi_d = bin_centres(SHAPE)
    found = table.at(theta_h[:, None, None], theta_d[:, None], phi_d)
    assert np.abs(found - table.values)[~missing].max() <= 1e-12 * table.values.max()


def test_the_published_look_up_gives_the_same_at_bin_centres(
    table: HalfDifferenceTable, planes: NDArray[np.float64]
) -> None:
    wi, wo = bin_directions(SHAPE)
    good = np.argwhere((wi[..., 2] > 0.0) & (wo[..., 2] > 0.0) & ~table.missing)
    chosen = good[np.random.default_rng(1).choice(len(good), 3_000, replace=False)]
    pairs = wi[tuple(chosen.T)], wo[tuple(chosen.T)]
    angles = half_difference(*pairs)
    places = [find_published_bin(*angle) for angle in zip(angles.theta_h, angles.theta_d, angles.phi_d, strict=True)]
    assert places == [tuple(place) for place in chosen]
    nearest = [[planes[c][place] * SCALE[c] for c in range(3)] for place in places]
    assert table.f(*pairs) == pytest.approx(np.array(nearest), rel=1e-9)


def test_the_model_comes_back_within_the_bound_of_the_interpolation(table: HalfDifferenceTable) -> None:
    """Linear interpolation has an error of at most 1/8 of the second difference per axis; away from holes, the sum."""
    wi, wo = random_directions(50_000), random_directions(50_000, 1)
    angles = half_difference(wi, wo)
    turn = np.where(angles.phi_d < 0.0, angles.phi_d + np.pi, angles.phi_d)
    scaled = (np.sqrt(angles.theta_h / (np.pi / 2)) * 90, angles.theta_d / (np.pi / 2) * 90, turn / np.pi * 180)
    place = tuple(np.minimum(position.astype(int), size - 1) for position, size in zip(scaled, SHAPE, strict=True))
    modes = ("nearest", "nearest", "wrap")
    near_hole = maximum_filter(table.missing, 5, mode=modes)[place]
    inner = ~near_hole & (place[0] > 1) & (place[1] > 1) & (place[0] < 87) & (place[1] < 87)
    assert inner.mean() > 0.15
    for c in range(3):
        values = table.values[..., c]
        bends = sum(np.abs(correlate1d(values, (1, -2, 1), axis, mode=modes[axis])) for axis in range(3))
        bound = 1.1 / 8.0 * maximum_filter(bends, 3, mode=modes)[place] + 1e-12
        error = np.abs(table.f(wi, wo) - MODEL.f(wi, wo))[:, c]
        assert np.all((error <= bound)[inner])


def test_M4_the_table_is_reciprocal_bit_for_bit(table: HalfDifferenceTable) -> None:
    wi, wo = random_pairs(100_000)
    assert np.array_equal(table.f(wi, wo), table.f(wo, wi))
    assert table.reciprocal
    assert table.isotropic


def test_what_was_read_is_written_again_byte_for_byte(table: HalfDifferenceTable, merl: Path, tmp_path: Path) -> None:
    write_merl(tmp_path / "copy.binary", table)
    assert (tmp_path / "copy.binary").read_bytes() == merl.read_bytes()
    again = read_merl(tmp_path / "copy.binary")
    assert np.array_equal(again.values, table.values)
    assert np.array_equal(again.missing, table.missing)


def test_tables_of_other_origin_come_back_within_an_ulp(table: HalfDifferenceTable, tmp_path: Path) -> None:
    other = HalfDifferenceTable(table.values * 0.7, table.missing, planes=table.planes)
    write_merl(tmp_path / "other.binary", other)
    again = read_merl(tmp_path / "other.binary")
    assert np.array_equal(again.missing, other.missing)
    known = ~other.missing
    assert np.abs(again.values[known] / other.values[known] - 1.0).max() <= np.finfo(np.float64).eps
    single = HalfDifferenceTable(other.values.astype(np.float32), other.missing)
    write_merl(tmp_path / "single.binary", single)
    assert np.array_equal(read_merl(tmp_path / "single.binary").values.astype(np.float32)[known], single.values[known])


def test_a_model_can_be_written_as_merl(tmp_path: Path) -> None:
    written = write_merl(tmp_path / "model.binary", MODEL)
    assert written.health.figures["resampling_rms_rel"] < 0.01
    table = open_brdf(str(tmp_path / "model.binary"))
    wi, wo = random_pairs(20_000)
    assert table.f(wi, wo) == pytest.approx(written.f(wi, wo), rel=1e-12)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (content_of(np.ones((3, 4)), (2, 2, 1)), "states 2 × 2 × 1 bins where a MERL table has 90 × 90 × 180"),
        (content_of(np.ones(3), (-1, 2**31 - 1, 90)), "states -1 × 2147483647 × 90 bins"),
        (content_of(np.ones((3, 10)), SHAPE, ">"), "looks big-endian: its bytes are swapped"),
        (content_of(np.ones((3, 10))), "has 252 bytes where a MERL table has 34,992,012"),
        (b"\x5a\0\0", "has only 3 bytes"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:69c4\nsize 34992012\n", "is a git-lfs pointer"),
        (b"", "is empty"),
    ],
)
def test_fault_7_a_wrong_file_is_refused_with_the_reason(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "wrong.binary"
    path.write_bytes(content)
    with pytest.raises(InputError) as error:
        read_brdf(path)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_table_of_other_numbers_of_bins_is_read(tmp_path: Path) -> None:
    coarse = table_from(Ggx(alpha=0.5), (24, 18, 36))
    planes = np.stack([coarse.values[..., c] / SCALE[c] for c in range(3)])
    path = tmp_path / "coarse.binary"
    path.write_bytes(content_of(planes, (24, 18, 36)))
    wi, wo = random_directions(200, 2), random_directions(200, 3)
    assert read_merl(path).f(wi, wo) == pytest.approx(coarse.f(wi, wo), rel=1e-6)


def test_the_name_alone_makes_no_table(tmp_path: Path) -> None:
    path = tmp_path / "words.binary"
    path.write_text("not even numbers")
    with pytest.raises(InputError, match="is not a measured BRDF of a known format"):
        read_brdf(path)


@pytest.mark.parametrize(
    ("value", "message"), [(-1.0, "only negative"), (np.nan, "not numbers"), (np.inf, "not numbers")]
)
def test_fault_7_values_that_mean_nothing_are_refused(tmp_path: Path, value: float, message: str) -> None:
    path = tmp_path / "wrong.binary"
    entries = np.full((3, *SHAPE), -1.0)
    entries[0, 3, 4, 5] = value
    path.write_bytes(content_of(entries))
    with pytest.raises(InputError, match=message):
        read_merl(path)
    path.write_bytes(content_of(entries) + b"\0")
    with pytest.raises(InputError, match="34,992,013 bytes where"):
        read_merl(path)
    assert path.stat().st_size == SIZE_BYTES + 1
