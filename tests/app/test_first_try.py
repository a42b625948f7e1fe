"""Command lines as a new user types them, right and wrong: exit code, and the first words of what is answered.

A call is `CODE CALL` with the answer below it, which may leave parts out (…). The calls share a folder with
photographs of three lights, their stack, a material, a bake, a model and images, all tiny.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from app import command_line
from app.arguments.usage import DONE
from engine.images.encode import encode_png
from tests.app.command import Command
from tests.app.scenarios import SCENARIOS, photograph

CALLS = Path(__file__).with_name("first_try.txt")

#: Calls that take seconds.
HEAVY = ("plan mesh.obj", "import photographs -o s1", "--to textures -o e1", "--difference")


def read_calls() -> list[tuple[int, str, str]]:
    """Exit code, words and answer of each call."""
    found = re.findall(r"^(\d) lightarc ?(.*)\n {2}(.*)$", CALLS.read_text(encoding="utf-8"), re.MULTILINE)
    return [(int(code), words, answer) for code, words, answer in found]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("first-try")
    photograph(place)
    for name in ("shade", "bake"):
        assert command_line.main(SCENARIOS[name].line(place, place)) == DONE
    for name, grey in (("a.png", 90), ("b.png", 120)):
        (place / name).write_bytes(encode_png(np.full((16, 16, 3), grey, np.uint8)))
    (place / "sky.png").write_bytes(encode_png(np.full((8, 16, 3), 200, np.uint8)))
    (place / "notes.txt").write_text("not an image")
    (place / "my cloth.obj").write_bytes((place / "mesh.obj").read_bytes())
    return place


def fits(answer: str, line: str) -> bool:
    """True for a line that is the answer, each … of which stands for any words."""
    return re.fullmatch(".*".join(map(re.escape, answer.split("…"))), line) is not None


def answer_of(lightarc: Command, words: str) -> tuple[int, str]:
    """The exit code of a call, and its first line: of the result, or of what is said in its place."""
    done = lightarc(*shlex.split(words))
    said = done.out if done.code == DONE else "\n".join(re.findall(r"^(?! {0,2}\d{1,3} %).*$", done.err, re.MULTILINE))
    return done.code, next(iter(said.strip().splitlines()), "(nothing)")


@pytest.mark.parametrize("is_heavy", [False, pytest.param(True, marks=pytest.mark.long)], ids=["quick", "long"])
def test_what_a_new_user_types_is_answered(
    is_heavy: bool, folder: Path, lightarc: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    differ = list[str]()
    for code, words, answer in read_calls():
        if any(each in words for each in HEAVY) and code == DONE and "-h" not in words.split() and not is_heavy:
            continue
        found = answer_of(lightarc, words)
        if found[0] != code or not fits(answer, found[1]):
            differ.append(f"{found[0]} lightarc {words}\n  {found[1]}")
    assert not differ, "\n".join(differ)


def test_there_are_calls_of_every_verb() -> None:
    calls = [words.split() for _, words, _ in read_calls()]
    assert len(calls) >= 150
    assert {name for name, *_ in command_line.VERBS} <= {word for words in calls for word in words}
