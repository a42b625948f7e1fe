"""A value that a test knows to be there, where its type allows None."""

from __future__ import annotations

from typing import TypeVar

T = TypeVar("T")


def present(value: T | None) -> T:
    """Give `value`; the test fails if it is None."""
    assert value is not None
    return value
