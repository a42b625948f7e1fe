"""Directions of lights from a mirror sphere in the image.

An orthographic camera along +z sees the lamp where the sphere's normal halves the angle between camera and lamp, so
the highlight at (x, y) on the sphere gives n = (x, y, sqrt(1 - x^2 - y^2)) and the light l = 2 (n . v) n - v with
v = (0, 0, 1). An error of d pixels of the highlight turns the light by about 2 d / (radius sqrt(1 - x^2 - y^2)).

The sphere is where a highlight moves: what it mirrors of the room stays the same in all photographs, and the lamp
wanders over it. Coins, printed circles and windows in the sphere lack one or the other. Its outline and the horizon
that it mirrors (at sqrt(1/2) of its radius) are the two circles across which brightness changes along the radius, in
all photographs together.

Conventions: pixel centres at half-integers, row 0 on top; directions x right, y up, z towards the camera.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError

#: Pixels of the longer side of images in which circles are searched for, and of the radius in which they are fitted.
SEARCHED_PX, FITTED_PX = 480, 150

#: Pixels of the radius in a search below which the part around a circle is searched once more, larger.
COARSE_PX = 60.0

#: Pixels of the radius in the photographs on which lights can be measured: one pixel is 5 degrees of a light.
MIN_RADIUS_PX = 25.0

#: Edge pixels that vote for circles, radii that they vote for, and circles that are looked at closer.
VOTERS, RADII, CIRCLES = 40_000, 40, 40

#: Circles that are tried as the horizon; a lamp may be mirrored so close to that that it lies in no sky within.
HORIZONS, HORIZON_RADIAL = 6, 0.975

#: Variance of a brightness difference (of square roots of values up to 1) below which there is no edge.
NO_EDGE = 2e-6

#: Pixels outside an outline in which the change of the surroundings is looked at.
BEYOND_PX: NDArray[np.float64] = np.arange(5.0, 11.0)

#: Directions in which an outline is sampled.
ANGLES: NDArray[np.float64] = np.radians(np.arange(0.0, 360.0, 3.0))[:, None]
COSINE, SINE = np.cos(ANGLES), np.sin(ANGLES)

#: Share of an outline that lies in the image at least, share of that on which anything changes, and share of the change
#: that is radial. A texture has a half of it along each direction.
MIN_SEEN, MIN_CHANGING, MIN_RADIAL, MIN_PEAK = 0.35, 0.5, 0.88, 0.8

#: Pixels of the radius of a circle that can be told from an edge by chance.
MIN_RADIUS = 8.0

#: The horizon lies at sqrt(1/2) of the radius; within this share there is nothing but room and lamps.
SKY = 0.66

#: Photographs of which at least three quarters show another lamp in the same place.
MIN_MOVING = 4

#: Sine of the angle below the horizon down to which a low lamp may be mirrored, where the table ends before.
BELOW = 0.1

#: A highlight is brighter than its background by this many times its unrest, and by this share of the brightest.
STANDS_OUT, MIN_HIGHLIGHT = 5.0, 0.03

#: Share of the photographs that show a highlight on a sphere.
MIN_SHOWN = 0.4

_DULL = "no highlight stands out on the sphere"
_HIDDEN = "the highlight is hidden in part by what else the sphere mirrors"

#: Shares of the peak and the area of a highlight in most images that it has in each, and where a window or the horizon
#: is next to it: with less of a lamp its middle is told to worse than 3 degrees.
MIN_PEAK_SHARE, MIN_AREA_SHARE, MIN_SHARE_BESIDE_HIDDEN = 0.3, 0.3, 0.8

#: Shares of the radius that a highlight moves at least.
MIN_MOTION = 0.05


@dataclass(frozen=True)
class Circle:
    """Outline of the sphere in pixels: centre (column, row) and radius."""

    column: float
    row: float
    radius: float

    def distance(self, other: Circle) -> float:
        """Pixels between the centres."""
        return math.hypot(self.column - other.column, self.row - other.row)


@dataclass(frozen=True)
class _View:
    """Photographs (N, h, w) of the square from (left, top) on of whole ones, scaled by `scale`."""

    images: NDArray[np.float32]
    scale: float
    left: int
    top: int

    def normalised(self, white: float) -> NDArray[np.float32]:
        """The photographs with 1 for what is as bright as `white` or more."""
        return np.clip(self.images / np.float32(white), 0, 1)

    def inwards(self, circle: Circle) -> Circle:
        """A circle of the whole photographs."""
        column, row = (circle.column - self.left) * self.scale, (circle.row - self.top) * self.scale
        return Circle(column, row, circle.radius * self.scale)

    def outwards(self, circle: Circle) -> Circle:
        """A circle of the view in the whole photographs."""
        column, row = circle.column / self.scale + self.left, circle.row / self.scale + self.top
        return Circle(column, row, circle.radius / self.scale)


def find_sphere(images: NDArray[np.float32], first: Circle | None = None) -> Circle:
    """The outline of the mirror sphere in the luminance of photographs (N, H, W).

    With `first` the outline of another one is found. In less than four photographs circles that stand out are enough.
    Raises UsageError where there is none on which a highlight moves.
    """
    height, width = images.shape[1:]
    around = Circle(width / 2, height / 2, max(height, width) / 2)
    view = _view(images, around, min(1.0, SEARCHED_PX / max(height, width)))
    white = max(float(np.percentile(view.images, 99.5)), 1e-9)
    outline, horizon = _search(view, white, first)
    if view.scale < 1 and outline.radius * view.scale < COARSE_PX:
        around = Circle(outline.column, outline.row, 3 * outline.radius)
        view = _view(images, around, min(1.0, SEARCHED_PX / (2 * around.radius)))
        outline, horizon = _search(view, white, first)
    scale = min(1.0, FITTED_PX / outline.radius)
    around = Circle(outline.column, outline.row, 1.2 * outline.radius + BEYOND_PX[-1] / scale)
    view = _view(images, around, scale)
    found = view.outwards(_refine(_edges(view.normalised(white)), view.inwards(outline), horizon=horizon))
    if found.radius < MIN_RADIUS_PX:
        problem = (
            f"the sphere at column {found.column:.0f}, row {found.row:.0f} has a radius of {found.radius:.0f} pixels"
        )
        raise UsageError(f"{problem}, on which lights cannot be measured; {MIN_RADIUS_PX:.0f} are needed")
    return found


def _search(view: _View, white: float, first: Circle | None) -> tuple[Circle, bool]:
    """The outline in whole photographs to a pixel of the view, and whether it encloses a horizon."""
    images = view.normalised(white)
    edges = _edges(images)
    circles = [_fit(edges, drawn) for drawn in _vote(edges)]
    if first is not None:
        known = view.inwards(first)
        circles = [circle for circle in circles if circle.distance(known) > known.radius]
    circles = [circle for circle in circles if circle.radius >= MIN_RADIUS and _radial(edges, circle) >= MIN_RADIAL]
    shown = {circle: _share_with_highlight(images, circle) for circle in circles}
    most = max(shown.values(), default=0.0)
    if most < MIN_SHOWN:
        raise UsageError("no sphere was found on which a highlight moves")
    circles.sort(key=lambda one: -_radial(edges, one))
    for horizon in [circle for circle in circles[:HORIZONS] if _radial(edges, circle) >= HORIZON_RADIAL]:
        over = _refine(edges, Circle(horizon.column, horizon.row, math.sqrt(2) * horizon.radius), horizon=True)
        stands_out = _is_horizon(horizon, over) and _radial(edges, over) >= MIN_PEAK
        if stands_out and _share_with_highlight(images, over) >= max(MIN_SHOWN, 0.7 * most):
            return view.outwards(over), True
    outline, is_over = _outermost(edges, [circle for circle in circles if shown[circle] >= 0.7 * most], images)
    return view.outwards(outline), is_over


def _view(images: NDArray[np.float32], around: Circle, scale: float) -> _View:
    """The square around a circle, reduced by `scale`."""
    import cv2

    left, top = (max(0, math.floor(middle - around.radius)) for middle in (around.column, around.row))
    right, bottom = (math.ceil(middle + around.radius) for middle in (around.column, around.row))
    reduced = [
        cv2.resize(image[top:bottom, left:right], None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        for image in images
    ]
    return _View(np.stack(reduced), scale, left, top)


def _edges(images: NDArray[np.float32]) -> NDArray[np.float32]:
    """(3, H, W) structure tensor gx gx, gy gy, gx gy of the square roots of images (N, H, W), the mean over all."""
    import cv2

    tensor = np.zeros((3, *images.shape[1:]), np.float32)
    for image in images:
        smooth = cv2.GaussianBlur(np.sqrt(image), (0, 0), 0.7)
        gx, gy = (cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3, scale=1 / 8) for order in ((1, 0), (0, 1)))
        tensor += np.stack([gx * gx, gy * gy, gx * gy]) / np.float32(len(images))
    return tensor


def _vote(edges: NDArray[np.float32]) -> Iterator[Circle]:
    """Circles that most edges are perpendicular to (Hough transform with the direction of the edges, Kimme1975).

    Centres may lie outside the image by a quarter of its size.
    """
    import cv2

    height, width = edges.shape[1:]
    change = edges[0] + edges[1]
    around = cv2.GaussianBlur(change, (0, 0), 8)
    straight = np.hypot(edges[0] - edges[1], 2 * edges[2]) > 0.8 * change
    rows, columns = np.nonzero(straight & (change > 0.5 * around) & (change > max(NO_EDGE, 0.2 * np.median(change))))
    if len(rows) > VOTERS:
        steepest = np.argsort(-(change / around)[rows, columns], kind="stable")[:VOTERS]
        rows, columns = rows[steepest], columns[steepest]
    angle = 0.5 * np.arctan2(2 * edges[2], edges[0] - edges[1])[rows, columns]
    radii = np.geomspace(max(5.0, 0.02 * min(height, width)), 0.5 * max(height, width), RADII)
    border_y, border_x = height // 4, width // 4
    shape = (height + 2 * border_y) // 2 + 1, (width + 2 * border_x) // 2 + 1  # cells of two pixels
    votes = np.zeros((RADII, *shape), np.float32)
    for index, radius in enumerate(radii):
        for side in (radius, -radius):
            x = ((columns + side * np.cos(angle) + border_x) // 2).astype(np.int64)
            y = ((rows + side * np.sin(angle) + border_y) // 2).astype(np.int64)
            within = (x >= 0) & (x < shape[1]) & (y >= 0) & (y < shape[0])
            cells = y[within] * shape[1] + x[within]
            votes[index] += np.bincount(cells, minlength=shape[0] * shape[1]).reshape(shape)
        blur = 1 + 0.015 * radius
        count = cv2.GaussianBlur(votes[index], (0, 0), blur) * (4 * math.pi * blur * blur)  # within the blur
        chance = float(count.mean())
        votes[index] = (count - chance) / math.sqrt(chance + 1)  # small circles get many by chance more often
    for _ in range(CIRCLES):
        index, y, x = (int(at) for at in np.unravel_index(int(votes.argmax()), votes.shape))
        if votes[index, y, x] <= 0:
            return
        yield Circle(2.0 * x + 1 - border_x, 2.0 * y + 1 - border_y, float(radii[index]))
        near = max(2, int(0.06 * radii[index]))
        votes[max(0, index - 2) : index + 3, max(0, y - near) : y + near + 1, max(0, x - near) : x + near + 1] = 0


def _across(
    edges: NDArray[np.float32], circle: Circle, radii: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Change along the radius, NaN outside the image, and its share of all change, NaN where nothing changes.

    Both are (angles, radii).
    """
    import cv2

    height, width = edges.shape[1:]
    x, y = (middle - 0.5 + radii * part for middle, part in ((circle.column, COSINE), (circle.row, SINE)))
    sampled = (cv2.remap(plane, np.float32(x), np.float32(y), cv2.INTER_LINEAR) for plane in edges)
    xx, yy, xy = (np.asarray(plane, np.float64) for plane in sampled)
    seen = (x >= 1) & (x <= width - 2) & (y >= 1) & (y <= height - 2)
    radial = np.where(seen, np.maximum(xx * COSINE**2 + yy * SINE**2 + 2 * xy * COSINE * SINE, 0), np.nan)
    return radial, np.where(xx + yy > NO_EDGE, radial / np.maximum(xx + yy, NO_EDGE), np.nan)


