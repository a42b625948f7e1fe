"""Confinement of a process that reads untrusted files, by what its system offers; it cannot be undone.

Linux: Landlock leaves the reading of the Python installation, of the system's libraries and of this program's code, and
takes all other files, TCP, and signals and abstract sockets to other processes (`man 7 landlock`). A seccomp filter
allows the system calls that decoders need (`man 2 seccomp`, x86-64 and AArch64); among what it takes are sockets, new
processes and programs, opening a file for writing, `ptrace`, and signals. Where the kernel has the filter alone, other
files of the same user can be read, and what is read cannot be sent anywhere but to the parent. Descriptors that are
open stay usable.

Landlock does not hide that a file exists, nor its size and times (`stat`). Where the system lets a user make namespaces
(`man 7 user_namespaces`), the process therefore gets a root of its own first, which holds the readable folders alone.

Other systems: nothing, which `Protection.sentence` says.

Ours, because the libraries for Landlock on PyPI (landlock, py-landlock, landlockpy) are pre-releases or months old, and
those for seccomp (pyseccomp) need a libseccomp that wheels do not bring; both are three system calls.
Cost: a millisecond; 2 µs more per system call.
"""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import stat
import struct
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from engine.core.cached import cached_property
from engine.core.health import Finding, Health, Verdict

_PROJECT = Path(__file__).resolve().parents[2]

_NO_NEW_PRIVILEGES = 38  # of prctl
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # of all architectures
_READ_FILE, _READ_DIR = 1 << 2, 1 << 3

#: Rights to files that each version of Landlock added: how many bits there are from it on.
_FILE_RIGHTS = {1: 13, 2: 14, 3: 15, 5: 16}
_TCP, _SCOPES = 0b11, 0b11
_TCP_SINCE, _SCOPES_SINCE = 4, 6

_NEW_USER, _NEW_MOUNTS = 0x10000000, 0x00020000  # of unshare
_READ_ONLY, _NO_SETUID, _NO_DEVICES, _NO_PROGRAMS, _REMOUNT = 1, 2, 4, 8, 32
_BIND, _RECURSIVE, _PRIVATE = 4096, 16384, 1 << 18
_MAX_LINKS = 40  # as many as Linux follows
_DETACH = 2  # of umount2
#: The folder that becomes the root; what it holds otherwise is hidden from the process alone.
_ROOT = "/tmp"
_PIVOT_ROOT = {"x86_64": 155, "aarch64": 41}

_ALLOW, _REFUSE, _ABSENT = 0x7FFF0000, 0x00050000 | 1, 0x00050000 | 38  # EPERM; ENOSYS, after which libc asks otherwise
_LOAD, _IF_EQUAL, _IF_ANY, _RETURN = 0x20, 0x15, 0x45, 0x06
_NUMBER_AT, _ARCHITECTURE_AT, _ARGUMENTS_AT = 0, 4, 16

_NEW_THREAD = 0x00010000
_ANY_WRITING = 0o3 | 0o100 | 0o1000 | 0o20000000  # access mode, O_CREAT, O_TRUNC, O_TMPFILE
_OWN_DESCRIPTOR = (0, 1, 2, 3, 4, 1030)  # F_DUPFD, F_GETFD, F_SETFD, F_GETFL, F_SETFL, F_DUPFD_CLOEXEC
_OWN_DEVICE = (0x5401, 0x5421, 0x5450, 0x5451)  # TCGETS, FIONBIO, FIONCLEX, FIOCLEX


@dataclass(frozen=True)
class Protection:
    """The confinement of a process.

    Attributes
    ----------
    landlock : the version of Landlock, 0 for none.
    seccomp : a filter of system calls holds.
    hidden : other files are not there for the process: neither names nor sizes of them can be found out.
    """

    landlock: int = 0
    seccomp: bool = False
    hidden: bool = False

    @property
    def whole(self) -> bool:
        return bool(self.landlock) and self.seccomp

    @property
    def sentence(self) -> str:
        """The protection in words for a user."""
        if self.whole:
            means = f"(Landlock {self.landlock}, seccomp{', a root of its own' if self.hidden else ''})"
            lack = "" if self.hidden else ", but could ask whether a file exists: this system grants no namespaces"
            return f"Files are decoded in a process that opens no other file, no network and no program {means}{lack}"
        if self.seccomp:
            return (
                "Files are decoded in a process that writes no file and opens no network and no program (seccomp), "
                "but could read other files: this kernel has no Landlock"
            )
        if self.landlock:
            return (
                f"Files are decoded in a process that opens no other file and no program (Landlock {self.landlock}), "
                "but could open a network: this kernel or CPU has no seccomp filter"
            )
        return "Files are decoded in a process of its own, which this system does not confine further"

    @cached_property
    def health(self) -> Health:
        """The sentence as a finding."""
        return Health(findings=(Finding(Verdict.GOOD if self.whole else Verdict.NOTE, self.sentence),))


