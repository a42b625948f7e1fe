"""Time and memory of reading a model of four million triangles, as `lightarc render` reads it, for each kind of file.

The model is a wavy ball, as glTF with normals, texture coordinates and colours. Reading runs in a process of its own
with its decoder; CPU time is that of both, and memory is sampled ten times a second in proportional shares (PSS), so
that what both share counts once. Bytes for a triangle are those of the peak without twice the file; by them
`engine.geometry.read_scene` refuses what would not fit.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.app.large_memory import memory_of
from benchmarks.measure import Accuracy
from engine.core.errors import InputError, MissingCapability
from engine.core.steps import Step, Steps
from engine.storage.atomic import write_bytes

#: Rows of the grid of the ball, which has twice as many columns and 4 rows² triangles.
ROWS = 1000

#: CPU seconds and bytes that reading may take.
LIMIT_S, LIMIT_BYTES = 25.0, 2 * 2**30

KINDS = ("ply", "glb", "obj", "stl")

#: Processes that compute beside a run, runs beside them, and seconds by the clock after which one counts as endless.
BUSY, RUNS, END_S = 4, 20, 600.0

_READ = "import sys; from engine.geometry.mesh import read_mesh; print(len(read_mesh(sys.argv[1]).faces))"

#: Computes until the process that started it has ended, however that did.
_COMPUTE = "import os\nparent = os.getppid()\nwhile os.getppid() == parent: pass"

_INTERVAL_S = 0.1


class Cost(NamedTuple):
    """Seconds by the clock and of CPU, and the peak of memory."""

    time_s: float
    cpu_s: float
    peak_bytes: int


def large_models(folder: Path, rows: int = ROWS) -> Steps[list[Accuracy]]:
    """CPU seconds and GiB of reading each kind; the bounds are those of a binary PLY."""
    if not Path("/proc/self/smaps_rollup").exists():
        raise MissingCapability("This system does not tell the memory of a process by kind", "Measure on Linux")
    found = []
    for index, kind in enumerate(KINDS):
        yield Step(index / len(KINDS), f"making a model as {kind}")
        path = folder / f"ball.{kind}"
        positions, faces = make_ball(rows)
        write_bytes(path, write_model(kind, positions, faces))
        count, size_bytes = len(faces), path.stat().st_size
        del positions, faces
        cost = yield from _read(path, index / len(KINDS))
        path.unlink()
        more = {**cost._asdict(), "triangles": count, "bytes_per_triangle": (cost.peak_bytes - 2 * size_bytes) / count}
        what = f"CPU seconds of {count / 1e6:.1f} million triangles, {cost.time_s:.1f} s by the clock"
        bounds = (LIMIT_S, LIMIT_BYTES / 2**30) if kind == "ply" else (None, None)
        found.append(Accuracy(f"read-{kind}-cpu", cost.cpu_s, what, bounds[0], more))
        found.append(Accuracy(f"read-{kind}-memory", cost.peak_bytes / 2**30, "GiB at most", bounds[1], more))
    return found


def busy_models(folder: Path, rows: int = ROWS, runs: int = RUNS) -> Steps[list[Accuracy]]:
    """Runs that end of `runs` images of a binary PLY, in processes of their own, beside `BUSY` processes that compute.

    A run that has not ended after `END_S` by the clock, or ends with an error, counts as one that does not.
    """
    path = folder / "ball.ply"
    write_bytes(path, write_model("ply", *make_ball(rows)))
    words = ("render", str(path), "--brdf", "lambert:albedo=0.8", "--renderer", "cpu", "--width", "128")
    command = [sys.executable, "-m", "app", *words, "--height", "128", "-o", str(folder / "ball.png"), "--overwrite"]
    ended, longest_s = 0, 0.0
    with ExitStack() as stack:
        for _ in range(BUSY):
            busy = stack.enter_context(subprocess.Popen([sys.executable, "-c", _COMPUTE]))
            stack.callback(busy.kill)
        for number in range(runs):
            yield Step(number / runs, f"run {number + 1} of {runs} beside {BUSY} busy processes")
            start = time.monotonic()
            with suppress(subprocess.TimeoutExpired):
                ended += subprocess.run(command, capture_output=True, timeout=END_S, check=False).returncode == 0
            longest_s = max(longest_s, time.monotonic() - start)
    what = f"share of {runs} runs beside {BUSY} busy processes that does not end; the longest took {longest_s:.0f} s"
    return [Accuracy("busy-models", 1.0 - ended / runs, what, 0.0, {"runs": runs, "longest_s": longest_s})]


def _read(path: Path, done: float) -> Steps[Cost]:
    """Read a model in a process of its own."""
    before, start, peak = _cpu_of_children(), time.monotonic(), 0
    command = [sys.executable, "-c", _READ, str(path)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        try:
            while process.poll() is None:
                peak = max(peak, memory_of(process.pid)[0])
                yield Step(done, f"reading {path.name}")
                time.sleep(_INTERVAL_S)
        finally:
            process.kill()
        message = process.stderr.read() if process.stderr else ""
    if process.returncode:
        raise InputError(path, f"could not be measured: {message.strip()[-300:]}", "Make room, or measure less")
    return Cost(time.monotonic() - start, _cpu_of_children() - before, peak)


def _cpu_of_children() -> float:
    """Seconds of CPU of all processes that have ended, with theirs."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def make_ball(rows: int) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Positions and triangles of a ball with waves."""
    columns = 2 * rows
    theta, phi = np.meshgrid(
        np.linspace(0.0, np.pi, rows), np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False), indexing="ij"
    )
    radius = 1.0 + 0.05 * np.sin(20.0 * theta) * np.sin(20.0 * phi)
    place = [np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)]
    positions = np.stack([radius * each for each in place], axis=-1).reshape(-1, 3).astype(np.float32)
    at = np.arange((rows - 1) * columns).reshape(rows - 1, columns)
    right = np.roll(at, -1, axis=1)
    faces = np.stack([at, right, at + columns, right, right + columns, at + columns], axis=-1)
    return positions, faces.reshape(-1, 3).astype(np.int32)


