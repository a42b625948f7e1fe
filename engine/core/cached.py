"""Properties that are computed once for each object, without a lock, and results that are remembered.

`functools.cached_property` of Python 3.11 holds one lock for all objects of a class while it computes, so that the
window waits for the value of another scene that a job computes at length. Python 3.12 removed the lock, and this class
stands for that one before; two threads that ask at once may both compute, and one of the equal values stays.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

__all__ = ["cached_property", "remember", "remember_with"]

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")
First = TypeVar("First")


def remember(count: int) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """Keep the last `count` results of a function, as `functools.lru_cache`, of arguments that have a hash.

    A BRDF of a user's own class may have none, as a dataclass that is not frozen: its results are computed each time.
    """

    def decorate(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        kept: Any = functools.lru_cache(maxsize=count)(function)

        @functools.wraps(function)
        def call(*arguments: Parameters.args, **options: Parameters.kwargs) -> Result:
            try:
                hash((arguments, *options.values()))
            except TypeError:
                return function(*arguments, **options)
            result: Result = kept(*arguments, **options)
            return result

        return call

    return decorate


def remember_with(
    function: Callable[Concatenate[First, Parameters], Result],
) -> Callable[Concatenate[First, Parameters], Result]:
    """Keep the result of a function for each first argument as long as that lives; the others follow from it."""
    kept: WeakKeyDictionary[Any, Result] = WeakKeyDictionary()

    @functools.wraps(function)
    def call(first: First, /, *others: Parameters.args, **options: Parameters.kwargs) -> Result:
        if first not in kept:
            kept[first] = function(first, *others, **options)
        return kept[first]

    return call


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
