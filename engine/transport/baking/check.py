"""Check of a bake: how far small images of it are from the reference, under lights that are known, kept in its file.

Measured by `engine.accuracy.bake_check` when a bake ends. A bake passes under a light where no view is further than
`MAX_MEAN` from the mean of the reference and at most `MAX_DARK` of the pixels are below a tenth of it. Whoever draws
the bake says where it does not pass. The record lies in the last page of the file, which is zero until then.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.core.errors import InputError
from engine.core.figure_text import percent
from engine.storage import atomic
from engine.storage.text import read_json
from engine.transport.baking.file_header import PAGE, REMEDY

#: Largest deviation of the mean of a view, and largest share of pixels below a tenth of the reference.
MAX_MEAN, MAX_DARK = 0.02, 0.001

#: The light of a check that is no environment: one direction.
LAMP = "a lamp"

#: Lights that a check holds at most.
MAX_LIGHTS = 12

#: Characters of a light's name that are kept.
MAX_NAME = 80

_Share = Annotated[float, Field(ge=0.0, le=1.0)]


class LightCheck(BaseModel):
    """Deviation of the images under one light from the reference.

    Attributes
    ----------
    light : name of the environment, or `LAMP`.
    mean_rel : deviation of the mean radiance, of the view where it is largest; positive where the bake is brighter.
    mean_uncertainty : of it, two standard errors of the reference.
    rmse_rel : relative RMSE of all views, the noise of the reference taken off.
    dark, bright : shares of the pixels below a tenth of the reference and above ten times of it.
    pixels : how many these are known from.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    light: Annotated[str, Field(max_length=MAX_NAME)]
    mean_rel: Annotated[float, Field(ge=-1.0, allow_inf_nan=False)]
    mean_uncertainty: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
    rmse_rel: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
    dark: _Share
    bright: _Share
    pixels: Annotated[int, Field(ge=0, le=1 << 40)]

    @property
    def passes(self) -> bool:
        """True where neither the mean nor dark pixels are beyond their limits."""
        return abs(self.mean_rel) - self.mean_uncertainty <= MAX_MEAN and self.dark <= MAX_DARK

    def deviation(self) -> str:
        """Return what is wrong, in a few words, where the bake does not pass."""
        way = "too bright" if self.mean_rel > 0.0 else "too dark"
        parts = [f"{percent(abs(self.mean_rel))} {way}"] if abs(self.mean_rel) > MAX_MEAN else []
        if self.dark > MAX_DARK:
            parts.append(f"{percent(self.dark)} of its pixels below a tenth of the reference")
        return " and ".join(parts)


#: Words on a bake that has no check.
NOT_COMPARED = "this bake was not compared with the reference"


class Alternative(BaseModel):
    """Another mode, with its default settings, and the `lights` under which it passes where the bake does not."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    mode: Annotated[str, Field(pattern=r"^[a-z-]{1,20}$")]
    lights: Annotated[tuple[str, ...], Field(max_length=MAX_LIGHTS)]


class BakeCheck(BaseModel):
    """The checks of a bake under several lights, each seen from `views` directions in images of `edge`² pixels.

    `alternative` is what was tried where the bake does not pass under all lights, if anything was.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    views: Annotated[int, Field(ge=1, le=1000)]
    edge: Annotated[int, Field(ge=1, le=1 << 14)]
    lights: Annotated[tuple[LightCheck, ...], Field(max_length=MAX_LIGHTS)]
    alternative: Alternative | None = None

    @property
    def failed(self) -> tuple[LightCheck, ...]:
        """The lights under which the bake does not pass."""
        return tuple(each for each in self.lights if not each.passes)

    def under(self, environment: str | None) -> tuple[LightCheck, ...]:
        """Checks that speak for a light: the environment of that name, else all; the lamp where the name is None."""
        if environment is None:
            return tuple(each for each in self.lights if each.light == LAMP)
        around = tuple(each for each in self.lights if each.light != LAMP)
        return tuple(each for each in around if each.light == environment[:MAX_NAME]) or around


def lines_of_check(check: BakeCheck) -> list[str]:
    """One sentence with the error under each light."""
    said = (f"{percent(each.rmse_rel)} under {each.light}" for each in check.lights)
    return [f"error of {check.views} small views against the reference: {', '.join(said)}"]


def warnings_of_check(check: BakeCheck | None, mode: str, label: Callable[[str], str] = str) -> list[str]:
    """The lights under which a bake of `mode` does not pass, in one sentence; none where it passes.

    `label` gives the name of a mode that a user knows it by.
    """
    if check is None or not check.failed:
        return []
    said = "; ".join(f"under {each.light} {each.deviation()}" for each in check.failed)
    return [
        f"in the mode {label(mode)} this bake differs from the reference: {said}{_advise(check, check.failed, label)}"
    ]


def warnings_at_render(
    check: BakeCheck | None, mode: str, environment: str | None, label: Callable[[str], str] = str
) -> list[str]:
    """The same for an image under an environment of a name, or under lamps alone where it is None."""
    found = () if check is None else tuple(each for each in check.under(environment) if not each.passes)
    if check is None or not found:
        return []
    worst = max(found, key=lambda each: (each.dark, abs(each.mean_rel)))
    is_same = environment is not None and worst.light == environment[:MAX_NAME]
    seen = "under this light" if is_same else f"under {worst.light}"
    seen += "" if is_same or environment is None else ", the nearest light that was checked,"
    advice = _advise(check, (worst,), label)
    return [f"in the mode {label(mode)} this bake differs from the reference: {seen} {worst.deviation()}{advice}"]


def _advise(check: BakeCheck, failed: Sequence[LightCheck], label: Callable[[str], str]) -> str:
    """Name the mode that was tried and passes where the bake fails, as the end of a sentence."""
    other = check.alternative
    better = [each.light for each in failed if other is not None and each.light in other.lights]
    if other is None or not better:
        return ""
    names = better[0] if len(better) == 1 else f"{', '.join(better[:-1])} and {better[-1]}"
    return f"; the mode {label(other.mode)} passes {'there' if len(better) == len(failed) else f'under {names}'}"


def write_check(path: str | os.PathLike[str], check: BakeCheck) -> None:
    """Write `check` into the last page of the transport file `path`, in one piece; OutputError where it cannot be."""
    atomic.overwrite_end(path, encode_check(check))


def encode_check(check: BakeCheck) -> bytes:
    """Bytes of the page: length and CRC-32 of a JSON text, the text, zeros."""
    text = json.dumps(check.model_dump(), ensure_ascii=True, allow_nan=False, sort_keys=True).encode()
    if len(text) > PAGE - 8:
        raise ValueError(f"a check of {len(text)} bytes does not fit a page")
    return (len(text).to_bytes(4, "little") + zlib.crc32(text).to_bytes(4, "little") + text).ljust(PAGE, b"\0")


def decode_check(path: Path, page: bytes) -> BakeCheck | None:
    """The check in a page; None where it is zero. InputError where it is damaged."""
    if not any(page):
        return None
    length, checksum = (int.from_bytes(page[at : at + 4], "little") for at in (0, 4))
    text = page[8 : 8 + length]
    if len(text) != length or zlib.crc32(text) != checksum or any(page[8 + length :]):
        raise InputError(path, "is damaged: the checksum of its check does not fit", REMEDY)
    try:
        return BakeCheck.model_validate(read_json(text, path, "its check", REMEDY))
    except ValidationError:
        raise InputError(path, "holds a check with impossible values", REMEDY) from None