@dataclass(frozen=True)
class _Cpu:
    """A CPU as the kernel names it, its number of `seccomp`, and its column of `_SYSTEM_CALLS`."""

    architecture: int
    seccomp: int
    column: int


_PROCESSORS = {"x86_64": _Cpu(0xC000003E, 317, 0), "aarch64": _Cpu(0xC00000B7, 277, 1)}

#: System calls that decoders need, with their numbers on x86-64 and AArch64; None: this CPU has no such call.
_SYSTEM_CALLS: dict[str, tuple[int, int | None]] = {
    "read": (0, 63),
    "write": (1, 64),
    "futex": (202, 98),
    "mmap": (9, 222),
    "munmap": (11, 215),
    "mprotect": (10, 226),
    "brk": (12, 214),
    "madvise": (28, 233),
    "mremap": (25, 216),
    "close": (3, 57),
    "lseek": (8, 62),
    "pread64": (17, 67),
    "pwrite64": (18, 68),
    "readv": (19, 65),
    "writev": (20, 66),
    "fstat": (5, 80),
    "newfstatat": (262, 79),
    "statx": (332, 291),
    "stat": (4, None),
    "lstat": (6, None),
    "access": (21, None),
    "readlink": (89, None),
    "faccessat": (269, 48),
    "faccessat2": (439, 439),
    "readlinkat": (267, 78),
    "getdents64": (217, 61),
    "getcwd": (79, 17),
    "fadvise64": (221, 223),
    "ftruncate": (77, 46),
    "fallocate": (285, 47),
    "recvmsg": (47, 212),
    "dup": (32, 23),
    "dup2": (33, None),
    "dup3": (292, 24),
    "pipe": (22, None),
    "pipe2": (293, 59),
    "poll": (7, None),
    "select": (23, None),
    "ppoll": (271, 73),
    "pselect6": (270, 72),
    "rt_sigaction": (13, 134),
    "rt_sigprocmask": (14, 135),
    "rt_sigreturn": (15, 139),
    "sigaltstack": (131, 132),
    "alarm": (37, None),
    "setitimer": (38, 103),
    "nanosleep": (35, 101),
    "clock_gettime": (228, 113),
    "clock_getres": (229, 114),
    "clock_nanosleep": (230, 115),
    "sched_yield": (24, 124),
    "sched_getaffinity": (204, 123),
    "getcpu": (309, 168),
    "getpid": (39, 172),
    "gettid": (186, 178),
    "getuid": (102, 174),
    "geteuid": (107, 175),
    "getgid": (104, 176),
    "getegid": (108, 177),
    "uname": (63, 160),
    "sysinfo": (99, 179),
    "times": (100, 153),
    "getrusage": (98, 165),
    "mincore": (27, 232),
    "getrandom": (318, 278),
    "membarrier": (324, 283),
    "set_tid_address": (218, 96),
    "set_robust_list": (273, 99),
    "rseq": (334, 293),
    "futex_waitv": (449, 449),
    "restart_syscall": (219, 128),
    "exit": (60, 93),
    "exit_group": (231, 94),
    "openat": (257, 56),
    "clone": (56, 220),
    "clone3": (435, 435),
    "fcntl": (72, 25),
    "ioctl": (16, 29),
    "prlimit64": (302, 261),
}


def confine(*, landlock: bool = True, folder: str = "") -> Protection:
    """Confine this process for good, as far as the system can; what it got is returned.

    It must have one thread: Landlock holds for the thread that asks, and those that it starts later.
    `landlock` False leaves that out, as kernels without it do. Of files that are none of programs it may read those in
    a `folder`.
    """
    if sys.platform != "linux" or sys.maxsize < 1 << 32:
        return Protection()
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    libc.prctl.argtypes = [ctypes.c_int, *[ctypes.c_ulong] * 4]
    if libc.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0) != 0:
        return Protection()
    alone = len(os.listdir("/proc/self/task")) == 1  # noqa: PTH208 - names, no paths
    known = _readable() | ({Path(folder)} if folder else set())
    hidden = landlock and alone and _hide_files(libc, known)
    return Protection(_lock_land(libc, known) if landlock and alone else 0, _filter(libc), hidden)


