"""What the reader returns: typed event frames, places, and what it could not read."""

from dataclasses import dataclass
from typing import Literal

Relation = Literal[
    "on", "in", "into", "toward", "at", "from", "off", "over", "along", "down", "up", "under",
    "above", "away_from", "against", "near", "behind", "before", "after", "around", "between",
    "until", "object", "through", "past", "in_front", "left_of", "right_of", "atop",
]  # fmt: skip
Way = Literal[
    "left", "right", "up", "down", "forward", "backward", "sideways", "outward", "inward", "off",
    "away", "toward_camera",
]  # fmt: skip


LandmarkKind = Literal["point", "line", "area", "opening"]


EDGES = ("edge", "end")
"""Parts of a support beyond which nothing carries: any side of it, or one across its length."""


SLOPE_ENDS = ("upper_end", "lower_end")
"""Parts of a slope that bound it along the way down."""


@dataclass(frozen=True, slots=True)
class Place:
    """A place that a clause speaks of.

    kind: what `name` is; a group is what the clause's object stands on or among. part: a place
    on it (`edge`, `end`, `lower_end`, …) or "". landmark_kind: for landmarks that the case does not
    give, what they would be. ends: the two objects between which a line is meant. members: the
    objects that a group consists of, where the words tell.
    """

    name: str
    kind: Literal["object", "support", "landmark", "group"]
    part: str = ""
    landmark_kind: LandmarkKind = "point"
    ends: tuple[str, ...] = ()
    members: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class EventFrame:
    """One thing that happens, or is so, in the prompt.

    agent: objects that act. patient: objects that undergo or do it. cause: what else brings it
    about (wind, friction, person, gravity). any_one: one of the patients suffices; as_one: they are
    named together ("the blocks", "the tower"), and none of them by itself, in a number or as each;
    least, most: how many of them, where a number is a limit. only: nothing else of its kind.
    places: how it stands to places, first the nearest; begins: how it stands to them at first ("the
    ball behind the box rolls …"). link: how the clause hangs on the one before (`then`, `while`,
    `before`, `after`, `once`, `as`, `which`), or, where it `leads`, on the one that follows.
    posture: how it ends (`upright`, `flat`, `side`, `still`, `inverted`). share: of the way to
    `extent`, from … to. timing: whether several do it in turn or together. steps: how many of a
    flight of stairs it goes down. distance, speed, angle, delay: how far, how fast, how many
    degrees, how many seconds after the beginning. sequel: the prompt says that it comes after the
    frame before. rest: it is about the others of those that the frame before picks from. by: who
    does it with its limbs, and has to come within reach first. gait: what goes by itself, how.
    """

    sense: str
    clause: str
    patient: tuple[str, ...] = ()
    agent: tuple[str, ...] = ()
    cause: str = ""
    any_one: bool = False
    as_one: bool = False
    least: int = 0
    most: int | None = None
    only: bool = False
    direction: Way | None = None
    origin: Way | None = None
    places: tuple[tuple[Relation, Place], ...] = ()
    manner: frozenset[str] = frozenset()
    posture: str = ""
    path: Literal["", "curve", "straight", "circle"] = ""
    count: int | None = None
    steps: int | None = None
    distance: float | None = None
    speed: float | None = None
    delay: float | None = None
    angle: float | None = None
    negated: bool = False
    link: str = "then"
    sequel: bool = False
    rest: bool = False
    leads: bool = False
    begins: tuple[tuple[Relation, Place], ...] = ()
    share: tuple[float, float] | None = None
    extent: Place | None = None
    timing: Literal["", "in_turn", "together"] = ""
    by: str = ""
    gait: Literal["", "drive", "run", "walk"] = ""

    @property
    def partly_off(self) -> bool:
        """ "Halfway off the table": it juts out over the edge, and stays up there."""
        off = self.place("off", "from") is not None
        return off and self.share is not None and self.share[1] < 1

    @property
    def counted(self) -> bool:
        """Whether a number of the patients is a limit."""
        return self.least > 0 or self.most is not None

    @property
    def lies_down(self) -> bool:
        """ "Falls onto its side": where it stands, and off nothing."""
        lying = self.posture in ("side", "supine", "prone")
        return lying and self.sense == "fall" and self.place("off", "from", "on") is None

    def place(self, *relations: str) -> Place | None:
        """The first place in one of these relations."""
        return next((place for relation, place in self.places if relation in relations), None)


@dataclass(frozen=True, slots=True)
class ReadClause:
    """A clause of the prompt: its id, its wording, and whether any of it was read."""

    id: str
    text: str


@dataclass(frozen=True, slots=True)
class Reading:
    """frames in the order of the prompt; not_understood: words that nothing stands for; unmarked:
    things beside the event that it names and nobody marked, on which nothing demanded depends."""

    clauses: tuple[ReadClause, ...]
    frames: tuple[EventFrame, ...]
    not_understood: tuple[str, ...]
    unmarked: tuple[str, ...] = ()

    def places(self) -> tuple[Place, ...]:
        """All places spoken of, once each."""
        found = {p: None for frame in self.frames for _, p in (*frame.places, *frame.begins)}
        found |= {frame.extent: None for frame in self.frames if frame.extent is not None}
        return tuple(found)
