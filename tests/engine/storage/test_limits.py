"""Limits of an account: each is named as what it is, and blamed on no file."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

PROGRAM = """
import resource, sys
resource.setrlimit(getattr(resource, sys.argv[2]), (int(sys.argv[3]),) * 2)
from app.command_line import main
print(main(["compare", sys.argv[1], sys.argv[1]]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of Linux")
@pytest.mark.parametrize(
    ("limit", "value", "answer"),
    [
        ("RLIMIT_FSIZE", 65536, "\n0\n"),
        ("RLIMIT_NOFILE", 9, "Too many files are open. Close other programs"),
    ],
)
def test_a_image_is_read_or_the_limit_named(limit: str, value: int, answer: str, tmp_path: Path) -> None:
    import cv2
    import numpy as np

    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((300, 400, 3), np.uint8))
    words = [sys.executable, "-c", PROGRAM, str(tmp_path / "a.png"), limit, str(value)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    ended = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert answer in ended.stdout + ended.stderr
    assert "Traceback" not in ended.stderr