def _hide_files(libc: ctypes.CDLL, known: set[Path]) -> bool:
    """Enter a root that holds the folders that are `known` alone, read-only; False where the system denies that."""
    readable = sorted({path.resolve() for path in known if path.exists()})
    outer = [path for path in readable if not any(other in path.parents for other in readable)]
    links = {link: target for link, target in _links(known) if not any(folder in link.parents for folder in outer)}
    user, group = os.getuid(), os.getgid()
    sources: list[int] = []
    try:
        _call(libc.unshare(_NEW_USER | _NEW_MOUNTS))
        for name, text in (("setgroups", "deny"), ("uid_map", f"{user} {user} 1"), ("gid_map", f"{group} {group} 1")):
            place = os.open(f"/proc/self/{name}", os.O_WRONLY)
            os.write(place, text.encode())
            os.close(place)
        _mount(libc, "none", "/", "", _RECURSIVE | _PRIVATE)
        # Held open because some may lie below the new root. They belong to the namespace only if opened within it.
        sources += [os.open(path, os.O_PATH | os.O_CLOEXEC) for path in outer]
        _mount(libc, "tmpfs", _ROOT, "tmpfs", _NO_SETUID | _NO_DEVICES)
    except (OSError, KeyError):
        return False
    try:
        for path, source in zip(outer, sources, strict=True):
            inside = Path(f"{_ROOT}{path}")
            is_folder = stat.S_ISDIR(os.fstat(source).st_mode)
            os.makedirs(inside if is_folder else inside.parent, exist_ok=True)  # noqa: PTH103 - atomic writing is for users
            if not is_folder:
                os.close(os.open(inside, os.O_CREAT | os.O_WRONLY))
            _mount(libc, f"/proc/self/fd/{source}", str(inside), "", _BIND | _RECURSIVE)
            _mount(libc, "none", str(inside), "", _BIND | _REMOUNT | _READ_ONLY | _get_kept_flags(inside))
        for link, target in links.items():
            inside = Path(f"{_ROOT}{link}")
            os.makedirs(inside.parent, exist_ok=True)  # noqa: PTH103
            if os.stat(inside.parent).st_dev != os.stat(_ROOT).st_dev:  # noqa: PTH116 - never in a folder of the user
                raise OSError(errno.EXDEV, "a link would lie outside the new root")
            os.symlink(target, inside)  # noqa: PTH211
        _mount(libc, "none", _ROOT, "", _REMOUNT | _READ_ONLY | _NO_SETUID | _NO_DEVICES)
        os.chdir(_ROOT)
        _call(libc.syscall(_PIVOT_ROOT[platform.machine()], b".", b"."))
        _call(libc.umount2(b".", _DETACH))
        os.chdir("/")
    except (OSError, KeyError):
        os.chdir("/")
        libc.umount2(_ROOT.encode(), _DETACH)
        return False
    finally:
        for source in sources:
            os.close(source)
    return True


def _links(known: set[Path]) -> set[tuple[Path, str]]:
    """Find the links on the way to the readable paths: where each lies, without links, and its target."""
    found = set()
    for path in known:
        place, rest, left = Path("/"), list(path.absolute().parts[1:]), _MAX_LINKS
        while rest and left:
            here = place.parent if rest[0] == ".." else place / rest[0]
            rest = rest[1:]
            if here.is_symlink():
                target, left = here.readlink(), left - 1
                found.add((here, str(target)))
                rest = [*target.parts[target.is_absolute() :], *rest]
                here = Path("/") if target.is_absolute() else here.parent
            place = here
    return found


def _get_kept_flags(place: Path) -> int:
    """The restrictions of a mount, which a namespace of a user must keep."""
    return os.statvfs(place).f_flag & (_NO_SETUID | _NO_DEVICES | _NO_PROGRAMS)


def _mount(libc: ctypes.CDLL, source: str, target: str, kind: str, flags: int) -> None:
    _call(libc.mount(source.encode(), target.encode(), kind.encode() or None, ctypes.c_ulong(flags), None))


def _call(result: int) -> None:
    if result != 0:
        raise OSError(ctypes.get_errno(), "the system refuses a root of its own")


