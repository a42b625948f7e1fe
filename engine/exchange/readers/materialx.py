"""The material of a MaterialX document: OpenPBR, Standard Surface, glTF PBR or UsdPreviewSurface with image nodes.

Inputs of the surface are followed through node graphs, normal maps, channels, factors and inversions to a value or to
an image. What goes through another node takes the default of the surface, which is said, as is what is not drawn, and
inputs that have another value than their default and are not read. f0 is ((ior − 1) / (ior + 1))² times the weight of
the highlight. A value or file without a colour space of its own has that of the elements around it (MaterialX 1.39,
"Color Spaces"), and is linear Rec.709 where none has one; it counts for colours alone. y of normals is up. Entities
are refused, and nothing outside the folder of the document is read.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Literal
from xml.etree import ElementTree

import numpy as np

from engine.brdf.brdf import brdf_to_text
from engine.core.errors import InputError
from engine.exchange.readers.colour_spaces import SPACES
from engine.exchange.readers.layers import WEIGHTS, gltf_layers, has_layers, layers_of, openpbr_values, standard_values
from engine.exchange.readers.textures import Channel, Described, Image, Input
from engine.images.decode import TransferChoice
from engine.scene.credits import credits_of
from engine.storage.untrusted import AGAIN

_DEEPEST = 40

Element = ElementTree.Element


@dataclass(frozen=True)
class Surface:
    """Names of the inputs of a surface, with the values that it has where nothing is said (MaterialX 1.39).

    `weights` are factors on the map of their key; `unseen` are inputs that are not drawn unless they are 0. `scattered`
    are weight and colour of light that is scattered below the surface, `passing` is the weight of what goes through.
    `ignored` are inputs that are not read with the values at which nothing is lost; None for details of what the weight
    of a part decides, of which the loss of the part tells.
    """

    base_colour: tuple[str, tuple[float, ...]]
    roughness: tuple[str, float]
    metallic: tuple[str, float]
    normal: str
    ior: tuple[str, float]
    weights: Mapping[str, tuple[str, float]]
    occlusion: str = ""
    unseen: tuple[str, ...] = ()
    scattered: tuple[str, str] = ("", "")
    passing: str = ""
    ignored: Mapping[str, str | None] = field(default_factory=dict)


def _losses(details: str, **values: str) -> Mapping[str, str | None]:
    return MappingProxyType({**dict.fromkeys(details.split()), **values})


#: Surfaces that are read, in the order in which one of several is chosen: the nearest to PBR maps first.
SURFACES = {
    "gltf_pbr": Surface(
        ("base_color", (1.0, 1.0, 1.0)),
        ("roughness", 1.0),
        ("metallic", 1.0),
        "normal",
        ("ior", 1.5),
        {"f0": ("specular", 1.0)},
        "occlusion",
        ("emissive",),
        passing="transmission",
        ignored=_losses(
            "emissive_strength thickness attenuation_distance attenuation_color dispersion alpha_cutoff",
            alpha="1",
            alpha_mode="0",
        ),
    ),
    "open_pbr_surface": Surface(
        ("base_color", (0.8, 0.8, 0.8)),
        ("specular_roughness", 0.3),
        ("base_metalness", 0.0),
        "geometry_normal",
        ("specular_ior", 1.5),
        {},
        "",
        ("emission_luminance",),
        ("subsurface_weight", "subsurface_color"),
        "transmission_weight",
        _losses(
            "emission_color transmission_color transmission_depth transmission_scatter transmission_scatter_anisotropy "
            "transmission_dispersion_scale transmission_dispersion_abbe_number subsurface_color subsurface_radius "
            "subsurface_radius_scale subsurface_scatter_anisotropy",
            geometry_opacity="1",
            geometry_thin_walled="false",
        ),
    ),
    "standard_surface": Surface(
        ("base_color", (0.8, 0.8, 0.8)),
        ("specular_roughness", 0.2),
        ("metalness", 0.0),
        "normal",
        ("specular_IOR", 1.5),
        {"base_colour": ("base", 1.0), "f0": ("specular", 1.0)},
        "",
        ("emission",),
        ("subsurface", "subsurface_color"),
        "transmission",
        _losses(
            "emission_color transmission_color transmission_depth transmission_scatter transmission_scatter_anisotropy "
            "transmission_dispersion transmission_extra_roughness subsurface_color subsurface_radius "
            "subsurface_scale subsurface_anisotropy",
            opacity="1,1,1",
            thin_walled="false",
            coat_anisotropy="0",
            coat_rotation="0",
            coat_affect_color="0",
            coat_affect_roughness="0",
        ),
    ),
    "UsdPreviewSurface": Surface(
        ("diffuseColor", (0.18, 0.18, 0.18)),
        ("roughness", 0.5),
        ("metallic", 0.0),
        "normal",
        ("ior", 1.5),
        {},
        "occlusion",
        ("emissiveColor",),
        ignored=_losses(
            "specularColor",
            useSpecularWorkflow="0",
            opacity="1",
            opacityMode="0",
            opacityThreshold="0",
            displacement="0",
        ),
    ),
    "disney_principled": Surface(
        ("baseColor", (0.16, 0.16, 0.16)),
        ("roughness", 0.5),
        ("metallic", 0.0),
        "",
        ("", (1.0 + 0.08**0.5) / (1.0 - 0.08**0.5)),  # reflects 0.08 specular
        {"f0": ("specular", 0.5)},
        passing="specTrans",
        ignored=_losses(
            "",
            anisotropic="0",
            specularTint="0",
            sheen="0",
            sheenTint="0.5",
            ior="1.5",
            subsurface="0",
            subsurfaceDistance="1,1,1",
        ),
    ),
}

#: Numbers of glTF's layers in MaterialX, with their defaults.
_GLTF_LAYERS = {
    "clearcoat": 0.0,
    "clearcoat_roughness": 0.0,
    "sheen_roughness": 0.0,
    "iridescence": 0.0,
    "iridescence_ior": 1.3,
    "iridescence_thickness": 100.0,
    "anisotropy_strength": 0.0,
    "anisotropy_rotation": 0.0,
}

#: Nodes that are read.
NODES = (
    *SURFACES,
    *("image", "tiledimage", "gltf_image", "gltf_colorimage", "UsdUVTexture", "hextiledimage", "hextilednormalmap"),
    *("normalmap", "gltf_normalmap", "convert", "dot", "constant", "multiply", "invert", "extract", "swizzle"),
    *("separate2", "separate3", "separate4"),
)
_IMAGES = ("image", "tiledimage", "gltf_image", "gltf_colorimage", "UsdUVTexture", "hextiledimage", "hextilednormalmap")
_THROUGH = ("normalmap", "gltf_normalmap", "convert", "dot", "output")

#: Inputs that move texture coordinates, of images and of place2d, with the value at which they do not.
_MOVES = {"uvtiling": 1.0, "uvoffset": 0.0, "scale": 1.0, "rotate": 0.0, "offset": 0.0}

#: Nodes whose output is the texture coordinates of the model.
_COORDINATES = ("texcoord", "geompropvalue")

#: An element that stands for another document.
_INCLUDE = "{http://www.w3.org/2001/XInclude}include"

#: The colour space of a USD texture that its file tells.
AUTO = "auto"

_CHANNELS = {"r": 0, "x": 0, "g": 1, "y": 1, "b": 2, "z": 2}


def materialx_of(content: bytes, path: Path, included: Mapping[str, bytes] = MappingProxyType({})) -> Described:
    """The material of a document's content, as it names its files; InputError where it has no surface that is read.

    Elements of documents that it includes, by the names that it calls them, stand in their places; what these
    include in turn is left out.

    It runs in the decoder process (`engine.exchange.readers.documents_child`).
    """
    root = _parse(content, path)
    _include(root, path, included)
    found = {kind: [each for each in root if each.tag == kind] for kind in SURFACES}
    shaders = [shader for each in found.values() for shader in each]
    order = [each.tag for each in root if each.tag in ("gltf_pbr", "open_pbr_surface")]
    if order[:1] != ["gltf_pbr"]:  # layers of OpenPBR, which other surfaces say less well, but for those made of glTF's
        shaders.sort(key=lambda shader: not _has_layers(shader))
    if not shaders:
        known = ", ".join(SURFACES)
        raise InputError(path, "has no surface that is read", f"These are read: {known}")
    credits = credits_of({"licence": root.get("license"), **root.attrib})
    return replace(_Document(path, root).describe(shaders[0], shaders), credits=credits)


def describe_surface(shader: Element, root: Element, path: Path) -> Described:
    """The material of a surface among the elements below `root`."""
    return _Document(path, root).describe(shader, [shader])


def _parse(content: bytes, path: Path) -> Element:
    """The root of a document."""
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise InputError(path, "defines entities, which no MaterialX document needs", AGAIN)
    try:
        root = ElementTree.fromstring(content)
    except (ElementTree.ParseError, ValueError, LookupError, RecursionError) as error:
        raise InputError(path, f"is not valid XML ({str(error)[:80]})", AGAIN) from None
    if root.tag != "materialx":
        raise InputError(path, "is not a MaterialX document", "Give a .mtlx file")
    return root


def _include(root: Element, path: Path, included: Mapping[str, bytes]) -> None:
    """Put elements of other documents in the places of those that include them, with what their roots state."""
    for place, element in reversed([*enumerate(root)]):
        name = element.get("href", "")
        if element.tag != _INCLUDE or name not in included:
            continue
        other = _parse(included[name], path.parent / name)
        for each in other:
            for stated in ("colorspace", "fileprefix"):
                if value := other.get(stated):
                    each.set(stated, each.get(stated) or value)
        root[place : place + 1] = [each for each in other if each.tag != _INCLUDE]


class _Document:
    """Elements of one document, by the name that inputs call them."""

    def __init__(self, path: Path, root: Element) -> None:
        self.path, self.root = path, root
        self.parents = {child: parent for parent in root.iter() for child in parent}
        self.notes: list[str] = []
        self.read: set[str] = set()

    def describe(self, shader: Element, shaders: list[Element]) -> Described:
        surface = SURFACES[shader.tag]
        if len(shaders) > 1:
            self.notes.append(f"of {len(shaders)} surfaces, {shader.get('name', '')[:40]!r} ({shader.tag}) is taken")
        base = self._input(shader, *surface.base_colour, colour=True)
        roughness = self._input(shader, surface.roughness[0], (surface.roughness[1],))
        metallic = self._input(shader, surface.metallic[0], (surface.metallic[1],))
        ior = self._number(shader, *surface.ior)
        f0 = Input((((ior - 1.0) / (ior + 1.0)) ** 2 if ior > 0.0 else 1.0,))
        for name, (weight, usual) in surface.weights.items():
            factor = self._number(shader, weight, usual)
            base = _times(base, factor) if name == "base_colour" else base
            f0 = _times(f0, factor) if name == "f0" else f0
        normal = self._input(shader, surface.normal, (0.0, 0.0, 1.0))
        occlusion = self._input(shader, surface.occlusion, (1.0,)) if surface.occlusion else Input()
        constant = {surface.normal: (normal, (0.0, 0.0, 1.0)), surface.occlusion: (occlusion, (1.0,))}
        passed = [name for name, (each, usual) in constant.items() if name and not each.image and each.factor != usual]
        if passed:
            self.notes.append(f"a constant {' and '.join(passed)} is passed over")
        unseen = [name for name in surface.unseen if self._is_given(shader, name)]
        if unseen:
            self.notes.append(f"{' and '.join(unseen)} is not drawn")
        base = self._scatter_below(shader, surface, base)
        layers, widened = self._layers(shader, roughness)
        self._say_what_is_ignored(shader, surface)
        return Described(
            self._name(shader),
            base_colour=base,
            roughness=_times(roughness, widened),
            metallic=metallic,
            f0=f0,
            normal=replace(normal, factor=(1.0,)) if normal.image else None,
            occlusion=occlusion if occlusion.image else None,
            normal_scale=normal.factor[0] if normal.image else 1.0,
            upwards="opengl",
            notes=tuple(self.notes),
            layers=layers,
        )

    def _say_what_is_ignored(self, shader: Element, surface: Surface) -> None:
        """Name the inputs that are given, are not read, and would be seen."""
        ignored = []
        for given in shader:
            name = given.get("name", "")
            if given.tag != "input" or name in self.read:
                continue
            usual = surface.ignored.get(name, "")
            if usual is not None and (given.get("value") is None or not _is_same(given.get("value", ""), usual)):
                ignored.append(name[:40])
        if ignored:
            self.notes.append(f"{', '.join(ignored)} {'are' if len(ignored) > 1 else 'is'} not drawn")

    def _scatter_below(self, shader: Element, surface: Surface, base: Input) -> Input:
        """The base colour with what is scattered below the surface, and without what goes through it."""
        name, coloured = surface.scattered
        if name and (weight := self._number(shader, name, 0.0)):
            below = self._input(shader, coloured, (0.8, 0.8, 0.8) if "weight" in name else (1.0, 1.0, 1.0), colour=True)
            self.notes.append("light that is scattered below the surface leaves where it came, as from a diffuse one")
            if weight >= 1.0:
                base = below
            elif base.image is None and below.image is None:
                pairs = zip(_spread(base.factor, 3), _spread(below.factor, 3), strict=True)
                base = Input(tuple(a + weight * (b - a) for a, b in pairs))
            else:
                self.notes.append(f"{coloured} is mixed with an image, which is passed over")
        if surface.passing and (passing := min(self._number(shader, surface.passing, 0.0), 1.0)):
            self.notes.append("light that goes through the surface is lost")
            base = _times(base, 1.0 - passing)
        return base

    def _layers(self, shader: Element, roughness: Input) -> tuple[str, float]:
        """The text of the layers over the base, '' for none, and the factor of their anisotropy on the roughness."""

        def number(name: str, usual: float) -> float:
            return self._number(shader, name, usual)

        def colour(name: str, usual: Sequence[float]) -> Sequence[float]:
            given = self._input(shader, name, tuple(usual), colour=True)
            if given.image is not None:
                self.notes.append(f"the image of {name} is passed over")
                return usual
            return _spread(given.factor, 3)

        if shader.tag == "open_pbr_surface":
            return brdf_to_text(layers_of(openpbr_values(number, colour))), 1.0
        if shader.tag == "standard_surface":
            values, widened, notes = standard_values(number, colour)
            self.notes += notes if has_layers(values) else []
            return (brdf_to_text(layers_of(values)), widened) if has_layers(values) else ("", 1.0)
        if shader.tag == "gltf_pbr":
            given = {name: number(name, usual) for name, usual in _GLTF_LAYERS.items()}
            coloured = {"sheen_color": (0.0, 0.0, 0.0), "specular_color": (1.0, 1.0, 1.0)}
            given |= {name: colour(name, usual) for name, usual in coloured.items()}  # type: ignore[misc]
            mean = 0.5 if roughness.image is not None else 1.0
            layers, widened, notes = gltf_layers(given, mean * roughness.factor[0])
        else:
            is_usd = shader.tag == "UsdPreviewSurface"
            rough = number("clearcoatRoughness", 0.01) if is_usd else 1.0 - number("clearcoatGloss", 1.0)
            given = {"clearcoat": number("clearcoat", 0.0), "clearcoat_roughness": rough}
            layers, widened, notes = gltf_layers(given, 1.0)
            notes = ["clear coat is drawn as glTF's"] if layers else []
        self.notes += notes
        return "" if layers is None else brdf_to_text(layers), widened

    def _name(self, shader: Element) -> str:
        """The name of the material that has the surface."""
        for material in self.root.iter("surfacematerial"):
            if any(each.get("nodename") == shader.get("name") for each in material):
                return material.get("name", "material")[:60]
        return shader.get("name", "material")[:60]

    def _is_given(self, shader: Element, name: str) -> bool:
        self.read.add(name)
        given = _child(shader, name)
        if given is None:
            return False
        return given.get("value") is None or any(self._numbers(given.get("value", "0")))

    def _number(self, shader: Element, name: str, usual: float) -> float:
        given = self._input(shader, name, (usual,))
        if given.image is not None:
            self.notes.append(f"the image of {name} is passed over, and {usual:g} taken")
            return usual
        return given.factor[0]

    def _input(self, owner: Element, name: str, usual: tuple[float, ...], *, colour: bool = False) -> Input:
        """The value or the image of an input, its default where nothing or nothing known is given."""
        self.read.add(name)
        given = _child(owner, name)
        found = None if given is None else self._has_followed(given, colour, 0)
        if found is None:
            if given is not None:
                self.notes.append(f"{name} comes from nodes that are not read, and its default is taken")
            return Input(usual)
        if colour and len(found.factor) == 4:
            return replace(found, factor=found.factor[:3])
        if len(found.factor) not in ((1, 3) if colour else (1, len(usual))):
            raise InputError(self.path, f"has {len(found.factor)} numbers for {name}", AGAIN)
        return found

    def _has_followed(self, given: Element, colour: bool, depth: int) -> Input | None:
        """The value or the image that an input or an output leads to; None for nodes that are not read."""
        if depth > _DEEPEST:
            raise InputError(self.path, "has nodes that lead to each other without end", AGAIN)
        if given.get("value") is not None and given.get("nodename") is None and given.get("nodegraph") is None:
            values = self._numbers(given.get("value", ""))
            return Input(self._to_rec709(values, given) if colour and len(values) in (3, 4) else values)
        source = self._source(given)
        if source is None:
            return None
        if source.tag == "nodegraph":
            named = given.get("output")
            outputs = [each for each in source if each.tag == "output" and named in (None, each.get("name"))]
            return self._has_followed(outputs[0], colour, depth + 1) if outputs else None
        return self._read_node(source, given, colour, depth + 1)

    def _source(self, given: Element) -> Element | None:
        """The node, graph, or input of a graph that an input names."""
        scope = self.parents.get(self.parents[given]) if given.tag == "input" else self.parents[given]
        scope = self.root if scope is None else scope
        if (interface := given.get("interfacename")) is not None:
            return _child(scope, interface)
        if (graph := given.get("nodegraph")) is not None:
            return next((each for each in self.root if each.tag == "nodegraph" and each.get("name") == graph), None)
        named = given.get("nodename")
        return next((each for each in scope if each.get("name") == named and each.tag != "input"), None)

    def _read_node(self, node: Element, given: Element, colour: bool, depth: int) -> Input | None:
        if node.tag == "input":
            return self._has_followed(node, colour, depth)
        if node.tag in _IMAGES or (node.tag == "gltf_normalmap" and _child(node, "file") is not None):
            return self._image(node, given, colour)
        inside = _child(node, "in")
        if node.tag == "constant":
            value = _child(node, "value")
            return None if value is None else self._has_followed(value, colour, depth)
        if node.tag == "multiply":
            return self._product(node, colour, depth)
        if inside is None:
            return None
        found = self._has_followed(inside, colour, depth)
        if found is None:
            return None
        if node.tag in _THROUGH:
            scale = _child(node, "scale") if node.tag.endswith("normalmap") else None
            strength = self._numbers(scale.get("value", "1")) if scale is not None else (1.0,)
            return _times(found, strength[0])
        if node.tag == "invert":
            return replace(found, inverted=not found.inverted) if found.image else None
        if node.tag in ("extract", "swizzle") or node.tag.startswith("separate"):
            return self._channel(node, given, found)
        return None

    def _channel(self, node: Element, given: Element, found: Input) -> Input | None:
        """One channel of an image, by an index, by letters, or by the name of the output that was asked for."""
        index, letters = _child(node, "index"), _child(node, "channels")
        if node.tag == "extract":
            place = int(self._numbers(index.get("value", "0"))[0]) if index is not None else 0
        else:
            said = letters.get("value", "r") if letters is not None else (given.get("output") or "outr")[-1]
            place = _CHANNELS.get(said[:1], -1)
        if found.image is None or place not in (0, 1, 2):
            return None
        channel: Literal[0, 1, 2] = (0, 1, 2)[place]
        return replace(found, image=replace(found.image, channel=channel, transfer="linear"))

    def _product(self, node: Element, colour: bool, depth: int) -> Input | None:
        sides = [_child(node, name) for name in ("in1", "in2")]
        found = [self._has_followed(side, colour, depth) if side is not None else None for side in sides]
        one, other = found
        if one is None or other is None or (one.image and other.image):
            return None
        first, second = (one, other) if one.image else (other, one)
        count = max(len(first.factor), len(second.factor))
        pairs = zip(_spread(first.factor, count), _spread(second.factor, count), strict=True)
        return replace(first, factor=tuple(a * b for a, b in pairs))

    def _image(self, node: Element, given: Element, colour: bool) -> Input | None:
        file = _child(node, "file")
        if file is None or not file.get("value"):
            return None
        if moved := self._find_moved(node):
            moved = list(dict.fromkeys(moved))
            said = f"{', '.join(moved)} of texture coordinates {'are' if len(moved) > 1 else 'is'} passed over"
            self.notes += [] if said in self.notes else [said]
        named = "".join(each.get("fileprefix", "") for each in self._around(file)) + file.get("value", "")
        named = named.replace("\\", "/")
        space = self._space(file) if colour else ""
        transfer: TransferChoice = "auto" if space == AUTO else "linear"
        if colour and not space:
            shown = PurePosixPath(named).name[:60]
            self.notes.append(f"{shown} states no colour space, and is taken as linear Rec.709")
        asked = (given.get("output") or "")[-1:] if node.tag == "UsdUVTexture" else ""
        channel = None if colour or node.get("type") in ("vector3", "color3") else 0
        if asked in _CHANNELS and not colour:
            channel = _CHANNELS[asked] if given.get("output") in ("r", "g", "b") else channel
        shown = PurePosixPath(named).name
        chosen: Channel = "alpha" if asked == "a" else None if channel is None else (0, 1, 2)[channel]
        return Input(image=Image(Path(named), shown, transfer, chosen, space=space.removeprefix(AUTO)))

    def _find_moved(self, node: Element, depth: int = 0) -> list[str]:
        """What moves the texture coordinates of an image, by the names of inputs and nodes: those of the model hold."""
        moves = {} if node.tag == "UsdUVTexture" else {"tiling": 1.0} if node.tag.startswith("hextiled") else _MOVES
        moved = [name for name, usual in moves.items() if self._is_moved(_child(node, name), usual)]
        moved += ["hexagonal tiling"] if node.tag.startswith("hextiled") else []
        given = _child(node, "texcoord")
        source = self._source(given) if given is not None else None
        while source is not None and source.tag in ("input", "output", "nodegraph") and depth < _DEEPEST:
            outputs = [each for each in source if each.tag == "output"] if source.tag == "nodegraph" else []
            source, depth = self._source(outputs[0] if outputs else source), depth + 1
        if source is None or source.tag in _COORDINATES:
            return moved
        if source.tag == "place2d" and depth < _DEEPEST:
            return [*moved, *self._find_moved(source, depth + 1)]
        return [*moved, f"the node {source.tag[:40]}"]

    def _is_moved(self, given: Element | None, usual: float) -> bool:
        if given is None:
            return False
        found = self._has_followed(given, False, 0)
        return found is None or found.image is not None or any(abs(each - usual) > 1e-6 for each in found.factor)

    def _space(self, element: Element) -> str:
        """The name of the colour space of an element, in lower case; '' where nothing states one."""
        around = (element, *self._around(element))
        space = next((each.get("colorspace", "") for each in around if each.get("colorspace")), "")
        if space and space != AUTO and space.lower() not in SPACES:
            problem = f"states the colour space {space[:40]!r}, which is not known"
            raise InputError(self.path, problem, "Save it in lin_rec709, srgb_texture or acescg")
        return space.lower()

    def _to_rec709(self, values: tuple[float, ...], given: Element) -> tuple[float, ...]:
        """A colour of the space that its element states, as linear Rec.709."""
        space = self._space(given)
        if space in ("", AUTO) or SPACES[space].is_rec709:
            return values
        colour = SPACES[space].linear(np.asarray(values[:3], np.float64))
        return (*(float(each) for each in colour), *values[3:])

    def _around(self, element: Element) -> list[Element]:
        """The elements around one, the nearest first."""
        found = []
        while (parent := self.parents.get(element)) is not None:
            found.append(parent)
            element = parent
        return found

    def _numbers(self, text: str) -> tuple[float, ...]:
        try:
            values = tuple(float(each) for each in text.split(",")[:16])
        except ValueError:
            values = ()
        if not values or not all(math.isfinite(each) and abs(each) <= 1e6 for each in values):
            raise InputError(self.path, f"has an impossible value ({text[:40]!r})", AGAIN)
        return values


def _is_same(value: str, usual: str) -> bool:
    """True for equal numbers, however they are written, and for equal words."""
    try:
        one, other = ([float(each) for each in text.split(",")] for text in (value, usual))
    except ValueError:
        return value.strip().lower() == usual
    return one == other or (len(set(one)) == 1 and set(one) == set(other))


def _has_layers(shader: Element) -> bool:
    """True for an OpenPBR surface that states a layer."""
    stated = (name for name in (*WEIGHTS, "specular_color") if _child(shader, name) is not None)
    return shader.tag == "open_pbr_surface" and any(stated)


def _child(owner: Element, name: str) -> Element | None:
    """The input of that name."""
    return next((each for each in owner if each.tag == "input" and each.get("name") == name), None)


def _times(given: Input, factor: float) -> Input:
    return replace(given, factor=tuple(each * factor for each in given.factor))


def _spread(values: tuple[float, ...], count: int) -> tuple[float, ...]:
    return values if len(values) == count else (values[0],) * count
