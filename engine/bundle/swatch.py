"""A small image of a material, flat and from above, for lists of files: the preview of a bundle that has no better.

Of a shading map it is the slice half way up, of a directional map the image under a lamp `TILT_DEG` from the normal
towards the upper left, of PBR maps the base colour. Only every so many texels are looked at, so that it costs a few
milliseconds at any size.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from engine.core.colour import to_display8
from engine.core.directions import surface_direction
from engine.images.encode import encode_png
from engine.scene.material import Material
from engine.shading.directional.planes import DirectionalMap
from engine.shading.power_law import PowerLawMap

#: Longest side in pixels, share of texels that are at most white, and the lamp of directional maps.
SIDE, BELOW_WHITE, TILT_DEG, AZIMUTH_DEG = 384, 0.98, 40.0, 135.0

#: Radiance above it is as good as this.
_BRIGHTEST = 1e30


def swatch(material: Material) -> bytes:
    """A PNG of at most `SIDE` pixels a side; ValueError for a material without maps."""
    shading_map, law, directional, pbr = material.maps
    if shading_map is not None:
        step = _step(shading_map.slices.shape[1:3])
        image = np.asarray(shading_map.slices[len(shading_map.slices) // 2, ::step, ::step])
    elif law is not None:
        image = _few(law).slice_image(0.5 * law.r_max)
    elif directional is not None:
        lamp = surface_direction(np.radians(TILT_DEG), np.radians(AZIMUTH_DEG))
        image = _thin(directional).image(lamp)
    elif pbr is not None:
        step = _step(pbr.size)
        image = pbr.base_colour[::step, ::step]
    else:
        raise ValueError("a material without maps has no image of its surface")
    image = np.clip(np.nan_to_num(image.astype(np.float64)), 0.0, _BRIGHTEST)
    bright = float(np.quantile(image, BELOW_WHITE))
    return encode_png(to_display8(image / bright if bright > 0.0 else image), software="Lightarc")


def _step(size: tuple[int, ...]) -> int:
    return max(1, -(-max(size) // SIDE))


def _few(law: PowerLawMap) -> PowerLawMap:
    """Every so many texels of a power law, without the tiles that it keeps."""
    step = _step(law.error_map.shape)
    scale, exponent, errors = (map_[::step, ::step] for map_ in (law.scale, law.exponent, law.error_map))
    return replace(law, kept=None, scale=scale, exponent=exponent, error_map=errors)


def _thin(directional: DirectionalMap) -> DirectionalMap:
    step = _step(directional.planes.shape[1:])
    return replace(directional, planes=np.ascontiguousarray(directional.planes[:, ::step, ::step]))
