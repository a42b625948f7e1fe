"""Crop, rectification, size and control points through a whole import."""

from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np
import pytest

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.registration.framing import Framing, homography
from engine.capture.registration.framing import crop as crop_to_size
from engine.capture.registration.warp import Region
from engine.core.errors import InputError
from engine.core.steps import drain

FIELDS, FIELD_PX, FINE = 8, 30, 4
HEIGHT, WIDTH = 320, 400
CORNERS = np.array([[61.3, 40.2], [330.8, 55.7], [360.1, 290.4], [40.6, 272.9]])


def board(corners: Any) -> Any:
    """Luminance of a chequerboard between `corners`, as the mean of fine samples per pixel, on grey."""
    unit = np.array([[0, 0], [FIELDS, 0], [FIELDS, FIELDS], [0, FIELDS]], float)
    row, column = (np.mgrid[: HEIGHT * FINE, : WIDTH * FINE] + 0.5) / FINE - 0.5
    there = np.stack([column, row, np.ones_like(row)], -1) @ homography(corners, unit).T
    x, y = there[..., 0] / there[..., 2], there[..., 1] / there[..., 2]
    inside = (x > 0) & (x < FIELDS) & (y > 0) & (y < FIELDS)
    light = np.where(inside, np.where((np.floor(x) + np.floor(y)) % 2 == 0, 0.9, 0.1), 0.4)
    return light.reshape(HEIGHT, FINE, WIDTH, FINE).mean(axis=(1, 3))


def photograph(folder: Path, images: Any, toml: Any = ()) -> Path:
    """Linear PNG files of the images, brighter with the elevation of the light, with their `capture.toml`."""
    folder.mkdir()
    lines = ['transfer = "linear"', *toml]
    for number, image in enumerate(images):
        codes = np.rint(np.repeat((0.5 + 0.1 * number) * image[..., None], 3, axis=2) * 65535).astype(np.uint16)
        (folder / f"p{number}.png").write_bytes(cv2.imencode(".png", codes)[1].tobytes())
    (folder / "capture.toml").write_text("\n".join(lines))
    return folder


def import_capture(folder: Path, **settings: Any) -> Any:
    sources = find([folder], [20 + 20 * number for number in range(len(list(folder.glob("*.png"))))])
    return drain(import_stack(sources, ImportSettings(**settings), folder.parent / "stack"))


def edges(profile: Any) -> Any:
    """The positions where the profile crosses its middle, in pixels."""
    over = profile - (profile.max() + profile.min()) / 2
    at = np.flatnonzero(over[:-1] * over[1:] < 0)
    return at + over[at] / (over[at] - over[at + 1])


@pytest.fixture(scope="module")
def boards(tmp_path_factory: pytest.TempPathFactory) -> Any:
    shifts = ((0.0, 0.0), (2.4, -1.3), (-1.7, 0.6))
    return photograph(tmp_path_factory.mktemp("boards") / "photographs", [board(CORNERS + move) for move in shifts])


