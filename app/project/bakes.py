"""Bakes of the View workspace, kept beside the project under the hash of what they were made from.

The name of a bake has two parts: of its model, ground, BRDF and settings, and of what the plan of the scene decided.
So a bake that another plan led to, because the machine or the size of the window was another, is found as well, and
drawn until the wanted one is there. A bake that was interrupted lies beside its place until it goes on, which it does
only in the version that began it (`engine.transport.baking.file`).
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import astuple, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.document.bake_request import Estimate, Made, Wanted, bake, estimate, setting_for
from app.document.variation import images_of
from app.project.made import find_note, keep_newest, key_of, note, use
from engine.core.errors import FileError, InputError
from engine.core.steps import Step, Steps, part
from engine.geometry.mesh import Mesh
from engine.storage.atomic import make_folder
from engine.storage.resumable import discard_unfinished
from engine.transport.baking.file import open_transport

if TYPE_CHECKING:
    from engine.light.environment import EnvironmentMap

log = logging.getLogger(__name__)

#: Bakes that a data folder keeps, and their bytes together.
KEPT, MAX_BYTES = 100, 8 * 2**30

#: Interrupted bakes that it keeps.
UNFINISHED = 3

KIND = "bake"

#: Files of another format have other names: raised with each change after which equal settings bake something else.
FORMAT = 1

_SUFFIX = ".transport"


def place_of(wanted: Wanted, folder: Path) -> Path:
    """Place of the bake that is `wanted`.

    TypeError for a BRDF that is not a value of the document, OSError where an image that it follows cannot be read.
    """
    return folder / f"{_subject(wanted)}{key_of(wanted.decided)[:12]}{_SUFFIX}"


def _subject(wanted: Wanted) -> str:
    """The part of the name that does not depend on a plan."""
    choices, ground = wanted.choices, wanted.ground
    settings = sorted(vars(choices.settings).items())
    of = (FORMAT, choices.method.name, _key_of_mesh(wanted.mesh), astuple(ground) if ground is not None else None)
    parts = [wanted.parts] if wanted.parts else []
    return f"{KIND}-{key_of(of, wanted.brdf, settings, *_vary(wanted), *parts)[:24]}-"


def _vary(wanted: Wanted) -> list[Any]:
    """All that varies over the model, and the content of the files that it follows; nothing where nothing does."""
    files = images_of(wanted.variations)
    numbers: dict[Any, Any] = {path: f"file {number}" for number, path in enumerate(files)}
    said = ([type(each).__name__, *vars(each).values()] for each in wanted.variations)
    return [*([numbers.get(part, part) for part in parts] for parts in said), *files]


@lru_cache(maxsize=4)
def _key_of_mesh(mesh: Mesh) -> str:
    """Its arrays are hashed once: a large model takes longer than a step of a slider."""
    return key_of(mesh)


def bake_or_cost(wanted: Wanted, folders: Sequence[Path]) -> Steps[tuple[Made | None, Estimate | None]]:
    """The bake that is `wanted`, if one of `folders` has it; or the cost of one, and one of another plan, if any."""
    yield Step(0.0, "looking for a bake")
    found = [made for folder in folders if (made := keep(wanted, folder)) is not None]
    whole = next((made for made in found if made.wanted.is_as(wanted)), None)
    if whole is not None:
        return whole, None
    return found[0] if found else None, (yield from part(estimate(wanted), 0.1, 1.0))


def keep(wanted: Wanted, folder: Path) -> Made | None:
    """The bake of `folder` that is `wanted`, or the last one that differs from it only by the plan; else None.

    One that is damaged is left out, and the log names it.
    """
    try:
        place, subject = place_of(wanted, folder), _subject(wanted)
    except (TypeError, OSError) as error:
        log.info("this bake is not looked for: %s", error)
        return None
    others = sorted(folder.glob(f"{subject}*{_SUFFIX}"), key=lambda each: each.stat().st_mtime, reverse=True)
    for each in ([place] if place in others else []) + [other for other in others if other != place]:
        noted = find_note(each)
        as_made = wanted if each == place else _as_noted(wanted, noted.made_with if noted is not None else {})
        if as_made is None or place_of(as_made, folder) != each:
            continue
        try:
            made = _open(each, as_made, noted.seconds if noted is not None else None)
        except InputError as error:
            log.warning("%s", error)
            continue
        use(each)
        return made
    return None


def _open(place: Path, wanted: Wanted, seconds: float | None) -> Made:
    file = open_transport(place)
    return Made(wanted, wanted.choices.method.baking.transport_of(file), seconds, file.size_bytes, file.check)


def bake_and_keep(
    estimate: Estimate, folder: Path, own: Sequence[EnvironmentMap] = (), *, is_checked: bool = True
) -> Steps[Made]:
    """Bake into `folder`, checked under the environments `own` as well; an equal bake that was interrupted goes on.

    OutputError where that cannot be written.
    """
    wanted = estimate.wanted
    make_folder(folder)
    try:
        place = place_of(wanted, folder)
    except (TypeError, OSError):
        place = folder / f"{KIND}-of-{wanted.choices.method.name}{_SUFFIX}"  # nobody finds it again
    made = yield from bake(place, estimate, own, is_checked=is_checked)
    note(place, KIND, made.bake_s or 0.0, encode_note(wanted))
    tidy(folder)
    return made


def tidy(folder: Path) -> None:
    """Keep no more than there is room for; bakes that another process goes on with stay."""
    keep_newest(folder, f"{KIND}-*{_SUFFIX}", KEPT, MAX_BYTES)
    begun = sorted(folder.glob(f".{KIND}-*.unfinished"), key=lambda each: each.stat().st_mtime)
    for each in begun[:-UNFINISHED]:
        try:
            discard_unfinished(each.with_name(each.name.removeprefix(".").removesuffix(".unfinished")))
        except FileError as error:
            log.info("an interrupted bake stays: %s", error)


def is_begun(folder: Path) -> bool:
    """True if a bake that was interrupted can go on in `folder`."""
    return any(folder.glob(f".{KIND}-*.unfinished"))


def encode_note(wanted: Wanted) -> dict[str, Any]:
    """The settings of a bake and what its plan decided, as JSON can say it."""
    effects = wanted.plan.effects if wanted.plan is not None else None
    decided = None if effects is None else [[each.effect, each.decision, each.estimated_error_rel] for each in effects]
    return {"method": wanted.choices.method.name, "settings": wanted.choices.values, "effects": decided}


def _as_noted(wanted: Wanted, made_with: Mapping[str, Any]) -> Wanted | None:
    """`wanted`, with the decisions of the plan that a bake was made with; None where nobody noted them."""
    try:
        return with_effects(wanted, made_with["effects"])
    except (KeyError, TypeError, ValueError):
        return None


def with_effects(wanted: Wanted, effects: Any) -> Wanted:
    """`wanted`, with a plan that decided so of these effects. TypeError or ValueError where they are none."""
    if effects is None:
        return replace(wanted, plan=None)
    from engine.planning.ceilings import usual
    from engine.planning.costs.cost_model import Cost
    from engine.planning.plan import Effect, EffectsPlan

    rows = tuple(Effect(str(name), str(decision), "", float(error), 0.0, 0) for name, decision, error in effects)
    nothing = Cost(0.0, 0.0, 0.0, 0, 0)
    setting = setting_for(wanted.choices)
    return replace(wanted, plan=EffectsPlan(rows, setting, 0.0, (0.0, 0.0), nothing, True, 0.0, 1.0, usual()))
