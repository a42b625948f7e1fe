"""From the photographs of a stack to the maps of its surface.

The steps: the lamps and what they tell (`lamps`), kinds of texels and their priors, slopes and reflectance of each
texel (`reflectance`, `engine.texel.kernel`), height (`height`), occlusion by relief (`horizon`), and the error against
the photographs (`relight`).
Memory, by the arrays and not measured: maps with their uncertainties take 150 bytes a texel, the height 100 more; 24
megapixels would need some 6 GiB.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.calibration.separation import gain_sigma_of
from engine.capture.mask import mask_of
from engine.capture.stack import ImageStack
from engine.core.colour import WorkingSpace
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps, part
from engine.core.summary import Summary
from engine.surface.depth_edges import add_torn, divide, doubt_open_outlines, find_beside, find_depth_edges, find_unlit
from engine.surface.height import (
    LENS,
    disagreement,
    estimate_unresolved,
    height_deviation,
    height_from_slopes,
    lens_variance,
    measure_relief,
    shift_variance,
)
from engine.surface.horizon import openness
from engine.surface.lamps import Lamps, lamps
from engine.surface.metal_kernel import METAL_EVIDENCE
from engine.surface.pbr_maps import (
    DIELECTRIC_F0,
    Map,
    MapErrors,
    PbrMaps,
    Uncertainty,
    clip_wide,
    count_regions,
    wide_text,
)
from engine.surface.reflectance import (
    FEWEST_FOR_GLOSS,
    Array,
    Reflectance,
    fit_rows,
    kinds,
    metallic_roughness,
)
from engine.surface.regularise import smooth_roughness, weigh_neighbours
from engine.surface.relight import coefficients, measure_relight_errors
from engine.surface.rig_error import rig_error
from engine.texel.kernel import (
    COV_AB,
    COV_REFLECTANCE,
    DIFFUSE,
    DIFFUSE_BY_R,
    ROUGHNESS,
    SPECULAR,
    SPECULAR_BY_R,
    VAR_A,
    VAR_B,
    VAR_DIFFUSE,
    VAR_ROUGHNESS,
    VAR_SPECULAR,
    show_texels,
)

#: Largest levels of 8 and 16 bits, which are no radiance.
_LEVELS = (255.0, 65535.0)

#: Texels beyond the border that are mirrored for the shadows of relief, and the lowest light that counts there.
BORDER, LOWEST = 64, math.radians(5.0)

#: Held-out error over that of the mean image, and median deviation of normals (radians), that need attention.
NOT_BETTER, MAX_NORMAL_SIGMA = 0.8, math.radians(5.0)

#: Columns of ρ and F, their variances and covariance, and how they move with the roughness.
COEFFICIENTS = [
    *range(DIFFUSE, DIFFUSE + 3),
    *range(SPECULAR, SPECULAR + 3),
    VAR_DIFFUSE,
    VAR_SPECULAR,
    COV_REFLECTANCE,
    DIFFUSE_BY_R,
    SPECULAR_BY_R,
]

#: Texels that are converted at once.
BLOCK_TEXELS = 1 << 16

#: Share of texels whose colour may exceed one before it is worth a word.
WORTH_A_WORD = 0.001


@dataclass(frozen=True, eq=False, repr=False)
class Surface(Summary):
    """The maps, the lamps, the radiance of a white card that faces a lamp, and the seconds of the parts."""

    maps: PbrMaps
    lamps: Lamps
    white: float
    health: Health
    seconds: dict[str, float]

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        height, width = self.maps.size
        error = math.degrees(self.maps.errors.normal_sigma)
        return {"size": f"{width} × {height} texels", "normal_error": f"{error:.3g}°", "white": self.white}


def check_white(white: float | None, name: str) -> None:
    """Refuse a radiance of a white card that none has; UsageError calls it by `name`."""
    if white is None:
        return
    if not 1e-6 <= white <= 1e6:
        raise UsageError(f"{name} {white} is not a positive radiance")
    if white in _LEVELS:
        raise UsageError(
            f"{name} {white:g} seems to be an 8- or 16-bit level; the white level is 1, or its share of that where the "
            "reference is darker"
        )


def recover(
    stack: ImageStack, used: NDArray[np.int64], *, white: float | None = None, left_out: bool = True
) -> Steps[Surface]:
    """The surface behind the photographs `used`.

    `white` is the radiance of a white card that faces a lamp, in units of the photographs' white level; None for 1, or
    more where texels are brighter. `left_out` asks for the error of photographs that are left out.
    Raises InputError where the lamps do not tell any slope.
    """
    start = time.perf_counter()
    seen = lamps(stack, used)
    shape = (stack.radiance.shape[1], stack.radiance.shape[2])
    planes = _Planes(*shape, seen, stack.working_space)
    diffuse_only = len(used) < FEWEST_FOR_GLOSS
    drawn = mask_of(stack)
    outside = np.zeros(shape, np.bool_) if drawn is None else ~drawn
    shadows = beside = None
    if seen.observed.kind == "both":
        shadows = yield from part(find_depth_edges(stack, used, seen.direction), 0.0, 0.05)
        outside |= find_unlit(shadows.upper)
        if outside.all():
            outside = np.zeros(shape, np.bool_)
        beside = find_beside(shadows.mark(shape)) if len(shadows.places) else None
    alike = yield from part(kinds(stack, used, seen, white, outside), 0.05, 0.1)
    for step in fit_rows(stack, used, seen, alike, diffuse_only, beside, outside):
        first, last, found = step.partial
        if diffuse_only:
            found[:, SPECULAR : SPECULAR + 3] = DIELECTRIC_F0
        planes.put(first, last, found)
        yield Step(0.1 + 0.5 * step.done, step.note)
    planes.finish(outside)
    blur, shift = _alignment_errors(stack, used)
    for channel in range(3):
        own = planes.sigma["base_colour"][..., channel]
        np.minimum(np.hypot(own, np.sqrt(lens_variance(planes.base_colour[..., channel], blur))), 1.0, out=own)
    of_gain = np.float32(gain_sigma_of(stack.provenance))
    if of_gain:  # the diffuse part is as bright as the gain of the pairs says
        own = planes.sigma["base_colour"]
        np.minimum(np.hypot(own, of_gain * planes.base_colour), 1.0, out=own)
    # roughness is alpha^(1/2), so that alpha² is out by 4 roughness³ times its error
    of_relief = estimate_unresolved(planes.slope, blur) / (4.0 * planes.roughness**3)
    planes.sigma["roughness"] = np.minimum(np.hypot(planes.sigma["roughness"], of_relief), 0.5).astype(np.float32)
    fitted = time.perf_counter()
    height = height_sigma = occlusion = occlusion_sigma = region = None
    doubts: list[Finding] = []
    if shadows is not None:
        edges = shadows.confirm(planes.slope, planes.predict)
        in_shadow = edges.copy()
        right, up = -planes.slope[..., 0].astype(np.float64), -planes.slope[..., 1].astype(np.float64)
        blurred, moved = (
            0.5 * (measure(planes.slope[..., 0], size) + measure(planes.slope[..., 1], size))
            for measure, size in ((lens_variance, blur), (shift_variance, shift))
        )
        steep = 1.0 + right**2 + up**2
        of_image = (blurred + moved) * (steep + 1.0) / steep**2
        planes.sigma["normal"] = np.sqrt(planes.sigma["normal"] ** 2 + of_image).astype(np.float32)
        variance = planes.variance + blurred + moved
        edges |= outside
        division = divide(edges)
        solved = yield from part(height_from_slopes(right, up, variance, division), 0.6, 0.7)
        excess, off = disagreement(solved, right, up, variance, division)
        torn = add_torn(edges, off, excess)
        if (torn & ~edges).any():
            division = divide(torn)
            again = height_from_slopes(right, up, variance, division, solved)
            solved = yield from part(again, 0.7, 0.75)
            excess, _ = disagreement(solved, right, up, variance, division)
        if division is not None and division.count > 1:
            region = division.region.astype(np.float32)
        planes.sigma["normal"] = np.minimum(planes.sigma["normal"] * np.sqrt(excess), 0.5 * np.pi).astype(np.float32)
        if outside.any():
            solved[outside] = solved[~outside].min()
        height = solved.astype(np.float32)
        deviation = yield from part(height_deviation(excess * variance, division), 0.75, 0.8)
        of_outlines = doubt_open_outlines(in_shadow & shadows.find_contradicted(solved), division, solved, outside)
        deviation = np.hypot(deviation, of_outlines)
        yield Step(0.8, "estimating errors of the rig")
        of_rig, doubts = rig_error(stack, used, seen)
        if of_outlines.any():
            doubted = percent(float((of_outlines > 0.0)[~outside].mean()))
            text = (
                f"Outlines within {doubted} of the surface are not closed: its heights are as uncertain as they differ"
            )
            doubts = [*doubts, Finding(Verdict.WARNING, text)]
        normal_sigma = np.hypot(planes.sigma["normal"], of_rig)
        if stack.provenance.get("lights_convex_assumed"):  # normals and heights may as well be those of the other side
            normal_sigma = np.hypot(normal_sigma, np.arccos(np.clip(planes.normal[..., 2], 0.0, 1.0)))
            deviation = np.hypot(deviation, np.abs(solved - solved.mean(dtype=np.float64)))
        planes.sigma["normal"] = np.minimum(normal_sigma, 0.5 * np.pi).astype(np.float32)
        # what the lens flattens, it flattens everywhere: heights are short by the same part as slopes
        share = float(np.sqrt(2.0 * blurred.mean(dtype=np.float64) / max((right**2 + up**2).mean(), 1e-12)))
        relief = measure_relief(solved, division)
        # slopes that err alike over the image bend it: their error times half the way from its middle
        rows, columns = (np.arange(size) - 0.5 * (size - 1) for size in solved.shape)
        bent = 0.5 * of_rig * np.hypot(rows[:, None], columns[None])
        height_sigma = np.sqrt(deviation**2 + (share * relief) ** 2 + bent**2).astype(np.float32)
        occlusion = yield from part(_open_part(height), 0.8, 0.85)
        # the open part is the mean of cos² of horizons, which err as the normals do
        hidden = np.sqrt(occlusion * (1.0 - occlusion))
        occlusion_sigma = np.minimum(2.0 * hidden * planes.sigma["normal"], 1.0).astype(np.float32)
    solved_at = time.perf_counter()
    figures = MapErrors(normal_sigma=float(np.median(planes.sigma["normal"][~outside])))
    if left_out:
        comparing = measure_relight_errors(stack, used, seen, alike, lambertian=diffuse_only, outside=outside)
        apart = yield from part(comparing, 0.85, 1.0)
        figures = MapErrors(apart.in_sample, apart.left_out, apart.mean_picture, figures.normal_sigma)
    base_colour, base_sigma, wide = clip_wide(stack.working_space, planes.base_colour, planes.sigma.pop("base_colour"))
    assert base_sigma is not None
    maps = PbrMaps(
        base_colour,
        planes.normal,
        planes.roughness,
        planes.metallic,
        planes.f0,
        height,
        occlusion,
        Uncertainty(base_sigma, **planes.sigma, height=height_sigma, occlusion=occlusion_sigma),
        seen.observed,
        figures,
        region,
        (~outside).astype(np.float32) if outside.any() else None,
        wide=wide,
    )
    seconds = {"fit": fitted - start, "height": solved_at - fitted, "errors": time.perf_counter() - solved_at}
    return Surface(maps, seen, alike.white, _health(maps, alike.white, len(used), doubts), seconds)


def _alignment_errors(stack: ImageStack, used: NDArray[np.int64]) -> tuple[float, float]:
    """Variance by which photographs are blurred along an axis, in squared texels, and by how many texels they may lie
    beside their place.

    The bilinear weights of the import blur a photograph that was moved by the fraction f of a texel by f (1 − f), the
    mean of which is 1/6. What is left of the motion of the camera is the residual that the import states.
    """
    recorded = stack.provenance.get("photographs")
    listed = recorded if isinstance(recorded, list) and len(recorded) == len(stack.sources) else []
    still = np.eye(3).ravel().tolist()
    moved = [
        photograph
        for photograph in used
        if listed
        and isinstance(listed[photograph], dict)
        and listed[photograph].get("alignment_matrix", still) != still
    ]
    residual = [stack.quality[photograph].alignment_residual_px or 0.0 for photograph in moved]
    blur = LENS**2 + len(moved) / max(len(used), 1) / 6.0
    return blur, float(np.median(residual)) if residual else 0.0


class _Planes:
    """The maps of a stack as they are filled block by block of rows, colours in its working space."""

    def __init__(self, height: int, width: int, seen: Lamps, space: WorkingSpace) -> None:
        self.seen, self.space = seen, space
        plane, colour = (height, width), (height, width, 3)
        self.slope = np.zeros((height, width, 2), np.float32)
        self.variance, self.evidence = np.zeros(plane, np.float32), np.zeros(plane, np.float32)
        self.coefficients = np.zeros((*plane, len(COEFFICIENTS)), np.float32)
        self.base_colour, self.normal = np.zeros(colour, np.float32), np.zeros(colour, np.float32)
        self.roughness, self.metallic, self.f0 = (np.zeros(plane, np.float32) for _ in range(3))
        self.sigma: dict[str, Map] = {
            name: np.zeros(colour if name == "base_colour" else plane, np.float32)
            for name in ("base_colour", "normal", "roughness", "metallic", "f0")
        }

    def put(self, first: int, last: int, found: Array) -> None:
        """Rows from `first` to before `last` as the kernel found them."""
        rows, width = slice(first, last), self.slope.shape[1]

        def reshape(values: Array) -> Map:
            return np.asarray(values, np.float32).reshape(last - first, width, *values.shape[1:])

        along, across = found[:, 0], found[:, 1]
        cosine, sine = np.cos(self.seen.turn), np.sin(self.seen.turn)
        slope = np.stack([cosine * along - sine * across, sine * along + cosine * across], axis=-1)
        normal = np.column_stack([slope, np.ones(len(slope))])
        self.normal[rows] = reshape(normal / np.linalg.norm(normal, axis=1, keepdims=True))
        self.slope[rows] = reshape(slope)
        a, b, c = found[:, VAR_A], found[:, VAR_B], found[:, COV_AB]
        if self.seen.observed.kind != "both":
            b, c = np.zeros_like(b), np.zeros_like(c)
        self.variance[rows] = reshape(0.5 * (a + b))
        self.sigma["normal"][rows] = reshape(_angle(along, across, a, b, c))
        self.coefficients[rows] = reshape(found[:, COEFFICIENTS])
        self.roughness[rows] = reshape(found[:, ROUGHNESS])
        self.sigma["roughness"][rows] = reshape(np.minimum(np.sqrt(found[:, VAR_ROUGHNESS]), 0.5))
        self.evidence[rows] = reshape(self._find_metallic(rows, METAL_EVIDENCE).metal_evidence)

    def finish(self, outside: NDArray[np.bool_]) -> None:
        """Let neighbours decide what texels do not tell, and say that nothing is known of texels `outside` (H, W)."""
        found, sigma = smooth_roughness(self.roughness, self.sigma["roughness"], outside)
        self.sigma["roughness"] = sigma
        threshold = weigh_neighbours(self.evidence, METAL_EVIDENCE, outside)
        count = max(1, BLOCK_TEXELS // self.roughness.shape[1])
        for first in range(0, len(self.roughness), count):
            rows = slice(first, first + count)
            self._convert(rows, found[rows], threshold[rows])
        for name, values, unknown in (
            ("roughness", self.roughness, 0.5),
            ("metallic", self.metallic, 0.5),
            ("f0", self.f0, DIELECTRIC_F0),
        ):
            values[outside] = DIELECTRIC_F0 if name == "f0" else 0.5 if name == "roughness" else 0.0
            self.sigma[name][outside] = unknown
        self.base_colour[outside], self.sigma["base_colour"][outside] = 0.0, 1.0

    def _convert(self, rows: slice, roughness: Map, evidence: Map) -> None:
        """Metallic-roughness of the coefficients of some rows at another roughness; metals need this evidence."""
        own = self.coefficients[rows]
        moved = (roughness - self.roughness[rows])[..., None] * own[..., 9:]  # ρ and F move with the roughness
        own[..., :3] = np.maximum(own[..., :3] + moved[..., :1], 0.0)
        own[..., 3:6] = np.maximum(own[..., 3:6] + moved[..., 1:], 0.0)
        self.roughness[rows] = roughness
        made, shape = self._find_metallic(rows, evidence), self.roughness[rows].shape
        self.base_colour[rows], self.metallic[rows] = made.base_colour.reshape(*shape, 3), made.metallic.reshape(shape)
        self.f0[rows] = made.f0.reshape(shape)
        self.sigma["base_colour"][rows] = made.base_colour_sigma.reshape(*shape, 3)
        self.sigma["metallic"][rows] = made.metallic_sigma.reshape(shape)
        self.sigma["f0"][rows] = made.f0_sigma.reshape(shape)

    def _find_metallic(self, rows: slice, evidence: float | Map) -> Reflectance:
        flat = self.coefficients[rows].reshape(-1, len(COEFFICIENTS)).astype(np.float64)
        needed = evidence if isinstance(evidence, float) else evidence.ravel().astype(np.float64)
        return metallic_roughness(flat[:, :3], flat[:, 3:6], flat[:, 6:9], needed)

    def predict(self, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> Array:
        """(N, E) radiance of texels at `rows` and `columns` (E,) under each lamp, as the maps show it."""
        at = (rows, columns)
        diffuse, specular = coefficients(self.base_colour[at], self.metallic[at][:, None], self.f0[at][:, None])
        cosine, sine = np.cos(self.seen.turn), np.sin(self.seen.turn)
        right, up = self.slope[at].T.astype(np.float64)
        turned = np.stack([cosine * right + sine * up, cosine * up - sine * right], axis=1)
        towards = self.seen.observe_from(rows, columns, *self.roughness.shape)
        image = np.empty((len(towards), len(rows), 3), np.float32)
        show_texels(turned, self.roughness[at], diffuse, specular, towards, image)
        return np.asarray((image @ self.space.to_rec709.T).mean(axis=-1), np.float64)


def _angle(along: Array, across: Array, a: Array, b: Array, c: Array) -> Array:
    """Root mean square angle (radians) by which normals err, for slopes with variances a and b and covariance c.

    For the slopes s of a normal the angle of a change d is |d|² / (1 + s²) − (s·d)² / (1 + s²)², squared.
    """
    length = 1.0 + along**2 + across**2
    with np.errstate(invalid="ignore"):
        inside = along**2 * a + across**2 * b + 2.0 * along * across * c
        squared = (a + b) / length - inside / length**2
    return np.asarray(np.sqrt(np.clip(np.nan_to_num(squared, nan=np.inf), 0.0, (0.5 * np.pi) ** 2)))


def _open_part(height: Map) -> Steps[Map]:
    """(H, W) cosine-weighted part of the hemisphere that relief leaves open; beyond the border it is mirrored."""
    border = [min(BORDER, size) for size in height.shape]
    padded = np.pad(height, [(each, each) for each in border], "symmetric")
    found = yield from openness(padded, lowest=LOWEST)
    inner = found[border[0] : border[0] + height.shape[0], border[1] : border[1] + height.shape[1]]
    return np.ascontiguousarray(np.clip(inner, 0.0, 1.0))


def _health(maps: PbrMaps, white: float, photographs: int, doubts: list[Finding]) -> Health:
    findings = list(doubts)
    if maps.observed.azimuth is not None:
        azimuth = number(math.degrees(maps.observed.azimuth))
        text = f"the lamps stand on one arc: only the slope along {azimuth}° is observed, across it the surface is "
        findings.append(Finding(Verdict.WARNING, text + "shown as flat, and there is no height"))
    if maps.region is not None:
        inside = maps.region == maps.region if maps.mask is None else maps.mask > 0.0
        share = percent(float(np.mean(maps.region[inside] == 0.0)))
        text = f"depth edges divide the surface into {count_regions(maps)} regions, the largest with {share} of it: "
        findings.append(Finding(Verdict.WARNING, f"{text}the height steps between them by amounts that are unknown"))
    if maps.mask is not None:
        share = percent(float(1.0 - maps.mask.mean(dtype=np.float64)))
        findings.append(Finding(Verdict.NOTE, f"{share} of the image is background, of which nothing is said"))
    if maps.wide is not None:
        findings.append(Finding(Verdict.NOTE, wide_text(maps.wide)))
    if photographs < FEWEST_FOR_GLOSS:
        text = f"{photographs} photographs do not resolve highlights: roughness and reflectance are those of plastic"
        findings.append(Finding(Verdict.WARNING, text))
    if white > 1.0:
        text = f"a white reference that faces a lamp is taken to be {number(white)} times as bright as the white level"
        findings.append(Finding(Verdict.NOTE, f"{text}, because texels are brighter than a card at that level"))
    if maps.errors.left_out > NOT_BETTER * maps.errors.mean_picture:
        ours, mean = number(maps.errors.left_out), number(maps.errors.mean_picture)
        text = f"held-out error is {ours} 8-bit levels, not at least 20 % lower than the {mean} of the mean image"
        findings.append(Finding(Verdict.WARNING, f"{text}: shadows, or lamps that are placed wrongly"))
    if maps.errors.normal_sigma > MAX_NORMAL_SIGMA:
        sigma = number(math.degrees(maps.errors.normal_sigma))
        text = (
            f"half of the normals are uncertain by more than {sigma}° (1 sigma): the photographs do not fit the model"
        )
        findings.append(Finding(Verdict.WARNING, f"{text} of a lit surface, or lamps are placed wrongly"))
    return Health(findings=tuple(findings))
