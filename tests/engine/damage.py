"""Damaged files by the recipe of OpenEXR's own fuzz test, deterministic for a seed, and what a reader may do with them.

As there (OpenEXRTest, `fuzzFile.cpp`), a window over a good file, most often over its header, is overwritten with
random values of a random density. Added are cuts at every 1/64 of the file and of its header (at random places from
seed 2 on), flipped bits, runs of zeros and of 0xFF, and blocks that are missing or there twice. Seed 0, that of the
ordinary suite, gives every sixteenth file only.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from engine.storage import untrusted

#: Damaged files per reader and seed, and one of how many of them is read in the ordinary suite.
COUNT = 800
_SAMPLED = 16

#: Seeds: the sample, and 25 of the campaign; one is 40,000 files over all readers and formats, all are a million.
ROUNDS = 26

#: Limits of time and memory for one damaged file (fault 5).
TIME_LIMIT_S = 2.0
MEMORY_LIMIT_BYTES = 512 << 20

_LARGEST_WINDOW = 64
_IN_HEADER = 0.7


class Damage(NamedTuple):
    """A damaged file: its content, what was done, and the bytes [first, last) of the good file that it concerns."""

    content: bytes
    what: str
    first: int
    last: int


def find_damaged(good: bytes, header: tuple[int, int], count: int = COUNT, *, seed: int) -> Iterator[Damage]:
    """`count` damaged copies of `good`, whose header is the bytes [header[0], header[1]); of seed 0 every sixteenth."""
    return islice(_all_damaged(good, header, count, seed), 0, None, 1 if seed else _SAMPLED)


def _all_damaged(good: bytes, header: tuple[int, int], count: int, seed: int) -> Iterator[Damage]:
    cuts = {len(good) * part // 64 for part in range(64)}
    cuts |= {header[0] + (header[1] - header[0]) * part // 64 for part in range(65)} | {1, 2, 4, 8, len(good) - 1}
    random = np.random.default_rng(seed)
    if seed > 1:
        cuts = set(random.integers(1, len(good), len(cuts)).tolist())
    for cut in sorted(cuts - {0, len(good)}):
        yield Damage(good[:cut], "cut", cut, len(good))
    left = count - len(cuts)
    while left > 0:
        one = _damage(good, header, random)
        if one.content and one.content != good:
            left -= 1
            yield one


def _damage(good: bytes, header: tuple[int, int], random: np.random.Generator) -> Damage:
    low, high = header if random.random() < _IN_HEADER else (0, len(good))
    first = int(random.integers(low, high))
    last = min(high, first + int(_LARGEST_WINDOW ** random.random()))
    window = np.frombuffer(good[first:last], np.uint8).copy()
    what = str(random.choice(["noise", "noise", "flips", "zeros", "ones", "removed", "doubled"]))
    if what == "noise":
        hit = random.random(len(window)) < random.random()
        hit[random.integers(len(window))] = True
        window[hit] = random.integers(0, 256, int(hit.sum()))
    elif what == "flips":
        places = random.integers(0, len(window), random.integers(1, 9))
        np.bitwise_xor.at(window, places, (1 << random.integers(0, 8, len(places))).astype(np.uint8))
    elif what == "removed":
        window = window[:0]
    elif what == "doubled":
        window = np.tile(window, 2)
    else:
        window[:] = 0 if what == "zeros" else 255
    moved = what in ("removed", "doubled")
    return Damage(good[:first] + window.tobytes() + good[last:], what, first, len(good) if moved else last)


def peak_memory_bytes(pid: int) -> int:
    """Most physical memory that a process has held, where the system says so (Linux); else 0."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0
    return next((int(line.split()[1]) << 10 for line in status.splitlines() if line.startswith("VmHWM")), 0)


def decoder_pids() -> list[int]:
    """The decoder processes that run now."""
    return [child.process.pid for child in tuple(untrusted._running)]
