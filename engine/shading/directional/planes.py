"""The directional shading map: for each texel a few numbers, the planes, that give its radiance under any light.

Texels x, the values of all photographs, are projected on the vectors v_k in which they vary most (principal
components); plane k holds v_k · (x − mean) in eight bits. A photograph of a new direction is a weighted sum of the
photographs (`engine.shading.directional.interpolation`), and so of the mean and of the planes. It continues the shading
map of Kautz2004, whose S(r) knows the elevation of the light alone. The number of planes is the least whose error,
each photograph left out in turn, is nearly the least that a budget of bytes allows.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.capture.object_part import object_mask
from engine.capture.stack import ImageStack
from engine.core.cached import cached_property
from engine.core.colour import srgb_decode
from engine.core.directions import Vectors, surface_direction
from engine.core.errors import OutputError
from engine.core.side_by_side import side_by_side
from engine.core.steps import Step, Steps, part
from engine.shading.directional.effective_light import TILTS, TURNS, table_directions, weights_at
from engine.shading.directional.interpolation import STATED, Kernel, best_kernel, weights
from engine.shading.directional.minified import minify
from engine.shading.directional.moments import Moments, make_reader, moments
from engine.shading.directional.planes_kernel import add_planes, choose_branches, round_values, shorten_values
from engine.storage.scratch import open_unnamed, scratch_place

Array = NDArray[np.float64]

#: Numbers of planes among which is chosen, and how much larger than the least the error of fewer may be.
SWEEP, NEARLY = (1, 2, 3, 5, 7, 9, 12, 15, 18, 22, 27, 33, 40, 48, 56, 64, 80, 96, 128), 1.002

#: Bytes of a texel that are spent unless others are asked for, as much as a shading map of eight slices has; and of a
#: map, beyond which it has no more than `FEW` planes.
BUDGET, MAP_BYTES, FEW = 96, 512 << 20, 27

#: Noise of the kernel, over the best without planes, that is tried with them: planes leave out noise by themselves.
NOISES = (1.0, 0.3, 0.1)

#: Photographs that are left out in turn, evenly over the list: each takes a decomposition of a matrix of 3 N.
FOLDS = 64

#: Codes of a plane.
STEPS = 255

#: Bytes of planes in sixteen bits that are kept, in memory or in a scratch file, until their ranges are known.
KEPT_BYTES = 8 << 30

#: The least sine of elevation at which light still shines: what is lower is dimmed as its cosine.
LOWEST = 1e-3


@dataclass(frozen=True, eq=False)
class DirectionalMap:
    """Radiance of a material for light from any direction.

    Attributes
    ----------
    planes : (K, H, W) uint8.
    low, step : (K,) the value of plane k is low + step · code.
    mean : (3 N,) codes of the photographs, and vectors : (3 N, K) of them, orthonormal where they are fitted here.
    lights : (N, 3) unit vectors towards the lamps, above the sample plane.
    kernel : by which photographs are interpolated.
    r_max : mean luminance of the brightest photograph, radiance.
    leave_one_out, in_sample, mean_picture : root mean squares over texels, channels and photographs, in codes of 8-bit
        sRGB, of predicting a photograph from the others, of all photographs, and of the mean of the others instead;
        NaN where the photographs are not known.
    """

    planes: NDArray[np.uint8]
    low: Array
    step: Array
    mean: Array
    vectors: Array
    lights: Vectors
    kernel: Kernel
    r_max: float
    leave_one_out: float
    in_sample: float
    mean_picture: float

    @property
    def bytes_per_texel(self) -> int:
        return len(self.planes)

    @property
    def has_lamps(self) -> bool:
        """True where `lights` are those of lamps, and not directions at which functions are given."""
        return self.kernel.basis not in STATED or self.kernel.basis == "gauss"

    @property
    def lowest(self) -> float:
        """The cosine of the lowest lamp; light below it is dimmed in proportion.

        What another program describes is shown as it shows it, down to the horizon.
        """
        return LOWEST if self.kernel.basis in STATED else max(float(self.lights[:, 2].min()), LOWEST)

    @cached_property
    def table(self) -> NDArray[np.float32]:
        """(TILTS, TURNS, 3, 1 + K) the weights of `functions` at `table_directions`, between which they are linear."""
        found = self.functions(table_directions().reshape(-1, 3))
        return found.reshape(TILTS, TURNS, *found.shape[1:]).astype(np.float32)

    @cached_property
    def smaller(self) -> list[NDArray[np.float16]]:
        """The planes (K, h, w) at half the size, at a quarter … down to one texel, of which light sees the mean."""
        return minify(self)

    def at_least(self, side: int) -> NDArray[np.uint8] | NDArray[np.float16]:
        """The planes at the smallest size whose longer side has so many texels; all of fewer."""
        if max(self.planes.shape[1:]) < 2 * side:
            return self.planes
        return [planes for planes in self.smaller if max(planes.shape[1:]) >= side][-1]

    def functions(self, light: Vectors) -> Array:
        """(M, 3, 1 + K) weights of 1 and of the planes in the sRGB code of each channel, for directions (M, 3)."""
        of_photographs = weights(self.lights, light, self.kernel)
        count = len(self.lights)
        constant = of_photographs @ self.mean.reshape(count, 3)
        shares = np.einsum("mn,nck->mck", of_photographs, self.vectors.reshape(count, 3, -1))
        return np.concatenate([(constant + shares @ self.low)[..., None], shares * self.step], axis=-1)

    def sample(self, texels: NDArray[Any], cosine: Array, azimuth: Array) -> Array:
        """(T, M, 3) radiance of `texels` (T, K), codes of planes, under unit light at cosines and azimuths (M,)."""
        functions = weights_at(self.table, cosine, azimuth)
        planes = np.ascontiguousarray(texels.T, np.float64)
        shares = np.empty((len(cosine), len(texels), 3))
        linear = np.empty_like(shares)
        add_planes(planes, functions, shares, linear)
        np.power(linear, 2.4, out=linear)
        choose_branches(shares, np.minimum(cosine / self.lowest, 1.0), linear)
        return linear.swapaxes(0, 1)

    def image(self, light: Vectors) -> NDArray[np.float32]:
        """(H, W, 3) linear radiance under unit light from one direction (3,); black from below."""
        light = np.asarray(light, np.float64)
        dimmed = min(max(float(light[2]), 0.0) / self.lowest, 1.0)
        if dimmed == 0.0:
            return np.zeros((*self.planes.shape[1:], 3), np.float32)
        functions = self.functions(light[None])[0].astype(np.float32)
        codes = np.tensordot(self.planes.astype(np.float32), functions[:, 1:], axes=(0, 1)) + functions[:, 0]
        return np.asarray(srgb_decode(np.maximum(codes, 0.0) / np.float32(255.0)) * np.float32(dimmed))


def fit(stack: ImageStack, used: NDArray[np.int64], most: int = BUDGET) -> Steps[DirectionalMap]:
    """The directional map of the photographs `used`, which have an azimuth; with `most` planes or fewer, a byte each.

    ValueError for a stack without azimuths. Reads each photograph twice.
    """
    found = yield from part(moments(stack, used), 0.0, 0.5)
    return (yield from part(fit_planes(stack, used, found, most), 0.5, 1.0))


class Choice(NamedTuple):
    """The `kernel` of a map, its `vectors` (3 N, K), and the error of leaving each photograph out."""

    kernel: Kernel
    vectors: Array
    leave_one_out: float


def fit_planes(stack: ImageStack, used: NDArray[np.int64], found: Moments, most: int = BUDGET) -> Steps[DirectionalMap]:
    """The same where the moments are known."""
    choice = yield from part(choose_planes(stack, used, found, most), 0.0, 0.3)
    return (yield from part(project(stack, used, found, choice), 0.3, 1.0))


def choose_planes(stack: ImageStack, used: NDArray[np.int64], found: Moments, most: int = BUDGET) -> Steps[Choice]:
    """The best map of the photographs `used` as their moments tell it; no pixel is read."""
    lights = directions(stack, used)
    best = best_kernel(lights, found.average_channels())
    kernels = [replace(best, noise=share * best.noise) for share in NOISES]
    height, width = stack.radiance.shape[1:3]
    counts = sweep(len(used), min(most, max(FEW, MAP_BYTES // (height * width))))
    tried = yield from errors_by_planes(lights, found, kernels, counts)
    kernel = min(tried, key=lambda each: min(tried[each].values()))
    count = choose(tried[kernel])
    return Choice(kernel, components(found.covariance, count), tried[kernel][count])


def project(stack: ImageStack, used: NDArray[np.int64], found: Moments, choice: Choice) -> Steps[DirectionalMap]:
    """The map of the photographs `used` that was chosen by their moments."""
    kernel, vectors, error = choice
    lights = directions(stack, used)
    planes, low, step, noise = yield from _project(stack, used, found.mean, vectors)
    own = weights(lights, lights, kernel)
    inside = np.hypot(_error(found, vectors, own), _estimate_noise(vectors, own, noise))
    mean_of_others = (1.0 - np.eye(len(used))) / max(len(used) - 1, 1)
    plain = _rms(found, np.einsum("ij,cd->icjd", mean_of_others - np.eye(len(used)), np.eye(3)))
    figures = (float(np.hypot(error, _estimate_noise(vectors, own, noise))), float(inside), plain)
    r_max = float(stack.mean_radiance[used].max())
    return DirectionalMap(planes, low, step, found.mean, vectors, lights, kernel, r_max, *figures)


def directions(stack: ImageStack, used: NDArray[np.int64]) -> Vectors:
    """(N, 3) towards the lamps of the photographs `used`."""
    if stack.azimuth is None:
        raise ValueError("a directional map needs the azimuth of each lamp")
    return surface_direction(0.5 * np.pi - stack.elevation[used], stack.azimuth[used])


def sweep(photographs: int, most: int = BUDGET) -> tuple[int, ...]:
    """Numbers of planes that are worth trying: fewer than the values of a texel of which one photograph is left out."""
    top = min(max(1, 3 * (photographs - 1) - 1), most, SWEEP[-1])
    return (*(count for count in SWEEP if count < top), top)


def choose(errors: dict[int, float]) -> int:
    """The least number of planes whose error is nearly the least."""
    least = min(errors.values())
    return min(count for count, error in errors.items() if error <= NEARLY * least)


def components(covariance: Array, count: int) -> Array:
    """(3 N, count) the vectors in which texels vary most, with a sign that does not depend on the machine."""
    from scipy.linalg import eigh

    last = len(covariance) - 1
    _, vectors = eigh(covariance, subset_by_index=(max(last - count + 1, 0), last), check_finite=False)
    vectors = vectors[:, ::-1]
    largest = vectors[np.abs(vectors).argmax(axis=0), np.arange(vectors.shape[1])]
    return np.asarray(vectors * np.where(largest < 0.0, -1.0, 1.0))


def errors_by_planes(
    lights: Vectors, found: Moments, kernels: Sequence[Kernel], counts: tuple[int, ...]
) -> Steps[dict[Kernel, dict[int, float]]]:
    """Root mean square of predicting a photograph from planes that are made of the others, by kernel and number.

    With f_k the weighted vectors v_k, eigenvectors of the covariance C of the others with eigenvalues λ_k, K planes
    show Σ f_k v_k·d of a texel's deviation d: the mean square of its difference from the photograph's own d_c is
    C_cc + Σ f_k² λ_k − 2 f_k v_k·C_c, a running sum over k. Bound by the decomposition for each photograph that is
    left out, of which no kernel is part.
    """
    total = len(lights)
    folds = np.unique(np.linspace(0, total - 1, min(total, FOLDS)).round().astype(np.int64))
    squares = {kernel: dict.fromkeys(counts, 0.0) for kernel in kernels}
    covariance, mean = found.covariance, found.mean.reshape(total, 3)

    def by_kernel(out: np.int64) -> list[Array]:
        """For each kernel the mean square over channels of predicting photograph `out` from 1, 2 … planes."""
        others = np.flatnonzero(np.arange(total) != out)
        values, own = (3 * others[:, None] + np.arange(3)).ravel(), 3 * out + np.arange(3)
        within, across = covariance[np.ix_(values, values)], covariance[np.ix_(values, own)]
        vectors = components(within, max(counts))
        spread, shared = np.einsum("vk,vk->k", vectors, within @ vectors), vectors.T @ across
        left = []
        for kernel in kernels:
            of_others = weights(lights[others], lights[out][None], kernel)[0]
            functions = np.einsum("n,nck->kc", of_others, vectors.reshape(len(others), 3, -1))
            gained = np.cumsum(functions**2 * spread[:, None] - 2.0 * functions * shared, axis=0)
            offset = of_others @ mean[others] - mean[out]
            left.append(np.mean(np.maximum(np.diag(covariance)[own] + gained, 0.0) + offset**2, axis=1))
        return left

    with closing(side_by_side(by_kernel, folds)) as all_left:
        for at, lefts in enumerate(all_left):
            yield Step((at + 1) / len(folds), "leaving photographs out")
            for kernel, left in zip(kernels, lefts, strict=True):
                for count in counts:
                    squares[kernel][count] += float(left[count - 1])
    return {
        kernel: {count: float(np.sqrt(square / len(folds))) for count, square in by_count.items()}
        for kernel, by_count in squares.items()
    }


def _error(found: Moments, vectors: Array, of_photographs: Array) -> float:
    """Root mean square of all photographs as planes show them, minus them.

    A texel's deviation d from the mean gives V Vᵀ d instead, of which `of_photographs` (N, N) is the weighted sum.
    """
    count = len(of_photographs)
    functions = np.einsum("mn,nck->mck", of_photographs, vectors.reshape(count, 3, -1)).reshape(3 * count, -1)
    apart = functions @ vectors.T - np.eye(3 * count)
    offset = (of_photographs @ found.mean.reshape(count, 3)).ravel() - found.mean
    spread = np.einsum("ij,ij->i", apart @ found.covariance, apart)
    return float(np.sqrt(np.mean(np.maximum(spread, 0.0) + offset**2)))


def _rms(found: Moments, apart: Array) -> float:
    flat = apart.reshape(-1, len(found.mean))
    return float(np.sqrt(max(np.einsum("ij,ij->", flat @ found.second, flat) / len(flat), 0.0)))


def _estimate_noise(vectors: Array, of_photographs: Array, noise: Array) -> float:
    """Root mean square that the rounding of the planes, variances `noise` (K,), adds to photographs."""
    count = of_photographs.shape[1]
    shares = np.einsum("mn,nck->mck", of_photographs, vectors.reshape(count, 3, -1))
    return float(np.sqrt(np.mean((shares**2) @ noise)))


def _project(
    stack: ImageStack, used: NDArray[np.int64], mean: Array, vectors: Array
) -> Steps[tuple[NDArray[np.uint8], Array, Array, Array]]:
    """The planes in eight bits, their ranges, and the variance of their rounding.

    The range of a plane is known after its last texel: values are kept until then where they fit in `KEPT_BYTES` and on
    the disk, and are else projected again, which reads the photographs once more. It is that of the texels of the
    object where the stack shows it alone: the black ones around it come as near to black as the planes then can.
    """
    height, width = stack.radiance.shape[1:3]
    mask = object_mask(stack)
    inside = np.ones((height, width), np.bool_) if mask is None else mask
    count = vectors.shape[1]
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    planes, noise = np.empty((count, height, width), np.uint8), np.zeros(count)
    with ExitStack() as held:
        kept = _keep_values(stack, count, held)
        share = 0.5 if kept is None else 0.8
        with closing(_project_pieces(stack, used, mean, vectors, inside)) as pieces:
            for piece in pieces:
                low, high = np.minimum(low, piece.least), np.maximum(high, piece.largest)
                if kept is not None:
                    kept.add(piece)
                yield Step(share * piece.last / height, "writing planes")
        step = (high - low) / STEPS
        step[step <= 0.0] = 1.0
        narrow_low, narrow_step = low.astype(np.float32), step.astype(np.float32)

        def round_piece(piece: _Piece) -> tuple[int, Array]:
            squares = np.empty(count)
            of_piece = piece.codes, piece.low, piece.step, piece.first
            round_values(*of_piece, narrow_low, narrow_step, inside, planes, squares)
            return piece.last, squares

        again = _project_pieces(stack, used, mean, vectors, inside) if kept is None else kept.read()
        with closing(again), closing(side_by_side(round_piece, again)) as rounded:
            for last, squares in rounded:
                noise += squares
                yield Step(share + (1.0 - share) * last / height, "writing planes")
    return planes, low, step, noise * step**2 / int(inside.sum())


@dataclass(frozen=True, eq=False)
class _Piece:
    """Planes in the rows from `first` to before `last`.

    Attributes
    ----------
    codes : (K, rows, W) uint16, values of planes as `low` + `step` · code of each row, whose range they have.
    low, step : (K, rows, 2) of the texels that count, and of those around an object, whose values may lie far from
        theirs.
    least, largest : (K,) of the values that count.
    """

    first: int
    last: int
    codes: NDArray[np.uint16]
    low: NDArray[np.float32]
    step: NDArray[np.float32]
    least: NDArray[np.float32]
    largest: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class _KeptValues:
    """Pieces of planes: their arrays, or where these lie one after the other in a `file` without a name."""

    file: IO[bytes] | None
    pieces: list[_Piece] = field(default_factory=list)

    def add(self, piece: _Piece) -> None:
        """Add the rows that follow those before them."""
        if self.file is not None:
            self.file.write(piece.codes.data)
            piece = replace(piece, codes=np.broadcast_to(np.uint16(0), piece.codes.shape))
        self.pieces.append(piece)

    def read(self) -> Generator[_Piece]:
        """The pieces in the order in which they were added."""
        if self.file is not None:
            self.file.seek(0)
        for piece in self.pieces:
            if self.file is None:
                yield piece
                continue
            codes = np.empty(piece.codes.shape, np.uint16)
            self.file.readinto(codes.data.cast("B"))  # type: ignore[attr-defined]
            yield replace(piece, codes=codes)


def _keep_values(stack: ImageStack, count: int, held: ExitStack) -> _KeptValues | None:
    """Room for the values of `count` planes, a file as long as it is `held`; None where they are too many."""
    size_bytes = 2 * count * math.prod(stack.radiance.shape[1:3])
    if size_bytes > KEPT_BYTES:
        return None
    try:
        place = scratch_place(size_bytes, stack.folder)
        return _KeptValues(None if place is None else held.enter_context(open_unnamed(place, size_bytes)))
    except (OSError, OutputError):
        return None


def _project_pieces(
    stack: ImageStack, used: NDArray[np.int64], mean: Array, vectors: Array, inside: NDArray[np.bool_]
) -> Generator[_Piece]:
    """The values of planes piece by piece; texels `inside` (H, W) count."""
    width, turned = stack.radiance.shape[2], vectors.T.astype(np.float32)
    reader = make_reader(stack, used, mean.astype(np.float32))

    def project(rows: tuple[int, int]) -> _Piece:
        first, last = rows
        values = np.empty((len(turned), (last - first) * width), np.float32)
        for start, stop, block in reader.read_blocks(first, last):
            values[:, (start - first) * width : (stop - first) * width] = turned @ block
        of_rows, counts = values.reshape(len(turned), last - first, width), inside[first:last]
        low, high = np.zeros((*of_rows.shape[:2], 2), np.float32), np.zeros((*of_rows.shape[:2], 2), np.float32)
        least, largest = np.full(len(turned), np.inf, np.float32), np.full(len(turned), -np.inf, np.float32)
        for row, shown in enumerate(counts):
            for kind, texels in enumerate((shown, ~shown)):
                if texels.any():
                    own = of_rows[:, row] if texels.all() else of_rows[:, row, texels]
                    low[:, row, kind], high[:, row, kind] = own.min(axis=1), own.max(axis=1)
            if shown.any():
                least, largest = np.minimum(least, low[:, row, 0]), np.maximum(largest, high[:, row, 0])
        step = np.maximum((high - low) / np.float32(np.iinfo(np.uint16).max), np.finfo(np.float32).tiny)
        codes = np.empty(of_rows.shape, np.uint16)
        shorten_values(of_rows, counts, low, step, codes)
        return _Piece(first, last, codes, low, step, least, largest)

    return side_by_side(project, reader.list_pieces())
