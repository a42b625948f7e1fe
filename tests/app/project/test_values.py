"""Values of the document that a project file keeps: every class that a document can hold is one of them."""

from __future__ import annotations

import ast
import dataclasses
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np

from app.document.document import Project
from app.project.declared import is_known
from app.project.project_file import History, Writer, read
from engine.scene.material import Material
from engine.shading.directional.interpolation import Kernel
from engine.shading.directional.planes import DirectionalMap
from engine.storage.file_array import FileArray
from tests.test_layers import modules


@cache
def homes(module: str) -> dict[str, str]:
    """The module of each name that annotations in `module` can use, also of those for type checkers."""
    found: dict[str, str] = {}
    for node in ast.walk(ast.parse(modules()[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module in modules():
            found |= {alias.asname or alias.name: node.module for alias in node.names}
        elif isinstance(node, ast.ClassDef):
            found[node.name] = module
    return found


def find_held_by(kind: type, seen: set[type]) -> Iterator[type]:
    """Classes of values that the fields of `kind` are annotated with, and those that they hold."""
    parts = [(part.name, part.type) for part in dataclasses.fields(kind) if part.init]
    for _, words in parts:
        for name in re.findall(r"\w+", str(words)):
            home = homes(kind.__module__).get(name)
            held = getattr(import_module(home), name, None) if home is not None else None
            if isinstance(held, type) and dataclasses.is_dataclass(held) and held not in seen:
                seen.add(held)
                yield held
                yield from find_held_by(held, seen)


def test_every_class_that_a_document_can_hold_is_kept() -> None:
    """A class that is missing is a fault that a user sees: the latest changes are not saved.

    A `FileArray` belongs to a stack in a folder, which is kept by its name.
    """
    held = list(find_held_by(Project, {FileArray}))
    assert {DirectionalMap, Kernel, Material} <= set(held)
    assert [each for each in held if not is_known(each)] == []


def test_a_material_for_light_from_every_side_is_kept(tmp_path: Path) -> None:
    chance = np.random.default_rng(5)
    planes, lights = chance.integers(0, 255, (2, 4, 5), np.uint8), np.array([[0.0, 0.6, 0.8], [0.6, 0.0, 0.8]])
    vectors, numbers = chance.normal(size=(6, 2)), chance.normal(size=(2, 2))
    kernel = Kernel(0.5, 0.01)
    directional = DirectionalMap(
        planes, numbers[0], numbers[1], chance.normal(size=6), vectors, lights, kernel, 0.7, 3.0, 2.0, 9.0
    )
    path = tmp_path / "dome.lap"
    writer = Writer(path)
    writer.write(History(Project(material=Material(None, None, directional=directional, name="Coin"))))
    writer.close()
    found = read(path).current.material.directional
    assert found is not None
    assert found.kernel == kernel
    assert (found.r_max, found.leave_one_out, found.in_sample, found.mean_picture) == (0.7, 3.0, 2.0, 9.0)
    for name in ("planes", "low", "step", "mean", "vectors", "lights"):
        assert np.array_equal(getattr(found, name), getattr(directional, name)), name
    assert read(path).current.has_map
