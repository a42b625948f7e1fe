"""A project that was cleaned up is small, and its photographs give back every bit; what they cannot give stays."""

from __future__ import annotations

import dataclasses
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from app.commands.making import material_of, new_stack_of, pixels_made
from app.commands.rebuilding import lacks_material, rebuild, set_up_whole
from app.document.document import ImportChoices, Project
from app.project import arrays
from app.project.arrays import PACKED
from app.project.cleaning import clean_up
from app.project.made import size_of
from app.project.photographs import keep, photographs, take_marks
from app.project.pixels import are_packed, are_there
from app.project.places import claim, release
from app.project.project_file import History, Writer, data_folder, read
from app.project.report import problems_of
from app.session import cache
from engine.capture.lights.sources import find
from engine.capture.stack import CODES, RADIANCE, ROOM, SATURATED
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.geometry.shapes import shape
from engine.simulate.arc import LightArc
from engine.simulate.simulate import simulate
from engine.storage import atomic
from engine.storage.atomic import discard, make_folder
from tests.app.command import Command
from tests.engine.capture.calibration.generated import Capture, render, write
from tests.threads import threads


def make(path: Path, capture: Path, choices: ImportChoices) -> Path:
    """A project with stack, material and a model, all of whose photographs are marked."""
    sources = find([capture])
    target = make_folder(data_folder(path)) / f"stack-{'5' * 40}"
    project = Project(sources=sources, import_choices=choices, imported_with=choices, mesh=shape("sphere"))
    writer = Writer(path)
    writer.write(History(project))
    stack = drain(new_stack_of(sources, choices, target))
    project = dataclasses.replace(project, stack=stack)
    project = dataclasses.replace(project, material=drain(material_of(project)), built_from=project.recipe)
    writer.write(History(project))
    writer.close()
    keep(path, drain(take_marks(photographs(project))))
    return path


@pytest.fixture
def capture(tmp_path: Path, photographs: Path) -> Path:
    """Photographs of this test alone, which it may change."""
    return Path(shutil.copytree(photographs, tmp_path / "capture"))


@pytest.fixture
def project(tmp_path: Path, capture: Path) -> Path:
    return make(tmp_path / "a.lap", capture, ImportChoices(motion="none"))


def content(project: Project) -> dict[str, bytes]:
    """Every number of the stack and of the material."""
    assert project.stack is not None
    stack, material = project.stack, project.material
    assert material.shading_map is not None
    assert material.power_law is not None
    found = {"radiance": np.stack(list(stack.radiance)), "saturated": np.stack(list(stack.saturated))}
    found |= {"slices": material.shading_map.slices, "scale": material.power_law.scale}
    found |= {"exponent": material.power_law.exponent, "error": material.power_law.error_map}
    return {name: array.tobytes() for name, array in found.items()}


def test_pixels_lie_in_the_cache_and_arrays_are_compressed(project: Path) -> None:
    names = {file.name for file in data_folder(project).rglob("*") if file.is_file()}
    assert not {CODES, RADIANCE, SATURATED} & names
    assert any(name.endswith(PACKED) for name in names)
    assert not any(name.endswith(".npy") for name in names)
    assert drain(problems_of(project)) == []
    assert content(read(project).current)


def test_every_bit_comes_back(project: Path, capture: Path, lightarc: Command) -> None:
    before, size = content(read(project).current), size_of(data_folder(project))
    found = lightarc("project", "clean-up", project)
    assert found.code == 0, found.err
    assert "freed" in found.out
    taken_by = sum(file.stat().st_size for file in capture.glob("*.png"))
    assert size_of(project) + size_of(data_folder(project)) < min(size, 2 * taken_by)
    opened = read(project)
    assert opened.current.stack is not None
    assert not are_there(opened.current.stack)
    assert opened.current.mesh is not None
    assert lacks_material(opened.current)
    with pytest.raises(InputError, match="not there at the moment"):
        opened.current.stack.radiance[0]
    whole = drain(rebuild(project)).current
    assert content(whole) == before
    assert set_up_whole(project).project.material.has_map
    assert drain(clean_up(project)).freed_bytes >= 0
    assert content(drain(rebuild(project)).current) == before


def test_aligned_raw_photographs_give_the_same_bits_on_one_thread(tmp_path: Path) -> None:
    """Demosaicing, alignment and warping are repeated by another process, which has one thread."""
    angles = tuple(np.radians((15.0, 40.0, 65.0, 85.0)))
    drain(simulate(LightArc(elevation=angles, size=96, format="dng", interreflection=False), tmp_path / "raw"))
    with threads(2):
        path = make(tmp_path / "a.lap", tmp_path / "raw", ImportChoices(trust_angles=True))
    before = content(read(path).current)
    drain(clean_up(path))
    assert lacks_material(read(path).current)
    program = (
        "import sys; from pathlib import Path; from app.commands.rebuilding import rebuild\n"
        "from engine.core.steps import drain\n"
        "if __name__ == '__main__': drain(rebuild(Path(sys.argv[1])))\n"
    )
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
    (tmp_path / "again.py").write_text(program)
    command = ["taskset", "-c", "0"] if shutil.which("taskset") else []
    command += [sys.executable, str(tmp_path / "again.py"), str(path)]
    root = Path(__file__).parents[3]
    subprocess.run(command, check=True, env={**os.environ, **one, "PYTHONPATH": str(root)}, cwd=root)
    assert content(read(path).current) == before


