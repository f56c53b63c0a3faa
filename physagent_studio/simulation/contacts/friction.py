"""How hard friction grips: at once where bodies meet, gently while they slide.

MuJoCo's friction asks a sliding contact to stop within the time constant of `solreffriction`,
and what it asks above μN also pushes the bodies apart. Asking for rest within one engine step
is right for an impact, which lasts no longer, but makes a sliding box hop: 25 mm at 2 m/s and
μ = .4. Asked over `SLIDE` of a second it hops 0.4 mm and stops within 0.2 % of v²/2μg. So
friction is hard where bodies meet, and gentle where they have been close already.

Gentle friction keeps a slide as it is, whatever else happens to the body. Where something rocks
or tumbles on its edges the next impact is due at a contact that is there already, and keeping
the slide through it would push the body along its way: a box of restitution .7 gained a tenth of
its energy in a bounce. So what rocks rather than slides grips hard, as an impact of that speed
would stop the slide: with rest as the aim no impact gains energy.

The same holds for what is wedged: a ring on a cone touches it all around, what pushes it off at one
side pushes it on at the other, and gentle friction kept it rattling for ever.
"""

import math
from collections import Counter
from collections.abc import Sequence
from itertools import combinations
from typing import TypeAlias

import numpy as np

from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.contacts.touches import ContactLog
from physagent_studio.simulation.model.model import MEETING, Compiled
from physagent_studio.simulation.surfaces import FloatArray, IntArray

SLIDE = 1 / 120
"""s in which friction would stop the slip of a lasting contact."""

TUMBLING = 0.25
"""Share of the slide from which on what turning does matters more."""

NOTHING: frozenset[int] = frozenset()

GripState: TypeAlias = tuple[frozenset[int], frozenset[int], frozenset[int]]
"""The pairs that are close, those that are engaged and those that rock."""


