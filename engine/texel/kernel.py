"""Kernel that finds the slope and the reflectance of each texel from its radiance under all lamps.

The model of a texel of slopes (a, b) = (n_x, n_y) / n_z under the light v of lamp i, seen from straight above, is

    I_i = ρ c_i + F s_i,   c = max(n·v, 0),   s = π D G₂ / (4 n·l n·v) c

with GGX and Smith's height-correlated shadowing (Heitz2014 Eq. 99) of alpha = roughness²; v has the length of the
irradiance over π. Schlick's term is left out: seen from above it is below 2·10⁻³ for lamps at 5° and more. A photograph
may show another share of either part, as one taken through a polariser does: c and s of a lamp are then those shares of
the above.

A surface may reflect its diffuse part by another law than Lambert's: c is then multiplied by a fall-off

    m = (n·l)^g (1 − q (1 − n·l)⁵) (1 + β r),   r = s / t,  s = l_z − n·l n_z,  t = max(n·l, n_z) if s > 0, else 1

of a power g, of light that enters through an interface (q, with Schlick's term) and of rough surfaces, which are
brighter towards the lamp (β, Oren1994 in the form of Fujii). It is 1 where the normal points to lamp and viewer.

1. Lambertian and robust, of photographs without a specular part where there are any. The fifth of the photographs that
   is darkest in the texel (shadows) and the fifth that is brightest (highlights) are left out by rank; then least
   squares, reweighted with Tukey's biweight, which ends at 3 deviations below the fit and at 2 above it. The deviation
   is 1.4826 times the median of the absolute residuals.
2. All parameters by Levenberg-Marquardt, from these slopes or from the direction of the highlight. ρ and F of each
   channel are linear and are eliminated from the normal equations (Golub1973), so that a 3 × 3 system for a, b and the
   roughness remains. Residuals are divided by the root of the model, as photons scatter, and reweighted by the biweight
   that ends at 4 deviations.
3. Covariances are the inverse of the normal equations, times the square of the deviation; those of ρ and F include
   what they follow of an error of slopes and roughness.

Roughness and F have priors, a mean and a deviation, which speak where the photographs do not.
Both lobes of all lamps and their derivatives are one evaluation. All sums over lamps are the products of pairs of its
columns, from which reflectance, gradient and normal equations follow without the lamps; an iteration ends where a step
is small beside the standard deviation of what it moves.
Bound by arithmetic, roots and quotients of the lobes above all: 0.023 ms of one core for 40 lamps, 0.042 ms for 64.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar
from engine.core.quickselect import nth_smallest

Bools = NDArray[np.bool_]
Integers = NDArray[np.integer]
Floats = NDArray[np.floating]

#: Columns of the result: slopes, roughness, ρ, F, variances of the slopes and their covariance, variances of the
#: roughness, ρ and F, covariance of ρ and F, the deviation of a residual, and how ρ and F move with the roughness.
A, B, ROUGHNESS, DIFFUSE, SPECULAR = 0, 1, 2, 3, 6
VAR_A, VAR_B, COV_AB, VAR_ROUGHNESS, VAR_DIFFUSE, VAR_SPECULAR, COV_REFLECTANCE, DEVIATION = range(9, 17)
DIFFUSE_BY_R, SPECULAR_BY_R = 17, 18
COLUMNS = 19

#: Slopes of more than 80° and roughness below what a lamp of one degree shows are not told.
STEEPEST, MIN_ROUGHNESS = 5.67, 0.12

#: The least deviation of a residual over the root of the mean radiance, and what counts as dark, over the mean.
MIN_DEVIATION, DARK = 2e-3, 0.05

#: Iterations at most, those of the Lambertian start, and the step at which they end, in squared standard deviations.
ITERATIONS, ROUNDS, ENOUGH = 12, 10, 1e-3

#: Deviation of a prior of roughness from which several are tried.
UNKNOWN_ROUGHNESS = 0.12

#: Rows of an evaluation: c, s, and their derivatives in a, b and roughness, in which c has none.
C, S, C_A, S_A, C_B, S_B, S_R = range(7)


@parallel
def fit_texels(
    values: Floats,
    usable: Bools,
    lights: Floats,
    shares: Floats,
    across_free: bool,
    priors: Floats,
    kind: Integers,
    lambertian: bool,
    found: Floats,
) -> None:
    """Fill `found` (T, COLUMNS) float64.

    `values` (N, T, 3) float32 radiance, `usable` (N, T) bool, `lights` (N, T or 1, 3) float64, `shares` (N, 2) of the
    diffuse and the specular part that each photograph shows, the diffuse ones positive, `priors` (K, 4) means and
    deviations of roughness and F, and three numbers of the fall-off (g, q, β) where it is not Lambert's (K, 7), `kind`
    (T,) which of them a texel has. Where `across_free` is False, b is zero. Where
    `lambertian` is True, F is zero.
    """
    count, texels = usable.shape
    rows = 64
    for chunk in prange((texels + rows - 1) // rows):
        value, lamp = np.empty((3, count)), np.empty((7, count))
        grey, weight, scratch = np.empty(count), np.empty(count), np.empty((3, count))
        lobe, products = np.empty((2, 7, count)), np.empty((7, 10))
        is_usable, is_matte = np.empty(count, np.bool_), np.empty(count, np.bool_)
        is_separated = False
        for i in range(count):
            is_separated = is_separated or shares[i, 1] == 0.0
        for texel in range(chunk * rows, min(texels, (chunk + 1) * rows)):
            if lights.shape[1] > 1 or texel == chunk * rows:
                _place(lights, texel if lights.shape[1] > 1 else 0, lamp)
                for i in range(count):
                    lamp[5, i], lamp[6, i] = shares[i, 0], shares[i, 1]
            for i in range(count):
                is_usable[i] = usable[i, texel]
                is_matte[i] = usable[i, texel] and (shares[i, 1] == 0.0 or not is_separated)
                for channel in range(3):
                    value[channel, i] = values[i, texel, channel]
                grey[i] = (value[0, i] + value[1, i] + value[2, i]) / 3.0
            row, prior = found[texel], priors[kind[texel]]
            _lambertian(grey, is_matte, lamp, across_free, weight, scratch[0], row)
            _refine(value, grey, is_usable, lamp, across_free, prior, lambertian, weight, scratch, lobe, products, row)


@scalar
def _place(lights: Floats, place: int | np.int64, lamp: Floats) -> None:
    """Fill `lamp` (7, N): the light, the inverse of its length, that of its unit vector plus (0, 0, 1), and shares of
    one of the diffuse and the specular part."""
    for i in range(len(lights)):
        x, y, z = lights[i, place, 0], lights[i, place, 1], lights[i, place, 2]
        length = math.sqrt(x * x + y * y + z * z)
        lamp[0, i], lamp[1, i], lamp[2, i] = x, y, z
        lamp[3, i], lamp[4, i] = 1.0 / length, 1.0 / math.sqrt(2.0 + 2.0 * z / length)
        lamp[5, i], lamp[6, i] = 1.0, 1.0


@scalar
def lobes(a: float, b: float, alpha: float, x: float, y: float, z: float) -> tuple[float, float]:
    """(c, s) of the model for light (x, y, z) of any length."""
    strength = math.sqrt(x * x + y * y + z * z)
    n_z = 1.0 / math.sqrt(1.0 + a * a + b * b)
    received = (a * x + b * y + z) * n_z
    if received <= 0.0:
        return 0.0, 0.0
    n_l, l_z = received / strength, z / strength
    n_h = (received / strength + n_z) / math.sqrt(2.0 + 2.0 * l_z)
    squared = alpha * alpha
    spread = n_h * n_h * (squared - 1.0) + 1.0
    masking_l = n_z * math.sqrt(n_l * n_l * (1.0 - squared) + squared)
    masking_v = n_l * math.sqrt(n_z * n_z * (1.0 - squared) + squared)
    return received, squared / (spread * spread) * 0.5 / (masking_l + masking_v) * received


@scalar
def fall_off(n_l: float, n_z: float, l_z: float, fall: Floats) -> tuple[float, float, float]:
    """The factor m of the diffuse part and its derivatives in n·l and n_z; `fall` are g, q and β."""
    n_l = max(n_l, 1e-3)
    s = l_z - n_l * n_z
    if s <= 0.0:
        r, r_l, r_z = s, -n_z, -n_l
    elif n_l >= n_z:
        r, r_l, r_z = l_z / n_l - n_z, -l_z / (n_l * n_l), -1.0
    else:
        r, r_l, r_z = l_z / n_z - n_l, -1.0, -l_z / (n_z * n_z)
    away = 1.0 - n_l
    entering, rough = 1.0 - fall[1] * away**5, 1.0 + fall[2] * r
    power = n_l ** fall[0]
    m = power * entering * rough
    m_l = m * fall[0] / n_l + power * (5.0 * fall[1] * away**4 * rough + entering * fall[2] * r_l)
    return m, m_l, power * entering * fall[2] * r_z


@parallel
def show_kinds(
    slopes: Floats,
    roughness: Floats,
    diffuse: Floats,
    specular: Floats,
    towards: Floats,
    falls: Floats,
    kind: Integers,
    image: Floats,
) -> None:
    """As `show_texels`, with the fall-off (K, 3) of the kind (T,) of each texel."""
    for texel in prange(len(slopes)):
        place, fall = np.int64(texel) if towards.shape[1] > 1 else np.int64(0), falls[kind[texel]]
        a, b = slopes[texel, 0], slopes[texel, 1]
        n_z, alpha = 1.0 / math.sqrt(1.0 + a * a + b * b), max(roughness[texel], 0.03) ** 2
        for lamp in range(len(towards)):
            x, y, z = towards[lamp, place]
            received, highlight = lobes(a, b, alpha, x, y, z)
            strength = math.sqrt(x * x + y * y + z * z)
            received *= fall_off(received / strength, n_z, z / strength, fall)[0]
            for channel in range(3):
                image[lamp, texel, channel] = diffuse[texel, channel] * received + specular[texel, channel] * highlight


@parallel
def weigh_fall_off(slopes: Floats, towards: Floats, falls: Floats, kind: Integers, share: Floats) -> None:
    """Fill `share` (T,) with ρ of the Lambertian surface that is nearest over the lamps, over ρ with the fall-off."""
    for texel in prange(len(slopes)):
        place, fall = np.int64(texel) if towards.shape[1] > 1 else np.int64(0), falls[kind[texel]]
        a, b, both, own = slopes[texel, 0], slopes[texel, 1], 0.0, 0.0
        n_z = 1.0 / math.sqrt(1.0 + a * a + b * b)
        for lamp in range(len(towards)):
            x, y, z = towards[lamp, place]
            strength, received = math.sqrt(x * x + y * y + z * z), (a * x + b * y + z) * n_z
            if received > 0.0:
                both += received * received * fall_off(received / strength, n_z, z / strength, fall)[0]
                own += received * received
        share[texel] = both / own if own > 0.0 else 1.0


@parallel
def show_texels(
    slopes: Floats, roughness: Floats, diffuse: Floats, specular: Floats, towards: Floats, image: Floats
) -> None:
    """Fill `image` (N, T, 3) from texels (T, …) under the light (N, T or 1, 3)."""
    for texel in prange(len(slopes)):
        place = np.int64(texel) if towards.shape[1] > 1 else np.int64(0)
        for lamp in range(len(towards)):
            x, y, z = towards[lamp, place]
            alpha = max(roughness[texel], 0.03) ** 2
            received, highlight = lobes(slopes[texel, 0], slopes[texel, 1], alpha, x, y, z)
            for channel in range(3):
                image[lamp, texel, channel] = diffuse[texel, channel] * received + specular[texel, channel] * highlight


@parallel
def differentiate(slopes: Floats, roughness: Floats, lights: Floats, found: Floats) -> None:
    """Fill `found` (T, 7, N) with c, s and their derivatives, rows as of `evaluate`, for lights (N, T or 1, 3)."""
    for texel in prange(len(slopes)):
        lamp = np.empty((7, len(lights)))
        _place(lights, np.int64(texel) if lights.shape[1] > 1 else np.int64(0), lamp)
        evaluate(slopes[texel, 0], slopes[texel, 1], roughness[texel], lamp, np.empty(0), found[texel])


@scalar
def _lambertian(
    grey: Floats, is_usable: Bools, lamp: Floats, across_free: bool, weight: Floats, sorting: Floats, row: Floats
) -> None:
    """Slopes of the robust Lambertian fit, into `row`; `weight` is then zero for shadows, highlights and clipping."""
    count, kept = len(grey), 0
    for i in range(count):
        if is_usable[i]:
            sorting[kept] = grey[i]
            kept += 1
    tail = kept // 5 if kept - 2 * (kept // 5) >= 4 else 0
    dark = nth_smallest(sorting, kept, tail) if tail > 0 else -np.inf
    bright = nth_smallest(sorting, kept, kept - 1 - tail) if tail > 0 else np.inf
    row[A], row[B] = 0.0, 0.0
    for i in range(count):
        weight[i] = 1.0 if is_usable[i] and dark <= grey[i] <= bright else 0.0
    last_x, last_y, last_z = 0.0, 0.0, 0.0
    for _ in range(ROUNDS):
        xx, xy, xz, yy, yz, zz, xg, yg, zg = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(count):
            w = weight[i]
            if w == 0.0:
                continue
            x, y, z = lamp[0, i], lamp[1, i] if across_free else 0.0, lamp[2, i]
            wx, wy, wz = w * x, w * y, w * z
            xx, xy, xz, yy, yz, zz = xx + wx * x, xy + wx * y, xz + wx * z, yy + wy * y, yz + wy * z, zz + wz * z
            xg, yg, zg = xg + wx * grey[i], yg + wy * grey[i], zg + wz * grey[i]
        least = 1e-7 * (xx + yy + zz) + 1e-30
        x, y, z = _solve(xx + least, xy, xz, yy + least, yz, zz + least, xg, yg, zg)
        kept = 0
        for i in range(count):
            fitted = x * lamp[0, i] + y * lamp[1, i] + z * lamp[2, i]
            if is_usable[i] and fitted > 0.0:
                sorting[kept] = abs(grey[i] - fitted)
                kept += 1
        if kept < 5 or z <= 0.0:
            break
        deviation = 1.4826 * nth_smallest(sorting, kept, kept // 2) + 1e-7 * z
        for i in range(count):
            fitted = x * lamp[0, i] + y * lamp[1, i] + z * lamp[2, i]
            off = grey[i] - fitted
            off /= deviation * (3.0 if off < 0.0 else 2.0)
            weight[i] = (1.0 - off * off) ** 2 if is_usable[i] and fitted > 0.0 and abs(off) < 1.0 else 0.0
        if abs(x - last_x) + abs(y - last_y) + abs(z - last_z) < 2e-3 * z:
            break
        last_x, last_y, last_z = x, y, z
    if z > 0.0:
        row[A] = min(max(x / z, -STEEPEST), STEEPEST)
        row[B] = min(max(y / z, -STEEPEST), STEEPEST)


@scalar
def _solve(
    xx: float, xy: float, xz: float, yy: float, yz: float, zz: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Solution of a symmetric positive 3 × 3 system (Cholesky)."""
    a = math.sqrt(max(xx, 1e-300))
    b, c = xy / a, xz / a
    d = math.sqrt(max(yy - b * b, 1e-300))
    e = (yz - b * c) / d
    f = math.sqrt(max(zz - c * c - e * e, 1e-300))
    u = x / a
    v = (y - b * u) / d
    w = (z - c * u - e * v) / f
    third = w / f
    second = (v - e * third) / d
    return (u - b * second - c * third) / a, second, third


