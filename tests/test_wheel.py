"""The wheel: one top-level package, whose modules know nothing of the names that they have in the repository."""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

import engine

PROJECT = Path(__file__).resolve().parents[1]

MODULES = {"engine", "engine.pots", "engine.vase", "app", "app.wheel"}

#: A user's own modules, of the names that Lightarc's folders have in the repository.
HOSTILE = dict.fromkeys(("app.py", "engine.py"), "raise SystemExit('a module of the user was imported')\n")

SCRIPT = """
import lightarc

lightarc.simulate_capture("capture", sample="plain", elevations_deg=(30, 60, 90), size=32)
stack = lightarc.import_capture("capture", "stack", motion="none")
material = lightarc.compress_material(lightarc.build_material(stack, slices=3))
lightarc.save_bundle("plain.lightarc", material)
assert lightarc.verify_bundle("plain.lightarc").ok
lightarc.save_image("plain.png", lightarc.render("sphere", material=material, size=(16, 12), samples=1))
lightarc.bake("plane", "lambert", "plane.transport", method="sh", order=3)
"""


def backend() -> ModuleType:
    spec = importlib.util.spec_from_file_location("wheel_backend", PROJECT / "packaging" / "wheel_backend.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_names_of_modules_are_changed_and_lines_stay() -> None:
    source = '''"""Speaks of `engine.vase`."""
import engine
import engine.vase as shapes
from app import wheel
from engine.pots import (
    InputError,
)

ä, TABLE = "ä", ("engine.vase:decode", f"app.wheel:{ä}", "an engine", "my.engine.vase")  # engine.vase
START = """
from engine.pots import InputError
"""
'''
    assert (
        backend().rewrite(source, MODULES)
        == '''"""Speaks of `engine.vase`."""
from lightarc import engine
from lightarc.engine import vase as shapes
from lightarc.app import wheel
from lightarc.engine.pots import (
    InputError,
)

ä, TABLE = "ä", ("lightarc.engine.vase:decode", f"lightarc.app.wheel:{ä}", "an engine", "my.engine.vase")  # engine.vase
START = """
from lightarc.engine.pots import InputError
"""
'''
    )


@pytest.mark.parametrize(
    "source",
    [
        'TABLE = ["engine.nothing:decode"]',
        'run([python, "-m", "app"])',
        'run("-m", "app")',
        "import engine.vase",
        "import os, engine",
        'TABLE = ["engine.va" "se:decode"]',
    ],
)
def test_a_name_that_cannot_be_changed_ends_the_build(source: str) -> None:
    unclear = backend()
    with pytest.raises(unclear.UnclearName, match=r"^1: "):
        unclear.rewrite(source, MODULES)


def test_all_modules_lie_in_one_package_and_import_nothing_above_it(
    tmp_path_factory: pytest.TempPathFactory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wheel = backend()
    monkeypatch.setattr(wheel, "MANUAL", tmp_path_factory.mktemp("html"))
    (wheel.MANUAL / "index.html").write_text("the manual")
    wheel.stage(PROJECT, tmp_path)
    assert (tmp_path / "lightarc" / "resources" / "manual" / "html" / "index.html").is_file()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["LICENSE", "README.md", "lightarc", "pyproject.toml"]
    for folder in ("app", "engine", "resources"):
        own = {path.relative_to(PROJECT) for path in (PROJECT / folder).rglob("*.*") if "__pycache__" not in path.parts}
        assert all((tmp_path / "lightarc" / path).exists() for path in own)
    candidate = re.compile(r"\b(?:from|import)\s[^\n]*(?<!\.)\b(?:app|engine|resources)\b")
    for path in (tmp_path / "lightarc").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if not candidate.search(text):
            continue  # few lines look like it, and parsing takes long
        tree = ast.parse(text, filename=str(path))
        nodes = list(ast.walk(tree))
        imported = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
        imported |= {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)}
        assert not {name for name in imported if re.match(r"(app|engine|resources)\b", name)}, path


def test_the_version_stands_in_one_place() -> None:
    names = [path for folder in ("app", "engine", "lightarc", "packaging") for path in (PROJECT / folder).rglob("*.py")]
    names += [PROJECT / "pyproject.toml", PROJECT / "README.md", PROJECT / "packaging" / "CHANGELOG.md"]
    saying = [path for path in names if engine.__version__ in path.read_text(encoding="utf-8")]
    assert saying == [PROJECT / "engine" / "__init__.py"]


@pytest.mark.long
def test_an_installation_works_beside_modules_of_the_same_names(tmp_path: Path) -> None:
    """Wheel, empty environment, demo and script, in a folder with an app.py, an engine.py and a resources/."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def call(*words: str | Path, cwd: Path = tmp_path) -> None:
        done = subprocess.run([*map(str, words)], cwd=cwd, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr

    call(*pip, "wheel", PROJECT, "--no-deps", "--no-build-isolation", "-w", tmp_path)
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name.startswith(f"lightarc-{engine.__version__}-")
    folders = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {name for name in folders if not name.endswith(".dist-info")} == {"lightarc"}
    home = tmp_path / "environment"
    venv.create(home)
    paths = {name: Path(sysconfig.get_path(name, vars={"base": str(home)})) for name in ("purelib", "scripts")}
    # A .pth file brings the dependencies, and not the editable installation, since files of its kind are not followed.
    (paths["purelib"] / "dependencies.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
    python = paths["scripts"] / "python"
    call(*pip, "--python", python, "install", "--no-deps", "--no-index", wheel)

    work = tmp_path / "work"
    (work / "resources").mkdir(parents=True)
    for name, content in HOSTILE.items():
        (work / name).write_text(content, encoding="utf-8")
    (work / "resources" / "__init__.py").write_text(HOSTILE["app.py"], encoding="utf-8")
    (work / "script.py").write_text(SCRIPT, encoding="utf-8")
    call(python, "script.py", cwd=work)
    assert (work / "plain.png").exists()
    call(paths["scripts"] / "lightarc", "demo", "-o", "out", cwd=work)
    assert (work / "out" / "contact_sheet.png").exists()
    call(python, "-m", "lightarc", "bundle", "verify", "out/woven.lightarc", cwd=work)
