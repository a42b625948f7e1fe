"""Set-up and start, without network: what packaging/dev.py decides, says and leaves behind."""

from __future__ import annotations

import ast
import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

DEV = Path(__file__).resolve().parents[1] / "packaging" / "dev.py"


def load() -> ModuleType:
    module = ModuleType("dev")
    module.__file__ = str(DEV)
    exec(compile(DEV.read_text(encoding="utf-8"), DEV, "exec"), vars(module))
    return module


@pytest.fixture
def dev(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The script as a module that takes an empty folder for the project."""
    module = load()
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    for name in ("run", "test"):
        (tmp_path / f"{name}.lock").write_text(f"{name}==1\n")
    environment = tmp_path / ".venv"
    places = {
        "PROJECT": tmp_path,
        "ENVIRONMENT": environment,
        "PROGRAMS": environment / module.PROGRAMS.name,
        "PYTHON": environment / module.PROGRAMS.name / module.PYTHON.name,
        "UNFINISHED": environment / "unfinished",
        "LOG": environment / "log",
        "LOCKS": {name: tmp_path / f"{name}.lock" for name in ("run", "test")},
        "RESULTS": tmp_path / "build" / "demo",
    }
    for name, place in places.items():
        monkeypatch.setattr(module, name, place)
    return module


@pytest.fixture
def installed(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Replace the two parts of set-up that need the outside world; the list says what was installed."""
    done: list[str] = []
    monkeypatch.setattr(dev, "provide_system_packages", lambda purpose, with_venv: None)
    monkeypatch.setattr(dev, "install_packages", done.append)
    without_pip(dev, monkeypatch)
    return done


def without_pip(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make `.venv` a bare file tree, so that a test takes milliseconds."""

    def make() -> None:
        if not dev.is_sound():
            shutil.rmtree(dev.ENVIRONMENT, ignore_errors=True)
            dev.PYTHON.parent.mkdir(parents=True)
            dev.PYTHON.touch()

    monkeypatch.setattr(dev, "make_environment", make)
    monkeypatch.setattr(dev, "is_sound", lambda: dev.PYTHON.exists() and not dev.UNFINISHED.exists())


def test_only_the_standard_library_is_imported() -> None:
    tree = ast.parse(DEV.read_text(encoding="utf-8"), feature_version=(3, 8))
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imported |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert {name.split(".")[0] for name in imported} <= sys.stdlib_module_names


def test_an_old_python_is_reported_in_a_sentence(
    dev: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(dev.sys, "version_info", (3, 10, 4, "final", 0))
    assert dev.main(["run"]) == 5
    assert "needs Python 3.11 or newer" in capsys.readouterr().err


def test_words_after_two_dashes_are_handed_on_unread(dev: ModuleType) -> None:
    assert dev.parse(["run"]) == ("run", [])
    assert dev.parse(["run", "--", "demo", "-o", "out", "--", "x"]) == ("run", ["demo", "-o", "out", "--", "x"])
    assert dev.parse(["test", "--", "-k", "X8"]) == ("test", ["-k", "X8"])
    assert dev.parse(["bench", "--", "--large"]) == ("bench", ["--large"])
    assert dev.parse(["manual", "--", "folder"]) == ("manual", ["folder"])
    verb, rest = dev.parse(["test", "--long", "--", "-m", "long"])
    assert (verb, rest[0], rest[-2:]) == ("test", "--long", ["-m", "long"])
    with pytest.raises(SystemExit):
        dev.parse(["run", "--long"])


def test_wrong_usage_ends_with_2(dev: ModuleType) -> None:
    with pytest.raises(SystemExit) as ended:
        dev.main(["dance"])
    assert ended.value.code == 2


def test_a_second_set_up_installs_nothing(dev: ModuleType, installed: list[str]) -> None:
    dev.set_up("run")
    dev.set_up("run")
    assert installed == ["run"]


def test_what_tests_need_serves_a_run_but_not_the_reverse(dev: ModuleType, installed: list[str]) -> None:
    dev.set_up("run")
    dev.set_up("test")
    dev.stamp_of("run").unlink()
    dev.set_up("run")
    assert installed == ["run", "test"]


@pytest.mark.parametrize("changed", ["run.lock", "pyproject.toml"])
def test_a_changed_declaration_is_installed(dev: ModuleType, installed: list[str], changed: str) -> None:
    dev.set_up("run")
    with (dev.PROJECT / changed).open("a") as file:
        file.write("# changed\n")
    dev.set_up("run")
    assert installed == ["run", "run"]


def test_another_python_is_set_up_anew(dev: ModuleType, installed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    dev.set_up("run")
    monkeypatch.setattr(dev, "python_version", lambda: "3.99")
    dev.set_up("run")
    assert installed == ["run", "run"]


def test_an_interrupted_set_up_starts_from_a_fresh_environment(
    dev: ModuleType, installed: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(purpose: str) -> None:
        (dev.ENVIRONMENT / "half").touch()
        raise KeyboardInterrupt

    monkeypatch.setattr(dev, "install_packages", interrupt)
    assert dev.main(["run"]) == 4
    assert "takes the set-up up again" in capsys.readouterr().err
    monkeypatch.setattr(dev, "install_packages", installed.append)
    dev.set_up("run")
    assert installed == ["run"]
    assert not (dev.ENVIRONMENT / "half").exists()
    assert dev.is_ready("run")
    dev.UNFINISHED.touch()
    assert not dev.is_ready("run")


def test_a_half_made_environment_is_repaired(dev: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    dev.PYTHON.parent.mkdir(parents=True)
    dev.PYTHON.write_text("not an interpreter")
    assert not dev.is_sound()
    dev.make_environment()
    assert dev.is_sound()
    capsys.readouterr()
    dev.make_environment()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("output", "sentence"),
    [
        ("ERROR: THESE PACKAGES DO NOT MATCH THE HASHES FROM THE REQUIREMENTS FILE.", "differs from the one"),
        ("OSError: [Errno 28] No space left on device", "disk is full"),
        ("ERROR: No matching distribution found for numpy==9", "no fitting build"),
        ("NewConnectionError: Failed to establish a new connection", "cannot be reached"),
        ("SSLError: CERTIFICATE_VERIFY_FAILED", "certificate"),
        ("something\nelse\n\n", "pip failed (else)"),
    ],
)
def test_a_failing_pip_is_explained_in_a_sentence(dev: ModuleType, output: str, sentence: str) -> None:
    assert sentence in dev.meaning_of(output)


def test_a_failing_pip_leaves_its_words_and_no_stamp(
    dev: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(dev, "provide_system_packages", lambda purpose, with_venv: None)
    without_pip(dev, monkeypatch)
    program = "print('No space left on device'); raise SystemExit(1)"
    child = dev.child
    monkeypatch.setattr(dev, "child", lambda _, **options: child([sys.executable, "-c", program], **options))
    assert dev.main(["run"]) == 5
    assert "disk is full" in capsys.readouterr().err
    assert "No space left" in dev.LOG.read_text()
    assert not dev.stamp_of("run").exists()
    assert not dev.UNFINISHED.exists()


@pytest.mark.skipif(sys.platform != "linux", reason="system libraries come by package manager on Linux alone")
class TestSystemPackages:
    def test_those_that_the_linker_finds_are_not_asked_for(self, dev: ModuleType) -> None:
        assert dev.can_load("libc.so.6")
        assert not dev.can_load("libnosuchthing.so.1")

    def test_a_user_without_privilege_gets_the_line_to_type(
        self, dev: ModuleType, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(dev, "can_load", lambda library: library != "libEGL.so.1")
        monkeypatch.setattr(dev.shutil, "which", lambda name: f"/usr/bin/{name}")
        monkeypatch.setattr(dev, "apt_privilege", lambda: None)
        with pytest.raises(dev.SetupError, match=r"Type: sudo apt-get install -y --no-install-recommends libegl1$"):
            dev.provide_system_packages("test", with_venv=False)

    def test_other_systems_get_their_own_line(self, dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(dev, "can_load", lambda library: False)
        monkeypatch.setattr(dev.shutil, "which", lambda name: "/usr/bin/dnf" if name == "dnf" else None)
        with pytest.raises(dev.SetupError, match="Type: sudo dnf install "):
            dev.provide_system_packages("run", with_venv=False)

    def test_only_tests_need_an_x_server(self, dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
        asked: list[Sequence[str]] = []
        monkeypatch.setattr(dev, "can_load", lambda library: True)
        monkeypatch.setattr(dev.shutil, "which", lambda name: None if name == "Xvfb" else f"/usr/bin/{name}")
        monkeypatch.setattr(dev, "install_with_apt", asked.append)
        dev.provide_system_packages("run", with_venv=False)
        dev.provide_system_packages("test", with_venv=False)
        assert asked == [["xvfb"]]


@pytest.fixture
def called(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """The commands that would have been run, each with exit code 0."""
    calls: list[list[str]] = []

    def call(command: Sequence[str], environment: object = None) -> int:
        calls.append(list(command[1:]))
        return 0

    monkeypatch.setattr(dev, "call", call)
    monkeypatch.setattr(dev.sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    return calls


def test_with_a_display_the_window_opens(
    dev: ModuleType, called: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert dev.run([]) == 0
    assert called == [["gui"]]


def test_without_a_display_the_demo_says_where_its_results_are(
    dev: ModuleType, called: list[list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert dev.run([]) == 0
    assert called == [["demo", "-o", str(dev.RESULTS)]]
    assert str(dev.RESULTS) in capsys.readouterr().err


def test_arguments_go_to_lightarc_as_they_are(dev: ModuleType, called: list[list[str]]) -> None:
    dev.run(["demo", "-o", "out"])
    assert called == [["demo", "-o", "out"]]


@pytest.mark.skipif(not shutil.which("Xvfb"), reason="Xvfb is not installed")
@pytest.mark.parametrize(
    ("codes", "expected"), [([0, 0, 0, 0], 0), ([0, 3, 4, 0], 3), ([0, 0, 0, 1], 1), ([2, 0, 0, 1], 2)]
)
def test_every_stage_runs_and_the_first_failure_counts(
    dev: ModuleType, monkeypatch: pytest.MonkeyPatch, codes: list[int], expected: int
) -> None:
    stages: list[str] = []

    def start(command: Sequence[str], **options: Any) -> subprocess.Popen[str]:
        if command[0] != str(dev.PYTHON):
            return started(command, **options)
        stages.append(command[2])
        if command[2] == "mypy":
            assert options["env"]["MYPY_CACHE_DIR"] == str(dev.types_folder()), "checkouts share what it found"
        return started([sys.executable, "-c", f"raise SystemExit({codes[len(stages) - 1]})"], text=True)

    started = subprocess.Popen
    monkeypatch.setattr(dev.subprocess, "Popen", start)
    assert dev.test(["-k", "X8"]) == expected
    assert stages == ["ruff", "ruff", "mypy", "pytest"]


def test_tests_of_what_changed_are_chosen(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a file changed that is no module, all tests run; without a change, those of the sources' shape."""
    assert dev.parse(["test", "--changed", "--", "-x"]) == ("test", ["--changed", "-x"])
    answers = {0: ["tests/a.py", "tests/b.py"], 3: []}
    for code, files in answers.items():
        done = subprocess.CompletedProcess([], code, "\n".join(files))
        monkeypatch.setattr(dev.subprocess, "run", lambda *_words, done=done, **_more: done)
        assert dev.changed_tests() == files
    monkeypatch.setattr(dev.subprocess, "run", lambda *_words, **_more: subprocess.CompletedProcess([], 0, ""))
    assert dev.changed_tests() == ["tests/test_architecture.py"]


@pytest.mark.skipif(not shutil.which("Xvfb"), reason="Xvfb is not installed")
def test_the_virtual_display_ends_with_its_block(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[subprocess.Popen[str]] = []
    child = dev.child

    @contextlib.contextmanager
    def watch(command: Sequence[str], **options: object) -> Iterator[subprocess.Popen[str]]:
        with child(command, **options) as process:
            started.append(process)
            yield process

    monkeypatch.setattr(dev, "child", watch)
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    with dev.virtual_display() as environment:
        assert "PYTHONDONTWRITEBYTECODE" not in environment
        assert environment["DISPLAY"].removeprefix(":").isdigit()
        assert environment["LIBGL_ALWAYS_SOFTWARE"] == "1"
        assert started[0].poll() is None
    assert started[0].poll() is not None


def test_exit_codes_pass_through(dev: ModuleType) -> None:
    assert dev.call([sys.executable, "-c", "raise SystemExit(3)"]) == 3
    assert dev.call([sys.executable, "-c", "import os; os.kill(os.getpid(), 9)"]) == 128 + signal.SIGKILL


def test_a_terminated_start_takes_its_program_along(tmp_path: Path) -> None:
    note = tmp_path / "process"
    program = f"import os, pathlib, time; pathlib.Path({str(note)!r}).write_text(str(os.getpid())); time.sleep(60)"
    starter = (
        f"import runpy, sys; dev = runpy.run_path({str(DEV)!r}); import signal;"
        f"signal.signal(signal.SIGTERM, dev['_stop']); dev['call']([sys.executable, '-c', {program!r}])"
    )
    with subprocess.Popen([sys.executable, "-c", starter]) as process:
        while not note.exists() or not note.read_text():
            assert process.poll() is None
            time.sleep(0.02)
        process.terminate()
        assert process.wait() == 128 + signal.SIGTERM
    with pytest.raises(ProcessLookupError):
        os.kill(int(note.read_text()), 0)
