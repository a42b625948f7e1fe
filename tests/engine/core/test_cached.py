"""A property that one object computes keeps no other object waiting."""

from __future__ import annotations

import threading

import pytest

from engine.core.cached import cached_property, remember


class Squared:
    def __init__(self, number: int, proceed: threading.Event | None = None) -> None:
        self.number, self.proceed, self.computed = number, proceed, 0
        self.begun = threading.Event()

    @cached_property
    def square(self) -> int:
        self.computed += 1
        self.begun.set()
        if self.proceed is not None:
            assert self.proceed.wait(30)
        return self.number**2


def test_a_value_is_computed_once_and_kept() -> None:
    one = Squared(3)
    assert (one.square, one.square, one.computed) == (9, 9, 1)
    assert one.__dict__["square"] == 9
    del one.square
    assert (one.square, one.computed) == (9, 2)


def test_nobody_waits_for_the_value_of_another_object() -> None:
    slow = Squared(2, threading.Event())
    thread = threading.Thread(target=lambda: slow.square)
    thread.start()
    assert slow.begun.wait(30)
    found: list[int] = []
    other = threading.Thread(target=lambda: found.append(Squared(5).square), daemon=True)
    other.start()
    other.join(10)
    assert slow.proceed is not None
    slow.proceed.set()
    thread.join(30)
    assert found == [25]


def test_results_are_remembered_where_arguments_have_a_hash() -> None:
    calls: list[object] = []

    @remember(2)
    def name(value: object, sign: str = "!") -> str:
        calls.append(value)
        return f"{value}{sign}"

    assert [name(1), name(1), name(1, sign="?"), name([2]), name([2])] == ["1!", "1!", "1?", "[2]!", "[2]!"]
    assert calls == [1, 1, [2], [2]]


def test_a_fault_of_the_function_is_its_own() -> None:
    @remember(2)
    def fail(_value: object) -> None:
        raise TypeError("of its own")

    with pytest.raises(TypeError, match="of its own"):
        fail(1)
