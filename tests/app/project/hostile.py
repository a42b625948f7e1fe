"""Hostile projects by seed: a sound project, changed where the structure of its file, rows, values and arrays allows.

    python -m tests.app.project.hostile SEED COUNT

makes and reads so many and prints what became of them, with the peak of memory and the longest times.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import logging
import os
import random
import resource
import shutil
import sqlite3
import sys
import tempfile
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from app.document.comparison import Comparison, Entry
from app.document.document import Look, Project, Step
from app.document.factoring import Factoring, Run
from app.document.variation import Blend, VariedParameter
from app.project.arrays import PACKED, find_beside
from app.project.copying import copy
from app.project.photographs import keep, photographs, take_marks
from app.project.project_file import History, Writer, data_folder, read
from app.project.recovery import recover
from app.project.report import describe, identity, problems_of
from app.project.setup import set_up
from app.project.thumbnail import image_of
from app.project.values import Absent, array_from, name_of
from engine.brdf.brdf import MODELS
from engine.capture.lights.sources import Sources
from engine.capture.photograph.exposures import Exposure
from engine.core.errors import LightarcError
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import drain
from engine.factor.settings import DEFAULT
from engine.geometry.camera import Camera
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap
from engine.light.lamps import LampSettings
from engine.scene.material import Material
from engine.shading.power_law import fit
from engine.shading.shading_map import ShadingMap
from engine.storage.packed import pack

#: Values that a reader may take for what they are not.
EVIL: tuple[Any, ...] = (
    *(None, True, 0, -1, 5, 2**31, 2**63, -(10**30), 1e308, -1e30, 0.5, "", "²", "str", "9" * 5000, "\ud800", "a\0b"),
    *("../../etc/passwd", "/etc/passwd", [], {}, [[]], {"tuple": []}, {"map": []}, {"set": [1, "a"]}, {"float": "nan"}),
    *({"float": "inf"}, {"float": "1e5"}, {"verdict": 9}, {"path": "/etc/passwd"}, {"path": "../x", "near": "../../x"}),
    *(
        {"path": "x" * 5000},
        {"path": "/a/b"},
        {"path": 5},
        {"stack": "/"},
        {"stack": "../.."},
        {"stack": "stack-1"},
    ),
    *({"array": "0" * 40}, {"array": "../../x"}, {"value": "0" * 40}, {"value": 5}, {"is": "Mesh", "of": {}}),
    *({"is": "Path", "of": {}}, {"is": [], "of": 3}, {"tuple": [1, 2, 3]}, {"map": [[1, 2]]}, {"map": [[[], 2]]}),
    {"map": [["a", {"tuple": [1.0, float(2)]}]]},
)


def base(folder: Path) -> Path:
    """A sound project with something of each kind, small, with two steps."""
    from engine.images.encode import encode_png

    images = folder / "pictures"
    images.mkdir(parents=True)
    for angle in (10, 50, 90):
        (images / f"felt_{angle}deg.png").write_bytes(encode_png(np.full((8, 9, 3), 100 * angle, np.uint16)))
    paths = tuple(sorted(images.iterdir()))
    elevation = np.radians([10.0, 50.0, 90.0])
    exposures = tuple((Exposure(path, 0.1),) for path in paths)
    sources = Sources(paths, elevation, None, "file names", (0.1, None, None), exposures)
    slices = np.linspace(0.0, 1.0, 3 * 4 * 5 * 3, dtype=np.float32).reshape(3, 4, 5, 3)
    shading_map = ShadingMap(slices, 1.0, np.array([0.1, 0.5, 1.0]))
    health = Health({"a": 1.0}, (Finding(Verdict.NOTE, "is grey", "a.png"),))
    entries = tuple(Entry(name, kind(), at % 12) for at, (name, kind) in enumerate(list(MODELS.items())[:3]))
    runs = (Run(1, 0, "SVD", "model:phong", DEFAULT, given=MODELS["phong"]()),)
    first = Project(
        sources=sources,
        material=Material(shading_map, drain(fit(shading_map)), elevation_deg=(10.0, 90.0), health=health),
        provenance={"software": "test", "list": [1, 2.5, None, {"deep": True}]},
        mesh=shape("plane"),
        environment=EnvironmentMap(np.ones((4, 8, 3), np.float32)),
        look=Look(lamps=(LampSettings(),), forced=("shadows",)),
        camera=Camera((0.0, 0.0, 3.0)),
        views={"front": Camera((0.0, 1.0, 3.0))},
        comparison=Comparison(entries, (folder / "x.binary",)),
        factoring=Factoring(runs=runs, current=1),
        variations=(VariedParameter("exponent", 1.0, 20.0), Blend("lambert", "x")),
        bakes={"sh": {"order": 4}},
        name="Felt",
    )
    second = dataclasses.replace(first, look=Look(gain=2.0), notes="Linen")
    path = folder / "Felt.lap"
    with contextlib.closing(Writer(path)) as writer:
        writer.write(History(second, (Step("Gain", "", first, second), Step("Gain", "", second, first)), 1))
    keep(path, drain(take_marks(photographs(second))))
    return path


@contextlib.contextmanager
def change(path: Path) -> Iterator[sqlite3.Connection]:
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as connection:
        left = iter(range(100))  # the change before may have put a view that never ends in place of a table
        connection.set_progress_handler(lambda: next(left, None) is None, 10_000)
        connection.executescript("PRAGMA synchronous=OFF; PRAGMA journal_mode=MEMORY; BEGIN")
        yield connection
        if connection.in_transaction:
            connection.execute("COMMIT")


def _row(connection: sqlite3.Connection, table: str, rng: random.Random) -> tuple[Any, ...]:
    return rng.choice(connection.execute(f"SELECT * FROM {table}").fetchall())


def _evil(rng: random.Random) -> Any:
    return rng.choice(EVIL)


def _mutate(said: Any, rng: random.Random) -> Any:
    """A JSON value with one of its parts another one."""
    if isinstance(said, dict) and said and rng.random() < 0.85:
        key = rng.choice(list(said))
        if rng.random() < 0.08:
            return {name: value for name, value in said.items() if name != key}
        if rng.random() < 0.05:
            return {**said, rng.choice(["x", "path", "of", "tuple"]): _evil(rng)}
        return {**said, key: _mutate(said[key], rng)}
    if isinstance(said, list) and said and rng.random() < 0.85:
        at = rng.randrange(len(said))
        if rng.random() < 0.1:
            return said[:at] + said[at + 1 :]
        if rng.random() < 0.05:
            return said * 1000
        return [*said[:at], _mutate(said[at], rng), *said[at + 1 :]]
    if isinstance(said, float | int) and not isinstance(said, bool) and rng.random() < 0.6:
        return rng.choice([-said, said * 1e6, said * 1e-9, said + 1, int(said), str(said), 0.0, -1e30, 1e300])
    return _evil(rng)


def _text(value: Any, rng: random.Random) -> str:
    text = json.dumps(value, sort_keys=True)
    if rng.random() < 0.03:
        text = "[" * 20_000 + "]" * 20_000
    elif rng.random() < 0.03:
        text = text.replace("1.0", "1e400", 1).replace("0.0", "NaN", 1)
    return text


def values(path: Path, rng: random.Random) -> None:
    """One value of the document is another, under its right name, wherever it was named."""
    with change(path) as connection:
        name, text = _row(connection, "value", rng)
        replace(connection, name, _text(_mutate(json.loads(text), rng), rng))


def parts(path: Path, rng: random.Random) -> None:
    """A part of the current document is of another kind: anything, or the value of another part."""
    with change(path) as connection:
        current = connection.execute("SELECT value FROM meta WHERE name = 'current'").fetchone()[0]
        said = json.loads(connection.execute("SELECT parts FROM state WHERE name = ?", (current,)).fetchone()[0])
        part = rng.choice([field.name for field in dataclasses.fields(Project)])
        if rng.random() < 0.4:
            said[part] = rng.choice(list(said.values()))
        else:
            text = _text(_evil(rng), rng)
            said[part] = name_of(text.encode("utf-8", "surrogatepass"))
            connection.execute("INSERT OR REPLACE INTO value VALUES (?, ?)", (said[part], text))
        if rng.random() < 0.1:
            said[part] = _evil(rng)
        text = json.dumps(said, sort_keys=True)
        connection.execute("UPDATE state SET parts = ? WHERE name = ?", (text, current))


def replace(connection: sqlite3.Connection, name: str, text: str) -> None:
    """Give a value another text and its name, and all that name it likewise."""
    renamed = name_of(text.encode())
    connection.execute("DELETE FROM value WHERE name = ?", (name,))
    connection.execute("INSERT OR REPLACE INTO value VALUES (?, ?)", (renamed, text))
    for other, content in connection.execute("SELECT name, text FROM value").fetchall():
        if name in content and other != renamed:
            replace(connection, other, content.replace(name, renamed))
    connection.execute("UPDATE state SET parts = replace(parts, ?, ?)", (name, renamed))


def rows(path: Path, rng: random.Random) -> None:
    """A column of a row holds another value, or one of another type."""
    with change(path) as connection:
        table = rng.choice(["meta", "step", "state", "value", "array", "photograph"])
        names = [row[1] for row in connection.execute(f"PRAGMA table_info({table})")]
        row = _row(connection, table, rng) if connection.execute(f"SELECT 1 FROM {table}").fetchone() else None
        value = rng.choice(
            ["²", "", "x" * 100_000, b"\xff\xfe", b"", 5, -1, 2.5, None, 2**62, "0", "1", "9" * 5000, "[]", "{}", "\0"]
        )
        if row is not None:
            column = rng.choice(names)
            with contextlib.suppress(sqlite3.IntegrityError):
                connection.execute(f"UPDATE {table} SET {column} = ? WHERE {names[0]} IS ?", (value, row[0]))
        else:
            connection.execute(f"INSERT INTO {table} VALUES ({', '.join('?' * len(names))})", (value,) * len(names))


def objects(path: Path, rng: random.Random) -> None:
    """Views, triggers, indices, generated columns and further tables; tables that are gone or made otherwise."""
    table = rng.choice(["step", "state", "value", "meta", "array", "photograph"])
    endless = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x AS number, x AS name FROM c"
    deep = "+".join("1" * 900)
    statements = [
        f"ALTER TABLE {table} RENAME TO x; CREATE VIEW {table} AS {endless};",
        f"CREATE TRIGGER t AFTER UPDATE ON {table} BEGIN DELETE FROM meta; END;",
        f"CREATE TRIGGER t AFTER DELETE ON {table} BEGIN SELECT hex(zeroblob(100000000)); END;",
        f"CREATE INDEX i ON {table}({deep});",
        "CREATE TABLE extra(a);",
        f"ALTER TABLE {table} ADD COLUMN more TEXT DEFAULT (hex(zeroblob(1000)));",
        f"ALTER TABLE {table} ADD COLUMN more AS (1);",
        f"DROP TABLE {table};",
        f"CREATE VIEW v AS {endless};",
        "CREATE VIRTUAL TABLE f USING fts5(a);",
        "CREATE VIRTUAL TABLE r USING rtree(a, b, c);",
        f"DROP TABLE {table}; CREATE TABLE {table}(name, value, text, parts, number);",
        "PRAGMA writable_schema=ON; UPDATE sqlite_master SET sql = 'CREATE TABLE x(' || hex(zeroblob(9000)) || ')' "
        f"WHERE name = '{table}';",
        "PRAGMA writable_schema=ON; UPDATE sqlite_master SET rootpage = 2;",
        f"PRAGMA writable_schema=ON; UPDATE sqlite_master SET type = 'view' WHERE name = '{table}';",
        "".join(f"CREATE TABLE t{at}(a);" for at in range(200)),
        "ANALYZE;",
    ]
    with change(path) as connection, contextlib.suppress(sqlite3.OperationalError):
        connection.executescript(rng.choice(statements))


def numbers(path: Path, rng: random.Random) -> None:
    """An array is of another kind, shape or size, or holds other numbers; within the file or beside it."""
    with change(path) as connection:
        there = sorted(data_folder(path).glob("arrays/*"))
        stored = connection.execute("SELECT name, content FROM array").fetchall()
        name = rng.choice([*(name for name, _ in stored), *(each.stem for each in there)])
        array = array_from(dict(stored)[name]) if name in dict(stored) else find_beside(data_folder(path), name)
        other = _other_array(array, rng)
        stream = io.BytesIO()
        np.lib.format.write_array(stream, other, version=(1, 0), allow_pickle=True)
        changed_to = bytearray(stream.getvalue())
        if rng.random() < 0.2:
            changed_to = changed_to[: rng.randrange(len(changed_to))]
        if rng.random() < 0.2 and changed_to:
            changed_to[rng.randrange(min(128, len(changed_to)))] = rng.randrange(256)
        renamed = name_of(bytes(changed_to)) if rng.random() < 0.9 else name
        beside = data_folder(path) / "arrays" / f"{renamed}.npy"
        if rng.random() < 0.1:
            connection.execute("INSERT OR REPLACE INTO array VALUES (?, ?)", (renamed, bytes(changed_to)))
        elif rng.random() < 0.05:
            os.mkfifo(beside)
        elif rng.random() < 0.05 and not beside.is_symlink():
            beside.symlink_to("/dev/zero")
        elif rng.random() < 0.3:
            with beside.with_suffix(PACKED).open("wb") as file:
                deque(pack(file, [bytes(changed_to)], len(changed_to), max(1, other.itemsize % 256)), maxlen=0)
            if rng.random() < 0.3:
                _flip(beside.with_suffix(PACKED), rng)
        else:
            beside.write_bytes(changed_to)
        for value, text in connection.execute("SELECT name, text FROM value").fetchall():
            if name in text:
                replace(connection, value, text.replace(name, renamed))


def _flip(path: Path, rng: random.Random) -> None:
    content = bytearray(path.read_bytes())
    for _ in range(rng.choice([1, 8])):
        content[rng.randrange(len(content))] = rng.randrange(256)
    path.write_bytes(content)


def _other_array(array: Any, rng: random.Random) -> Any:
    with np.errstate(all="ignore"):
        return rng.choice(
            [
                lambda: array.astype(rng.choice(["f2", "f4", "f8", ">f4", "i4", "u8", "?", "c16", "S3", "O"])),
                lambda: array.reshape(-1),
                lambda: array[:-1],
                lambda: array[..., None],
                lambda: np.zeros((0, *array.shape[1:]), array.dtype),
                lambda: array * -1 if array.dtype != bool else array,
                lambda: np.full(array.shape, np.nan),
                lambda: np.where(array > array.mean(), np.inf, array),
                lambda: (array * 10**6).astype(array.dtype),
                lambda: np.concatenate([array, array]),
            ]
        )()


def file_bytes(path: Path, rng: random.Random) -> None:
    """Bytes of the file are others, it is cut short, or journals lie beside it."""
    content = bytearray(path.read_bytes())
    kind = rng.randrange(5)
    if kind == 0:
        for _ in range(rng.choice([1, 4, 64])):
            content[rng.randrange(len(content))] = rng.randrange(256)
    elif kind == 1:
        content = content[: rng.randrange(len(content))]
    elif kind == 2:
        content[rng.randrange(100)] = rng.choice([0, 1, 2, 255])
    elif kind == 3:
        page = 4096 * rng.randrange(len(content) // 4096)
        other = 4096 * rng.randrange(len(content) // 4096)
        content[page : page + 4096] = content[other : other + 4096]
    else:
        name = str(path.with_name("victim")).encode()
        tail = len(name).to_bytes(4, "big") + sum(name).to_bytes(4, "big") + bytes.fromhex("d9d505f920a163d7")
        head = bytes.fromhex("d9d505f920a163d7") + bytes(500)
        path.with_name(path.name + "-journal").write_bytes(head + bytes(8) + name + tail)
    path.write_bytes(content)


def loops(path: Path, rng: random.Random) -> None:
    """Values that each name the one before twice, or a long way down: small on disk, without an end in memory."""
    with change(path) as connection:
        count, times = rng.choice([(40, 2), (200, 1), (8, 50)])
        kind = rng.choice(["list", "factors"])
        name = ""
        for _ in range(count):
            ref: Any = {"value": name} if name else 1
            factors = {"is": "HomomorphicFactors", "of": {"shorter": {"tuple": [ref] * times}}}
            said = [ref] * times if kind == "list" else factors
            text = json.dumps(said, sort_keys=True)
            name = name_of(text.encode())
            connection.execute("INSERT OR REPLACE INTO value VALUES (?, ?)", (name, text))
        current = connection.execute("SELECT value FROM meta WHERE name = 'current'").fetchone()[0]
        part = rng.choice(["provenance", "built_from", "comparison", "material"])
        statement = "UPDATE state SET parts = json_set(parts, ?, ?) WHERE name = ?"
        connection.execute(statement, (f"$.{part}", name, current))


def marks(path: Path, rng: random.Random) -> None:
    """Rows about photographs and results that name what they like."""
    with change(path) as connection:
        evil = json.dumps(_evil(rng))
        place = rng.choice(
            [evil, '{"path": "/etc/passwd"}', '{"near": "../../../etc/passwd", "path": "/x"}', "[[[", ""]
        )
        row = (place, rng.choice([0, -1, 2**62]), 5, rng.choice(["", "x", "0" * 40]), rng.choice([None, evil, place]))
        connection.execute("INSERT OR REPLACE INTO photograph VALUES (?, ?, ?, ?, ?)", row)
        name = rng.choice(["made ..", "made /", "made x", "made ", "made bake-1", f"made {'y' * 300}"])
        said = {"kind": _evil(rng), "seconds": _evil(rng), "bytes": _evil(rng), "made_with": _evil(rng)}
        connection.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (name, json.dumps(said)))


def folders(path: Path, rng: random.Random) -> None:
    """The data folder is not there, or is a file, a link, or holds other things under the names of arrays."""
    data = data_folder(path)
    there = sorted(data.glob("arrays/*"))
    one, other = rng.choice(there), rng.choice(there)
    kind = rng.randrange(12)
    if kind == 0:
        shutil.rmtree(data)
    elif kind == 1:
        shutil.rmtree(data)
        data.write_bytes(b"a file")
    elif kind == 2:
        moved = data.with_name("moved")
        data.rename(moved)
        data.symlink_to(rng.choice([moved, Path("/proc/self"), data, path.parent]))
    elif kind == 3:
        shutil.rmtree(data / "arrays")
        (data / "arrays").symlink_to(rng.choice(["/dev", "arrays", "/"]))
    elif kind == 4:
        one.unlink()
        one.mkdir()
    elif kind == 5:  # arrays under one another's names: each is sound, and none is its own
        content = one.read_bytes()
        one.write_bytes(other.read_bytes())
        other.write_bytes(content)
    elif kind == 6:
        one.write_bytes(b"")
    elif kind == 7:
        with one.open("r+b") as file:
            file.truncate(1 << 40)  # a hole: a terabyte that takes no room
    elif kind == 8:
        other = one.with_name(one.name.upper())
        other.write_bytes(one.read_bytes()[::-1])
        if rng.random() < 0.5:
            one.unlink()
    elif kind == 9:
        one.with_suffix(".npy" if one.suffix != ".npy" else PACKED).write_bytes(rng.randbytes(200))
    elif kind == 10:
        one.unlink()
        one.symlink_to(rng.choice([other, one, Path("/dev/zero"), Path("/etc/passwd"), Path("missing")]))
    else:
        for name in ("stack-1", "bake-1", "..", "made", "job-1.json", "\udcff", "a" * 255):
            with contextlib.suppress(OSError):
                (data / name).mkdir()


def another_project(path: Path, rng: random.Random) -> None:
    """Arrays or rows of another project under the names of this one: right in their kind, wrong in their content."""
    data = data_folder(path)
    shape_of = rng.choice([(3, 4, 5, 3), (4, 8, 3), (3,), (1,), (0,), (2, 2)])
    array = np.asarray(np.random.default_rng(rng.randrange(9)).random(shape_of), rng.choice(["f4", "f8", "i8", "u1"]))
    stream = io.BytesIO()
    np.lib.format.write_array(stream, array, version=(1, 0))
    for each in sorted(data.glob("arrays/*")):
        if rng.random() < 0.4:
            with each.open("wb") as file:
                deque(pack(file, [stream.getvalue()], len(stream.getvalue()), array.itemsize), maxlen=0)
    if rng.random() < 0.3:
        with change(path) as connection:
            name, _ = _row(connection, "array", rng)
            connection.execute("UPDATE array SET content = ? WHERE name = ?", (stream.getvalue(), name))


def leftovers(path: Path, rng: random.Random) -> None:
    """Journals of a write that was interrupted, logs of another mode, or files of this name that are none."""
    kind = rng.randrange(7)
    journal, log, shared = (path.with_name(path.name + ending) for ending in ("-journal", "-wal", "-shm"))
    if kind in (0, 1):  # a hot journal: what it holds is rolled back
        with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as connection:
            connection.executescript("PRAGMA synchronous=OFF; PRAGMA cache_size=1; PRAGMA cache_spill=1; BEGIN")
            connection.execute("UPDATE value SET text = text || ' '")
            connection.execute("INSERT INTO value VALUES ('x', zeroblob(200000))")
            copies = path.read_bytes(), journal.read_bytes()
            connection.execute("ROLLBACK")
        path.write_bytes(copies[0])
        journal.write_bytes(copies[1] if kind == 0 else copies[1][: rng.randrange(len(copies[1]))])
    elif kind == 2:
        with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as connection:
            connection.executescript("PRAGMA journal_mode=WAL; PRAGMA wal_autocheckpoint=0")
            connection.execute("UPDATE value SET text = text || ' '")
            copies = path.read_bytes(), log.read_bytes()
        path.write_bytes(copies[0])
        log.write_bytes(copies[1])
        shared.write_bytes(rng.randbytes(32768))
    elif kind == 3:
        rng.choice([journal, log, shared]).mkdir()
    elif kind == 4:
        rng.choice([journal, log, shared]).symlink_to(rng.choice([path, Path("/dev/zero"), Path("/etc/passwd")]))
    elif kind == 5:
        rng.choice([journal, log, shared]).write_bytes(rng.choice([b"", b"x", rng.randbytes(5000)]))
    else:
        (path.parent / f".{path.name}.waiting-{'0' * 32}").mkdir()


def no_file(path: Path, rng: random.Random) -> None:
    """Something else than a regular file of its size stands under the name of the project."""
    kind = rng.randrange(6)
    if kind == 0:
        with path.open("r+b") as file:
            file.truncate(rng.choice([1 << 33, 1 << 40, 100, 0]))
        return
    content = path.read_bytes()
    path.unlink()
    if kind == 1:
        path.mkdir()
    elif kind == 2:
        os.mkfifo(path)
    elif kind == 3:
        path.symlink_to(rng.choice([path, Path("/dev/zero"), Path("/etc/passwd"), Path("missing"), path.parent]))
    elif kind == 4:
        path.with_name("target").write_bytes(content)
        path.symlink_to("target")
    else:
        path.write_bytes(content * 2)


def names(path: Path, rng: random.Random) -> None:
    """Names of photographs, models, entries and the project in other scripts, forms, cases and directions."""
    odd = [
        *("cafe\u0301.png", "caf\u00e9.png", "\u202egnp.exe", "\udce9.png", "A.PNG", "a.png", "\U0001f383.png"),
        *("con.png", "x" * 255, "x" * 256, "\u200b", "line\nbreak.png", "\x1b[31m.png", "a/../b.png", "~/a", "$HOME"),
    ]
    with change(path) as connection:
        for _ in range(rng.choice([1, 3])):
            name, text = _row(connection, "value", rng)
            said = json.loads(text)
            with contextlib.suppress(sqlite3.Error):
                replace(connection, name, json.dumps(_rename(said, rng, odd), sort_keys=True))
        if rng.random() < 0.5:
            place = json.dumps({"path": "/photographs/" + rng.choice(odd), "near": rng.choice(odd)})
            row = (place, 5, 5, "0" * 40, None)
            with contextlib.suppress(sqlite3.Error, UnicodeEncodeError):
                connection.execute("INSERT OR REPLACE INTO photograph VALUES (?, ?, ?, ?, ?)", row)


def _rename(said: Any, rng: random.Random, odd: list[str]) -> Any:
    """A JSON value in which some texts are others, but for the names of kinds."""
    if isinstance(said, dict):
        return {name: each if name == "is" else _rename(each, rng, odd) for name, each in said.items()}
    if isinstance(said, list):
        return [_rename(each, rng, odd) for each in said]
    return rng.choice(odd) if isinstance(said, str) and len(said) != 40 and rng.random() < 0.4 else said


@contextlib.contextmanager
def read_only(here: Path) -> Iterator[None]:
    """Within the block nothing in the folder can be written, also by whoever is root."""
    entries = [here, *here.rglob("*")]
    modes = [(each, each.lstat().st_mode & 0o7777) for each in entries if not each.is_symlink()]
    user = os.geteuid()
    here.parent.chmod(0o755)
    try:
        for each, mode in reversed(modes):
            each.chmod(mode & 0o555 | 0o444)
        if user == 0:
            os.seteuid(NOBODY)
        yield
    finally:
        os.seteuid(user)
        for each, mode in modes:
            each.chmod(mode)


@contextlib.contextmanager
def full_disk(_here: Path) -> Iterator[None]:
    """Within the block no file can grow, as on a disk without room."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


