"""The rooms of the house: every folder of sources is one, and imports point down from floor to floor."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path, PurePosixPath

import pytest

PROJECT = Path(__file__).resolve().parents[1]

#: All rooms, lowest first: each imports itself and rooms before it, also for type checkers and within functions.
ROOMS = (
    "engine/core",
    "engine/storage",
    "engine/images",
    "engine/geometry",
    "engine/light",
    "engine/capture/photograph",
    "engine/capture/lights",
    "engine/capture/registration",
    "engine/capture",
    "engine/brdf/models",
    "engine/brdf",
    "engine/brdf/readers",
    "engine/factor/solvers",
    "engine/factor",
    "engine/shading/directional",
    "engine/shading",
    "engine/surface",
    "engine/scene",
    "engine/transport/baking",
    "engine/transport/sh",
    "engine/transport/wavelet",
    "engine/transport/gaussian/fitting",
    "engine/transport/gaussian",
    "engine/transport",
    "engine/render",
    "engine/simulate",
    "engine/gl",
    "engine/gl/reflectance",
    "engine/accuracy",
    "engine/planning/costs",
    "engine/planning/effects",
    "engine/planning/methods",
    "engine/planning",
    "engine/bundle",
    "engine/exchange/readers",
    "engine/exchange",
    "engine/figures",
    "engine/figures/papers",
    "engine/proof",
    "engine/tradeoff",
    "engine/selftest",
    "engine/selftest/generated",
    "engine/bench",
    "engine/bench/transport",
    "app/process",
    "app/arguments",
    "app/jobs",
    "app/session",
    "app/widgets",
    "app/viewport",
    "app/document",
    "app/project",
    "app/commands",
    "app/capture",
    "app/material",
    "app/brdf",
    "app/factor",
    "app/varying",
    "app/view",
    "app/export",
    "app/docks",
    "app/help",
    "app/window",
    "app/bench",
    "app/cli",
    "app/cli/shading",
    "app/cli/transport",
    "app",
)

#: Modules in a room, at most.
MOST = 16

#: Lines of a file: a noun mostly takes as many.
SHORT, LONG = 60, 400

#: Files with fewer lines, and why.
SHORT_FILES = {
    "engine/core/side_by_side.py": "one loop, which several rooms share",
    "app/material/tiling.py": "three rows, which two pages share",
    "engine/render/layers.py": "two layers of one loop over the pixels",
    "engine/capture/stack_record.py": "the record of a file, apart so that pydantic is loaded with the first one",
    "engine/capture/photograph/kinds.py": "suffixes, which the window asks for before it loads a reader",
    "engine/exchange/web.py": "one target, whose page is that of a bundle",
    "app/arguments/options.py": "options made of declared settings, for several verbs",
    "app/arguments/usage.py": "exit codes and wrong usage, which every verb needs and nothing else",
    "app/capture/picture_bar.py": "one widget",
    "app/cli/demo.py": "one verb of the command line",
    "app/cli/transport/method_options.py": "options of all methods, for verbs that bake",
    "app/cli/gui.py": "one verb of the command line",
    "app/cli/doubts.py": "one idea of all verbs",
    "app/commands/drawable.py": "one idea that three workspaces share",
    "app/commands/opening.py": "models and lights by name or file, for the window and for bundles",
    "app/widgets/fitting.py": "one widget",
    "app/document/history.py": "arithmetic of what undo keeps, without Qt",
    "app/document/scene.py": "the scene of a project, which window and command line share",
    "app/process/garbage.py": "one setting of Python",
    "app/process/packages.py": "one way around a fault of Python",
    "app/process/last_words.py": "one way to end",
    "app/view/views_menu.py": "one menu",
    "app/window/naming.py": "one proposal",
    "engine/bench/brdf.py": "one measurement",
    "engine/bench/measure.py": "what every measurement returns",
    "engine/bench/prefilter.py": "one measurement",
    "engine/bench/tables.py": "one measurement",
    "engine/bench/transport/frame.py": "one measurement",
    "engine/bench/transport/gaussian.py": "one measurement",
    "engine/bench/transport/lobe.py": "one measurement",
    "engine/core/quickselect.py": "one algorithm that kernels of two rooms share",
    "engine/capture/lights/azimuth_spread.py": "one assumption of the method, checked in one place",
    "engine/capture/photograph/demosaic.py": "the choice between two kernels",
    "engine/render/pbr.py": "PBR maps at points, which the two renderers of the processor share",
    "engine/core/kernels.py": "the compiler's settings; whoever does not compile must not load it",
    "engine/core/interrupts.py": "apart from what it guards: OpenGL and pictures that are compared",
    "engine/core/one_thread.py": "apart from kernels, so that it is there without the compiler",
    "engine/surface/metallic_roughness.py": "one formula, that of the glTF specification",
    "engine/figures/papers/catalogue.py": "one figure",
    "engine/figures/papers/green_6.py": "one figure",
    "engine/figures/papers/green_7.py": "one figure",
    "engine/gl/light_texture.py": "two small textures",
    "engine/images/codes.py": "a kernel that the decoder child alone compiles",
    "engine/planning/bake.py": "the bake that a plan calls for, whatever the method",
    "engine/planning/ceilings.py": "one value: what a plan may cost",
    "engine/planning/effects/relative_error.py": "one figure, which effects and methods share",
    "engine/proof/blender_child.py": "a process of its own, for Blender's Python",
    "engine/proof/mitsuba_child.py": "a process of its own, for one library",
    "engine/render/display.py": "what both renderers are told of the picture",
    "engine/selftest/case.py": "what every case of the self-test is",
    "engine/selftest/confinement.py": "one hard case",
    "engine/selftest/generated/law.py": "the type of every law, and the draws that they share",
    "engine/simulate/built_in.py": "apart from what simulates it, which is loaded where it must be made",
    "engine/shading/compile.py": "kernels compiled before they are needed",
    "engine/shading/directional/codes_kernel.py": "a kernel, apart so that it is compiled when it is first needed",
    "engine/shading/directional/minified.py": "its kernel apart, which loads the compiler",
    "engine/shading/linearise.py": "a kernel, apart so that reading a map does not load the compiler",
    "engine/shading/mixed.py": "one formula with its bound",
    "engine/storage/partial_names.py": "names that three modules of the room share",
    "engine/storage/text.py": "one encoding, turned into another",
}

#: Files with more lines, and why. A file that comes here is divided first; the list only gets shorter.
LONG_FILES = {
    "app/material/tab.py": "one workspace; its panels are files of their own",
    "engine/capture/lights/sources.py": "the photographs of a capture, from files, folders and archives",
    "app/brdf/tab.py": "one workspace; its panels are files of their own",
    "app/window/main_window.py": "the window, which connects all that lies in it",
    "app/capture/tab.py": "one workspace; its panels are files of their own",
    "app/view/tab.py": "one workspace; its panels are files of their own",
    "engine/light/gaussian_prefilter_kernel.py": "one kernel and its steps, compiled together",
    "engine/planning/costs/machine_profile.py": "one measurement for each rate of the cost model",
    "engine/storage/atomic.py": "every way of writing a file, where one place is the point",
    "engine/storage/untrusted.py": "the protocol with the decoder child, from both ends",
    "engine/surface/texel_kernel.py": "one kernel and its steps, compiled together",
    "engine/tradeoff/sweep.py": "one sweep over all methods",
    "engine/transport/gaussian/bake.py": "one bake, step after step",
    "engine/transport/gaussian/fitting/view_kernel.py": "one kernel and its steps, compiled together",
}


@cache
def modules() -> dict[str, Path]:
    """Dotted name → file of every module of the program."""
    found = {}
    for path in sorted(path for top in ("engine", "app") for path in (PROJECT / top).rglob("*.py")):
        found[".".join(path.relative_to(PROJECT).with_suffix("").parts).removesuffix(".__init__")] = path
    return found


def room_of(module: str) -> str:
    return modules()[module].parent.relative_to(PROJECT).as_posix()


def imported(module: str) -> Iterator[tuple[int, str]]:
    """Line and name of every module of ours that a module imports, wherever it does.

    Lists of modules by name (verbs, methods, measurements, figures) are the seams where a low room is given what it
    calls; they are no imports.
    """
    known = modules()
    for node in ast.walk(ast.parse(known[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                if full in known or node.module in known:
                    yield node.lineno, full if full in known else str(node.module)


def lines_of(path: Path) -> int:
    return path.read_text(encoding="utf-8").count("\n")


def files() -> list[tuple[str, int]]:
    """Name and lines of every file that holds something of its own."""
    paths = (path for path in modules().values() if path.name not in {"__init__.py", "__main__.py"})
    return [(path.relative_to(PROJECT).as_posix(), lines_of(path)) for path in paths]


def test_every_folder_is_a_room_and_every_room_a_folder() -> None:
    rooms = {room_of(name) for name, path in modules().items() if path.name != "__init__.py"}
    assert sorted(rooms) == sorted(ROOMS)


@pytest.mark.parametrize("room", ROOMS)
def test_imports_point_down(room: str) -> None:
    """With one order for all rooms there is no cycle among them."""
    below = set(ROOMS[: ROOMS.index(room) + 1]) | {"engine", "app"}
    upward = [
        f"{modules()[name].relative_to(PROJECT)}:{line} imports {other}"
        for name in modules()
        if room_of(name) == room
        for line, other in imported(name)
        if room_of(other) not in below and modules()[other].name != "__init__.py"
    ]
    assert upward == []


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_can_be_overlooked(room: str) -> None:
    assert len([path for path in (PROJECT / room).glob("*.py") if path.name != "__init__.py"]) <= MOST


@pytest.mark.parametrize("room", [room for room in ROOMS if room not in {"engine", "app"}])
def test_a_room_says_in_one_sentence_what_it_is(room: str) -> None:
    """The sentence is that of ARCHITECTURE.md; nothing else stands in `__init__.py`."""
    (sentence,) = ast.parse((PROJECT / room / "__init__.py").read_text(encoding="utf-8")).body
    assert isinstance(sentence, ast.Expr)
    assert isinstance(sentence.value, ast.Constant)
    said = str(sentence.value.value)
    assert said.endswith(".")
    assert f"| `{room}` | {said[:-1]} |" in (PROJECT / "ARCHITECTURE.md").read_text(encoding="utf-8")


def test_rooms_stand_one_upon_the_other() -> None:
    """The engine is complete before the window begins."""
    tops = [PurePosixPath(room).parts[0] for room in ROOMS]
    assert [pair for pair in pairwise(tops) if pair == ("app", "engine")] == []


def test_files_have_the_size_of_one_noun() -> None:
    short = {name for name, lines in files() if lines < SHORT}
    long = {name for name, lines in files() if lines > LONG}
    assert sorted(short ^ set(SHORT_FILES)) == []
    assert sorted(long ^ set(LONG_FILES)) == []


def test_tests_lie_where_their_sources_lie() -> None:
    tests = {path.parent.relative_to(PROJECT / "tests").as_posix() for path in (PROJECT / "tests").rglob("*.py")}
    assert sorted(tests - set(ROOMS) - {".", "engine", "app"}) == []
