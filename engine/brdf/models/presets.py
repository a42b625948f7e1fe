"""Published parameters of measured materials, named as in `lafortune:preset=blue-paint`.

The tables are in resources/brdf; the first line of each is its citation. Values are as printed, also where a fit
reflects more light than it receives: `preset.brdf.energy_conserving` says so.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from engine.brdf.models.lafortune import Lafortune, LafortuneThreeLobes
from engine.core.errors import UsageError

#: Most names that an error lists.
_LISTED = 8

_TABLES = Path(__file__).resolve().parents[3] / "resources" / "brdf"


@dataclass(frozen=True)
class Preset:
    """A named set of parameters: the model's name, the value, and where the numbers were published."""

    name: str
    model: str
    brdf: Lafortune | LafortuneThreeLobes
    source: str

    @property
    def text(self) -> str:
        """Text that `brdf_from_text` turns into `brdf`."""
        return f"{self.model}:preset={self.name}"


def find_preset(model: str, name: str) -> Preset:
    """The preset `name` of a model; UsageError names some that are near."""
    known = [preset for preset in PRESETS if preset.model == model]
    for preset in known:
        if preset.name == name:
            return preset
    if not known:
        raise UsageError(f"{model} has no presets; those of lafortune are the only ones")
    names = [preset.name for preset in known]
    alike = [known_name for known_name in names if any(word and word in known_name for word in name.split("-"))]
    listed = (alike or get_close_matches(name[:40], names) or names)[:_LISTED]
    more = "" if len(names) == len(listed) else f" and {len(names) - len(listed)} more"
    raise UsageError(f"unknown preset {name[:40]!r} of {model}; choose from {', '.join(listed)}{more}")


def _rows(table: str) -> tuple[str, list[dict[str, str]]]:
    """The citation in the first line and the rows below the comments."""
    lines = (_TABLES / table).read_text(encoding="utf-8").splitlines()
    return lines[0].lstrip("# "), list(csv.DictReader(line for line in lines if not line.startswith("#")))


def _three_lobes(table: str) -> Iterator[Preset]:
    """A row per channel, three rows in the order r, g, b per material."""
    citation, rows = _rows(table)
    for red, green, blue in zip(rows[0::3], rows[1::3], rows[2::3], strict=True):
        colours = {
            key: (float(red[key]), float(green[key]), float(blue[key])) for key in red if key not in ("name", "channel")
        }
        lobes = {f"{key}{lobe + 1}": colours[f"{key}{lobe}"] for lobe in range(3) for key in ("cxy", "cz")}
        exponents = {f"exponent{lobe + 1}": colours[f"n{lobe}"] for lobe in range(3)}
        yield Preset(
            red["name"], "lafortune", LafortuneThreeLobes(kd=colours["diffuse"], **lobes, **exponents), citation
        )


def _one_lobe(table: str) -> Iterator[Preset]:
    citation, rows = _rows(table)
    for row in rows:
        kd, ks = ((float(row[f"{key}_r"]), float(row[f"{key}_g"]), float(row[f"{key}_b"])) for key in ("kd", "ks"))
        brdf = Lafortune(kd=kd, ks=ks, cxy=float(row["cxy"]), cz=float(row["cz"]), exponent=float(row["n"]))
        yield Preset(row["name"], "lafortune", brdf, citation)


#: The library, in the order of the tables.
PRESETS = (*_three_lobes("lafortune_three_lobes.csv"), *_one_lobe("ngan2005_one_lobe.csv"))

_TEXTS = {preset.brdf: preset.text for preset in PRESETS}


def text_of_preset(brdf: object) -> str | None:
    """`model:preset=name` where `brdf` has exactly the parameters of a preset."""
    return _TEXTS.get(brdf) if isinstance(brdf, Lafortune | LafortuneThreeLobes) else None