def _radial(edges: NDArray[np.float32], circle: Circle) -> float:
    """The share of the change that is radial, the mean over the outline; 0 where too little of that is seen."""
    radial, share = _across(edges, circle, np.array([circle.radius]))
    seen, changing = ~np.isnan(radial), ~np.isnan(share)
    enough = seen.mean() >= MIN_SEEN and changing.sum() >= MIN_CHANGING * seen.sum()
    return float(share[changing].mean()) if enough else 0.0


def _covered(edges: NDArray[np.float32], circle: Circle) -> float:
    """The mean over the outline of the share of the change that is radial, 0 where nothing changes."""
    radial, share = _across(edges, circle, np.array([circle.radius]))
    seen = ~np.isnan(radial)
    return float(np.nansum(share) / seen.sum()) if seen.mean() >= MIN_SEEN else 0.0


def _change(edges: NDArray[np.float32], circle: Circle) -> float:
    """How much changes across a circle."""
    change = np.log(_across(edges, circle, np.array([circle.radius]))[0] + NO_EDGE)
    seen = ~np.isnan(change)
    return float(change[seen].mean()) if seen.mean() >= MIN_SEEN else -math.inf


def _fit(edges: NDArray[np.float32], start: Circle) -> Circle:
    """The circle near `start` across which the change is most radial."""
    return Circle(*_maximise(lambda at: _covered(edges, Circle(*at)), [start.column, start.row, start.radius]))