NOBODY = 65534

#: Kinds of changes around the file and beside it; `SURROUNDINGS` are what it may be read in.
AROUND: tuple[Callable[[Path, random.Random], None], ...] = (
    folders,
    folders,
    another_project,
    leftovers,
    leftovers,
    no_file,
    names,
    names,
)
SURROUNDINGS = (read_only, full_disk)

KINDS: tuple[Callable[[Path, random.Random], None], ...] = (
    values,
    values,
    values,
    values,
    parts,
    parts,
    rows,
    objects,
    numbers,
    numbers,
    file_bytes,
    loops,
    marks,
)


#: What a second change raises where the first has left nothing to change.
UNCHANGED = (
    sqlite3.Error,
    OSError,
    Absent,
    RecursionError,
    TypeError,
    AttributeError,
    KeyError,
    ValueError,
    IndexError,
    OverflowError,
)


#: A file without holes is smaller; a change reads it whole.
MAX_CHANGED_BYTES = 2**28

#: From this seed on, changes around the file are made as well.
FIRST_AROUND = 10_000_000


def hostile(sound: Path, path: Path, seed: int) -> str:
    """Make the hostile project of `seed` at `path` from a sound one; what was done to it."""
    rng = random.Random(seed)
    shutil.copy(sound, path)
    shutil.copytree(data_folder(sound), data_folder(path))
    kinds = [rng.choice(KINDS) for _ in range(rng.choice([1, 1, 1, 2, 3]))]
    if seed >= FIRST_AROUND:
        kinds = [
            *(kinds[:1] if rng.random() < 0.15 else ()),
            *(rng.choice(AROUND) for _ in range(rng.choice([1, 1, 2]))),
        ]
    for kind in kinds:
        if _is_changed_alone(path):
            with contextlib.suppress(*UNCHANGED):
                kind(path, rng)
    return " ".join(kind.__name__ for kind in kinds)


