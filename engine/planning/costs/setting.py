"""One way to draw a scene: a mode and what is chosen of its parameters.

    reference     samples: paths for each pixel
    direct        directions: lights that stand for the environment
    shading-map   directions; power_law: 0 the slices, 1 the fit

those of other packages, and the transport methods with those of their parameters that have a sweep
(`engine.transport.method`).

Parameters that are not named have their mode's default. A setting is a value: it may be a key, and equal settings are
one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, cast

from engine.core.params import Parameter
from engine.scene.mode import MODES, ModeParameter, Number
from engine.transport import method as transport


def modes() -> tuple[str, ...]:
    """Every mode, from the one that bakes nothing and is exact to the one that bakes most."""
    return (*reversed(MODES), *transport.names())


def parameters_of(mode: str) -> Mapping[str, ModeParameter]:
    """The parameters of a mode by name; ValueError where there is no such mode."""
    if mode in MODES:
        return MODES[mode].parameters
    if mode not in transport.names():
        raise ValueError(f"unknown mode {mode!r}; choose from {', '.join(modes())}")
    return {each.name: _parameter(each) for each in transport.method_of(mode).parameters}


def _parameter(parameter: Parameter) -> ModeParameter:
    low, high, default = int(parameter.low), int(parameter.high), int(cast(int, parameter.default or 0))
    return ModeParameter(low, high, default, parameter.sweep, parameter.doc, parameter.values)


def shows(mode: str, effect: str) -> bool:
    """True where images of a mode can have an effect that not all modes have."""
    return effect in (MODES[mode] if mode in MODES else transport.method_of(mode)).shows


def shows_of_sharp(mode: str, effect: str) -> bool:
    """True where images of a mode can have an effect of sharp lights: lamps, and the suns of an environment."""
    return shows(mode, effect) or (mode in MODES and effect in MODES[mode].shows_of_sharp)


@dataclass(frozen=True)
class Setting:
    """A mode with all of its parameters; those not given are at their default.

    ValueError for a mode or a parameter that is not known, and for a value out of its range.
    """

    mode: str
    parameters: Mapping[str, Number] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        known = parameters_of(self.mode)
        strange = [name for name in self.parameters if name not in known]
        if strange:
            raise ValueError(f"{strange[0]!r} is not a parameter of {self.mode}; it has {', '.join(known)}")
        whole = {
            name: _check(name, parameter, self.parameters.get(name, parameter.default))
            for name, parameter in known.items()
        }
        object.__setattr__(self, "parameters", MappingProxyType(whole))

    def __hash__(self) -> int:
        return hash((self.mode, *self.parameters.items()))

    def __getitem__(self, name: str) -> int:
        """The value of a parameter; all of them are whole numbers so far."""
        return int(self.parameters[name])

    def __str__(self) -> str:
        shown = [f"{name} {value}" for name, value in self.parameters.items() if value != 0 or name == "order"]
        return f"{self.mode}, {', '.join(shown)}"

    def replace(self, **parameters: Number) -> Setting:
        """This with some parameters turned."""
        return Setting(self.mode, {**self.parameters, **parameters})

    def as_json(self) -> dict[str, Any]:
        return {"mode": self.mode, "knobs": dict(self.parameters)}


def setting_of(record: object) -> Setting:
    """The setting that `as_json` wrote; ValueError for anything else."""
    if not isinstance(record, dict) or not isinstance(record.get("knobs", {}), dict):
        raise ValueError("a setting is an object with mode and parameters")
    return Setting(str(record.get("mode")), record.get("knobs", {}))


def sweep(mode: str, parameter: str, base: Setting | None = None) -> Iterator[Setting]:
    """`base` (the defaults of the mode where None) at each step of one parameter, cheapest first."""
    start = Setting(mode) if base is None else base
    for value in parameters_of(mode)[parameter].sweep:
        yield start.replace(**{parameter: value})


def _check(name: str, parameter: ModeParameter, value: object) -> Number:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{name} is a number, not {value!r}")
    if not parameter.low <= value <= parameter.high or value != int(value):
        raise ValueError(f"{name} {value} is not a whole number in {parameter.low} … {parameter.high}")
    if parameter.values and value not in parameter.values:
        raise ValueError(f"{name} {value} is none of the numbers {', '.join(map(str, parameter.values))}")
    return int(value)
