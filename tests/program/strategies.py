"""Hypothesis strategies for valid programs, their edits, and people's ways of writing them."""

from typing import Any

from hypothesis import strategies as st

from physagent_studio.program import (
    MATERIALS,
    AddItem,
    MoveItem,
    PhysicalProgram,
    RemoveItem,
    SetField,
)

OBJECTS = ["ball", "crate", "no", "007", "1e3", "true", "red_pin"]
SUPPORTS = ["floor", "table", "off"]
LANDMARKS = ["line", "null"]

small = st.floats(-50, 50).map(lambda x: round(x, 3))
length = st.floats(0.01, 5).map(lambda x: round(x, 4))
step = st.integers(0, 40)
vector = st.tuples(small, small, small).map(list)
sizes = st.tuples(length, length, length).map(list)
text = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=60)
words = st.sampled_from(["the ball rolls", "a: b # c", "- x", "'", "é → 2 °", "yes", "12:30"])
direction = st.sampled_from(["left", "right", "up", "down", "away", "toward_camera"])


def some(required: dict[str, Any], optional: dict[str, Any] | None = None) -> Any:
    return st.fixed_dictionaries(required, optional=optional or {})


def kind(name: str, required: dict[str, Any], optional: dict[str, Any] | None = None) -> Any:
    return some({"kind": st.just(name), **required}, optional)


shapes = st.one_of(
    kind("sphere", {"radius": length}),
    kind("ellipsoid", {"radii": sizes}),
    kind("box", {"size": sizes}),
    kind("cylinder", {"radius": length, "height": length}),
    kind("capsule", {"radius": length, "height": length}),
    kind("torus", {"radius": length, "tube": length}),
    kind("frustum", {"bottom_radius": length, "top_radius": length, "height": length}),
    kind("inflated", {"size": sizes}, {"thickness": length}),
    kind("revolved", {"profile": st.lists(st.tuples(small, length).map(list), min_size=2)}),
)
support_shapes = st.one_of(
    kind("floor", {}, {"height": small}),
    kind("wall", {"point": vector, "yaw": st.floats(-3, 3)}),
    kind("box", {"position": vector, "size": sizes}, {"yaw": st.floats(-3, 3)}),
    kind(
        "ramp",
        {"toe": vector, "yaw": st.floats(-3, 3), "run": length, "rise": length, "width": length},
        {"steps": st.integers(0, 12)},
    ),
)
bodies = st.one_of(
    kind("rigid", {}),
    kind("soft", {}, {"young": st.floats(1e3, 1e9)}),
    kind("cloth", {}, {"pinned": st.sampled_from(["none", "top"])}),
    kind("granular", {}, {"grains": st.integers(8, 500)}),
    kind("breakable", {}, {"release_impulse": length}),
)


def scene_objects(name: str) -> Any:
    return some(
        {"name": st.just(name)},
        {
            "shape": st.none() | shapes,
            "position": st.none() | vector,
            "support": st.none() | st.sampled_from([*SUPPORTS, "air"]),
            "material": st.sampled_from(sorted(MATERIALS)),
            "density": st.none() | st.floats(1, 10000),
            "friction": st.none() | st.floats(0, 2),
            "body": bodies,
            "grounding": some({}, {"points": st.lists(some({"x": small, "y": small}), max_size=3)}),
        },
    )


directed = some({"magnitude": small}, {"quantity": st.just("acceleration")}).flatmap(
    lambda base: st.one_of(
        some({"direction": direction}),
        some({"toward": st.sampled_from([*OBJECTS[:1], *LANDMARKS])}),
        some({"toward": vector}),
        some({"along": st.just("velocity")}),
    ).map(lambda way: {**base, **way})
)
vectors = vector | directed
leaf = st.one_of(
    kind("moves", {"subject": st.just("ball")}, {"direction": direction, "distance": length}),
    kind("contacts", {"subject": st.just("ball"), "other": st.sampled_from(SUPPORTS)}),
    kind("topples", {"subject": st.just("ball")}, {"tilt": st.floats(1, 90)}),
    kind("stays", {"subject": st.just("ball")}, {"negated": st.booleans()}),
    kind("passes_over", {"subject": st.just("ball"), "landmark": st.just("line")}),
)
conditions = st.one_of(
    kind("on_contact", {"a": st.just("ball"), "b": st.just("floor")}, {"delay": step}),
    kind("when", {"statement": leaf.map(lambda s: {"id": "cond", **s})}),
)


