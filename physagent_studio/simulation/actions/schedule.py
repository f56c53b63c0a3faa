"""When actions start and end: fixed windows, and starts on a condition."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from physagent_studio.program import Action, After, OnContact, duration_of
from physagent_studio.program.actions import FixObject, When
from physagent_studio.records import ActionSpan
from physagent_studio.simulation.actions.effect import Effect
from physagent_studio.simulation.actions.effects import EFFECTS, Hanging


@dataclass(eq=False, slots=True)
class Slot:
    """An action with its window; start and end (exclusive) are None until they are known."""

    action: Action
    effect: Effect
    start: int | None = None
    end: int | None = None
    began: bool = False
    ended: bool = False
    expired: bool = False


class Schedule:
    """All actions of a clip of `steps` control steps; asked once before each step.

    active: actions that have begun and not ended, in the program's order. just_ended: whether
    one has ended since somebody last cleared this mark.
    """

    def __init__(
        self,
        actions: tuple[Action, ...],
        steps: int,
        hanging: Mapping[str, float | None] = MappingProxyType({}),
    ) -> None:
        """hanging: things that stay where they are until the first action on them begins, and how
        long the thread is that each hangs by, m, where one is seen."""
        self._steps = steps
        heard = (item for item in actions if not item.muted)
        self.slots = tuple(Slot(item, EFFECTS[type(item)](item)) for item in heard)
        self.hanging = tuple(_hanging(name, thread, steps) for name, thread in hanging.items())
        self._by_id = {slot.action.id: slot for slot in self.slots}
        self._edges: set[int] = {0} if self.hanging else set()
        self.active: list[Slot] = []
        self.just_ended = False
        self._waiting = {slot.action.id for slot in self.slots if slot.action.when is not None}
        for slot in self.slots:
            if slot.action.when is None:
                self._open(slot, slot.action.start_step)

    @property
    def is_conditional(self) -> bool:
        """Whether some action still waits for its condition."""
        return bool(self._waiting)

    @property
    def awaits_contact(self) -> bool:
        """Whether some action still waits for a contact."""
        return any(
            slot.start is None and not slot.expired and isinstance(slot.action.when, OnContact)
            for slot in self.slots
        )

    def _open(self, slot: Slot, start: int) -> None:
        slot.start = start
        slot.end = min(start + duration_of(slot.action), self._steps)
        self._edges |= {slot.start, slot.end}
        self._waiting.discard(slot.action.id)

    @property
    def awaited(self) -> list[tuple[str, When]]:
        """The statements that actions still wait for, by the action's id."""
        waiting = [slot.action for slot in self.slots if slot.start is None and not slot.expired]
        return [(item.id, item.when) for item in waiting if isinstance(item.when, When)]

    def resolve(
        self,
        step: int,
        touched: Callable[[str, str], int | None],
        came_true: Callable[[str], int | None],
    ) -> None:
        """Opens windows whose condition has come true before `step`.

        touched: the first control step on which two bodies touched, or None. came_true: the
        step at which the statement of an action was first seen to hold, or None.
        """
        for slot in self.slots:
            when = slot.action.when
            if when is None or slot.start is not None or slot.expired:
                continue
            if isinstance(when, OnContact):
                cause = touched(when.a, when.b)
                # What happened during a step is known, and answered, on the next.
                start = None if cause is None else cause + 1 + when.delay
            else:
                by_time = isinstance(when, After)
                cause = self._end_of(when.action) if by_time else came_true(slot.action.id)
                start = None if cause is None else cause + when.delay
            if when.timeout is not None and max(start or 0, step) > when.timeout:
                slot.expired = True
                self._waiting.discard(slot.action.id)
            elif start is not None:
                self._open(slot, max(start, step))

    def _end_of(self, action_id: str) -> int | None:
        slot = self._by_id.get(action_id)
        return slot.end if slot is not None else None

    def has_edge(self, step: int) -> bool:
        """Whether some window opens or closes just before `step`."""
        return step in self._edges

    def next_edge(self, step: int) -> int:
        """The first step after `step` before which some window opens or closes."""
        return min((edge for edge in self._edges if edge > step), default=self._steps)

    def recall(self, spans: Mapping[str, ActionSpan], active: Mapping[str, Any], step: int) -> None:
        """Takes up before `step` of an earlier run with the same actions so far.

        spans: of the earlier run. active: the memories of the actions that were at work.
        """
        for slot in self.slots:
            span = spans.get(slot.action.id)
            if span is None or span.start is None or span.start >= step or span.end is None:
                continue
            self._open(slot, span.start)
            slot.began = True
            if slot.action.id in active:
                slot.effect.recall(active[slot.action.id])
            else:
                slot.ended, slot.effect.work = True, span.work
        for slot in self.hanging:
            slot.began, slot.ended = True, slot.action.id not in active
            if not slot.ended:
                slot.effect.recall(active[slot.action.id])
        self.active = self._acting()

    def _acting(self) -> list[Slot]:
        return [s for s in (*self.hanging, *self.slots) if s.began and not s.ended]

    def turn(self, step: int) -> tuple[list[Slot], list[Slot]]:
        """The actions that end and those that begin just before `step`; updates `active`."""
        starting = [
            slot
            for slot in (*self.hanging, *self.slots)
            if not slot.began and slot.start == step and step < self._steps
        ]
        moved = {slot.action.name for slot in starting if slot not in self.hanging}
        for slot in self.hanging:
            if slot.action.name in moved and not slot.ended:
                slot.end = step
                slot.ended = slot in starting
        starting = [slot for slot in starting if not slot.ended]
        ending = [slot for slot in self.active if slot.end is not None and slot.end <= step]
        for slot in ending:
            slot.ended = True
        for slot in starting:
            slot.began = True
        self.active = self._acting()
        self.just_ended |= bool(ending)
        return ending, starting


def _hanging(name: str, thread: float | None, steps: int) -> Slot:
    """What keeps a thing in the air; no action can have its id."""
    held = FixObject.model_construct(id=f"hanging {name}", name=name, start_step=0, duration=steps)
    return Slot(held, Hanging(held, thread), 0, steps)
