"""Radiance of a height field under a distant lamp, seen by an orthographic camera straight above.

Physics. A texel at height h with unit normal n = (-dh/dx, -dh/dy, 1) / sqrt(1 + |grad h|^2) is lit by a lamp in
direction l = (cos e cos a, cos e sin a, sin e) for elevation e and azimuth a. A lamp whose irradiance on a surface
that faces it is E makes it reflect

    L = E V max(0, n . l) (rho / pi + f_s(l, v)),    v = (0, 0, 1)

with albedo rho, the share V of the lamp that relief leaves visible, and a specular lobe f_s: GGX with Smith's
height-correlated masking and Schlick's Fresnel term (Walter et al. 2007; Heitz 2014). The camera measures radiance,
so the tilt of a texel towards the viewer enters only through n . l: foreshortening scales the projected area of a
facet and the light it sends alike. For a flat diffuse sample L = E rho sin(e) / pi.

Self-shadowing. The horizon of a texel towards azimuth a is the largest slope (h(x + t d) - h(x)) / t over t > 0. It
is found once for all elevations of an azimuth by sweeping lines across the periodic field and keeping the upper
convex hull of what lies towards the lamp (Timonen and Westerholm 2010, "Scalable Height Field Self-Shadowing",
section 3): exact along rows and columns, interpolated between neighbouring lines otherwise. The lamp is a uniform
disc of angular radius w; what a straight edge at the horizon leaves of it is

    V(u) = 1/2 + (u sqrt(1 - u^2) + asin u) / pi,    u = (e - horizon) / w  in [-1, 1]

so that shadows have the soft edges of a real lamp, and hard ones for w = 0.

Interreflection, where asked for, is one diffuse bounce: the part of a texel's hemisphere that its horizons hide is
taken to shine with the mean radiance of the neighbourhood, L += rho (1 - open) blur(L). The open part, for the
horizontal, is the mean of cos^2(horizon) over azimuths: the integral of the cosine above the horizon, over pi.

Cost: some 40 ms per megatexel and azimuth for the horizon, 30 ms per megatexel and light, 100 ms with a bounce.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.kernels import parallel, prange, scalar
from engine.render.height_fields import Sample
from engine.render.lens import blurred


def light_direction(elevation: float, azimuth: float) -> NDArray[np.float64]:
    """(3,) unit vector towards the lamp; azimuth counts from +x (right) towards +y (up the image)."""
    across = math.cos(elevation)
    return np.array([across * math.cos(azimuth), across * math.sin(azimuth), math.sin(elevation)])


def surface_slope(height: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W, 2) dh/dx and dh/dy of a periodic height field, by central differences over two texels."""
    across = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) / np.float32(2)
    upward = (np.roll(height, 1, axis=0) - np.roll(height, -1, axis=0)) / np.float32(2)
    return np.stack([across, upward], axis=-1).astype(np.float32)


def horizon_slope(height: NDArray[np.float32], azimuth: float, lowest: float) -> NDArray[np.float32]:
    """(H, W) tangent of the horizon's elevation towards `azimuth` of a periodic height field, at least 0.

    Horizons below `lowest` (rad) may be missed, because nothing farther than relief / tan(lowest) is looked at; pass
    the elevation of the lower edge of the lowest lamp.
    """
    if not 0.0 < lowest <= math.pi / 2:
        raise ValueError(f"lowest elevation {lowest:g} rad is outside (0, pi/2]")
    towards_column, towards_row = math.cos(azimuth), -math.sin(azimuth)
    if abs(towards_column) < abs(towards_row):
        return np.ascontiguousarray(_horizon(height.T, towards_row, towards_column, lowest).T)
    return _horizon(height, towards_column, towards_row, lowest)


def openness(height: NDArray[np.float32], azimuths: int = 8, lowest: float = math.radians(5.0)) -> NDArray[np.float32]:
    """(H, W) cosine-weighted part of the hemisphere above a horizontal receiver that relief leaves open, 1 if flat."""
    total = np.zeros(height.shape)
    for index in range(azimuths):
        slope = horizon_slope(height, 2 * math.pi * index / azimuths, lowest).astype(np.float64)
        total += 1.0 / (1.0 + slope * slope)
    return (total / azimuths).astype(np.float32)


def bounce(
    direct: NDArray[np.float32], albedo: NDArray[np.float32], open_part: NDArray[np.float32], reach: float
) -> NDArray[np.float32]:
    """(H, W, 3) radiance by one diffuse bounce off the relief within some `reach` texels."""
    return albedo * (np.float32(1) - open_part)[..., None] * blurred(direct, reach)


def visibility(horizon: NDArray[np.float32], elevation: float, lamp_radius: float) -> NDArray[np.float32]:
    """(H, W) share of a lamp disc of angular radius `lamp_radius` (rad) above the horizon."""
    above = elevation - np.arctan(horizon, dtype=np.float64)
    if lamp_radius == 0.0:
        return (above >= 0.0).astype(np.float32)
    u = np.clip(above / lamp_radius, -1.0, 1.0)
    return (0.5 + (u * np.sqrt(1.0 - u * u) + np.arcsin(u)) / np.pi).astype(np.float32)


