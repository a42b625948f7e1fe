"""A function that stands for the making of a capture: quick, and wrong in ways that names of captures ask for."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from engine.core.errors import InputError
from engine.core.steps import Step, Steps
from engine.storage.atomic import atomic_folder, write_bytes, write_json


def make(text: str, order: Mapping[str, Any]) -> Steps[dict[str, Any]]:
    """Write the hash of the files of a capture into its folder."""
    said = json.loads(text)
    name, place = said["name"], Path(said["place"])
    yield Step(0.1, "begun")
    if name.startswith("refuse"):
        raise InputError(place, "is <b>no</b> capture", "Give another")
    if name.startswith("crash"):
        os.abort()
    if name.startswith("mistake"):
        raise KeyError("a mistake")
    if name.startswith("hang"):
        time.sleep(600.0)
    if name.startswith("eat"):
        held = [bytes(1 << 26) for _ in range(1000)]
        raise AssertionError(len(held))
    with atomic_folder(Path(order["output"]) / name, "capture.json") as folder:
        digest = hashlib.sha256()
        for path in sorted(each for each in place.iterdir() if each.is_file()):
            digest.update(path.read_bytes())
            time.sleep(0.01)
            yield Step(0.5, f"read {path.name}")
        write_bytes(folder / "result.bin", digest.digest())
        write_json(folder / "capture.json", {"lightarc_capture": 1, "key": digest.hexdigest()})
    warnings = ["<script>alert(1)</script>"] if "odd" in name else []
    figures = {"verdict": "warning" if warnings else "good", "held_out_rmse_srgb8": float(len(name))}
    return {"photographs": 2, "warnings": warnings, **figures}
