"""Masks of captures: from a file and from alpha, through the import to the surface."""

from __future__ import annotations

import dataclasses
from collections import deque
from pathlib import Path

import cv2
import numpy as np
import pytest

from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.mask import mask_of, pack
from engine.capture.object_outline import ObjectOutline, simplify_outline
from engine.capture.stack import ImageStack
from engine.core.errors import InputError, UsageError
from engine.core.steps import drain
from engine.surface.recover import recover
from tests.engine.capture.calibration.generated import Capture, render, write

CAPTURE = Capture(seed=5, height=40, width=48, lamps=9, file_format="png16")


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(render(CAPTURE), tmp_path_factory.mktemp("capture") / "photographs")


def disc() -> np.ndarray:
    row, column = np.mgrid[:40, :48]
    return np.asarray((column - 20) ** 2 + (row - 22) ** 2 < 150)


def bring_in(photographs: Path, folder: Path, **settings: object) -> ImageStack:
    chosen = ImportSettings(calibrate="none", motion="none", **settings)  # type: ignore[arg-type]
    return drain(import_stack(find([photographs]), chosen, folder))


def test_a_mask_file_goes_the_way_of_the_photographs(photographs: Path, tmp_path: Path) -> None:
    drawn = tmp_path / "drawn.png"
    cv2.imwrite(str(drawn), np.uint8(255) * disc().astype(np.uint8))
    stack = bring_in(photographs, tmp_path / "stack", mask=drawn, crop=(6, 4, 36, 30))
    found = mask_of(stack)
    assert found is not None
    np.testing.assert_array_equal(found, disc()[4:34, 6:42])
    surface = drain(recover(stack, np.arange(9), left_out=False))
    assert surface.maps.mask is not None
    np.testing.assert_array_equal(surface.maps.mask > 0.0, found)
    plain = drain(recover(dataclasses.replace(stack, provenance={}), np.arange(9), left_out=False))
    assert plain.maps.mask is None
    apart = np.degrees(np.arccos(np.clip((surface.maps.normal * plain.maps.normal).sum(axis=-1), -1.0, 1.0)))
    assert np.median(apart[found]) < 0.5
    assert (surface.maps.base_colour[~found] == 0.0).all()


def test_an_outline_goes_the_way_of_the_photographs(photographs: Path, tmp_path: Path) -> None:
    """A rectangle from pixel 8 to 30 and 10 to 25, both with their own pixels, cut by the crop."""
    outline = ObjectOutline(((7.5, 9.5), (30.5, 9.5), (30.5, 25.5), (7.5, 25.5)))
    stack = bring_in(photographs, tmp_path / "stack", mask=outline, crop=(6, 4, 36, 30))
    found = mask_of(stack)
    assert found is not None
    wanted = np.zeros((40, 48), np.bool_)
    wanted[10:26, 8:31] = True
    assert np.count_nonzero(found != wanted[4:34, 6:42]) <= 23 + 16 + 2  # pixels that its edge touches belong to it
    outside = ObjectOutline(((100.0, 100.0), (140.0, 100.0), (140.0, 140.0)))
    with pytest.raises(UsageError, match="leaves nothing"):
        bring_in(photographs, tmp_path / "none", mask=outside)


@pytest.mark.parametrize("points", [(), ((0.0, 0.0), (1.0, 1.0)), ((0.0, 0.0), (1.0, 1.0), (1e9, 0.0))])
def test_an_outline_that_is_none_is_refused(points: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(UsageError):
        ObjectOutline(points)


def test_long_paths_keep_their_shape_in_few_points() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 20_000)
    outline = simplify_outline([(1000.0 + 900.0 * np.cos(t), 900.0 * np.sin(t)) for t in turn])
    assert outline is not None
    assert len(outline.points) < 500
    area = cv2.contourArea(np.array(outline.points, np.float32))
    assert area == pytest.approx(np.pi * 900.0**2, rel=2e-3)


def test_the_alpha_of_photographs_is_their_mask(photographs: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut"
    cut.mkdir()
    for file in photographs.iterdir():
        if file.suffix != ".png":
            (cut / file.name).write_bytes(file.read_bytes())
            continue
        pixels = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
        assert pixels is not None
        cv2.imwrite(str(cut / file.name), np.dstack([pixels, np.uint16(65535) * disc().astype(np.uint16)]))
    found = mask_of(bring_in(cut, tmp_path / "stack", mask="alpha"))
    np.testing.assert_array_equal(found, disc())
    with pytest.raises(InputError, match="no alpha channel"):
        bring_in(photographs, tmp_path / "other", mask="alpha")


def test_masks_of_another_size_or_without_an_object_are_refused(photographs: Path, tmp_path: Path) -> None:
    for values, words in ((np.full((30, 48), 255), "48 × 30 pixels"), (np.zeros((40, 48)), "leaves nothing")):
        drawn = tmp_path / "drawn.png"
        cv2.imwrite(str(drawn), values.astype(np.uint8))
        settings = ImportSettings(calibrate="none", motion="none", mask=drawn)
        notes: deque[str] = deque()
        with pytest.raises(InputError, match=words):
            notes.extend(step.note for step in import_stack(find([photographs]), settings, tmp_path / "stack"))
        assert not (tmp_path / "stack").exists()
        assert not any(note.startswith("Reading 2 of") for note in notes)  # refused before minutes of reading


def test_a_damaged_mask_is_refused(photographs: Path, tmp_path: Path) -> None:
    stack = bring_in(photographs, tmp_path / "stack")
    assert mask_of(stack) is None
    for packed in ("%%%", pack(np.ones((4, 4), np.bool_)), pack(np.ones((400, 400), np.bool_)), 7):
        with pytest.raises(InputError, match="damaged mask"):
            mask_of(dataclasses.replace(stack, provenance={"mask": packed}))
