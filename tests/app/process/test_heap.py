"""Freed arrays go back to the system."""

from __future__ import annotations

import subprocess
import sys

import pytest

TAKE_AND_FREE = """
import numpy as np, psutil
from app.process.heap import give_back_freed_arrays

def own_mib():
    return psutil.Process().memory_full_info().uss / 2**20

give_back_freed_arrays()
np.ones(3 * 2**20)  # 24 MiB, freed at once: arrays of up to that size come from the pool now
arrays, above, before = [], [], own_mib()
for _ in range(8):
    arrays.append(np.ones(2**20))
    above.append(np.ones(2000))
taken = own_mib() - before
arrays.clear()
print(taken, own_mib() - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="a setting of glibc")
def test_arrays_below_a_small_one_go_back_when_they_are_freed() -> None:
    found = subprocess.run([sys.executable, "-c", TAKE_AND_FREE], check=True, capture_output=True, text=True)
    taken, kept = map(float, found.stdout.split())
    assert taken > 60.0
    assert kept < 12.0


SMALL_ONES = """
import time
import numpy as np, psutil
from app.process import heap

heap.EVERY_S = 0.05
heap.give_back_freed_arrays()
heap.give_back_free_pages()
before = psutil.Process().memory_full_info().uss / 2**20
arrays = [np.ones(2**15) for _ in range(800)]  # 256 KiB each, from a pool
taken = psutil.Process().memory_full_info().uss / 2**20 - before
del arrays[:-1]  # the last one lies above all others
time.sleep(0.5)
print(taken, psutil.Process().memory_full_info().uss / 2**20 - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="a service of glibc")
def test_free_pages_below_a_small_array_go_back() -> None:
    found = subprocess.run([sys.executable, "-c", SMALL_ONES], check=True, capture_output=True, text=True)
    taken, kept = map(float, found.stdout.split())
    assert taken > 150.0
    assert kept < 40.0
