"""K-tuples under light that changes step by step: what stays is kept, and what changes a little is added.

The quantised coefficients are integers, so sums updated ten thousand times are those of one fresh sum, bit for bit.
Adding what differs pays where few of them do, as when a lamp moves through a map or a patch of it is painted: it takes
one thread, and a second copy of all vectors, sorted by coefficient (some 8 bytes for each that is kept). Turning a map
changes all, and a fresh sum on all threads is quicker then. Lamps that stay cost nothing, while each that is looked up
anew costs a ray for every vertex.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import cached_property
from engine.light.lamps import Lamp
from engine.transport.wavelet.kernel import add_changes, by_coefficient, finish_sums
from engine.transport.wavelet.lighting import Lighting, lamp_tuples, mix
from engine.transport.wavelet.quantise import WaveletLight
from engine.transport.wavelet.transfer import WaveletTransport, reflect_light, relight_transport

#: Adding changes is taken where they touch less than this share of all kept coefficients: one thread, for which they
#: lie anywhere in memory, takes several times as long for each as the threads of a fresh sum.
CHEAPER = 0.05


class Relighter:
    """The K-tuples of one transport under one light after the other; for one thread at a time.

    The same numbers as `wavelet.lighting.tuples`, bit for bit, with whatever is the least work.
    """

    def __init__(self, transport: WaveletTransport) -> None:
        self.transport = transport
        self._light: WaveletLight | None = None
        self._around: NDArray[np.float64] | None = None
        self._relighting: Relighting | None = None
        self._lamps: tuple[tuple[Lamp, ...], NDArray[np.float64]] | None = None

    def tuples(self, lighting: Lighting) -> NDArray[np.float64]:
        """The light-modulated K-tuples (R, 3) under `lighting`, mixed where the transport has a mixture."""
        rows = self._under(lighting.light) + reflect_light(self.transport, lighting.light)
        if len(lighting.directional.direction):
            if self._lamps is None or self._lamps[0] != lighting.lamps:
                self._lamps = lighting.lamps, lamp_tuples(self.transport, lighting.directional)
            rows += self._lamps[1]
        return mix(self.transport, rows)

    def _under(self, light: WaveletLight) -> NDArray[np.float64]:
        before, self._light = self._light, light
        if before is None or self._around is None or len(before.quantised) != len(light.quantised):
            self._around = relight_transport(self.transport, light)
        elif not _same(before, light):
            self._around = self._changed(before, light)
        return self._around

    def _changed(self, before: WaveletLight, light: WaveletLight) -> NDArray[np.float64]:
        changed = (light.quantised != before.quantised).any(axis=1)
        if self._entries[changed].sum() > CHEAPER * self._entries.sum():
            return relight_transport(self.transport, light)
        if self._relighting is None:
            self._relighting = Relighting(self.transport, before)
        return self._relighting.update(light)

    @cached_property
    def _entries(self) -> NDArray[np.int64]:
        """(M,) how many vectors keep each coefficient."""
        vectors = self.transport.vectors
        kept = np.arange(vectors.indices.shape[1]) < vectors.counts[:, None]
        return np.bincount(vectors.indices[kept], minlength=6 * self.transport.edge**2)


def _same(one: WaveletLight, other: WaveletLight) -> bool:
    return (
        one.quantum == other.quantum
        and np.array_equal(one.scaling, other.scaling)
        and np.array_equal(one.quantised, other.quantised)
    )


class Relighting:
    """The K-tuples of one transport under light that changes step by step.

    `sums` of the products of quantised coefficients are kept as 64-bit integers, so that changes can be added without
    drift.
    """

    def __init__(self, transport: WaveletTransport, light: WaveletLight) -> None:
        self._transport = transport
        vectors = transport.vectors
        count = len(light.quantised)
        self._start, self._row, self._word = by_coefficient(vectors.indices, vectors.words, vectors.counts, count)
        self._sums = np.zeros((transport.rows, 3), np.int64)
        self._scaling = np.zeros((transport.rows, 3))
        self._light = WaveletLight(np.zeros((6, 3)), np.zeros_like(light.quantised), light.quantum, 0.0, 0.0)
        self.update(light)

    def update(self, light: WaveletLight) -> NDArray[np.float64]:
        """The tuples (R, 3) under `light`; quick where few of its coefficients differ from those before."""
        if len(light.quantised) != len(self._light.quantised):
            raise ValueError("the light has another edge than the one before")
        change = light.quantised.astype(np.int32) - self._light.quantised
        changed = np.flatnonzero(change.any(axis=1))
        add_changes(self._start, self._row, self._word, changed, change, self._sums)
        self._scaling[:] = 0.0
        add_changes(self._start, self._row, self._word, np.arange(6), light.scaling, self._scaling)
        self._light = light
        result = np.empty(self._scaling.shape)
        finish_sums(self._transport.vectors.peaks, self._sums, self._scaling, light.quantum, result)
        return result
