"""Damaged files of USD: the good ones, and what reads many in one process (`tests.engine.storage.damaged_files`).

The library of USD opens files by their paths, so a batch is a folder that the confined process may read.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from engine.core.errors import InputError
from engine.exchange.usd import usdz
from engine.geometry import usd
from engine.geometry.mesh import decode_mesh
from engine.images.encode import encode_png


def layer() -> bytes:
    """A box of two materials, as text."""
    faces = "0, 3, 2, 1, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7"
    points = ", ".join(f"({x}, {y}, {z})" for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (0, 1)))
    coordinates = ", ".join(f"({number / 8}, {number % 3})" for number in range(8))

    def material(name: str, colour: str) -> str:
        surface = f"</all/{name}/surface.outputs:surface>"
        return f"""
    def Material "{name}"
    {{
        token outputs:surface.connect = {surface}
        def Shader "surface"
        {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor{colour}
            float inputs:roughness = 0.4
            token outputs:surface
        }}
        def Shader "base"
        {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @base.png@
            float4 inputs:scale = (0.5, 1, 1, 1)
            float3 outputs:rgb
        }}
    }}"""

    painted = material("painted", ".connect = </all/painted/base.outputs:rgb>")
    return f"""#usda 1.0
(
    customLayerData = {{
        string author = "somebody"
    }}
    metersPerUnit = 0.01
    upAxis = "Z"
)
def Xform "all"
{{
    double3 xformOp:translate = (3, -1, 0.5)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "box" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        int[] faceVertexCounts = [4, 4, 4, 4, 4]
        int[] faceVertexIndices = [{faces}]
        point3f[] points = [{points}]
        texCoord2f[] primvars:st = [{coordinates}] (
            interpolation = "vertex"
        )
        rel material:binding = </all/painted>
        def GeomSubset "some" (
            prepend apiSchemas = ["MaterialBindingAPI"]
        )
        {{
            uniform token familyName = "materialBind"
            int[] indices = [0, 1]
            rel material:binding = </all/plain>
        }}
    }}{painted}{material("plain", " = (0.5, 0.25, 0.1)")}
}}
""".encode()


def crate() -> bytes:
    """The same layer in binary form."""
    from pxr import Sdf

    made = Sdf.Layer.CreateAnonymous(".usda")
    made.ImportFromString(layer().decode())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "good.usdc")
        made.Export(str(path))
        return path.read_bytes()


def package() -> bytes:
    """The binary layer and an image in a package."""
    image = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    return usdz({"model.usdc": crate(), "base.png": encode_png(image)})


def prepare() -> None:
    """Load the library before the process is confined."""
    usd.prepare()
    from engine.exchange.readers import usd as materials
    from engine.geometry import usd_stage

    usd_stage.prepare()
    assert materials


def decode_batch(_content: Any, name: str, copies: str, files: Sequence[str]) -> dict[str, Any]:
    """The decoder of the child: `outcomes` of files, 'read', 'refused' or a fault in words, and the `times` of each."""
    found = [_decode(name, copies, file) for file in files]
    return {"outcomes": [text for text, _ in found], "times": np.array([seconds for _, seconds in found])}


def _decode(name: str, copies: str, file: str) -> tuple[str, float]:
    from engine.exchange.readers.usd import decode_materials

    start, outcome = time.process_time(), "read"
    try:
        mesh = decode_mesh(b"", name, copies=copies, file=file)
        if "missing" not in mesh:
            if not (np.isfinite(mesh["positions"]).all() and np.isfinite(mesh["uv"]).all()):
                outcome = "numbers are not finite"
            elif not 0 <= mesh["faces"].min() <= mesh["faces"].max() < len(mesh["positions"]):
                outcome = "faces name vertices that do not exist"
        decode_materials(b"", name, copies, file)
    except InputError as error:
        outcome = "refused" if error.problem and error.remedy and "\n" not in str(error) else f"no sentence: {error}"
    except Exception as error:  # the product would end this process; counted, and told with its number
        outcome = f"{type(error).__name__}: {str(error)[:200]}"
    return outcome, time.process_time() - start
