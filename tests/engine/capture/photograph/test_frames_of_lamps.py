"""Flat fields and dark frames of each lamp, against the closed form of a near, unequal lamp in a lit room."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.core.errors import InputError
from engine.core.steps import drain

SIZE, DISTANCE = 40, 1.6


def write(folder: Path, names: list[str], images: list[np.ndarray]) -> Path:
    folder.mkdir(exist_ok=True)
    for name, image in zip(names, images, strict=True):
        assert cv2.imwrite(str(folder / name), image[..., ::-1].astype(np.float32))
    return folder


@pytest.mark.parametrize("named", [True, False])
def test_frames_of_each_lamp_take_off_its_intensity_fall_off_and_room_light(tmp_path: Path, named: bool) -> None:
    """What is left is ρ n·v, v = l − p / D of equal lamps, to a common factor."""
    random = np.random.default_rng(2)
    place = (np.arange(SIZE) + 0.5) / SIZE - 0.5
    ground = np.stack(np.broadcast_arrays(place[None, :], -place[:, None], 0.0), axis=-1) / DISTANCE
    albedo = random.uniform(0.1, 0.6, (SIZE, SIZE, 3))
    slope = 0.3 * random.standard_normal((SIZE, SIZE, 2))
    normal = np.dstack([slope, np.ones((SIZE, SIZE))])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    names, photographs, flats, darks, wanted, lines = [], [], [], [], [], []
    for number, (rise, around, gain) in enumerate(
        zip((25, 35, 45, 55, 65, 75), range(0, 360, 60), (1, 0.5, 0.7, 1.3, 0.9, 1.1), strict=True)
    ):
        up, turn = np.radians(rise), np.radians(around)
        light = np.array([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)])
        towards = light - ground
        lit = gain / np.linalg.norm(towards, axis=-1) ** 3
        room = random.uniform(0.02, 0.05, (SIZE, SIZE, 3))
        shown = albedo * np.maximum((normal * towards).sum(axis=-1), 0.0)[..., None]
        photographs.append(0.5 * lit[..., None] * shown + room)
        flats.append(0.5 * 0.8 * lit[..., None] * towards[..., 2:] + room)
        darks.append(room)
        wanted.append(shown)
        names.append(f"photo_{number}.tif")
        lines.append(f"{names[-1]} {light[0]:.9f} {light[1]:.9f} {light[2]:.9f}")
    folder = write(tmp_path / "capture", names, photographs)
    (folder / "lights.lp").write_text("\n".join([str(len(lines)), *lines]))
    frames = names if named else [f"{name[:-4]}_card.tif" for name in names]
    settings = ImportSettings(
        motion="none",
        flat=write(tmp_path / "flats", frames, flats),
        dark=write(tmp_path / "darks", frames, darks),
        lamp_distance=DISTANCE,
    )
    stack = drain(import_stack(find([folder]), settings, tmp_path / "stack"))
    order = [names.index(name) for name in stack.sources]
    ratio = np.asarray(stack.radiance[:]) / np.maximum(np.stack(wanted)[order], 1e-3)
    lit_texels = np.stack(wanted)[order] > 0.02
    assert np.ptp(ratio[lit_texels]) < 0.01 * np.median(ratio[lit_texels])
    assert stack.provenance["lamp_distance_widths"] == DISTANCE
    assert stack.provenance["flat_of_lamps"][names[0]] == frames[0]
    assert not [term for term in stack.provenance["calibration"] if term["name"] in ("gains", "distance", "ambient")]


def test_frames_that_belong_to_no_photograph_are_refused(tmp_path: Path) -> None:
    grey = [np.full((8, 8, 3), level) for level in (0.2, 0.3, 0.4)]
    folder = write(tmp_path / "c", [f"a_{angle}deg.tif" for angle in (20, 40, 60)], grey)
    flats = write(tmp_path / "f", ["x.tif", "y.tif"], grey[:2])
    with pytest.raises(InputError, match="holds 2 frames for 3 photographs"):
        drain(import_stack(find([folder]), ImportSettings(flat=flats), tmp_path / "s"))
    black = write(tmp_path / "b", [f"a_{angle}deg.tif" for angle in (20, 40, 60)], [0.0 * each for each in grey])
    with pytest.raises(InputError, match="flat field without light"):
        drain(import_stack(find([folder]), ImportSettings(flat=black), tmp_path / "s"))