def radiance(
    sample: Sample,
    slope: NDArray[np.float32],
    visible: NDArray[np.float32],
    light: NDArray[np.float64],
    irradiance: float = 1.0,
) -> NDArray[np.float32]:
    """(H, W, 3) radiance towards the camera, linear sRGB, in units of `irradiance` per steradian."""
    image = np.empty(sample.albedo.shape, np.float32)
    _shade(slope, sample.albedo, sample.specular, sample.roughness, visible, light, irradiance, image)
    return image


def _horizon(height: NDArray[np.float32], along: float, across: float, lowest: float) -> NDArray[np.float32]:
    """Horizon towards the direction `along` columns and `across` rows (|along| >= |across|, together a unit vector)."""
    field = np.ascontiguousarray(height if along > 0 else height[:, ::-1])
    drift = across / abs(along) if abs(across) > 1e-12 else 0.0
    rows, columns = field.shape
    relief = float(field.max()) - float(field.min())
    reach = math.ceil(min(relief / math.tan(lowest) * abs(along), 4.0 * (rows + columns)))
    lines = np.empty(field.shape, np.float32)
    _sweep(field, drift, 1.0 / abs(along), reach, lines)
    slope = _between_lines(lines, drift) if drift else lines
    return slope if along > 0 else np.ascontiguousarray(slope[:, ::-1])


@parallel
def _sweep(field, drift, spacing, reach, lines):  # type: ignore[no-untyped-def]
    """Bound by the reads of heights: each enters and leaves the hull once.

    Line j passes column c at row j + drift c; it is walked from the far right, where the lamp is, to the left.
    """
    rows, columns = field.shape
    for line in prange(rows):
        hull_height = np.empty(columns + reach + 1)
        hull_column = np.empty(columns + reach + 1, np.int64)
        count = 0
        for column in range(columns + reach - 1, -1, -1):
            here = _on_line(field, line + drift * column, column % columns)
            while count > 1 and (hull_height[count - 1] - here) * (hull_column[count - 2] - column) <= (
                hull_height[count - 2] - here
            ) * (hull_column[count - 1] - column):
                count -= 1
            if column < columns:
                slope = 0.0
                if count > 0:
                    slope = (hull_height[count - 1] - here) / ((hull_column[count - 1] - column) * spacing)
                lines[line, column] = max(slope, 0.0)
            hull_height[count], hull_column[count] = here, column
            count += 1


@scalar
def _on_line(field, row, column):  # type: ignore[no-untyped-def]
    rows = field.shape[0]
    above = math.floor(row)
    first = int(above) % rows
    second = first + 1 if first + 1 < rows else 0
    return field[first, column] + (row - above) * (field[second, column] - field[first, column])


@parallel
def _between_lines(lines, drift):  # type: ignore[no-untyped-def]
    """Bound by memory: two reads and a write to a texel."""
    slope = np.empty_like(lines)
    rows, columns = lines.shape
    for row in prange(rows):
        for column in range(columns):
            slope[row, column] = _on_line(lines, row - drift * column, column)
    return slope


@parallel
def _shade(slope, albedo, specular, roughness, visible, light, irradiance, image):  # type: ignore[no-untyped-def]
    """Bound by arithmetic: one square root and some forty operations to a texel."""
    rows, columns = roughness.shape
    half_x, half_y, half_z = light[0], light[1], light[2] + 1.0
    half_length = math.sqrt(half_x * half_x + half_y * half_y + half_z * half_z)
    half_x, half_y, half_z = half_x / half_length, half_y / half_length, half_z / half_length
    fresnel = (1.0 - half_z) ** 5
    for row in prange(rows):
        for column in range(columns):
            dx, dy = slope[row, column, 0], slope[row, column, 1]
            n_z = 1.0 / math.sqrt(1.0 + dx * dx + dy * dy)
            cosine = max(0.0, (light[2] - dx * light[0] - dy * light[1]) * n_z)
            n_h = (half_z - dx * half_x - dy * half_y) * n_z
            lobe = _ggx(max(cosine, 1e-6), n_z, n_h, roughness[row, column])
            arriving = irradiance * visible[row, column] * cosine
            for channel in range(3):
                base = specular[row, column, channel]
                gloss = lobe * (base + (1.0 - base) * fresnel) if base > 0.0 else 0.0
                image[row, column, channel] = arriving * (albedo[row, column, channel] / math.pi + gloss)


@scalar
def _ggx(n_l, n_v, n_h, alpha):  # type: ignore[no-untyped-def]
    """D G / (4 (n.l) (n.v)) with Smith's height-correlated G (Heitz 2014, eq. 99), in 1/sr, without the cosine."""
    squared = alpha * alpha
    spread = n_h * n_h * (squared - 1.0) + 1.0
    density = squared / (math.pi * spread * spread)
    masking_l = n_v * math.sqrt(n_l * n_l * (1.0 - squared) + squared)
    masking_v = n_l * math.sqrt(n_v * n_v * (1.0 - squared) + squared)
    return density * 0.5 / (masking_l + masking_v)