def _is_changed_alone(path: Path) -> bool:
    """True where a change reaches the project alone: no link leads away, no pipe waits, nothing is endless."""
    is_linked = any(each.is_symlink() for each in path.parent.rglob("*"))
    return not is_linked and path.is_file() and path.stat().st_size < MAX_CHANGED_BYTES


def surroundings(seed: int, here: Path) -> contextlib.AbstractContextManager[None]:
    """What the project of `seed` in the folder `here` is read in: mostly a folder like any other."""
    rng = random.Random(f"around {seed}")
    return rng.choice(SURROUNDINGS)(here) if rng.random() < 0.3 else contextlib.nullcontext()


def outcome_within(path: Path, seed: int) -> str:
    """The outcome of a project that can be read only: verify finds what it finds where it can be written."""
    with surroundings(seed, path.parent):
        try:
            describe(path)
            found: list[str] | str = drain(problems_of(path))
        except LightarcError as error:
            found = str(error)
    return "refused" if isinstance(found, str) else "problems" if found else "sound"


def outcome(path: Path, away: Path) -> str:
    """'refused', 'problems' or 'incomplete', or 'sound' where everything later works too.

    Whatever else is raised is a fault.
    """
    try:
        describe(path)
        problems = drain(problems_of(path))
    except LightarcError:
        with contextlib.suppress(LightarcError):
            drain(recover(path, away / "recovered.lap"))
            drain(problems_of(away / "recovered.lap"))
            read(away / "recovered.lap")
        return "refused"
    opened = read(path)
    if opened.steps:
        identity(path)
    for step in opened.steps:
        for state in (step.old, step.new):
            try:
                opened.state(str(state))
            except LightarcError:
                assert problems, f"verify called sound what cannot be read: {step.text}"
    if problems:
        return "problems"
    image_of(opened.current)
    if opened.missing:  # which `described` says, and which can be made again
        return "incomplete"
    setup = set_up(path)
    assert setup.scene.brdf.f(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0])).shape == (3,)
    drain(copy(path, away / "copied.lap"))
    with contextlib.closing(Writer(away / "again.lap")) as writer:
        writer.write(History(opened.current))
    return "sound"


