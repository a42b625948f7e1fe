"""Faults 12 and 13 (odd files and names), and decoders that crash, hang, eat memory or talk too much."""

import os
import runpy
import socket
import subprocess
import sys
import threading
import time
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import psutil
import pytest

from engine.core.errors import InputError
from engine.storage import scratch, shared_memory, untrusted
from engine.storage.shared_memory import SharedFile
from engine.storage.untrusted import Decoding, decode_in_child, read_bytes

DECODERS = """
import contextlib, ctypes, json, os, sys, time
import numpy as np
from engine.core.errors import InputError
from engine.storage.shared_memory import result_array

def echo(content, name, **options):
    return {"content": np.frombuffer(content, np.uint8), "name": name, "options": options, "pid": os.getpid()}

def hang(content, name):
    time.sleep(1000)

def wait(content, name):
    time.sleep(1)
    return {"content": np.frombuffer(content, np.uint8)}

def compute(content, name):
    while True:
        pass

def crash(content, name):
    ctypes.string_at(0)

def quit(content, name):
    os._exit(7)

def eat(content, name):
    return {"array": np.ones((1 << 32,))}

def chatter(content, name):
    print("not json")
    os.write(1, b"nor this\\n" * 10000)
    os.write(2, b"noise\\n" * 100000)
    return {"array": np.arange(6, dtype=">u2").reshape(2, 3), "empty": np.zeros((0, 3), np.float32)}

def refuse(content, name):
    raise InputError(name, "is not liked", "Give another")

def surprise(content, name):
    class Odd(Exception): pass
    raise Odd("never seen")

def damaged(content, name):
    raise KeyError("width")

def unread(content, name):
    raise ValueError("7 bytes are missing")

def nonsense(content, name):
    for descriptor in range(3, 16):
        with contextlib.suppress(OSError):
            os.write(descriptor, b"[1, 2]\\n")
    time.sleep(1000)

def copy_tail(file, name, scratch):
    size = file.seek(0, 2)
    file.seek(size - 250)
    scratch.write(file.read())
    return {"size": size}

def made_in_place(content, name):
    array = result_array((3, 4), np.float32)
    array[:] = 7
    return {"array": array, "copied": np.arange(5), "view": np.arange(12).reshape(3, 4).T, "empty": np.zeros((0, 2))}
"""