def actions(action_id: str, name: str) -> Any:
    base = {"id": st.just(action_id), "name": st.just(name)}
    start = {"start_step": step, "muted": st.booleans(), "when": st.none() | conditions}
    lasting = {"duration": st.integers(1, 20)}

    def act(operator: str, fields: dict[str, Any], optional: dict[str, Any] | None = None) -> Any:
        return some(
            {**base, "operator": st.just(operator), **fields}, {**start, **(optional or {})}
        )

    return st.one_of(
        act("SetVelocity", {"velocity": vectors}),
        act("SetAngularVelocity", {"angular_velocity": vectors}, lasting),
        act("ApplyForce", {"force": vectors, **lasting}, {"point": vector}),
        act("ApplyTorque", {"torque": vectors, **lasting}),
        act("ApplyAngledForce", {"magnitude": small, "angle": small, **lasting}),
        act("ApplyDisturbance", {"model": st.just("wind"), "amplitude": length, **lasting}),
        act("SetPosition", {"position": vector}),
        act("SetOrientation", {"rotation": st.just([1.0, 0.0, 0.0, 0.0])}),
        act("FixObject", {**lasting}),
    )


@st.composite
def program_data(draw: Any) -> dict[str, Any]:
    """Plain data of a valid program; `ball`, all supports and all landmarks are always there."""
    names = ["ball", *draw(st.lists(st.sampled_from(OBJECTS[1:]), unique=True, max_size=3))]
    ids = draw(st.lists(st.sampled_from(["kick", "push", "no", "3"]), unique=True, max_size=3))
    statements = draw(st.lists(leaf, max_size=3))
    return {
        "clip": draw(
            some({}, {"substeps": st.integers(1, 50), "playback_fps": st.integers(1, 60)})
        ),
        "scene": {
            "objects": [draw(scene_objects(name)) for name in names],
            "supports": [
                {"name": name, "shape": draw(st.none() | support_shapes)} for name in SUPPORTS
            ],
            "landmarks": [
                {"name": name, "kind": "line", "points": draw(st.none() | st.just([[0, 0, 0]]))}
                for name in LANDMARKS
            ],
        },
        "event": {
            "prompt": draw(text | words),
            "actions": [draw(actions(one, draw(st.sampled_from(names)))) for one in ids],
        },
        "contract": {
            "clauses": [{"id": "c1", "text": draw(text | words)}],
            "statements": [{"id": f"s{n}", **one} for n, one in enumerate(statements)],
        },
    }


programs = program_data().map(PhysicalProgram.model_validate)


@st.composite
def edits_of(draw: Any, program: PhysicalProgram) -> Any:
    """One edit that applies to a program."""
    things = [one.name for one in program.scene.objects]
    acts = [one.id for one in program.event.actions]
    name = draw(st.sampled_from(things))
    choices = [
        st.builds(SetField, path=st.just(f"scene.objects.{name}.shape"), value=shapes),
        st.builds(SetField, path=st.just(f"scene.objects.{name}.position"), value=vector),
        st.builds(SetField, path=st.just(f"scene.objects.{name}.density"), value=length),
        st.builds(SetField, path=st.just(f"scene.objects.{name}.rotation.1"), value=length),
        st.builds(SetField, path=st.just("event.prompt"), value=text | words),
        st.builds(SetField, path=st.just("clip.substeps"), value=st.integers(1, 99)),
        st.builds(SetField, path=st.just("scene.scale.metres"), value=length),
        st.builds(
            AddItem,
            path=st.just("event.actions"),
            item=actions("new", name),
            index=st.none() | st.integers(0, len(acts)),
        ),
        st.builds(
            AddItem,
            path=st.just("scene.objects"),
            item=scene_objects("newcomer"),
            index=st.none() | st.integers(0, len(things)),
        ),
        st.builds(
            MoveItem,
            path=st.just(f"scene.objects.{name}"),
            index=st.integers(0, len(things) - 1),
        ),
    ]
    if acts:
        act = draw(st.sampled_from(acts))
        choices += [
            st.builds(RemoveItem, path=st.just(f"event.actions.{act}")),
            st.builds(SetField, path=st.just(f"event.actions.{act}.start_step"), value=step),
            st.builds(SetField, path=st.just(f"event.actions.{act}.muted"), value=st.booleans()),
            st.builds(
                MoveItem,
                path=st.just(f"event.actions.{act}"),
                index=st.integers(0, len(acts) - 1),
            ),
        ]
    return draw(st.one_of(choices))
