"""Parameters are declared once, as fields of a frozen dataclass: default, range, unit and a sentence.

    @dataclass(frozen=True)
    class Phong:
        exponent: float = param(20.0, 0.0, 1e6, doc="Sharpness of the highlight.", slider=(1.0, 1000.0), log=True)

The window's sliders, the command line's `phong:exponent=20`, the GLSL uniforms, manifests and the ranges of the
property tests are all read from this declaration. The settings of a transport method (`engine.transport.method`) also
have whole numbers, flags, words of a list and texts: `whole`, `flag`, `choice`, `texts`.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, TypeVar, cast

from engine.core.errors import UsageError
from engine.core.suggestion import suggest

Instance = TypeVar("Instance")

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Parameter:
    """Declaration of one parameter: allowed range [low, high], the slider's narrower range, unit and a sentence.

    Attributes
    ----------
    kind : what its values are; a default of None stands for what follows from other parameters or from a plan.
    values : all that are allowed; empty for the whole range.
    sweep : values of a sweep, cheapest first; empty for what is not swept.
    offered : values of a form, with their words. words : its label, where the name is none.
    option : of the command line, without dashes, where that is not the name. fitted : False for a parameter of a BRDF
        that a fit leaves as it is.
    """

    name: str
    default: float | Colour
    low: float
    high: float
    slider: tuple[float, float]
    unit: str
    doc: str
    log: bool
    kind: Literal["number", "whole", "flag", "choice", "text", "texts"] = "number"
    values: tuple[Any, ...] = ()
    sweep: tuple[int, ...] = ()
    offered: tuple[tuple[Any, str], ...] = ()
    words: str = ""
    option: str = ""
    metavar: str = "N"
    fitted: bool = True

    @property
    def is_colour(self) -> bool:
        return isinstance(self.default, tuple)

    @property
    def label(self) -> str:
        """The name as a user reads it: `alpha_x` becomes 'Alpha x'; a unit suffix is left to `unit`.

        Names of a standard that spell 'color' are read as the other labels are.
        """
        words = self.words or self.name.removesuffix("_deg").replace("_", " ").replace("color", "colour")
        return words[:1].upper() + words[1:]

    @property
    def flag(self) -> str:
        """The option of the command line: `--occluder-cells`."""
        return f"--{self.option or self.name.replace('_', '-')}"

    def check(self, value: object, name: str = "") -> None:
        """UsageError for a value that is not allowed, about the `name`; None stands for the default."""
        name = name or self.name
        if value is None and self.default is None:
            return
        if self.kind == "whole":
            self._check_whole(value, name)
        elif self.kind == "flag" and not isinstance(value, bool):
            raise UsageError(f"{name} is on or off, not {value!r}")
        elif self.kind == "choice" and value not in self.values:
            raise UsageError(f"{name} is {', '.join(self.values)}, not {value!r}")
        elif self.kind == "text" and not isinstance(value, str):
            raise UsageError(f"{name} is a text, not {value!r}")
        elif self.kind == "texts" and not (isinstance(value, tuple) and all(isinstance(text, str) for text in value)):
            raise UsageError(f"{name} are texts, not {value!r}")

    def _check_whole(self, value: object, name: str) -> None:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UsageError(f"{name} is a number, not {value!r}")
        if isinstance(value, float) and not value.is_integer():  # which nothing infinite is, and not a number
            raise UsageError(f"{name} is a whole number, not {value!r}")
        if not self.low <= value <= self.high:
            raise UsageError(f"{name} {value} is outside {self.low:g} … {self.high:g}")
        if self.values and value not in self.values:
            raise UsageError(f"{name} {value} is not possible; {', '.join(map(str, self.values))} are")


def param(
    default: float | Colour,
    low: float,
    high: float,
    *,
    doc: str,
    unit: str = "",
    slider: tuple[float, float] | None = None,
    log: bool = False,
    fitted: bool = True,
) -> Any:
    """Declare a dataclass field as a parameter in [low, high]; a tuple default makes it a linear RGB colour.

    One that is not `fitted` keeps its value in fits.
    """
    if not low <= high:
        raise ValueError(f"empty parameter range [{low}, {high}]")
    declaration = {
        "low": low,
        "high": high,
        "slider": slider or (low, high),
        "unit": unit,
        "doc": doc,
        "log": log,
        "fitted": fitted,
    }
    return dataclasses.field(default=default, metadata={"parameter": declaration})


def same_as(declared: type[Any], name: str, **narrower: Any) -> Any:
    """Declare a field as the parameter `name` of another dataclass: its default, range, unit and sentence.

    `narrower` replaces some of these (`default`, `low`, `high`, `slider`, `log`, `doc`).
    """
    (found,) = (each for each in dataclasses.fields(declared) if each.name == name)
    default = narrower.pop("default", found.default)
    return dataclasses.field(default=default, metadata={"parameter": {**found.metadata["parameter"], **narrower}})


def whole(
    default: int | None,
    low: int,
    high: int,
    *,
    doc: str,
    slider: tuple[int, int] | None = None,
    log: bool = False,
    values: tuple[int, ...] = (),
    sweep: tuple[int, ...] = (),
    offered: tuple[tuple[int, str], ...] = (),
    words: str = "",
    option: str = "",
) -> Any:
    """Declare a whole number in [low, high], of `values` only where some are given; None follows from the others.

    A form offers the values of the `sweep` unless others are `offered`.
    """
    shown = offered or tuple((value, str(value)) for value in sweep)
    more = {"values": values, "sweep": sweep, "offered": shown, "words": words, "option": option}
    return _declare(default, low, high, doc, "whole", slider=slider or (low, high), log=log, **more)


def flag(
    default: bool | None,
    *,
    doc: str,
    sweep: tuple[int, ...] = (),
    offered: tuple[tuple[bool | None, str], ...] = (),
    words: str = "",
    option: str = "",
) -> Any:
    """Declare what is on or off; None leaves it to a plan."""
    return _declare(default, 0, 1, doc, "flag", sweep=sweep, offered=offered, words=words, option=option)


def choice(
    default: str | None, values: tuple[str, ...], *, doc: str, offered: tuple[tuple[str | None, str], ...] = ()
) -> Any:
    """Declare one word out of `values`; None follows from the others."""
    return _declare(default, 0, 0, doc, "choice", values=values, offered=offered)


def text(*, doc: str, metavar: str) -> Any:
    """Declare a text that need not be given."""
    return _declare(None, 0, 0, doc, "text", metavar=metavar)


def texts(*, doc: str, metavar: str) -> Any:
    """Declare any number of texts, none by default."""
    return _declare((), 0, 0, doc, "texts", metavar=metavar)


def _declare(default: Any, low: int, high: int, doc: str, kind: str, **more: Any) -> Any:
    shared = {"low": low, "high": high, "slider": (low, high), "unit": "", "doc": doc, "log": False, "kind": kind}
    return dataclasses.field(default=default, metadata={"parameter": {**shared, **more}})


def parameters(of: object) -> tuple[Parameter, ...]:
    """The declared parameters of a dataclass (type or instance), in order of declaration."""
    return _parameters(of if isinstance(of, type) else type(of))


@cache
def _parameters(of: type) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(name=field.name, default=cast("float | Colour", field.default), **field.metadata["parameter"])
        for field in dataclasses.fields(of)
        if "parameter" in field.metadata
    )


def check(instance: object) -> None:
    """Raise UsageError if a parameter of `instance` is outside its range; call it from `__post_init__`.

    The test is `low <= x <= high`, so NaN is refused as well. A single number given for a colour becomes grey, and a
    whole number of whatever type an int.
    """
    for parameter in parameters(instance):
        value = getattr(instance, parameter.name)
        if parameter.kind != "number":
            parameter.check(value)
            if parameter.kind == "whole" and value is not None:
                object.__setattr__(instance, parameter.name, int(value))
            continue
        try:
            if parameter.is_colour:
                colour = (value, value, value) if isinstance(value, (int, float)) else tuple(value)
                value = tuple(float(channel) for channel in colour)
            else:
                value = float(value)
        except (TypeError, ValueError):
            kind = "one number or three" if parameter.is_colour else "a number"
            raise UsageError(f"{parameter.name} needs {kind}, got {value!r:.60}") from None
        if isinstance(value, tuple) and len(value) != 3:
            raise UsageError(f"{parameter.name} needs one number or three, got {value!r}")
        for number in value if isinstance(value, tuple) else (value,):
            if not parameter.low <= number <= parameter.high:
                raise UsageError(
                    f"{parameter.name} = {number:g} is outside [{parameter.low:g}, {parameter.high:g}]"
                    f"{' ' + parameter.unit if parameter.unit else ''}"
                )
        object.__setattr__(instance, parameter.name, value)


def check_values(of: object, **values: Any) -> None:
    """Raise UsageError if one of `values` is none that the dataclass `of` declares for the parameter of that name."""
    declared = {parameter.name: parameter for parameter in parameters(of)}
    for name, value in values.items():
        declared[name].check(value)


def parse(of: type[Instance], text: str) -> Instance:
    """Make an instance from `name=value,name=value`; a colour is one number or `r/g/b`, a choice one of its words.

    Raises UsageError, naming the parameters that exist, for an unknown name, a bad number or a value out of range.
    """
    declared = {parameter.name: parameter for parameter in parameters(of)}
    values: dict[str, str | float | tuple[float, ...]] = {}
    for item in filter(None, (piece.strip() for piece in text.split(","))):
        name, equals, number = (piece.strip() for piece in item.partition("="))
        if not equals and name in declared:
            raise UsageError(f"{name} needs a value, as {name}={declared[name].default}")
        if not equals or name not in declared:
            meant = suggest(name, declared)
            raise UsageError(f"unknown parameter {name[:40]!r}{meant}; choose from {', '.join(declared)}")
        if name in values:
            raise UsageError(f"{name} is given twice")
        if declared[name].kind == "choice":
            values[name] = number
            continue
        try:
            numbers = tuple(float(channel) for channel in number.split("/"))
        except ValueError:
            raise UsageError(f"{name} = {number[:40]!r} is not a number") from None
        if len(numbers) != 1 and not (declared[name].is_colour and len(numbers) == 3):
            raise UsageError(
                f"{name} = {number[:40]!r} needs {'one number or r/g/b' if declared[name].is_colour else 'one number'}"
            )
        values[name] = numbers if len(numbers) == 3 else numbers[0]
    return of(**values)


def unparse(instance: object) -> str:
    """The text that `parse` turns back into `instance`."""

    def number(value: str | float | Colour) -> str:
        if isinstance(value, str):
            return value
        return "/".join(repr(channel) for channel in value) if isinstance(value, tuple) else repr(value)

    return ",".join(f"{p.name}={number(getattr(instance, p.name))}" for p in parameters(instance))