def test_photographs_that_are_gone_keep_what_was_made_of_them(project: Path, capture: Path) -> None:
    before = content(read(project).current)
    next(iter(sorted(capture.glob("*.png")))).unlink()
    cleaned = drain(clean_up(project))
    assert "missing" in cleaned.kept[0]
    stack = read(project).current.stack
    assert stack is not None
    assert stack.folder is not None
    assert are_packed(stack.folder)
    for place in (cache.entries_folder() or project).iterdir():
        discard(place)
    opened = read(project).current
    assert opened.stack is not None
    drain(pixels_made(opened.stack, opened.sources, opened.imported_with))
    assert content(opened) == before


@pytest.mark.parametrize("are_gone", [False, True])
def test_room_light_comes_back_with_the_codes_that_it_is_taken_off(tmp_path: Path, are_gone: bool) -> None:
    lit = Capture(seed=8, file_format="jpg", lamps=18, height=48, width=56, room=0.15, distance=4.0)
    path = make(tmp_path / "a.lap", write(render(lit), tmp_path / "lit"), ImportChoices())
    stack = read(path).current.stack
    assert stack is not None
    assert set(stack.pixels) == {ROOM, CODES}
    before = stack.radiance[:].tobytes()
    if are_gone:
        next((tmp_path / "lit").glob("*.jpg")).unlink()
    drain(clean_up(path))
    assert stack.folder is not None
    assert are_packed(stack.folder) == are_gone
    for place in (cache.entries_folder() or path).iterdir():
        discard(place)
    opened = read(path).current
    assert opened.stack is not None
    assert not are_there(opened.stack)
    drain(pixels_made(opened.stack, opened.sources, opened.imported_with))
    assert opened.stack.radiance[:].tobytes() == before


def test_photographs_that_changed_give_nothing_in_place_of_what_was(project: Path, capture: Path) -> None:
    first, second = sorted(capture.glob("*.png"))[:2]
    second.replace(first)
    assert "missing" in drain(clean_up(project)).kept[0]
    assert not lacks_material(read(project).current)


def test_other_pixels_are_refused(project: Path, capture: Path) -> None:
    drain(clean_up(project))
    first, second = sorted(capture.glob("*.png"))[:2]
    first.write_bytes(second.read_bytes()[:-2] + b"\1\2")
    with pytest.raises(InputError):
        drain(rebuild(project))
    assert lacks_material(read(project).current)


def test_what_other_settings_or_a_version_made_stays(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.project.cleaning.engine.__version__", "999")
    kept = drain(clean_up(project)).kept
    assert "imported by lightarc" in kept[0]
    assert not lacks_material(read(project).current)


def test_a_project_of_before_is_compressed_and_its_pixels_come_back(
    tmp_path: Path, capture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stack and arrays as .npy files beside the project, and radiance in place of codes."""
    with monkeypatch.context() as patch:
        patch.setattr("engine.capture.import_codes.writes_codes", lambda _: False)
        project = make(tmp_path / "a.lap", capture, ImportChoices(motion="none"))
    opened, folder = read(project).current, data_folder(project)
    before = content(opened)
    assert opened.stack is not None
    assert opened.stack.folder is not None
    for name, values in (("radiance", opened.stack.radiance), ("saturated", opened.stack.saturated)):
        np.save(opened.stack.folder / f"{name}.npy", np.stack(list(values)))
    for file in (folder / "arrays").glob(f"*{PACKED}"):
        np.save(file.with_suffix(".npy"), arrays.find_beside(folder, file.stem))
        file.unlink()
    for place in (cache.entries_folder() or project).iterdir():
        discard(place)
    assert content(read(project).current) == before
    drain(clean_up(project))
    assert not list(folder.rglob("*.npy"))
    rebuilt = drain(rebuild(project)).current
    assert content(rebuilt) == before
    assert rebuilt.stack is not None
    assert set(rebuilt.stack.pixels) == {RADIANCE, SATURATED}


def test_a_project_that_is_open_elsewhere_is_left_alone(project: Path) -> None:
    other = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    try:
        from engine.storage.writer import start_of, writer

        host = writer().rsplit("-", 2)[0]
        (data_folder(project) / f"open-{host}-{other.pid}-{start_of(other.pid)}").touch()
        with pytest.raises(InputError, match="open in another window"):
            drain(clean_up(project))
    finally:
        other.kill()
        other.wait()
    assert claim(project)
    drain(clean_up(project))
    assert list(data_folder(project).glob("open-*")), "the mark of the window stays"
    release(project)


def test_interrupted_at_any_operation_nothing_is_lost(project: Path, tmp_path: Path) -> None:
    """Each clean-up is cut off one operation later, until one is whole; the project gives all bits all the time."""
    before = content(read(project).current)

    class Cut(BaseException):
        pass

    number, is_whole = 0, False
    while not is_whole:
        number += 3
        count = [0]

        def fault(_operation: str, _path: Path, number: int = number, count: list[int] = count) -> None:
            count[0] += 1
            if count[0] == number:
                raise Cut

        atomic.fault = fault
        try:
            drain(clean_up(project))
            is_whole = True
        except Cut:
            pass
        finally:
            atomic.fault = None
    assert number > 3
    assert content(drain(rebuild(project)).current) == before