@pytest.fixture(scope="module")
def decoders(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A module of decoders that children can import; children are fresh before the first test and gone afterwards."""
    folder = tmp_path_factory.mktemp("decoders")
    (folder / "decoders_for_tests.py").write_text(DECODERS)
    untrusted.stop_children()
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        yield "decoders_for_tests"
    untrusted.stop_children()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "file.bin"
    path.write_bytes(bytes(range(256)) * 100)
    return path


def refuse(path: Path | str, read: Any = read_bytes) -> Any:
    with pytest.raises(InputError) as caught:
        read(path)
    assert str(caught.value).count("\n") == 0
    return caught.value


def test_fault12_only_regular_files_are_read(tmp_path: Path) -> None:
    folder, fifo, empty = tmp_path / "folder.jpg", tmp_path / "fifo.jpg", tmp_path / "empty.jpg"
    folder.mkdir()
    os.mkfifo(fifo)
    empty.touch()
    assert "folder" in refuse(folder).problem
    assert "pipe" in refuse(fifo).problem
    assert "device" in refuse("/dev/zero").problem
    assert "empty" in refuse(empty).problem
    assert "does not exist" in refuse(tmp_path / "absent.jpg").problem


def test_fault12_sockets_and_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket.jpg")
        assert "socket" in refuse("socket.jpg").problem
    Path("dangling.jpg").symlink_to("nowhere")
    Path("loop.jpg").symlink_to("loop.jpg")
    Path("zero.jpg").symlink_to("/dev/zero")
    assert "does not exist" in refuse("dangling.jpg").problem
    assert "link" in refuse("loop.jpg").problem.lower()
    assert "device" in refuse("zero.jpg").problem


def test_fault12_a_file_that_changes_while_it_is_read_is_refused(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check_kind = untrusted._check_kind

    def append(path: Path, status: Any, limit_bytes: Any) -> None:
        check_kind(path, status, limit_bytes)
        with Path(path).open("ab") as writer:
            writer.write(b"more")

    monkeypatch.setattr(untrusted, "_check_kind", append)
    assert "changed" in refuse(file).problem


def test_fault12_a_file_that_shrinks_while_it_is_read_is_refused(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check_kind = untrusted._check_kind

    def cut(path: Path, status: Any, limit_bytes: Any) -> None:
        check_kind(path, status, limit_bytes)
        os.truncate(path, 10)

    monkeypatch.setattr(untrusted, "_check_kind", cut)
    assert "changed" in refuse(file).problem


def test_fault12_a_file_that_vanishes_is_refused(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(untrusted, "_check_kind", lambda path, *_: Path(path).unlink())
    assert "does not exist" in refuse(file).problem


def test_files_over_the_limit_are_not_read(file: Path) -> None:
    with pytest.raises(InputError, match="limit"):
        read_bytes(file, limit_bytes=1000)
    assert len(read_bytes(file)) == 25600


NAMES = [
    "with space.bin",
    "quote'\"%s%n.bin",
    "new\nline.bin",
    "emoji 🧵.bin",
    "שלום.bin",
    unicodedata.normalize("NFC", "é.bin"),
    unicodedata.normalize("NFD", "é.bin"),
    "trailing.",
    "-o",
    "n" * 255,
    os.fsdecode(b"latin1-\xe9\xff.bin"),
]


@pytest.mark.parametrize("name", NAMES, ids=lambda name: ascii(name)[:20])
def test_fault13_names_of_any_spelling_work(tmp_path: Path, decoders: str, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(b"content")
    reply = decode_in_child(f"{decoders}:echo", path)
    assert bytes(reply["content"]) == b"content"
    assert reply["name"] == os.fspath(path)
    path.unlink()
    str(refuse(path)).encode("utf-8")


def test_fault13_impossible_names_are_one_clear_error(tmp_path: Path) -> None:
    for path in (str(tmp_path / ("n" * 256)), "/".join(["d" * 200] * 30), "nul\0.jpg"):
        assert refuse(path).problem


def test_arrays_and_values_survive_the_way_through_the_child(file: Path, decoders: str) -> None:
    reply = decode_in_child(f"{decoders}:echo", file, number=1.5, text="ü", list=[1, None])
    assert bytes(reply["content"]) == file.read_bytes()
    assert reply["options"] == {"number": 1.5, "text": "ü", "list": [1, None]}
    reply = decode_in_child(f"{decoders}:chatter", file)
    assert reply["array"].tolist() == [[0, 1, 2], [3, 4, 5]]
    assert reply["empty"].shape == (0, 3)


def test_a_child_serves_many_files(file: Path, decoders: str) -> None:
    pids = {decode_in_child(f"{decoders}:echo", file)["pid"] for _ in range(5)}
    assert len(pids) == 1
    assert pids != {os.getpid()}


@pytest.mark.parametrize(
    ("decoder", "words"),
    [
        ("crash", "crashed"),
        ("quit", "exit code 7"),
        ("refuse", "is not liked"),
        ("surprise", "Odd: never seen"),
        ("damaged", r"is damaged or of an unknown kind\."),
        ("unread", r"is damaged or of an unknown kind \(7 bytes are missing\)\."),
    ],
)
def test_what_goes_wrong_in_a_decoder_costs_one_file(file: Path, decoders: str, decoder: str, words: str) -> None:
    for _ in range(2):
        with pytest.raises(InputError, match=words) as caught:
            decode_in_child(f"{decoders}:{decoder}", file)
        assert caught.value.path == str(file)
        assert decode_in_child(f"{decoders}:echo", file)["name"] == str(file)


def test_a_file_of_another_origin_never_meets_a_process_that_refused_one(
    tmp_path: Path, decoders: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(untrusted, "_origin", lambda path: os.fspath(Path(path).parent))
    files = [tmp_path / folder / name for folder in ("mine", "theirs") for name in ("a", "b")]
    for each in files:
        each.parent.mkdir(exist_ok=True)
        each.write_bytes(b"content")
    mine, _, theirs, more = files

    def pid(path: Path) -> int:
        return int(decode_in_child(f"{decoders}:echo", path)["pid"])

    assert pid(mine) == pid(theirs)
    with pytest.raises(InputError):
        decode_in_child(f"{decoders}:refuse", theirs)
    suspect = pid(more)
    assert suspect != pid(mine), "a process that refused a file reads one of another origin"
    assert pid(mine) == pid(theirs)


@pytest.mark.parametrize("hands_descriptors", [True, False])
def test_a_decoder_may_ask_for_the_file_and_for_one_to_write(
    file: Path, decoders: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hands_descriptors: bool
) -> None:
    if not hands_descriptors:
        untrusted.stop_children()
    monkeypatch.setattr(untrusted, "HANDS_DESCRIPTORS", hands_descriptors and untrusted.HANDS_DESCRIPTORS)
    with (tmp_path / "scratch").open("w+b") as scratch:
        reply = decode_in_child(f"{decoders}:copy_tail", file, as_file=True, scratch=scratch)
        scratch.seek(0)
        assert scratch.read() == bytes(range(6, 256))
    assert reply["size"] == 256 * 100
    untrusted.stop_children()


@pytest.mark.skipif(sys.platform == "darwin", reason="macOS does not limit address space")
def test_memory_is_bounded(file: Path, decoders: str) -> None:
    with pytest.raises(InputError, match="GiB"):
        decode_in_child(f"{decoders}:eat", file, memory_bytes=2 << 30)
    assert decode_in_child(f"{decoders}:echo", file)


def test_a_decoder_that_hangs_is_stopped(file: Path, decoders: str) -> None:
    with pytest.raises(InputError, match=r"within 0\.5 s"):
        decode_in_child(f"{decoders}:hang", file, timeout_s=0.5)
    assert decode_in_child(f"{decoders}:echo", file)


def test_time_that_other_programs_take_is_not_that_of_a_file(file: Path, decoders: str) -> None:
    """A decoder that waits has used no CPU time; one that computes for ever has."""
    assert decode_in_child(f"{decoders}:wait", file, timeout_s=0.5)
    with pytest.raises(InputError, match=r"within 0\.5 s"):
        decode_in_child(f"{decoders}:compute", file, timeout_s=0.5)


def test_a_decoder_process_that_does_not_start_is_not_blamed_on_the_file(
    file: Path, decoders: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    untrusted.stop_children()
    monkeypatch.setattr(untrusted, "START_LIMIT_S", 0.01)
    with pytest.raises(InputError, match="did not start"):
        decode_in_child(f"{decoders}:echo", file)


def test_the_time_of_a_file_begins_when_the_process_has_started(
    file: Path, decoders: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    untrusted.stop_children()
    monkeypatch.setattr(untrusted, "_START", f"import time; time.sleep(2.1)\n{untrusted._START}")
    assert decode_in_child(f"{decoders}:echo", file, timeout_s=2.0)


def test_two_files_are_decoded_at_once_and_no_process_stays(file: Path, decoders: str) -> None:
    pids = []
    threads = [
        threading.Thread(target=lambda: pids.append(decode_in_child(f"{decoders}:echo", file)["pid"])) for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(pids) == 8
    assert len(set(pids)) <= untrusted.CHILDREN
    untrusted.stop_children()
    assert not [pid for pid in pids if psutil.pid_exists(pid)]


def test_an_expected_process_serves_the_first_file(file: Path, decoders: str, monkeypatch: pytest.MonkeyPatch) -> None:
    untrusted.stop_children()
    untrusted.expect(f"{decoders}:echo")
    untrusted.expect(decoders)
    (child,) = untrusted._idle
    assert decode_in_child(f"{decoders}:echo", file)["pid"] == child.process.pid
    untrusted.stop_children()

    def none_left(*_arguments: Any, **_options: Any) -> None:
        raise BlockingIOError

    with monkeypatch.context() as short:
        short.setattr(subprocess, "Popen", none_left)
        untrusted.expect(decoders)
    assert untrusted._idle == []
    assert decode_in_child(f"{decoders}:echo", file)


def test_a_decoder_of_another_kind_ends_none_of_photographs(monkeypatch: pytest.MonkeyPatch) -> None:
    """A batch of captures needs both in turn, and each start takes as long as a photograph."""
    ended, waiting = list[str](), list[Any]()
    monkeypatch.setattr(untrusted, "_idle", waiting)
    monkeypatch.setattr(untrusted, "IDLE", runpy.run_path(untrusted.__file__)["IDLE"])  # as it is outside of tests
    for name in [*["photographs"] * untrusted.CHILDREN, "maps"]:
        untrusted._keep(SimpleNamespace(kill=lambda name=name: ended.append(name)))  # type: ignore[arg-type]
    assert ended == []
    untrusted._keep(SimpleNamespace(kill=lambda: ended.append("others")))  # type: ignore[arg-type]
    assert ended == ["photographs"]


def test_a_killed_idle_child_is_replaced(file: Path, decoders: str) -> None:
    pid = decode_in_child(f"{decoders}:echo", file)["pid"]
    idle = psutil.Process(pid)
    idle.kill()
    idle.wait(10)
    assert decode_in_child(f"{decoders}:echo", file)["pid"] != pid


def test_a_child_ends_when_its_parent_is_gone(file: Path, decoders: str) -> None:
    code = (
        "from engine.storage.untrusted import decode_in_child; import os, sys\n"
        f"print(decode_in_child('{decoders}:echo', {str(file)!r})['pid'], flush=True)\n"
        "os.kill(os.getpid(), 9)\n"
    )
    root = os.fspath(Path(untrusted.__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([root, *sys.path])}
    printed = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    pid = int(printed.stdout)
    for _ in range(100):
        if not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
            return
        time.sleep(0.05)
    pytest.fail("the decoder outlived its parent by 5 s")


def test_large_contents_do_not_block_each_other(tmp_path: Path, decoders: str) -> None:
    path = tmp_path / "large.bin"
    path.write_bytes(np.random.default_rng(0).bytes(20_000_000))
    reply = decode_in_child(f"{decoders}:echo", path)
    assert reply["content"].tobytes() == path.read_bytes()


@pytest.mark.parametrize("shared", [True, False])
def test_arrays_come_through_shared_memory_or_the_pipe(
    file: Path, decoders: str, shared: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not shared:
        monkeypatch.delattr(os, "memfd_create", raising=False)
    before = psutil.Process().num_fds()
    reply = decode_in_child(f"{decoders}:made_in_place", file)
    assert (reply["array"] == 7).all()
    assert reply["copied"].tolist() == list(range(5))
    assert np.array_equal(reply["view"], np.arange(12).reshape(3, 4).T)
    assert reply["empty"].shape == (0, 2)
    decode_in_child(f"{decoders}:echo", file)
    assert (reply["array"] == 7).all()
    del reply
    assert psutil.Process().num_fds() <= before + 3  # of the child: two pipes and a socket


def test_arrays_are_mapped_and_not_read_once_more(file: Path, decoders: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(SharedFile, "_read")  # what takes the arrays of a child that still maps them
    reply = decode_in_child(f"{decoders}:made_in_place", file)
    assert (reply["array"] == 7).all()


def test_arrays_lie_in_files_that_no_child_knows_while_memory_is_limited(
    file: Path, decoders: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shared_memory, "_IN_FILES_BYTES", 1)
    with scratch.keep_in_memory(0):
        reply = decode_in_child(f"{decoders}:made_in_place", file)
        assert isinstance(reply["array"], np.memmap)
    assert (reply["array"] == 7).all()
    assert reply["copied"].tolist() == list(range(5))
    assert np.array_equal(reply["view"], np.arange(12).reshape(3, 4).T)
    monkeypatch.setattr(os, "sendfile", lambda *_: 0)
    with scratch.keep_in_memory(0), pytest.raises(InputError, match="invalid response"):
        decode_in_child(f"{decoders}:made_in_place", file)


def test_fault18_a_child_that_answers_nonsense_costs_one_file(file: Path, decoders: str) -> None:
    with pytest.raises(InputError, match="invalid response"):
        decode_in_child(f"{decoders}:nonsense", file, timeout_s=20)
    assert decode_in_child(f"{decoders}:echo", file)


def test_fault18_a_request_that_does_not_reach_a_dead_child_goes_to_another(
    file: Path, decoders: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pid = decode_in_child(f"{decoders}:echo", file)["pid"]
    idle = psutil.Process(pid)
    idle.kill()
    idle.wait(10)
    lies = [True]
    alive = property(lambda child: lies.pop() if lies else child.process.poll() is None)
    monkeypatch.setattr(untrusted._Child, "alive", alive)
    assert decode_in_child(f"{decoders}:echo", file)["pid"] != pid


def test_fault17_a_decoding_that_never_ends_is_cancelled(file: Path, decoders: str) -> None:
    decode_in_child(f"{decoders}:echo", file)
    decodings = [Decoding(f"{decoders}:hang", file) for _ in range(untrusted.CHILDREN + 1)]
    assert not decodings[0].wait(0.2)
    for decoding in decodings:
        decoding.cancel()
    assert all(decoding.wait(0) for decoding in decodings)
    assert not any(child.alive for child in untrusted._running)
    assert decode_in_child(f"{decoders}:echo", file)
