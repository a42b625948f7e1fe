"""The border of the library: whatever goes wrong within it leaves it as a `LightarcError`."""

from __future__ import annotations

import functools
import operator
import warnings
from collections.abc import Callable, Mapping
from typing import ParamSpec, TypeVar

import numpy as np

from engine.core.errors import LightarcError, UsageError, file_failure, shortage

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

#: Longest side of an image, in pixels.
MAX_SIDE_PX = 65_536


def public(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """`function`, whose errors are those of `engine.core.errors`, and whose numerical warnings stay within it.

    A value that it cannot work with raises UsageError, which is a ValueError too, a file InputError or OutputError,
    and too little memory OutOfMemory.
    """

    @functools.wraps(function)
    def guard(*arguments: Parameters.args, **options: Parameters.kwargs) -> Result:
        try:
            with np.errstate(all="ignore"):
                return function(*arguments, **options)
        except LightarcError:
            raise
        except Exception as error:  # the border of the library: nothing else leaves it
            lack = shortage(error)
            if lack is not None:
                raise lack from error
            if (refused := file_failure(error)) is not None:
                raise refused from error
            if isinstance(error, RecursionError):
                raise UsageError(f"{function.__name__}: a value is nested too deeply") from error
            raise UsageError(f"{function.__name__}: {error or type(error).__name__}") from error

    return guard


def accept_old_names(
    old: Mapping[str, str],
) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """Accept parameters by the names of the release before, old to new, with a warning."""

    def accept(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        @functools.wraps(function)
        def translate(*arguments: Parameters.args, **options: Parameters.kwargs) -> Result:
            for name in old.keys() & options.keys():
                text = f"the parameter {name} of {function.__name__} is called {old[name]}"
                warnings.warn(text, DeprecationWarning, stacklevel=2)
                options[old[name]] = options.pop(name)
            return function(*arguments, **options)

        return translate

    return accept


def check_size(size: tuple[int, int]) -> None:
    """UsageError for an image size that is not two whole numbers of pixels from 1 to `MAX_SIDE_PX`."""
    try:
        width, height = map(operator.index, size)
    except (TypeError, ValueError):
        raise UsageError(f"image size must be (width, height) in whole pixels, not {size!r:.60}") from None
    if not (1 <= width <= MAX_SIDE_PX and 1 <= height <= MAX_SIDE_PX):
        raise UsageError(
            f"image size must be from 1 × 1 to {MAX_SIDE_PX:,} × {MAX_SIDE_PX:,} pixels, not {width:,} × {height:,}"
        )