class Grip:
    """Keeps each pair's `solreffriction`: hard while it is apart or rocks, gentle once it is close.

    Close are pairs that touch or are closer than they can come in one engine step without an
    impact: now; engaged those of them that have touched since they came close. awaits: whether some
    have not, or may not have where deformables or grains are about. rocking: those that rock, see
    `MEETING`. loose: whether there are
    deformables or grains, which come close and apart all the time. alone: whether of every two
    things that are close one is close to nothing else, all supports being one thing. firm: whether
    nothing grips gently at the moment, see `liveliness`.
    """

    def __init__(self, compiled: Compiled, dt: float) -> None:
        damping = compiled.model.pair_solreffriction
        self._damping = damping[:, 1]
        self._table = compiled.pair_table
        self._view = compiled.contacts
        self._impact = -1.0 / dt
        self._slide = max(-1.0 / SLIDE, 0.5 * self._impact)
        self.loose = any(isinstance(handle, Cloud) for handle in compiled.handles)
        self._known: dict[bytes, frozenset[int]] = {}
        self._coded: dict[frozenset[int], frozenset[int]] = {}
        self._sets: dict[frozenset[int], frozenset[int]] = {NOTHING: NOTHING}
        self._bodies = compiled.pair_bodies.tolist()
        model = compiled.model
        ends = np.stack([model.pair_geom1, model.pair_geom2], 1)
        both = [compiled.contacts.coded(two).tolist() for two in (ends, ends[:, ::-1])]
        self._codes = list(zip(*both, strict=True))
        self._objects = len(compiled.handles) if compiled.reach is not None else 0
        self._alone: dict[frozenset[int], bool] = {NOTHING: self._objects > 0}
        damping[:, 0] = -1.0
        damping[:, 1] = self._impact
        self._geom_bodies = compiled.geom_bodies.tolist()
        counts = Counter((min(two), max(two)) for two in self._bodies)
        rigid = compiled.reach is not None
        # Two bodies of which one at least has several parts that collide.
        self._compound = {two for two, count in counts.items() if rigid and count > 1}
        self._objects_at = () if compiled.reach is None else compiled.reach.objects
        self._things = 1 + max((max(two) for two in self._bodies), default=0)
        # The engine's state stays where it is in memory.
        self._places, self._rates = compiled.data.qpos, compiled.data.qvel
        # Where turning is kept in `qvel`, and its square below which nothing rocks.
        self._turning = [
            (at + 3, 0.99 * (MEETING / 2 / lever) ** 2)
            for _, at, _, lever in self._objects_at
            if lever > 0
        ]
        self.now = self.engaged = self.rocking = NOTHING
        self.awaits = self.loose
        self.firm = False
        self.alone = self._objects > 0

    @property
    def state(self) -> GripState:
        """What a snapshot keeps, see `rows`."""
        return self.now, self.engaged, self.rocking

    def rows(self, states: Sequence[GripState]) -> FloatArray:
        """(len(states), npair) 0 apart, 1 close, 2 engaged, 2 more if rocking."""
        known = {state: index for index, state in enumerate(dict.fromkeys(states))}
        table = np.zeros((len(known), len(self._bodies)))
        for row, (now, engaged, rocking) in zip(table, known, strict=True):
            row[list(now)] = 1
            row[list(engaged)] += 1
            row[list(rocking)] += 2
        return table[[known[state] for state in states]]

    def gather(self, count: int) -> None:
        """Adds the pairs that have come close in the engine step just done.

        What parts stays gentle to the end of its control step: a hop of a hundredth of a second
        is part of sliding or rolling, its landing no impact of its own. count: of the contacts
        that there are.
        """
        pairs = self._close(count)
        if pairs is not self.now and not pairs <= self.now:
            pairs = self._one(pairs | self.now)
            self._hold(pairs, self._hard(pairs))

    def update(self, count: int) -> frozenset[int]:
        """Takes over which pairs are close at the end of a control step; those that are no more.

        count: of the contacts that there are.
        """
        pairs = self._close(count)
        rocking = self._hard(pairs) if pairs else NOTHING
        if pairs is self.now and rocking == self.rocking:
            return NOTHING
        parted = self.now - pairs
        self._hold(pairs, rocking)
        return parted

    def note(self, log: ContactLog, since: int) -> bool:
        """Notes which pairs have touched since an engine step; True if all that are close have.

        Which are close must be known from `update` already.
        """
        if self.now and self.awaits:
            touched = self._pairs(log.active_geoms(since)) & self.now
            self._engage(touched | self.engaged)
        return not self.awaits

    def _close(self, count: int) -> frozenset[int]:
        """The pairs that are close now; equal sets are one object."""
        if self.loose:
            return self._one(self._pairs(self._view.geoms()))
        if not count:
            return NOTHING
        now = self._view.now(count)
        key = now.tobytes()
        pairs = self._known.get(key)
        if pairs is None:
            # What rolls changes its contacts all the time, and hardly ever whom it touches.
            codes = frozenset(now.tolist())
            pairs = self._coded.get(codes)
            if pairs is None:
                pairs = self._coded[codes] = self._one(self._pairs(self._view.geoms()))
            self._known[key] = pairs
        return pairs

    def _one(self, pairs: frozenset[int]) -> frozenset[int]:
        return self._sets.setdefault(pairs, pairs)

    def _pairs(self, geoms: IntArray) -> frozenset[int]:
        pairs = self._table[geoms[:, 0], geoms[:, 1]]
        if self.loose:
            # Deformables have no geoms (−1), and grains no pairs.
            pairs = pairs[(pairs >= 0) & (geoms >= 0).all(axis=1)]
        return frozenset(pairs.tolist())

    def _hold(self, pairs: frozenset[int], rocking: frozenset[int]) -> None:
        was, gentle, damping = self.now - self.rocking, pairs - rocking, self._damping
        for pair in was - gentle:
            damping[pair] = self._impact
        for pair in gentle - was:
            damping[pair] = self._slide
        self.now, self.rocking = pairs, rocking
        alone = self._alone.get(pairs)
        if alone is None:
            alone = self._alone[pairs] = self._are_alone(pairs)
        self.alone = alone
        self._engage(pairs & self.engaged)

    def _hard(self, pairs: frozenset[int]) -> frozenset[int]:
        """Those of the pairs that rock or are wedged."""
        if self.firm:
            return pairs
        rocking = self._rocks(pairs) if self._turning else NOTHING
        return rocking | self._wedged() if self._compound and len(pairs) > 1 else rocking

    def _wedged(self) -> frozenset[int]:
        """The pairs of two bodies that touch each other from opposite sides."""
        view, found = self._view, NOTHING
        sides: dict[tuple[int, int], list[tuple[int, list[float]]]] = {}
        at = view.at["frame"]
        for row, (one, other) in enumerate(view.geoms().tolist()):
            two = self._geom_bodies[one], self._geom_bodies[other]
            turned = two[0] > two[1]
            two = (two[1], two[0]) if turned else two
            if two in self._compound:
                normal = view.numbers[row, at : at + 3].tolist()
                pair = int(self._table[one, other])
                sides.setdefault(two, []).append((pair, [-x for x in normal] if turned else normal))
        for seen in sides.values():
            # A few of them tell: where many touch, those beside one another do so alike.
            some = [normal for _, normal in seen[:: max(1, len(seen) // 6)]]
            if any(a * x + b * y + c * z < 0 for (a, b, c), (x, y, z) in combinations(some, 2)):
                found |= {pair for pair, _ in seen}
        return found

    def _rocks(self, pairs: frozenset[int]) -> frozenset[int]:
        """Those of the pairs in which a point may come at the other body faster than `MEETING`."""
        rates = self._rates.tolist()
        for at, most in self._turning:
            a, b, c = rates[at : at + 3]
            if a * a + b * b + c * c > most:
                return self._rocking(pairs, rates)
        return NOTHING

    def _rocking(self, pairs: frozenset[int], rates: list[float]) -> frozenset[int]:
        """`_rocks` where something turns fast enough. rates: `qvel`."""
        lively = [0.0] * self._things
        for index, (_, at, _, lever) in enumerate(self._objects_at):
            a, b, c = rates[at + 3 : at + 6]
            speed = lever * math.sqrt(a * a + b * b + c * c)
            if speed > MEETING / 2:
                lively[index] = speed
        fast = []
        for pair in pairs:
            one, other = self._bodies[pair]
            if lively[one] + lively[other] > MEETING:
                fast.append(pair)
        if not fast:
            return NOTHING
        places = self._places.tolist()
        return frozenset(
            pair
            for pair in fast
            if self._tumbles(places, rates, self._bodies[pair], self._view.spot(self._codes[pair]))
        )

    def _tumbles(
        self,
        places: list[float],
        rates: list[float],
        two: list[int],
        spot: tuple[list[float], list[float]] | None,
    ) -> bool:
        """Whether turning brings two bodies together, and not only while they slide.

        places, rates: `qpos`, `qvel`. spot: point and normal of their contact, None where they
        are apart at the moment. Plain numbers: it is asked often, for a body or two.
        """
        if spot is None:
            return True
        (px, py, pz), (nx, ny, nz) = spot
        closing = sx = sy = sz = 0.0
        for sign, end in zip((1, -1), two, strict=True):
            if end >= len(self._objects_at):
                continue
            place, at, _, lever = self._objects_at[end]
            x, y, z, *turn = places[place : place + 7]
            u, v, w, *spin = rates[at : at + 6]
            a, b, c = _turned(turn, spin)
            # Turning about the normal brings nothing closer.
            i, j, k = b * nz - c * ny, c * nx - a * nz, a * ny - b * nx
            closing += lever * math.sqrt(i * i + j * j + k * k)
            x, y, z = px - x, py - y, pz - z
            sx += sign * (u + b * z - c * y)
            sy += sign * (v + c * x - a * z)
            sz += sign * (w + a * y - b * x)
        along = sx * nx + sy * ny + sz * nz
        slip = math.sqrt(max(sx * sx + sy * sy + sz * sz - along * along, 0.0))
        return closing > max(MEETING, TUMBLING * slip)

    def _are_alone(self, pairs: frozenset[int]) -> bool:
        if not self._objects:
            return False
        last = self._objects
        met = [self._bodies[pair] for pair in pairs]
        ends = {(min(one, last), min(other, last)) for one, other in met}
        flat = [end for two in ends for end in two if end < last]
        return all(any(end < last and flat.count(end) == 1 for end in two) for two in ends)

    def _engage(self, pairs: frozenset[int]) -> None:
        self.engaged = pairs
        self.awaits = self.loose or len(pairs) < len(self.now)

    def restore(self, state: FloatArray) -> None:
        """Takes up a row of `rows`."""
        kept = state.tolist()
        self.engaged = frozenset(pair for pair, value in enumerate(kept) if value in (2, 4))
        rocking = frozenset(pair for pair, value in enumerate(kept) if value > 2)
        self._hold(self._one(frozenset(np.flatnonzero(state).tolist())), rocking)

    def recall(self, state: GripState) -> None:
        """Takes up where `state` was."""
        pairs, self.engaged, rocking = state
        self._hold(pairs, rocking)


def _turned(turn: list[float], spin: list[float]) -> tuple[float, float, float]:
    """An angular velocity, which the engine keeps in the body frame, in the world's. turn: wxyz."""
    w, x, y, z = turn
    a, b, c = spin
    i, j, k = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return a + w * i + y * k - z * j, b + w * j + z * i - x * k, c + w * k + x * j - y * i