@scalar
def evaluate(a: float, b: float, roughness: float, lamp: Floats, fall: Floats, lobe: Floats) -> None:
    """Fill `lobe` (7, N) for the lamps (7, N) of `_place`: c and s as in `lobes`, and their derivatives.

    `fall` are g, q and β of the diffuse part, or nothing for Lambert's.
    """
    falls = len(fall) > 0 and (fall[0] != 0.0 or fall[1] != 0.0 or fall[2] != 0.0)
    n_z = 1.0 / math.sqrt(1.0 + a * a + b * b)
    z_a, z_b = -a * n_z * n_z * n_z, -b * n_z * n_z * n_z
    squared = roughness * roughness * roughness * roughness
    rest = 1.0 - squared
    root_v = math.sqrt(n_z * n_z * rest + squared)
    by_z, by_alpha = n_z * rest / root_v, 0.5 * (1.0 - n_z * n_z) / root_v
    for i in range(lamp.shape[1]):
        received = (a * lamp[0, i] + b * lamp[1, i] + lamp[2, i]) * n_z
        lit = 1.0 if received > 0.0 else 0.0
        received = received * lit
        c_a = lit * (lamp[0, i] * n_z - received * a * n_z * n_z)
        c_b = lit * (lamp[1, i] * n_z - received * b * n_z * n_z)
        n_l, l_a, l_b = received * lamp[3, i], c_a * lamp[3, i], c_b * lamp[3, i]
        root_l = math.sqrt(n_l * n_l * rest + squared)
        n_h = (n_l + n_z) * lamp[4, i]
        spread = 1.0 / (1.0 - n_h * n_h * rest)
        visible = 1.0 / (n_z * root_l + n_l * root_v)
        gloss = lamp[6, i] * 0.5 * squared * spread * spread * visible
        s = gloss * received
        by_h, by_l = 4.0 * n_h * rest * spread * lamp[4, i], n_z * n_l * rest / root_l + root_v
        own = root_l + n_l * by_z
        lobe[C, i], lobe[S, i] = lamp[5, i] * received, s
        lobe[C_A, i], lobe[C_B, i] = lamp[5, i] * c_a, lamp[5, i] * c_b
        if falls and received > 0.0:
            m, m_l, m_z = fall_off(n_l, n_z, lamp[2, i] * lamp[3, i], fall)
            lobe[C_A, i] = lamp[5, i] * (c_a * m + received * (m_l * l_a + m_z * z_a))
            lobe[C_B, i] = lamp[5, i] * (c_b * m + received * (m_l * l_b + m_z * z_b))
            lobe[C, i] *= m
        lobe[S_A, i] = s * (by_h * (l_a + z_a) - (own * z_a + by_l * l_a) * visible) + gloss * c_a
        lobe[S_B, i] = s * (by_h * (l_b + z_b) - (own * z_b + by_l * l_b) * visible) + gloss * c_b
        by_square = 1.0 / squared - 2.0 * n_h * n_h * spread
        by_square -= (0.5 * n_z * (1.0 - n_l * n_l) / root_l + n_l * by_alpha) * visible
        lobe[S_R, i] = s * by_square * 4.0 * roughness * roughness * roughness


