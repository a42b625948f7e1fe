"""Parameters are declared once, as fields of a frozen dataclass: default, range, unit and a sentence.

    @dataclass(frozen=True)
    class Phong:
        exponent: float = param(20.0, 0.0, 1e6, doc="Sharpness of the highlight.", slider=(1.0, 1000.0), log=True)

The window's sliders, the command line's `phong:exponent=20`, the GLSL uniforms, manifests and the ranges of the
property tests are all read from this declaration.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, TypeVar, cast

Instance = TypeVar("Instance")

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Parameter:
    """Declaration of one parameter: allowed range [low, high], the slider's narrower range, unit and a sentence."""

    name: str
    default: float | Colour
    low: float
    high: float
    slider: tuple[float, float]
    unit: str
    doc: str
    log: bool

    @property
    def is_colour(self) -> bool:
        return isinstance(self.default, tuple)

    @property
    def label(self) -> str:
        """The name as a person reads it: `alpha_x` becomes 'Alpha x'; a unit suffix is left to `unit`."""
        words = self.name.removesuffix("_deg").replace("_", " ")
        return words[:1].upper() + words[1:]


def param(
    default: float | Colour,
    low: float,
    high: float,
    *,
    doc: str,
    unit: str = "",
    slider: tuple[float, float] | None = None,
    log: bool = False,
) -> Any:
    """Declare a dataclass field as a parameter in [low, high]; a tuple default makes it a linear RGB colour."""
    if not low <= high:
        raise ValueError(f"empty parameter range [{low}, {high}]")
    declaration = {
        "low": low,
        "high": high,
        "slider": slider or (low, high),
        "unit": unit,
        "doc": doc,
        "log": log,
    }
    return dataclasses.field(default=default, metadata={"parameter": declaration})


def parameters(of: Any) -> tuple[Parameter, ...]:
    """The declared parameters of a dataclass (type or instance), in order of declaration."""
    return tuple(
        Parameter(name=field.name, default=cast("float | Colour", field.default), **field.metadata["parameter"])
        for field in dataclasses.fields(of)
        if "parameter" in field.metadata
    )


def check(instance: Any) -> None:
    """Raise ValueError if a parameter of `instance` is outside its range; call it from `__post_init__`.

    The test is `low <= x <= high`, so NaN is refused as well. A single number given for a colour becomes grey.
    """
    for parameter in parameters(instance):
        value = getattr(instance, parameter.name)
        if parameter.is_colour:
            colour = (value, value, value) if isinstance(value, (int, float)) else tuple(value)
            if len(colour) != 3:
                raise ValueError(f"{parameter.name} needs one number or three, got {value!r}")
            value = tuple(float(channel) for channel in colour)
        else:
            value = float(value)
        for number in value if isinstance(value, tuple) else (value,):
            if not parameter.low <= number <= parameter.high:
                raise ValueError(
                    f"{parameter.name} = {number:g} is outside [{parameter.low:g}, {parameter.high:g}]"
                    f"{' ' + parameter.unit if parameter.unit else ''}"
                )
        object.__setattr__(instance, parameter.name, value)


def parse(of: type[Instance], text: str) -> Instance:
    """Make an instance from `name=value,name=value`; a colour is one number or `r/g/b`.

    Raises ValueError, naming the parameters that exist, for an unknown name, a bad number or a value out of range.
    """
    declared = {parameter.name: parameter for parameter in parameters(of)}
    values: dict[str, float | tuple[float, ...]] = {}
    for item in filter(None, (piece.strip() for piece in text.split(","))):
        name, equals, number = (piece.strip() for piece in item.partition("="))
        if not equals or name not in declared:
            raise ValueError(f"unknown parameter {name!r}; known are {', '.join(declared)}")
        try:
            numbers = tuple(float(channel) for channel in number.split("/"))
        except ValueError:
            raise ValueError(f"{name} = {number!r} is not a number") from None
        if len(numbers) != 1 and not (declared[name].is_colour and len(numbers) == 3):
            raise ValueError(
                f"{name} = {number!r} needs {'one number or r/g/b' if declared[name].is_colour else 'one number'}"
            )
        values[name] = numbers if len(numbers) == 3 else numbers[0]
    return of(**values)


def unparse(instance: Any) -> str:
    """The text that `parse` turns back into `instance`."""

    def number(value: float | Colour) -> str:
        return "/".join(repr(channel) for channel in value) if isinstance(value, tuple) else repr(value)

    return ",".join(f"{p.name}={number(getattr(instance, p.name))}" for p in parameters(instance))
