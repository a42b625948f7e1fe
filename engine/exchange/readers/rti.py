"""Files of reflectance transformation imaging as directional maps, which relight as the files say.

| file | form | what is read |
|---|---|---|
| `.ptm` | PTM 1.1 and 1.2 (Malzbender2001) | RGB, LRGB, both also as JPEG, but for planes predicted in motion |
| `.rti` | `#HSH1.2` and its siblings | HSH of up to 16 terms (Gautron2004), PTM; a byte for each term of R, G, B |
| `info.json`, `plane_N` | a tree of relight | ptm, hsh, sh in rgb and lrgb, rbf and bilinear in mrgb; JPEG and PNG |

All give codes of 8-bit sRGB as sums of planes times functions of the direction of light: those of a polynomial or of
harmonics, or photographs between which is interpolated. Planes of bytes stay as they are. Where luminance and colour
are multiplied, the products of their codes have 16 bits, of which a plane holds the upper eight and one the lower, so
that nothing is rounded. Rows of a PTM run from the bottom up, all others from the top down; x of l is to the right and
y up. Decoders run in the confined process, and check what a header promises before anything is allocated for it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import luminance
from engine.core.directions import Vectors, surface_direction
from engine.core.errors import InputError
from engine.core.steps import Step, Steps
from engine.images.decode import unknown
from engine.images.jpeg import read_jpeg
from engine.images.png import read_png
from engine.images.raster import check_size
from engine.scene.material import Material
from engine.shading.directional.functions import hemispherical, polynomial, spherical
from engine.shading.directional.interpolation import Kernel, Stated, octahedral
from engine.shading.directional.planes import LOWEST, DirectionalMap
from engine.storage.records import MAX_PLANES
from engine.storage.text import read_json
from engine.storage.untrusted import AGAIN, decode_in_child, read_head

Floats = NDArray[np.float64]
Codes = NDArray[np.uint8]

Form = Literal["ptm", "hsh", "relight"]

#: Names of a relight tree: its numbers, and its planes.
INFO, _PLANE = "info.json", re.compile(r"plane_(\d{1,2})\.(?:jpe?g|png)", re.IGNORECASE)

#: Most bytes of a header and of `info.json`, and the largest number in them.
_HEADER_BYTES, _INFO_BYTES, _LARGEST = 4096, 8 << 20, 1e9

#: Angles from the normal, in degrees, of rings of directions that tell 16 functions apart, and directions of a ring.
_RINGS_DEG, _RING = (20.0, 45.0, 70.0), 8

#: Texels that are looked at for the brightest image.
_SEEN = 1 << 16

#: The decoder process that reads these files: that of images.
_PROCESS = "engine.images.decode"

_OTHERWISE = "Export it as PTM_FORMAT_RGB, or as HSH"


def form_of(path: Path) -> Form | None:
    """The form of a file or of a folder, by its first bytes or the names in it; None for anything else."""
    if path.is_dir():
        return "relight" if _is_info(path / INFO) else None
    if _is_info(path):
        return "relight"
    head = read_head(path, 8)[0] if path.is_file() else b""
    if head.startswith(b"PTM_"):
        return "ptm"
    return "hsh" if head.startswith((b"#HSH", b"#PTM", b"#RTI")) else None


def _is_info(path: Path) -> bool:
    """True for the `info.json` of a tree, which counts its planes."""
    return path.name.lower() == INFO and path.is_file() and b'"nplanes"' in read_head(path, _INFO_BYTES)[0]


def read_rti(path: Path, form: Form) -> Steps[Material]:
    """The material of a file or a tree; InputError where it is damaged, or of a kind that is not read."""
    yield Step(0.0, "reading planes")
    options: dict[str, Any] = {"process": _PROCESS}
    file = path
    if form == "relight":
        file = path / INFO if path.is_dir() else path
        options["beside"] = {
            each.name.lower(): each for each in sorted(file.parent.iterdir()) if _PLANE.fullmatch(each.name)
        }
    reply = decode_in_child(f"engine.exchange.readers.rti:decode_{form}", file, **options)
    yield Step(0.8, "looking for the brightest image")
    found = DirectionalMap(
        planes=reply["planes"],
        low=np.asarray(reply["low"]),
        step=np.asarray(reply["step"]),
        mean=np.asarray(reply["mean"]),
        vectors=np.asarray(reply["vectors"]),
        lights=np.asarray(reply["lights"]),
        kernel=Kernel(float(reply["length"]), 0.0, basis=reply["basis"]),
        r_max=1.0,
        leave_one_out=math.nan,
        in_sample=math.nan,
        mean_picture=math.nan,
    )
    name = file.parent.name if form == "relight" else path.stem
    return Material(None, None, "lambert", name=name, directional=replace(found, r_max=_brightest(found, file)))


def _brightest(found: DirectionalMap, path: Path) -> float:
    """The mean luminance of the brightest image, over texels of a grid."""
    step = max(1, math.ceil(math.sqrt(found.planes[0].size / _SEEN)))
    few = replace(found, planes=found.planes[:, ::step, ::step])
    largest = max(float(luminance(few.image(light)).mean()) for light in found.lights)
    if not largest > 0.0:
        raise InputError(path, "is black under light from every side", "Check how it was made")
    return largest


@dataclass(frozen=True, eq=False)
class _Plane:
    """Codes (H, W) that stand for low + step · code, and the functions (N, 3) that it is multiplied with."""

    codes: Codes
    low: float
    step: float
    functions: Floats


def _plane(codes: Codes, scale: float, bias: float, functions: Floats) -> _Plane:
    """The plane of scale (code − bias)."""
    step = abs(scale) or 1.0
    return _Plane(codes, -step * bias, step, np.sign(scale) * functions)


def _in_colours(codes: Sequence[Codes], scale: Floats, bias: Floats, functions: Floats) -> list[_Plane]:
    """Planes of `functions` (N, K) of each channel: R, G, B of the first, then of the next."""
    only = np.eye(3)
    return [
        _plane(each, scale[place], bias[place], functions[:, place // 3, None] * only[place % 3])
        for place, each in enumerate(codes)
    ]


def _multiply_colour(
    light: Sequence[Codes],
    scale: Floats,
    bias: Floats,
    tint: Sequence[Codes],
    tint_scale: Floats,
    tint_bias: Floats,
    functions: Floats,
) -> tuple[list[_Plane], Floats]:
    """Planes and the constant (N, 3) of a luminance Σ scale_k (light_k − bias_k) f_k times a colour
    tint_scale_c (tint_c − tint_bias_c), multiplied out."""
    upper, lower = list[_Plane](), list[_Plane]()
    only = np.eye(3)
    for k, codes in enumerate(light):
        for c, colour in enumerate(tint):
            product = codes.astype(np.uint16) * colour
            of_both = scale[k] * tint_scale[c]
            seen = functions[:, k, None] * only[c]
            upper.append(_plane((product >> 8).astype(np.uint8), 256.0 * of_both, 0.0, seen))
            lower.append(_plane((product & 255).astype(np.uint8), of_both, 0.0, seen))
    constant = functions @ (scale * bias)
    coloured = [_plane(each, tint_scale[c], 0.0, -constant[:, None] * only[c]) for c, each in enumerate(tint)]
    shift = tint_scale * tint_bias
    shifted = [
        _plane(each, scale[k], 0.0, -functions[:, k, None] * shift) for k, each in enumerate(light) if shift.any()
    ]
    return [*upper, *coloured, *shifted, *lower], constant[:, None] * shift


def _reply(
    planes: Sequence[_Plane], lights: Vectors, basis: Stated, mean: Floats | None = None, length: float = 1.0
) -> dict[str, Any]:
    """What a decoder returns: the arrays and numbers of a `DirectionalMap`; `mean` (N, 3) is 0 where there is none."""
    return {
        "planes": np.stack([each.codes for each in planes]),
        "low": [each.low for each in planes],
        "step": [each.step for each in planes],
        "vectors": np.stack([each.functions.ravel() for each in planes], axis=1),
        "mean": np.zeros(3 * len(lights)) if mean is None else mean.ravel(),
        "lights": lights,
        "basis": basis,
        "length": length,
    }


def _sample_directions() -> Vectors:
    """(25, 3) directions that tell the functions of all forms apart; the last ones lie at the horizon."""
    tilt = np.radians([0.0, *np.repeat(_RINGS_DEG, _RING)])
    turn = np.concatenate([[0.0], np.tile(np.arange(_RING) * (2.0 * np.pi / _RING), len(_RINGS_DEG))])
    horizon = surface_direction(np.full(_RING, np.arccos(LOWEST)), np.arange(_RING) * (2.0 * np.pi / _RING))
    return np.vstack([surface_direction(tilt, turn), horizon])


def decode_ptm(content: bytes, name: str) -> dict[str, Any]:
    """The decoder of PTM 1.1 and 1.2."""
    version, form, *_ = [*content[:64].split(maxsplit=2), b"", b""]
    if version not in (b"PTM_1.1", b"PTM_1.2"):
        raise InputError(name, f"is a PTM of the version {_show(version)}, which is not read", "Export it as PTM 1.2")
    kind = form.removeprefix(b"PTM_FORMAT_").decode("latin-1")
    if kind not in ("RGB", "LRGB", "JPEG_RGB", "JPEG_LRGB"):
        raise InputError(name, f"is a PTM of the format {_show(form)}, which is not read", _OTHERWISE)
    is_tinted, count = kind.endswith("LRGB"), 9 if kind.endswith("LRGB") else 18
    packed = 1 + 7 * count if kind.startswith("JPEG") else 0
    numbers, start = _header(content, name, 2, 14 + packed)
    width, height = _whole(numbers[:2], name)
    check_size(name, width, height, 90 if is_tinted else 36, len(content))
    scale, bias = np.array(numbers[2:8]), np.array(numbers[8:14])
    body = content[start:]
    if packed:
        stored = _unpack_jpeg(body, name, _whole(numbers[14:], name, low=-1), count, height, width)
    else:
        stored = _divide_planes(body, name, count, height, width, interleaved=is_tinted and version == b"PTM_1.1")
    stored = [each[::-1] for each in stored]
    lights = _sample_directions()
    functions = polynomial(lights)
    if is_tinted:
        third = np.full(3, 1.0 / 255.0)
        planes, _ = _multiply_colour(stored[:6], scale, bias, stored[6:], third, np.zeros(3), functions)
    else:
        ordered = [stored[6 * channel + k] for k in range(6) for channel in range(3)]
        planes = _in_colours(ordered, np.repeat(scale, 3), np.repeat(bias, 3), functions)
    return _reply(planes, lights, "ptm")


def _divide_planes(body: bytes, name: str, count: int, height: int, width: int, interleaved: bool) -> list[Codes]:
    """Planes of bytes: in blocks of six terms for each texel, the last of LRGB of three, or all of a texel together."""
    texels = height * width
    if len(body) < count * texels:
        raise InputError(name, f"ends after {len(body):,} of {count * texels:,} bytes of its planes", AGAIN)
    sizes = [9] if interleaved else [6, 3] if count == 9 else [6, 6, 6]
    planes, first = list[Codes](), 0
    for size in sizes:
        block = np.frombuffer(body, np.uint8, size * texels, first).reshape(height, width, size)
        planes += [block[..., place] for place in range(size)]
        first += size * texels
    return planes


def _unpack_jpeg(body: bytes, name: str, numbers: list[int], count: int, height: int, width: int) -> list[Codes]:
    """Planes that are JPEG each, and differences from other planes, with the texels that these miss behind them."""
    transforms, across, down, order, references, sizes, sides = (
        numbers[1 + count * place : 1 + count * (place + 1)] for place in range(7)
    )
    if any(across) or any(down) or any(each not in (0, 1) for each in transforms):
        raise InputError(name, "is a PTM with planes that are predicted in motion, which are not read", _OTHERWISE)
    if sorted(order) != list(range(count)) or max(references) >= count or min(*sizes, *sides) < 0:
        raise InputError(name, "says of planes in which order they are made, and not of all", AGAIN)
    if sum(sizes) + sum(sides) > len(body):
        raise InputError(name, f"ends after {len(body):,} of {sum(sizes) + sum(sides):,} bytes of its planes", AGAIN)
    planes, corrections, first = list[Codes](), list[bytes](), 0
    for size, side in zip(sizes, sides, strict=True):
        planes.append(_image(body[first : first + size], name, height, width)[..., 0])
        corrections.append(body[first + size : first + size + side])
        first += size + side
    made = set[int]()
    for plane in sorted(range(count), key=order.__getitem__):
        if (reference := references[plane]) >= 0:
            if reference not in made:
                raise InputError(name, "predicts a plane from one that comes after it", AGAIN)
            other = planes[reference] if not transforms[plane] else 255 - planes[reference]
            planes[plane] = planes[plane] + other + np.uint8(128)  # modulo 256, as - 128
        planes[plane] = _correct(planes[plane], corrections[plane], name)
        made.add(plane)
    return planes


def _correct(plane: Codes, said: bytes, name: str) -> Codes:
    """The plane with codes that are stated: of each four bytes of its place and one of its code."""
    if not said:
        return plane
    if len(said) % 5:
        raise InputError(name, "has corrections of a plane that are cut off", AGAIN)
    entries = np.frombuffer(said, np.uint8).reshape(-1, 5)
    place = np.ascontiguousarray(entries[:, :4]).view(">u4")[:, 0].astype(np.int64)
    if (place >= plane.size).any():
        raise InputError(name, "corrects texels that it does not have", AGAIN)
    corrected = plane.ravel().copy()
    corrected[place] = entries[:, 4]
    return corrected.reshape(plane.shape)


def _image(content: bytes, name: str, height: int, width: int) -> NDArray[np.uint8]:
    """(H, W, 3) the bytes of an image, which has the size that was stated."""
    if content.startswith(b"\xff\xd8"):
        raster = read_jpeg(content, name)
    elif content.startswith(b"\x89PNG"):
        raster = read_png(content, name)
    else:
        raise unknown(content, name)
    samples = raster.samples if raster.samples.ndim == 3 else np.repeat(raster.samples[..., None], 3, axis=2)
    if samples.dtype != np.uint8:
        raise InputError(name, "has a plane of more than 8 bits", "Export its planes as JPEG or PNG with 8 bits")
    if samples.shape[:2] != (height, width):
        found = f"{samples.shape[1]} × {samples.shape[0]}"
        raise InputError(name, f"has a plane of {found} texels, and says {width} × {height}", AGAIN)
    return np.asarray(samples[..., :3])


def decode_hsh(content: bytes, name: str) -> dict[str, Any]:
    """The decoder of `.rti`: a kind, the size, how many terms, then factors and constants of these, and bytes."""
    numbers, start = _header(content, name, 0, 7)
    kind, width, height, channels, terms, colours, size_bytes = _whole(numbers, name)
    words = {0: "reserved", 2: "SH", 4: "adaptive"}
    if kind not in (1, 3):
        problem = f"holds terms of the kind {words.get(kind, kind)}, which is not read"
        raise InputError(name, problem, "Export it as HSH or PTM")
    if (channels, colours, size_bytes) != (3, 2, 1):
        raise InputError(name, "has terms that are not a byte for each of R, G and B", "Export it as HSH, RGB, 8 bits")
    if terms != 6 if kind == 1 else not 1 <= terms <= 16:
        raise InputError(name, f"has {terms} terms, which are read up to 16, and of a PTM 6", "Export it with fewer")
    check_size(name, width, height, 6 * terms, len(content))
    wanted = 8 * terms + 3 * terms * width * height
    if len(content) - start < wanted:
        raise InputError(name, f"ends after {len(content) - start:,} of {wanted:,} bytes of its terms", AGAIN)
    scale, constant = np.frombuffer(content, "<f4", 2 * terms, start).reshape(2, terms).astype(np.float64)
    _check(scale, name)
    _check(constant, name)
    body = np.frombuffer(content, np.uint8, 3 * terms * width * height, start + 8 * terms)
    codes = body.reshape(height, width, 3, terms)
    lights = _sample_directions()
    functions = polynomial(lights) if kind == 1 else hemispherical(lights)[:, :terms]
    ordered = [codes[:, :, channel, k] for k in range(terms) for channel in range(3)]
    planes = _in_colours(ordered, np.repeat(scale, 3), np.zeros(3 * terms), functions)
    mean = np.repeat(255.0 * (functions @ constant)[:, None], 3, axis=1)
    return _reply(planes, lights, "ptm" if kind == 1 else "hsh", mean)


def decode_relight(content: bytes, name: str, beside: Mapping[str, bytes] = MappingProxyType({})) -> dict[str, Any]:
    """The decoder of a relight tree: `info.json`, and planes by their names."""
    if len(content) > _INFO_BYTES:
        raise InputError(name, f"has more than {_INFO_BYTES >> 20} MiB of numbers", "Export it again")
    info = read_json(content, name, INFO, AGAIN)
    kind, space = (info.get(each) if isinstance(info, dict) else None for each in ("type", "colorspace"))
    if kind not in ("ptm", "hsh", "sh", "rbf", "bilinear"):
        raise InputError(name, f"is a tree of the type {_quote(kind)}, which is not read", "Export it as ptm or hsh")
    spaces = ("mrgb",) if kind in ("rbf", "bilinear") else ("rgb", "lrgb")
    if space not in spaces:
        problem = f"is a tree of the type {kind} in the colours {_quote(space)}, which are not read"
        raise InputError(name, problem, f"Export it in {' or '.join(spaces)}")
    width, height, count = _whole([info.get(each) for each in ("width", "height", "nplanes")], name)
    if count % 3 or not 3 <= count <= MAX_PLANES:
        raise InputError(name, f"has {count} planes, which are read by three, and up to {MAX_PLANES}", AGAIN)
    material = info["materials"][0] if isinstance(info.get("materials"), list) and info["materials"] else info
    material = material if isinstance(material, dict) else {}
    scale, bias = (_list(material.get(each), count, name, each) for each in ("scale", "bias"))
    check_size(name, width, height, 2 * max(count, 45), sum(map(len, beside.values())))
    planes = _relight_planes(beside, name, count, height, width)
    if kind in ("rbf", "bilinear"):
        return _interpolate_photographs(info, material, name, planes, scale, bias)
    lights = _sample_directions()
    functions = {"ptm": polynomial, "hsh": hemispherical, "sh": spherical}[str(kind)](lights)
    if kind == "ptm":
        functions = functions[:, [5, 3, 4, 0, 2, 1]]
    terms = count // 3 if space == "rgb" else count - 3
    if terms > functions.shape[1]:
        raise InputError(name, f"has {terms} terms of the type {kind}, which has {functions.shape[1]}", AGAIN)
    if space == "rgb":
        return _reply(_in_colours(planes, scale, 255.0 * bias, functions), lights, kind)
    tint = (planes[:3], scale[:3] / 255.0, 255.0 * bias[:3])
    made, mean = _multiply_colour(planes[3:], scale[3:], 255.0 * bias[3:], *tint, functions[:, :terms])
    return _reply(made, lights, kind, mean)


def _relight_planes(beside: Mapping[str, bytes], name: str, count: int, height: int, width: int) -> list[Codes]:
    """The planes (H, W) of a tree, three of each image."""
    planes = list[Codes]()
    for number in range(count // 3):
        names = [f"plane_{number}.{ending}" for ending in ("png", "jpg", "jpeg")]
        found = next((beside[each] for each in names if each in beside), None)
        if found is None:
            problem = f"needs plane_{number}.jpg or plane_{number}.png next to it, which is not there"
            raise InputError(name, problem, "Copy the whole folder, or export its planes as images without tiles")
        image = _image(found, f"{Path(name).parent / names[1]}", height, width)
        planes += [image[..., channel] for channel in range(3)]
    return planes


def _interpolate_photographs(
    info: dict[str, Any], material: dict[str, Any], name: str, planes: list[Codes], scale: Floats, bias: Floats
) -> dict[str, Any]:
    """Planes that are sums of photographs: the basis holds their mean, and their shares of each plane."""
    basis: Stated = "gauss" if info["type"] == "rbf" else "octahedron"
    if basis == "gauss":
        numbers = info.get("lights")
        count = len(numbers) // 3 if isinstance(numbers, list) else 0
        lights = _list(numbers, 3 * count, name, "lights").reshape(-1, 3)
        (length,) = _list([info.get("sigma")], 1, name, "sigma")
    else:
        (side,), length = _whole([info.get("resolution")], name), 1.0
        lights = octahedral(side) if 2 <= side <= 32 else np.zeros((0, 3))
    lengths = np.linalg.norm(lights, axis=1)
    if not 1 <= len(lights) <= 1024 or not (lengths > 0.5).all() or not (lights[:, 2] > -0.1).all() or length <= 0.0:
        raise InputError(name, "states no lights above the sample that photographs could have", AGAIN)
    lights = np.column_stack([lights[:, :2], np.maximum(lights[:, 2], 1e-6 * lengths)])
    lights /= np.linalg.norm(lights, axis=1, keepdims=True)
    values = _list(info.get("basis"), 3 * (len(planes) + 1) * len(lights), name, "basis")
    shares = values.reshape(len(planes) + 1, len(lights), 3)
    spread = _list(material.get("range"), len(planes), name, "range")
    if not (spread != 0.0).all():
        raise InputError(name, "states a range of 0", AGAIN)
    made = [
        _plane(codes, scale[k], 255.0 * bias[k], (shares[k + 1] - 127.0) / spread[k]) for k, codes in enumerate(planes)
    ]
    return _reply(made, lights, basis, shares[0], float(length))


def _header(content: bytes, name: str, words: int, count: int) -> tuple[list[float], int]:
    """The numbers of a header behind so many `words`, and the place behind its last line.

    Lines that begin with # are comments.
    """
    numbers, at, skipped = list[float](), 0, 0
    limit = _HEADER_BYTES + 16 * count
    while len(numbers) < count:
        end = content.find(b"\n", at, limit)
        if end < 0:
            raise InputError(name, "has a header that is cut off", AGAIN)
        line = content[at:end].split()
        at = end + 1
        if not line or line[0].startswith(b"#"):
            continue
        taken = min(words - skipped, len(line))
        skipped += taken
        for word in line[taken:]:
            try:
                numbers.append(float(word))
            except ValueError:
                raise InputError(name, f"has {_show(word)} in its header in place of a number", AGAIN) from None
    if len(numbers) > count:
        raise InputError(name, "has more numbers in its header than it needs", AGAIN)
    _check(np.array(numbers), name)
    return numbers, at


def _check(numbers: Floats, name: str) -> None:
    """InputError for numbers that no file can mean."""
    if not (np.abs(numbers) <= _LARGEST).all():
        raise InputError(name, "states numbers that are not finite, or too large", AGAIN)


def _list(numbers: Any, count: int, name: str, what: str) -> Floats:
    """(count,) numbers of a list of JSON."""
    is_list = isinstance(numbers, list) and len(numbers) == count
    if not is_list or not all(isinstance(each, int | float) and not isinstance(each, bool) for each in numbers):
        raise InputError(name, f"does not state {count} numbers as its {what}", AGAIN)
    found = np.array([float(each) for each in numbers if abs(each) <= _LARGEST])
    if len(found) < count:
        raise InputError(name, "states numbers that are not finite, or too large", AGAIN)
    return found


def _whole(numbers: Sequence[Any], name: str, low: int = 0) -> list[int]:
    """Whole numbers; InputError for others, and for less than `low`."""
    for each in numbers:
        is_number = isinstance(each, int | float) and not isinstance(each, bool) and low <= each <= _LARGEST
        if not is_number or each != int(each):
            raise InputError(name, f"states {_quote(each)} in place of a whole number", AGAIN)
    return [int(each) for each in numbers]


def _show(word: bytes) -> str:
    return ascii(word[:40].decode("latin-1"))


def _quote(value: Any) -> str:
    return ascii(value)[:60]