@scalar
def _sum_up(value: Floats, weight: Floats, lobe: Floats, columns: int, products: Floats) -> None:
    """Fill `products` (7, 10): sums over lamps of products of rows of `lobe`, and from column 7 of these and values.

    Of the rows, the first `columns` are looked at, with the upper triangle alone.
    """
    products[:columns] = 0.0
    for i in range(len(weight)):
        w = weight[i]
        if w == 0.0:
            continue
        for j in range(columns):
            part = w * lobe[j, i]
            for k in range(j, columns):
                products[j, k] += part * lobe[k, i]
            for channel in range(3):
                products[j, 7 + channel] += part * value[channel, i]


@scalar
def _reflectance(
    value: Floats, weight: Floats, products: Floats, prior: Floats, strength: float, lambertian: bool, row: Floats
) -> float:
    """ρ and F, zero or more, of each channel by least squares, into `row`; returns the weighted squares.

    `strength` is the variance of a residual, in whose unit the prior is.
    """
    cc, cs, ss = products[C, C], products[C, S], products[S, S]
    own = strength / (prior[3] * prior[3])
    squares = 0.0
    for channel in range(3):
        cv, sv = products[C, 7 + channel], products[S, 7 + channel] + own * prior[2]
        determinant = cc * (ss + own) - cs * cs
        diffuse, specular = -1.0, -1.0
        if determinant > 1e-12 * cc * (ss + own) and not lambertian:
            diffuse = (cv * (ss + own) - sv * cs) / determinant
            specular = (sv * cc - cv * cs) / determinant
        if lambertian or specular < 0.0:
            specular = 0.0
            diffuse = max(cv / cc, 0.0) if cc > 0.0 else 0.0
        elif diffuse < 0.0:
            diffuse = 0.0
            specular = max(sv / (ss + own), 0.0)
        row[DIFFUSE + channel], row[SPECULAR + channel] = diffuse, specular
        if not lambertian:
            squares += own * (specular - prior[2]) ** 2
        of_values = 0.0
        for i in range(len(weight)):
            of_values += weight[i] * value[channel, i] * value[channel, i]
        squares += of_values - 2.0 * (diffuse * cv + specular * products[S, 7 + channel])
        squares += diffuse * diffuse * cc + 2.0 * diffuse * specular * cs + specular * specular * ss
    return squares


