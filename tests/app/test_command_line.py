"""The command line's frame: exit codes, one JSON object, examples that parse, and never a traceback for a user."""

from __future__ import annotations

import argparse
import errno
import json
import logging
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, cast

import numpy as np
import pytest

from app import command_line
from app.process import ending
from engine.core.errors import InputError, MissingCapability, OutOfMemory, OutputError, UsageError
from engine.core.steps import Step

PROJECT = Path(__file__).resolve().parents[2]
NAMES = [name for name, _, _ in command_line.VERBS]
REMEDY = OutOfMemory("").remedy


def lightarc(*words: str | bytes, **options: Any) -> subprocess.CompletedProcess[bytes]:
    command = [sys.executable, "-m", "app", *words]
    return subprocess.run(command, capture_output=True, cwd=PROJECT, stdin=subprocess.DEVNULL, **options)


@pytest.fixture
def stub(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], Any]], None]:
    """Make the command line know a single verb, `act`, that does what the test says."""

    def install(act: Callable[[], Any], report: Callable[[dict[str, Any]], str] | None = None) -> None:
        module = ModuleType("stub_verb")
        module.EXAMPLE = "lightarc act"  # type: ignore[attr-defined]
        module.add_arguments = lambda parser: None  # type: ignore[attr-defined]
        module.run = lambda arguments, show: (show(Step(0.5, "halfway")), act())[1]  # type: ignore[attr-defined]
        if report is not None:
            module.report = report  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, "stub_verb", module)
        monkeypatch.setattr(command_line, "VERBS", (("act", "stub_verb", "Act."),))

    return install


def raising(error: BaseException) -> Callable[[], Any]:
    def act() -> Any:
        raise error

    return act


@pytest.mark.parametrize("name", NAMES)
def test_help_of_each_verb_shows_an_example_that_parses(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        command_line.main([name, "-h"])
    assert ended.value.code == 0
    example = capsys.readouterr().out.split("example:", 1)[1].strip().splitlines()[0]
    words = shlex.split(example.partition(" > ")[0])
    assert words[:2] == ["lightarc", name]
    assert command_line.build_parser().parse_args(words[1:]).verb == name


@pytest.mark.parametrize("name", NAMES)
def test_every_option_of_a_verb_is_explained(name: str) -> None:
    subparsers = next(a for a in command_line.build_parser()._actions if isinstance(a, argparse._SubParsersAction))
    unexplained = [action.dest for action in subparsers.choices[name]._actions if not (action.help or action.choices)]
    assert unexplained == []


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (InputError("scan.tif", "ends in row 12", "Copy it again"), 3, "scan.tif: ends in row 12. Copy it again."),
        (OutputError("out", "the disk is full", "Free 2 GB"), 3, "out: the disk is full. Free 2 GB."),
        (KeyboardInterrupt(), 4, "Cancelled; nothing was written."),
        (MissingCapability("No OpenGL 3.3", "Install Mesa"), 5, "No OpenGL 3.3. Install Mesa."),
        (UsageError("Size must be positive."), 2, "Size must be positive. See lightarc act -h."),
        (MemoryError(), 6, f"There is not enough memory. {REMEDY}."),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), 6, f"There is not enough memory. {REMEDY}."),
        (RuntimeError("can't start new thread"), 6, f"No further thread can be started. {REMEDY}."),
        (OSError(errno.EAGAIN, "of a fork"), 6, f"No further process can be started. {REMEDY}."),
        (
            ImportError("libLLVM.so: failed to map segment from shared object"),
            6,
            f"There is not enough memory to load all libraries. {REMEDY}.",
        ),
    ],
)
def test_failures_become_exit_codes_and_one_sentence(
    stub: Callable[..., None], capfd: pytest.CaptureFixture[str], error: BaseException, code: int, message: str
) -> None:
    stub(raising(error))
    assert command_line.main(["act", "--json"]) == code
    printed = capfd.readouterr()
    assert printed.out == ""
    assert printed.err == message + "\n"


