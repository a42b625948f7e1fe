"""Kernel that finds the slope and the reflectance of each texel from its radiance under all lamps.

The model of a texel of slopes (a, b) = (n_x, n_y) / n_z under the light v of lamp i, seen from straight above, is

    I_i = ρ c_i + F s_i,   c = max(n·v, 0),   s = π D G₂ / (4 n·l n·v) c

with GGX and Smith's height-correlated shadowing (Heitz2014 Eq. 99) of alpha = roughness²; v has the length of the
irradiance over π. Schlick's term is left out: seen from above it is below 2·10⁻³ for lamps at 5° and more.

1. Lambertian and robust. The fifth of the photographs that is darkest in the texel (shadows) and the fifth that is
   brightest (highlights) are left out by rank; then least squares, reweighted with Tukey's biweight, which ends at
   3 deviations below the fit and at 2 above it. The deviation is 1.4826 times the median of the absolute residuals.
2. All parameters by Levenberg-Marquardt, from these slopes or from the direction of the highlight. ρ and F of each
   channel are linear and are eliminated from the normal equations (Golub1973), so that a 3 × 3 system for a, b and the
   roughness remains. Residuals are divided by the root of the model, as photons scatter, and reweighted by the biweight
   that ends at 4 deviations.
3. Covariances are the inverse of the normal equations, times the square of the deviation.

Roughness and F have priors, a mean and a deviation, which speak where the photographs do not.
Bound by arithmetic: four evaluations of GGX for each lamp and iteration, some 0.2 ms of one core for 40 lamps.
"""

from __future__ import annotations

import math

import numpy as np

from engine.core.kernels import parallel, prange, scalar

#: Columns of the result: slopes, roughness, ρ, F, variances of the slopes and their covariance, variances of the
#: roughness, ρ and F, covariance of ρ and F, and the deviation of a residual.
A, B, ROUGHNESS, DIFFUSE, SPECULAR = 0, 1, 2, 3, 6
VAR_A, VAR_B, COV_AB, VAR_ROUGHNESS, VAR_DIFFUSE, VAR_SPECULAR, COV_REFLECTANCE, DEVIATION = range(9, 17)
COLUMNS = 17

#: Slopes of more than 80° and roughness below what a lamp of one degree shows are not told.
STEEPEST, LEAST_ROUGHNESS = 5.67, 0.12

#: The least deviation of a residual over the root of the mean radiance, and what counts as dark, over the mean.
LEAST_DEVIATION, DARK = 2e-3, 0.05

ITERATIONS = 14


