"""Spherical harmonics under light and from views that change in turn: only what has moved is worked out anew.

A light that stays keeps its coefficients at the vertices (the paper's fixed light): moving the camera costs a frame and
nothing else. A view that stays while lights change gets the BRDF rotated into the world once (its fixed view): a
new light is then 3 order² products for each vertex in place of order⁴, and a frame looks no table up. For 50,000
vertices at order 5 a new light and its frame with software GL take a third of the time.

The window does not use it: its camera moves between two lights without waiting for one, and what holds for one view
would show the highlights of the view before until the next light is there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.diffuse import Lambert
from engine.core.directions import Vectors, normalize
from engine.transport.relight import RelightSh
from engine.transport.sh import kernel
from engine.transport.sh.brdf_table import lambert_table
from engine.transport.sh.transfer import Floats, ShTransport, local_views, transfer, view_vectors
from engine.transport.wavelet.transfer import GRAZING


class Relighter:
    """One transport under one light after the other, seen from one point after the other; for one thread at a time.

    Call `relit` whenever the light or the eye has moved, and draw what it returns. From the second light for one eye on
    that holds for this eye only, and `is_for` says so: its vertices have the radiance that they send there.
    """

    def __init__(self, transport: ShTransport) -> None:
        self.transport = transport
        self._light: Floats | None = None
        self._eye: tuple[float, ...] | None = None
        self._view: tuple[float, ...] | None = None
        self._shown: RelightSh | None = None
        self._vectors: NDArray[np.float32] | None = None
        self._seen: ShTransport | None = None

    def relit(self, light: Floats, eye: ArrayLike) -> RelightSh:
        """The transport under `light`, (order², 3) or (V, order², 3) as for `transfer`, to be seen from `eye` (3,).

        A new light for the same eye takes the fixed view, anything else the fixed light. What is drawn is the same.
        """
        place = tuple(float(x) for x in np.asarray(eye))
        new_light = self._light is None or not np.array_equal(light, self._light)
        same_view, self._light, self._eye = place == self._eye, np.array(light), place
        if self._shown is not None and not new_light and self.is_for(self._shown, place):
            return self._shown
        if not same_view:
            self._vectors = None
        if same_view and new_light and not self.transport.diffuse:
            if self._vectors is None:
                self._vectors = view_vectors(self.transport, _find_drawn_views(self.transport, place))
            self._shown = RelightSh(self._flat, shade_fixed_view(self._vectors, np.asarray(light, np.float32)))
            self._view = place
        else:
            self._shown = RelightSh(self.transport, transfer(self.transport, light))
        return self._shown

    def is_for(self, relit: RelightSh, eye: ArrayLike) -> bool:
        """True if `relit`, which came from here, can be seen from `eye` (3,)."""
        return relit.transport is self.transport or tuple(float(x) for x in np.asarray(eye)) == self._view

    @property
    def _flat(self) -> ShTransport:
        """A surface on which every vertex is as bright towards every side."""
        if self._seen is None:
            order, mesh = self.transport.order, self.transport.mesh
            nothing = np.broadcast_to(np.float32(0.0), (len(mesh.positions), 1, order**2))
            white = lambert_table(Lambert((1.0, 1.0, 1.0)), order)
            self._seen = ShTransport(mesh, 0, True, 1.0, white, False, nothing)
        return self._seen


def _find_drawn_views(transport: ShTransport, eye: ArrayLike) -> Vectors:
    """`local_views` as images take them: a vertex of a face that is seen may be turned away itself."""
    local = local_views(transport, eye)
    local[:, 2] = np.maximum(local[:, 2], GRAZING)
    return normalize(local)


def shade_fixed_view(vectors: NDArray[np.float32], light: NDArray[np.float32]) -> NDArray[np.float32]:
    """Radiance (V, 3) of `vectors` (V, 3, n), which are for one view, under `light` (n, 3) or (V, n, 3)."""
    radiance = np.empty(vectors.shape[:2], np.float32)
    if light.ndim == 3:
        kernel.transfer_each(vectors, light, 1, radiance)
    else:
        kernel.transfer(vectors, light, radiance)
    return radiance