@scalar
def _reweigh(
    value: Floats, is_usable: Bools, mean: float, weight: Floats, scratch: Floats, lobe: Floats, row: Floats
) -> float:
    """The biweight of each photograph over the variance of its photons; returns the deviation of a residual."""
    count, kept = len(weight), 0
    for i in range(count):
        model, off = 0.0, 0.0
        for channel in range(3):
            shown = row[DIFFUSE + channel] * lobe[C, i] + row[SPECULAR + channel] * lobe[S, i]
            model += shown / 3.0
            off += (value[channel, i] - shown) / 3.0
        scratch[1, i] = 1.0 / (model + DARK * mean + 1e-9)
        scratch[2, i] = off * math.sqrt(scratch[1, i])
        if is_usable[i] and lobe[C, i] > 0.0:
            scratch[0, kept] = abs(scratch[2, i])
            kept += 1
    least = MIN_DEVIATION * math.sqrt(mean + 1e-9)
    deviation = max(1.4826 * nth_smallest(scratch[0], kept, kept // 2), least) if kept > 4 else 10.0 * least
    for i in range(count):
        off = scratch[2, i] / (4.0 * deviation)
        weight[i] = (1.0 - off * off) ** 2 * scratch[1, i] if is_usable[i] and abs(off) < 1.0 else 0.0
    return deviation


@scalar
def _refine(
    value: Floats,
    grey: Floats,
    is_usable: Bools,
    lamp: Floats,
    across_free: bool,
    prior: Floats,
    lambertian: bool,
    weight: Floats,
    scratch: Floats,
    lobe: Floats,
    products: Floats,
    row: Floats,
) -> None:
    """All parameters of a texel and their covariances, into `row`."""
    count, mean, kept = len(grey), 0.0, 0
    for i in range(count):
        if is_usable[i]:
            mean += max(grey[i], 0.0)
            kept += 1
    mean /= max(kept, 1)
    row[VAR_A:] = np.inf
    row[ROUGHNESS], row[DEVIATION], row[DIFFUSE_BY_R], row[SPECULAR_BY_R] = prior[0], 0.0, 0.0, 0.0
    row[DIFFUSE:VAR_A] = 0.0
    if mean <= 1e-6:
        row[A], row[B] = 0.0, 0.0
        return
    now = 0
    a, b, roughness = _start(
        value, grey, is_usable, lamp, across_free, prior, lambertian, mean, weight, lobe[0], products, row
    )
    damping, trial = 1e-2, row.copy()
    deviation = _reweigh(value, is_usable, mean, weight, scratch, lobe[now], row)
    for _ in range(ITERATIONS):
        strength = 3.0 * deviation * deviation
        _sum_up(value, weight, lobe[now], 7, products)
        before = _reflectance(value, weight, products, prior, strength, lambertian, row)
        before += strength * ((roughness - prior[0]) / prior[1]) ** 2
        aa, ab, ar, bb, br, rr, ga, gb, gr = _normal_equations(
            products, prior, strength, across_free, lambertian, a, b, roughness, row
        )
        up = 1.0 + damping
        da, db, dr = _solve(aa * up, ab, ar, bb * up, br, rr * up, ga, gb, gr)
        gain = da * ga + db * gb + dr * gr
        da, db, dr = min(max(da, -0.3), 0.3), min(max(db, -0.3), 0.3), min(max(dr, -0.15), 0.15)
        new_a, new_b = min(max(a + da, -STEEPEST), STEEPEST), min(max(b + db, -STEEPEST), STEEPEST)
        new_r = min(max(roughness + dr, MIN_ROUGHNESS), 1.0)
        evaluate(new_a, new_b, new_r, lamp, prior[4:], lobe[1 - now])
        _sum_up(value, weight, lobe[1 - now], 2, products)
        after = _reflectance(value, weight, products, prior, strength, lambertian, trial)
        after += strength * ((new_r - prior[0]) / prior[1]) ** 2
        if after <= before:
            a, b, roughness, now = new_a, new_b, new_r, 1 - now
            row[DIFFUSE:VAR_A] = trial[DIFFUSE:VAR_A]
            damping *= 0.3
            deviation = _reweigh(value, is_usable, mean, weight, scratch, lobe[now], row)
        else:
            damping = 10.0 * damping + 1e-3
        if gain < ENOUGH * strength or damping > 1e3:
            break
    strength = 3.0 * deviation * deviation
    _sum_up(value, weight, lobe[now], 7, products)
    row[A], row[B], row[ROUGHNESS], row[DEVIATION] = a, b, roughness, deviation
    _covariances(products, prior, strength, across_free, lambertian, row)


@scalar
def _covariances(
    products: Floats, prior: Floats, strength: float, across_free: bool, lambertian: bool, row: Floats
) -> None:
    """Variances and covariances of all parameters, into `row`: (Golub1973) that of ρ and F, x, where p are the others,
    is strength (X⁻¹ + X⁻¹ M P⁻¹ Mᵀ X⁻¹), X being the normal equations of x, P those of p without x, and M the mixed.
    What moves with the roughness are the means over channels of −X⁻¹ M.
    """
    aa, ab, ar, bb, br, rr = _normal_equations(
        products, prior, strength, across_free, lambertian, row[A], row[B], row[ROUGHNESS], row
    )[:6]
    of_a = _solve(aa, ab, ar, bb, br, rr, 1.0, 0.0, 0.0)
    of_b = _solve(aa, ab, ar, bb, br, rr, 0.0, 1.0, 0.0)
    of_r = _solve(aa, ab, ar, bb, br, rr, 0.0, 0.0, 1.0)
    row[VAR_A], row[COV_AB], row[VAR_B] = strength * of_a[0], strength * of_a[1], strength * of_b[1]
    row[VAR_ROUGHNESS] = strength * of_r[2]
    cc, cs, ss = products[C, C], products[C, S], products[S, S] + strength / (prior[3] * prior[3])
    determinant = cc * ss - cs * cs
    if lambertian:
        if cc > 0.0:
            row[VAR_DIFFUSE], row[VAR_SPECULAR], row[COV_REFLECTANCE] = strength / cc, prior[3] ** 2, 0.0
        return
    if determinant <= 0.0:
        return
    p, q, r = ss / determinant, -cs / determinant, cc / determinant
    diffuse, specular, both = p, r, q
    for channel in range(3):
        d, f = row[DIFFUSE + channel], row[SPECULAR + channel]
        a_c, a_s = d * products[C, C_A] + f * products[C, S_A], d * products[S, C_A] + f * products[S, S_A]
        b_c, b_s = d * products[C, C_B] + f * products[C, S_B], d * products[S, C_B] + f * products[S, S_B]
        if not across_free:
            b_c, b_s = 0.0, 0.0
        r_c, r_s = f * products[C, S_R], f * products[S, S_R]
        row[DIFFUSE_BY_R] -= (p * r_c + q * r_s) / 3.0
        row[SPECULAR_BY_R] -= (q * r_c + r * r_s) / 3.0
        d_a, d_b, d_r = p * a_c + q * a_s, p * b_c + q * b_s, p * r_c + q * r_s
        f_a, f_b, f_r = q * a_c + r * a_s, q * b_c + r * b_s, q * r_c + r * r_s
        x = d_a * of_a[0] + d_b * of_a[1] + d_r * of_a[2]
        y = d_a * of_b[0] + d_b * of_b[1] + d_r * of_b[2]
        z = d_a * of_r[0] + d_b * of_r[1] + d_r * of_r[2]
        diffuse += (x * d_a + y * d_b + z * d_r) / 3.0
        both += (x * f_a + y * f_b + z * f_r) / 3.0
        x = f_a * of_a[0] + f_b * of_a[1] + f_r * of_a[2]
        y = f_a * of_b[0] + f_b * of_b[1] + f_r * of_b[2]
        z = f_a * of_r[0] + f_b * of_r[1] + f_r * of_r[2]
        specular += (x * f_a + y * f_b + z * f_r) / 3.0
    row[VAR_DIFFUSE], row[VAR_SPECULAR], row[COV_REFLECTANCE] = strength * diffuse, strength * specular, strength * both


@scalar
def _start(
    value: Floats,
    grey: Floats,
    is_usable: Bools,
    lamp: Floats,
    across_free: bool,
    prior: Floats,
    lambertian: bool,
    mean: float,
    weight: Floats,
    lobe: Floats,
    products: Floats,
    row: Floats,
) -> tuple[float, float, float]:
    """Slopes and roughness from which to refine, with their ρ and F in `row`: those of the least absolute residuals.

    Slopes are those of the Lambertian fit, or of the mean half vector weighted with the square of radiance, which is
    near the normal where highlights are all that is seen; where the prior says little of the roughness, three more are
    tried. `weight` leaves out shadows.
    """
    count = len(grey)
    half_x, half_y, half_z = 0.0, 0.0, 1e-30
    for i in range(count):
        if is_usable[i]:
            strength = 1.0 / lamp[3, i]
            square = lamp[6, i] * grey[i] * grey[i] * lamp[4, i] / strength
            half_x, half_y = half_x + square * lamp[0, i], half_y + square * lamp[1, i]
            half_z += square * (lamp[2, i] + strength)
    first_a, first_b, second_a, second_b = row[A], row[B], half_x / half_z, half_y / half_z
    if not across_free:
        second_b = 0.0
    kept = row[DIFFUSE:VAR_A].copy()
    best, a, b, roughness = np.inf, first_a, first_b, prior[0]
    tries = 4 if prior[1] > UNKNOWN_ROUGHNESS else 1
    for trial in range(1 if lambertian else 2 * tries):
        tried = prior[0] if trial % tries == 0 else 0.3 * (trial % tries)
        tried_a, tried_b = (first_a, first_b) if trial < tries else (second_a, second_b)
        evaluate(tried_a, tried_b, tried, lamp, prior[4:], lobe)
        for i in range(count):
            weight[i] = 1.0 / (max(grey[i], 0.0) + DARK * mean) if is_usable[i] else 0.0
        for turn in range(2):
            _sum_up(value, weight, lobe, 2, products)
            _reflectance(value, weight, products, prior, 1e-4 * mean, lambertian, row)
            residual = 0.0
            for i in range(count):
                model, off = 0.0, 0.0
                for channel in range(3):
                    shown = row[DIFFUSE + channel] * lobe[C, i] + row[SPECULAR + channel] * lobe[S, i]
                    model += shown / 3.0
                    off += abs(value[channel, i] - shown)
                if is_usable[i]:
                    residual += off / math.sqrt(max(grey[i], 0.0) + DARK * mean)
                if turn == 0 and grey[i] < 0.5 * model:
                    weight[i] = 0.0
        if residual < best:
            best, a, b, roughness = residual, tried_a, tried_b, tried
            kept[:] = row[DIFFUSE:VAR_A]
    row[DIFFUSE:VAR_A] = kept
    evaluate(a, b, roughness, lamp, prior[4:], lobe)
    return a, b, roughness


@scalar
def _normal_equations(
    products: Floats,
    prior: Floats,
    strength: float,
    across_free: bool,
    lambertian: bool,
    a: float,
    b: float,
    roughness: float,
    row: Floats,
) -> tuple[float, ...]:
    """The 3 × 3 system of slopes and roughness without ρ and F, its upper triangle and its right side."""
    cc, cs, ss = products[C, C], products[C, S], products[S, S] + strength / (prior[3] * prior[3])
    aa, ab, ar, bb, br, rr, ga, gb, gr = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    determinant = cc * ss - cs * cs
    both = determinant > 1e-12 * cc * ss and not lambertian
    m = products
    for channel in range(3):
        d, f = row[DIFFUSE + channel], row[SPECULAR + channel]
        a_c, a_s = d * m[C, C_A] + f * m[C, S_A], d * m[S, C_A] + f * m[S, S_A]
        b_c, b_s = d * m[C, C_B] + f * m[C, S_B], d * m[S, C_B] + f * m[S, S_B]
        r_c, r_s = f * m[C, S_R], f * m[S, S_R]
        at = 7 + channel
        ga += d * m[C_A, at] + f * m[S_A, at] - d * a_c - f * a_s
        gb += d * m[C_B, at] + f * m[S_B, at] - d * b_c - f * b_s
        gr += f * m[S_R, at] - d * r_c - f * r_s
        # what is at its bound of zero cannot take up a change of slope
        if both and d > 0.0 and f > 0.0:
            p, q, r = ss / determinant, -cs / determinant, cc / determinant
        elif d > 0.0:
            p, q, r = 1.0 / max(cc, 1e-30), 0.0, 0.0
        else:
            p, q, r = 0.0, 0.0, 1.0 / max(ss, 1e-30)
        aa += d * d * m[C_A, C_A] + 2.0 * d * f * m[C_A, S_A] + f * f * m[S_A, S_A]
        ab += d * d * m[C_A, C_B] + d * f * (m[C_A, S_B] + m[S_A, C_B]) + f * f * m[S_A, S_B]
        ar += f * (d * m[C_A, S_R] + f * m[S_A, S_R])
        bb += d * d * m[C_B, C_B] + 2.0 * d * f * m[C_B, S_B] + f * f * m[S_B, S_B]
        br += f * (d * m[C_B, S_R] + f * m[S_B, S_R])
        rr += f * f * m[S_R, S_R]
        u, v = p * a_c + q * a_s, q * a_c + r * a_s
        aa, ab, ar = aa - u * a_c - v * a_s, ab - u * b_c - v * b_s, ar - u * r_c - v * r_s
        u, v = p * b_c + q * b_s, q * b_c + r * b_s
        bb, br = bb - u * b_c - v * b_s, br - u * r_c - v * r_s
        rr -= (p * r_c + q * r_s) * r_c + (q * r_c + r * r_s) * r_s
    # slopes of more than 60° are rare
    aa, ga = aa + strength / 4.0, ga - strength / 4.0 * a
    bb, gb = bb + strength / 4.0, gb - strength / 4.0 * b
    own = strength / (prior[1] * prior[1])
    rr, gr = rr + own, gr + own * (prior[0] - roughness)
    if not across_free:
        ab, br, gb = 0.0, 0.0, 0.0
    return aa, ab, ar, bb, br, rr, ga, gb, gr
