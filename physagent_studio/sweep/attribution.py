"""Which hunks of an accepted proposal brought the event about.

A set of hunks is worth 1 where the program with just these realises its contract, else 0. Leave
one out: what the whole loses without a hunk. Shapley: what a hunk adds, on average over all orders
in which they could have been made; the values add up to what all of them bring together.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.errors import InputError, ProgramError
from physagent_studio.jobs import Executor
from physagent_studio.jobs.executor import never, quiet
from physagent_studio.program import apply
from physagent_studio.program.edits import Hunk
from physagent_studio.sweep.carry_out import results
from physagent_studio.sweep.plan import Point, Target, set_by_reconstruction

MOST_HUNKS = 8
"""Hunks up to which orders are told apart; of more each is only left out."""
EXACT_HUNKS = 6
"""Hunks up to which every set is run, 64 at most."""
ORDERS = 24
"""Orders that are drawn beyond that: a value is then off by about a tenth (1 / (2 √24))."""


@dataclass(frozen=True, slots=True)
class Attribution:
    """needed: whether the event fails without a hunk. shapley: None for more than eight hunks.

    exact: whether every order was counted. before, after: whether it holds without and with all.
    """

    needed: tuple[bool, ...]
    shapley: tuple[float, ...] | None
    exact: bool
    before: bool
    after: bool


def attribution(
    target: Target,
    hunks: Sequence[Hunk],
    executor: Executor,
    *,
    seed: int = 0,
    cancelled: Callable[[], bool] = never,
    tell: Callable[[float], None] = quiet,
) -> Attribution:
    """Runs the program of `target`, which is without the hunks, with sets of them.

    tell: hears the share of these that have run.
    """
    paths = [edit.path for hunk in hunks for edit in hunk.edits]
    if not hunks or any(set_by_reconstruction(target, path) for path in paths):
        raise InputError("only changes of what is simulated can be told apart, of one at least")
    everything = frozenset(range(len(hunks)))
    orders = _orders(len(hunks), seed)
    wanted = {frozenset[int](), everything, *(everything - {one} for one in everything)}
    wanted |= {frozenset(order[:at]) for order in orders for at in range(len(order))}
    points = {chosen: _point(target, hunks, sorted(chosen)) for chosen in wanted}
    held = results(points.values(), executor, cancelled, lambda done: tell(done / len(points)))
    worth = {chosen: held[point.key].holds for chosen, point in points.items()}
    gained = [0] * len(hunks)
    for order in orders:
        for at, one in enumerate(order):
            gained[one] += worth[frozenset(order[: at + 1])] - worth[frozenset(order[:at])]
    after = worth[everything]
    needed = tuple(after and not worth[everything - {one}] for one in sorted(everything))
    shapley = tuple(total / len(orders) for total in gained) if orders else None
    return Attribution(needed, shapley, len(hunks) <= EXACT_HUNKS, worth[frozenset()], after)


def _orders(count: int, seed: int) -> list[tuple[int, ...]]:
    """All orders of the hunks, a sample of them, or none where there are too many."""
    if count <= EXACT_HUNKS:
        return list(itertools.permutations(range(count)))
    drawn = np.random.default_rng(seed)
    return [tuple(drawn.permutation(count).tolist()) for _ in range(ORDERS * (count <= MOST_HUNKS))]


def _point(target: Target, hunks: Sequence[Hunk], chosen: Sequence[int]) -> Point:
    """The program with some of the hunks; none where one of them needs another."""
    values = {hunks[index].id: 1.0 for index in chosen}
    try:
        edits = [edit for index in chosen for edit in hunks[index].edits]
        return Point(target, values, apply(target.program, edits))
    except ProgramError as error:
        return Point(target, values, None, problem=str(error))
