"""Colour spaces by the names that MaterialX documents give them, as linear Rec.709.

Names are those of MaterialX 1.39 ("Color Spaces") with the aliases of the ASWF's colour interoperability forum. Numbers
of no space (`none`, `raw`) stay as they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from engine.core.colour import ACESCG, REC_2020, SRGB_FROM_XYZ
from engine.images.colour_space import (
    ADOBE_RGB,
    LINEAR_CURVE,
    P3,
    SRGB_CURVE,
    ColourSpace,
    Curve,
    from_chromaticities,
    gamma,
    linear_space,
)

_AP1 = linear_space(ACESCG.chromaticities).matrix
_P3 = from_chromaticities((*P3, *REC_2020.chromaticities[6:]))


def _spaces(curve: Curve, matrix: object, *names: str) -> dict[str, ColourSpace]:
    return {name: ColourSpace(names[0], (curve,), matrix) for name in names}  # type: ignore[arg-type]


#: Spaces by name in lower case.
SPACES: Mapping[str, ColourSpace] = MappingProxyType(
    {
        **_spaces(
            LINEAR_CURVE,
            None,
            *("lin_rec709", "lin_rec709_scene", "lin_srgb", "linear", "scene-linear rec.709-srgb"),
            *("raw", "none", "data"),
        ),
        **_spaces(SRGB_CURVE, None, "srgb_texture", "srgb", "srgb_rec709_scene", "srgb_rec709_display", "srgb_tx"),
        **_spaces(gamma(1.8), None, "g18_rec709", "g18_rec709_scene"),
        **_spaces(gamma(2.2), None, "g22_rec709", "g22_rec709_scene"),
        **_spaces(gamma(2.4), None, "rec709_display"),
        **_spaces(LINEAR_CURVE, _AP1, "acescg", "lin_ap1", "lin_ap1_scene"),
        **_spaces(gamma(2.2), _AP1, "g22_ap1", "g22_ap1_scene"),
        **_spaces(LINEAR_CURVE, linear_space(REC_2020.chromaticities).matrix, "lin_rec2020", "lin_rec2020_scene"),
        **_spaces(LINEAR_CURVE, _P3, "lin_displayp3", "lin_p3d65", "lin_p3d65_scene"),
        **_spaces(SRGB_CURVE, _P3, "srgb_displayp3", "srgb_p3d65_scene"),
        **_spaces(LINEAR_CURVE, SRGB_FROM_XYZ, "lin_ciexyzd65_scene", "lin_ciexyzd65_display", "lin_ciexyzd65"),
        **_spaces(LINEAR_CURVE, ADOBE_RGB.matrix, "lin_adobergb", "lin_adobergb_scene"),
        **_spaces(ADOBE_RGB.curves[0], ADOBE_RGB.matrix, "adobergb", "g22_adobergb_scene"),
    }
)
