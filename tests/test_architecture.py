"""The shape of the sources: who may import whom, who may write files, and what must not appear at all.

Ours instead of import-linter, because one walk over the sources serves rules of imports and of other things alike.
"""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from app.command_line import VERBS
from tests.import_graph import modules, nearest_module

PROJECT = Path(__file__).resolve().parents[1]

QT = {"PySide6", "shiboken6", "pyqtgraph"}

#: Calls that write, make or remove something on the disk, by their dotted name.
WRITING = re.compile(
    r"\.(write_text|write_bytes|touch|mkdir|makedirs|rmtree|unlink|symlink_to|hardlink_to|tofile|savez\w*|savetxt|"
    r"imwrite|TiffWriter|open_memmap|memmap|NamedTemporaryFile|TemporaryFile|TemporaryDirectory|mkstemp|mkdtemp)$"
    r"|^(np|numpy)\.save$|^os\.(open|rename|replace|remove|link)$|^shutil\.(copy\w*|move)$|^open$|\.open$|ZipFile$"
)

STREAM = "writes into the stream of an atomic file"
NULL = "the null device"
READING = "opens for reading, without waiting for a pipe"
WORKING = "the working folder of one run, removed at its end"

#: Writes that do not go through `engine.storage.atomic`, and the reason for each.
EXCEPTIONS = {
    "engine/bundle/members.py zipfile.ZipFile": STREAM,
    "engine/exchange/usd.py zipfile.ZipFile": "a package in memory",
    "engine/images/encode.py tifffile.imwrite": STREAM,
    "engine/storage/decoder_child.py os.open": NULL,
    "app/__main__.py os.open": NULL,
    "engine/storage/sandbox.py os.makedirs": "folders of a root in memory, which one process alone sees",
    "engine/storage/untrusted.py os.open": READING,
    "engine/storage/sandbox.py os.open": "a place whose reading stays allowed, or a file of that root",
    "engine/storage/resumable.py os.open": (
        "the unfinished file itself, whose writing passes what `atomic` has for that"
    ),
    "engine/capture/stack.py os.open": READING,
    "engine/storage/file_array.py os.open": READING,
    "engine/transport/baking/file_header.py os.open": READING,
    "engine/storage/scratch.py tempfile.TemporaryFile": "an unnamed file that vanishes with the process",
    "engine/storage/unpack.py tempfile.TemporaryFile": "an unnamed file that vanishes with the process",
    "engine/storage/spilling.py os.open": "an unnamed file, by which is found whether there can be one",
    "engine/capture/lights/sources.py tempfile.TemporaryDirectory": "unpacked photographs, removed with their sources",
    "engine/storage/scratch.py np.memmap": "an unnamed file that vanishes with the process",
    "engine/exchange/blender.py tempfile.TemporaryDirectory": "what Blender makes a file of, removed with it",
    "engine/exchange/readers/archive.py tempfile.TemporaryDirectory": "unpacked textures, removed with it",
    "engine/geometry/usd.py tempfile.TemporaryDirectory": "copies for one process that reads them, removed with it",
    "lightarc/_inputs.py tempfile.TemporaryDirectory": "copies of open files and arrays, removed with the block",
    "app/session/settings.py base.mkdir": WORKING,
    "app/session/settings.py tempfile.mkdtemp": WORKING,
    "app/cli/bundle.py tempfile.mkdtemp": "a page that a browser reads after the command has ended",
    "app/window/projects.py tempfile.mkdtemp": "a project whose own folder cannot be written",
    "app/session/settings.py shutil.rmtree": WORKING,
    "app/cli/transport/render_transport.py tempfile.TemporaryDirectory": "a bake for one image, removed with it",
    "engine/proof/blender.py tempfile.TemporaryDirectory": "an image that Blender draws, removed with it",
    "engine/proof/libraries.py tempfile.TemporaryDirectory": "a model that another program reads, removed with it",
    "engine/proof/programs.py tempfile.TemporaryDirectory": "a page that a browser reads, removed with it",
    "engine/proof/programs.py (site / 'material.glb').symlink_to": "in that folder",
    "engine/proof/programs.py (site / 'three').symlink_to": "in that folder",
    "engine/planning/costs/machine_profile.py tempfile.TemporaryDirectory": "a bake that is measured, removed with it",
    "engine/transport/reuse.py tempfile.TemporaryDirectory": "a bake of another BRDF, removed when it is read",
    "engine/planning/bake_group.py tempfile.TemporaryDirectory": "a bake that is measured, removed with it",
    "engine/accuracy/bake_check.py tempfile.TemporaryDirectory": "a bake that is compared, removed with it",
    "app/arguments/common.py self.path.open": "a log, which is read while work goes on, and after a crash",
    "app/process/crash.py path.open": "the report of a crash, which is written while the process falls",
    "app/process/crash.py path.unlink": "reports of crashes that are empty or too many",
    "app/session/settings.py folder.mkdir": "an empty folder for the settings",
}

