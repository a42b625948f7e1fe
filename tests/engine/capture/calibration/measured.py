"""What the program makes of a generated capture: its errors, beside what it states about them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.stack import ImageStack
from engine.core.steps import drain
from engine.shading.shading_map import include
from engine.surface.recover import Surface, recover
from tests.engine.capture.calibration.generated import Rendered, write

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Measured:
    """Angles between recovered and true normals, those that the program states (one deviation), and its stack."""

    error_deg: Array
    sigma_deg: Array
    stack: ImageStack
    surface: Surface

    @property
    def covered(self) -> float:
        """Share of texels whose error is within the 95 % interval: 1.96 deviations of an angle of two slopes."""
        return float((self.error_deg <= 1.73 * self.sigma_deg).mean())


def measure(rendered: Rendered, folder: Path, settings: ImportSettings | None = None) -> Measured:
    """Import a capture with no option, recover its surface, and compare the normals with the truth."""
    sources = find([write(rendered, folder / "photographs")])
    stack = drain(import_stack(sources, settings or ImportSettings(), folder / "stack"))
    surface = drain(recover(stack, include(stack, ()), left_out=False))
    truth = aligned_truth(rendered, stack)
    cosine = np.clip((surface.maps.normal * truth).sum(axis=-1), -1.0, 1.0)
    error = np.degrees(np.arccos(cosine))
    assert surface.maps.uncertainty is not None
    return Measured(error, np.degrees(surface.maps.uncertainty.normal), stack, surface)


def measure_motion(rendered: Rendered, stack: ImageStack) -> tuple[Array, Array]:
    """(N,) true error of the alignment of each photograph in pixels, and the residual that is stated (0 for none)."""
    order = [rendered.names.index(name) for name in stack.sources]
    reference = stack.provenance.get("aligned_to") or rendered.names[order[0]]
    truth = rendered.shifts[order] - rendered.shifts[rendered.names.index(reference)]
    matrices = np.array([each["alignment_matrix"] for each in stack.provenance["photographs"]]).reshape(-1, 3, 3)
    middle = np.array([0.5 * rendered.capture.width, 0.5 * rendered.capture.height, 1.0])
    found = (matrices @ middle)[:, :2] - middle[:2]
    residual = [each.alignment_residual_px or 0.0 for each in stack.quality]
    return np.hypot(*(found - truth).T), np.array(residual)


def aligned_truth(rendered: Rendered, stack: ImageStack) -> Array:
    """(h, w, 3) true normals at the texels of the stack, which shows the sample as its reference photograph does."""
    from scipy import ndimage

    left, top = stack.provenance["crop_px"][:2] if stack.provenance.get("crop_px") else (0, 0)
    reference = stack.provenance.get("aligned_to")
    across, down = rendered.shifts[rendered.names.index(reference)] if reference else (0.0, 0.0)
    rows, columns = np.mgrid[: stack.radiance.shape[1], : stack.radiance.shape[2]].astype(float)
    places = [rows + top - down, columns + left - across]
    found = np.stack(
        [ndimage.map_coordinates(rendered.normals[..., axis], places, order=3, mode="nearest") for axis in range(3)], -1
    )
    return np.asarray(found / np.linalg.norm(found, axis=-1, keepdims=True))
