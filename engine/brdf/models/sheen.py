"""Sheen as glTF defines it: KHR_materials_sheen. GLSL counterpart: resources/shaders/brdf/sheen.glsl.

    f = c D V + base min(1 − m E(n·l), 1 − m E(n·v)),   m the largest channel of the colour c,   α = roughness²,
    D = (2 + 1/α) sin^(1/α) θ_h / 2π,   V = 1/((1 + Λ(n·l) + Λ(n·v)) 4 n·l n·v),

with Λ the fit of Estevez2017 to the shadowing of fibres and E the albedo of D V. The extension takes E from a table;
here it is a fit to quadrature, 0.004 off at most where it is below 1, and not below the lobe's own where that is
largest. D V is not normalised: below a roughness of 0.25 it reflects more than it receives at grazing angles, at 0.05
four times as much, and a base is left no less than nothing. Bound by arithmetic, some 0.2 µs a pair of directions.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: Least roughness that is drawn: that of a smoother sheen is within some 6 degrees of the horizon.
SMOOTHEST_SHEEN = 0.05

#: Least roughness at which no colour reflects more than it receives.
WITHIN_ONE = 0.3

#: The five numbers of Λ at α = 1 and at α = 0.
_ROUGH = np.array([21.5473, 3.82987, 0.19823, -1.97760, -4.32054])
_SMOOTH = np.array([25.3245, 3.32435, 0.16801, -1.27393, -4.85967])

#: Coefficients k of ln(E n·v (1 + Λ(n·v))) = Σ k xⁱ yʲ with x = 2 √(n·v) − 1 and y = 1 + ⅔ ln roughness.
_ALBEDO = np.array(
    [
        [-1.027, 0.852, -1.603, 1.332, -0.465],
        [-2.934, 4.791, -4.521, 3.071, -1.006],
        [-1.760, 4.150, -4.324, 1.785, 0.039],
        [-0.952, 2.289, -0.879, -1.329, 0.795],
        [-0.722, 0.668, 1.185, -0.717, -0.451],
        [-0.711, 0.447, -0.199, 1.539, -1.083],
        [-0.468, 0.461, -0.694, 1.009, -0.380],
    ]
)


def sheen(cosine_i: Floats, cosine_o: Floats, sine2_h: Floats, roughness: float, most: float) -> tuple[Any, Any]:
    """D V (n,) in 1/sr, and the share (n,) of what lies below that is left.

    Parameters
    ----------
    cosine_i, cosine_o : (n,) cosines towards the light and the viewer, above the horizon.
    sine2_h : (n,) sin² θ_h of the half vector.
    roughness : in [0, 1]; below 0.05 it is taken for 0.05. most : the largest channel of the colour.
    """
    rough = max(roughness, SMOOTHEST_SHEEN)
    alpha = rough * rough
    masked_i, masked_o = masking(cosine_i, alpha), masking(cosine_o, alpha)
    distribution = (2.0 + 1.0 / alpha) / (2.0 * np.pi) * np.power(sine2_h, 0.5 / alpha)
    lobe = distribution / ((1.0 + (masked_i + masked_o)) * (4.0 * cosine_i * cosine_o))
    albedo = np.maximum(_albedo(cosine_i, masked_i, rough), _albedo(cosine_o, masked_o, rough))
    return lobe, np.maximum(1.0 - most * albedo, 0.0)


def sheen_albedo(cosine: Floats, roughness: float) -> Floats:
    """E (n,), the share of light that white sheen reflects, for cosines (n,) in (0, 1]."""
    rough = max(roughness, SMOOTHEST_SHEEN)
    return _albedo(cosine, masking(cosine, rough * rough), rough)


def masking(cosine: Floats, alpha: float) -> Floats:
    """Λ (n,) for cosines (n,) in (0, 1]: the fit of Estevez2017, mirrored about 1/2."""
    a, b, c, d, e = _ROUGH + (_SMOOTH - _ROUGH) * (1.0 - alpha) ** 2
    is_low = cosine < 0.5
    x = np.where(is_low, cosine, np.maximum(1.0 - cosine, 0.0))
    exponent = a / (1.0 + b * x**c) + d * x + e
    middle = a / (1.0 + b * 0.5**c) + d * 0.5 + e
    return np.asarray(np.exp(np.where(is_low, exponent, 2.0 * middle - exponent)))


def _albedo(cosine: Floats, masked: Floats, roughness: ArrayLike) -> Floats:
    x, value = 2.0 * np.sqrt(cosine) - 1.0, np.zeros(())
    y = 1.0 + np.log(roughness) * (2.0 / 3.0)
    for row in _ALBEDO[::-1]:
        value = value * x + np.polyval(row[::-1], y)
    return np.asarray(np.exp(value) / (cosine * (1.0 + masked)))
