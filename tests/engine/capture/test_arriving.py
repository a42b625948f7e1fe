"""Photographs that appear one by one, as a camera writes them: late, in halves, renamed, damaged, twice."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import engine.capture.arriving as module
from engine.capture.arriving import Capture, Watching, arrive
from engine.capture.decoded import Decoded
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.stack import CODES, RECORD
from engine.core.health import Verdict
from engine.core.steps import drain
from tests.engine.capture.calibration.generated import Capture as Generated
from tests.engine.capture.calibration.generated import render, write

STILL = ImportSettings(calibrate="none")
OPTIONS: dict[str, Any] = {"white_balance": "camera", "transfer": "auto", "bands": ()}


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = Generated(seed=11, file_format="jpg", lamps=6, height=48, width=56)
    return write(render(made), tmp_path_factory.mktemp("taken") / "card")


@pytest.fixture(autouse=True)
def quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    """A photograph that stays for a moment is complete."""
    for name, seconds in (("LOOK_S", 0.002), ("STEADY_S", 0.01), ("GIVE_UP_S", 0.3)):
        monkeypatch.setattr(module, name, seconds)


class Camera:
    """What a camera does to `folder`, an action each time when the one before has been noticed."""

    def __init__(self, folder: Path, *actions: Callable[[], object], settle: Callable[[Capture], bool]) -> None:
        self.folder, self.actions, self.settle = folder, list(actions), settle
        self.seen: list[Capture] = []

    def run(self, decoded: Decoded, **more: Any) -> Capture:
        begun_s = time.monotonic()
        wishes = Watching(self.folder, **more)
        steps = arrive(decoded, wishes, lambda: not self.actions and self.settle(self.seen[-1]))
        with closing(steps):
            while True:
                assert time.monotonic() - begun_s < 60.0
                try:
                    step = next(steps)
                except StopIteration as ended:
                    return ended.value
                if step.partial is not None:
                    self.seen.append(step.partial)
                if self.actions and not (self.seen and self.seen[-1].awaited):
                    self.actions.pop(0)()


@pytest.fixture
def decoded() -> Iterator[Decoded]:
    with closing(Decoded(OPTIONS)) as kept:
        yield kept


def test_a_capture_taken_in_disorder_becomes_the_stack_of_its_folder(
    photographs: Path, decoded: Decoded, tmp_path: Path
) -> None:
    folder = tmp_path / "taken"
    folder.mkdir()
    names = sorted(path.name for path in photographs.glob("*.jpg"))
    contents = [(photographs / name).read_bytes() for name in names]
    actions: list[Callable[[], object]] = [lambda: shutil.copy(photographs / "lights.lp", folder)]

    def put(at: int, name: str, content: bytes) -> Callable[[], object]:
        return lambda: (folder / name).write_bytes(content)

    def write_on() -> None:
        with (folder / names[3]).open("ab") as file:
            file.write(contents[3][len(contents[3]) // 2 :])

    actions += [put(5, names[5], contents[5])]
    actions += [put(3, names[3], contents[3][: len(contents[3]) // 2]), lambda: None]
    camera = Camera(folder, *actions, settle=lambda seen: True)
    drained = camera.run(decoded)  # the half that never came on is unreadable
    broken = {one.path.name: one for one in drained.photographs}[names[3]]
    assert broken.thumbnail is None
    assert broken.verdict is Verdict.BAD
    assert drained.expect == 6
    assert drained.count == 1
    assert len(drained.listed) == 6
    more = [
        put(0, "tmp0.jpg", contents[0]),
        write_on,
        lambda: (folder / "tmp0.jpg").rename(folder / names[0]),
        put(1, names[1], b""),
        put(1, names[1], contents[1]),
        put(2, names[2], contents[2]),
        put(4, names[4], contents[4]),
    ]
    camera = Camera(folder, *more, settle=lambda seen: False)
    found = camera.run(decoded)
    assert found.count == 6
    assert {one.path.name for one in found.photographs} == set(names)
    assert all(one.direction is not None and one.verdict < Verdict.BAD for one in found.photographs)
    counts = [seen.coverage or 0.0 for seen in camera.seen]
    assert counts[-1] == max(counts) > counts[0]
    stack = drain(import_stack(find([folder]), STILL, tmp_path / "found"))
    decoded.close()
    again = drain(import_stack(find([folder]), STILL, tmp_path / "expected"))
    assert stack.sources == again.sources
    for name in (CODES, RECORD):
        assert (tmp_path / "found" / name).read_bytes() == (tmp_path / "expected" / name).read_bytes()


def test_photographs_are_judged_beside_those_that_are_there(tmp_path: Path, decoded: Decoded) -> None:
    made = render(Generated(seed=4, file_format="tif16", surface="grains", lamps=7, height=96, width=112))
    folder = write(made, tmp_path / "taken")
    names = list(made.names)
    images = [np.asarray(cv2.imread(str(folder / name), cv2.IMREAD_UNCHANGED)) for name in names]
    changed = {
        "blurred": (1, lambda image: cv2.GaussianBlur(image, (0, 0), 3.0)),
        "is black": (2, lambda image: image // 400),
        "same image": (3, lambda _: images[0]),
        "is shifted against": (4, lambda image: np.roll(images[0], (6, 8), (0, 1)) + np.uint16(9)),
        "clipped": (5, lambda image: np.where(image > np.median(image), np.uint16(65535), image)),
    }
    for at, change in changed.values():
        cv2.imwrite(str(folder / names[at]), change(images[at]))
    for at, name in enumerate(names):  # a minute ago, one after the other
        os.utime(folder / name, (time.time() - 60 + at,) * 2)
    found = Camera(folder, settle=lambda seen: len(seen.photographs) == 7).run(decoded)
    said = {one.path.name: " ".join(each.text for each in one.findings) for one in found.photographs}
    for words, (at, _) in changed.items():
        assert words in said[names[at]], (words, said)
    assert said[names[6]] == ""
    assert found.count == 6  # the image that is there twice counts once


def draw_button(folder: Path, lamps: int, moved: Collection[int]) -> list[str]:
    """Photographs of a glossy dome-shaped button before black under `lamps` all around, some of which are `moved`."""
    folder.mkdir()
    row, column = np.mgrid[-1.5:1.5:160j, -1.5:1.5:160j]
    inside = row**2 + column**2 < 1.0
    up = np.sqrt(np.clip(1.0 - row**2 - column**2, 0.0, None))
    normal = np.stack([column, -row, up], axis=-1)
    grain = np.random.default_rng(1).uniform(0.8, 1.0, inside.shape)
    lines, names = [str(lamps)], [f"{at:02}.png" for at in range(lamps)]
    for at, name in enumerate(names):
        azimuth, elevation = 2.4 * at, np.radians(25.0 + 40.0 * at / lamps)
        lamp = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
        half = lamp + np.array([0.0, 0.0, 1.0])
        half /= np.linalg.norm(half)
        shaded = 0.15 * np.clip(normal @ lamp, 0.0, None) * grain + 0.8 * np.clip(normal @ half, 0.0, None) ** 60
        codes = (255.0 * np.clip(inside * shaded, 0.0, 1.0) ** (1.0 / 2.2)).astype(np.uint8)
        cv2.imwrite(str(folder / name), np.roll(codes, (12, -16) if at in moved else 0, (0, 1)))
        lines.append("{} {:.6f} {:.6f} {:.6f}".format(name, *lamp))
        os.utime(folder / name, (time.time() - 60 + at,) * 2)
    (folder / "lights.lp").write_text("\n".join(lines))
    return names


@pytest.mark.parametrize("moved", [(), (19,), range(15, 24)], ids=["still", "one", "from one on"])
def test_highlights_that_move_with_the_lamp_are_no_motion(
    tmp_path: Path, decoded: Decoded, moved: Collection[int]
) -> None:
    names = draw_button(tmp_path / "taken", 24, moved)
    found = Camera(tmp_path / "taken", settle=lambda seen: len(seen.photographs) == len(names)).run(decoded)
    assert tell_shifted(found) == {names[at] for at in moved}


def test_a_list_that_comes_after_its_photographs_tells_highlights_from_motions(
    tmp_path: Path, decoded: Decoded
) -> None:
    names = draw_button(tmp_path / "taken", 24, (19,))
    listed = tmp_path / "taken" / "lights.lp"
    lines = listed.read_text()
    listed.unlink()

    def settle(seen: Capture) -> bool:
        if len(seen.photographs) == len(names) and not listed.exists():
            listed.write_text(lines)
        return len(seen.listed) == len(names)

    camera = Camera(tmp_path / "taken", settle=settle)
    found = camera.run(decoded)
    unlit = next(seen for seen in camera.seen if len(seen.photographs) == len(names))
    assert tell_shifted(unlit) != {names[19]}  # else the list had nothing to correct
    assert tell_shifted(found) == {names[19]}


def test_photographs_are_compared_with_the_first_one_that_is_left(tmp_path: Path, decoded: Decoded) -> None:
    names = draw_button(tmp_path / "taken", 12, (0,))
    first = tmp_path / "taken" / names[0]

    def settle(seen: Capture) -> bool:
        if len(seen.photographs) == len(names):
            first.unlink(missing_ok=True)
        return not first.exists() and len(seen.photographs) == len(names) - 1

    camera = Camera(tmp_path / "taken", settle=settle)
    found = camera.run(decoded, expect=len(names) + 1)
    assert tell_shifted(next(seen for seen in camera.seen if len(seen.photographs) == len(names)))
    assert tell_shifted(found) == set()


def tell_shifted(capture: Capture) -> set[str]:
    """The names of the photographs that are said to be shifted."""
    return {one.path.name for one in capture.photographs if any("is shifted" in each.text for each in one.findings)}