def _lock_land(libc: ctypes.CDLL, known: set[Path]) -> int:
    """Leave the reading of the files that are `known`; the version of Landlock, 0 where there is none."""
    version = libc.syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), 1)
    if version < 1:
        return 0
    files = (1 << max(bits for since, bits in _FILE_RIGHTS.items() if since <= version)) - 1
    handled = struct.pack("QQQ", files, _TCP, _SCOPES)
    size_bytes = 24 if version >= _SCOPES_SINCE else 16 if version >= _TCP_SINCE else 8
    ruleset = libc.syscall(_CREATE_RULESET, handled, ctypes.c_size_t(size_bytes), 0)
    if ruleset < 0:
        return 0
    try:
        for path in known:
            _allow_reading(libc, ruleset, path)
        return version if libc.syscall(_RESTRICT_SELF, ruleset, 0) == 0 else 0
    finally:
        os.close(ruleset)


def _allow_reading(libc: ctypes.CDLL, ruleset: int, path: Path) -> None:
    try:
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:  # a folder of modules need not exist
        return
    rights = _READ_FILE | _READ_DIR if path.is_dir() else _READ_FILE
    libc.syscall(_ADD_RULE, ruleset, 1, struct.pack("=Qi", rights, place), 0)
    os.close(place)


def _readable() -> set[Path]:
    """The folders of Python's modules, of libraries and of this program."""
    modules = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")}
    modules |= {path for path in sys.path if path and _has_packages(Path(path))}
    libraries = os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    libraries += [f"{sys.base_prefix}/lib", "/usr/lib", "/usr/lib64", "/usr/local/lib", "/lib", "/lib64"]
    own = (_PROJECT / "engine", _PROJECT / "resources")
    return {Path(path) for path in (*modules, *libraries, "/etc/ld.so.cache") if path} | set(own)


def _has_packages(folder: Path) -> bool:
    """True if packages are installed in a folder: it is called so, or holds a record of an installation."""
    return folder.name in ("site-packages", "dist-packages") or next(folder.glob("*.dist-info"), None) is not None


def _filter(libc: ctypes.CDLL) -> bool:
    """Let the system calls through that decoders need; False where this kernel or CPU has no filter."""
    cpu = _PROCESSORS.get(platform.machine())
    if cpu is None:
        return False
    steps = list(_program(cpu))
    code = ctypes.create_string_buffer(b"".join(steps))
    program = struct.pack("HxxxxxxQ", len(steps), ctypes.addressof(code))
    every_thread, filtering = 1, 1
    return bool(libc.syscall(cpu.seccomp, filtering, every_thread, program) == 0)


def _program(cpu: _Cpu) -> Iterator[bytes]:
    """The filter: instructions of classic BPF that look at one system call at a time."""
    conditions = {
        "openat": _unless_any(2, _ANY_WRITING),
        "clone": _if_any(0, _NEW_THREAD),
        "clone3": [_step(_RETURN, _ABSENT)],
        "fcntl": _if_one_of(1, _OWN_DESCRIPTOR),
        "ioctl": _if_one_of(1, _OWN_DEVICE),
        "prlimit64": _if_one_of(0, (0,)),
    }
    yield _step(_LOAD, _ARCHITECTURE_AT)
    yield _step(_IF_EQUAL, cpu.architecture, 1, 0)
    yield _step(_RETURN, _REFUSE)
    yield _step(_LOAD, _NUMBER_AT)
    for name, numbers in _SYSTEM_CALLS.items():
        number = numbers[cpu.column]
        if number is not None:
            yield from _on(number, conditions.get(name, [_step(_RETURN, _ALLOW)]))
    yield _step(_RETURN, _REFUSE)


def _on(number: int, steps: list[bytes]) -> list[bytes]:
    return [_step(_IF_EQUAL, number, 0, len(steps)), *steps]


def _if_any(argument: int, bits: int) -> list[bytes]:
    return [_argument(argument), _step(_IF_ANY, bits, 0, 1), _step(_RETURN, _ALLOW), _step(_RETURN, _REFUSE)]


def _unless_any(argument: int, bits: int) -> list[bytes]:
    return [_argument(argument), _step(_IF_ANY, bits, 0, 1), _step(_RETURN, _REFUSE), _step(_RETURN, _ALLOW)]


def _if_one_of(argument: int, values: Iterable[int]) -> list[bytes]:
    tests = [step for value in values for step in (_step(_IF_EQUAL, value, 0, 1), _step(_RETURN, _ALLOW))]
    return [_argument(argument), *tests, _step(_RETURN, _REFUSE)]


def _argument(index: int) -> bytes:
    """Load the lower half of an argument, on CPUs that store it first: those of the table."""
    return _step(_LOAD, _ARGUMENTS_AT + 8 * index)


def _step(code: int, value: int, then: int = 0, otherwise: int = 0) -> bytes:
    return struct.pack("HBBI", code, then, otherwise, value)
