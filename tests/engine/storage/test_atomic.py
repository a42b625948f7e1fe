"""Writing: complete or absent, whatever fails and wherever the process dies (faults 1, 2, 12, 13, 14, 17)."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from engine.core.errors import InputError, OutputError
from engine.storage import atomic, writer
from engine.storage.partial_names import aside_name, partial_name

OLD, NEW = b"old" * 40_000, b"new" * 50_000


@pytest.fixture(autouse=True)
def no_fault_stays() -> Iterator[None]:
    yield
    atomic.fault = None


def write_file(folder: Path) -> None:
    with atomic.atomic_file(folder / "result.exr") as output:
        output.write(NEW[:70_000])
        output.write(NEW[70_000:])


def write_folder(folder: Path) -> None:
    with atomic.atomic_folder(folder / "result.exr", "marker.json") as partial:
        atomic.write_bytes(partial / "marker.json", NEW)
        atomic.write_json(atomic.make_folder(partial / "inner") / "more.json", {"a": 1})


def prepare_file(folder: Path) -> None:
    (folder / "result.exr").write_bytes(OLD)


def prepare_folder(folder: Path) -> None:
    (folder / "result.exr").mkdir()
    (folder / "result.exr" / "marker.json").write_bytes(OLD)


def content(folder: Path) -> bytes | None:
    path = folder / "result.exr"
    path = path / "marker.json" if path.is_dir() else path
    return path.read_bytes() if path.exists() else None


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


def complaint_of(write: Callable[[Path], None], folder: Path) -> str | None:
    try:
        write(folder)
    except OutputError as error:
        return str(error)
    return None


#: Rounds in which a process dies at every operation; the first is in the ordinary suite.
DEATHS = 4

KINDS = pytest.mark.parametrize(
    ("prepare", "write"), [(prepare_file, write_file), (prepare_folder, write_folder)], ids=["file", "folder"]
)


class FailAt:
    """Counts operations and fails the one numbered `at`, or all from there on."""

    def __init__(self, at: int, code: int, persistent: bool) -> None:
        self.at, self.code, self.persistent, self.count = at, code, persistent, 0

    @property
    def fired(self) -> bool:
        return self.count >= self.at

    def __call__(self, _operation: str, _path: Path) -> None:
        self.count += 1
        if self.count == self.at or (self.persistent and self.fired):
            raise OSError(self.code, os.strerror(self.code))


@KINDS
@pytest.mark.parametrize("exchange", [True, False], ids=["one-step", "two-steps"])
@pytest.mark.parametrize(
    ("code", "persistent"),
    [
        pytest.param(errno.ENOSPC, False, id="full disk"),
        pytest.param(errno.EIO, True, id="disk error from then on"),
        pytest.param(errno.EACCES, False, id="no access", marks=pytest.mark.long),
        pytest.param(errno.EMFILE, True, id="too many open files from then on", marks=pytest.mark.long),
    ],
)
def test_fault_1_every_operation_fails(
    tmp_path: Path,
    prepare: Callable[[Path], None],
    write: Callable[[Path], None],
    code: int,
    persistent: bool,
    exchange: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if not exchange:
        monkeypatch.setattr(atomic, "_exchange", lambda _one, _other: False)
    for at in range(1, 200):
        folder = tmp_path / str(at)
        folder.mkdir()
        prepare(folder)
        atomic.fault = fault = FailAt(at, code, persistent)
        complaint = complaint_of(write, folder)
        assert complaint is None or (str(folder) in complaint and "partial-" not in complaint)
        atomic.fault = None
        assert content(folder) in (OLD, NEW) or not exchange
        atomic.remove_leftovers(folder)
        assert content(folder) in (OLD, NEW)
        assert names(folder) == ["result.exr"]
        if not fault.fired:
            assert content(folder) == NEW
            return
    pytest.fail("the loop never reached the end of the work")


def test_fault_1_full_disk_names_needed_and_free_bytes(tmp_path: Path) -> None:
    prepare_file(tmp_path)

    def full(operation: str, _path: Path) -> None:
        if operation == "write":
            raise OSError(errno.ENOSPC, "")

    atomic.fault = full
    with pytest.raises(OutputError, match=r"result.exr: the disk is full \(70,000 bytes needed, [\d.]+ [MGT]B free\)"):
        write_file(tmp_path)
    assert (names(tmp_path), content(tmp_path)) == (["result.exr"], OLD)


def test_fault_1_room_is_asked_for_before_the_first_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(atomic, "free_bytes", lambda _folder: 1099)
    with pytest.raises(OutputError, match="1,100 bytes needed, 1,099 bytes free"):
        atomic.write_bytes(tmp_path / "a", bytes(1000))
    assert names(tmp_path) == []
    atomic.write_bytes(tmp_path / "a", bytes(999))


def run_child(script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    root = Path(__file__).resolve().parents[3]
    return subprocess.run(
        [sys.executable, "-c", script, *arguments],
        cwd=root, env={**os.environ, "PYTHONPATH": str(root)}, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.skipif(sys.platform != "linux", reason="RLIMIT_FSIZE")
def test_fault_1_real_limit_of_the_system(tmp_path: Path) -> None:
    prepare_file(tmp_path)
    script = (
        "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))\n"
        "from engine.core.errors import OutputError\nfrom engine.storage.atomic import write_bytes\n"
        "try: write_bytes(sys.argv[1], bytes(200000))\n"
        "except OutputError as error: print(error)"
    )
    printed = run_child(script, str(tmp_path / "result.exr")).stdout
    assert "larger than this file system or account allows" in printed
    assert (names(tmp_path), content(tmp_path)) == (["result.exr"], OLD)


@KINDS
def test_short_writes_are_continued(
    tmp_path: Path, prepare: Callable[[Path], None], write: Callable[[Path], None]
) -> None:
    prepare(tmp_path)
    atomic.fault = lambda operation, _path: 999 if operation == "write" else None
    write(tmp_path)
    assert content(tmp_path) == NEW


def die_at(at: int, work: Callable[[], None]) -> int:
    """Do `work` in a copy of this process that ends with code 9 at operation number `at`; the exit code."""
    copy = os.fork()
    if copy:
        return os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
    count = iter(range(1, 1_000_000))
    atomic.fault = lambda _operation, _path: os._exit(9) if next(count) == at else None
    with contextlib.suppress(BaseException):
        work()
        os._exit(0)
    os._exit(1)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process")
@KINDS
@pytest.mark.parametrize("exchange", [True, False], ids=["one-step", "two-steps"])
@pytest.mark.campaign(rounds=DEATHS)
def test_fault_2_death_at_every_operation(
    tmp_path: Path,
    prepare: Callable[[Path], None],
    write: Callable[[Path], None],
    exchange: bool,
    seed: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if not exchange:
        monkeypatch.setattr(atomic, "_exchange", lambda _one, _other: False)
    for at in range(1 + seed % DEATHS, 200, DEATHS):
        folder = tmp_path / str(at)
        folder.mkdir()
        prepare(folder)
        code = die_at(at, lambda folder=folder: write(folder))  # type: ignore[misc]
        assert code in (0, 9)
        assert content(folder) in (OLD, NEW) or not exchange
        atomic.remove_leftovers(folder)
        assert content(folder) in (OLD, NEW)
        assert names(folder) == ["result.exr"]
        if code == 0:
            assert content(folder) == NEW
            return
    pytest.fail("the loop never reached the end of the work")


@KINDS
def test_fault_17_closed_generator_leaves_nothing(
    tmp_path: Path, prepare: Callable[[Path], None], write: Callable[[Path], None]
) -> None:
    prepare(tmp_path)
    enter = atomic.atomic_file if write is write_file else lambda path: atomic.atomic_folder(path, "marker.json")

    def work() -> Iterator[int]:
        with enter(tmp_path / "result.exr"):
            yield 1

    steps = work()
    next(steps)
    assert len(names(tmp_path)) == 2
    steps.close()  # type: ignore[attr-defined]
    assert (names(tmp_path), content(tmp_path)) == (["result.exr"], OLD)


def test_what_was_put_aside_is_kept_until_it_can_be_brought_back(tmp_path: Path) -> None:
    aside = tmp_path / name_partial_of(aside_name(), 999999999)
    (aside / "result.exr").mkdir(parents=True)
    (aside / "result.exr" / "marker.json").write_bytes(OLD)
    for at in range(1, 4):
        atomic.fault = FailAt(at, errno.EIO, persistent=True)
        atomic.remove_leftovers(tmp_path)
        assert names(tmp_path) == [aside.name]
        assert (aside / "result.exr" / "marker.json").read_bytes() == OLD
    atomic.fault = None
    atomic.remove_leftovers(tmp_path)
    assert (names(tmp_path), content(tmp_path)) == (["result.exr"], OLD)


def test_leftovers_of_a_running_process_stay(tmp_path: Path) -> None:
    parent = os.getppid()
    ours = partial_name(tmp_path / "a.exr")
    running = name_partial_of(ours, parent, writer.start_of(parent))
    elsewhere, abandoned = (name_partial_of(ours, number, host="render_farm_7") for number in (999999998, 999999997))
    kept = [running, elsewhere, ".a.partial-notes.exr"]
    number_used_again = name_partial_of(ours, parent, 1)
    for name in (*kept, ours, name_partial_of(ours, 999999999), number_used_again, abandoned):
        (tmp_path / name).touch()
    long_ago = time.time() - writer.ABANDONED_S - 60.0
    os.utime(tmp_path / abandoned, (long_ago, long_ago))
    with atomic.atomic_file(tmp_path / "b") as output:
        assert names(tmp_path) == sorted([*kept, *(name for name in names(tmp_path) if "b.part" in name)])
        output.write(b"1")
    assert names(tmp_path) == sorted([*kept, "b"])


def name_partial_of(name: str, process: int, start: int | None = 1, host: str | None = None) -> str:
    """The name of a partial as another process or machine would have made it."""
    head, tail = name.split("-", 2)[:2] if name.startswith(".lightarc") else name.split("-", 1)[:1], name.split("-")
    return "-".join([*head, host or tail[-4], str(process), str(start), tail[-1]])


@pytest.mark.skipif(not hasattr(os, "statvfs"), reason="the system does not say")
def test_a_medium_without_writing_is_called_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path)
    monkeypatch.setattr(os, "statvfs", lambda _folder: SimpleNamespace(f_flag=os.ST_RDONLY))
    with pytest.raises(OutputError, match="the file system is read-only"):
        atomic.write_bytes(tmp_path / "a", b"1")


@KINDS
def test_a_failing_close_is_a_failure_of_the_disk(
    tmp_path: Path, prepare: Callable[[Path], None], write: Callable[[Path], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    prepare(tmp_path)
    really_close = os.close

    def over_quota(descriptor: int) -> None:
        really_close(descriptor)
        raise OSError(errno.EDQUOT, "")

    with monkeypatch.context() as patch:
        patch.setattr(os, "close", over_quota)
        complaint = complaint_of(write, tmp_path)
    assert complaint is not None
    assert re.search(r"your disk quota is used up", complaint)
    assert (names(tmp_path), content(tmp_path)) == (["result.exr"], OLD)


def test_fault_12_only_files_are_replaced_by_files(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    os.mkfifo(tmp_path / "pipe")
    for target, cause in (
        (tmp_path / "folder", "it is a folder"),
        (tmp_path / "pipe", "not a regular file"),
        (Path("/dev/null"), "not a regular file"),
        (tmp_path / "loop", "circle"),
        (tmp_path / "absent" / "a", "the folder does not exist"),
        (Path("/"), "it is the root"),
    ):
        before = sorted(tmp_path.iterdir())
        with pytest.raises(OutputError, match=cause):
            atomic.write_bytes(target, b"1")
        assert sorted(tmp_path.iterdir()) == before


def test_folders_of_others_are_never_replaced(tmp_path: Path) -> None:
    foreign = tmp_path / "photographs"
    foreign.mkdir()
    (foreign / "a.jpg").touch()
    with (
        pytest.raises(OutputError, match=r"holds no marker.json"),
        atomic.atomic_folder(foreign, "marker.json"),
    ):
        pytest.fail("the block must not be entered")
    (tmp_path / "file").touch()
    with (
        pytest.raises(OutputError, match="a file of that name"),
        atomic.atomic_folder(tmp_path / "file", "marker.json"),
    ):
        pytest.fail("the block must not be entered")
    (foreign / "a.jpg").unlink()
    with atomic.atomic_folder(foreign, "marker.json") as partial:
        (partial / "marker.json").touch()
    assert names(foreign) == ["marker.json"]


def test_symbolic_links_are_followed_and_stay(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real/target")
    atomic.write_bytes(tmp_path / "link", b"1")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "target").read_bytes() == b"1"


ODD_NAMES = [
    "ä" * 127, "é.exr", "😀.png", "\u202eltr", "a b", "it's \"q\"", "100%", "new\nline", "x" * 255, "x" * 251 + ".exr",
    "trailing.", os.fsdecode(b"\xff\xfe"), "." + "y" * 254,
]  # fmt: skip


@pytest.mark.skipif(sys.platform != "linux", reason="names that only Linux takes")
@pytest.mark.parametrize("name", ODD_NAMES, ids=ascii)
def test_fault_13_odd_names(tmp_path: Path, name: str) -> None:
    atomic.write_bytes(tmp_path / name, b"1")
    with atomic.atomic_folder(tmp_path / "folder", "marker.json") as partial:
        atomic.write_bytes(partial / name, b"2")
    assert names(tmp_path) == sorted([name, "folder"])
    assert (tmp_path / "folder" / name).read_bytes() == b"2"


@pytest.mark.parametrize(
    "name", ["x" * 256, "ä" * 128, "nul\0", "a/" * 2500, "\ud800"], ids=lambda name: ascii(name[:9])
)
def test_fault_13_impossible_names(tmp_path: Path, name: str) -> None:
    with pytest.raises(OutputError) as caught:
        atomic.write_bytes(f"{tmp_path}/{name}", b"1")
    assert str(caught.value).isprintable()
    assert names(tmp_path) == []


def test_fault_14_protected_files_and_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    prepare_file(tmp_path)
    allowed = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "result.exr" and allowed(path, mode))
    with pytest.raises(OutputError, match="write-protected"):
        write_file(tmp_path)
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path)
    with pytest.raises(OutputError, match="writing here is not permitted"):
        write_file(tmp_path)
    assert (names(tmp_path), content(tmp_path)) == (["result.exr"], OLD)


def test_permissions_of_a_replaced_file_stay(tmp_path: Path) -> None:
    prepare_file(tmp_path)
    (tmp_path / "result.exr").chmod(0o640)
    write_file(tmp_path)
    assert (tmp_path / "result.exr").stat().st_mode & 0o777 == 0o640


def test_json_refuses_what_json_cannot_say(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="JSON"):
        atomic.write_json(tmp_path / "a.json", {"a": float("nan")})
    assert names(tmp_path) == []


def test_an_exception_of_the_block_passes_unchanged(tmp_path: Path) -> None:
    with contextlib.suppress(KeyError), atomic.atomic_file(tmp_path / "a") as output:
        output.write(b"1")
        raise KeyError
    assert names(tmp_path) == []


def test_a_library_that_cannot_write_names_the_final_path(tmp_path: Path) -> None:
    with pytest.raises(OutputError) as caught, atomic.atomic_folder(tmp_path / "a", "marker") as partial:
        raise OSError(errno.ENOSPC, "No space left on device", str(partial / "b.tif"))
    assert caught.value.path == str(tmp_path / "a" / "b.tif")
    assert list(tmp_path.iterdir()) == []


def test_what_is_written_and_read_again_is_named_as_it_will_be_called(tmp_path: Path) -> None:
    with pytest.raises(InputError) as raised, atomic.atomic_folder(tmp_path / "out", "marker") as folder:
        raise InputError(folder / "a.lightarc", "is damaged", "Copy it again")
    assert raised.value.path == str(tmp_path / "out" / "a.lightarc")
