"""Plain words: sentences that say what a thing is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[1]

FOLDERS = ("app", "engine", "packaging", "tests")

#: A docstring or comment that begins with a question instead of saying what a thing is.
QUESTION = re.compile(r'\s*(?:r?"""|#:? ?)(?:What|How|Whether|Which|Where|When)\b')


@pytest.mark.parametrize("folder", FOLDERS)
def test_docstrings_and_comments_begin_with_what_a_thing_is(folder: str) -> None:
    questions = [
        f"{path.relative_to(PROJECT).as_posix()}:{number} {line.strip()}"
        for path in sorted((PROJECT / folder).rglob("*.py"))
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if QUESTION.match(line)
    ]
    assert questions == []