def _maximise(quality: Callable[[NDArray[np.float64]], float], start: list[float]) -> list[float]:
    """Values in pixels near `start`, centre and radii, of the greatest quality (simplex, Nelder1965)."""
    from scipy.optimize import minimize

    def objective(at: NDArray[np.float64]) -> float:
        return -quality(at) if at[2] > 3 else math.inf

    at = np.array(start)
    for step in (1 + 0.03 * start[2], 0.5):  # a simplex that has shrunk too early starts once more
        simplex = at + np.vstack([np.zeros(len(at)), np.eye(len(at)) * step])
        options = {"initial_simplex": simplex, "xatol": 0.02, "fatol": 1e-4, "maxfev": 200}
        at = minimize(objective, at, method="Nelder-Mead", options=options).x
    return [float(value) for value in at]


def _refine(edges: NDArray[np.float32], outline: Circle, *, horizon: bool) -> Circle:
    """The circle near `outline` on which most changes, and more than outside.

    What the rim mirrors is the more compressed the closer it lies to the outline, so that change rises towards that
    from inside, and falls to that of the surroundings outside. Where nothing changes outside, the outline is an edge
    alone, and where that is steepest. A horizon around the same centre, which is sharper, helps to find that.
    """
    near, _ = _across(edges, outline, outline.radius * np.linspace(0.94, 1.06, 25))
    beyond, _ = _across(edges, outline, outline.radius + BEYOND_PX)
    steepest = np.nanmax(near, axis=1, initial=NO_EDGE)
    little = 0.03 * steepest + 0.01 * np.median(steepest)  # what is dark on both sides does not count
    around = float(np.median(beyond[~np.isnan(beyond)])) if not np.isnan(beyond).all() else 0.0
    weight = 0.5 * min(1.0, 50 * around / float(np.median(steepest)))

    def quality(at: NDArray[np.float64]) -> float:
        column, row, radius = at[:3]
        radial, _ = _across(edges, Circle(column, row, radius), radius + np.array([0.0, 2.0]))
        on, outside = np.log(radial + little[:, None]).T
        seen = ~np.isnan(on) & ~np.isnan(outside)
        if seen.mean() < MIN_SEEN:
            return -math.inf
        step = float((on + weight * (on - outside))[seen].mean())
        return step + 3 * _change(edges, Circle(column, row, at[3])) if horizon else step

    start = [outline.column, outline.row, outline.radius, outline.radius * math.sqrt(0.5)]
    return Circle(*_maximise(quality, start[: 4 if horizon else 3])[:3])