def write_model(kind: str, positions: NDArray[np.float32], faces: NDArray[np.int32]) -> bytes:
    """The content of a file."""
    if kind == "obj":
        lines = ["v %.6g %.6g %.6g" % tuple(each) for each in positions.tolist()]  # noqa: UP031 - twice as fast
        lines += ["f %d %d %d" % tuple(each) for each in (faces + 1).tolist()]  # noqa: UP031
        return "\n".join([*lines, ""]).encode()
    if kind == "stl":
        rows = np.zeros(len(faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
        rows["corners"] = positions[faces]
        return bytes(80) + len(faces).to_bytes(4, "little") + rows.tobytes()
    if kind == "ply":
        rows = np.empty(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
        rows["count"], rows["corners"] = 3, faces
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\n"
        head += "".join(f"property float {axis}\n" for axis in "xyz")
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        return head.encode() + positions.tobytes() + rows.tobytes()
    return _glb(positions, faces)


def _glb(positions: NDArray[np.float32], faces: NDArray[np.int32]) -> bytes:
    """With normals, texture coordinates and colours."""
    tables = [positions, positions, positions[:, :2], 0.5 + 0.4 * positions]
    content = [np.ascontiguousarray(each, np.float32).tobytes() for each in tables] + [faces.tobytes()]
    starts = np.cumsum([0, *map(len, content)]).tolist()
    views = [
        {"buffer": 0, "byteOffset": start, "byteLength": len(each)}
        for start, each in zip(starts, content, strict=False)
    ]
    accessors = [
        {"bufferView": at, "componentType": 5126, "count": len(each), "type": f"VEC{each.shape[1]}"}
        for at, each in enumerate(tables)
    ]
    accessors.append({"bufferView": 4, "componentType": 5125, "count": faces.size, "type": "SCALAR"})
    names = ("POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0")
    primitive = {"attributes": {name: at for at, name in enumerate(names)}, "indices": 4}
    tree = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "buffers": [{"byteLength": starts[-1]}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body = len(text).to_bytes(4, "little") + b"JSON" + text + starts[-1].to_bytes(4, "little") + b"BIN\0"
    whole = 12 + len(body) + starts[-1]
    return b"".join([b"glTF", (2).to_bytes(4, "little"), whole.to_bytes(4, "little"), body, *content])
