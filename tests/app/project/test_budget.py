"""A project holds a bounded multiple of its photographs; what is beyond lies in the cache, and every bit comes back."""

from __future__ import annotations

import dataclasses
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from app.commands.making import keep_stack, material_of
from app.commands.rebuilding import lacks_material, lacks_surface, rebuild
from app.commands.surface import surface_of
from app.document.document import ImportChoices, Project, Step
from app.project import budget
from app.project.arrays import CONTENT, file_of
from app.project.budget import list_cached, secure_arrays
from app.project.cleaning import clean_up
from app.project.made import size_of
from app.project.photographs import keep, photographs, take_marks
from app.project.project_file import History, Opened, Writer, data_folder, read
from app.project.report import describe, problems_of
from app.session import cache
from app.window.main_window import MainWindow
from engine.capture.lights.sources import find
from engine.core.steps import drain
from engine.scene.material import Material
from engine.simulate.arc import LightArc
from engine.simulate.simulate import simulate
from engine.storage.atomic import discard, make_folder
from tests.app.opening import open_project

#: Promises, in multiples of the photographs.
MAX_TIMES, MAX_TIMES_CLEAN = 20.0, 2.0


@pytest.fixture(scope="module")
def arc(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten noisy JPEGs of lamps on an arc, between which the camera moves a little."""
    folder = tmp_path_factory.mktemp("arc")
    drain(simulate(LightArc(size=160, interreflection=False), folder / "lossless"))
    make_folder(folder / "photographs")
    for file in (folder / "lossless").glob("*.tif*"):
        levels = np.round(np.asarray(cv2.imread(str(file), cv2.IMREAD_UNCHANGED)) / 257.0).astype(np.uint8)
        assert cv2.imwrite(str(folder / "photographs" / f"{file.stem}.jpg"), levels, (cv2.IMWRITE_JPEG_QUALITY, 75))
    angles = (folder / "lossless" / "capture.toml").read_text().replace(".tif", ".jpg")
    (folder / "photographs" / "capture.toml").write_text(angles)
    return folder / "photographs"


@pytest.fixture
def capture(tmp_path: Path, arc: Path) -> Path:
    """Photographs of this test alone, which it may change."""
    folder = make_folder(tmp_path / "capture")
    for file in arc.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    return folder


def import_into(path: Path, project: Project, choices: ImportChoices) -> Project:
    """`project` with its photographs imported anew."""
    assert project.sources is not None
    if not path.exists():
        write(path, [project])
    marks = drain(take_marks(photographs(project)))
    stack = drain(keep_stack(project.sources, choices, marks, (make_folder(data_folder(path)),)))
    keep(path, marks)
    return dataclasses.replace(project, import_choices=choices, imported_with=choices, stack=stack)


def build(project: Project) -> Project:
    """`project` with the material of its stack, its look as it was."""
    material = drain(material_of(project)).looking_like(project.material)
    return dataclasses.replace(project, material=material, built_from=project.recipe)


def write(path: Path, states: list[Project]) -> None:
    """Write states as a window does, one after the other."""
    writer, steps = Writer(path), tuple[Step, ...]()
    writer.write(History(states[0]))
    for old, new in pairwise(states):
        steps = (*steps, Step("Change", "", old, new))
        writer.write(History(new, steps, len(steps)))
    writer.close()


@pytest.fixture
def built(tmp_path: Path, capture: Path) -> Project:
    """A project with a material, as it is in `project`."""
    path = tmp_path / "a.lap"
    imported = import_into(path, Project(sources=find([capture])), ImportChoices(motion="none"))
    write(path, [imported, found := build(imported)])
    return found


@pytest.fixture
def project(tmp_path: Path, built: Project) -> Path:
    assert built.has_map
    return tmp_path / "a.lap"


def times(path: Path) -> float:
    """The size of a project in multiples of its photographs."""
    taken = sum(file.stat().st_size for file in photographs(read(path).current))
    return (size_of(path) + size_of(data_folder(path))) / taken


def content(project: Project) -> dict[str, bytes]:
    """Every number of the maps of a state, as far as they are there."""
    found = {}
    surface = project.surface.maps if project.surface is not None else None
    for value in (project.material.shading_map, project.material.power_law, project.material.directional, surface):
        for name, each in vars(value).items() if value is not None else ():
            if hasattr(each, "tobytes"):
                found[f"{type(value).__name__} {name}"] = each.tobytes()
    return found


def empty_cache() -> None:
    folder = cache.entries_folder()
    assert folder is not None
    for place in folder.iterdir():
        discard(place)


def history(opened: Opened) -> list[Project]:
    """All states of a project that was opened, the oldest first."""
    found = [opened.steps[0].old, *(step.new for step in opened.steps)]
    return [opened.state(each) if isinstance(each, str) else each for each in found]


def test_a_project_of_jpegs_is_small_and_gives_back_every_bit_of_every_state(tmp_path: Path, capture: Path) -> None:
    """An import, a material, other settings, another material, maps of the surface, and other settings again."""
    project = tmp_path / "a.lap"
    imported = import_into(project, Project(sources=find([capture])), ImportChoices())
    built = build(imported)
    changed = dataclasses.replace(built, slices=6, mixed=True, tileable=True, excluded=frozenset(["woven_10.jpg"]))
    again = build(changed)
    surfaced = dataclasses.replace(again, surface=drain(surface_of(again)), surface_from=again.surface_recipe)
    states = [imported, built, changed, again, surfaced, dataclasses.replace(surfaced, excluded=frozenset())]
    write(project, states)
    assert times(project) < MAX_TIMES
    assert list_cached(project, data_folder(project)), "slices lie in the cache"
    assert not read(project).missing
    assert all(each["present"] for each in describe(project)["derived"])
    for state, opened in zip(states, history(read(project)), strict=True):
        assert content(opened) == content(state)
    empty_cache()
    assert drain(problems_of(project)) == [], "what can be made again is not missed"
    for number, (state, opened) in enumerate(zip(states, history(read(project)), strict=True)):
        whole = dataclasses.replace(opened, **remake(opened))
        assert content(whole) == content(state), f"state {number}"
    drain(clean_up(project))
    assert times(project) < MAX_TIMES_CLEAN
    assert content(drain(rebuild(project)).current) == content(states[-1])


def remake(project: Project) -> dict[str, Any]:
    """The parts that a state lacks, made again as the window does."""
    from app.commands.rebuilding import material_again, surface_again

    parts: dict[str, Any] = {}
    if lacks_material(project):
        parts["material"] = drain(material_again(project))
    if lacks_surface(project):
        parts["surface"] = drain(surface_again(project))
    return parts


def test_a_material_of_an_earlier_import_comes_back(tmp_path: Path, capture: Path) -> None:
    """Undo leads to states in between, which have the stack of the second import and the material of the first."""
    path = tmp_path / "a.lap"
    first = build(import_into(path, Project(sources=find([capture])), ImportChoices(motion="none")))
    write(path, [first])
    others = find(sorted(capture.glob("*.jpg"))[:8])
    between = import_into(path, dataclasses.replace(first, sources=others), ImportChoices())
    glossy = dataclasses.replace(between, material=dataclasses.replace(between.material, brdf="ggx:alpha=0.1"))
    states = [first, between, glossy, build(glossy)]
    write(path, states)
    assert times(path) < MAX_TIMES
    drain(clean_up(path))
    assert times(path) < MAX_TIMES_CLEAN
    for state, opened in zip(states, history(read(path)), strict=True):
        empty_cache()
        assert lacks_material(opened)
        assert content(dataclasses.replace(opened, **remake(opened))) == content(state)


def test_photographs_that_are_gone_bring_results_into_the_project(project: Path, built: Project, capture: Path) -> None:
    folder, files = data_folder(project), photographs(built)
    names = list_cached(project, folder)
    drain(secure_arrays(project, folder, files, are_gone=False))
    files[0].unlink()
    assert cache.keep_within(0) == 0, "the cache keeps what no photograph gives again"
    drain(secure_arrays(project, folder, files, are_gone=True))
    assert list_cached(project, folder) == []
    assert all(file_of(folder, name).is_file() for name in names)
    empty_cache()
    assert content(read(project).current) == content(built)
    drain(clean_up(project))
    assert content(read(project).current) == content(built)


def test_results_made_while_photographs_are_gone_lie_in_the_project(tmp_path: Path, capture: Path) -> None:
    path = tmp_path / "a.lap"
    imported = import_into(path, Project(sources=find([capture])), ImportChoices(motion="none"))
    next(iter(capture.glob("*.jpg"))).unlink()
    write(path, [imported, build(imported)])
    assert list_cached(path, data_folder(path)) == []


def test_a_copy_in_the_cache_that_is_damaged_is_made_again(project: Path, built: Project) -> None:
    damaged = cache.entry(f"array-{list_cached(project, data_folder(project))[0]}")
    assert damaged is not None
    content_of = bytearray((damaged / CONTENT).read_bytes())
    content_of[-1] ^= 1
    (damaged / CONTENT).write_bytes(content_of)
    assert drain(problems_of(project)) == []
    assert not damaged.exists()
    assert content(drain(rebuild(project)).current) == content(built)
    assert damaged.exists()
    (damaged / CONTENT).write_bytes(content_of[:-100])
    assert content(drain(rebuild(project)).current) == content(built)


def test_without_a_cache_or_with_one_that_is_too_small_results_lie_in_the_project(
    tmp_path: Path, capture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.lap"
    built = build(import_into(path, Project(sources=find([capture])), ImportChoices(motion="none")))
    with monkeypatch.context() as patch:
        patch.setattr(cache, "limit_bytes", lambda: 0)
        write(path, [built])
    empty_cache()
    assert content(read(path).current) == content(built)


def test_a_material_that_no_photographs_give_stays_in_the_project(project: Path, built: Project) -> None:
    folder = data_folder(project)
    opened = dataclasses.replace(built, built_from=())
    assert budget.find_beyond(built, "material", folder, ()).arrays
    assert not budget.find_beyond(opened, "material", folder, ()).arrays
    assert not budget.find_beyond(
        dataclasses.replace(opened, material=Material(None, None)), "material", folder, ()
    ).arrays


@pytest.mark.parametrize("built_from", [(1,), (None,) * 7, (0, frozenset(), 10**9, False, "last-slice", 32, None)])
def test_settings_from_a_file_that_no_project_has_are_not_taken(project: Path, built_from: tuple[object, ...]) -> None:
    current = read(project).current
    forged = dataclasses.replace(current, material=Material(None, None), built_from=built_from)
    assert lacks_material(dataclasses.replace(current, material=Material(None, None)))
    assert not lacks_material(forged)
    with_stack = dataclasses.replace(forged, built_from=(current.stack, *built_from[1:]))
    assert not lacks_material(with_stack)


def test_undo_in_the_window_brings_back_the_material_of_each_step(
    window: MainWindow, qtbot: Any, project: Path, built: Project
) -> None:
    """Among them one that is out of date; it is made again with the settings that it was built with."""
    changed = dataclasses.replace(built, slices=6)
    states = [built, changed, build(changed)]
    write(project, states)
    empty_cache()
    open_project(window, qtbot, project)
    document = window.bench.document
    for step, state in (
        (None, states[2]),
        (window.undo, states[1]),
        (window.undo, states[0]),
        (window.redo, states[1]),
    ):
        if step is not None:
            step.trigger()
        expected = content(state)
        qtbot.waitUntil(lambda expected=expected: content(document.project) == expected, timeout=120_000)
        assert document.project.slices == state.slices
        assert document.undo_stack.count() == 2, "no step of the history"
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=60_000)
    assert times(project) < MAX_TIMES
    assert content(read(project).current) == content(built)
