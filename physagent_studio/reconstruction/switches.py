"""Which heuristics are at work: all, but for those that a bench leaves out.

Things are sought on threads of their own, which know no context variables: what is left out is left
out for the whole process, and only benches and tests do so.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from physagent_studio.errors import InputError

MASKS = {
    "expected gain": "other candidates by what they are expected to add",
    "variants": "other candidates with shadow or reflection, wider or tighter",
    "unions of drafts": "any two drafts together are one more",
    "framed": "what frames an upright rectangle belongs to it",
    "rare colours": "a cut by the colours of a box that are rare around it is one more draft",
    "upon another": "what stands on a thing keeps what both masks cover",
    "tight boxes": "a box that a person drew ends where the thing ends",
    "settled outline": "the outline settled at the size of the picture",
    "stacks": "things of one kind above one another cut apart along seams",
    "settled seams": "seams moved to where they are seen best",
    "round masks": "of the masks of a ball a rounder one is likelier",
    "ball outlines": "balls cover what spheres do",
    "box outlines": "what a box's mask lost on one side comes back from the other",
    "closed bodies": "nothing is seen through plain bodies without handles or frames",
    "foot spill": "no shade at the foot of round fruit",
    "clicks of others": "clicks on other things lie outside",
}
"""What the segmenter can leave out, by name, and what it does."""
PLATES = {
    "soft outlines": "the hole is as wide as the thing's colours fade",
    "leftovers": "what masks have missed, by its colour, leaves too",
    "scraps": "small bits that stand out of smooth ground beside it leave too",
    "floor reflections": "mirror images on polished ground leave",
    "cast shadows": "shade at the feet leaves",
    "dimmed ground": "ground of any pattern with less light than around it is shade",
    "detached shadows": "the shadow on the ground of what is in the air leaves",
    "shade of stacks": "what stands on a thing makes its shade longer",
    "deeper shade": "darker and darker shade is tried where it ends at paint",
    "deep shade": "ground of another colour is what is beside it in the shade of the sun",
    "narrow gaps": "what a thing encloses leaves with it where that is narrow",
    "bystanders": "what else stands in the shade of a thing is none of it and stays",
    "shade of bystanders": "shade that lies nearer to a bystander is its own",
    "slits": "no slit between a thing and its shade",
    "contact shade": "the dark line below a thing leaves with it",
    "straight lines": "edges seen on both sides of a hole are joined",
    "edges onward": "edges are looked for where they come out of a hole",
    "lines of masks": "lines through the masks are sought besides those of the hole",
    "edges in grain": "edges of the softened picture go on behind the hole too",
    "black shade": "black places are the ground beside them in deep shade",
    "bent lines": "edges that bend go on in an arc behind the hole",
    "lines from beside": "lines begin where they are seen beside the hole",
    "edges of supports": "edges of tops and ramps go on",
    "edges seen": "edges seen beside a thing as they are farther off stay",
    "strokes": "edges are drawn through what is filled in",
    "faces": "shade and traces end at the face on which a thing stands",
    "level shifts": "copies along the level plane",
    "shifts along lines": "copies along lines that go on behind the hole",
    "expected colours": "copies have to show the colours that are around",
    "own faces": "faces of tables and ramps are filled from the same face",
    "sides of lines": "copies over a line that goes on cost",
    "bent copies": "copies that are sheared or stretched cost",
    "smooth fill": "bare ground is filled smoothly",
    "rooted": "what grows keeps what is at its foot",
}
"""The same of the background's plate."""
BODIES = {
    "prisms": "what drives stands over the footprint that is seen",
    "outline fitting": "meshes are led to their masks before the photo is laid on them",
    "outline bending": "also by a thin plate along the outline",
    "outline carving": "what covers openings of its mask is drawn along the rays of that",
    "light off": "light is read off round things and taken out of their textures",
    "light on blocks": "so is that on the sides of a block of one colour",
    "gloss off": "gloss too",
    "plain balls": "what changes slowly over a ball of one colour is light",
    "rim shade": "shade at a ball's rim is light, not its colour",
    "hidden tops": "what carries something goes on behind it",
    "usual depths": "boxes are as deep as their name tells",
    "round bodies": "the sides of a cube around a ball show the first one again",
    "things once": "what is there once is not repeated",
    "turned sides": "what is not seen of a ring shows what is seen of it",
    "straight sides": "the rim of a straight front goes on to the back",
    "plain undersides": "undersides that nobody saw show no streaks",
    "covered sides": "covered sides of blocks are painted in their own colour",
    "opposite sides": "hidden sides of a block show the opposite one",
    "creases": "edges within the mask say how a box is turned",
    "snug boxes": "outlines of boxes are drawn to the rim",
    "usual sizes of bodies": "bodies far from the usual size are unlikely",
    "as what is below": "a box on a box is begun as that lies",
    "lying": "cylinders and capsules may lie",
    "revolved": "surfaces of revolution",
    "corrected revolved": "their boxes drawn to the mask's",
    "straight inflated": "things with a usual depth have straight sides",
    "flat inflated": "what lies is inflated on the ground",
    "rings": "rings",
    "parts beside": "handles and legs that the body leaves out are drawn",
    "legs": "deep things stand on posts",
    "feet": "silhouettes are laid across two feet",
    "bodies without parts": "what stands off a body does not make it wider",
    "stems": "parts beside the body are drawn with it",
    "threads": "what hangs takes its thread along",
    "strings below": "what is lighter than air takes its string along",
    "alike kinds": "things of one name have one kind of form",
    "depenetration": "what stands in another is moved away",
    "flats": "what balances on its end gets flats",
    "nudged": "centres of mass are moved over what carries them",
    "roll": "the camera's roll by upright edges",
    "right angles": "the camera by edges of right-angled things",
    "starts from above": "round bodies fitted once more as seen from above",
    "rims": "the camera by the rims of plates, lids and pucks",
    "outlines": "the camera by outlines of things of known form",
    "known sizes": "the camera by things of known size on one plane",
    "boxed tops": "the top of a table fills the box around it",
    "round tops": "the camera by the tops of round tables in boxes",
    "eye level": "cameras are held at a usual height",
}
"""The same of bodies, their looks and places, and of the camera."""
HEURISTICS = MASKS | PLATES | BODIES
"""What can be left out, by name, and what it does."""
_left_out: frozenset[str] = frozenset()
_asked: set[str] = set()


def at_work(name: str) -> bool:
    """Whether a heuristic is to be used."""
    _asked.add(name)
    return name not in _left_out


@contextmanager
def without(names: Iterable[str]) -> Iterator[set[str]]:
    """Leaves heuristics out for a while. Gives the names that are asked for meanwhile."""
    global _left_out, _asked
    before = _left_out, _asked
    chosen = frozenset(names)
    unknown = sorted(chosen - HEURISTICS.keys())
    if unknown:
        raise InputError(
            f"there is no heuristic '{unknown[0]}'; there are: {', '.join(HEURISTICS)}"
        )
    _left_out, _asked = _left_out | chosen, set()
    try:
        yield _asked
    finally:
        _left_out, _asked = before
