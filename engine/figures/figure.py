"""A figure: rows of panels with their errors, plots beside them, and the settings that it is made with.

Errors are relative RMSE of linear radiance against the reference, over the pixels that both cover completely, with the
noise of the reference taken off and what is left of it stated (`engine.accuracy.compare.error_against`). The papers
show images; the figures under them are ours.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.accuracy.compare import ErrorEstimate, error_against
from engine.core.cached import cached_property
from engine.core.figure_text import percent_within
from engine.core.steps import Steps
from engine.figures.contact_sheet import Panel, Row, draw_sheet, panel_width
from engine.figures.plot import Curve
from engine.geometry.camera import Camera, frame
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import bust, grid_mesh
from engine.light.environment import EnvironmentMap
from engine.render.display import Display, display
from engine.render.reference import ReferenceImage, reference
from engine.scene.scene import Scene

#: Coverage from which a pixel is taken to be covered completely.
COVERED = 0.999

#: Images (height, width, 4) of linear radiance times coverage, and coverage.
Image = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Settings:
    """Settings of figures.

    Attributes
    ----------
    mesh, environment : the user's; None for what suits each figure.
    quick : few vertices, pixels and samples, to see that it works.
    """

    mesh: Mesh | None = None
    environment: EnvironmentMap | None = None
    quick: bool = False

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of an image."""
        return (40, 40) if self.quick else (360, 360)

    @property
    def samples(self) -> int:
        """Samples of each pixel of the reference."""
        return 16 if self.quick else 64

    @property
    def directions(self) -> int:
        """That transport towards a view is tabulated at for a fit of Gaussians."""
        return 48 if self.quick else 128

    @property
    def edge(self) -> int:
        """Edge of the cube maps that visibility is found for."""
        return 16 if self.quick else 64

    @property
    def warnings(self) -> tuple[str, ...]:
        """Doubts about the user's files."""
        mesh = () if self.mesh is None else self.mesh.health.warnings
        light = () if self.environment is None else self.environment.health.warnings
        return (*mesh, *light)

    @cached_property
    def model(self) -> Mesh:
        """The user's mesh, or the bust with as few vertices as a bake of some minutes allows."""
        return self.mesh if self.mesh is not None else coarse_bust(*((17, 25) if self.quick else (73, 109)))


@dataclass(frozen=True, eq=False)
class Shown:
    """One image of a figure.

    Attributes
    ----------
    panel : what it shows, in a few words. parameters : how it was made.
    error : against the next image of its row that has none, which is a reference.
    exposure_ev : stops by which it is shown brighter.
    variance : of a reference by Monte Carlo, (height, width, 3).
    """

    panel: str
    image: Image
    parameters: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    error: ErrorEstimate | None = None
    exposure_ev: float = 0.0
    variance: NDArray[np.float64] | None = None


