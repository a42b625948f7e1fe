"""The export: a folder in which each target has a folder of its own, and a record of the error of each.

`TARGETS` lists them once; the command line, the window and the record read it. A target is a function from subject and
settings to a representation, whose errors are measured here, alike for all (`engine.exchange.loss`), and one to files,
which state those errors wherever their format has a place for words.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import engine
from engine.core.directions import surface_direction
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps, part
from engine.exchange import brdf, gltf, materialx, rti, shaders, textures, usd, web
from engine.exchange.loss import Floats, Shown, loss, material_shown, photograph_error, references, size_of
from engine.exchange.pbr_from_material import cavity, nearest_maps
from engine.exchange.subject import Contents, Settings, Subject
from engine.scene.material import Material
from engine.storage.atomic import atomic_folder, make_folder, write_bytes
from engine.surface.lamps import observed_slopes
from engine.surface.recover import recover

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack

#: The record of an export, by which its folder is known.
RECORD = "export.json"


@dataclass(frozen=True)
class Target:
    """A form in which a material leaves.

    Attributes
    ----------
    words : a sentence for people.
    shown : the representation as its files hold it, rounding included; None where it shows no picture of the surface.
    contents : the files, from subject, settings and the sentence that states the errors.
    """

    name: str
    words: str
    shown: Callable[[Subject, Settings], Shown | None]
    contents: Callable[[Subject, Settings, str], Steps[Contents]]


def in_8_bits(subject: Subject, _settings: Settings) -> Shown:
    """The PBR maps in pictures of 8 bits."""
    return subject.shown_as("png8")


def with_one_f0(subject: Subject, _settings: Settings) -> Shown:
    """The same with the mean f0, of formats that hold no map of it."""
    return subject.shown_as("png8", subject.mean_f0)


TARGETS: tuple[Target, ...] = (
    Target("textures", "PBR textures, named and packed for a program", textures.shown, textures.contents),
    Target("materialx", "MaterialX: OpenPBR and glTF PBR surfaces", with_one_f0, materialx.contents),
    Target("gltf", "glTF: a ball with the material, as .glb", in_8_bits, gltf.contents),
    Target("usd", "USD: a ball with UsdPreviewSurface, as .usdz", with_one_f0, usd.contents),
    Target("shaders", "GLSL and HLSL that evaluate the material itself", shaders.shown, shaders.contents),
    Target("web", "A page for any browser, and one for strict sites", web.shown, web.contents),
    Target("rti", "RTI: .ptm, .rti and a tree for web viewers", rti.shown, rti.contents),
    Target("brdf", "BRDF tables (CSV, ALTA, MERL, RGL) and the nearest model", brdf.shown, brdf.contents),
)

NAMES = tuple(target.name for target in TARGETS)

#: The name that stands for a choice, and the targets among which it chooses: one for each representation.
AUTO, CANDIDATES = "auto", ("textures", "shaders", "rti")


def subject_of(material: Material, stack: ImageStack | None = None) -> Steps[Subject]:
    """The material with PBR maps, and its photographs where they are at hand.

    The maps are measured where the photographs show the slopes of the surface, and else those nearest to the material.
    """
    if stack is not None and shows_slopes(stack) and stack.radiance.shape[1:3] == size_of(material):
        surface = yield from recover(stack, np.arange(len(stack.sources)), left_out=False)
        return Subject(material, surface.maps, surface.white, cavity(material), stack)
    maps, white = yield from nearest_maps(material)
    return Subject(material, maps, white, cavity(material), stack)


def shows_slopes(stack: ImageStack) -> bool:
    """True where the lamps of a stack stood on sides that tell slopes in both directions."""
    if stack.azimuth is None:
        return False
    lamps = surface_direction(0.5 * np.pi - stack.elevation, stack.azimuth)
    return observed_slopes(lamps).kind == "both"


def export(
    folder: str | os.PathLike[str],
    material: Material,
    names: Sequence[str],
    *,
    settings: Settings | None = None,
    stack: ImageStack | None = None,
    error: float = 0.05,
) -> Steps[dict[str, Any]]:
    """Write `material` to the targets `names` in `folder`, and return the record, the content of `RECORD`.

    `AUTO` alone writes the smallest of `CANDIDATES` whose `rmse_rel_reference` is at most `error`; `auto` of the
    record then holds all of them.

    `targets` of the record lists for each target its `files`, `bytes`, errors and warnings: `rmse_rel` against the
    photographs (None without a stack of the same size), `rmse_rel_reference` and `flip` over three environments, and
    the same by environment. An earlier export is replaced. UsageError for unknown targets, OutputError for the folder.
    """
    unknown = [name for name in names if name not in (*NAMES, AUTO)]
    if unknown or not names or (AUTO in names and len(names) > 1):
        raise UsageError(f"unknown target {' '.join(unknown)!r}; known are {', '.join(NAMES)}, or {AUTO} alone")
    settings = settings or Settings()
    if not (error >= 0.0 and np.isfinite(error)):
        raise UsageError(f"an error of {error} is not a number from 0 upwards")
    subject = yield from part(subject_of(material, stack), 0.0, 0.2)
    wanted = yield from part(references(material), 0.2, 0.3)
    usable, remark = _usable_stack(subject)
    record: dict[str, Any] = {
        "lightarc_export": 1,
        "software": {"lightarc": engine.__version__},
        "material": (yield from _own_errors(subject, wanted, usable)),
        "targets": [],
    }
    written = _Written(subject, settings, wanted, usable, remark, {})
    if AUTO in names:
        choosing = part(written.smallest(error), 0.4, 1.0)
        record["auto"], made = yield from choosing
    else:
        made = yield from part(written.all(names), 0.4, 1.0)
    with atomic_folder(folder, RECORD) as place:
        for target, contents, entry in made:
            for name, content in contents.files.items():
                path = place / target / name
                make_folder(path.parent)
                write_bytes(path, content)
            record["targets"].append(entry)
        write_bytes(place / RECORD, (json.dumps(record, indent=2, allow_nan=False) + "\n").encode())
    return {**record, "folder": str(Path(folder))}


#: A target, its files, and its entry in the record.
Made = tuple[str, Contents, dict[str, Any]]


@dataclass(frozen=True, eq=False)
class _Written:
    """The targets of one subject, each with its errors; those of equal representations are measured once."""

    subject: Subject
    settings: Settings
    wanted: dict[str, Floats]
    stack: ImageStack | None
    remark: tuple[str, ...]
    measured: dict[Shown | None, dict[str, Any]]

    def all(self, names: Sequence[str]) -> Steps[list[Made]]:
        """The targets `names`, in the order of `TARGETS`."""
        chosen = [target for target in TARGETS if target.name in names]
        made = []
        for index, target in enumerate(chosen):
            made.append((yield from part(self.one(target), index / len(chosen), (index + 1) / len(chosen))))
        return made

    def one(self, target: Target) -> Steps[Made]:
        subject, settings = self.subject, self.settings
        shown = target.shown(subject, settings)
        if shown not in self.measured:
            self.measured[shown] = yield from part(_errors(shown, self.wanted, subject, self.stack), 0.0, 0.5)
        errors = self.measured[shown]
        contents = yield from part(target.contents(subject, settings, statement(errors)), 0.5, 1.0)
        entry = {
            "target": target.name,
            "files": [f"{target.name}/{name}" for name in contents.files],
            "bytes": sum(map(len, contents.files.values())),
            "white_radiance": subject.white,
            "bytes_per_texel": contents.bytes_per_texel,
            **errors,
            "warnings": [*contents.warnings, *self.remark],
            **contents.record,
        }
        return target.name, contents, entry

    def smallest(self, error: float) -> Steps[tuple[dict[str, Any], list[Made]]]:
        """The candidate of fewest bytes whose error is within the budget; where none is, that of least error, said."""
        made = yield from self.all([name for name in CANDIDATES if name != "rti" or rti.has_sides(self.subject)])
        within = [each for each in made if each[2]["rmse_rel_reference"] <= error]
        candidates = within or [min(made, key=lambda each: float(each[2]["rmse_rel_reference"]))]
        best = min(candidates, key=lambda each: int(each[2]["bytes"]))
        rows = [{key: each[2][key] for key in ("target", "bytes", "rmse_rel_reference", "flip")} for each in made]
        if not within:
            best[2]["warnings"].append(f"no representation keeps an error of {percent(error)}; this one has the least")
        return {"error": error, "chosen": best[0], "candidates": rows}, [best]


def statement(errors: dict[str, Any]) -> str:
    """The errors of a representation as a sentence in plain ASCII, for files and pages."""
    if errors["rmse_rel_reference"] is None:
        return "It shows no picture of the surface."
    under = ", ".join(errors["by_environment"])
    shown = f"relative RMSE {percent(errors['rmse_rel_reference'], 3)}, FLIP {number(errors['flip'])}"
    words = f"Error of leaving the shading map, against the material under {under}: {shown}"
    if errors["rmse_rel"] is not None:
        words += f"; against the photographs: relative RMSE {percent(errors['rmse_rel'], 3)}"
    return f"{words}."


def _usable_stack(subject: Subject) -> tuple[ImageStack | None, tuple[str, ...]]:
    """The photographs, where they show the texels of the material, and a sentence where they do not."""
    stack = subject.stack
    if stack is None:
        return None, ()
    if stack.radiance.shape[1:3] != subject.maps.size:
        return None, ("the material was cut to a tile, so that it is not compared with the photographs",)
    return stack, ()


def _own_errors(subject: Subject, wanted: dict[str, Floats], stack: ImageStack | None) -> Steps[dict[str, Any]]:
    """Errors of the material before it leaves: of its photographs, and of its power law against its slices."""
    material, found = subject.material, {"name": subject.material.name, "brdf": subject.material.brdf}
    figures: dict[str, Any] = {"rmse_rel": None, "rmse_rel_power_law": None}
    if stack is not None:
        figures["rmse_rel"] = yield from part(photograph_error(material_shown(material), stack), 0.3, 0.35)
    if material.power_law is not None and material.shading_map is not None:
        measured = yield from part(loss(material_shown(material, "power-law"), wanted, subject.maps.size), 0.35, 0.4)
        figures["rmse_rel_power_law"] = measured.mean_rmse_rel
    return {**found, **figures}


def _errors(
    shown: Shown | None, wanted: dict[str, Floats], subject: Subject, stack: ImageStack | None
) -> Steps[dict[str, Any]]:
    """The errors of a representation, None for what does not apply."""
    figures: dict[str, Any] = {"rmse_rel": None, "rmse_rel_reference": None, "flip": None, "by_environment": {}}
    if shown is None:
        return figures
    yield Step(0.0, "measuring the error")
    if stack is not None:
        figures["rmse_rel"] = yield from part(photograph_error(shown, stack), 0.0, 0.4)
    measured = yield from part(loss(shown, wanted, subject.maps.size), 0.4, 1.0)
    return {
        **figures,
        "rmse_rel_reference": measured.mean_rmse_rel,
        "flip": measured.mean_flip,
        "by_environment": {
            name: {"rmse_rel": measured.rmse_rel[name], "flip": measured.flip[name]} for name in measured.rmse_rel
        },
    }
