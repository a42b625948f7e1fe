"""Angles that nobody stated, held against the light; photographs of no use, left out or refused."""

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.capture.doubts import RISING, Doubtful, rising_share
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.selection import Listed
from engine.capture.lights.sources import find
from engine.capture.photograph.decode import Unreadable
from engine.capture.stack import ImageStack
from engine.core.errors import InputError
from engine.core.steps import drain

NOISE = cv2.GaussianBlur(np.random.default_rng(4).normal(size=(60, 80)).astype(np.float32), (0, 0), 1.5)


@pytest.fixture
def folder(tmp_path: Path) -> Callable[..., Path]:
    def make(levels: dict[str, float]) -> Path:
        place = tmp_path / "photographs"
        place.mkdir()
        for name, level in levels.items():
            codes = np.clip(level * (1 + NOISE), 0, 255).astype(np.uint8)
            (place / name).write_bytes(cv2.imencode(Path(name).suffix, codes)[1].tobytes())
        return place

    return make


def import_capture(place: Path, **choices: Any) -> ImageStack:
    settings = ImportSettings(motion="none", **choices)
    return drain(import_stack(find([place]), settings, place.parent / "stack"))


def levels(names: str, numbers: Any, light: Any) -> dict[str, float]:
    return {names.format(number): float(level) for number, level in zip(numbers, light, strict=True)}


def test_frame_numbers_are_no_angles_where_the_light_contradicts(folder: Callable[..., Path]) -> None:
    """Ten frames of a dome, 8 apart, whose lamps come in any order."""
    place = folder(levels("IMG_{:02d}.png", range(12, 90, 8), [90, 40, 160, 60, 30, 120, 80, 150, 50, 100]))
    with pytest.raises(Doubtful, match="bare numbers in the file names") as refused:
        import_capture(place)
    assert "--angles-deg" in refused.value.remedy
    assert not (place.parent / "stack").exists()
    stack = import_capture(place, trust_angles=True)
    assert stack.angle_source == "file names"
    assert any("a user said so" in warning for warning in stack.health.warnings)


def test_bare_numbers_are_angles_where_the_light_grows_with_them(folder: Callable[..., Path]) -> None:
    angles = np.arange(10, 91, 10)
    stack = import_capture(folder(levels("suede_{}.png", angles, 20 + 150 * np.sin(np.radians(angles)))))
    assert stack.elevation_deg.tolist() == angles.tolist()
    assert any("as they do on an arc" in finding.text for finding in stack.health.findings)


def test_angles_with_a_unit_are_believed(folder: Callable[..., Path]) -> None:
    stack = import_capture(folder(levels("suede_{}deg.png", (10, 40, 70), (150, 60, 90))))
    assert stack.elevation_deg.tolist() == [10.0, 40.0, 70.0]


def test_a_random_order_rarely_passes() -> None:
    elevation = np.arange(6.0)
    shares = [rising_share(elevation, np.array(order)) for order in itertools.permutations(range(6))]
    assert sum(share >= RISING for share in shares) == 20
    assert rising_share(np.zeros(3), np.arange(3.0)) == 1.0


@pytest.mark.parametrize("names", ["p_{}deg.png", "p_{}deg.tif"])
def test_a_photograph_cut_short_is_left_out_with_its_reason(folder: Callable[..., Path], names: str) -> None:
    place = folder(levels(names, (10, 30, 50, 70), (40, 80, 120, 160)))
    broken = place / names.format(50)
    broken.write_bytes(broken.read_bytes()[:-300])
    stack = import_capture(place)
    assert stack.elevation_deg.tolist() == [10.0, 30.0, 70.0]
    assert broken.name not in stack.sources
    (said,) = [finding for finding in stack.health.findings if finding.source == broken.name]
    assert "was excluded: it" in said.text
    with pytest.raises(Doubtful, match="the other 3 photographs") as refused:
        import_capture(place, strict=True)
    assert (refused.value.consent, refused.value.path) == ("leave_out", str(broken))


def test_no_photographs_are_left_out_where_few_would_remain(folder: Callable[..., Path]) -> None:
    place = folder(levels("p_{}deg.png", (10, 20, 30, 40, 50), (40, 80, 100, 120, 160)))
    for name in ("p_10deg.png", "p_50deg.png"):
        (place / name).write_bytes(b"nothing")
    with pytest.raises(Unreadable):
        import_capture(place)
    assert sorted(path.name for path in place.parent.iterdir()) == ["photographs"]


def test_only_reading_leaves_a_photograph_out(folder: Callable[..., Path]) -> None:
    place = folder(levels("p_{}deg.png", (10, 30, 50, 70), (40, 80, 120, 160)))
    (place / "p_50deg.png").write_bytes(cv2.imencode(".png", np.zeros((10, 10), np.uint8))[1].tobytes())
    with pytest.raises(InputError, match="60 px"):
        import_capture(place)


ANGLES = (3, 10, 30, 50, 70, 90)
SINES = 200 * np.sin(np.radians(ANGLES))


@pytest.mark.parametrize(("place", "level", "says"), [(4, 0, "it is black"), (2, 9000, "it is overexposed")])
def test_a_photograph_that_shows_nothing_is_left_out(
    folder: Callable[..., Path], place: int, level: float, says: str
) -> None:
    light = [level if at == place else each for at, each in enumerate(SINES)]
    photographs = folder(levels("p_{}deg.png", ANGLES, light))
    name = f"p_{ANGLES[place]}deg.png"
    stack = import_capture(photographs)
    assert stack.elevation_deg.tolist() == [float(angle) for angle in ANGLES if angle != ANGLES[place]]
    (said,) = [finding for finding in stack.health.findings if finding.source == name]
    assert says in said.text
    assert said.sentence in stack.health.warnings
    with pytest.raises(Doubtful, match="the other 5 photographs") as refused:
        import_capture(photographs, strict=True)
    assert (refused.value.consent, refused.value.otherwise) == ("leave_out", "use_all")
    assert Path(refused.value.path).name == name
    assert len(import_capture(photographs, use_all=True).sources) == 6


@pytest.mark.parametrize("brightness", [1.0, 0.02])
def test_dark_photographs_of_grazing_lamps_and_dark_captures_are_kept(
    folder: Callable[..., Path], brightness: float
) -> None:
    assert len(import_capture(folder(levels("p_{}deg.png", ANGLES, brightness * SINES))).sources) == 6


def test_what_was_chosen_for_a_photograph_goes_with_it(folder: Callable[..., Path]) -> None:
    light = [0 if at == 3 else each for at, each in enumerate(SINES)]
    place = folder(levels("p_{}deg.png", ANGLES, light))
    stack = import_capture(place, lights=Listed(("2-6",)), reference="p_50deg.png")
    assert stack.elevation_deg.tolist() == [10.0, 30.0, 70.0, 90.0]


def test_all_are_used_where_many_show_nothing(folder: Callable[..., Path]) -> None:
    light = [0 if at in (1, 4) else each for at, each in enumerate(SINES)]
    stack = import_capture(folder(levels("p_{}deg.png", ANGLES, light)), trust_angles=True)
    assert len(stack.sources) == 6
    assert sum("are black" in warning for warning in stack.health.warnings) == 2
