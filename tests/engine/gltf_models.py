"""glTF files of generated models, with their numbers within the text."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

_COMPONENTS = {"f": 5126, "u": 5125}
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class Model:
    """A glTF tree of one mesh, to which primitives are added."""

    def __init__(self, materials: list[dict[str, Any]] | None = None, **more: Any) -> None:
        self.primitives: list[dict[str, Any]] = []
        self.tree: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": self.primitives}],
            "materials": materials or [],
            **{key: [] for key in ("buffers", "bufferViews", "accessors")},
            **more,
        }

    def accessor(self, values: ArrayLike) -> int:
        """The index of a new accessor of floats, or of whole numbers without a sign."""
        array = np.asarray(values)
        array = array.astype("<u4" if array.dtype.kind in "iu" else "<f4")
        rows = array.reshape(len(array), -1)
        content = "data:;base64," + base64.b64encode(rows.tobytes()).decode()
        self.tree["buffers"].append({"byteLength": rows.nbytes, "uri": content})
        self.tree["bufferViews"].append({"buffer": len(self.tree["buffers"]) - 1, "byteLength": rows.nbytes})
        view, shape = len(self.tree["bufferViews"]) - 1, _SHAPES[rows.shape[1]]
        component = _COMPONENTS[array.dtype.kind]
        self.tree["accessors"].append(
            {"bufferView": view, "componentType": component, "count": len(rows), "type": shape}
        )
        return len(self.tree["accessors"]) - 1

    def add(self, positions: ArrayLike, corners: ArrayLike | None = None, **more: Any) -> None:
        """A primitive; of `more`, what is written in capitals are tables of its vertices."""
        attributes = {"POSITION": self.accessor(np.asarray(positions, float))}
        attributes |= {key: self.accessor(np.asarray(more.pop(key), float)) for key in list(more) if key.isupper()}
        primitive = {"attributes": attributes, **more}
        if corners is not None:
            primitive["indices"] = self.accessor(np.ravel(corners))
        self.primitives.append(primitive)
