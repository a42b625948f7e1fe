"""Missing entries of tables are filled by one rule, and counted.

1. In a row over phi with any measured value, by a line between the nearest measured values on both sides.
2. A row with none takes the nearest row of theta that has some, the lower one of two equally near.
3. Where no row of theta has any, the nearest value of the outermost angle gives all of them, again the lower of two.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from engine.health import Finding, Health, Verdict

RULE = "filled along phi from the nearest measured values, empty rows from the nearest row"


def fill_holes(values: NDArray[np.floating], missing: NDArray[np.bool_]) -> None:
    """Fill `values` (G, R, P, 3) in place where `missing` (G, R, P); ValueError where nothing is measured."""
    from engine.brdf.table_kernel import fill_along_turns

    if missing.all():
        raise ValueError("no entry of the table is measured")
    groups, rows, turns = missing.shape
    fill_along_turns(values.reshape(groups * rows, turns, 3), missing.reshape(groups * rows, turns))
    measured_rows: NDArray[np.bool_] = np.any(~missing, axis=2)
    for group, known in enumerate(measured_rows):
        if known.any() and not known.all():
            values[group] = values[group][nearest(known)]
    measured_groups: NDArray[np.bool_] = np.any(measured_rows, axis=1)
    if not measured_groups.all():
        values[:] = values[nearest(measured_groups)]


def nearest(measured: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each place (N,) the nearest one that is measured, the lower of two."""
    known = np.flatnonzero(measured)
    places = np.arange(len(measured))
    above = np.clip(np.searchsorted(known, places), 0, len(known) - 1)
    below = np.maximum(above - 1, 0)
    lower = np.abs(places - known[below]) <= np.abs(known[above] - places)
    return np.where(lower, known[below], known[above])


def missing_health(missing: NDArray[np.bool_]) -> Health:
    """How many entries were filled, as a figure, and as a note for a person where there are any."""
    count = int(missing.sum())
    note = f"{count:,} of {missing.size:,} entries are missing; they are {RULE}."
    return Health(
        MappingProxyType({"samples": float(missing.size), "missing": float(count)}),
        (Finding(Verdict.NOTE, note),) if count else (),
    )