def _share_with_highlight(images: NDArray[np.float32], circle: Circle) -> float:
    """The share of images (N, H, W) with a highlight within the sky of a sphere, 0 where those do not move."""
    if len(images) < MIN_MOVING:
        return 1.0
    sky = _within(images.shape[1:], circle, SKY)
    if sky.sum() < 30:
        return 0.0
    shown = images[:, sky]
    lower, upper = np.quantile(shown, (0.25, 0.75), axis=0)
    least = max(MIN_HIGHLIGHT, STANDS_OUT * float(np.median(upper - lower)))
    brighter = shown - lower
    bright = brighter.max(axis=1) > least
    if bright.sum() < 2:
        return 0.0
    spots = np.argwhere(sky)[brighter[bright].argmax(axis=1)]
    moved = np.hypot(*(spots - np.median(spots, axis=0)).T).max()
    return float(bright.mean()) if moved > MIN_MOTION * circle.radius else 0.0


def _within(shape: tuple[int, ...], circle: Circle, share: float) -> NDArray[np.bool_]:
    rows, columns = np.mgrid[: shape[0], : shape[1]] + 0.5
    inside: NDArray[np.bool_] = np.hypot(columns - circle.column, rows - circle.row) < share * circle.radius
    return inside


def _outermost(edges: NDArray[np.float32], circles: list[Circle], images: NDArray[np.float32]) -> tuple[Circle, bool]:
    """The outline among circles of which the first stands out most, and whether it encloses a horizon.

    The first may be the horizon, or what else a sphere shows around its centre. Where two circles lie at a ratio of
    sqrt(2), they are horizon and outline; else the outermost is taken within which a highlight moves.
    """
    core = circles[0]
    radii = core.radius * np.geomspace(0.6, 1.6, 200)
    share = _across(edges, core, radii)[1]
    seen = ~np.isnan(share)
    profile = np.where(seen.mean(axis=0) >= MIN_SEEN, np.nansum(share, axis=0) / np.maximum(seen.sum(axis=0), 1), 0)
    peaks = [at for at in range(3, 197) if profile[at] == profile[at - 3 : at + 4].max() and profile[at] > MIN_PEAK]
    rings = [_fit(edges, Circle(core.column, core.row, float(radii[at]))) for at in peaks]
    rings = [ring for ring in rings if ring.distance(core) < 0.05 * core.radius and _radial(edges, ring) >= MIN_RADIAL]
    around = [circle for circle in circles if circle.distance(core) + core.radius <= 1.02 * circle.radius]
    rings += [circle for circle in around if circle is core or _radial(edges, circle) >= HORIZON_RADIAL]
    shown = {ring: _share_with_highlight(images, ring) for ring in rings}
    rings = sorted((ring for ring in rings if shown[ring] >= 0.7 * max(shown.values())), key=lambda ring: ring.radius)
    over_horizon = [ring for ring in rings if any(_is_horizon(other, ring) for other in rings)]
    return (over_horizon or rings)[-1], bool(over_horizon)


