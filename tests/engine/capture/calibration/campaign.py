"""Figures of the calibration on generated captures, printed: one line for each capture, then those of all.

    python -m tests.engine.capture.calibration.campaign --first 1000 --count 100

imports each capture without an option, recovers its surface and compares it with the truth; checks its list of lights
in a wrong form and in the right one; and compares the motion of the camera that was found with the true one.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from engine.capture.calibration.light_list import check_list
from engine.capture.import_plan import ImportSettings
from tests.engine.capture.calibration.generated import LISTS, Capture, draw, join_names, render
from tests.engine.capture.calibration.measured import measure, measure_motion

#: What is named for each fault of a list.
NAMED = {
    "right": "listed",
    "shifted": "shifted",
    "reversed": "reversed",
    "mirrored x": "mirrored-x",
    "mirrored y": "mirrored-y",
    "swapped": "swapped-xy",
    "turned": "turned",
}


@dataclass(frozen=True)
class Figures:
    """Figures of one capture.

    Attributes
    ----------
    median_deg, mean_deg : angle between recovered and true normals.
    sigma_deg : median standard deviation that is stated.
    covered : share of texels whose normal lies within the interval of 95 %.
    is_warned : whether the program says that the normals are not to be trusted.
    motion_px, residual_px : (N,) true error of the alignment of each photograph, and the one that is stated.
    wrong, named : what is wrong with the list that was tried, and the form that was named.
    false_alarm : form named for the right list, 'listed' for none.
    """

    capture: Capture
    median_deg: float
    mean_deg: float
    sigma_deg: float
    covered: float
    is_warned: bool
    motion_px: tuple[float, ...]
    residual_px: tuple[float, ...]
    wrong: str
    named: str
    false_alarm: str
    terms: tuple[str, ...]

    @property
    def is_named(self) -> bool:
        return self.named.startswith(NAMED[self.wrong])

    @property
    def is_untold(self) -> bool:
        """Whether it was said that the photographs do not tell the list from one that is turned."""
        return self.named == "turned, untold"

    def line(self) -> str:
        """One line for a table."""
        made = self.capture
        motion = (
            f"{max(self.motion_px):5.2f}/{max(self.residual_px):4.2f}"
            if made.motion_px or any(self.motion_px)
            else "    -     "
        )
        faults = f"{made.distance:4.1f} {made.gains[0]:.1f} {made.room:.2f} {made.motion_px:.2f}"
        what = f"{made.seed:5d} {made.surface:6s} {made.material:11s} {made.lamps:2d} {faults} {made.file_format:5s}"
        error = f"{self.median_deg:6.2f} {self.mean_deg:6.2f} {self.sigma_deg:6.2f} {100.0 * self.covered:5.1f}"
        warned = "W" if self.is_warned else " "
        terms = ",".join(term[:3] for term in self.terms)
        alarm = "" if self.false_alarm == "listed" else f" FALSE {self.false_alarm}"
        named = "" if self.is_named else f" {self.wrong}: {self.named}"
        return f"{what} {error} {warned} {motion} {terms:15s}{named}{alarm}"


def measure_capture(capture: Capture, folder: Path) -> Figures:
    """The figures of one capture, imported without an option into `folder`, which is removed."""
    rendered = render(capture)
    measured = measure(rendered, folder, ImportSettings())
    motion, residual = measure_motion(rendered, measured.stack)
    photographs = list(rendered.photographs)
    clipped = [(each >= 0.99).any(axis=-1).astype(np.float32) for each in photographs]
    wrong = LISTS[1 + capture.seed % (len(LISTS) - 1)]
    listed = join_names(rendered.directions, wrong, np.random.default_rng([capture.seed, 3]))
    checked = check_list(photographs, clipped, listed)
    named = "turned, untold" if wrong == "turned" and checked.doubt else checked.form
    false = check_list(photographs, clipped, rendered.directions).form
    calibration = measured.stack.provenance["calibration"]
    shutil.rmtree(folder)
    return Figures(
        capture,
        float(np.median(measured.error_deg)),
        float(measured.error_deg.mean()),
        float(np.median(measured.sigma_deg)),
        measured.covered,
        bool(measured.surface.health.warnings),
        tuple(motion.tolist()),
        tuple(residual.tolist()),
        wrong,
        named,
        false,
        tuple(term["name"] for term in calibration if term["accepted"]),
    )


def summarise(found: Sequence[Figures]) -> str:
    """The figures of all captures, as text."""
    medians = np.array([each.median_deg for each in found])
    means = np.array([each.mean_deg for each in found])
    covered = np.array([each.covered for each in found])
    stated = np.array([each.sigma_deg for each in found])
    quiet = np.array([not each.is_warned for each in found])
    moved = [each for each in found if each.capture.motion_px]
    lines = [
        f"{len(found)} captures, seeds {found[0].capture.seed} to {found[-1].capture.seed}",
        f"median error of normals: {_spread(medians)}; mean error {_spread(means)}",
        f"captures whose median error is at most 1° {_share(medians <= 1.0)}, 2° {_share(medians <= 2.0)}",
        f"95 % interval covers 95 % of texels in {_share(covered >= 0.95)} of captures"
        f" (90 %: {_share(covered >= 0.9)}; mean coverage {covered.mean():.3f})",
        f"stated deviation over the true error, of the medians: {np.median(stated / np.maximum(medians, 1e-3)):.2f}",
        f"median error above 2° without a warning: {int((quiet & (medians > 2.0)).sum())}; "
        f"with a warning, below 1°: {int((~quiet & (medians < 1.0)).sum())}",
        f"wrong lists named {sum(each.is_named and not each.is_untold for each in found)}, "
        f"said to be perhaps turned {sum(each.is_untold for each in found)}, "
        f"right lists doubted {sum(each.false_alarm != 'listed' for each in found)}",
    ]
    if moved:
        off = np.concatenate([each.motion_px for each in moved])
        residual = np.concatenate([each.residual_px for each in moved])
        lines.append(
            f"camera that moved ({len(moved)} captures): error median {np.median(off):.3f} px, "
            f"worst {off.max():.2f} px; "
            f"residual below half of the error in {int((residual < 0.5 * off).sum())} of {len(off)} photographs"
        )
    still = [max(each.motion_px) for each in found if not each.capture.motion_px]
    if still:
        lines.append(f"camera that stood still: worst shift {max(still):.2f} px")
    return "\n".join(lines)


def _spread(values: np.ndarray) -> str:
    return f"median {np.median(values):.2f}°, 90 % {np.quantile(values, 0.9):.2f}°, worst {values.max():.2f}°"


def _share(which: np.ndarray) -> str:
    return f"{100.0 * which.mean():.0f} %"


def run(seeds: Iterable[int], folder: Path) -> list[Figures]:
    """The figures of the captures drawn by `seeds`, printed as they come."""
    found = []
    for seed in seeds:
        found.append(measure_capture(draw(seed), folder / str(seed)))
        print(found[-1].line(), flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=1000, help="first seed")
    parser.add_argument("--count", type=int, default=100, help="number of captures")
    parser.add_argument("--seeds", type=int, nargs="*", help="these seeds instead")
    chosen = parser.parse_args()
    seeds = chosen.seeds or range(chosen.first, chosen.first + chosen.count)
    with tempfile.TemporaryDirectory() as folder:
        print(summarise(run(seeds, Path(folder))))


if __name__ == "__main__":
    main()