def test_a_tilted_chequerboard_comes_out_straight_in_every_photograph(boards: Any) -> None:
    reference = import_capture(boards, motion="translation").provenance["aligned_to"]
    shift = {"p0.png": (0.0, 0.0), "p1.png": (2.4, -1.3), "p2.png": (-1.7, 0.6)}[reference]
    wanted = Framing(cast(Any, tuple(map(tuple, CORNERS + shift))), FIELDS * FIELD_PX, FIELDS * FIELD_PX)
    stack = import_capture(boards, motion="translation", framing=wanted)
    assert stack.radiance.shape == (3, FIELDS * FIELD_PX, FIELDS * FIELD_PX, 3)
    expected = np.arange(1, FIELDS) * FIELD_PX - 0.5
    for image in stack.radiance[:, :, :, 1]:
        for middle in range(FIELD_PX // 2, FIELDS * FIELD_PX, FIELD_PX):
            for profile in (image[middle], image[:, middle]):
                assert np.abs(edges(profile[4:-4]) + 4 - expected).max() <= 0.1
    assert stack.provenance["crop_px"] is None
    assert stack.provenance["framing"]["corners_px"] == (CORNERS + shift).tolist()


def test_corners_alone_become_a_image_of_their_own_size(boards: Any) -> None:
    stack = import_capture(boards, motion="none", framing=((60, 40), (330, 40), (330, 220), (60, 220)))
    assert stack.radiance.shape[1:3] == (180, 270)
    assert stack.provenance["framing"]["width_px"] == 270


def test_a_crop_keeps_every_bit_and_a_smaller_one_the_mean(boards: Any) -> None:
    whole = import_capture(boards, motion="none").radiance[:]
    crop = import_capture(boards, motion="none", framing=crop_to_size(Region(11, 7, 301, 203)))
    assert np.array_equal(crop.radiance, whole[:, 7:210, 11:312])
    small = import_capture(boards, motion="none", framing=crop_to_size(Region(11, 7, 300, 200), 100, 50))
    blocks = whole[:, 7:207, 11:311].reshape(3, 50, 4, 100, 3, 3).mean(axis=(2, 4))
    assert np.abs(small.radiance[:] - blocks).mean() < 0.005
    assert small.radiance[:].mean() == pytest.approx(float(blocks.mean()), rel=1e-3)


def test_frames_beyond_a_photograph_and_impossible_ones_are_refused(boards: Any) -> None:
    with pytest.raises(InputError, match="beyond what all"):
        import_capture(boards, motion="none", framing=crop_to_size(Region(200, 7, 300, 200)))
    with pytest.raises(ValueError, match="clockwise"):
        ImportSettings(framing=cast(Any, tuple(map(tuple, CORNERS[::-1]))))
    with pytest.raises(ValueError, match="both"):
        ImportSettings(crop=(0, 0, 9, 9), framing=cast(Any, tuple(map(tuple, CORNERS))))


def texture(seed: int, right: int = 0, down: int = 0) -> Any:
    """A random texture around 0.4, seen `right` and `down` pixels further."""
    noise = np.random.default_rng(seed).normal(size=(HEIGHT + 40, WIDTH + 40)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), 2.0)
    return 0.4 + 0.05 * (smooth / smooth.std())[20 - down : 20 - down + HEIGHT, 20 - right : 20 - right + WIDTH]


ENTRY = '[[photographs]]\nfile = "p{}.png"\nelevation_deg = {}'
POINTS = "control_points = [[10, 10, 15, 8], [300, 20, 305, 18], [200, 250, 205, 248]]"


def refuse(folder: Path, reference: Any) -> Any:
    """The last photograph is unlike the others, and moved by (5, -2)."""
    toml = [f'reference = "{reference}"', *(ENTRY.format(n, 20 + 20 * n) for n in range(3)), POINTS]
    images = [texture(1), texture(1, 3, 1), texture(2, 5, -2)]
    return photograph(folder, images, toml)


def test_control_points_of_the_capture_file_move_what_alignment_refuses(tmp_path: Path) -> None:
    folder = refuse(tmp_path / "photographs", "p0.png")
    stack = import_capture(folder, motion="translation")
    assert stack.provenance["aligned_to"] == "p0.png"
    assert len(stack.provenance["control_points_px"]["p2.png"]) == 3
    matrix = np.reshape(stack.provenance["photographs"][2]["alignment_matrix"], (3, 3))
    assert np.allclose(matrix, [[1, 0, 5], [0, 1, -2], [0, 0, 1]], atol=1e-9)
    assert not any(finding.source == "p2.png" and "aligned" in finding.text for finding in stack.health.findings)
    left, top = stack.provenance["crop_px"][:2]
    height, width = stack.radiance.shape[1:3]
    expected = 0.7 * texture(2)[top : top + height, left : left + width]
    assert np.abs(stack.radiance[2, :, :, 1] - expected).max() < 1e-4
    (folder / "capture.toml").write_text('transfer = "linear"\nreference = "p0.png"')
    stack = import_capture(folder, motion="translation")
    assert stack.quality[2].alignment_residual_px is None


def test_control_points_without_alignment_and_in_the_reference(tmp_path: Path) -> None:
    stack = import_capture(refuse(tmp_path / "a", "p1.png"), motion="none")
    assert stack.provenance["aligned_to"] == "p1.png"
    assert stack.provenance["crop_px"] == [0, 2, WIDTH - 5, HEIGHT - 2]
    with pytest.raises(InputError, match=r"control points for p2\.png"):
        import_capture(refuse(tmp_path / "b", "p2.png"), motion="none")
    with pytest.raises(InputError, match=r"names other\.png"):
        import_capture(refuse(tmp_path / "c", "other.png"))


def test_control_points_that_tear_the_photographs_apart_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no pixel is seen by all"):
        import_capture(refuse(tmp_path / "a", "p0.png"), motion="none", control_points={"p2.png": [[0, 0, 9000, 0]]})


def test_points_of_the_capture_file_are_taken_away_by_none(tmp_path: Path) -> None:
    stack = import_capture(refuse(tmp_path / "a", "p0.png"), motion="translation", control_points={"p2.png": ()})
    assert stack.provenance["control_points_px"] == {}
    assert stack.quality[2].alignment_residual_px is None
