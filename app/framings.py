"""What part of the photographs becomes the picture: how a framing begins, and the size that its corners give."""

from __future__ import annotations

from math import hypot
from pathlib import Path
from typing import TYPE_CHECKING

from app.framing_view import Corners
from app.import_panel import is_upright
from engine.steps import Step, Steps

if TYPE_CHECKING:
    from engine.capture.framing import Framing

#: Share of the photograph that a new framing leaves out at each edge.
INSET = 0.1


def begun(path: Path, framing: Framing | None, how: str, width_px: int | None) -> Steps[Framing]:
    """A framing of the photograph to begin with ('crop' or 'corners'), or `framing` at another width."""
    yield Step(0.0, "reading the photograph")
    from engine.capture.decode import read_photograph
    from engine.capture.framing import Framing

    if framing is not None and is_upright(framing) == (how == "crop"):
        across = width_px or framing.width_px
        return Framing(framing.corners, across, max(1, round(across * framing.height_px / framing.width_px)))
    height, width = read_photograph(path).saturated.shape
    left, top = round(INSET * width), round(INSET * height)
    across, along = width - 2 * left, height - 2 * top
    lean = 0.0 if how == "crop" else 0.25 * left
    low, right, bottom = top - 0.5, left + across - 0.5, top + along - 0.5
    corners = ((left - 0.5 + lean, low), (right - lean, low), (right, bottom), (left - 0.5, bottom))
    return Framing(corners, across, along)


def framed(corners: Corners, size: tuple[int, int], *, upright: bool) -> Framing:
    """The framing between `corners` of a photograph of `size` (width, height), as large as it is seen there."""
    from engine.capture.framing import Framing, estimated_aspect

    width, height = size
    return Framing(corners, *_natural_size(corners, estimated_aspect(corners, (height, width)), upright))


def _natural_size(corners: Corners, aspect: float, upright: bool) -> tuple[int, int]:
    """Width and height in pixels at which nothing of the figure between `corners` is made coarser."""
    sides = [hypot(x1 - x0, y1 - y0) for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True)]
    if upright:
        return max(1, round(sides[0])), max(1, round(sides[1]))
    width = max(sides[0], sides[2], max(sides[1], sides[3]) * aspect)
    return max(1, round(width)), max(1, round(width / aspect))
