"""The texels of a material in the light of a bake: self-shadowing and interreflection on a shading map or planes.

A shading map is looked up by r_j = sigma f_r cos(theta_j) of each light j (Kautz2004 Eq. 2), so that it needs the
lights one by one, and a bake has only their sum. What the bake knows is the share of the light that arrives. With B
the radiance that it finds for the BRDF, and B_0 what the same sum is where nothing is in the way of any light,

    L = sum_j S(r_j) E_j  ·  B / B_0 .

The first factor is the picture of the shading map, planes or PBR maps without shadows (`engine.render.direct`); with
S(r) = a r it is a B_0 / f, and L = a B / f: Lambertian texels are exact, under any light. So is a convex model, where
B = B_0, and one light that is seen or not. In between, lights that are shadowed are taken to meet the texels as those
do that are not: S is nonlinear, and with several lights its mean over the unshadowed ones differs from the whole mean.

B and B_0 are of the same spherical harmonics, so that what these leave out of the light cancels. Both tend to 0 where
the surface turns away from the light; there `FLOOR` keeps the ratio at 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Of the mean of B_0 over the model, added to both.
FLOOR = 0.01

Picture = NDArray[np.float32]


def shadowed(texels: Picture, baked: Picture, unshadowed: Picture) -> Picture:
    """The picture `texels` (H, W, 4), radiance times coverage and coverage, times `baked` over `unshadowed`."""
    covered = unshadowed[..., 3] > 0.0
    floor = FLOOR * float(unshadowed[covered][:, :3].mean(dtype=np.float64)) if covered.any() else 0.0
    if floor <= 0.0:
        return texels
    least = floor * unshadowed[..., 3:]
    below = np.where(covered[..., None], unshadowed[..., :3] + least, 1.0)
    share = np.where(covered[..., None], (baked[..., :3] + least) / below, 1.0)
    found = texels.copy()
    found[..., :3] = np.minimum(texels[..., :3] * share, np.finfo(np.float32).max)
    return found
