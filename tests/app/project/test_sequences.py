"""Random sequences of open, edit, save as, undo, cancel, quit and kill while jobs run: no confirmed work is lost."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from engine.images.encode import encode_png
from tests.app.conftest import NO_DISPLAY
from tests.app.project.conftest import folder_in_memory
from tests.app.project.sequences import NAMES, Action, Play, Promises, draw, smallest, text_of

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="needs fork"),
    pytest.mark.skipif(NO_DISPLAY, reason="DISPLAY is not set: window tests need an X display (Xvfb)"),
]

#: The smallest sequences that lost a save once, one after the other: it waited for a job, and Quit, a new project or
#: SIGTERM dropped it; of two saves at once the second was dropped; a slow disk was too slow for Quit; and a
#: save waited for a job without an end. The first two are played in every suite, the others with --long.
KNOWN: list[Action] = [
    {"do": "notes", "text": "saved beside a job"},
    {"do": "job", "lane": "compute", "deaf": False},
    {"do": "save_as", "target": NAMES[0]},
    {"do": "quit"},
    {"do": "notes", "text": "left for another project"},
    {"do": "job", "lane": "compute", "deaf": True},
    {"do": "save_as", "target": NAMES[1]},
    {"do": "new"},
    {"do": "terminate"},
]
KNOWN_TOO: list[Action] = [
    {"do": "model", "name": "sphere", "pause_s": 0.2},
    {"do": "save_as", "target": NAMES[2]},
    {"do": "save_as", "target": NAMES[0]},
    {"do": "quit"},
    {"do": "notes", "text": "saved on a slow disk"},
    {"do": "photographs", "pause_s": 0.5},
    {"do": "slow_disk", "each_s": 0.2},
    {"do": "save_as", "target": NAMES[2]},
    {"do": "quit"},
    {"do": "notes", "text": "saved while a search goes on"},
    {"do": "job", "lane": "compute", "deaf": False},
    {"do": "save_as", "target": NAMES[1]},
    {"do": "wait"},
]

#: Sequences that are tried to shrink one that fails.
TRIES = 40


@pytest.fixture(scope="session")
def small_capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of three photographs of 24 × 16 pixels."""
    folder = tmp_path_factory.mktemp("capture") / "cloth"
    folder.mkdir()
    surface = np.random.default_rng(0).uniform(0.7, 1.3, (16, 24, 3))
    for angle in (20, 50, 80):
        levels = np.clip(2 * angle * surface, 0, 255).astype(np.uint8)
        (folder / f"cloth_{angle}deg.png").write_bytes(encode_png(levels))
    return folder


def find_broken_by(windows: Path, photographs: Path, actions: Sequence[Action]) -> list[str]:
    """The promises that the program breaks in a sequence, in a home of its own."""
    with folder_in_memory() as folder:
        return Play(windows, folder, photographs).run(actions)


@pytest.mark.parametrize("known", [KNOWN, pytest.param(KNOWN_TOO, marks=pytest.mark.long)])
def test_what_was_lost_once_is_kept(windows: Path, small_capture: Path, known: list[Action]) -> None:
    assert find_broken_by(windows, small_capture, known) == []


@pytest.mark.campaign(rounds=500)
def test_no_confirmed_work_is_lost_in_any_sequence(windows: Path, small_capture: Path, seed: int) -> None:
    actions = draw(seed)
    broken = find_broken_by(windows, small_capture, actions)
    if broken:
        small = smallest(actions, lambda fewer: bool(find_broken_by(windows, small_capture, fewer)), TRIES)
        pytest.fail(f"sequence {seed}: {broken}\nsmallest:\n{text_of(small)}")


def test_a_lost_save_and_a_lost_gesture_are_found(tmp_path: Path) -> None:
    """Without a window: the model says what is missing, and says nothing where all is there."""
    held: dict[str, list] = {}
    here, there = str(tmp_path / "here.lap"), str(tmp_path / "there.lap")

    def read(path: Path) -> dict:
        return {"marks": held[str(path)], "problems": []}

    def play(how: str) -> Promises:
        promises = Promises()
        promises.shown(here, EMPTY)
        promises.shown(here, _marks(1))
        promises.settle(here)
        promises.shown(here, _marks(2))
        promises.accepted(here, there)
        promises.leaving(here)  # Save as lets the view come to rest, and nothing is on disk for that
        promises.shown(here, _marks(3))
        promises.ended(how)
        return promises

    Path(here).touch()
    held[here] = _marks(3)
    assert play("quit").broken(read) == [f"there.lap is lost; the last of it was {_marks(3)}"]
    assert play("kill").broken(read) == []
    Path(there).touch()
    for kept, is_whole in ((1, False), (2, True), (3, True)):
        held[there] = _marks(kept)
        assert (play("quit").broken(read) == []) is is_whole
    held[here] = _marks(1)
    assert play("kill").broken(read) == []
    held[here] = _marks(2)
    assert [words.partition(" ")[0] for words in play("quit").broken(read)] == ["here.lap"]
    assert play("kill").broken(read) == []
    held[here] = EMPTY
    assert [words.partition(" ")[0] for words in play("kill").broken(read)] == ["here.lap"]


def test_a_sequence_that_fails_is_shrunk_to_what_it_takes() -> None:
    actions = draw(1) + draw(2)

    def fails(fewer: Sequence[Action]) -> bool:
        return actions[2] in fewer and actions[-2] in fewer

    assert smallest(actions, fails, 200) == [actions[2], actions[-2]]


EMPTY = [0, 0, 1.0, "shading-map", 8, "", "", "", "", 0, [], False]


def _marks(at: int) -> list:
    return [at, at, 1.0, "shading-map", 8, f"note {at}", "", "", "", 0, [], False]
