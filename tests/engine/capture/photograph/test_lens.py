"""Distortion of a lens: found on drawn photographs of a board, taken off, and kept in a file."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.photograph.lens import Lens, lens_of_boards, read_lens, save_lens
from engine.core.errors import InputError
from engine.core.steps import drain

WIDTH, HEIGHT = 480, 360
TRUTH = Lens(WIDTH, HEIGHT, (520.0, 520.0, 243.0, 176.0), (-0.18, 0.05, 0.001, -0.0008, 0.0), 0.0, 0)


@cache
def _straight(lens: Lens, fine: int) -> tuple[np.ndarray, np.ndarray]:
    """Places without distortion of a grid with `fine` points across each pixel."""
    rows, columns = np.mgrid[: fine * HEIGHT, : fine * WIDTH]
    return undistorted(lens, (columns + 0.5) / fine - 0.5, (rows + 0.5) / fine - 0.5)


def undistorted(lens: Lens, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points without distortion of points in a photograph, by OpenCV."""
    fx, fy, cx, cy = lens.camera
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    points = np.stack([x.ravel(), y.ravel()], axis=1)[:, None].astype(np.float64)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-9)
    found = cv2.undistortPoints(points, matrix, np.array(lens.distortion), P=matrix, criteria=criteria).reshape(-1, 2)
    return found[:, 0].reshape(x.shape), found[:, 1].reshape(x.shape)


def board(lens: Lens, tilt: tuple[float, float], at: tuple[float, float, float]) -> np.ndarray:
    """A photograph of a board of 10 × 8 squares of one unit, in 8-bit levels."""
    fine = 3
    x, y = _straight(lens, fine)
    fx, fy, cx, cy = lens.camera
    ray = np.stack([(x - cx) / fx, (y - cy) / fy, np.ones_like(x)], axis=-1)
    turn = cv2.Rodrigues(np.array([*tilt, 0.1]))[0]
    normal, origin = turn[:, 2], np.array(at)
    reach = (origin @ normal) / (ray @ normal)
    inside = (ray * reach[..., None] - origin) @ turn
    u, v = inside[..., 0] + 5.0, inside[..., 1] + 4.0
    square = (np.floor(u) + np.floor(v)) % 2
    shown = np.where((u > -0.7) & (u < 10.7) & (v > -0.7) & (v < 8.7), 0.9, 0.4)
    shown = np.where((u > 0) & (u < 10) & (v > 0) & (v < 8), 0.1 + 0.8 * square, shown)
    small = shown.reshape(HEIGHT, fine, WIDTH, fine).mean(axis=(1, 3))
    return np.rint(255 * small).astype(np.uint8)


POSITIONS = [
    ((0.0, 0.0), (0.0, 0.0, 14.0)),
    ((0.4, 0.0), (-2.2, -1.2, 15.0)),
    ((-0.4, 0.1), (2.2, 1.2, 15.0)),
    ((0.0, 0.45), (2.4, -1.2, 16.0)),
    ((0.1, -0.45), (-2.2, 1.3, 16.0)),
    ((0.3, 0.3), (0.0, 0.0, 13.0)),
]


def test_a_board_tells_the_lens_and_its_file_keeps_it(tmp_path: Path) -> None:
    images = [board(TRUTH, *each) for each in POSITIONS]
    found = lens_of_boards(images, tmp_path)
    x, y = np.meshgrid(np.linspace(20, WIDTH - 20, 9), np.linspace(20, HEIGHT - 20, 7))
    straight = undistorted(found, *TRUTH.distort(x, y))
    # up to a projective map, by which a camera may look elsewhere
    before, after = (np.stack([each.ravel() for each in pair], axis=1) for pair in ((x, y), straight))
    matrix, _ = cv2.findHomography(before, after)
    left = np.hypot(*(cv2.perspectiveTransform(before[None], matrix)[0] - after).T)
    assert TRUTH.largest_shift_px() > 12.0
    assert left.max() < 0.4
    assert found.boards == len(POSITIONS)
    save_lens(tmp_path / "a.lens", found.as_json())
    assert read_lens(tmp_path / "a.lens").as_json() == found.as_json()
    for change in ({"distortion": [9.0, 0, 0, 0, 0]}, {"camera_px": [0, 1, 2, 3]}, {"width_px": -1}, {"more": 1}):
        (tmp_path / "b.lens").write_text(json.dumps({**found.as_json(), **change}))
        with pytest.raises(InputError, match=r"no lens has|does not hold a lens"):
            read_lens(tmp_path / "b.lens")
    with pytest.raises(InputError, match="in 2 photographs only"):
        lens_of_boards(images[:2], tmp_path)
    with pytest.raises(InputError, match="of the way to the corners"):
        lens_of_boards([board(TRUTH, tilt, (0.0, 0.0, 30.0)) for tilt, _ in POSITIONS[:5]], tmp_path)


def test_photographs_are_straightened_before_they_are_aligned(tmp_path: Path) -> None:
    """Radiance that is linear in the position stays linear in that of the straight image."""
    folder = tmp_path / "c"
    folder.mkdir()
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    x, y = undistorted(TRUTH, columns.astype(float), rows.astype(float))
    for angle in (20, 40, 60):
        image = angle / 90 * (0.2 + 0.4 * x / WIDTH + 0.3 * y / HEIGHT)
        cv2.imwrite(str(folder / f"x_{angle}deg.tif"), np.repeat(image[..., None], 3, axis=2).astype(np.float32))
    save_lens(tmp_path / "a.lens", replace(TRUTH, boards=6).as_json())
    settings = ImportSettings(motion="none", lens=tmp_path / "a.lens")
    stack = drain(import_stack(find([folder]), settings, tmp_path / "s"))
    wanted = 40 / 90 * (0.2 + 0.4 * columns / WIDTH + 0.3 * rows / HEIGHT)
    clipped = np.asarray(stack.saturated[1])
    assert np.abs(np.asarray(stack.radiance[1])[..., 0] - wanted)[~clipped].max() < 1e-3
    assert clipped.mean() < 0.01
    assert stack.provenance["lens"]["distortion"] == list(TRUTH.distortion)
    assert any("The lens moved points" in each.text for each in stack.health.findings)
    save_lens(tmp_path / "b.lens", replace(TRUTH, width=800).as_json())
    with pytest.raises(InputError, match="the lens was measured in photographs of 800"):
        drain(import_stack(find([folder]), ImportSettings(motion="none", lens=tmp_path / "b.lens"), tmp_path / "t"))
