"""Kernels of the equation for the height, which pass over arrays once and make none.

All are bound by memory, and on one thread: where other programs run, threads that wait for each other take longer. Sums
have one order, where those of a BLAS depend on its threads.
"""

from __future__ import annotations

import math

import numpy as np

from engine.core.kernels import scalar


@scalar
def apply_normal(across: np.ndarray, down: np.ndarray, height: np.ndarray, result: np.ndarray) -> None:
    """Write Dᵀ W D h of a height (H, W), by the weights `across` (H, W − 1) and `down` (H − 1, W), as `result`."""
    rows, columns = height.shape
    for row in range(rows):
        own, target = height[row], result[row]
        target[0] = 0.0
        for column in range(1, columns):
            target[column] = across[row, column - 1] * (own[column] - own[column - 1])
        for column in range(columns - 1):
            target[column] -= across[row, column] * (own[column + 1] - own[column])
        if row > 0:
            for column in range(columns):
                target[column] += down[row - 1, column] * (own[column] - height[row - 1, column])
        if row < rows - 1:
            for column in range(columns):
                target[column] -= down[row, column] * (height[row + 1, column] - own[column])


def sum_products(one: np.ndarray, other: np.ndarray) -> float:
    """The sum of the products of two arrays (H, W)."""
    by_row = np.empty(len(one))
    _sum_products(one, other, by_row)
    return float(by_row.sum())


@scalar
def _sum_products(one: np.ndarray, other: np.ndarray, by_row: np.ndarray) -> None:
    for row in range(one.shape[0]):
        total = 0.0
        for column in range(one.shape[1]):
            total += one[row, column] * other[row, column]
        by_row[row] = total


@scalar
def add_product(target: np.ndarray, factor: float, other: np.ndarray) -> None:
    """Add `factor` times an array (H, W) to another."""
    for row in range(target.shape[0]):
        for column in range(target.shape[1]):
            target[row, column] += factor * other[row, column]


@scalar
def divide_by_eigenvalues(spectrum: np.ndarray, first: int, last: int) -> None:
    """Divide columns `first` to `last` of the cosine transform (H, W) of a flow by the eigenvalues of Dᵀ D; the mean,
    which is open, becomes 0."""
    rows, columns = spectrum.shape
    by_column = np.empty(last - first)
    for column in range(first, last):
        by_column[column - first] = _eigenvalue(column, columns)
    for row in range(rows):
        of_row = _eigenvalue(row, rows)
        for column in range(first, last):
            value = of_row + by_column[column - first]
            spectrum[row, column] = spectrum[row, column] * (1.0 / value) if value > 0.0 else 0.0


@scalar
def _eigenvalue(number: int, count: int) -> float:
    return 2.0 - 2.0 * math.cos(math.pi * number / count)
