"""Effects as people read them, and from which error on one is worth a figure."""

from __future__ import annotations

#: Names by those of `engine.effects.estimates`; an effect that is not among them is shown by its own.
NAMES = {
    "self-shadowing": "Shadows",
    "interreflection": "Bounces",
    "glossy": "Gloss",
    "anisotropy": "Anisotropy",
    "all-frequency-light": "Sharp light",
    "sun-split": "Sun",
    "mesostructure": "Mesostructure",
    "spatially-varying-gloss": "Varying gloss",
    "fresnel": "Fresnel",
    "retro-reflection": "Retro-reflection",
}

#: Relative errors below this are no loss.
LEAST_ERROR = 1e-5
