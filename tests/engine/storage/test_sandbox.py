"""Spec 15, S16: a decoder that has been taken over reaches nothing but what it was handed."""

from __future__ import annotations

import json
import os
import platform
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from engine.core.errors import InputError
from engine.storage import sandbox, untrusted
from engine.storage.untrusted import decode_in_child

confined = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() not in ("x86_64", "aarch64"), reason="there is nothing to confine by"
)

#: A decoder that tries to break out, in every way there is a system call for, and says what each attempt gave.
BURGLAR = r"""
import ctypes, fcntl, os, resource, signal, socket, subprocess, tempfile, threading
import numpy as np
from engine.storage.shared_memory import result_array

libc = ctypes.CDLL(None, use_errno=True)

def call(function, *arguments):
    ctypes.set_errno(0)
    if function(*arguments) == -1:
        raise OSError(ctypes.get_errno(), "")

def burgle(content, name, parent, folder, copies=""):
    buffer = ctypes.create_string_buffer(8)
    reading = {
        "open /etc/passwd": lambda: open("/etc/passwd").read(),
        "open the file by its name": lambda: open(name).read(),
        "list a folder": lambda: os.listdir(folder),
        "own environment in /proc": lambda: open("/proc/self/environ").read(),
        "environment of the parent": lambda: open(f"/proc/{parent}/environ").read(),
        "memory of the parent": lambda: open(f"/proc/{parent}/mem", "rb").seek(0),
    }
    asking = {
        "size of /etc/passwd": lambda: os.stat("/etc/passwd"),
        "size of the file": lambda: os.stat(name),
        "kind of the folder": lambda: os.lstat(folder),
        "access to the file": lambda: call(libc.access, name.encode(), 0),
        "the file from the working folder": lambda: os.stat("../" * 40 + name.lstrip("/")),
        "the file through the process": lambda: os.stat(f"/proc/self/root{name}"),
        "the file through the parent": lambda: os.stat(f"/proc/{parent}/root{name}"),
        "link of the working folder": lambda: os.readlink("/proc/self/cwd"),
        "another folder": lambda: os.stat("/var"),
    }
    others = {
        "write a new file": lambda: open(folder + "/new", "w"),
        "write the file": lambda: open(name, "r+b"),
        "append to a module": lambda: open(np.__file__, "a"),
        "unnamed file": lambda: tempfile.TemporaryFile(dir="/tmp"),
        "write its own memory": lambda: open("/proc/self/mem", "r+b"),
        "make a folder": lambda: os.mkdir(folder + "/made"),
        "remove the file": lambda: os.unlink(name),
        "rename the file": lambda: os.rename(name, name + "2"),
        "link": lambda: os.symlink("/etc", folder + "/link"),
        "cut the file": lambda: os.truncate(name, 0),
        "change rights": lambda: os.chmod(name, 0o777),
        "change times": lambda: os.utime(name, (0, 0)),
        "change folder": lambda: os.chdir("/"),
        "internet socket": lambda: socket.socket().connect(("127.0.0.1", 9)),
        "unix socket": lambda: socket.socket(socket.AF_UNIX),
        "pair of sockets": socket.socketpair,
        "fork": os.fork,
        "spawn": lambda: os.posix_spawn("/bin/true", ["true"], {}),
        "run": lambda: subprocess.run(["/bin/true"]),
        "exec": lambda: os.execv("/bin/true", ["true"]),
        "kill the parent": lambda: os.kill(parent, 0),
        "signal through a descriptor": lambda: fcntl.fcntl(0, fcntl.F_SETOWN, parent),
        "handle of the parent": lambda: os.pidfd_open(parent),
        "limits of the parent": lambda: resource.prlimit(parent, resource.RLIMIT_NOFILE, (3, 3)),
        "trace the parent": lambda: call(libc.ptrace, 16, parent, 0, 0),
        "read from the parent": lambda: call(libc.process_vm_readv, parent, buffer, 1, buffer, 1, 0),
        "namespaces": lambda: call(libc.unshare, 0x10000000),
        "file in memory": lambda: os.memfd_create("x"),
        "type into the terminal": lambda: fcntl.ioctl(0, 0x5412, b"x"),
        "system calls of another mode": lambda: call(libc.syscall, 0x40000000 | 39),
        "more rights": lambda: call(libc.prctl, 38, 0, 0, 0, 0),
        "write among copies": lambda: open((copies or "/tmp") + "/new", "w"),
        "io_uring": lambda: call(libc.syscall, 425, 8, buffer),
    }
    def outcome(reach):
        try:
            reach()
        except OSError:
            return False
        return True
    threads = []
    thread = threading.Thread(target=lambda: threads.append({k: outcome(v) for k, v in reading.items()}))
    thread.start()
    thread.join()
    return {
        "reading": {key: outcome(reach) for key, reach in reading.items()},
        "asking": {key: outcome(reach) for key, reach in asking.items()},
        "others": {key: outcome(reach) for key, reach in others.items()},
        "in a thread": threads[0],
        "environment": sorted(os.environ),
        "copies": os.listdir(copies) if copies else [],
        "installation": len(open(np.__file__).read()),
        "length": len(content),
        "descriptors": sorted(int(each) for each in range(64) if outcome(lambda: os.fstat(each))),
    }

kept = []

def keep(content, name):
    array = result_array((5000,), np.int64)
    array[:] = 7
    kept.append(array)
    def later():
        import time
        time.sleep(0.3)
        array[:] = 8
    threading.Thread(target=later).start()
    return {"array": array}
"""


