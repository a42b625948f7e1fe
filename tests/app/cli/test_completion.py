"""What a shell completes."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from app.cli.completion import find_words
from app.command_line import VERBS, build_parser
from tests.app.command import Command

#: Words that are typed, the last one not to its end, and what bash makes of it.
TYPED = (
    ("lightarc rend", "render"),
    ("lightarc render --mod", "--mode"),
    ("lightarc render --mode ref", "reference"),
    ("lightarc --log a.log brdf f", "fit"),
    ("lightarc brdf fit --weighting l", "log"),
    ("lightarc bundle ver", "verify"),
)


def test_all_verbs_and_options_are_completed() -> None:
    words = list(find_words(build_parser()))
    assert {name for name, _, _ in VERBS} < {name for word in words if not word.path for name in word.names}
    assert any(word.path == "brdf fit" and "--weighting" in word.names for word in words)
    assert all(word.is_file for word in words if "--output" in word.names)


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_bash_completes(lightarc: Command, tmp_path: Path) -> None:
    script = lightarc("completion", "bash").out
    ask = "\n".join(
        f"COMP_WORDS=({typed}); COMP_CWORD={len(typed.split()) - 1}; _lightarc; echo ${{COMPREPLY[@]}}"
        for typed, _ in TYPED
    )
    done = subprocess.run(["bash", "-c", f"{script}\n{ask}"], capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout.splitlines() == [found for _, found in TYPED], done.stderr
