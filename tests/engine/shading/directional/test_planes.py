"""Directional maps and their rivals: every error against refits without the photograph, by brute force."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.capture.coded_pixels import Curve, Decoding, FallOff, Window, arrays_of
from engine.capture.mask import pack
from engine.capture.object_part import take_object
from engine.capture.stack import ImageStack
from engine.core.colour import srgb_decode, srgb_encode
from engine.core.steps import drain
from engine.shading.directional.effective_light import weights_at
from engine.shading.directional.functions import hemispherical, hsh, polynomial
from engine.shading.directional.interpolation import (
    Kernel,
    best_kernel,
    best_ridge,
    leave_out_of_fit,
    list_left_out,
    rms,
    weights,
)
from engine.shading.directional.moments import Moments, make_reader, moments, row_blocks
from engine.shading.directional.planes import BUDGET, choose, components, directions, errors_by_planes, fit, sweep
from engine.shading.directional.planes_kernel import round_values, shorten_values
from engine.storage.file_array import FileArray
from engine.storage.records import MAX_PLANES
from tests.engine.domes import dome

Array = NDArray[Any]


@pytest.fixture(scope="module")
def stack() -> ImageStack:
    return dome()


@pytest.fixture(scope="module")
def codes(stack: ImageStack) -> Array:
    """(N, texels, 3)."""
    return np.asarray(255.0 * srgb_encode(np.asarray(stack.radiance, np.float64))).reshape(len(stack.sources), -1, 3)


@pytest.fixture(scope="module")
def known(stack: ImageStack) -> Moments:
    return drain(moments(stack, np.arange(len(stack.sources))))


def read_row(stack: ImageStack, radiance: Array, pivot: Array | None = None) -> Array:
    """The texels of the first row of the first photograph, which has this radiance."""
    reader = make_reader(dataclasses.replace(stack, radiance=radiance), np.array([0]), pivot)
    ((first, last, found),) = reader.read_blocks(0, 1)
    assert (first, last) == (0, 1)
    return found


def rmse(apart: Array) -> float:
    return float(np.sqrt(np.mean(apart**2)))


def test_moments_are_those_of_the_codes(codes: Array, known: Moments) -> None:
    flat = codes.transpose(1, 0, 2).reshape(codes.shape[1], -1)
    assert known.mean == pytest.approx(flat.mean(axis=0), abs=2e-3)
    assert known.second == pytest.approx(flat.T @ flat / len(flat), rel=2e-5)


def test_codes_of_any_radiance(stack: ImageStack) -> None:
    """White is 255, more than the table holds is its end, what is not a number is black; less a value of each line."""
    odd = np.array([0.0, 1.0, 0.2, 1e9, np.inf, -3.0, np.nan, -np.inf, 64.0], np.float32).reshape(1, 1, 3, 3)
    found = read_row(stack, odd)
    end = 255.0 * srgb_encode(np.array(64.0))
    expected = [[0.0, end, 0.0], [255.0, end, 0.0], [255.0 * srgb_encode(np.array(0.2)), 0.0, end]]
    assert found == pytest.approx(np.array(expected), abs=2e-3)
    pivot = np.array([1.0, 20.0, -300.0], np.float32)
    less = read_row(stack, odd, pivot)
    assert less == pytest.approx(found - pivot[:, None], abs=1e-4)


def test_moments_of_every_third_row_and_of_small_blocks(stack: ImageStack, monkeypatch: pytest.MonkeyPatch) -> None:
    used = np.arange(12)
    whole = drain(moments(stack, used))
    monkeypatch.setattr("engine.shading.directional.moments.BLOCK_VALUES", 3 * 12 * 9 * 2)
    assert list(row_blocks(7, 9, 12)) == [(0, 2), (2, 4), (4, 6), (6, 7)]
    parts = drain(moments(stack, used))
    assert parts.second == pytest.approx(whole.second, rel=1e-6)
    monkeypatch.setattr("engine.shading.directional.moments.TEXELS", 7 * 9 // 3)
    sparse = drain(moments(stack, used))
    third = dataclasses.replace(stack, radiance=stack.radiance[:, 1::3])
    assert sparse.mean == pytest.approx(drain(moments(third, used)).mean, rel=1e-6)


def test_weights_give_a_photograph_back_where_there_is_no_noise(stack: ImageStack) -> None:
    lights = directions(stack, np.arange(12))
    assert weights(lights, lights, Kernel(0.4, 1e-12)) == pytest.approx(np.eye(12), abs=1e-6)


def test_weights_keep_what_is_linear_in_the_light(stack: ImageStack) -> None:
    lights = directions(stack, np.arange(12))
    wanted = np.array([[0.1, 0.2, math.sqrt(0.95)], [-0.5, 0.3, math.sqrt(0.66)]])
    found = weights(lights, wanted, Kernel(0.3, 0.1))
    assert found.sum(axis=1) == pytest.approx(1.0)
    assert found @ lights == pytest.approx(wanted, abs=1e-9)


def test_lamps_on_one_ring_have_no_trend_upwards() -> None:
    phi = np.arange(10) * 0.63
    ring = np.stack([0.8 * np.cos(phi), 0.8 * np.sin(phi), np.full(10, 0.6)], axis=1)
    above = np.array([[0.0, 0.0, 1.0]])
    assert np.abs(weights(ring, above, Kernel(0.3, 0.1))).max() < 0.5


@pytest.mark.parametrize(
    "kernel",
    [
        *(Kernel(0.2, 0.3), Kernel(0.9, 0.01), Kernel(0.4, 0.1, 0.5, 2.0, "linear", 3.0)),
        *(Kernel(0.3, 50.0, 1.0, 0.0, "polynomial", 40.0), Kernel(0.3, 0.1, 1.5, 1.0, "harmonic", 0.2)),
    ],
)
def test_leaving_out_is_a_refit_without_the_photograph(
    stack: ImageStack, codes: Array, known: Moments, kernel: Kernel
) -> None:
    lights = directions(stack, np.arange(12))
    apart = []
    for out in range(12):
        others = np.flatnonzero(np.arange(12) != out)
        own = weights(lights[others], lights[out][None], kernel)[0]
        # the trend is centred on other lights, which changes no weight
        apart.append(np.tensordot(own, codes[others], axes=1) - codes[out])
    assert rms(list_left_out(lights, kernel), known.average_channels()) == pytest.approx(
        rmse(np.array(apart)), rel=1e-4
    )


@pytest.mark.parametrize("ridge", [0.0, 0.02])
def test_leaving_out_of_a_fit_is_a_refit(stack: ImageStack, codes: Array, known: Moments, ridge: float) -> None:
    """With the penalty of all photographs as rows of values that are 0."""
    functions = polynomial(directions(stack, np.arange(12)))
    penalty = np.sqrt(ridge * np.mean(np.sum(functions**2, axis=0))) * np.eye(6)
    apart = []
    for out in range(12):
        others = np.flatnonzero(np.arange(12) != out)
        rows = np.vstack([codes[others].reshape(11, -1), np.zeros((6, codes[0].size))])
        solved = np.linalg.lstsq(np.vstack([functions[others], penalty]), rows, rcond=None)[0]
        apart.append(functions[out] @ solved - codes[out].ravel())
    found = rms(leave_out_of_fit(functions, ridge), known.average_channels())
    assert found == pytest.approx(rmse(np.array(apart)), rel=1e-4)


def test_a_kernel_of_much_noise_is_a_ridge_fit(stack: ImageStack) -> None:
    """Of the functions with a penalty and a constant without one."""
    lights, wanted = directions(stack, np.arange(12)), np.array([[0.1, 0.2, math.sqrt(0.95)]])
    functions, at = polynomial(lights), polynomial(wanted)
    penalty = np.diag([0.05] * 5 + [0.0])
    fitted = at @ np.linalg.solve(functions.T @ functions + penalty, functions.T)
    noise = 1e6
    assert weights(lights, wanted, Kernel(0.3, noise, 1.0, 0.0, "polynomial", noise / 0.05)) == pytest.approx(
        fitted, abs=1e-4
    )


@pytest.mark.parametrize("seed", range(4))
def test_the_best_kernel_is_no_worse_than_ridge_fits(seed: int) -> None:
    stack = dome(14, seed=seed)
    lights = directions(stack, np.arange(14))
    second = drain(moments(stack, np.arange(14))).average_channels()
    found = rms(list_left_out(lights, best_kernel(lights, second)), second)
    for functions in (polynomial(lights), hsh(lights)):
        assert found < rms(leave_out_of_fit(functions, best_ridge(functions, second)), second)


def test_hemispherical_harmonics_are_orthogonal() -> None:
    """On the hemisphere with equal weights of area: no two are alike, and those of files have the norm 1."""
    rng = np.random.default_rng(3)
    z, phi = rng.random(200_000), rng.uniform(0.0, 2.0 * math.pi, 200_000)
    sine = np.sqrt(1.0 - z**2)
    lights = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)
    values = hsh(lights)
    across = values.T @ values / len(values)
    scale = np.sqrt(np.diag(across))
    assert across / np.outer(scale, scale) == pytest.approx(np.eye(9), abs=0.01)
    normal = hemispherical(lights)
    assert 2.0 * math.pi * normal.T @ normal / len(values) == pytest.approx(np.eye(16), abs=0.02)


def test_errors_by_planes_are_those_of_refits(stack: ImageStack, codes: Array, known: Moments) -> None:
    lights, kernel = directions(stack, np.arange(12)), Kernel(0.4, 0.1)
    apart = []
    for out in range(12):
        others = np.flatnonzero(np.arange(12) != out)
        texels = codes[others].transpose(1, 0, 2).reshape(codes.shape[1], -1)
        mean = texels.mean(axis=0)
        _, _, axes = np.linalg.svd(texels - mean, full_matrices=False)
        shown = mean + (texels - mean) @ axes[:4].T @ axes[:4]
        own = weights(lights[others], lights[out][None], kernel)[0]
        apart.append(np.einsum("n,tnc->tc", own, shown.reshape(len(shown), 11, 3)) - codes[out])
    found = drain(errors_by_planes(lights, known, [kernel], (4,)))[kernel]
    assert found[4] == pytest.approx(rmse(np.array(apart)), rel=1e-3)


def test_a_map_shows_its_photographs_with_the_error_that_it_tells(stack: ImageStack, codes: Array) -> None:
    found = drain(fit(stack, np.arange(12)))
    lights = directions(stack, np.arange(12))
    shown = np.array([255.0 * srgb_encode(found.image(light).astype(np.float64)) for light in lights])
    assert rmse(shown.reshape(codes.shape) - codes) == pytest.approx(found.in_sample, rel=0.05)
    assert found.in_sample < found.leave_one_out < found.mean_picture
    means = codes.sum(axis=0) - codes
    assert found.mean_picture == pytest.approx(rmse(means / 11.0 - codes), rel=1e-3)


def test_large_maps_are_projected_twice_to_the_same_planes(stack: ImageStack, monkeypatch: pytest.MonkeyPatch) -> None:
    used = np.arange(len(stack.sources))
    monkeypatch.setattr("engine.shading.directional.moments.BLOCK_VALUES", 3 * len(used) * stack.radiance.shape[2])
    once = drain(fit(stack, used))
    monkeypatch.setattr("engine.storage.scratch.IN_MEMORY_BYTES", 0)
    kept_in_file = drain(fit(stack, used))
    monkeypatch.setattr("engine.shading.directional.planes.KEPT_BYTES", 0)
    twice = drain(fit(stack, used))
    for found in (kept_in_file, twice):
        np.testing.assert_array_equal(found.planes, once.planes)
        assert (found.in_sample, found.leave_one_out) == (once.in_sample, once.leave_one_out)


@pytest.mark.parametrize("kind", ["distant", "grey", "near", "of 16 bits"])
def test_a_stack_of_codes_has_the_map_of_its_radiance(
    stack: ImageStack, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bit for bit, whether a code tells the value of a pixel by itself or not."""
    count, height, width = stack.radiance.shape[:3]
    bits, channels, random = 16 if kind == "of 16 bits" else 8, 1 if kind == "grey" else 3, np.random.default_rng(3)
    most = (1 << bits) - 1
    codes = (most * srgb_encode(np.clip(stack.radiance[:][..., :channels], 0.0, 1.0))).astype(f"uint{bits}")
    path = tmp_path / "codes"
    path.write_bytes(codes.tobytes())
    file = FileArray(path, codes.shape, codes.dtype, 0, path.stat())
    curve = Curve(srgb_decode(np.arange(most + 1) / most).astype(np.float32)[None], most)
    near = FallOff(4.0, 0.7, 2.0) if kind == "near" else None
    decodings = [
        Decoding(curve, tuple(random.uniform(0.5, 2.0, 3)), None, near, float(np.float32(random.uniform(0.8, 1.2))))
        for _ in range(count)
    ]
    radiance = arrays_of(file, tuple(decodings), Window(height, width), (height, width))[0]
    used = np.delete(np.arange(count), 4)
    monkeypatch.setattr("engine.shading.directional.moments.BLOCK_VALUES", 3 * len(used) * width)
    monkeypatch.setattr("engine.shading.directional.moments.PIECE_BYTES", 2 * 3 * len(used) * width)
    monkeypatch.setattr("engine.shading.directional.moments.FEW_PIXELS", 2 * len(used) * width)
    coded = dataclasses.replace(stack, radiance=radiance)
    assert (make_reader(coded, used).tables is not None) == (kind in ("distant", "grey"))
    found, expected = (drain(fit(each, used)) for each in (coded, dataclasses.replace(stack, radiance=radiance[:])))
    for name in ("planes", "low", "step", "mean", "vectors"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    assert found.leave_one_out == pytest.approx(expected.leave_one_out, rel=1e-12)


def find_ranges(values: Array, inside: Array) -> tuple[Array, Array]:
    """Lowest value and step of 16 bits of each row, of the texels `inside` and of the others."""
    low, step = np.zeros((*values.shape[:2], 2), np.float32), np.ones((*values.shape[:2], 2), np.float32)
    for row, shown in enumerate(inside):
        for kind, texels in enumerate((shown, ~shown)):
            if texels.any():
                low[:, row, kind] = values[:, row, texels].min(axis=1)
                step[:, row, kind] = np.maximum(np.ptp(values[:, row, texels], axis=1) / np.float32(65535.0), 1e-30)
    return low, step


@pytest.mark.parametrize("around", [0.0, 1e4], ids=["like the rest", "far from it"])
def test_values_are_rounded_to_the_nearest_code(around: float) -> None:
    """And what that changes counts inside the mask alone, however far the values around it lie."""
    random = np.random.default_rng(5)
    values = random.uniform(-5.0, 260.0, (2, 3, 13)).astype(np.float32)
    values[1, 2] = 7.0
    inside, planes, squares = random.random((5, 13)) < 0.6, np.full((2, 5, 13), 7, np.uint8), np.empty(2)
    shown = inside[1:4]
    values[:, ~shown] += np.float32(around)
    of_rows, codes = find_ranges(values, shown), np.empty(values.shape, np.uint16)
    shorten_values(values, shown, *of_rows, codes)
    low_of, step_of = (np.where(shown, each[..., :1], each[..., 1:]) for each in of_rows)
    kept = low_of + step_of * codes.astype(np.float32)
    assert np.abs(kept - values)[:, shown].max() < 0.51 * 265.0 / 65535.0 + 2e-5
    assert {0, 65535} <= set(codes[:, 0].ravel().tolist())
    low, step = np.array([-1.0, 0.0], np.float32), np.array([0.5, 1.0], np.float32)
    round_values(codes, *of_rows, 1, low, step, inside, planes, squares)
    scaled = (kept - low[:, None, None]) / step[:, None, None]
    expected = np.clip(np.rint(scaled), 0.0, 255.0)
    np.testing.assert_array_equal(planes[:, 1:4], expected.astype(np.uint8))
    assert (planes[:, [0, 4]] == 7).all()
    apart = (expected.astype(np.float64) - scaled)[:, shown]
    of_codes = (step_of / step[:, None, None])[:, shown] ** 2 / 12.0
    assert squares == pytest.approx((apart**2 + of_codes).sum(axis=1), rel=1e-6)


def test_an_object_before_black_has_planes_as_fine_as_it_needs(stack: ImageStack) -> None:
    """Texels around an object lie beyond the range of its planes, and sixteen bits as far as to black are 4e-3."""
    height, width = stack.radiance.shape[1:3]
    mask = np.zeros((height, width), np.bool_)
    mask[height // 4 : height // 2, width // 3 : width // 2] = True
    radiance = np.asarray(0.4 + 0.002 * stack.radiance[:], np.float32)
    shown, _, _ = drain(take_object(dataclasses.replace(stack, radiance=radiance, provenance={"mask": pack(mask)})))
    used = np.arange(len(stack.sources))
    found = drain(fit(shown, used))
    lights = directions(shown, used)
    images = np.array([255.0 * srgb_encode(found.image(light).astype(np.float64)) for light in lights])
    apart = (images - 255.0 * srgb_encode(radiance.astype(np.float64)))[:, mask]
    assert rmse(apart) < 1e-4


def test_left_and_right_light_give_different_images(stack: ImageStack) -> None:
    found = drain(fit(stack, np.arange(12)))
    left, right = found.image(np.array([-0.8, 0.0, 0.6])), found.image(np.array([0.8, 0.0, 0.6]))
    assert np.abs(left - right).max() > 0.1
    assert not found.image(np.array([0.6, 0.0, -0.8])).any()


def test_fewer_planes_are_chosen_where_they_are_nearly_as_good() -> None:
    assert choose({1: 9.0, 2: 5.009, 3: 5.0, 5: 5.3}) == 2
    assert sweep(64)[-1] == BUDGET
    assert sweep(1024, 1000)[-1] == MAX_PLANES
    assert sweep(64, 9)[-1] == 9
    assert sweep(3) == (1, 2, 3, 5)
    assert sweep(1) == (1,)


def test_components_do_not_depend_on_the_sign_that_a_library_gives() -> None:
    rng = np.random.default_rng(0)
    square = rng.normal(size=(6, 6))
    found = components(square @ square.T, 3)
    assert found[np.abs(found).argmax(axis=0), np.arange(3)] == pytest.approx(np.abs(found).max(axis=0))


def test_texels_show_the_sums_of_their_planes(stack: ImageStack) -> None:
    """The kernels give the same bits as expressions of arrays do, dark texels and grazing light included."""
    found = drain(fit(stack, np.arange(len(stack.sources))))
    cosine, azimuth = np.array([0.0, 0.01, 0.3, 0.9, 1.0]), np.array([0.0, 2.0, -1.0, 4.0, 0.5])
    texels = np.random.default_rng(2).integers(0, 256, (1000, len(found.planes)), np.uint8)
    table = weights_at(found.table, cosine, azimuth)
    codes = table[..., 0] + np.einsum("mck,tk->tmc", table[..., 1:], np.moveaxis(texels.astype(np.float64).T, 0, 1))
    wanted = np.minimum(cosine / found.lowest, 1.0)[:, None] * srgb_decode(np.maximum(codes, 0.0) / 255.0)
    assert (codes < 0.0).any()
    assert (codes[codes > 0.0] < 10.0).any()
    np.testing.assert_array_equal(found.sample(texels, cosine, azimuth), wanted)