def test_what_an_interrupted_verb_held_is_not_freed_while_the_process_ends(
    stub: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    freed = []

    class HalfOwned:
        def __del__(self) -> None:
            freed.append(self)

    def act(*_arguments: object) -> None:
        half = HalfOwned()
        raise KeyboardInterrupt(type(half).__name__)

    monkeypatch.setattr(ending, "_interrupted", None)
    stub(act)
    assert command_line.main(["act"]) == ending.CANCELLED
    assert freed == []


def test_mistakes_of_the_programmer_are_not_hidden(stub: Callable[..., None]) -> None:
    for bug in (
        ZeroDivisionError("a bug"),
        RuntimeError("a bug"),
        OSError(errno.EBADF, "a bug"),
        ValueError("a bug"),
        np.linalg.LinAlgError("a bug"),
    ):
        stub(raising(bug))
        with pytest.raises(type(bug), match="a bug"):
            command_line.main(["act"])


@pytest.mark.parametrize(
    ("function", "words"),
    [
        ("engine.brdf.fit.fit", "brdf fit phong --model ward"),
        ("app.cli.factor.factor", "factor phong"),
        ("app.cli.factor.thesis_table", "factor --table"),
        ("engine.transport.sh.bake.prepare", "bake sphere --brdf ggx --mode sh -o out.transport"),
        ("engine.selftest.run.selftest", "selftest"),
        ("app.cli.transport.render.reference", "render sphere --mode reference -o out.png"),
    ],
)
def test_a_singular_matrix_within_a_computation_is_no_wrong_usage(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, function: str, words: str
) -> None:
    def singular(*_values: Any, **_named: Any) -> Any:
        raise np.linalg.LinAlgError("Singular matrix")
        yield

    monkeypatch.chdir(tmp_path)
    import_module("engine.brdf.ranking")  # it would keep what stands in for the fit
    monkeypatch.setattr(function, singular)
    with pytest.raises(np.linalg.LinAlgError, match="Singular matrix"):
        command_line.main(words.split())


def test_json_is_one_object_and_nothing_else(stub: Callable[..., None], capfd: pytest.CaptureFixture[str]) -> None:
    def act() -> dict[str, Any]:
        logging.getLogger("engine").warning("a log line")
        return {"time_s": 1.5, "name": "Köper", "exit_code": 0, "warnings": []}

    stub(act)
    assert command_line.main(["act", "--json"]) == 0
    assert json.loads(capfd.readouterr().out) == {"time_s": 1.5, "name": "Köper", "warnings": []}


def test_json_is_strict(stub: Callable[..., None]) -> None:
    stub(lambda: {"rms": float("nan"), "warnings": []})
    with pytest.raises(ValueError, match="JSON"):
        command_line.main(["act", "--json"])


def test_a_verb_may_decide_its_exit_code(stub: Callable[..., None]) -> None:
    stub(lambda: {"valid": False, "exit_code": 3, "warnings": []})
    assert command_line.main(["act"]) == 3


def test_health_is_one_line_and_the_first_warnings(
    stub: Callable[..., None], capfd: pytest.CaptureFixture[str]
) -> None:
    for warnings, words in (
        ([], "Health: no warnings."),
        (["Row 3 is black."], "Health: 1 warning:\n- Row 3 is black."),
        (
            [f"Texel {number} does not brighten." for number in range(34)],
            "\n- Texel 7 does not brighten.\n- and 26 more, which --json lists",
        ),
    ):
        stub(lambda *_arguments, warnings=warnings: {"figure": 1, "warnings": warnings})
        assert command_line.main(["act"]) == 0
        assert words in capfd.readouterr().out


@pytest.mark.parametrize("words", [["act"], ["act", "--json"]])
def test_a_result_without_its_health_is_a_mistake(stub: Callable[..., None], words: Sequence[str]) -> None:
    stub(lambda: {"images": 10})
    with pytest.raises(KeyError, match="warnings"):
        command_line.main(words)


def test_users_read_the_report(stub: Callable[..., None], capfd: pytest.CaptureFixture[str]) -> None:
    stub(lambda: {"images": 10, "warnings": []}, lambda result: f"{result['images']} photographs")
    command_line.main(["act"])
    assert capfd.readouterr().out == "10 photographs\nHealth: no warnings.\n"


@pytest.mark.parametrize("words", [["act"], ["act", "--json"]])
def test_names_that_no_encoding_knows_are_printed(
    stub: Callable[..., None], capfdbinary: pytest.CaptureFixture[bytes], words: Sequence[str]
) -> None:
    name = os.fsdecode(b"caf\xe9-\xf0\x9f\x8e\x83")
    stub(lambda: {"folder": name, "warnings": []})
    assert command_line.main(words) == 0
    assert (b"caf\\udce9" if "--json" in words else b"caf\\xe9") in capfdbinary.readouterr().out


@pytest.mark.parametrize(
    "words", [["nosuchverb"], ["import"], ["import", "--nosuch"], ["simulate", "-o", "x", "--elevations-deg", "a"]]
)
def test_wrong_usage_ends_with_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        command_line.main(words)
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("lightarc")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "joined"),
    [
        (["--light-deg", "-30,0", "-o", "x"], ["--light-deg=-30,0", "-o", "x"]),
        (["--corners", "-.5,1e3,2,3"], ["--corners=-.5,1e3,2,3"]),
        (["--light-deg=1,2", "-3,4"], ["--light-deg=1,2", "-3,4"]),
        (["--json", "-o", "x"], ["--json", "-o", "x"]),
        (["--", "-3,4"], ["--", "-3,4"]),
    ],
)
def test_lists_of_negative_numbers_are_values_and_no_options(words: list[str], joined: list[str]) -> None:
    assert command_line._join(words) == joined