@dataclass(frozen=True, eq=False)
class ShownRow:
    """Images side by side under a heading."""

    heading: str
    images: tuple[Shown, ...]


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure of a paper.

    Attributes
    ----------
    name : of the verb, as kautz-6.
    title, subtitle : what it shows, and on what.
    rows : its images.
    plots : by the name of their files, figures of `engine.figures.plot`.
    table : rows of equal keys, units in the keys, for a CSV beside the images; what the plots show.
    extra : rows of `engine.figures.contact_sheet` that are not images of a scene, above the others.
    """

    name: str
    title: str
    subtitle: str
    rows: tuple[ShownRow, ...] = ()
    plots: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    table: tuple[Mapping[str, Any], ...] = ()
    extra: tuple[Row, ...] = ()


def coarse_bust(rows: int, columns: int) -> Mesh:
    """The built-in bust with so many vertices."""
    positions, normals = bust(rows, columns)
    v, u = np.meshgrid(np.linspace(0.0, 1.0, rows), np.linspace(0.0, 1.0, columns), indexing="ij")
    return grid_mesh("blob", positions, normals, np.stack([u, v], -1))


def camera_of(mesh: Mesh, size: tuple[int, int]) -> Camera:
    return frame(mesh.positions, size[0] / size[1])


def reference_of(scene: Scene, settings: Settings) -> Steps[ReferenceImage]:
    """The reference of `scene`: direct light with shadows."""
    return (yield from reference(scene, settings.size, samples=settings.samples))


def error_of(image: Image, expected: ReferenceImage) -> ErrorEstimate:
    """Error of an image against the reference, over what both cover completely; 0 where that is nothing."""
    mask = (image[..., 3] >= COVERED) & (expected.image[..., 3] >= COVERED)
    if not mask.any():
        return ErrorEstimate(0.0, 0.0)
    return error_against(image, expected.image, 0.0 if expected.variance is None else expected.variance, mask)


def compare_with(
    panels: Sequence[tuple[str, Mapping[str, Any], Image]], expected: ReferenceImage, last: str
) -> tuple[Shown, ...]:
    """The `panels` (words, parameters, image) with their errors, and the reference after them under the words
    `last`."""
    stops = exposure_of(expected.image)
    shown = [Shown(words, image, parameters, error_of(image, expected), stops) for words, parameters, image in panels]
    return (*shown, Shown(last, expected.image, exposure_ev=stops, variance=expected.variance))


def error_curve(name: str, x: Sequence[float], images: Sequence[Shown]) -> Curve:
    """The errors of `images` over `x` in %, with their uncertainty; references among them are passed over."""
    errors = [shown.error for shown in images if shown.error is not None]
    values, spread = [100.0 * e.rmse_rel for e in errors], [100.0 * e.uncertainty for e in errors]
    return Curve(name, x, values, spread)


def exposure_of(image: Image) -> float:
    """Stops that make the brightest parts of the model just not clip on the display."""
    covered = image[image[..., 3] >= COVERED][:, :3]
    top = float(np.percentile(covered, 99.0)) if covered.size else 0.0
    return float(np.clip(np.log2(0.8 / top), -40.0, 40.0)) if top > 0.0 else 0.0


def sheet_of(figure: Figure) -> NDArray[np.uint8]:
    """(H, W, 3) the contact sheet of a figure."""
    rows = [Row(row.heading, tuple(_panel(row, shown) for shown in row.images), _aspect(row)) for row in figure.rows]
    return draw_sheet(figure.title, figure.subtitle, [*figure.extra, *rows])


def _panel(row: ShownRow, shown: Shown) -> Panel:
    pixels = display(shown.image, Display(shown.exposure_ev))
    words = shown.panel if shown.error is None else f"{shown.panel} · {error_text(shown.error)}"
    narrow = panel_width(len(row.images)) < 11 * len(words)
    return Panel(pixels, words.replace(" ± ", "±").replace(" %", "%") if narrow else words)


def _aspect(row: ShownRow) -> float:
    height, width = row.images[0].image.shape[:2]
    return width / height


def error_text(error: ErrorEstimate) -> str:
    """`12.3 ± 0.4 %`, with as many digits as the uncertainty allows; an exact error stands alone."""
    if not math.isfinite(error.rmse_rel):
        return "no relative error: black"
    return percent_within(error.rmse_rel, error.uncertainty)


def file_name(row: int, column: int, shown: Shown) -> str:
    """Name of the file of an image's radiance, from its position and its label."""
    words = re.sub(r"[^a-z0-9]+", "-", shown.panel.lower()).strip("-")
    return f"{row + 1}-{column + 1}-{words[:40]}.exr"


def records(figure: Figure) -> list[dict[str, Any]]:
    """The images of a figure, their errors and references, and their files.

    An error is None of references, and where the reference is black and an image is not.
    """
    found = []
    for number, row in enumerate(figure.rows):
        for column, shown in enumerate(row.images):
            later = enumerate(row.images[column:], column)
            expected = next((file_name(number, place, each) for place, each in later if each.error is None), None)
            found.append(
                {
                    "name": figure.name,
                    "panel": f"{row.heading}, {shown.panel}",
                    "knobs": dict(shown.parameters),
                    "error_rmse_rel": _finite(shown.error.rmse_rel) if shown.error else None,
                    "error_uncertainty": _finite(shown.error.uncertainty) if shown.error else None,
                    "radiance": file_name(number, column, shown),
                    "reference": expected if shown.error else None,
                }
            )
    return found


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
