"""Arrays in memory that others have left."""

import numpy as np

from engine.storage.reused import ReusedMemory


def test_memory_goes_to_the_next_array_of_its_size_when_no_view_is_left() -> None:
    memory = ReusedMemory()
    first = memory.array((3, 4), np.float32)
    view, place = first[1:, ::2].T, first.ctypes.data
    view[...] = 7
    del first
    assert memory.array((12,), np.float32).ctypes.data != place
    assert (view == 7).all()
    del view
    assert memory.array((13,), np.float32).ctypes.data != place
    again = memory.array((6, 8), np.bool_)
    assert (again.ctypes.data, again.shape, again.dtype) == (place, (6, 8), np.bool_)
    memory.close()
    del again
    assert memory.array((0, 3), np.float32).shape == (0, 3)
    assert memory.array((3, 4), np.float32).shape == (3, 4)
