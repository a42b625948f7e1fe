"""The proof of an export: what each consumer on this machine drew of it, beside our own image, on one sheet.

The export is written to the folder first (`engine.exchange.export`), then each consumer reads its files as any user
has them. `proof.png` shows ours, theirs, and the difference four times enlarged, with the relative RMSE; who draws
nothing, complains or is absent is named with the reason. `proof.json` has the same as values. Consumers that draw take
some seconds each; MaterialX on a CPU in place of a graphics card a minute for half a million texels.

Readers of our own that follow published formats and share no line with the writers: RTI files, relit.

PTM 1.2 (Malzbender2001) holds rows from the bottom up and values to 255, HSH 1.2 (Gautron2004) rows from the top and
values to 1; both are codes of sRGB. Lines of a header that begin with # are comments.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.core.colour import to_display8
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, drain, part
from engine.exchange.export import NAMES, departure, write
from engine.exchange.rti import fit, has_sides
from engine.exchange.rti import show as rti_shown
from engine.exchange.subject import Settings, Subject
from engine.figures.contact_sheet import Panel, Row, draw_sheet
from engine.images.encode import encode_png
from engine.proof.blender import cycles, eevee, our_power_law
from engine.proof.libraries import absent, materialx, mitsuba, on_a_sphere, usd
from engine.proof.programs import glslang, three, validator
from engine.proof.square import Drawn, Floats, draw_ourselves, lamp, middle, relative_rmse
from engine.scene.material import Material
from engine.shading.directional.functions import polynomial
from engine.storage.atomic import write_bytes

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack


def draw_by_hsh(folder: Path) -> Drawn:
    """The `.rti` of `folder`, relit by the lamp."""
    (file,) = folder.glob("*.rti")
    return Drawn("rti", "HSH 1.2, read by its format", linear(relight_hsh(file.read_bytes())), "The .rti, relit.")


def draw_by_ptm(folder: Path) -> Drawn:
    """The `.ptm` of three channels of `folder`, relit by the lamp."""
    file = next(path for path in folder.glob("*.ptm") if not path.stem.endswith("_lrgb"))
    return Drawn("rti", "PTM 1.2, read by its format", linear(relight_ptm(file.read_bytes())), "The .ptm, relit.")


def relight_hsh(content: bytes) -> Floats:
    """Draw (H, W, 3) 8-bit levels under the lamp."""
    lines: list[bytes] = []
    while len(lines) < 3:
        line, _, content = content.partition(b"\r\n")
        if not line.startswith(b"#"):
            lines.append(line)
    width, height, channels = (int(word) for word in lines[1].split())
    count = int(lines[2].split()[0])
    scale = np.array(struct.unpack(f"<{count}f", content[: 4 * count]))
    bias = np.array(struct.unpack(f"<{count}f", content[4 * count : 8 * count]))
    codes = np.frombuffer(content[8 * count :], np.uint8).reshape(height, width, channels, count)
    x, y, z = lamp()
    phi, once = np.arctan2(y, x), 2.0 * z - 1.0
    root, less = np.sqrt(max(z - z * z, 0.0)), z * z - z
    weights = [
        np.sqrt(1.0 / (2.0 * np.pi)),
        np.sqrt(6.0 / np.pi) * np.cos(phi) * root,
        np.sqrt(3.0 / (2.0 * np.pi)) * once,
        np.sqrt(6.0 / np.pi) * np.sin(phi) * root,
        np.sqrt(30.0 / np.pi) * np.cos(2.0 * phi) * less,
        np.sqrt(30.0 / np.pi) * np.cos(phi) * once * root,
        np.sqrt(5.0 / (2.0 * np.pi)) * (1.0 + 6.0 * less),
        np.sqrt(30.0 / np.pi) * np.sin(phi) * once * root,
        np.sqrt(30.0 / np.pi) * np.sin(2.0 * phi) * less,
    ]
    return np.asarray(255.0 * ((codes / 255.0 * scale + bias) @ np.array(weights)))


def relight_ptm(content: bytes) -> Floats:
    """Draw (H, W, 3) 8-bit levels under the lamp, of PTM_FORMAT_RGB."""
    lines = content.split(b"\n", 6)
    width, height = int(lines[2]), int(lines[3])
    scale, bias = (np.array(line.split(), np.float64) for line in lines[4:6])
    terms = scale * (np.frombuffer(lines[6], np.uint8).reshape(3, height, width, 6) - bias)
    x, y, _ = lamp()
    return np.moveaxis(terms @ np.array([x * x, y * y, x * y, x, y, 1.0]), 0, 2)[::-1]


def linear(codes: Floats) -> Floats:
    """Linear light of the middle of an image of sRGB codes (IEC 61966-2-1)."""
    share = np.clip(middle(codes) / 255.0, 0.0, 1.0)
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


SHEET, RECORD = "proof.png", "proof.json"

#: The material of Blender that EEVEE draws, whose error is its own.
SHADER_TO_RGB = "blender, Shader to RGB"

#: Times by which differences are enlarged.
ENLARGED = 4.0


@dataclass(frozen=True, eq=False)
class Compared:
    """A consumer with our image of the same, None where it draws none."""

    drawn: Drawn
    ours: Floats | None

    @property
    def rmse_rel(self) -> float | None:
        if self.ours is None or self.drawn.image is None:
            return None
        return relative_rmse(self.drawn.image, self.ours)


def prove(folder: str | os.PathLike[str], material: Material, stack: ImageStack | None = None) -> Steps[dict[str, Any]]:
    """Write all exports of `material` and the sheet into `folder`; the record of the export with `proof` added."""
    leaving = yield from part(departure(material, stack), 0.0, 0.3)
    subject = leaving.subject
    names = [name for name in NAMES if _is_possible(name, subject)]
    record = yield from part(write(folder, leaving, names, Settings()), 0.3, 0.6)
    compared = yield from part(_ask(Path(folder), subject), 0.6, 0.95)
    yield Step(0.95, "drawing the sheet")
    errors = {entry["target"]: entry["rmse_rel_reference"] for entry in record["targets"] if entry["target"] != "brdf"}
    for entry in record["targets"]:
        if "power_law" in entry:
            errors[SHADER_TO_RGB] = entry["power_law"]["rmse_rel_reference"]
    sheet = draw_sheet(material.name, _subtitle(compared), [_row(each, errors) for each in compared])
    write_bytes(Path(folder) / SHEET, encode_png(sheet, software="Lightarc"))
    rows = [_entry(each) for each in compared]
    write_bytes(Path(folder) / RECORD, (json.dumps({"consumers": rows}, indent=2) + "\n").encode())
    return {**record, "proof": {"sheet": str(Path(folder) / SHEET), "consumers": rows}}


def _is_possible(name: str, subject: Subject) -> bool:
    """True where the material can be written to the target: pages hold a power law or planes, shaders any map."""
    material = subject.material
    if name == "rti":
        return has_sides(subject.material, subject.stack)
    if name == "web":
        return material.power_law is not None or material.directional is not None
    return name != "shaders" or (material.has_map and material.pbr is None)


def _ask(folder: Path, subject: Subject) -> Steps[list[Compared]]:
    """Each consumer, one after the other."""
    size = subject.maps.size
    by_maps = _ours(subject, subject.mean_f0)
    by_gltf = _ours(subject, None)
    sphere = _our_sphere(subject)
    asked: list[tuple[str, Callable[[], list[Drawn]], Floats | None]] = [
        ("MaterialX, glTF PBR", lambda: [materialx(folder / "materialx", "gltf_pbr", size)], by_maps),
        ("MaterialX, OpenPBR", lambda: [materialx(folder / "materialx", "open_pbr_surface", size)], by_maps),
        ("three.js", lambda: [three(folder / "gltf", size)], by_gltf),
        ("Cycles", lambda: [cycles(folder / "blender", size)], by_maps),
        ("EEVEE", lambda: [_look_up(folder, subject)], our_power_law(subject.material)),
        ("Mitsuba", lambda: [mitsuba(folder / "brdf")], sphere),
        ("HSH", lambda: [_relight(folder, subject, draw_by_hsh)], _our_hsh(subject)),
        ("PTM", lambda: [_relight(folder, subject, draw_by_ptm)], _our_ptm(subject)),
        ("USD", lambda: [usd(folder / "usd")], None),
        ("glTF validator", lambda: [validator(folder / "gltf")], None),
        ("glslang", lambda: [_compile(folder, subject)], None),
    ]
    found = []
    for index, (name, ask, ours) in enumerate(asked):
        yield Step(index / len(asked), f"asking {name}")
        found += [Compared(drawn, ours) for drawn in ask()]
    return found


def _compile(folder: Path, subject: Subject) -> Drawn:
    if not _is_possible("shaders", subject):
        return absent("shaders", "glslang", "the material has no map that a shader looks up")
    return glslang(folder / "shaders")


def _look_up(folder: Path, subject: Subject) -> Drawn:
    if subject.material.power_law is None:
        return absent("blender", "Blender, EEVEE", "the material has no power law that Shader to RGB looks up")
    return eevee(folder / "blender", subject.maps.size)


def _ours(subject: Subject, f0: float | None) -> Floats:
    return middle(
        draw_ourselves(subject.decode_as("png8", f0, omits_flat=True), subject.maps.size, 1.0 / subject.white)
    )


def _our_hsh(subject: Subject) -> Floats | None:
    shown = rti_shown(subject, Settings())
    return None if shown is None else middle(draw_ourselves(shown, subject.maps.size, 1.0))


def _our_ptm(subject: Subject) -> Floats | None:
    """The polynomials before they are rounded."""
    if not has_sides(subject.material, subject.stack):
        return None
    terms = drain(fit(subject, polynomial))
    return linear(terms.coefficients @ terms.basis(lamp()[None])[0])


def _relight(folder: Path, subject: Subject, read: Callable[[Path], Drawn]) -> Drawn:
    if not has_sides(subject.material, subject.stack):
        return absent("rti", "RTI", "the lamps stood on one arc")
    return read(folder / "rti")


def _our_sphere(subject: Subject) -> Floats:
    wi, wo, mask = on_a_sphere()
    image = np.zeros((*mask.shape, 3))
    image[mask] = np.pi * subject.material.reflectance.f(wi, wo) * wi[:, 2:]
    return image


def _subtitle(compared: list[Compared]) -> str:
    drew = sum(each.drawn.image is not None for each in compared)
    missing = sum(each.drawn.is_sound is None for each in compared)
    wrong = sum(each.drawn.is_sound is False for each in compared)
    return f"{drew} images by others beside ours, {wrong} complaints, {missing} not asked"


def _row(each: Compared, errors: dict[str, float | None]) -> Row:
    """Ours, theirs and the difference; exposed by ours."""
    is_power_law = each.drawn.name.endswith("EEVEE") and SHADER_TO_RGB in errors
    which = "rti, the .rti" if each.drawn.target == "rti" else each.drawn.target  # a .ptm is further away
    which = SHADER_TO_RGB if is_power_law else which
    lost = errors.get(SHADER_TO_RGB if is_power_law else each.drawn.target)
    heading = each.drawn.target if lost is None else f"{which} {percent(lost, 3)} away from the material"
    image, ours, error = each.drawn.image, each.ours, each.rmse_rel
    if image is None or ours is None or error is None:
        return Row(f"{heading}: {each.drawn.name}", (Panel(None, each.drawn.words),), aspect=12.0)
    bright = float(np.quantile(ours, 0.995)) or 1.0
    panels = (
        Panel(to_display8(ours / bright), "ours, of the same files"),
        Panel(to_display8(image / bright), f"{each.drawn.name}. {each.drawn.words}"),
        Panel(to_display8(ENLARGED * np.abs(image - ours) / bright), f"difference x {ENLARGED:g}: {percent(error, 3)}"),
    )
    return Row(heading, panels)


def _entry(each: Compared) -> dict[str, Any]:
    drawn = each.drawn
    return {
        "target": drawn.target,
        "consumer": drawn.name,
        "is_sound": drawn.is_sound,
        "drew": drawn.image is not None,
        "rmse_rel": each.rmse_rel,
        "words": drawn.words,
    }
