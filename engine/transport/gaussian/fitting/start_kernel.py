"""The compiled loops of the Gaussian fit: where the lobes of a view may be before anything else is known.

One lobe after the other: at the peak of what the others leave over, or at its moments; then halves of a lobe, and a
narrow one in a wide one, as highlights with long tails want it. Each start takes a few steps, and the best is kept; of
a single lobe, which all of them lead to the same minimum, the best goes on as it is. A
mean that starts on the far side of a narrow lobe would have no slope to follow, so starts always come from the data.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar
from engine.transport.gaussian.fitting.lobes import NARROWEST, WIDEST_LOBE
from engine.transport.gaussian.fitting.view_kernel import copy_lobes, refine, tangents

Indices = NDArray[np.integer]
Floats = NDArray[np.floating]


@scalar
def guesses(
    direction: Floats,
    value: Floats,
    area: Floats,
    mean: Floats,
    sigma: Floats,
    weight: Floats,
    new_mean: Floats,
    new_sigma: Floats,
) -> bool:
    """Guesses for one more lobe: `new_mean` (2, 3) and `new_sigma` (2,) from the peak and from the moments.

    Both of what the lobes (L, …) leave over, summed over colours where it is positive; False where there is nothing.
    """
    highest, energy = 0.0, 0.0
    moment = np.zeros(3)
    for s in range(len(area)):
        left = value[s, 0] + value[s, 1] + value[s, 2]
        for lobe in range(len(sigma)):
            q = 0.0
            for axis in range(3):
                q += ((direction[s, axis] - mean[lobe, axis]) / sigma[lobe]) ** 2
            left -= (weight[lobe, 0] + weight[lobe, 1] + weight[lobe, 2]) * math.exp(-0.5 * q)
        if left <= 0.0:
            continue
        energy += area[s] * left
        for axis in range(3):
            moment[axis] += area[s] * left * direction[s, axis]
        if left > highest:
            highest = left
            for axis in range(3):
                new_mean[0, axis] = direction[s, axis]
    length = math.sqrt(moment[0] ** 2 + moment[1] ** 2 + moment[2] ** 2)
    if not (highest > 0.0 and length > 1e-9 * energy):
        return False
    for axis in range(3):
        new_mean[1, axis] = moment[axis] / length
    new_sigma[0] = min(max(math.sqrt(energy / (2.0 * math.pi * highest)), NARROWEST), WIDEST_LOBE)
    new_sigma[1] = min(max(math.sqrt(max(1.0 - length / energy, 0.0)), NARROWEST), WIDEST_LOBE)
    return True


@scalar
def longest_axis(direction: Floats, value: Floats, area: Floats, mean: Floats, sigma: float, axis: Floats) -> float:
    """Fill `axis` (3,) with the tangent along which the data under a lobe spreads most; its deviation in rad."""
    axes = np.empty((2, 3))
    tangents(mean, axes)
    total, first, second, mixed = 0.0, 0.0, 0.0, 0.0
    for s in range(len(area)):
        q, x, y = 0.0, 0.0, 0.0
        for k in range(3):
            q += ((direction[s, k] - mean[k]) / sigma) ** 2
            x += direction[s, k] * axes[0, k]
            y += direction[s, k] * axes[1, k]
        if q > 18.0:
            continue
        share = area[s] * (value[s, 0] + value[s, 1] + value[s, 2])
        total += share
        first += share * x * x
        second += share * y * y
        mixed += share * x * y
    angle = 0.5 * math.atan2(2.0 * mixed, first - second)
    for k in range(3):
        axis[k] = math.cos(angle) * axes[0, k] + math.sin(angle) * axes[1, k]
    spread = 0.5 * (first + second) + math.sqrt(0.25 * (first - second) ** 2 + mixed * mixed)
    return math.sqrt(spread / total) if total > 0.0 else sigma


@scalar
def start_view(
    direction: Floats,
    value: Floats,
    area: Floats,
    square: float,
    scale: float,
    given_mean: Floats,
    given_sigma: Floats,
    mean: Floats,
    sigma: Floats,
    weight: Floats,
    steps: Indices,
) -> float:
    """Fit one view (L, …) by itself, from the data and from the lobes given (K, L, …); returns its energy.

    `steps` are those of each start, and of the best one after that.
    """
    lobes = len(sigma)
    pull, arrangements = np.zeros((lobes + 1, 4)), np.zeros((0, 0, 3))
    trial_mean, trial_sigma, trial_weight = np.empty((lobes, 3)), np.empty(lobes), np.empty((lobes, 3))
    old_mean, old_sigma, old_weight = np.empty((lobes, 3)), np.empty(lobes), np.empty((lobes, 3))
    new_mean, new_sigma, axis = np.empty((2, 3)), np.empty(2), np.empty(3)
    lowest = np.inf
    for count in range(1, lobes + 1):
        old = count - 1
        copy_lobes(mean[:old], sigma[:old], weight[:old], old_mean, old_sigma, old_weight)
        lowest = np.inf
        tried = steps[0] if count > 1 else 0
        found = guesses(direction, value, area, old_mean[:old], old_sigma[:old], old_weight[:old], new_mean, new_sigma)
        given = len(given_sigma) if count == lobes else 0
        for way in range(2 + 2 * old + given):
            if way < 2 and not found:
                continue
            copy_lobes(old_mean[:old], old_sigma[:old], old_weight[:old], trial_mean, trial_sigma, trial_weight)
            if way < 2:
                copy_lobes(
                    new_mean[way : way + 1], new_sigma[way : way + 1], new_mean[way : way + 1], trial_mean[old:],
                    trial_sigma[old:], trial_weight[old:],
                )  # fmt: skip
            elif way < 2 + 2 * old:
                _divide(direction, value, area, (way - 2) // 2, way % 2, axis, trial_mean, trial_sigma, old)
            else:
                near = way - 2 - 2 * old
                copy_lobes(given_mean[near], given_sigma[near], given_mean[near], trial_mean, trial_sigma, trial_weight)
            energy = refine(
                direction, value, area, square, scale, pull[: count + 1], arrangements, trial_mean[:count],
                trial_sigma[:count], trial_weight[:count], tried,
            )[1]  # fmt: skip
            if energy < lowest:
                lowest = energy
                copy_lobes(trial_mean[:count], trial_sigma[:count], trial_weight[:count], mean, sigma, weight)
        lowest = refine(
            direction, value, area, square, scale, pull[: count + 1], arrangements, mean[:count], sigma[:count],
            weight[:count], steps[1] if count > 1 else max(steps[0], steps[1]),
        )[1]  # fmt: skip
    return lowest


@scalar
def _divide(
    direction: Floats,
    value: Floats,
    area: Floats,
    lobe: int,
    nested: int,
    axis: Floats,
    mean: Floats,
    sigma: Floats,
    new: int,
) -> None:
    """Make two of a `lobe`, the second at `new`: halves side by side, or a narrow one inside a wide one."""
    if nested:
        for k in range(3):
            mean[new, k] = mean[lobe, k]
        sigma[new] = max(0.5 * sigma[lobe], NARROWEST)
        sigma[lobe] = min(1.5 * sigma[lobe], WIDEST_LOBE)
        return
    spread = longest_axis(direction, value, area, mean[lobe], sigma[lobe], axis)
    away = min(0.7 * spread, 1.0)
    before, behind = 0.0, 0.0
    for k in range(3):
        middle = mean[lobe, k]
        mean[new, k], mean[lobe, k] = middle + away * axis[k], middle - away * axis[k]
        before += mean[new, k] ** 2
        behind += mean[lobe, k] ** 2
    for k in range(3):
        mean[new, k] /= math.sqrt(before)
        mean[lobe, k] /= math.sqrt(behind)
    sigma[lobe] = max(0.8 * sigma[lobe], NARROWEST)
    sigma[new] = sigma[lobe]