def _is_horizon(inner: Circle, outline: Circle) -> bool:
    concentric = inner.distance(outline) < 0.05 * outline.radius
    return concentric and abs(outline.radius / inner.radius / math.sqrt(2) - 1) < 0.05


def find_highlights(images: NDArray[np.float32], sphere: Circle) -> list[tuple[float, float] | UsageError]:
    """(column, row) of the lamp's reflection in each of the images (N, H, W), or why there is none.

    What a quarter of them shows at least is room, not lamp. A lamp that a bright reflection of the room or the horizon
    hides in part is taken to be as large as in most images.
    """
    left, top = (max(0, math.floor(middle - sphere.radius)) for middle in (sphere.column, sphere.row))
    right, bottom = (max(1, math.ceil(middle + sphere.radius)) for middle in (sphere.column, sphere.row))
    squares = np.ascontiguousarray(images[:, top:bottom, left:right])
    room = np.quantile(squares, 0.25, axis=0).astype(np.float32) if len(images) >= MIN_MOVING else 0 * squares[0]
    mirrored = _mirrored(room.shape, sphere, left, top)
    found = [_spot(square - room, mirrored) for square in squares]
    spots = [spot for spot in found if isinstance(spot, _Spot)]
    if not spots:
        return [spot for spot in found if isinstance(spot, UsageError)]
    peak, area = np.quantile([(spot.peak, spot.pixels.sum()) for spot in spots], 0.75, axis=0).tolist()
    hidden = (mirrored[..., 2] <= 0) | (room > 0.5 * peak)
    half_angle = math.acos(max(0.0, 1 - 2 * area / (math.pi * sphere.radius**2)))  # solid angle 4 area / radius^2
    highlights = list[tuple[float, float] | UsageError]()
    for square, spot in zip(squares, found, strict=True):
        middle: NDArray[np.float64] | UsageError
        if isinstance(spot, UsageError):
            middle = spot
        elif spot.peak < MIN_PEAK_SHARE * peak:
            middle = UsageError(_DULL)
        elif (spot.pixels & ~hidden).sum() + 1 < _least_share(spot, hidden) * area:  # within a pixel of count
            middle = UsageError(_HIDDEN)
        else:
            middle = _middle(spot, square - room, mirrored, hidden & ~spot.pixels, half_angle)
        if isinstance(middle, UsageError):
            highlights.append(middle)
            continue
        normal = middle + np.array([0.0, 0.0, 1.0])
        x, y, _ = sphere.radius * normal / np.linalg.norm(normal)
        highlights.append((float(sphere.column + x), float(sphere.row - y)))
    return highlights


