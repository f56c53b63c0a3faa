"""Which hunks of an accepted proposal brought the event about.

A set of hunks is worth 1 where the program with just these realises its contract, else 0. Leave
one out: what the whole loses without a hunk. Shapley: what a hunk adds, on average over all orders
in which they could have been made; the values add up to what all of them bring together.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.errors import InputError, ProgramError
from physagent_studio.jobs import Executor
from physagent_studio.program import apply
from physagent_studio.program.edits import Hunk
from physagent_studio.sweep.carry_out import carry_out
from physagent_studio.sweep.plan import Point, Target
from physagent_studio.sweep.run import Ran

MOST_HUNKS = 8
"""Hunks up to which orders are told apart; of more each is only left out."""
EXACT_HUNKS = 6
"""Hunks up to which every set is run, 64 at most."""
ORDERS = 24
"""Orders that are drawn beyond that: a value is then off by about a tenth (1 / (2 √24))."""

Chosen = frozenset[int]


@dataclass(frozen=True, slots=True)
class Credit:
    """What a hunk did. needed: the event fails without it. shapley: None for more than eight."""

    hunk: Hunk
    needed: bool
    shapley: float | None


@dataclass(frozen=True, slots=True)
class Attribution:
    """exact: whether every order was counted. before, after: whether it holds without and with."""

    credits: tuple[Credit, ...]
    exact: bool
    before: bool
    after: bool
    runs: int


def attribution(
    target: Target,
    hunks: Sequence[Hunk],
    executor: Executor,
    *,
    seed: int = 0,
    cancelled: Callable[[], bool] = lambda: False,
) -> Attribution:
    """Runs the program of `target`, which is without the hunks, with sets of them."""
    count = len(hunks)
    if not count:
        raise InputError("a proposal without hunks has nothing to be thanked for")
    everything = frozenset(range(count))
    orders = _orders(count, seed)
    wanted = {frozenset(), everything, *(everything - {one} for one in everything)}
    wanted |= {frozenset(order[:at]) for order in orders for at in range(count)}
    worth, runs = _worth(target, hunks, wanted, executor, cancelled)
    shapley = _shapley(count, orders, worth)
    credits = tuple(
        Credit(hunk, worth[everything] > worth[everything - {index}], shapley.get(index))
        for index, hunk in enumerate(hunks)
    )
    exact = count <= EXACT_HUNKS
    return Attribution(credits, exact, bool(worth[frozenset()]), bool(worth[everything]), runs)


def _orders(count: int, seed: int) -> list[tuple[int, ...]]:
    """All orders of the hunks, a sample of them, or none where there are too many."""
    if count > MOST_HUNKS:
        return []
    if count <= EXACT_HUNKS:
        return list(itertools.permutations(range(count)))
    drawn = np.random.default_rng(seed)
    return [tuple(drawn.permutation(count).tolist()) for _ in range(ORDERS)]


def _shapley(
    count: int, orders: Sequence[tuple[int, ...]], worth: Mapping[Chosen, int]
) -> dict[int, float]:
    gained = dict.fromkeys(range(count), 0.0) if orders else {}
    for order in orders:
        for at, one in enumerate(order):
            before = frozenset(order[:at])
            gained[one] += worth[before | {one}] - worth[before]
    return {one: total / len(orders) for one, total in gained.items()}


def _worth(
    target: Target,
    hunks: Sequence[Hunk],
    wanted: set[Chosen],
    executor: Executor,
    cancelled: Callable[[], bool],
) -> tuple[dict[Chosen, int], int]:
    """1 or 0 for each set, and how many programs were run for it."""
    points = {chosen: _point(target, hunks, chosen) for chosen in sorted(wanted, key=sorted)}
    held: dict[str, bool] = {}

    def done(point: Point, ran: Ran) -> None:
        held[point.key] = ran.holds

    carry_out(points.values(), executor, done, cancelled=cancelled)
    return {chosen: int(held[point.key]) for chosen, point in points.items()}, len(held)


def _point(target: Target, hunks: Sequence[Hunk], chosen: Chosen) -> Point:
    """The program with some of the hunks; none where one of them needs another."""
    edits = [edit for index in sorted(chosen) for edit in hunks[index].edits]
    values = {f"{index}": 1.0 for index in sorted(chosen)}
    try:
        return Point(target, values, -1, apply(target.program, edits))
    except ProgramError as error:
        return Point(target, values, -1, None, str(error))
