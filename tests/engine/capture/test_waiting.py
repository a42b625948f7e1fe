"""Lights that wait for the calibration: their pixels come out as if they had been corrected after they were written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import engine.capture.import_codes as import_codes
import engine.capture.import_stack as module
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.photograph import decode
from engine.capture.photograph.calibrate import near_lamp_gain
from engine.capture.waiting import CodedPixels
from engine.core.steps import drain
from engine.images.codes import Coded
from engine.images.decode import halve_image
from engine.images.encode import write_tiff16
from engine.storage.scratch import keep_in_memory
from tests.engine.capture.calibration.generated import Capture, render, write

SMALL: dict[str, Any] = {"height": 48, "width": 56, "lamps": 18}


def test_rows_are_corrected_once_as_a_stack_that_was_written_would_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rendered = render(Capture(seed=3, distance=2.5, gains=(0.6, 1.3), file_format="jpg", **SMALL))
    sources = find([write(rendered, tmp_path / "photographs")])
    plain = drain(import_stack(sources, ImportSettings(calibrate="none"), tmp_path / "plain"))
    for place in ("import_stack", "output"):
        monkeypatch.setattr(f"engine.capture.{place}.BAND_PIXELS", 700)  # bands of 12 rows
    found = drain(import_stack(sources, ImportSettings(calibrate=("distance", "gains")), tmp_path / "found"))
    distance, gains = (found.provenance[name] for name in ("lamp_distance_widths", "lamp_gains"))
    assert distance == pytest.approx(2.5, rel=0.05)
    assert min(gains) < 0.8 < 1.2 < max(gains)
    assert plain.azimuth is not None
    for index, radiance in enumerate(plain.radiance):
        even = near_lamp_gain(48, 56, distance, float(plain.elevation[index]), float(plain.azimuth[index]))
        expected = radiance * (even / gains[index])[..., None]
        np.testing.assert_allclose(found.radiance[index], expected, rtol=3e-7)
    assert np.array_equal(found.saturated[:], plain.saturated[:])


@pytest.mark.parametrize(
    ("term", "fixed"),
    [
        ("ambient", {"room": 0.15}),
        ("motion", {"motion_px": 0.4, "surface": "coin"}),
        ("gains", {"gains": (0.7, 1.2)}),
    ],
)
def test_codes_that_wait_become_the_bits_of_pixels_that_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, term: str, fixed: dict[str, Any]
) -> None:
    sources = find(
        [write(render(Capture(seed=8, distance=4.0, **fixed, **{**SMALL, "lamps": 12})), tmp_path / "photographs")]
    )
    settings = ImportSettings(lamp_distance=4.0)
    codes = drain(import_stack(sources, settings, tmp_path / "codes"))
    monkeypatch.setattr(import_codes, "waits_as_codes", lambda _: False)
    pixels = drain(import_stack(sources, settings, tmp_path / "pixels", as_codes=False))
    assert term in {each["name"] for each in codes.provenance["calibration"] if each["accepted"]}
    for name in ("radiance", "saturated"):
        assert np.array_equal(getattr(codes, name)[:], getattr(pixels, name)[:])


@pytest.mark.parametrize("channels", [1, 3])
def test_codes_of_another_kind_than_announced_are_refused(channels: int) -> None:
    codes = np.arange(4 * 5 * channels, dtype=np.uint8).reshape(4, 5, channels)
    table = np.linspace(0.0, 1.0, 256, dtype=np.float32)
    light, saturated = Coded(codes, table[None], 18).linear(1, 3)
    assert np.array_equal(light, np.broadcast_to(table[codes[1:3]], (2, 5, 3)))
    assert np.array_equal(saturated, (codes[1:3] >= 18).any(axis=-1))
    twice = Coded(codes, table[None], 18, 2.0 * np.eye(3, dtype=np.float32)).linear(0, 4)[0]
    assert np.array_equal(twice[1:3], 2.0 * light)
    wrong: list[Any] = [
        (codes, table[None, :200], None),
        (codes.astype(np.uint16), table[None], None),
        (codes[..., :2] if channels == 3 else codes[..., 0], table[None], None),
        (codes, np.stack([table, table]), None),
        (codes, table[None].astype(np.float64), None),
        (codes, table[None], np.eye(2, dtype=np.float32)),
    ]
    for codes_, tables, matrix in wrong:
        with pytest.raises(TypeError):
            Coded(codes_, tables, 18, matrix)


def test_grey_and_turned_photographs_wait_as_codes(tmp_path: Path) -> None:
    from engine.capture.photograph.decode import read_photograph

    grey = (np.arange(40 * 30) % 251).astype(np.uint8).reshape(40, 30)
    cv2.imwrite(str(tmp_path / "grey.png"), grey)
    for orientation in (1, 6):
        photograph = read_photograph(tmp_path / "grey.png", orientation=orientation, keep_codes=True)
        assert photograph.coded is not None
        light, saturated = photograph.coded.linear(0, len(photograph.radiance))
        assert photograph.coded.codes.shape[2] == 1
        assert np.array_equal(light, photograph.radiance)
        assert np.array_equal(saturated, photograph.saturated)


@pytest.mark.parametrize("name", ["grey.png", "colours.tif", "turned.tif"])
def test_photographs_have_the_same_bits_while_memory_is_limited(tmp_path: Path, name: str) -> None:
    from engine.capture.photograph.decode import read_photograph

    codes = np.random.default_rng(1).integers(0, 1 << 16, (40, 30, 3), np.uint16)
    cv2.imwrite(str(tmp_path / "grey.png"), codes[..., 0])
    write_tiff16(tmp_path / "colours.tif", codes, transfer="srgb")
    write_tiff16(tmp_path / "turned.tif", codes, transfer="linear")
    orientation = 6 if name == "turned.tif" else 0
    plain = read_photograph(tmp_path / name, orientation=orientation)
    with keep_in_memory(0):
        limited = read_photograph(tmp_path / name, orientation=orientation, keep_codes=True)
        halved = read_photograph(tmp_path / name, orientation=orientation, half_size=True)
    assert np.array_equal(limited.radiance, plain.radiance)
    assert np.array_equal(limited.saturated, plain.saturated)
    assert limited.coded is not None
    assert (limited.largest_code, limited.warnings, limited.credits) == (
        plain.largest_code,
        plain.warnings,
        plain.credits,
    )
    assert np.array_equal(halved.radiance, halve_image(plain.radiance, plain.saturated)[0])


def test_more_photographs_are_decoded_at_once_where_their_arrays_lie_on_the_disk(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(decode, "CHILDREN", 8)
    monkeypatch.setattr(decode, "thread_count", lambda: 8)
    assert decode.count_at_once(24_000_000, 4 << 30) == 2
    with keep_in_memory(0):
        assert decode.count_at_once(24_000_000, 4 << 30) == 7
        assert decode.count_at_once(150_000_000, 4 << 30) == 1


def test_codes_that_wait_keep_nothing_else_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The decoder answers in one piece of memory, of which a small view would keep all for every photograph."""
    kept: list[Coded] = []

    def keep(coded: Coded, calibrate: Any) -> CodedPixels:
        kept.append(coded)
        return CodedPixels(coded, calibrate)

    monkeypatch.setattr(module, "CodedPixels", keep)
    sources = find([write(render(Capture(seed=8, file_format="jpg", **SMALL)), tmp_path / "photographs")])
    drain(import_stack(sources, ImportSettings(calibrate=("gains",)), tmp_path / "stack"))
    assert len(kept) == SMALL["lamps"]
    assert all(coded.tables.base is None for coded in kept)
    assert all(coded.matrix is None or coded.matrix.base is None for coded in kept)
