"""The Cholesky factor of a dense symmetric matrix, what is solved with it, and its condition.

Our own and not LAPACK's, whose bits depend on its threads: a search tries several projections at once, one per thread.
"""

from __future__ import annotations

import numpy as np

from engine.kernels import scalar

_PANEL = 8


@scalar
def cholesky(a):  # type: ignore[no-untyped-def]
    """Replace the lower triangle of a symmetric matrix by its factor; returns how many leading rows failed, or 0.

    Panels of eight columns, so that the rest of the matrix is passed over once for eight of them.
    """
    n = len(a)
    rows = np.zeros((_PANEL, n))
    for first in range(0, n, _PANEL):
        last = min(first + _PANEL, n)
        for i in range(first, n):
            for k in range(first, min(i + 1, last)):
                s = a[i, k]
                for m in range(first, k):
                    s -= a[i, m] * a[k, m]
                if i == k:
                    if not s > 0.0:
                        return k + 1
                    a[k, k] = np.sqrt(s)
                else:
                    a[i, k] = s / a[k, k]
        for k in range(first, last):
            for i in range(last, n):
                rows[k - first, i] = a[i, k]
        r0, r1, r2, r3, r4, r5, r6, r7 = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5], rows[6], rows[7]
        for i in range(last, n):
            p0, p1, p2, p3, p4, p5, p6, p7 = r0[i], r1[i], r2[i], r3[i], r4[i], r5[i], r6[i], r7[i]
            row = a[i]
            for j in range(last, i + 1):
                row[j] -= ((p0 * r0[j] + p1 * r1[j]) + (p2 * r2[j] + p3 * r3[j])) + (
                    (p4 * r4[j] + p5 * r5[j]) + (p6 * r6[j] + p7 * r7[j])
                )
    return 0


@scalar
def substituted(factor, right):  # type: ignore[no-untyped-def]
    """x (n, m) with F Fᵀ x = right (n, m)."""
    x = right.copy()
    n, m = x.shape
    for i in range(n):
        for c in range(m):
            s = x[i, c]
            for k in range(i):
                s -= factor[i, k] * x[k, c]
            x[i, c] = s / factor[i, i]
    for i in range(n - 1, -1, -1):
        for c in range(m):
            x[i, c] /= factor[i, i]
        for k in range(i):
            for c in range(m):
                x[k, c] -= factor[i, k] * x[i, c]
    return x


@scalar
def largest_eigenvalue(lower):  # type: ignore[no-untyped-def]
    """That of a symmetric positive matrix given by its lower triangle, from below, by 20 power iterations."""
    n = len(lower)
    x = np.ones(n) / np.sqrt(n)
    length = 0.0
    for _ in range(20):
        y = np.zeros(n)
        for i in range(n):
            s = lower[i, i] * x[i]
            for k in range(i):
                s += lower[i, k] * x[k]
                y[k] += lower[i, k] * x[i]
            y[i] += s
        length = 0.0
        for i in range(n):
            length += y[i] * y[i]
        length = np.sqrt(length)
        x = y / length
    return length


@scalar
def largest_of_inverse(factor):  # type: ignore[no-untyped-def]
    """The same of the inverse of a matrix given by its Cholesky factor."""
    n = len(factor)
    x = np.empty((n, 1))
    for i in range(n):
        x[i, 0] = 1.0 if i % 2 else -0.7
    length = 0.0
    for _ in range(20):
        x = substituted(factor, x)
        length = 0.0
        for i in range(n):
            length += x[i, 0] * x[i, 0]
        length = np.sqrt(length)
        x = x / length
    return length