def main(seed: int, count: int) -> None:
    shared = "/dev/shm"
    folder = Path(tempfile.mkdtemp(prefix="hostile-", dir=shared if os.path.isdir(shared) else None))  # noqa: PTH112
    os.environ |= {f"XDG_{kind}_HOME": str(folder / kind) for kind in ("CACHE", "CONFIG", "DATA")}
    logging.disable(logging.WARNING)
    os.fsync = lambda fd: None
    sound = base(folder / "base")
    outcome(sound, folder)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    times, outcomes = list[float](), Counter[str]()
    for number in range(seed, seed + count):
        here = folder / "now"
        here.mkdir()
        path = here / "Felt.lap"
        done = hostile(sound, path, number)
        start = time.process_time()
        try:
            within = outcome_within(path, number) if number >= FIRST_AROUND else ""
            found = outcome(path, here)
            outcomes[found] += 1
            assert within in ("", "refused", found) or (found, within) == ("incomplete", "sound"), (
                f"{within}, then {found}"
            )
        except Exception as error:  # counted, and told with its seed
            outcomes["FAULT"] += 1
            print(f"seed {number} ({done}): {type(error).__name__}: {str(error)[:200]}", flush=True)
        times.append(time.process_time() - start)
        shutil.rmtree(here)
        if len(times) % 250 == 0 or len(times) == count:
            order, peak = np.sort(times), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            p999, longest = order[int(0.999 * (len(order) - 1))], seed + int(np.argmax(times))
            print(
                f"seeds {seed} to {number}: {dict(outcomes)}; memory {before // 1024} MB, peak {peak // 1024} MB; "
                f"CPU median {np.median(order):.3f} s, p99.9 {p999:.2f} s, longest {order[-1]:.2f} s (seed {longest})",
                flush=True,
            )
    shutil.rmtree(folder)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
