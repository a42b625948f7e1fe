"""Films: what is written is read again, frame by frame."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from engine.core.errors import UsageError
from engine.images.animation import film, kind_of
from engine.images.decode import read_image

COLOURS = ((200, 30, 40), (30, 180, 60), (40, 50, 210))


def frame(colour: tuple[int, int, int], opacity: int | None = None) -> np.ndarray:
    whole = np.zeros((48, 65, 3 if opacity is None else 4), np.uint8)
    whole[:, :, :3] = colour
    if opacity is not None:
        whole[:, :, 3] = opacity * np.tri(48, 65, 10, dtype=np.uint8)[:, ::-1]
    return whole


def test_an_mp4_has_the_frames_in_their_order_and_time(tmp_path: Path) -> None:
    with film(tmp_path / "turn.mp4", (65, 48), 12.0) as keep:
        for colour in COLOURS:
            keep(frame(colour))
    read = cv2.VideoCapture(str(tmp_path / "turn.mp4"))
    found = []
    while (got := read.read())[0]:
        found.append(got[1][24, 30, ::-1].astype(int))
    assert read.get(cv2.CAP_PROP_FPS) == 12.0
    assert (read.get(cv2.CAP_PROP_FRAME_WIDTH), read.get(cv2.CAP_PROP_FRAME_HEIGHT)) == (64.0, 48.0)
    assert np.abs(np.array(found) - COLOURS).max() < 12


def test_a_webp_loops_and_keeps_its_opacity(tmp_path: Path) -> None:
    with film(tmp_path / "turn.webp", (65, 48), 25.0) as keep:
        for colour in COLOURS:
            keep(frame(colour, 255))
    with Image.open(tmp_path / "turn.webp") as read:
        count = getattr(read, "n_frames", 1)
        assert (count, read.info["loop"], read.size) == (3, 0, (65, 48))
        for number, colour in enumerate(COLOURS):
            read.seek(number)
            pixels = np.asarray(read.convert("RGBA")).astype(int)
            assert np.abs(pixels[24, 50, :3] - colour).max() < 12
            assert (pixels[24, 10, 3], pixels[24, 50, 3]) == (0, 255)


def test_a_folder_has_a_image_for_each_frame(tmp_path: Path) -> None:
    with film(tmp_path / "turn", (65, 48), 30.0) as keep:
        for colour in COLOURS:
            keep(frame(colour))
    names = sorted(path.name for path in (tmp_path / "turn").glob("*.png"))
    assert names == ["frame-00000.png", "frame-00001.png", "frame-00002.png"]
    assert read_image(tmp_path / "turn" / names[1]).pixels.shape[:2] == (48, 65)


@pytest.mark.parametrize("name", ["turn.mp4", "turn.webp", "turn"])
def test_a_film_that_fails_leaves_nothing(tmp_path: Path, name: str) -> None:
    def find_broken() -> None:
        with film(tmp_path / name, (65, 48), 30.0) as keep:
            keep(frame(COLOURS[0]))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        find_broken()
    assert list(tmp_path.iterdir()) == []


def test_other_endings_are_refused() -> None:
    with pytest.raises(UsageError, match=r"\.gif"):
        kind_of("turn.gif")
