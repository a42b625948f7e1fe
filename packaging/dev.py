"""Set Lightarc up on a machine that has nothing but Python ≥ 3.11, then run, test or measure it, or build its manual.

    python3 packaging/dev.py run [-- ARGUMENTS OF LIGHTARC …]
    python3 packaging/dev.py test [--long | --changed] [-- ARGUMENTS OF PYTEST …]
    python3 packaging/dev.py bench [-- ARGUMENTS OF THE BENCHMARKS …]
    python3 packaging/dev.py manual [-- FOLDER]

Set-up makes `.venv` in the project, fills it from the lock file (every package pinned with its hash) and adds the
project itself as an editable installation. On Debian and Ubuntu missing system libraries come through apt where the
user may install packages; elsewhere the one line to type is printed. A stamp remembers what was installed, so that
the next start only compares a hash; a set-up that was interrupted is taken up again.

Only the standard library is used. What dev.py itself says goes to standard error. Exit codes are those of the program
that was run; 4 after Ctrl+C during set-up, 5 where something is missing that the user has to install.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import hashlib
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

PROJECT = Path(__file__).resolve().parents[1]
ENVIRONMENT = PROJECT / ".venv"
PROGRAMS = ENVIRONMENT / ("Scripts" if os.name == "nt" else "bin")
PYTHON = PROGRAMS / ("python.exe" if os.name == "nt" else "python")
UNFINISHED = ENVIRONMENT / "lightarc-unfinished"
LOG = ENVIRONMENT / "lightarc-setup.log"
LOCKS = {"run": PROJECT / "packaging/requirements.lock", "test": PROJECT / "packaging/requirements-test.lock"}
RESULTS = PROJECT / "build" / "demo"

#: Each of the processes that run tests has a CPU to itself: threads of kernels, algebra and Mesa would only wait.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "LP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}

#: Variables that tests do without: another display, and the wish for no bytecode, without which each process that they
#: start compiles all modules again, and each run all tests.
UNSET = {"WAYLAND_DISPLAY", "PYTHONDONTWRITEBYTECODE"}

#: Seconds after which a process whose test of a campaign hangs is ended; tests give up at 3,600 themselves.
LONG_TEST_S = 3700

#: Stands before arguments of pytest for the test files of what has changed.
CHANGED = "--changed"

OLDEST_PYTHON = (3, 11)
CANCELLED, MISSING = 4, 5

#: Shared libraries that the wheels of Qt, moderngl and numba leave to a Linux system, each with its Debian package.
LIBRARIES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgomp.so.1": "libgomp1",
    "libdbus-1.so.3": "libdbus-1-3",
    "libfontconfig.so.1": "libfontconfig1",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-image.so.0": "libxcb-image0",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-render-util.so.0": "libxcb-render-util0",
    "libxcb-shape.so.0": "libxcb-shape0",
}

#: The same for Mitsuba, with which tests compare; without it they are skipped.
TEST_LIBRARIES = {"libatomic.so.1": "libatomic1"}

#: The same by the package managers of other Linux systems: the line to type.
OTHER_SYSTEMS = {
    "dnf": "sudo dnf install mesa-libEGL mesa-libGL mesa-dri-drivers glib2 libgomp dbus-libs fontconfig "
    "libxkbcommon-x11 xcb-util-cursor xcb-util-wm xcb-util-image xcb-util-keysyms xcb-util-renderutil "
    "dejavu-sans-fonts xorg-x11-server-Xvfb libatomic",
    "pacman": "sudo pacman -S --needed mesa libglvnd glib2 gcc-libs dbus fontconfig libxkbcommon-x11 xcb-util-cursor "
    "xcb-util-wm xcb-util-image xcb-util-keysyms xcb-util-renderutil ttf-dejavu xorg-server-xvfb",
    "zypper": "sudo zypper install Mesa-libEGL1 Mesa-libGL1 Mesa-dri libglib-2_0-0 libgomp1 libdbus-1-3 "
    "libfontconfig1 libxkbcommon-x11-0 libxcb-cursor0 libxcb-icccm4 libxcb-image0 libxcb-keysyms1 "
    "libxcb-render-util0 libxcb-shape0 dejavu-fonts xorg-x11-server-Xvfb libatomic1",
}

#: Parts of pip's error messages, and the explanation for the user who waits.
PIP_FAILURES = (
    ("DO NOT MATCH THE HASHES", "A package differs from the one that the lock file names; check the package index."),
    ("No space left", "The disk is full; free about 3 GB and run the same command again."),
    ("Permission denied", "The folder .venv cannot be written; check its owner and run the same command again."),
    ("No matching distribution", "The package index has no fitting build for this Python; try Python 3.11 or 3.12."),
    ("Failed to establish", "The package index cannot be reached; check network and proxy, then run this again."),
    ("Connection", "The package index cannot be reached; check network and proxy, then run this again."),
    ("timed out", "The package index does not answer; check network and proxy, then run this again."),
    ("CERTIFICATE", "The package index's certificate is not trusted; give pip your certificate (PIP_CERT)."),
)


class SetupError(Exception):
    """The machine cannot be set up; the message says what is wrong and what to do, in one or two sentences."""


def main(words: Sequence[str] | None = None) -> int:
    if sys.version_info < OLDEST_PYTHON:
        say(f"Lightarc needs Python 3.11 or newer; this is {sys.version.split()[0]}. Install one and call it by name.")
        return MISSING
    verb, rest = parse(sys.argv[1:] if words is None else words)
    signal.signal(signal.SIGTERM, _stop)
    try:
        set_up({"bench": "run", "manual": "test"}.get(verb, verb))
    except SetupError as error:
        say(str(error))
        return MISSING
    except KeyboardInterrupt:
        say("Interrupted; the same command takes the set-up up again.")
        return CANCELLED
    return {"run": run, "test": test, "bench": bench, "manual": manual}[verb](rest)


def parse(words: Sequence[str]) -> tuple[str, list[str]]:
    """Split the command line at the first `--`: what dev.py shall do, and what is handed on unread.

    `--long` is an option of pytest (`tests/conftest.py`) that is named so often that it needs no `--` before it.
    """
    own, rest = list(words), []
    if "--" in own:
        cut = own.index("--")
        own, rest = own[:cut], own[cut + 1 :]
    parser = argparse.ArgumentParser(
        prog="dev.py",
        description="Set Lightarc up, then run, test or measure it, or build its manual; what follows -- is handed on.",
        epilog="example: python3 packaging/dev.py run -- demo -o out",
    )
    verbs = "open Lightarc (or its demo, without a display), test, measure, or build the manual"
    parser.add_argument("verb", choices=("run", "test", "bench", "manual"), help=verbs)
    parser.add_argument("--long", action="store_true", help="test with the campaigns as well, which takes hours")
    parser.add_argument(
        "--changed", action="store_true", help="test with the files alone that import what differs from the last commit"
    )
    options = parser.parse_args(own)
    if (options.long or options.changed) and options.verb != "test":
        parser.error("--long and --changed belong to test")
    if options.changed:
        rest = [CHANGED, *rest]
    return options.verb, ["--long", "-o", f"faulthandler_timeout={LONG_TEST_S}", *rest] if options.long else rest


def say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def set_up(purpose: str) -> bool:
    """Bring system libraries and `.venv` into the state that `purpose` ('run' or 'test') needs; quick when they are.

    True if something was installed.
    """
    ready = is_ready(purpose)
    provide_system_packages(purpose, with_venv=not ready)
    if ready:
        return False
    start = time.monotonic()
    make_environment()
    UNFINISHED.touch()
    install_packages(purpose)
    UNFINISHED.unlink()
    stamp_of(purpose).write_text(key_of(purpose), encoding="ascii")
    say(f"Set up in {time.monotonic() - start:.0f} s.")
    return True


def is_ready(purpose: str) -> bool:
    """True if `.venv` holds what `purpose` needs; the set for tests includes the set for a run."""
    if not PYTHON.exists() or UNFINISHED.exists():
        return False
    return any(
        stamp_of(name).is_file() and stamp_of(name).read_text(encoding="ascii") == key_of(name)
        for name in {purpose, "test"}
    )


def stamp_of(purpose: str) -> Path:
    return ENVIRONMENT / f"lightarc-{purpose}.stamp"


def key_of(purpose: str) -> str:
    """Hash of all that an environment depends on: lock file, pyproject.toml, version of Python, place on the disk."""
    parts = (LOCKS[purpose].read_bytes(), (PROJECT / "pyproject.toml").read_bytes(), python_version().encode())
    return hashlib.sha256(b"\0".join((*parts, os.fsencode(PROJECT)))).hexdigest()


def python_version() -> str:
    return f"{sys.version_info.major}.{sys.version_info.minor}"


def provide_system_packages(purpose: str, *, with_venv: bool) -> None:
    """Install, or tell the user how to install, what pip cannot bring."""
    wanted = missing_libraries(purpose) if sys.platform.startswith("linux") else []
    if purpose == "test" and sys.platform.startswith("linux") and not shutil.which("Xvfb"):
        wanted.append("xvfb")
    if with_venv and importlib.util.find_spec("ensurepip") is None:
        wanted.append(f"python{python_version()}-venv")
    if wanted:
        if not shutil.which("apt-get"):
            raise SetupError(f"Missing on this system: {' '.join(wanted)}. {line_to_type()}")
        install_with_apt(wanted)


def missing_libraries(purpose: str) -> list[str]:
    """Debian packages of those libraries for `purpose` that the dynamic linker does not find."""
    needed = LIBRARIES | TEST_LIBRARIES if purpose == "test" else LIBRARIES
    return [package for library, package in needed.items() if not can_load(library)]


def can_load(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def line_to_type() -> str:
    lines = (line for manager, line in OTHER_SYSTEMS.items() if shutil.which(manager))
    return f"Type: {line}" if (line := next(lines, None)) else "Install them with this system's package manager."


def install_with_apt(packages: Sequence[str]) -> None:
    line = f"apt-get install -y --no-install-recommends {' '.join(packages)}"
    privilege = apt_privilege()
    if privilege is None:
        raise SetupError(f"System packages are missing. Type: sudo {line}")
    say(f"Installing system packages: {' '.join(packages)}")
    apt = [*privilege, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-q", "-o", "DPkg::Lock::Timeout=60"]
    subprocess.run([*apt, "update"], stdin=subprocess.DEVNULL, capture_output=True)
    done = subprocess.run([*apt, *line.split()[1:]], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode != 0:
        raise SetupError(f"apt-get failed ({_last_line(done.stderr or done.stdout)}). Type: sudo {line}")


def apt_privilege() -> list[str] | None:
    """The words to put before apt-get; None where this user would have to type a password."""
    if os.geteuid() == 0:
        return []
    sudo = ["sudo", "-n"]
    allowed = shutil.which("sudo") and subprocess.run([*sudo, "true"], capture_output=True).returncode == 0
    return sudo if allowed else None


def make_environment() -> None:
    """Make `.venv` anew unless a sound one of this Python's version is there."""
    if is_sound():
        return
    say(f"Making .venv with Python {sys.version.split()[0]}")
    base = getattr(sys, "_base_executable", sys.executable)
    done = subprocess.run([base, "-m", "venv", "--clear", str(ENVIRONMENT)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SetupError(
            f"Python cannot make .venv ({_last_line(done.stdout + done.stderr)}). Delete .venv, try again."
        )


def is_sound() -> bool:
    """True if `.venv` answers with this Python's version, has pip, and no installation in it was cut short."""
    if not PYTHON.exists() or UNFINISHED.exists():
        return False
    question = "import pip, sys; print('%d.%d' % sys.version_info[:2])"
    try:
        answer = subprocess.run([str(PYTHON), "-c", question], capture_output=True, text=True)
    except OSError:
        return False
    return answer.stdout.strip() == python_version()


def install_packages(purpose: str) -> None:
    lock = LOCKS[purpose]
    names = {line.split("==")[0] for line in lock.read_text(encoding="utf-8").splitlines() if line[:1].isalnum()}
    say(f"Installing {len(names)} packages into .venv (the first time this takes a minute or more)")
    pip(["--only-binary", ":all:", "--require-hashes", "--no-compile", "-r", str(lock)], expected=len(names))
    pip(["--no-deps", "--no-build-isolation", "-e", str(PROJECT)])
    compile_packages()


def compile_packages() -> None:
    """Compile what the packages will import, with all CPUs, where pip takes one and their own tests as well.

    A module that cannot be compiled says so when it is imported.
    """
    command = [str(PYTHON), "-m", "compileall", "-q", "-j", "0", "-x", r"[/\\]tests?[/\\]", str(ENVIRONMENT)]
    streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with child(command, **streams) as process:
        process.wait()


def pip(arguments: Sequence[str], expected: int = 0) -> None:
    """Run `pip install`, saying now and then how far it is; its own words go to a log file in `.venv`."""
    command = [str(PYTHON), "-m", "pip", "install", "--no-input", "--disable-pip-version-check"]
    streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    lines, found, shown = [], 0, time.monotonic()
    with child([*command, "--progress-bar", "off", *arguments], text=True, errors="replace", **streams) as process:
        for line in process.stdout or ():
            lines.append(line)
            found += line.startswith(("Collecting", "Requirement already satisfied"))
            if expected and time.monotonic() - shown > 10:
                shown = time.monotonic()
                say(f"  {min(found, expected)} of {expected} packages")
        code = process.wait()
    LOG.write_text("".join(lines), encoding="utf-8")
    if code != 0:
        UNFINISHED.unlink()
        raise SetupError(f"{meaning_of(''.join(lines))} pip's own words are in {LOG}")


def meaning_of(output: str) -> str:
    """The sentence for a user that belongs to the output of a failed pip."""
    for words, sentence in PIP_FAILURES:
        if words.lower() in output.lower():
            return sentence
    return f"pip failed ({_last_line(output)}). Run the same command again, or delete .venv first."


def _last_line(text: str) -> str:
    return next((line.strip() for line in reversed(text.splitlines()) if line.strip()), "it said nothing")


def run(words: Sequence[str]) -> int:
    """Hand `words` to lightarc; without any, open the window, or run the demo where no display is."""
    lightarc = str(PROGRAMS / ("lightarc.exe" if os.name == "nt" else "lightarc"))
    if words:
        return call([lightarc, *words])
    if has_display():
        return call([lightarc, "gui"])
    say("No display here: running the demo instead of the window")
    RESULTS.parent.mkdir(exist_ok=True)
    code = call([lightarc, "demo", "-o", str(RESULTS)])
    if code == 0:
        say(f"The results are in {RESULTS}")
    return code


def bench(words: Sequence[str]) -> int:
    """Hand `words` to the benchmarks."""
    return call([str(PYTHON), "-m", "benchmarks", *words])


def manual(words: Sequence[str]) -> int:
    """Build the manual as pages for a browser, in `build/manual/html` unless `words` name a folder."""
    return call([str(PYTHON), str(PROJECT / "packaging" / "manual.py"), *words])


def has_display() -> bool:
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def test(words: Sequence[str]) -> int:
    """Formatter, linter, types, then pytest with `words`; the exit code of the first that fails.

    All four run in any case, and pytest's closing line ends the output. The whole suite takes minutes longer than the
    types, which are checked beside its beginning; a chosen part may not, and follows them.
    """
    tool = [str(PYTHON), "-m"]
    if CHANGED in words:
        words = [*(word for word in words if word != CHANGED), *changed_tests()]
    codes = []
    for name, command in {"Format": ["ruff", "format", "--check", "."], "Lint": ["ruff", "check", "."]}.items():
        say(f"{name}: {' '.join(command)}")
        codes.append(call([*tool, *command]))
    say("Types: mypy, beside the tests" if not words else "Types: mypy")
    kept = {"MYPY_CACHE_DIR": str(types_folder()), **os.environ}
    with child([*tool, "mypy"], env=kept) as types, virtual_display() as environment:
        if words:
            end(types)
        command = ["pytest", "-n", str(workers()), "--dist", "worksteal", "-rs", *words]
        say(f"Tests: {' '.join(command)}")
        tests = call([*tool, *command], environment)
        codes += [end(types), tests]
    return next((code for code in codes if code), 0)


def types_folder() -> Path:
    """Where mypy keeps what it found, by content: one folder of the user for all checkouts with the same packages.

    In a fresh checkout it would otherwise work through all packages again, beside the tests.
    """
    kept = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    packages = hashlib.sha256(LOCKS["test"].read_bytes()).hexdigest()[:16]
    return kept / "lightarc-tests" / f"types-{packages}"


def changed_tests() -> list[str]:
    """Test files that import a module which differs from the last commit; none, for all, where other files differ."""
    command = [str(PYTHON), "-m", "tests.import_graph"]
    done = subprocess.run(command, cwd=PROJECT, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        say("Not only modules differ from the last commit: all tests run")
        return []
    files = done.stdout.split()
    say(f"{len(files)} test files import what differs from the last commit")
    return files or ["tests/test_architecture.py"]


def workers() -> int:
    """Processes that run tests: one per CPU up to four, none beside pytest itself where there is but one."""
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return 0 if available < 2 else min(available, 4)


@contextlib.contextmanager
def virtual_display() -> Iterator[Mapping[str, str]]:
    """On Linux an X server of its own with Mesa's software GL, for the same pixels everywhere; else nothing."""
    kept = {name: value for name, value in os.environ.items() if name not in UNSET}
    if not sys.platform.startswith("linux"):
        yield kept
        return
    reading, writing = os.pipe()
    command = ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1920x1080x24", "-nolisten", "tcp", "-noreset"]
    # A session of its own, because Ctrl+C shall reach pytest first.
    with child(command, pass_fds=[writing], stderr=subprocess.DEVNULL, start_new_session=True):
        os.close(writing)
        with os.fdopen(reading, encoding="ascii") as answer:
            number = answer.readline().strip()
        if not number:
            raise SystemExit("Xvfb does not start; type Xvfb :99 to see why.")
        yield {**ONE_THREAD, **kept, "DISPLAY": f":{number}", "QT_QPA_PLATFORM": "xcb", **software_gl()}


def software_gl() -> dict[str, str]:
    """Variables that choose Mesa's software GL, also where another driver stands before Mesa's.

    Images of a graphics card are up to two codes of 255 off the exact ones, where tests allow one.
    """
    chosen = {"LIBGL_ALWAYS_SOFTWARE": "1", "__GLX_VENDOR_LIBRARY_NAME": "mesa"}
    for folder in ("/etc/glvnd/egl_vendor.d", "/usr/share/glvnd/egl_vendor.d"):
        for vendor in sorted(Path(folder).glob("*mesa*.json")):
            chosen["__EGL_VENDOR_LIBRARY_FILENAMES"] = str(vendor)
    return chosen


def call(command: Sequence[str], environment: Mapping[str, str] | None = None) -> int:
    """Run a program in the foreground and return its exit code. Ctrl+C is the program's affair."""
    with child(command, env=environment) as process:
        return end(process)


def end(process: subprocess.Popen[str]) -> int:
    """Wait for a program; its exit code, or 128 and the number of the signal that ended it."""
    while True:
        try:
            code = process.wait()
            return code if code >= 0 else 128 - code
        except KeyboardInterrupt:
            continue


@contextlib.contextmanager
def child(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    """A process that does not outlive this block."""
    process = subprocess.Popen(command, **options)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.terminate()
        process.wait()


def _stop(number: int, _frame: FrameType | None) -> NoReturn:
    raise SystemExit(128 + number)


if __name__ == "__main__":
    sys.exit(main())
