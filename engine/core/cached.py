"""Properties that are computed once for each object, without a lock.

`functools.cached_property` of Python 3.11 holds one lock for all objects of a class while it computes, so that the
window waits for the value of another scene that a job computes at length. Python 3.12 removed the lock, and this class
stands for that one before; two threads that ask at once may both compute, and one of the equal values stays.
"""

from __future__ import annotations

import functools
import sys
from typing import TYPE_CHECKING, Any

__all__ = ["cached_property"]

if TYPE_CHECKING or sys.version_info >= (3, 12):
    from functools import cached_property
else:

    class cached_property(functools.cached_property):
        """A property whose value is kept in the object's `__dict__`."""

        def __get__(self, instance: Any, owner: Any = None) -> Any:
            if instance is None:
                return self
            if self.attrname not in instance.__dict__:
                instance.__dict__[self.attrname] = self.func(instance)
            return instance.__dict__[self.attrname]
