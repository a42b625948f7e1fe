"""The material of a project for other programs: what each target would lose, and the files.

A material is made ready once (`engine.exchange.export.Departure`), which takes most of the time: with photographs of a
dome the surface is measured, unless the project has its maps already. The window keeps it for as long as material and
photographs stay the same; errors are kept beside the project (`app.project.losses`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.commands.making import readable_stack
from app.commands.surface import material_with_surface, needs_surface, surface_of, with_surface
from app.document.document import Project
from app.project.losses import OWN, find_kept, keep, keys_of
from engine.core.steps import Step, Steps, part, relay, without_partials
from engine.scene.material import Material

if TYPE_CHECKING:
    from engine.exchange.export import Departure, Offer
    from engine.exchange.subject import Settings

#: Seconds on two cores, measured: to find the surface for a texel in a photograph, to find the nearest maps for a
#: texel, and to measure and pack a target, whatever its size and for each texel.
SURFACE_S, NEAREST_S, TARGET_S, TEXEL_S = 7e-7, 1.0e-5, 1.5, 4e-6


@dataclass(frozen=True, eq=False)
class Sent:
    """An export that was written: its folder, the bytes of its files by name, and the record."""

    folder: Path
    files: dict[str, int]
    record: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Known:
    """Offers that were measured before, by target and with the material itself as `OWN`, and the keys of all."""

    offers: Mapping[str, Offer] = field(default_factory=dict)
    keys: Mapping[str, str] = field(default_factory=dict)


def find_measured_before(project: Project, names: Sequence[str], folders: Sequence[Path]) -> Steps[Known]:
    """The targets `names` and the material itself, as far as they were measured before; nothing is measured.

    A target that cannot hold the material is known to be none.
    """
    keys = yield from keys_of(project, (OWN, *names))
    from engine.exchange.export import Offer, cannot_hold

    found = find_kept(keys, folders)
    for name in names:
        if why_not := cannot_hold(name, project.material, project.stack):
            found[name] = Offer(name, {}, None, f"{why_not[:1].upper()}{why_not[1:]}.")
    return Known(found, keys)


def seconds_to_measure(project: Project, count: int, *, is_ready: bool) -> float:
    """Estimated seconds to measure `count` targets, and before that to make the material ready unless it `is_ready`."""
    if not project.has_map or not count:
        return 0.0
    height, width = project.material.size
    seconds = count * (TARGET_S + TEXEL_S * height * width)
    if is_ready or material_with_surface(project).surface is not None or project.material.pbr is not None:
        return seconds
    stack = project.stack
    if stack is not None and needs_surface(project):
        return seconds + SURFACE_S * height * width * (len(stack.sources) - len(project.excluded))
    return seconds + NEAREST_S * height * width


def prepare_export(project: Project, leaving: Departure | None, known: Known) -> Steps[Departure]:
    """`leaving` where there is one, or else the material of `project`.

    The surface is the `partial` of a step where it had to be measured, and what is ready that of another.
    """
    yield Step(0.0, "reading the material")
    if leaving is None:
        from engine.exchange.export import departure

        material = material_with_surface(project)
        if needs_surface(project):
            surface = yield from part(without_partials(surface_of(project)), 0.0, 0.7)
            yield Step(0.7, "the surface is measured", surface)
            material = with_surface(material, surface)
        stack = yield from readable_stack(project)
        making = departure(material, stack, own_errors(material, known))
        leaving = yield from part(without_partials(making), 0.7, 1.0)
    yield Step(1.0, "comparing", leaving)
    return leaving


def own_errors(material: Material, known: Known) -> dict[str, Any] | None:
    """The errors of the material itself, as the record of an export states them; None where nobody measured them."""
    own = known.offers.get(OWN)
    if own is None:
        return None
    figures = {name: own.entry[name] for name in ("brdf_fit_rmse_rel", "rmse_rel", "rmse_rel_power_law")}
    return {"name": material.name, "brdf": material.brdf, **figures}


def find_known_entries(known: Known) -> dict[str, dict[str, Any]]:
    """The entries of targets that were measured, by target."""
    return {name: offer.entry for name, offer in known.offers.items() if not offer.why_not and name != OWN}


def own_offer(leaving: Departure) -> Offer:
    """The material itself as a target that loses nothing: its card has a ball and its error against photographs."""
    from engine.exchange.export import Offer

    nothing = {"rmse_rel_reference": 0.0, "flip": 0.0, "bytes": None, "bytes_per_texel": None}
    return Offer(OWN, {**leaving.own, **nothing}, leaving.sphere())


def offer(
    project: Project, leaving: Departure | None, known: Known, names: Sequence[str], folder: Path
) -> Steps[list[Offer]]:
    """Measure the targets `names`, and keep what was found in `folder`.

    A surface that had to be measured, the material that is ready, the material itself and each target are the `partial`
    of a step once.
    """
    known = yield from _look_up(project, known, names, folder)
    for name in names:
        if name in known.offers:
            yield Step(0.0, "measured before", known.offers[name])
    names = [name for name in names if name not in known.offers]
    if not names:
        return list(known.offers.values())
    leaving = yield from part(prepare_export(project, leaving, known), 0.0, 0.4)
    from engine.exchange.export import offers

    known = _select_these_photographs(known, project, leaving)
    if OWN not in known.offers:
        yield _keep(Step(0.4, "comparing", own_offer(leaving)), known, folder)
    measuring = relay(offers(leaving, project.exporting.settings, names), lambda step: _keep(step, known, folder))
    return (yield from part(measuring, 0.4, 1.0))


def _look_up(project: Project, known: Known, names: Sequence[str], folder: Path) -> Steps[Known]:
    """`known` with what was measured before, where nobody has looked for that yet."""
    if known.keys:
        return known
    before = yield from without_partials(find_measured_before(project, names, (folder,)))
    return Known({**before.offers, **known.offers}, before.keys)


def _select_these_photographs(known: Known, project: Project, leaving: Departure) -> Known:
    """`known` without keys where the photographs are not at hand: what is measured without them is not kept."""
    return known if leaving.subject.stack is project.stack else Known(known.offers)


def _keep(step: Step, known: Known, folder: Path) -> Step:
    """`step`, whose offer is written beside the project."""
    offer = step.partial
    if offer is not None and offer.target in known.keys:
        keep(known.keys[offer.target], offer, folder)
    return step


def send(
    project: Project, leaving: Departure | None, known: Known, names: Sequence[str], place: Path, folder: Path
) -> Steps[Sent]:
    """Write the targets `names` into `place`; OutputError where that is something else, or cannot be written.

    Targets that are not `known` are measured, since their files state their errors, and kept in `folder`; what is found
    on the way is the `partial` of a step, as that of `offer`.
    """
    known = yield from _look_up(project, known, names, folder)
    leaving = yield from part(prepare_export(project, leaving, known), 0.0, 0.4)
    from engine.exchange.export import write

    if project.exporting.repeats > 1:
        leaving, settings = yield from part(without_partials(_enlarge(project, leaving)), 0.4, 0.6)
        record = yield from part(without_partials(write(place, leaving, names, settings)), 0.6, 1.0)
        return _describe_sent(place, record)
    known = _select_these_photographs(known, project, leaving)
    if OWN not in known.offers:
        yield _keep(Step(0.4, "writing", own_offer(leaving)), known, folder)
    writing = write(place, leaving, names, project.exporting.settings, known=find_known_entries(known))
    record = yield from part(relay(writing, lambda step: _keep(step, known, folder)), 0.4, 1.0)
    return _describe_sent(place, record)


def _describe_sent(place: Path, record: dict[str, Any]) -> Sent:
    """The folder with the sizes of its files."""
    from engine.exchange.export import RECORD

    listed = [name for entry in record["targets"] for name in entry["files"]]
    return Sent(place, {name: (place / name).stat().st_size for name in (*listed, RECORD)}, record)


def _enlarge(project: Project, leaving: Departure) -> Steps[tuple[Departure, Settings]]:
    """A larger tile made ready, and the settings of its targets; UsageError for a material that does not repeat."""
    from engine.exchange.enlarge import enlarge, width_of_tile
    from engine.exchange.export import departure

    settings, repeats = project.exporting.settings, project.exporting.repeats
    material, stack = leaving.subject.material, leaving.subject.stack
    larger = yield from part(enlarge(material, repeats, stack), 0.0, 0.6)
    width_mm = width_of_tile(material, repeats, stack, settings.width_mm)
    return (yield from part(departure(larger), 0.6, 1.0)), replace(settings, width_mm=width_mm)


def smallest_of(found: Sequence[Offer], error: float) -> dict[str, Any]:
    """The choice that `--to auto` makes among what was measured (`engine.exchange.export.choice`)."""
    from engine.exchange.export import candidates, choice

    return choice([offer for offer in found if offer.target in candidates() and not offer.why_not], error)