#: Who may catch everything, and why.
CATCHERS = {
    "app/project/recording.py Exception": "the border of a thread: work that cannot be recorded is said, and goes on",
    "app/jobs/jobs.py BaseException": "the border of a thread: whatever was raised becomes the job's outcome",
    "app/batch/worker.py Exception": "the border of a process: whatever was raised is the failure of one capture",
    "app/viewport/gl_surface.py Exception": (
        "the border of a paint event: Qt would raise it in whatever Python code runs next"
    ),
    "app/command_line.py Exception": (
        "the border of a verb: OpenCV has its own error for too little memory; all else is raised again"
    ),
    "lightarc/_border.py Exception": "the border of the library: nothing but its own errors leaves it",
    "engine/core/plugins.py Exception": "code of other packages, which must not keep the program from starting",
    "engine/gl/context.py Exception": "moderngl raises plain Exception; every other type is raised again",
}


def sources(*folders: str) -> list[Path]:
    return [path for folder in folders for path in sorted((PROJECT / folder).rglob("*.py"))]


def name_of(path: Path) -> str:
    return path.relative_to(PROJECT).as_posix()


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(tree_of(path)))


def imports_of(path: Path) -> Iterator[str]:
    """Dotted names that a file imports anywhere, a name taken from a package counted as its module."""
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name_of(path)}:{node.lineno} imports relatively"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@cache
def packages_of(path: Path) -> set[str]:
    return {name.split(".")[0] for name in imports_of(path)}


def test_engine_knows_neither_qt_nor_app() -> None:
    assert [name_of(path) for path in sources("engine") if packages_of(path) & (QT | {"app", "lightarc"})] == []


def test_only_the_drawing_side_imports_moderngl() -> None:
    users = {name_of(path) for path in sources("engine", "app") if "moderngl" in packages_of(path)}
    assert not {name for name in users if not name.startswith("engine/gl/")} - {"app/viewport/viewport.py"}


def test_the_command_line_starts_without_heavy_libraries() -> None:
    heavy = {"numba", "cv2", "scipy", "moderngl", "rawpy", "trimesh", *QT}
    program = "import sys; from app.command_line import build_parser; build_parser('-h'); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=PROJECT)
    assert not heavy & set(loaded.stdout.split())


def runtime_imports(path: Path) -> set[str]:
    """Dotted names that a module imports when it runs, within functions too, but not for type checkers alone."""
    found: set[str] = set()
    waiting: list[ast.AST] = [tree_of(path)]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{name.name}" for name in node.names}
        elif not (isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)):
            waiting += ast.iter_child_nodes(node)
    return found


def test_all_verbs_but_gui_run_without_qt() -> None:
    """An installation without the extra `gui` has no PySide6."""
    waiting = [module for name, module, _ in VERBS if name not in ("gui", "bench")]
    came_from: dict[str, str] = dict.fromkeys(waiting, "a verb")
    while waiting:
        module = waiting.pop()
        names = runtime_imports(modules()[module])
        assert not {name.split(".")[0] for name in names} & QT, f"{module}, imported by {came_from[module]}"
        for other in filter(None, map(nearest_module, names)):
            if other not in came_from:
                came_from[other] = module
                waiting.append(other)


def test_the_package_starts_without_libraries() -> None:
    """Every module of an installation is imported after it, those of decoders among them."""
    program = "import lightarc, sys; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=PROJECT)
    assert not {"numpy", "app"} & set(loaded.stdout.split())


def writing_calls(path: Path) -> Iterator[str]:
    for node in nodes_of(path):
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            if WRITING.search(called) and not called.startswith("atomic.") and not reads_only(node, called):
                yield f"{name_of(path)} {called}"


def reads_only(call: ast.Call, called: str) -> bool:
    """True if a call that might write only reads: `open(path, "rb")`, `memmap(…, mode="r")`, `document.open(path)`."""
    if called == "os.open":
        return False
    position = 0 if called.endswith(".open") else 1
    modes = [word.value for word in call.keywords if word.arg == "mode"] or call.args[position : position + 1]
    mode = modes[0].value if modes and isinstance(modes[0], ast.Constant) else None
    if called.endswith(".open"):
        return not (isinstance(mode, str) and re.fullmatch(r"[rwaxbt+]*[wax+][rwaxbt+]*", mode))
    if called.endswith(("open", "ZipFile")) and not modes:
        return True
    return mode in {"r", "rb", "rt", "c"}


