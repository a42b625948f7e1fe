"""Whole verbs on tiny inputs, each a second or less, and the law that all of them keep whatever fails (safety S7).

An output is complete or absent, inputs stay as they were, no partial name is left, a failure is one sentence with the
right exit code, and the next run succeeds and removes what a killed one left.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app import command_line
from app.arguments.usage import DONE
from app.cli.transport import bake
from engine.bundle.bundle import open_bundle
from engine.capture.stack import open_stack
from engine.core.steps import Step
from engine.factor.factor_file import read_factors
from engine.images.decode import read_image
from engine.images.encode import encode_png
from engine.storage import atomic
from engine.transport.baking.file import open_transport


@dataclass(frozen=True)
class Scenario:
    """A verb: its `words` with {inputs} and {output}, the name of its output, and what opens that whole."""

    words: str
    output: str
    read: Callable[[Path], Any]
    resumed: bool = False

    def line(self, inputs: Path, folder: Path) -> list[str]:
        return [word.format(inputs=inputs, output=folder / self.output) for word in self.words.split()]


#: A tetrahedron with texture coordinates: to make them would take most of the time.
MESH = (
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 0.4 0\nvt 0 0.4\nvt 0.4 0.4\n"
    "f 1/1 3/3 2/2\nf 1/1 2/2 4/4\nf 1/1 4/4 3/3\nf 2/2 3/3 4/4\n"
)

BAKE = "bake {inputs}/mesh.obj --brdf lambert --cube 16 --fine 1 -o {output} "

SCENARIOS = {
    "import": Scenario("import {inputs}/photographs -o {output} --no-align", "stack", open_stack),
    "shade": Scenario("shade {inputs}/stack -o {output} --slices 3", "a.lightarc", open_bundle),
    "bundle": Scenario("shade {inputs}/stack -o {output} --slices 3", "a-bundle", open_bundle),
    "bake": Scenario(BAKE + "--mode sh --order 3", "a.transport", open_transport),
    "resumed bake": Scenario(
        BAKE + "--ground --ground-cells 9 --coefficients 40 --terms 2", "b.transport", open_transport, resumed=True
    ),
    "render": Scenario(
        "render {inputs}/mesh.obj --mode reference --samples 1 --width 24 --height 16 -o {output}", "a.png", read_image
    ),
    "turntable": Scenario(
        "render plane --turntable 2 --width 24 --height 16 -o {output}",
        "frames",
        lambda folder: [read_image(path) for path in folder.glob("*.png")],
    ),
    "factor": Scenario("factor lambert --size 8 --samples 300 --terms 1 -o {output}", "factors", read_factors),
}


def photograph(inputs: Path) -> None:
    """Photographs, a stack of them, and a mesh, in the folder `inputs`."""
    (inputs / "photographs").mkdir(parents=True)
    surface = np.random.default_rng(0).uniform(0.7, 1.3, (18, 24, 3))
    for angle in (20, 50, 80):
        codes = np.clip(2 * angle * surface, 0, 255).astype(np.uint8)
        (inputs / "photographs" / f"cloth_{angle}deg.png").write_bytes(encode_png(codes))
    (inputs / "mesh.obj").write_text(MESH)
    assert command_line.main(SCENARIOS["import"].line(inputs, inputs)) == DONE


def prepare(inputs: Path) -> None:
    """The files of `photograph`, and a bake that was interrupted."""
    photograph(inputs)
    parser = argparse.ArgumentParser()
    bake.add_arguments(parser)
    (inputs / "interrupted").mkdir()
    words = SCENARIOS["resumed bake"].line(inputs, inputs / "interrupted")[1:]

    def interrupt(step: Step) -> None:
        if step.done > 0.5:
            raise KeyboardInterrupt

    assert bake.run(parser.parse_args(words), interrupt)["cancelled"]


def begin(scenario: Scenario, inputs: Path, folder: Path) -> None:
    """An empty `folder` for the output, or with what an interrupted bake left."""
    folder.mkdir()
    if scenario.resumed:
        shutil.copytree(inputs / "interrupted", folder, dirs_exist_ok=True)


def digest(folder: Path) -> str:
    """Of the names and bytes of all files in `folder`."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    parts = [(path.relative_to(folder).as_posix(), hashlib.sha256(path.read_bytes()).hexdigest()) for path in files]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def names(folder: Path) -> set[str]:
    return {entry.name for entry in folder.iterdir()}


def assert_complete_or_absent(scenario: Scenario, folder: Path, what: str) -> None:
    if (folder / scenario.output).exists():
        assert scenario.read(folder / scenario.output) is not None, what


def assert_one_sentence(err: str, what: str) -> None:
    """Of the lines on standard error the last is a sentence; the others are progress and warnings, never a trace."""
    assert "Traceback" not in err, f"{what}\n{err}"
    assert ".partial-" not in err, f"{what}\n{err}"
    assert err.rstrip().endswith("."), f"{what}\n{err}"


class FailAt:
    """Counts the operations of `engine.storage.atomic`, and fails the one numbered `at` (from 0) with `code`."""

    def __init__(self, at: int = -1, code: int = 0) -> None:
        self.at, self.code, self.operations = at, code, list[str]()

    def __call__(self, operation: str, _path: Path) -> None:
        self.operations.append(operation)
        if len(self.operations) == self.at + 1:
            raise OSError(self.code, os.strerror(self.code))

    def __enter__(self) -> FailAt:
        atomic.fault = self
        return self

    def __exit__(self, *_: object) -> None:
        atomic.fault = None
