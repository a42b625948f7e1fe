"""The built-in capture, which the window opens where there is no data: kept from one start to the next.

What simulates it is loaded where it must be made; checking that it is whole takes a hundredth of a second.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import engine
from engine.core.errors import InputError
from engine.core.steps import Step, Steps
from engine.simulate.arc import MARKER, LightArc, capture_toml
from engine.storage.atomic import make_folder, write_json
from engine.storage.untrusted import read_bytes

LIMIT_BYTES = 64 << 20


def make_built_in_sample(folder: Path) -> Steps[Path]:
    """The folder of the built-in capture inside `folder`: made at the first call, and again where it is damaged."""
    arc = LightArc()
    capture = folder / f"{arc.sample}-{engine.__version__}"
    yield Step(0.0, "Looking for the built-in sample")
    if not _is_whole(capture, arc):
        from engine.simulate.simulate import simulate

        make_folder((capture / MARKER).parent)
        write_json(capture / MARKER, {"state": "to be made"})
        yield from simulate(arc, capture)
    return capture


def _is_whole(capture: Path, arc: LightArc) -> bool:
    """True if every photograph has the content that was written, under the angles of `arc`."""
    try:
        truth = json.loads(read_bytes(capture / MARKER, LIMIT_BYTES))
        table = read_bytes(capture / "capture.toml", LIMIT_BYTES).decode()
        return table == capture_toml(arc) and all(
            hashlib.sha256(read_bytes(capture / record["file"], LIMIT_BYTES)).hexdigest() == record["sha256"]
            for record in truth["photographs"]
        )
    except (InputError, ValueError, KeyError, TypeError):
        return False
