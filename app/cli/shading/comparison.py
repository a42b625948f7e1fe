"""`lightarc shade --compare`: representations of a capture beside each other: table, JSON, plot, worst places."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.results import software
from engine.core.errors import InputError
from engine.core.figure_text import number, time_text
from engine.core.steps import Step, drain, part
from engine.figures.worst_places import select_seen_places, worst_places, worst_sheet
from engine.images.encode import encode_png
from engine.shading.compare import Candidate, compare
from engine.shading.fidelity import FEWEST
from engine.shading.shading_map import include
from engine.storage.atomic import atomic_folder, write_bytes, write_json
from engine.surface.relight import errors, predicting

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.capture.stack import ImageStack

#: Bytes of maps in 8 bits: two of the normal, three of colour, and of metallic-roughness roughness, metallic and f0;
#: and products of a light: n·l and the colour, or a microfacet model, which has roots and quotients besides.
SURFACES: dict[str, tuple[int, int | None]] = {"pbr-maps": (8, None), "lambertian": (5, 6)}

#: Stems of the files of a comparison.
STEM = "comparison"


def run(arguments: argparse.Namespace, stack: ImageStack, show: Callable[[Step], None]) -> dict[str, Any]:
    """Compare, write and tell."""
    from engine.figures.plot import Dot, save, scatter_front

    used = include(stack, arguments.exclude)
    where = stack.folder or "the stack"
    if stack.azimuth is None:
        raise InputError(where, "its lamps have no azimuth", "Import it with a light list (.lp) or a capture.toml")
    if len(used) < FEWEST:
        raise InputError(where, f"{len(used)} photographs are too few to leave one out", f"Import {FEWEST} or more")
    found = drain(part(compare(stack, used, arguments.slices, arguments.bytes_per_texel), 0.0, 0.4), show)
    found = sorted([*found, *_surfaces(stack, used, show)], key=lambda each: each.leave_one_out)
    best = _front(found)
    dots = [
        Dot(each.bytes_per_texel, each.leave_one_out, _family(each.name), each.name, 0.0, each.name in best)
        for each in found
    ]
    words = ("Bytes of a texel", "Leave-one-out error / 8-bit sRGB codes")
    note = f"{len(used)} photographs of {stack.radiance.shape[2]} × {stack.radiance.shape[1]} texels."
    plot = scatter_front(dots, *words, log_y=False, note=note)
    own = next(each for each in found if each.name.startswith("planes-"))
    places = drain(part(worst_places(stack, used, own.predict), 0.9, 0.95), show)
    seen = drain(part(select_seen_places(stack, used, found, places), 0.95, 1.0), show)
    sheet = encode_png(worst_sheet(seen, own.name), software=software("shade"))
    record = {
        "photographs": len(used),
        "candidates": [_record(each) for each in found],
        "worst_of": own.name,
        "worst": [each.record for each in seen],
        "warnings": stack.health.without(set(stack.sources) - {stack.sources[at] for at in used}).warnings,
    }
    with atomic_folder(Path(arguments.output), f"{STEM}.json") as folder:
        save(plot, folder / f"{STEM}.png")
        write_bytes(folder / f"{STEM}-worst.png", sheet)
        write_json(folder / f"{STEM}.json", {"lightarc_comparison": 1, **record})
    return {**record, "files": [f"{STEM}.json", f"{STEM}.png", f"{STEM}.svg", f"{STEM}-worst.png"]}


def report(result: dict[str, Any]) -> str:
    units = "errors in 8-bit levels of sRGB, products of a fragment and a light"
    lines = [f"{'':16} {'held out':>9} {'training':>9} {'bytes':>6} {'products':>8} {'fit':>7}   {units}"]
    for each in result["candidates"]:
        errors = f"{number(each['leave_one_out_rmse_srgb8'], 3):>9} {number(each['in_sample_rmse_srgb8'], 3):>9}"
        seconds = time_text(each["fit_s"])
        products = "–" if each["products_per_fragment"] is None else each["products_per_fragment"]
        costs = f"{each['bytes_per_texel']:6} {products:>8} {seconds:>7}"
        lines.append(f"{each['representation']:16} {errors} {costs}")
    lines.append(f"where {result['worst_of']} is worst, and what the others show there: {STEM}-worst.png")
    return "\n".join(lines)


def _surfaces(stack: ImageStack, used: NDArray[np.int64], show: Callable[[Step], None]) -> list[Candidate]:
    """PBR maps and diffuse photometric stereo, where the lamps tell a slope and are enough to leave one out."""
    from engine.surface.lamps import FEWEST, apart

    if len(used) < FEWEST + 2 or apart(stack, used) < FEWEST:
        return []
    rows = []
    for place, (name, (byte_count, products)) in enumerate(SURFACES.items()):
        first, plain = 0.4 + 0.25 * place, name == "lambertian"
        found = drain(part(errors(stack, used, lambertian=plain), first, first + 0.2), show)
        predict = drain(part(predicting(stack, used, lambertian=plain), first + 0.2, first + 0.25), show)
        rows.append(Candidate(name, found.left_out, found.in_sample, byte_count, products, found.fit_s, predict))
    return rows


def _front(found: list[Candidate]) -> set[str]:
    """The names of those than which none is better in error and bytes."""
    return {
        each.name
        for each in found
        if not any(
            other.leave_one_out < each.leave_one_out and other.bytes_per_texel <= each.bytes_per_texel
            for other in found
        )
    }


def _family(name: str) -> str:
    """Colour of a candidate in the plot, by its kind."""
    if name in SURFACES:
        return "surface"
    return {"planes": "planes", "shading": "shading map"}.get(name.partition("-")[0], "rivals")


def _record(each: Candidate) -> dict[str, Any]:
    return {
        "representation": each.name,
        "leave_one_out_rmse_srgb8": each.leave_one_out,
        "in_sample_rmse_srgb8": each.in_sample,
        "bytes_per_texel": each.bytes_per_texel,
        "products_per_fragment": each.products,
        "fit_s": each.fit_s,
    }