def _least_share(spot: _Spot, hidden: NDArray[np.bool_]) -> float:
    """The share of the area of a whole lamp that a reflection has: more where it ends at what may hide the rest."""
    import cv2

    around = cv2.dilate(np.uint8(spot.pixels), np.ones((3, 3), np.uint8)) > 0
    return MIN_SHARE_BESIDE_HIDDEN if (around & hidden).any() else MIN_AREA_SHARE


def find_highlight(luminance: NDArray[np.float32], sphere: Circle) -> tuple[float, float]:
    """(column, row) of the lamp's reflection in one image (H, W); UsageError where none stands out."""
    (found,) = find_highlights(luminance[None], sphere)
    if isinstance(found, UsageError):
        raise found
    return found


def _mirrored(shape: tuple[int, ...], sphere: Circle, left: int, top: int) -> NDArray[np.float64]:
    """(H, W, 3) directions from which the pixels of a sphere get their light, (0, 0, -1) outside the outline.

    The image begins at (left, top). Equal areas mirror equal solid angles, 4 / radius^2 for a pixel.
    """
    rows, columns = np.mgrid[: shape[0], : shape[1]] + 0.5
    x, y = (columns + left - sphere.column) / sphere.radius, (sphere.row - top - rows) / sphere.radius
    z = np.sqrt(np.clip(1 - x * x - y * y, 0, 1))
    return np.stack([2 * z * x, 2 * z * y, 2 * z * z - 1], axis=-1)