@parallel
def fit_texels(values, usable, lights, across_free, priors, kind, lambertian, found):  # type: ignore[no-untyped-def]
    """Fill `found` (T, COLUMNS) float64.

    `values` (N, T, 3) float32 radiance, `usable` (N, T) bool, `lights` (N, T or 1, 3) float64, `priors` (K, 4) means
    and deviations of roughness and F, `kind` (T,) which of them a texel has. Where `across_free` is False, b is zero.
    Where `lambertian` is True, F is zero.
    """
    count, texels = usable.shape
    rows = 64
    for chunk in prange((texels + rows - 1) // rows):
        value, light = np.empty((count, 3)), np.empty((count, 3))
        grey, weight, sorting = np.empty(count), np.empty(count), np.empty(count)
        work = np.empty((count, 10))
        is_usable = np.empty(count, np.bool_)
        for texel in range(chunk * rows, min(texels, (chunk + 1) * rows)):
            place = texel if lights.shape[1] > 1 else 0
            for i in range(count):
                is_usable[i] = usable[i, texel]
                for axis in range(3):
                    value[i, axis] = values[i, texel, axis]
                    light[i, axis] = lights[i, place, axis]
                grey[i] = (value[i, 0] + value[i, 1] + value[i, 2]) / 3.0
            row = found[texel]
            _lambertian(grey, is_usable, light, across_free, weight, sorting, row)
            _refine(
                value, grey, is_usable, light, across_free, priors[kind[texel]], lambertian, weight, sorting, work, row
            )


@scalar
def lobes(a, b, alpha, x, y, z):  # type: ignore[no-untyped-def]
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
def median(values, count):  # type: ignore[no-untyped-def]
    """The median of the first `count` values, which are reordered (quickselect, Hoare1961)."""
    target, low, high = count // 2, 0, count - 1
    while low < high:
        pivot, i, j = values[(low + high) // 2], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if target <= j:
            high = j
        elif target >= i:
            low = i
        else:
            break
    return values[target]


@scalar
def _lambertian(grey, is_usable, light, across_free, weight, sorting, row):  # type: ignore[no-untyped-def]
    """Slopes of the robust Lambertian fit, into `row`; `weight` is then zero for shadows, highlights and clipping."""
    count, kept = len(grey), 0
    for i in range(count):
        if is_usable[i]:
            sorting[kept] = grey[i]
            kept += 1
    ranked = np.sort(sorting[:kept])
    tail = kept // 5 if kept - 2 * (kept // 5) >= 4 else 0
    row[A], row[B] = 0.0, 0.0
    for i in range(count):
        weight[i] = 0.0
        if is_usable[i] and (tail == 0 or ranked[tail] <= grey[i] <= ranked[kept - 1 - tail]):
            weight[i] = 1.0
    for _ in range(10):
        xx, xy, xz, yy, yz, zz, xg, yg, zg = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(count):
            x, y, z, w = light[i, 0], light[i, 1] if across_free else 0.0, light[i, 2], weight[i]
            xx, xy, xz, yy, yz, zz = (
                xx + w * x * x,
                xy + w * x * y,
                xz + w * x * z,
                yy + w * y * y,
                yz + w * y * z,
                (zz + w * z * z),
            )
            xg, yg, zg = xg + w * x * grey[i], yg + w * y * grey[i], zg + w * z * grey[i]
        least = 1e-7 * (xx + yy + zz) + 1e-30
        x, y, z = _solved(xx + least, xy, xz, yy + least, yz, zz + least, xg, yg, zg)
        kept = 0
        for i in range(count):
            fitted = x * light[i, 0] + y * light[i, 1] + z * light[i, 2]
            if is_usable[i] and fitted > 0.0:
                sorting[kept] = abs(grey[i] - fitted)
                kept += 1
        if kept < 5 or z <= 0.0:
            break
        deviation = 1.4826 * median(sorting, kept) + 1e-7 * z
        for i in range(count):
            fitted = x * light[i, 0] + y * light[i, 1] + z * light[i, 2]
            off = grey[i] - fitted
            off /= deviation * (3.0 if off < 0.0 else 2.0)
            weight[i] = (1.0 - off * off) ** 2 if is_usable[i] and fitted > 0.0 and abs(off) < 1.0 else 0.0
    if z > 0.0:
        row[A] = min(max(x / z, -STEEPEST), STEEPEST)
        row[B] = min(max(y / z, -STEEPEST), STEEPEST)


@scalar
def _solved(xx, xy, xz, yy, yz, zz, x, y, z):  # type: ignore[no-untyped-def]
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
def _reflectance(value, weight, work, prior, strength, lambertian, row):  # type: ignore[no-untyped-def]
    """ρ and F, zero or more, of each channel by least squares, into `row`; returns the weighted squares.

    `work` holds c and s in its first columns, `strength` is the variance of a residual, in whose unit the prior is.
    """
    cc, cs, ss = 0.0, 0.0, 0.0
    for i in range(len(weight)):
        w, c, s = weight[i], work[i, 0], work[i, 1]
        cc, cs, ss = cc + w * c * c, cs + w * c * s, ss + w * s * s
    own = strength / (prior[3] * prior[3])
    squares = 0.0
    for channel in range(3):
        cv, sv = 0.0, 0.0
        for i in range(len(weight)):
            wv = weight[i] * value[i, channel]
            cv, sv = cv + wv * work[i, 0], sv + wv * work[i, 1]
        sv += own * prior[2]
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
        for i in range(len(weight)):
            off = value[i, channel] - diffuse * work[i, 0] - specular * work[i, 1]
            squares += weight[i] * off * off
    return squares


@scalar
def _evaluate(a, b, roughness, light, work, column):  # type: ignore[no-untyped-def]
    for i in range(len(light)):
        work[i, column], work[i, column + 1] = lobes(a, b, roughness * roughness, light[i, 0], light[i, 1], light[i, 2])


@scalar
def _reweigh(value, is_usable, mean, weight, sorting, work, row):  # type: ignore[no-untyped-def]
    """The biweight of each photograph over the variance of its photons; returns the deviation of a residual."""
    count, kept = len(weight), 0
    for i in range(count):
        model, off = 0.0, 0.0
        for channel in range(3):
            shown = row[DIFFUSE + channel] * work[i, 0] + row[SPECULAR + channel] * work[i, 1]
            model += shown / 3.0
            off += (value[i, channel] - shown) / 3.0
        work[i, 8] = 1.0 / (model + DARK * mean + 1e-9)
        work[i, 9] = off * math.sqrt(work[i, 8])
        if is_usable[i] and work[i, 0] > 0.0:
            sorting[kept] = abs(work[i, 9])
            kept += 1
    least = LEAST_DEVIATION * math.sqrt(mean + 1e-9)
    deviation = max(1.4826 * median(sorting, kept), least) if kept > 4 else 10.0 * least
    for i in range(count):
        off = work[i, 9] / (4.0 * deviation)
        weight[i] = (1.0 - off * off) ** 2 * work[i, 8] if is_usable[i] and abs(off) < 1.0 else 0.0
    return deviation


@scalar
def _refine(value, grey, is_usable, light, across_free, prior, lambertian, weight, sorting, work, row):  # type: ignore[no-untyped-def]
    """All parameters of a texel and their covariances, into `row`."""
    count, mean, kept = len(grey), 0.0, 0
    a, b, roughness = row[A], row[B], prior[0]
    for i in range(count):
        if is_usable[i]:
            mean += max(grey[i], 0.0)
            kept += 1
    mean /= max(kept, 1)
    row[VAR_A:] = np.inf
    row[ROUGHNESS], row[DEVIATION] = roughness, 0.0
    row[DIFFUSE:VAR_A] = 0.0
    if mean <= 1e-6:
        row[A], row[B] = 0.0, 0.0
        return
    a, b, roughness = _start(value, grey, is_usable, light, across_free, prior, lambertian, mean, weight, work, row)
    damping, h, deviation = 1e-2, 1e-4, 0.0
    trial = row.copy()
    for iteration in range(ITERATIONS):
        deviation = _reweigh(value, is_usable, mean, weight, sorting, work, row)
        strength = 3.0 * deviation * deviation
        before = _reflectance(value, weight, work, prior, strength, lambertian, row)
        before += strength * ((roughness - prior[0]) / prior[1]) ** 2
        _evaluate(a + h, b, roughness, light, work, 2)
        _evaluate(a, b + h, roughness, light, work, 4)
        _evaluate(a, b, roughness + h, light, work, 6)
        system = _normal_equations(value, weight, work, prior, strength, across_free, lambertian, roughness, row)
        aa, ab, ar, bb, br, rr, ga, gb, gr = system
        up = 1.0 + damping
        da, db, dr = _solved(aa * up, ab, ar, bb * up, br, rr * up, ga, gb, gr)
        da, db, dr = min(max(da, -0.3), 0.3), min(max(db, -0.3), 0.3), min(max(dr, -0.15), 0.15)
        new_a, new_b = min(max(a + da, -STEEPEST), STEEPEST), min(max(b + db, -STEEPEST), STEEPEST)
        new_r = min(max(roughness + dr, LEAST_ROUGHNESS), 1.0)
        _evaluate(new_a, new_b, new_r, light, work, 0)
        after = _reflectance(value, weight, work, prior, strength, lambertian, trial)
        after += strength * ((new_r - prior[0]) / prior[1]) ** 2
        if after <= before or iteration == 0:
            a, b, roughness = new_a, new_b, new_r
            row[DIFFUSE:VAR_A] = trial[DIFFUSE:VAR_A]
            damping *= 0.3
            if after > (1.0 - 1e-5) * before and iteration > 2 and abs(da) + abs(db) < 1e-4:
                break
        else:
            _evaluate(a, b, roughness, light, work, 0)
            damping = 10.0 * damping + 1e-3
            if damping > 1e3:
                break
    deviation = _reweigh(value, is_usable, mean, weight, sorting, work, row)
    strength = 3.0 * deviation * deviation
    _evaluate(a + h, b, roughness, light, work, 2)
    _evaluate(a, b + h, roughness, light, work, 4)
    _evaluate(a, b, roughness + h, light, work, 6)
    system = _normal_equations(value, weight, work, prior, strength, across_free, lambertian, roughness, row)
    aa, ab, ar, bb, br, rr = system[:6]
    row[A], row[B], row[ROUGHNESS], row[DEVIATION] = a, b, roughness, deviation
    first = _solved(aa, ab, ar, bb, br, rr, 1.0, 0.0, 0.0)
    second = _solved(aa, ab, ar, bb, br, rr, 0.0, 1.0, 0.0)
    third = _solved(aa, ab, ar, bb, br, rr, 0.0, 0.0, 1.0)
    row[VAR_A], row[COV_AB], row[VAR_B] = strength * first[0], strength * first[1], strength * second[1]
    row[VAR_ROUGHNESS] = strength * third[2]
    cc, cs, ss = 0.0, 0.0, strength / (prior[3] * prior[3])
    for i in range(count):
        w, c, s = weight[i], work[i, 0], work[i, 1]
        cc, cs, ss = cc + w * c * c, cs + w * c * s, ss + w * s * s
    determinant = cc * ss - cs * cs
    if determinant > 0.0:
        row[VAR_DIFFUSE], row[VAR_SPECULAR] = strength * ss / determinant, strength * cc / determinant
        row[COV_REFLECTANCE] = -strength * cs / determinant
    if lambertian and cc > 0.0:
        row[VAR_DIFFUSE], row[VAR_SPECULAR], row[COV_REFLECTANCE] = strength / cc, prior[3] ** 2, 0.0


@scalar
def _start(value, grey, is_usable, light, across_free, prior, lambertian, mean, weight, work, row):  # type: ignore[no-untyped-def]
    """Slopes and roughness from which to refine, with their ρ and F in `row`: those of the least absolute residuals.

    Slopes are those of the Lambertian fit, or of the mean half vector weighted with the square of radiance, which is
    near the normal where highlights are all that is seen. `weight` leaves out shadows.
    """
    count = len(grey)
    half_x, half_y, half_z = 0.0, 0.0, 1e-30
    for i in range(count):
        if is_usable[i]:
            x, y, z = light[i, 0], light[i, 1], light[i, 2]
            strength = math.sqrt(x * x + y * y + z * z)
            square = grey[i] * grey[i] / math.sqrt(2.0 * strength * (strength + z))
            half_x, half_y, half_z = half_x + square * x, half_y + square * y, half_z + square * (z + strength)
    first_a, first_b, second_a, second_b = row[A], row[B], half_x / half_z, half_y / half_z
    if not across_free:
        second_b = 0.0
    kept = row[DIFFUSE:VAR_A].copy()
    best, a, b, roughness = np.inf, first_a, first_b, prior[0]
    for trial in range(1 if lambertian else 8):
        tried = prior[0] if trial % 4 == 0 else 0.1 + 0.2 * (trial % 4)
        tried_a, tried_b = (first_a, first_b) if trial < 4 else (second_a, second_b)
        _evaluate(tried_a, tried_b, tried, light, work, 0)
        for i in range(count):
            weight[i] = 1.0 / (max(grey[i], 0.0) + DARK * mean) if is_usable[i] else 0.0
        for turn in range(2):
            _reflectance(value, weight, work, prior, 1e-4 * mean, lambertian, row)
            residual = 0.0
            for i in range(count):
                model, off = 0.0, 0.0
                for channel in range(3):
                    shown = row[DIFFUSE + channel] * work[i, 0] + row[SPECULAR + channel] * work[i, 1]
                    model += shown / 3.0
                    off += abs(value[i, channel] - shown)
                if is_usable[i]:
                    residual += off / math.sqrt(max(grey[i], 0.0) + DARK * mean)
                if turn == 0 and grey[i] < 0.5 * model:
                    weight[i] = 0.0
        if residual < best:
            best, a, b, roughness = residual, tried_a, tried_b, tried
            kept[:] = row[DIFFUSE:VAR_A]
    row[DIFFUSE:VAR_A] = kept
    _evaluate(a, b, roughness, light, work, 0)
    return a, b, roughness


@scalar
def _normal_equations(value, weight, work, prior, strength, across_free, lambertian, roughness, row):  # type: ignore[no-untyped-def]
    """The 3 × 3 system of slopes and roughness without ρ and F, its upper triangle and its right side.

    Columns of `work`: c and s at the place, then beside it in a, b and roughness, from which derivatives follow.
    """
    cc, cs, ss = 0.0, 0.0, strength / (prior[3] * prior[3])
    aa, ab, ar, bb, br, rr, ga, gb, gr = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    mixed = np.zeros((3, 6))
    for i in range(len(weight)):
        w = weight[i]
        if w == 0.0:
            continue
        c, s = work[i, 0], work[i, 1]
        cc, cs, ss = cc + w * c * c, cs + w * c * s, ss + w * s * s
        c_a, s_a = (work[i, 2] - c) * 1e4, (work[i, 3] - s) * 1e4
        c_b, s_b, s_r = (work[i, 4] - c) * 1e4, (work[i, 5] - s) * 1e4, (work[i, 7] - s) * 1e4
        for channel in range(3):
            diffuse, specular = row[DIFFUSE + channel], row[SPECULAR + channel]
            d_a, d_b, d_r = diffuse * c_a + specular * s_a, diffuse * c_b + specular * s_b, specular * s_r
            off = value[i, channel] - diffuse * c - specular * s
            aa, ab, ar, bb, br, rr = (
                aa + w * d_a * d_a,
                ab + w * d_a * d_b,
                ar + w * d_a * d_r,
                bb + w * d_b * d_b,
                (br + w * d_b * d_r),
                (rr + w * d_r * d_r),
            )
            ga, gb, gr = ga + w * d_a * off, gb + w * d_b * off, gr + w * d_r * off
            mixed[channel, 0] += w * d_a * c
            mixed[channel, 1] += w * d_a * s
            mixed[channel, 2] += w * d_b * c
            mixed[channel, 3] += w * d_b * s
            mixed[channel, 4] += w * d_r * c
            mixed[channel, 5] += w * d_r * s
    determinant = cc * ss - cs * cs
    both = determinant > 1e-12 * cc * ss and not lambertian
    for channel in range(3):
        m = mixed[channel]
        # what is at its bound of zero cannot take up a change of slope
        free = both and row[DIFFUSE + channel] > 0.0 and row[SPECULAR + channel] > 0.0
        if free:
            p, q, r = ss / determinant, -cs / determinant, cc / determinant
        elif row[DIFFUSE + channel] > 0.0:
            p, q, r = 1.0 / max(cc, 1e-30), 0.0, 0.0
        else:
            p, q, r = 0.0, 0.0, 1.0 / max(ss, 1e-30)
        ac, as_ = p * m[0] + q * m[1], q * m[0] + r * m[1]
        bc, bs = p * m[2] + q * m[3], q * m[2] + r * m[3]
        rc, rs = p * m[4] + q * m[5], q * m[4] + r * m[5]
        aa -= ac * m[0] + as_ * m[1]
        ab -= ac * m[2] + as_ * m[3]
        ar -= ac * m[4] + as_ * m[5]
        bb -= bc * m[2] + bs * m[3]
        br -= bc * m[4] + bs * m[5]
        rr -= rc * m[4] + rs * m[5]
    # slopes of more than 60° are rare
    aa, ga = aa + strength / 4.0, ga - strength / 4.0 * row[A]
    bb, gb = bb + strength / 4.0, gb - strength / 4.0 * row[B]
    own = strength / (prior[1] * prior[1])
    rr, gr = rr + own, gr + own * (prior[0] - roughness)
    if not across_free:
        ab, br, gb = 0.0, 0.0, 0.0
    return aa, ab, ar, bb, br, rr, ga, gb, gr
