"""Bytes of transport files over those of their arrays, what rounding adds to the error, and the time to open them.

What is added is the change of radiance that vertices send under the studio, of coefficients as a bake rounds them
beside coefficients that are not, root mean square over that of the radiance; and what the file itself states of its
coefficients, which must be more. The time is that of the same arrays in a file of version 1, in the same run. Models
are the bunny on a ground where the folder of real data lies beside the project, otherwise a bust.
"""

from __future__ import annotations

import tempfile
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from benchmarks.measure import Accuracy
from benchmarks.transport.paid_off import BUNNY
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Step, Steps, drain
from engine.core.stopwatch import shortest
from engine.figures.figure import coarse_bust
from engine.geometry.ground import Ground
from engine.geometry.shapes import open_mesh
from engine.light.environment_file import open_environment
from engine.transport import sh_method, wavelet_method
from engine.transport.baking.file import open_transport
from engine.transport.baking.file_header import MAGIC, head_of, header_text, read_header
from engine.transport.baking.packing import unpack_content
from engine.transport.baking.radiance_error import choose_tried_pairs
from engine.transport.baking.settings import ShLight, WaveletLight
from engine.transport.baking.visibility import visibility_shares
from engine.transport.method import Subject, method_of
from engine.transport.relight import Light
from engine.transport.sh import bake as sh_bake
from engine.transport.sh.transfer import sum_signed_radiance
from engine.transport.wavelet.quantise import STEP
from engine.transport.wavelet.transfer import (
    Vectors16,
    cube_texels,
    light_maps,
    radiance_towards,
    transport_vectors,
    vectors_of,
    vertex_frames,
)

#: BRDFs, grey and coloured: the coefficients of a grey one take fewer bytes.
BRDFS = ("ggx:kd=0.3,alpha=0.3,f0=0.2", "ggx:kd=0.3/0.2/0.1,alpha=0.3,f0=0.2")

#: Share of the bytes that is promised for each mode (of a grey BRDF), error that is added, and time over version 1.
SHARES, ADDED, SLOWER = {"wavelet": 25e6 / 98.5e6, "sh": 1.0 / 3.0}, 0.02, 1.0

VERTICES, VIEWS = 300, 10


def transport_sizes(folder: Path) -> Steps[list[Accuracy]]:
    """Shares of bytes, added errors and ratios of times of wavelets and spherical harmonics."""
    mesh = open_mesh(str(BUNNY)) if BUNNY.exists() else coarse_bust(97, 145)
    found: list[Accuracy] = []
    for number, (mode, text) in enumerate((mode, text) for text in BRDFS for mode in SHARES):
        yield Step(number / (2 * len(SHARES)), f"baking {mesh.name} in {mode}")
        method, path = method_of(mode), folder / f"{mode}.transport"
        subject = Subject(mesh, brdf_from_text(text), Ground(), kept=folder / "visibility")
        work = drain(method.baking.prepare(subject, method.settings()))
        drain(method.baking.bake(path, work))
        name = f"transport-{{}}-{mode}-{BRDFS.index(text)}"
        found += _measure_file(name, f"{mesh.name} on a ground, {text}, {mode}", mode, path, work)
    return found


def _measure_file(name: str, what: str, mode: str, path: Path, work: Any) -> list[Accuracy]:
    head, size_bytes = head_of(path)
    header = read_header(path, head)
    share = size_bytes / header.size_bytes
    added = (_change_wavelets if mode == "wavelet" else _change_sh)(path, work)
    with tempfile.TemporaryDirectory() as place:
        old = Path(place) / "old.transport"
        text = header_text(header.model_copy(update={"version": 1}))
        content = unpack_content(path, size_bytes, header).copy()
        beginning = MAGIC + len(text).to_bytes(4, "little") + _crc(text) + text
        content[: len(beginning)] = np.frombuffer(beginning, np.uint8)
        old.write_bytes(content.tobytes())
        ratio = shortest(lambda: open_transport(path), 7) / shortest(lambda: open_transport(old), 7)
    baking = wavelet_method if mode == "wavelet" else sh_method
    stated = baking.rounding_error(open_transport(path))
    sizes = {"size_bytes": size_bytes, "arrays_bytes": header.size_bytes}
    return [
        Accuracy(
            name.format("bytes"), share, f"{what}: bytes of the file over those of its arrays", SHARES[mode], sizes
        ),
        Accuracy(
            name.format("rounding"), added, f"{what}: change of radiance by rounding", ADDED, {"stated_rel": stated}
        ),
        Accuracy(name.format("opening"), ratio, f"{what}: time to open it over that of version 1", SLOWER),
    ]


def _crc(text: bytes) -> bytes:
    return zlib.crc32(text).to_bytes(4, "little")


def _change_wavelets(path: Path, work: Any) -> float:
    transport = wavelet_method.transport_of(open_transport(path))
    chosen, towards = choose_tried_pairs(work.ground_vertex, VERTICES, VIEWS, 1)
    of = work.occluder.receivers(work.surface)
    counts = np.concatenate([some for _, some in visibility_shares(of, work.settings.edge, work.settings.fine, chosen)])
    frames = vertex_frames(work.surface, work.factors.isotropic)[chosen]
    some = replace(
        transport.mesh, positions=work.surface.positions[chosen], normals=work.surface.normals[chosen],
        uv=work.surface.uv[chosen], faces=np.zeros((1, 3), np.int32),
    )  # fmt: skip
    values = []
    for step in (1, STEP):
        arrays = transport_vectors(
            frames, counts, work.settings.fine**2, cube_texels(work.settings.edge), work.factors.hemisphere_map,
            light_maps(work.factors), work.settings.coefficients, step,
        )  # fmt: skip
        vectors: Vectors16 = vectors_of(arrays)
        alone = replace(transport, mesh=some, ground_vertex=len(chosen), vectors=vectors)
        object.__setattr__(alone, "frames", frames)  # those of the whole mesh, with its tangents
        rows = wavelet_method.relight_transport(alone, Light(open_environment("studio")), WaveletLight()).rows
        sent = [radiance_towards(alone, np.asarray(rows, np.float64), np.tile(wo, (len(chosen), 1))) for wo in towards]
        values.append([each.value for each in sent])
    return _change(np.array(values[1]), np.array(values[0]))


def _change_sh(path: Path, work: Any) -> float:
    transport = sh_method.transport_of(open_transport(path))
    chosen, towards = choose_tried_pairs(work.ground_vertex, VERTICES, VIEWS, 1)
    baker = sh_bake.baker_of(work, sh_bake.receivers_of(work))
    counts = baker.visible(chosen)
    with mock.patch.object(sh_bake, "round_rows", lambda rows: rows):
        exact = baker.rows(chosen, counts)
    values, count = [], work.settings.order**2
    for rows in (exact, baker.rows(chosen, counts)):
        whole = np.zeros(transport.rows.shape, np.float32)
        matrices = whole[: work.ground_vertex * count].reshape(work.ground_vertex, count, 1, count)
        matrices[chosen] = rows.reshape(-1, count, 1, count)
        light = Light(open_environment("studio"))
        relit = sh_method.relight_transport(replace(transport, rows=whole), light, ShLight())
        local = towards @ transport.frames[chosen]  # (chosen, views, 3)
        sent = [sum_signed_radiance(relit.transport, relit.rows, local[:, view], chosen) for view in range(VIEWS)]
        values.append([np.maximum(each, 0.0) * (local[:, view, 2:] > 0.0) for view, each in enumerate(sent)])
    return _change(np.array(values[1]), np.array(values[0]))


def _change(found: Any, exact: Any) -> float:
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))
