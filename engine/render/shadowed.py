"""Image of the texels of a material in the light of a bake: the self-shadowing and interreflection of the model.

A shading map is looked up by r_j = sigma f_r cos(theta_j) of each light j (Kautz2004 Eq. 2), so that it needs the
lights one by one, and a bake has only their sum B, for the BRDF f_r alone. What the texels add to the BRDF is seen
where nothing is in the way of any light: T = sum_j S(r_j) E_j with them, T_0 = sum_j f_r cos(theta_j) E_j without. So

    L = B · T / T_0 .

With S(r) = a r it is L = a sigma B: Lambertian texels are exact, under any light. So is a convex model, as far as the
bake is, for B = T_0 there; and one light that is seen or not. In between, lights that are shadowed are taken to meet
the texels as those do that are not: S is nonlinear, and with several lights its mean over all differs from that over
the unshadowed ones. PBR maps are drawn in the same way: T is of the BRDF of each texel, T_0 of the one at their mean,
which is the one that is baked.

Light beyond T_0 is interreflection, or an error of the bake: harmonics that ring about a narrow highlight. A texel
that is far brighter than the mean of all would paint with the latter, so that what is beyond T_0 is multiplied by at
most `MOST` times the T / T_0 of the whole image.

Highlights that the bake blurs, of smooth metals under few terms, are such an error, and relief seen from afar spreads T
over them: a metal of roughness 0.25 in harmonics of order 4 comes out 2.4 times too bright.

T and T_0 tend to 0 where the surface turns away from all lights, and what other parts of the model reflect still
arrives there. A share `FAINT` of the light is therefore taken to come from all sides in T and in T_0.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.colour import luminance
from engine.core.steps import Steps, part
from engine.render.direct import radiance
from engine.render.transported import image_of
from engine.scene.material import without_maps
from engine.scene.scene import Scene

#: Irradiance from all sides in T and T_0, over that of all lights.
FAINT = 0.01

#: Of a channel of T_0, over its luminance: the least that T is divided by.
MINIMUM = 1e-3

#: Of T / T_0 for light beyond T_0, over that of the whole image.
MAXIMUM = 2.0

Image = NDArray[np.float32]


def with_and_without(scene: Scene, baked: Brdf | None = None) -> tuple[Scene, Scene]:
    """The scenes of T and T_0, the latter of the BRDF that was `baked`.

    Where that is not given, it is that of the scene, or where parts have materials of their own those of all parts.
    """
    texels = replace(scene, relit=None, faint=FAINT, shadows=False)
    if baked is None and len(scene.parts) > 1 and scene.material is not None:
        return texels, replace(texels, material=without_maps(scene.material))
    return texels, replace(texels, material=None, brdf=scene.brdf if baked is None else baked)


def combine_shadowed(texels: Image, plain: Image, baked: Image) -> Image:
    """L from T, T_0 and B: images (H, W, 4) of radiance times coverage, and coverage.

    At outlines, where rounding lets one image cover a sub-pixel more than another, L covers what both do.
    """
    coverage = np.minimum(baked[..., 3:], texels[..., 3:])
    kept = coverage / np.where(baked[..., 3:] > 0.0, baked[..., 3:], 1.0)
    below = np.maximum(plain[..., :3], MINIMUM * luminance(plain[..., :3])[..., None])
    share = np.where(below > 0.0, texels[..., :3] / np.where(below > 0.0, below, 1.0), 1.0)
    sums = [np.maximum(each[..., :3].sum(axis=(0, 1), dtype=np.float64), 1e-30) for each in (texels, plain)]
    direct = np.minimum(baked[..., :3], below)
    beyond = np.minimum(share, MAXIMUM * (sums[0] / sums[1]).astype(np.float32)) * (baked[..., :3] - direct)
    found = np.minimum((direct * share + beyond) * kept, np.finfo(np.float32).max)
    return np.concatenate([found, coverage], axis=-1)


def draw(scene: Scene, size: tuple[int, int], samples: int = 2) -> Steps[Image]:
    """The image of any scene on the CPU: under its lights, or of its bake, with the texels where it has any."""
    if scene.relit is None:
        return (yield from radiance(scene, size, samples=samples))
    if not scene.has_texels:
        return (yield from image_of(scene.relit, scene.camera, size, samples)).image
    with_texels, without = with_and_without(scene)
    texels = yield from part(radiance(with_texels, size, samples=samples), 0.0, 0.4)
    plain = yield from part(radiance(without, size, samples=samples), 0.4, 0.7)
    baked = (yield from part(image_of(scene.relit, scene.camera, size, samples), 0.7, 1.0)).image
    return combine_shadowed(texels, plain, baked)