def test_files_are_written_in_one_place() -> None:
    calls = {call for path in sources("engine", "app", "lightarc") for call in writing_calls(path)}
    calls = {call for call in calls if not call.startswith("engine/storage/atomic.py ")}
    assert sorted(calls - set(EXCEPTIONS)) == []
    assert sorted(set(EXCEPTIONS) - calls) == [], "exceptions that nobody needs any more"


def test_nothing_is_pickled() -> None:
    everywhere = sources("engine", "app", "lightarc", "benchmarks", "packaging")
    pickling = {"pickle", "dill", "cloudpickle", "joblib", "shelve", "marshal"}
    assert [name_of(path) for path in everywhere if packages_of(path) & pickling] == []
    keywords = ((path, node) for path in everywhere for node in nodes_of(path) if isinstance(node, ast.keyword))
    allowing = [(path, node) for path, node in keywords if node.arg == "allow_pickle"]
    assert [(name_of(path), node.lineno) for path, node in allowing if ast.unparse(node.value) != "False"] == []


def test_failures_are_caught_by_name() -> None:
    """`except:` and `except Exception` hide mistakes; `except BaseException` may tidy up if it raises again."""
    found = []
    for path in sources("engine", "app", "lightarc", "benchmarks", "packaging"):
        for node in nodes_of(path):
            if not isinstance(node, ast.ExceptHandler):
                continue
            caught = ast.unparse(node.type) if node.type else "everything"
            raised_again = caught == "BaseException" and isinstance(node.body[-1], ast.Raise)
            if caught in {"everything", "Exception", "BaseException"} and not raised_again:
                found.append((f"{name_of(path)} {caught}", node.lineno))
    assert [(name, line) for name, line in found if name not in CATCHERS] == []


def text_files() -> Iterator[Path]:
    folders = ("app", "engine", "lightarc", "resources", "benchmarks", "docs", "tests", "packaging", ".ci")
    yield from (path for path in PROJECT.iterdir() if path.is_file() and path.name != ".git")  # a file in a worktree
    for folder in folders:
        yield from (
            path for path in (PROJECT / folder).rglob("*") if path.is_file() and "__pycache__" not in path.parts
        )


def test_no_file_names_a_machine_or_a_package_index() -> None:
    places = re.compile(
        rb"/(?:home|Users|root|work|tmp)/\w\w|C:\\Users|https?://[\w.]*(?:pypi\.org|pythonhosted|debian\.org)|index-url\s*="
    )
    assert [name_of(path) for path in text_files() if path != Path(__file__) and places.search(path.read_bytes())] == []


@pytest.mark.parametrize(("name", "module_name", "text"), VERBS, ids=[name for name, _, _ in VERBS])
def test_every_verb_explains_itself(name: str, module_name: str, text: str) -> None:
    verb = importlib.import_module(module_name)
    assert text.strip()
    assert verb.EXAMPLE.startswith(f"lightarc {name}")


def lock(name: str) -> dict[str, list[str]]:
    """Package → its locked versions; asserts that each entry is pinned exactly and carries hashes."""
    versions: dict[str, list[str]] = {}
    entries = re.split(r"\n(?=\S)", (PROJECT / "packaging" / name).read_text(encoding="utf-8").strip())
    for entry in entries:
        pinned = re.match(r"([\w.-]+)==(\S+)", entry)
        assert pinned, f"{name}: not pinned: {entry.splitlines()[0]}"
        assert re.findall(r"--hash=sha256:[0-9a-f]{64}\b", entry), f"{name}: {pinned[0]} has no hash"
        versions.setdefault(canonicalize_name(pinned[1]), []).append(pinned[2])
    return versions


@pytest.mark.parametrize(
    ("name", "extras"),
    [("requirements.lock", ["gui", "build"]), ("requirements-test.lock", ["gui", "build", "manual", "test"])],
)
def test_lock_files_pin_what_the_project_asks_for(name: str, extras: list[str]) -> None:
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *(line for extra in extras for line in project["optional-dependencies"][extra])]
    versions = lock(name)
    for requirement in map(Requirement, wanted):
        found = versions.get(canonicalize_name(requirement.name), [])
        assert found, f"{requirement.name} is not locked; see packaging/lock.py"
        assert all(requirement.specifier.contains(version) for version in found), f"{requirement} is locked at {found}"


def test_tests_run_on_the_versions_that_users_get() -> None:
    tests = lock("requirements-test.lock")
    assert {name: tests.get(name) for name in lock("requirements.lock")} == lock("requirements.lock")
