"""Parallel cylinders on a floor, which shadow and mask each other (Poulin1990).

The surface is brushed along the tangent x: cylinders of radius 1 at distance `spacing`, their axes at height 0, stand
out of a floor at height `floor`. Cylinders and floor reflect by the modified Phong model about their own normal, and

    f = 1/(spacing n·l n·v) ∫ f_phong(n; wi, wo) (n·wi) (n·wo) ds

over what both directions see of one period of the profile, where ds is the length along it. Occlusion is exact: in
the plane across the cylinders a direction of elevation ε sees of a cylinder the angles from −ε, where the surface turns
away, to 2 asin √(spacing sin ε / 2) − ε, where the neighbour's shadow begins, and of the floor what lies beyond
(1 − floor cos ε)/sin ε of the neighbour's axis. Both are intervals, so what two directions see is one.

On the cylinder with normal angle φ, δ = φ − φ̄ from the bisector of the two directions in that plane, at which they
enclose 2 acos c, and with A the product of their lengths there, (n·wi)(n·wo) = A (c² − sin² δ), and 1 − r·wo is
((wi_x + wo_x)² + (|wi| − |wo|)²)/2 + 2 A sin² δ with the lengths in that plane. Gauss–Legendre quadrature is over
tan(φ/2) for the diffuse part, and over tan(δ/2) for the highlight where that is above e⁻¹⁸ of its peak; the relative
error is below 1e-6. Angles are kept as cosine and sine throughout, so that nothing depends on the accuracy of inverse
functions in shaders.

Light that is reflected between cylinders is left out, as in the paper. What bounds the time is the power at the nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.cylinder_kernel import fill
from engine.brdf.models.evaluate import channels, reflects_no_more_than_it_receives
from engine.brdf.models.model import Model
from engine.core.params import Colour, param

Floats = NDArray[np.float64]

#: Gauss–Legendre nodes within (0, 1) and their weights, for highlights and for diffuse parts; the other half mirrors.
HIGHLIGHT_NODES, HIGHLIGHT_WEIGHTS = (half[9:] for half in np.polynomial.legendre.leggauss(18))
DIFFUSE_NODES, DIFFUSE_WEIGHTS = (half[6:] for half in np.polynomial.legendre.leggauss(12))


@dataclass(frozen=True)
class PoulinFournier(Model):
    """Parallel cylinders along the tangent; anisotropic, as brushed metal, satin or grooves. See the module."""

    name: ClassVar[str] = "poulin-fournier"
    label: ClassVar[str] = "Poulin–Fournier"

    kd: Colour = param((0.3, 0.3, 0.3), 0.0, 1.0, doc="Diffuse reflectance of cylinders and floor.")
    ks: Colour = param((0.3, 0.3, 0.3), 0.0, 1.0, doc="Strength of their highlight.")
    exponent: float = param(40.0, 1.0, 1e6, doc="Sharpness of their highlight.", slider=(1.0, 1000.0), log=True)
    spacing: float = param(
        2.5, 2.0, 20.0, doc="Distance of the axes in radii; at 2 the cylinders touch.", slider=(2, 6)
    )
    floor: float = param(0.2, 0.0, 1.0, doc="Height of the floor above the axes in radii; at 1 it hides the cylinders.")

    isotropic: ClassVar[bool] = False

    @property
    def energy_conserving(self) -> bool:
        """Each point of the profile conserves energy, and what leaves it and is blocked is not counted."""
        return reflects_no_more_than_it_receives(self.kd, self.ks)

    def formula(self, wi: Floats, wo: Floats) -> Floats:
        diffuse, highlight = np.empty((2, wi.shape[1]))
        nodes = (HIGHLIGHT_NODES, HIGHLIGHT_WEIGHTS, DIFFUSE_NODES, DIFFUSE_WEIGHTS)
        fill(wi, wo, self.exponent, self.spacing, self.floor, *nodes, diffuse, highlight)
        lobe = (self.exponent + 2.0) / (2.0 * np.pi) * highlight
        return channels(self.kd) / np.pi * diffuse + channels(self.ks) * lobe
