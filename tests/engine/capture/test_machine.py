"""Fault 24: an import gives the same numbers whatever the language, the time zone and the number of CPUs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile

ROOT = Path(__file__).parents[3]

ONE_CORE = {"ONE_CORE": "1", "NUMBA_NUM_THREADS": "1"}

#: Imports the folder given into the other one and prints a fingerprint of every number in the result.
IMPORT = """
import hashlib, locale, os, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
locale.setlocale(locale.LC_ALL, "")
if os.environ.get("ONE_CORE"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.core.steps import drain
stack = drain(import_stack(find([Path(sys.argv[2])]), ImportSettings(), Path(sys.argv[3])))
arrays = (stack.radiance, stack.saturated, stack.elevation, stack.azimuth, stack.mean_radiance)
print(format(0.5, "n"), [float(angle) for angle in stack.elevation_deg])
print(hashlib.sha256(b"".join(array[:].tobytes() for array in arrays)).hexdigest())
"""


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Photographs of three kinds, with light positions and a Radiance exposure in decimal fractions."""
    folder = tmp_path_factory.mktemp("capture")
    noise = np.random.default_rng(3).random((48, 64, 3)).astype(np.float32)
    surface = 0.2 + 0.6 * cv2.GaussianBlur(noise, (0, 0), 1.5)
    tifffile.imwrite(folder / "a.tif", np.rint(surface * 0.3 * 65535).astype(np.uint16), photometric="rgb")
    radiance = cv2.imencode(".hdr", surface * 1.25)[1].tobytes()
    (folder / "b.hdr").write_bytes(radiance.replace(b"\n\n", b"\nEXPOSURE=2.5\n\n", 1))
    cv2.imwrite(str(folder / "c.png"), np.rint(surface[..., ::-1] * 0.9 * 65535).astype(np.uint16))
    (folder / "lights.lp").write_text("3\na.tif 0.8 0.0 0.6\nb.hdr 0.6 0.0 0.8\nc.png 0.28 0.0 0.96\n")
    return folder


@pytest.fixture(scope="module")
def comma(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment with a decimal comma: German where the system has it, else made here, else without one."""
    known = subprocess.run(["locale", "-a"], capture_output=True, text=True, check=False).stdout.split()
    found = [name for name in known if name.lower() in ("de_de.utf8", "de_de.utf-8", "fr_fr.utf8", "fr_fr.utf-8")]
    if found:
        return {"LC_ALL": found[0]}
    folder = tmp_path_factory.mktemp("locale")
    made = subprocess.run(
        ["localedef", "-f", "UTF-8", "-i", "de_DE", str(folder / "de_DE.UTF-8")], capture_output=True, check=False
    )
    if made.returncode:
        return {"LC_ALL": "C"}
    return {"LC_ALL": "de_DE.UTF-8", "LOCPATH": str(folder)}


def import_capture(capture: Path, target: Path, **environment: str) -> list[str]:
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("LC_", "LANG"))}
    result = subprocess.run(
        [sys.executable, "-c", IMPORT, str(ROOT), str(capture), str(target)],
        env={**kept, "NUMBA_NUM_THREADS": "2", **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()


@pytest.fixture(scope="module")
def reference(capture: Path, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    lines = import_capture(capture, tmp_path_factory.mktemp("reference") / "stack", LC_ALL="C.UTF-8")
    assert lines[0].startswith("0.5 [36.8")
    return lines


@pytest.mark.parametrize(
    "environment",
    [
        pytest.param({"LC_ALL": "C", "LANG": "C"}, id="language C", marks=pytest.mark.long),
        pytest.param({"TZ": "Asia/Kolkata"}, id="another time zone", marks=pytest.mark.long),
        pytest.param(ONE_CORE, id="one CPU", marks=pytest.mark.long),
        pytest.param({"LC_ALL": "C", "LANG": "C", "TZ": "Asia/Kolkata", **ONE_CORE}, id="all", marks=pytest.mark.long),
    ],
)
def test_fault24_an_import_is_the_same_on_every_machine(
    environment: dict[str, str], capture: Path, reference: list[str], tmp_path: Path
) -> None:
    if "ONE_CORE" in environment and not hasattr(os, "sched_setaffinity"):
        pytest.skip("the system cannot confine a process to one CPU")
    assert import_capture(capture, tmp_path / "stack", **environment) == reference


def test_fault24_an_import_is_the_same_with_a_decimal_comma_elsewhere_on_one_cpu(
    comma: dict[str, str], capture: Path, reference: list[str], tmp_path: Path
) -> None:
    """All at once, since each process takes seconds; the campaign names the one that differs."""
    alone = ONE_CORE if hasattr(os, "sched_setaffinity") else {}
    shown, fingerprint = import_capture(capture, tmp_path / "stack", TZ="Asia/Kolkata", **alone, **comma)
    assert shown.startswith("0,5 " if comma["LC_ALL"] != "C" else "0.5 ")
    assert fingerprint == reference[1]
