"""Which state of this program wrote the page, the shader and brdf.json of a bundle: a fingerprint of their maker.

Two states of one version may write different pages, and a page of another state cannot be told from one that somebody
changed. The manifest keeps the fingerprint, and `engine.bundle.bundle` says what follows.
"""

from __future__ import annotations

import functools
import hashlib

import numpy as np

import engine
from engine.bundle.page import viewer
from engine.bundle.portable import RESOURCES, brdf_json, shader
from engine.scene.material import Material
from engine.shading.power_law import PowerLawMap

#: The key in `software` of the manifest, and the folders of resources that texts are put together from.
MAKER, _FOLDERS = "maker", ("viewer", "bundle", "shaders")


@functools.cache
def maker() -> str:
    """16 hexadecimal digits of the version, the texts of a material of one texel, and the resources of all others."""
    digest = hashlib.sha256(engine.__version__.encode())
    texel, error = np.full((1, 1, 3), 0.5, np.float32), np.zeros((1, 1), np.float32)
    plain = Material(None, PowerLawMap(texel, texel, 1.0, 0.0, np.zeros(3), error), "lambert", 1.0)
    for make in (viewer, shader, brdf_json):
        digest.update(make(plain).encode())
    for folder in _FOLDERS:
        for path in sorted((RESOURCES / folder).rglob("*.*")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
