"""How hard friction grips: at once where bodies meet, gently while they slide.

MuJoCo's friction asks a sliding contact to stop within the time constant of `solreffriction`,
and what it asks above μN also pushes the bodies apart. Asking for rest within one engine step
is right for an impact, which lasts no longer, but makes a sliding box hop: 25 mm at 2 m/s and
μ = .4. Asked over `SLIDE` of a second it hops 0.4 mm and stops within 0.2 % of v²/2μg. So
friction is hard where bodies meet, and gentle where they have been close already.
"""

from __future__ import annotations

import numpy as np

from physagent_studio.simulation.clouds import Cloud
from physagent_studio.simulation.mj import Data
from physagent_studio.simulation.model import Compiled
from physagent_studio.simulation.surfaces import FloatArray

SLIDE = 1 / 120
"""s in which friction would stop the slip of a lasting contact."""


class Grip:
    """Keeps each pair's `solreffriction`: one value while it is apart, one once it is close.

    close: (npair,) 0 or 1, which pairs touch or are closer than they can come in one engine step
    without an impact; part of a snapshot.
    """

    def __init__(self, compiled: Compiled, dt: float) -> None:
        self._damping = compiled.model.pair_solreffriction
        self._table = compiled.pair_table
        self._impact = -1.0 / dt
        self._slide = max(-1.0 / SLIDE, 0.5 * self._impact)
        self.close = np.zeros(len(compiled.pair_bodies))
        self._loose = any(isinstance(handle, Cloud) for handle in compiled.handles)
        self._known: dict[bytes, frozenset[int]] = {}
        self._damping[:, 0] = -1.0
        self._hold(frozenset())

    def update(self, data: Data) -> None:
        """Takes over which pairs are close in the engine step just done."""
        if self._loose:
            pairs = self._pairs(data)
        else:
            # A rolling body runs through the same few sets of contacts again and again.
            key = data.contact.geom.tobytes()
            pairs = self._known.get(key)
            if pairs is None:
                pairs = self._known[key] = self._pairs(data)
        if pairs != self._now:
            self._hold(pairs)

    def _pairs(self, data: Data) -> frozenset[int]:
        geoms = data.contact.geom
        pairs = self._table[geoms[:, 0], geoms[:, 1]]
        if self._loose:
            # Deformables have no geoms (−1), and grains no pairs.
            pairs = pairs[(pairs >= 0) & (geoms >= 0).all(axis=1)]
        return frozenset(pairs.tolist())

    def _hold(self, pairs: frozenset[int]) -> None:
        rows = sorted(pairs)
        self._now = pairs
        self.close[:] = 0
        self._damping[:, 1] = self._impact
        if rows:
            self.close[rows] = 1
            self._damping[rows, 1] = self._slide

    def restore(self, close: FloatArray) -> None:
        """Sets the pairs that are close."""
        self._hold(frozenset(np.flatnonzero(close).tolist()))
