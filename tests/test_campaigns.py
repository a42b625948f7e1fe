"""Options of the campaigns: what runs with and without them, under which names, and what a failure leaves."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests import kept

CAMPAIGNS = """
import pytest

@pytest.mark.campaign(rounds=10)
def test_rounds(seed): pass

@pytest.mark.long
def test_hours(): pass

def test_seconds(): pass
"""


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], "test_rounds[seed0] test_seconds"),
        (["--long", "--share", "0.2"], "test_rounds[seed0] test_rounds[seed1] test_hours test_seconds"),
        (["--long", "--share", "0.2", "-m", "long"], "test_rounds[seed1] test_hours"),
        (["--seed", "7"], "test_rounds[seed7] test_seconds"),
    ],
)
def test_campaigns_run_where_they_are_asked_for(tmp_path: Path, options: list[str], expected: str) -> None:
    tests = tmp_path / "tests"
    for folder in (tests, tmp_path / "packaging"):
        folder.mkdir()
    shutil.copy(Path(__file__).with_name("conftest.py"), tests)
    (tmp_path / "packaging" / "requirements-test.lock").touch()
    (tests / "test_some.py").write_text(CAMPAIGNS)
    command = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider", *options]
    environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # plugins take most of the time
    said = subprocess.run(command, cwd=tests, env=environment, capture_output=True, text=True).stdout
    assert " ".join(re.findall(r"::(\S+)", said)) == expected, said


def test_what_fails_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept, "FAILED", tmp_path / "failed")
    with kept.keep("good.png", b"good"):
        pass
    with pytest.raises(AssertionError) as caught, kept.keep("bad.png", b"bad"):
        raise AssertionError
    (path,) = (tmp_path / "failed").iterdir()
    assert path.read_bytes() == b"bad"
    assert caught.value.__notes__ == [f"The file is kept in {path}"]