@pytest.mark.parametrize(
    "words",
    [
        ["import", "absent", "-o", "stack"],
        ["shade", "absent", "-o", "out.lightarc"],
        ["render", "absent.obj", "--brdf", "lambert", "--light-deg", "30,0", "-o", "out.png"],
        ["bundle", "verify", "absent.lightarc"],
    ],
    ids=lambda words: words[0],
)
def test_absent_input_ends_with_3_and_writes_nothing(words: list[str], tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    command = [sys.executable, "-m", "app", *words, "--json"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert (done.returncode, done.stdout) == (3, "")
    assert "absent" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals")
@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)])
def test_a_signal_cancels_and_leaves_nothing(number: signal.Signals, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "app", "simulate", "-o", str(tmp_path / "capture"), "--size", "2048"]

    def heed() -> None:
        """A shell in the background ignores interrupts, and so does all that it starts."""
        signal.signal(number, signal.SIG_DFL)

    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=PROJECT, stdout=pipe, stderr=pipe, text=True, preexec_fn=heed) as process:
        while not list(tmp_path.iterdir()):
            assert process.poll() is None
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 4, err
    assert out == ""
    assert "Cancelled; nothing was written." in err
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="pipes end differently on Windows")
def test_a_reader_that_has_gone_is_no_traceback() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "app", "--version"]
    done = subprocess.run(command, cwd=PROJECT, stdout=writing, stderr=subprocess.PIPE, text=True)
    os.close(writing)
    assert "Traceback" not in done.stderr
    assert "BrokenPipe" not in done.stderr


def test_progress_goes_to_standard_error_without_escape_codes(
    stub: Callable[..., None], capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cast(Any, command_line).time, "monotonic", iter(range(0, 1000, 10)).__next__)
    stub(lambda: {"images": 1, "warnings": []})
    command_line.main(["act", "--json"])
    printed = capfd.readouterr()
    assert json.loads(printed.out) == {"images": 1, "warnings": []}
    assert printed.err == " 50 %  halfway\n"
