"""Measures the size of projects beside that of their photographs, before and after a clean-up, and how they open.

For each capture a project with stack and material is made, and the same in the format of before, where arrays and
pixels lie beside it as they are. Both are opened by turns in this run, and the first again after the clean-up, in CPU
time. After that the results are made again and compared by their hashes.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.measure import Accuracy
from engine.core.steps import Steps, part

#: Promises, in multiples of the photographs.
MAX_TIMES, MAX_TIMES_CLEAN = 20.0, 2.0

#: Widths and heights of JPEGs of an arc, and their quality: some 4 bits a pixel.
SIZES, JPEG_QUALITY = (256, 512, 1024), 90

#: Openings by turns, of which the fastest of each counts.
OPENINGS = 7

#: Real photographs that are measured as well, where the folder of test data lies beside the repository.
DOME = Path(__file__).parents[3] / "shared" / "data" / "stacks" / "ring_rti64"


def project_size(folder: Path) -> Steps[list[Accuracy]]:
    """Two figures for each capture: ten TIFFs of an arc, 32 of a dome, ten JPEGs in three sizes, and real ones."""
    found: list[Accuracy] = []
    captures = dict(_captures(folder))
    for at, (name, photographs) in enumerate(captures.items()):
        found += yield from part(
            _measure(name, photographs, folder / name), at / len(captures), (at + 1) / len(captures)
        )
    return found


def _captures(folder: Path) -> Iterator[tuple[str, Path]]:
    from engine.core.steps import drain
    from engine.simulate.arc import LightArc
    from engine.simulate.simulate import simulate

    arc = LightArc(size=384)
    around = tuple(float(each) for each in np.radians(np.arange(0.0, 360.0, 45.0)))
    dome = LightArc(elevation=tuple(np.radians((15.0, 35.0, 55.0, 75.0)).tolist()), azimuth=around, size=256)
    for name, settings in (("arc-of-10-tiffs", arc), ("dome-of-32-tiffs", dome)):
        yield name, drain(simulate(settings, folder / f"{name}-photographs")).folder
    for size in SIZES:
        name = f"arc-of-10-jpegs-{size}"
        yield (
            name,
            _as_jpegs(drain(simulate(LightArc(size=size), folder / f"{name}-tiffs")).folder, folder / f"{name}s"),
        )
    if DOME.is_dir():
        yield "dome-of-64-jpegs", DOME


def _as_jpegs(tiffs: Path, folder: Path) -> Path:
    """The photographs of a simulated capture as a camera writes them: 8 bits, compressed."""
    import imagecodecs

    from engine.storage.atomic import make_folder, write_bytes

    make_folder(folder)
    for file in tiffs.glob("*.tif"):
        levels = np.round(imagecodecs.imread(file) / 257.0).astype(np.uint8)
        write_bytes(folder / f"{file.stem}.jpg", bytes(imagecodecs.jpeg8_encode(levels, level=JPEG_QUALITY)))
    write_bytes(folder / "capture.toml", (tiffs / "capture.toml").read_bytes().replace(b".tif", b".jpg"))
    return folder


def _measure(name: str, photographs: Path, folder: Path) -> Steps[list[Accuracy]]:
    from app.commands.rebuilding import rebuild
    from app.project.cleaning import clean_up
    from app.project.made import size_of
    from app.project.photographs import files_of
    from app.project.project_file import data_folder, read

    path = yield from part(_make(photographs, folder / "new.lap"), 0.0, 0.6)
    taken = sum(file.stat().st_size for file in files_of(read(path).current))
    old = _as_before(path, folder / "old" / "old.lap")
    sizes = {each: size_of(each) + size_of(data_folder(each)) for each in (path, old)}
    opened: dict[Path, list[float]] = {path: [], old: []}
    for _ in range(OPENINGS):
        for each, times in opened.items():
            times.append(_opening_s(each))
            assert not read(each).missing
    hashes = _hashes(path)
    cleaned = yield from part(clean_up(path), 0.6, 0.7)
    opened_clean = min(_opening_s(path) for _ in range(OPENINGS))
    begun = time.perf_counter()
    yield from part(rebuild(path), 0.7, 1.0)
    details = {
        "photographs_bytes": taken,
        "before_bytes": sizes[old],
        "bytes": sizes[path],
        "cleaned_bytes": cleaned.after_bytes,
        "open_before_s": round(min(opened[old]), 4),
        "open_s": round(min(opened[path]), 4),
        "open_clean_s": round(opened_clean, 4),
        "rebuild_s": round(time.perf_counter() - begun, 2),
        "bit_equal": hashes == _hashes(path),
    }
    what = f"times the photographs: a project of {name.replace('-', ' ')}, {sizes[old] / taken:.1f} before"
    ms = [round(1e3 * seconds) for seconds in (min(opened[path]), min(opened[old]), opened_clean)]
    opening = f"it opens in {ms[0]} ms, {ms[1]} before and {ms[2]} after a clean-up"
    again = "every bit comes back" if details["bit_equal"] else "other bits come back"
    return [
        Accuracy(f"project-size-{name}", sizes[path] / taken, f"{what}; {opening}", MAX_TIMES, details),
        Accuracy(
            f"project-clean-{name}",
            cleaned.after_bytes / taken if details["bit_equal"] else float("inf"),
            f"times the photographs after a clean-up; {again} in {details['rebuild_s']} s",
            MAX_TIMES_CLEAN,
        ),
    ]


def _opening_s(path: Path) -> float:
    """Seconds of CPU time that opening a project takes."""
    from app.project.project_file import read

    begun = time.process_time()
    read(path)
    return time.process_time() - begun


def _make(photographs: Path, path: Path) -> Steps[Path]:
    """A project of these photographs, with stack and material."""
    from app.commands.making import mark_stack, material_of
    from app.document.document import ImportChoices, Project
    from app.project.photographs import files_of
    from app.project.project_file import History, Writer, data_folder
    from engine.capture.lights.sources import find
    from engine.storage.atomic import make_folder

    sources, choices, data = find([photographs]), ImportChoices(), make_folder(data_folder(path))
    project = Project(sources=sources, import_choices=choices, imported_with=choices)
    writer = Writer(path)
    writer.write(History(project))
    stack = yield from part(mark_stack(sources, choices, (data, data), files_of(project), None), 0.0, 0.7)
    project = dataclasses.replace(project, stack=stack)
    material = yield from part(material_of(project), 0.7, 1.0)
    writer.write(History(dataclasses.replace(project, material=material, built_from=project.recipe)))
    writer.close()
    return path


def _as_before(path: Path, old: Path) -> Path:
    """A copy in the format of before: arrays and pixels as .npy files."""
    from app.project.arrays import PACKED, find_beside, folder_of
    from app.project.budget import list_cached
    from app.project.copying import copy
    from app.project.project_file import data_folder, read
    from engine.core.steps import drain
    from engine.storage.atomic import discard

    drain(copy(path, old))
    for file in folder_of(data_folder(old)).glob(f"*{PACKED}"):
        _write_npy(file.with_suffix(".npy"), find_beside(data_folder(old), file.stem))
        discard(file)
    for name in list_cached(old, data_folder(old)):
        _write_npy(folder_of(data_folder(old)) / f"{name}.npy", find_beside(data_folder(old), name))
    stack = read(path).current.stack
    assert stack is not None
    assert stack.folder is not None
    for name, array in (("radiance", stack.radiance), ("saturated", stack.saturated)):
        _write_npy(data_folder(old) / stack.folder.name / f"{name}.npy", array[:])
    return old


def _write_npy(path: Path, array: np.ndarray) -> None:
    from app.project.values import array_parts
    from engine.storage.atomic import atomic_file

    with atomic_file(path) as file:
        for each in array_parts(array):
            file.write(each)


def _hashes(path: Path) -> dict[str, str]:
    """Hashes of every number of stack and material."""
    from app.project.project_file import read
    from app.project.values import array_parts, name_of

    project = read(path).current
    assert project.stack is not None
    found = {f"stack {at}": name_of(*array_parts(image)) for at, image in enumerate(project.stack.radiance)}
    found |= {f"clipped {at}": name_of(*array_parts(image)) for at, image in enumerate(project.stack.saturated)}
    for value in (project.material.shading_map, project.material.power_law, project.material.directional):
        for each in dataclasses.fields(value) if value is not None else ():
            if isinstance(array := getattr(value, each.name), np.ndarray):
                found[f"{type(value).__name__} {each.name}"] = name_of(*array_parts(array))
    return found