@pytest.fixture
def burglar(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    (tmp_path / "burglar_for_tests.py").write_text(BURGLAR)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("LIGHTARC_SECRET", "not for decoders")
    untrusted.stop_children()
    yield "burglar_for_tests"
    untrusted.stop_children()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "file.bin"
    path.write_bytes(b"content")
    return path


@confined
@pytest.mark.parametrize("has_copies", [False, True])
def test_a_decoder_reaches_nothing_but_its_file(
    burglar: str, file: Path, has_copies: bool, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Nor more than copies that are made for it."""
    copies = tmp_path_factory.mktemp("copies")
    (copies / "a").write_text("a")
    granted = str(copies) if has_copies else ""
    found = decode_in_child(f"{burglar}:burgle", file, parent=os.getpid(), folder=str(file.parent), copies=granted)
    assert found["copies"] == (["a"] if has_copies else [])
    protection = untrusted.protection()
    assert protection is not None
    assert protection.seccomp
    if not protection.landlock:
        pytest.skip(protection.sentence)
    for part in ("reading", "others", "in a thread"):
        assert [what for what, reached in found[part].items() if reached] == []
    if protection.hidden:
        assert [what for what, reached in found["asking"].items() if reached] == []
    assert set(found["environment"]) <= {*untrusted._KEPT, *untrusted._ONE_THREAD, *untrusted._LARGE_PAGES, "LC_CTYPE"}
    assert found["installation"] > 1000
    assert found["length"] == 7
    assert len(found["descriptors"]) <= 6, "three streams, the pipe of replies, the socket and the results"
    assert file.read_bytes() == b"content"
    assert sorted(path.name for path in file.parent.iterdir() if path.suffix) == ["burglar_for_tests.py", "file.bin"]


@confined
@pytest.mark.parametrize("is_installed", [True, False])
def test_modules_are_found_where_packages_are_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_installed: bool
) -> None:
    """Studios keep each package in a folder of its own on PYTHONPATH, whatever that is called."""
    folder = tmp_path / "packages"
    folder.mkdir()
    (folder / "decoder_of_a_studio.py").write_text(
        "def nothing(content, name):\n    return {}\n\ndef late(content, name):\n    import late_one\n    return {}\n"
    )
    (folder / "late_one.py").write_text("")
    if is_installed:
        (folder / "late_one-1.0.dist-info").mkdir()
    (tmp_path / "file.bin").write_bytes(b"content")
    monkeypatch.syspath_prepend(folder)
    untrusted.stop_children()
    try:
        decode_in_child("decoder_of_a_studio:nothing", tmp_path / "file.bin")
        protection = untrusted.protection()
        assert protection is not None
        if is_installed:
            decode_in_child("decoder_of_a_studio:late", tmp_path / "file.bin")
        elif protection.landlock:
            with pytest.raises(InputError):
                decode_in_child("decoder_of_a_studio:late", tmp_path / "file.bin")
    finally:
        untrusted.stop_children()


@confined
def test_a_kernel_without_landlock_keeps_the_rest(burglar: str, file: Path) -> None:
    code = (
        "import json, sys\n"
        "from burglar_for_tests import burgle\n"
        "from engine.storage.sandbox import confine\n"
        "protection = confine(landlock=False)\n"
        f"found = burgle(b'', {str(file)!r}, {os.getpid()}, {str(file.parent)!r})\n"
        "print(json.dumps([protection.sentence, found]))\n"
    )
    root = Path(sandbox.__file__).parents[2]
    environment = {"PYTHONPATH": f"{root}{os.pathsep}{file.parent}", **untrusted._ONE_THREAD}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    sentence, found = json.loads(run.stdout)
    assert "no Landlock" in sentence
    assert found["reading"]["open /etc/passwd"]
    assert [what for what, reached in found["others"].items() if reached] == []


@confined
def test_a_system_that_refuses_a_root_of_its_own_keeps_the_rest() -> None:
    """The refusal comes late, when the new root is half made: modules must be found all the same."""
    code = (
        "from engine.storage import sandbox\n"
        "sandbox._PIVOT_ROOT.clear()\n"
        "protection = sandbox.confine()\n"
        "import zipfile\n"
        "assert not protection.hidden\n"
        "print(protection.sentence)\n"
    )
    root = Path(sandbox.__file__).parents[2]
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=root)
    assert run.returncode == 0, run.stderr
    assert "whether a file exists" in run.stdout or "no Landlock" in run.stdout


@confined
def test_links_to_readable_folders_lead_there_and_no_folder_changes(tmp_path: Path) -> None:
    """Modules are found by a path with links in it, and the folders of the user are as they were."""
    real = tmp_path / "real" / "site-packages"
    real.mkdir(parents=True)
    (real / "late_module.py").write_text("x = 1\n")
    (tmp_path / "one").symlink_to("real")
    (tmp_path / "two").symlink_to(tmp_path / "one")
    (real / "inner").symlink_to("..")
    before = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*"))
    paths = [tmp_path / "two/site-packages", real / "inner/site-packages/../lib64", real / "inner/site-packages"]
    code = (
        "import sys\n"
        f"sys.path[:] = [{str(Path(sandbox.__file__).parents[2])!r}, *sys.path, *{[str(path) for path in paths]}]\n"
        "import os\n"
        f"os.environ['LD_LIBRARY_PATH'] = {os.pathsep.join(map(str, paths))!r}\n"
        "from engine.storage import sandbox\n"
        "protection = sandbox.confine()\n"
        "import late_module\n"
        f"print(protection.hidden, late_module.__file__, os.path.exists({str(tmp_path / 'two/site-packages')!r}))\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split()[1:] == [str(tmp_path / "two/site-packages/late_module.py"), "True"]
    assert sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*")) == before


@confined
def test_an_array_that_was_handed_over_cannot_be_changed_later(burglar: str, file: Path) -> None:
    array = decode_in_child(f"{burglar}:keep", file)["array"]
    time.sleep(0.6)
    assert (array == 7).all()


def test_a_system_without_protection_says_so() -> None:
    sentences = {sandbox.Protection(landlock, seccomp).sentence for landlock in (0, 7) for seccomp in (False, True)}
    assert len(sentences) == 4
    assert "whether a file exists" in sandbox.Protection(7, True).sentence
    assert "whether a file exists" not in sandbox.Protection(7, True, True).sentence
    assert "does not confine" in sandbox.Protection().sentence
    assert not sandbox.Protection(0, True).whole


def test_systems_other_than_linux_are_left_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    for system in ("darwin", "win32"):
        monkeypatch.setattr(sys, "platform", system)
        assert sandbox.confine() == sandbox.Protection()


def verdict(cpu: Any, number: int, *arguments: int, architecture: int | None = None) -> int:
    """The value that the filter returns for a system call, by the rules of classic BPF."""
    data = struct.pack("=iIQ6Q", number, architecture or cpu.architecture, 0, *(*arguments, *[0] * 6)[:6])
    steps = [struct.unpack("HBBI", step) for step in sandbox._program(cpu)]
    at, value = 0, 0
    while True:
        code, then, otherwise, operand = steps[at]
        at += 1
        if code == 0x06:
            return int(operand)
        if code == 0x20:
            (value,) = struct.unpack_from("=I", data, operand)
        else:
            holds = value == operand if code == 0x15 else bool(value & operand)
            at += then if holds else otherwise


#: read, openat, clone, clone3, fcntl, prlimit; and some that decoders have no use for, from socket to openat2.
NUMBERS = {
    "x86_64": ((0, 257, 56, 435, 72, 302), (41, 42, 59, 62, 101, 57, 58, 87, 322, 425, 437)),
    "aarch64": ((63, 56, 220, 435, 25, 261), (198, 203, 221, 129, 117, 35, 281, 425, 437)),
}


@pytest.mark.parametrize("cpu", NUMBERS)
def test_the_filter_lets_through_what_decoders_need(cpu: str) -> None:
    calls = sandbox._PROCESSORS[cpu]
    (read, openat, clone, clone3, fcntl, prlimit), refused = NUMBERS[cpu]
    allow, refuse, absent = 0x7FFF0000, 0x00050001, 0x00050026
    assert verdict(calls, read) == allow
    assert verdict(calls, read, architecture=0x40000003) == refuse
    assert verdict(calls, openat, 0, 0, os.O_RDONLY | 0o2000000) == allow
    for writing in (0o1, 0o2, 0o100, 0o1000, 0o20200002):
        assert verdict(calls, openat, 0, 0, writing) == refuse
    assert verdict(calls, clone, 0x3D0F00) == allow
    assert verdict(calls, clone, 0x01200011) == refuse
    assert verdict(calls, clone3) == absent
    assert (verdict(calls, fcntl, 0, 3), verdict(calls, fcntl, 0, 8)) == (allow, refuse)
    assert (verdict(calls, prlimit, 0), verdict(calls, prlimit, 1)) == (allow, refuse)
    assert {verdict(calls, number) for number in refused} == {refuse}
    assert len(list(sandbox._program(calls))) < 4096


def test_meshes_keep_no_descriptors(file: Path) -> None:
    """Spec 15, S10: a hundred results that are kept leave the number of open files as it was."""
    from engine.storage.shared_memory import make_shared_file, results_in

    process, kept = psutil.Process(), []
    before = process.num_fds() if sys.platform != "win32" else 0
    for number in range(100):
        with make_shared_file() as shared:
            if shared is None:
                pytest.skip("this system has no files in memory")
            with results_in(os.dup(shared.descriptor)) as results:
                assert results is not None
                offset = results.offset(np.full(3000, number))
                del results
            kept.append(shared.array(offset, np.dtype(np.int64), (3000,)))
    assert process.num_fds() == before
    assert [array[-1] for array in kept] == list(range(100))