@dataclass(frozen=True)
class _Spot:
    """A reflection: its pixels (H, W), the unit vector (3,) to the brightest of them, and their brightest value."""

    pixels: NDArray[np.bool_]
    direction: NDArray[np.float64]
    peak: float


def _spot(brighter: NDArray[np.float32], mirrored: NDArray[np.float64]) -> _Spot | UsageError:
    """What is above half of the brightest and connected to that, in a sphere (H, W) less the room that it mirrors."""
    import cv2

    sky = mirrored[..., 2] > 0
    if not sky.any():
        return UsageError("the outline of the sphere lies outside the image")
    shown = np.where(mirrored[..., 2] > -BELOW, brighter, 0)
    peak = float(shown[sky].max())
    if peak <= max(0.0, 2 * float(np.median(shown[sky]))):
        return UsageError(_DULL)
    _, labels = cv2.connectedComponents(np.uint8(shown > 0.5 * peak))
    smooth = np.where(sky & (labels > 0), cv2.blur(shown, (3, 3)), 0)
    brightest = np.unravel_index(int(smooth.argmax()), smooth.shape)
    pixels: NDArray[np.bool_] = labels == labels[brightest]
    rows, columns = np.nonzero(pixels)
    if rows.min() == 0 or columns.min() == 0 or rows.max() == sky.shape[0] - 1 or columns.max() == sky.shape[1] - 1:
        return UsageError("the highlight is cut by the border of the image")
    return _Spot(pixels, mirrored[brightest], peak)


def _middle(
    spot: _Spot,
    brighter: NDArray[np.float32],
    mirrored: NDArray[np.float64],
    hidden: NDArray[np.bool_],
    half_angle: float,
) -> NDArray[np.float64] | UsageError:
    """The unit vector (3,) to the middle of a lamp of this size whose reflection is seen where that is not `hidden`.

    A pixel counts by its light for as much of the sphere of directions as any other, so that the mean of what they
    mirror is the middle of a lamp, however large that is; where a part is hidden, the middle is where the rest of a
    whole lamp would have that mean. What is connected to the reflection but farther away than a lamp is large is none.
    """
    import cv2

    middle = spot.direction
    around = (cv2.dilate(np.uint8(spot.pixels), np.ones((3, 3), np.uint8)) > 0) & ~hidden
    light = np.where(around, np.maximum(brighter, 0), 0).astype(np.float64)
    for _ in range(30):
        cosine = mirrored @ middle
        whole = cosine > math.cos(half_angle)
        seen = whole & ~hidden
        near = light * (cosine > math.cos(min(math.pi / 2, 1.5 * half_angle + 0.02)))
        if not seen.any() or not near.any():
            return UsageError(_HIDDEN)
        observed = np.average(mirrored.reshape(-1, 3), axis=0, weights=near.ravel())
        expected = mirrored[seen].mean(axis=0) if (whole & hidden).any() else middle
        middle = middle + observed - expected
        middle = middle / np.linalg.norm(middle)
    return middle


def light_direction(sphere: Circle, column: float, row: float) -> NDArray[np.float64]:
    """(3,) unit vector towards the lamp whose reflection is seen at (column, row).

    Raises UsageError for a point outside the outline, or so close to it that the lamp would stand behind the sample.
    """
    x = (column - sphere.column) / sphere.radius
    y = (sphere.row - row) / sphere.radius
    z = np.sqrt(max(0.0, 1 - x * x - y * y))
    light = np.array([2 * z * x, 2 * z * y, 2 * z * z - 1])
    if x * x + y * y > 1 or light[2] <= 0:
        raise UsageError("the highlight lies too close to the outline: the lamp would stand below the sample")
    return light
