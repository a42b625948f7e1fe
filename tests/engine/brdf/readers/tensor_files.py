"""Writes tensor_file containers, and RGL measurements of a known material in them."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

TYPES = {"u1": 1, "i1": 2, "u2": 3, "i2": 4, "u4": 5, "i4": 6, "u8": 7, "i8": 8, "f2": 9, "f4": 10, "f8": 11}

Value = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def tensor_bytes(fields: Mapping[str, ArrayLike], order: Any = "<") -> bytes:
    """A tensor_file 1.0 with `fields`, each array at a multiple of 8 bytes behind the list; `order` as in `struct`."""
    arrays = {name: np.asarray(field) for name, field in fields.items()}
    start = 18 + sum(2 + len(name) + 11 + 8 * array.ndim for name, array in arrays.items())
    head, body = [b"tensor_file\0\x01\x00", struct.pack(f"{order}I", len(arrays))], b""
    for name, array in arrays.items():
        body += bytes(-(start + len(body)) % 8)
        kind = TYPES[array.dtype.str[1:]]
        head += [struct.pack(f"{order}H", len(name)), name.encode()]
        head += [struct.pack(f"{order}HBQ", array.ndim, kind, start + len(body))]
        head += [struct.pack(f"{order}{array.ndim}Q", *array.shape)]
        body += array.astype(array.dtype.newbyteorder(order)).tobytes()
    return b"".join(head) + body


def header_length(content: bytes) -> int:
    """The length of the list of fields of a small good file: up to the first array, or 8 bytes less."""
    (name_length,) = struct.unpack_from("<H", content, 18)
    (first,) = struct.unpack_from("<Q", content, 18 + 2 + name_length + 3)
    return int(first)


def fields_of(
    phi_i: ArrayLike,
    theta_i: ArrayLike,
    *,
    vndf: ArrayLike,
    values: ArrayLike,
    ndf: ArrayLike = ((1.0, 1.0), (1.0, 1.0)),
    sigma: ArrayLike = ((1.0, 1.0), (1.0, 1.0)),
    jacobian: int = 0,
    luminance: ArrayLike | None = None,
    wavelengths: ArrayLike | None = None,
    description: str = "made by a test",
) -> dict[str, NDArray[Any]]:
    """The fields of an RGL file; `values` (P, T, bands, Y, X)."""

    def single(array: ArrayLike) -> NDArray[np.float32]:
        return np.ascontiguousarray(array, np.float32)

    values = single(values)
    fields: dict[str, NDArray[Any]] = {
        "description": np.frombuffer(description.encode(), np.uint8),
        "phi_i": single(phi_i),
        "theta_i": single(theta_i),
        "sigma": single(sigma),
        "ndf": single(ndf),
        "vndf": single(vndf),
        "luminance": np.maximum(values.mean(axis=2), 1e-6) if luminance is None else single(luminance),
        "rgb" if wavelengths is None else "spectra": values,
        "jacobian": np.array([jacobian], np.uint8),
    }
    if wavelengths is not None:
        fields["wavelengths"] = single(wavelengths)
    return fields


def directions(x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
    """Unit vectors at the unit square's (x, y): theta = x² π/2, phi = (2y − 1) π."""
    theta, phi = np.broadcast_arrays(np.square(x) * np.pi / 2, (2 * np.asarray(y) - 1) * np.pi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def draw(density: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """The images of a grid of count × count numbers under a bilinear density (Y, X): (2, count, count), x and y.

    By interpolating its integrals on a grid 64 times as fine.
    """
    shares = np.linspace(0.0, 1.0, count)
    rows = _inverse(density.sum(axis=1) - 0.5 * (density[:, 0] + density[:, -1]), shares)
    places = np.empty((2, count, count))
    for index, place in enumerate(rows * (len(density) - 1)):
        low = min(int(place), len(density) - 2)
        line = density[low] + (place - low) * (density[low + 1] - density[low])
        places[:, index] = _inverse(line, shares), np.full(count, rows[index])
    return places


def _inverse(nodes: NDArray[np.float64], shares: NDArray[np.float64]) -> NDArray[np.float64]:
    at = np.linspace(0.0, 1.0, 64 * (len(nodes) - 1) + 1)
    values = np.interp(at, np.linspace(0.0, 1.0, len(nodes)), nodes)
    summed = np.concatenate([[0.0], np.cumsum(values[1:] + values[:-1])])
    return np.interp(shares, summed / summed[-1], at) if summed[-1] > 0.0 else shares


class AnisotropicGgx:
    """f = BRDF D G₁ G₁ / (4 cos cos), of which everything that an RGL file holds is known."""

    def __init__(self, alpha_x: float, alpha_y: float, bands: ArrayLike) -> None:
        self.alpha = np.array([alpha_x, alpha_y, 1.0])
        self.bands = np.asarray(bands, np.float64)

    def normals(self, half: NDArray[np.float64]) -> NDArray[np.float64]:
        slopes = half / self.alpha
        return np.asarray(1.0 / (np.pi * self.alpha[0] * self.alpha[1] * (slopes * slopes).sum(axis=-1) ** 2))

    def area(self, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(0.5 * (direction[..., 2] + np.linalg.norm(direction * self.alpha, axis=-1)))

    def f(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., bands) in 1/sr; G₁ / cos = 1 / area."""
        half = wi + wo
        half = half / np.linalg.norm(half, axis=-1, keepdims=True)
        shape = self.normals(half) / (4.0 * self.area(wi) * self.area(wo))
        return np.asarray(shape[..., None] * self.bands)

    def fields(
        self,
        phi_i: NDArray[np.float64],
        theta_i: NDArray[np.float64],
        *,
        nodes: int = 64,
        colours: int = 32,
        relative: bool = False,
        **more: Any,
    ) -> dict[str, NDArray[Any]]:
        """The fields of its measurement, with tables of nodes × nodes and a grid of colours × colours directions."""
        x, y = np.meshgrid(np.linspace(0, 1, nodes), np.linspace(0, 1, nodes))
        half = directions(x, y)
        jacobian = 2.0 * np.pi**2 * x * np.sin(x * x * np.pi / 2)
        vndf = np.empty((len(phi_i), len(theta_i), nodes, nodes))
        values = np.empty((len(phi_i), len(theta_i), len(self.bands), colours, colours))
        for p, phi in enumerate(phi_i):
            for t, theta in enumerate(theta_i):
                wi = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
                turned = _turn(half, phi) if relative else half
                vndf[p, t] = np.maximum(turned @ wi, 0.0) * self.normals(turned) * jacobian
                facets = directions(*draw(vndf[p, t], colours))
                facets = _turn(facets, phi) if relative else facets
                wo = 2.0 * (facets @ wi)[..., None] * facets - wi
                # f cos(theta_o) 4 sigma(wi) / D(h), which has a limit at the horizon
                shape = np.where(wo[..., 2] > 0.0, wo[..., 2] / self.area(wo * np.sign(wo[..., 2:])), 0.0)
                values[p, t] = self.bands[:, None, None] * shape
        tables = {"ndf": self.normals(half), "sigma": self.area(half), "jacobian": 1}
        return fields_of(phi_i, theta_i, vndf=vndf, values=values, **cast(Any, tables), **more)


def _turn(vectors: NDArray[np.float64], phi: float) -> NDArray[np.float64]:
    """`vectors` (..., 3) turned by phi about the normal."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([np.cos(phi) * x - np.sin(phi) * y, np.sin(phi) * x + np.cos(phi) * y, z], axis=-1)
