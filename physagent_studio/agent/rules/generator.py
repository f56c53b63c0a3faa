"""G: from a case and its prompt to the first physical program. It never simulates."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from physagent_studio.agent.rules.contract.compile import contract_of, landmarks_needed
from physagent_studio.agent.rules.contract.intents import struck_above
from physagent_studio.agent.rules.contract.living import by_limbs, kept_upright
from physagent_studio.agent.rules.scene.bodies import bodies_for
from physagent_studio.agent.rules.scene.facing import backwards_to_its_aim
from physagent_studio.agent.rules.scene.footing import (
    with_depth,
    with_depth_of_like,
    with_hold,
    with_room,
    with_walls_weighed,
)
from physagent_studio.agent.rules.scene.going_over import as_going_over
from physagent_studio.agent.rules.scene.hanging import (
    as_far_as_told,
    bounces_unseen,
    from_nowhere,
    in_the_air,
    kept_afloat,
    may_hang,
    sizes_off,
)
from physagent_studio.agent.rules.scene.materials import ground_material, material_of, unknown
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.scene.named_tables import surface_left
from physagent_studio.agent.rules.scene.rows import as_waves
from physagent_studio.agent.rules.scene.withdrawing import without_withdrawn
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule.company import ridden, with_what_bears_it
from physagent_studio.agent.rules.schedule.event_program import raised_places, schedule, tasks_of
from physagent_studio.agent.rules.schedule.heading import with_wheels
from physagent_studio.agent.rules.schedule.landmarks import assume_open, derived_landmarks
from physagent_studio.agent.rules.schedule.leaving import off_the_picture
from physagent_studio.agent.rules.schedule.pacing import paces_of, speed_to_get_there
from physagent_studio.agent.rules.schedule.ramps import friction_for
from physagent_studio.knowledge import density_of, grows
from physagent_studio.language import Inventory, Reading, inventory, read
from physagent_studio.program.contract import Contract
from physagent_studio.program.program import Clip, EventProgram, PhysicalProgram
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.plants import FOLIAGE
from physagent_studio.program.scene.state import Landmark, SceneObject, SceneState, Support
from physagent_studio.program.timing import clip_of
from physagent_studio.records import Case, Scene


class RuleGenerator:
    """Writes the first program from the words of the prompt and the reconstructed geometry."""

    def first(self, case: Case, reconstruct: Callable[[SceneState], Scene]) -> PhysicalProgram:
        """The program of a case; raises what `reconstruct` raises."""
        stock = stock_of(case)
        reading = read(case.prompt, stock)
        scene = reconstruct(open_scene(case, reading, stock))
        if aloft := from_nowhere(case, reading, Layout(scene.state)):
            lying, scene = scene, reconstruct(open_scene(case, reading, stock, aloft))
            unseen = {n for n in aloft if bounces_unseen(reading, Layout(scene.state), n)}
            if unseen == aloft:
                scene = lying
            elif unseen:
                scene = reconstruct(open_scene(case, reading, stock, aloft - unseen))
        elif above := may_hang(case, reading, Layout(scene.state)):
            hanging = reconstruct(open_scene(case, reading, stock, above))
            if 2 * sizes_off(hanging.state) < sizes_off(scene.state):
                scene = hanging
        # Which one is the taller, and what stands on what, is known only now.
        told = read(case.prompt, stock_in(case, scene.state))
        return self.program(case, told, scene.state, scene.masks)

    def program(
        self,
        case: Case,
        reading: Reading,
        state: SceneState,
        masks: Mapping[str, np.ndarray] = MappingProxyType({}),
    ) -> PhysicalProgram:
        """The program over a completed scene state. masks: (H, W) bool of objects in the photo."""
        state = as_far_as_told(without_withdrawn(state, reading), reading)
        state = with_room(with_depth_of_like(with_depth(state)))
        state = with_walls_weighed(state)
        clip = clip_of(case.seconds)
        reading = off_the_picture(reading, Layout(state), clip.seconds)
        reading = backwards_to_its_aim(reading, Layout(state))
        reading = with_what_bears_it(as_going_over(reading, Layout(state)), Layout(state))
        reading = struck_above(reading, Layout(state))
        reading = by_limbs(reading, Layout(state))
        state = with_hold(_with_landmarks(state, reading))
        state = _with_materials(_on_wheels(state, reading, clip, masks), reading, clip)
        state = kept_afloat(kept_upright(state, reading), reading)
        layout = Layout(state)
        reading = as_waves(reading, layout)
        said = (
            f"where the {word} is that the sentence names is not known" for word in reading.unmarked
        )
        state = state.model_copy(update={"flags": (*state.flags, *said)[:64]})
        return PhysicalProgram(
            clip=clip,
            scene=state,
            event=EventProgram(prompt=case.prompt[:4000], actions=schedule(reading, layout, clip)),
            contract=_contract(reading, layout, clip),
        )


def stock_of(case: Case) -> Inventory:
    """What the case names, as the reader asks for it, and the table that the prompt alone names."""
    return inventory(
        case.objects,
        [(s.name, s.grounding) for s in _supports_of(case)],
        [landmark.name for landmark in case.landmarks],
    )


def stock_in(case: Case, state: SceneState) -> Inventory:
    """The same with what a reconstructed scene says of it: how large things are, and stacks."""
    layout = Layout(state)
    known = [name for name, _ in case.objects if layout.has(name)]
    lowest = [n for n in known if layout.above(n) and state.object(layout.carrier(n) or "") is None]
    return inventory(
        case.objects,
        [(s.name, s.grounding) for s in _supports_of(case)],
        [landmark.name for landmark in case.landmarks],
        {name: (layout.height(name), layout.size(name)) for name in known},
        tuple((name, *layout.above(name)) for name in lowest),
        tuple((name, below) for name in known if (below := layout.base(name)) is not None),
    )


def open_scene(
    case: Case, reading: Reading, stock: Inventory, aloft: frozenset[str] = frozenset()
) -> SceneState:
    """What the picture shows, with its geometry still open; aloft: what is known to hang."""
    hanging, riding = in_the_air(case, reading) | aloft, ridden(reading)
    objects = tuple(
        SceneObject(
            name=name,
            grounding=grounding,
            material=material_of(name, case.prompt),
            density=density_of(name),
            support=AIR if name in hanging else riding.get(name),
            aloft="hangs" if name in hanging else None,
        )
        for name, grounding in case.objects
    )
    supports = _supports_of(case)
    if all(s.name != stock.ground for s in supports):
        ground = Support(name=stock.ground, material=ground_material(case.prompt, stock.ground))
        supports = (*supports, ground)
    given = {landmark.name for landmark in case.landmarks}
    needed = tuple(
        Landmark(name=place.name, kind=place.landmark_kind, on=stock.ground)
        for place in landmarks_needed(reading)
        if place.kind == "landmark" and place.name not in given and not place.ends
    )
    assumed = (unknown(name, case.prompt) for name, _ in case.objects)
    return SceneState(
        flags=tuple(text for text in assumed if text is not None)[:64],
        horizon=case.horizon,
        roll=case.roll,
        scale=case.scale,
        objects=objects,
        supports=supports,
        landmarks=(*case.landmarks, *needed),
    )


def _supports_of(case: Case) -> tuple[Support, ...]:
    """The supports of the case, and the table that things leave by the prompt alone."""
    left = surface_left(case)
    return (*case.supports, Support(name=left)) if left is not None else case.supports


def _with_landmarks(state: SceneState, reading: Reading) -> SceneState:
    """Edges and ends of supports that the prompt speaks of, from the geometry of the supports."""
    known = {landmark.name for landmark in state.landmarks}
    found = [
        landmark
        for landmark in derived_landmarks(Layout(state), landmarks_needed(reading), reading)
        if landmark.name not in known
    ]
    state = state.model_copy(update={"landmarks": (*state.landmarks, *found)})
    marks, said = assume_open(Layout(state), reading)
    flags = tuple(dict.fromkeys((*state.flags, *said)))[:64]
    return state.model_copy(update={"landmarks": marks, "flags": flags})


def _on_wheels(
    state: SceneState, reading: Reading, clip: Clip, masks: Mapping[str, np.ndarray]
) -> SceneState:
    """Wheels under what has them by its name, facing the way it goes; what is assumed as flags."""
    layout = Layout(state)
    objects, said = with_wheels(layout, tasks_of(reading, layout, clip), masks)
    flags = tuple(dict.fromkeys((*state.flags, *said)))[:64]
    return state.model_copy(update={"objects": objects, "flags": flags})


def _with_materials(state: SceneState, reading: Reading, clip: Clip) -> SceneState:
    """Friction on slopes, and how things hold together, where the event depends on it."""
    layout = Layout(state)
    friction = {
        task.name: mu
        for task in tasks_of(reading, layout, clip)
        if (mu := friction_for(task)) is not None
    }
    bodies = bodies_for(reading, layout)
    changed: list[SceneObject] = []
    for item in state.objects:
        update: dict[str, object] = {}
        if item.name in friction and item.friction is None:
            update["friction"] = friction[item.name]
        if item.name in bodies and item.body.kind == "rigid":
            update["body"] = bodies[item.name]
            if grows(item.name) and bodies[item.name].kind == "soft":
                # What stood for a trunk does not hold for a crown that bends.
                own = None if item.density == density_of(item.name) else item.density
                update |= {"material": FOLIAGE, "density": own}
        changed.append(item.model_copy(update=update))
    return state.model_copy(update={"objects": tuple(changed)})


def _contract(reading: Reading, layout: Layout, clip: Clip) -> Contract:
    """What the sentence demands, as far as the scene has what it speaks of, and its paces."""
    contract = _known_only(contract_of(reading, layout, clip.steps), layout.state)
    out = [f for f in reading.frames if "offscreen" in f.manner]
    half = {name for f in out if f.share is not None and f.share[1] < 1 for name in f.patient}
    gone = {name for f in out for name in f.patient} - half
    objects = [item.name for item in layout.state.objects]
    tasks = tasks_of(reading, layout, clip)
    needed = {t.name: speed_to_get_there(t) for t in tasks if t.target() is not None}
    told = {
        "paces": paces_of(reading, layout, needed),
        "leaving": tuple(name for name in objects if name in gone),
        "partly": tuple(name for name in objects if name in half),
        "backwards": tuple(task.name for task in tasks if task.backwards),
    }
    return _once_raised(contract.model_copy(update=told), reading, layout)


def _once_raised(contract: Contract, reading: Reading, layout: Layout) -> Contract:
    """What is said of things that are raised first is asked for from then on."""
    raised, wait = raised_places(reading, layout), act.STEPS.first_step + act.STEPS.rise_steps
    if not raised:
        return contract
    return contract.model_copy(
        update={
            "statements": tuple(
                s.model_copy(
                    update={
                        "from_step": (s.from_step or 0) + wait,
                        "to_step": None if s.to_step is None else s.to_step + wait,
                    }
                )
                if getattr(s, "subject", "") in raised
                else s
                for s in contract.statements
            )
        }
    )


def _known_only(contract: Contract, state: SceneState) -> Contract:
    """The contract without statements on places that the scene does not have; they stay visible
    as untested clauses."""
    places = set(state.names)
    kept = list(contract.statements)
    while True:
        ids = {s.id for s in kept}
        fine = [s for s in kept if _refers_to_known(s, places, ids)]
        if len(fine) == len(kept):
            return contract.model_copy(update={"statements": tuple(kept)})
        kept = fine


def _refers_to_known(statement: object, places: set[str], ids: set[str]) -> bool:
    names = [getattr(statement, f, None) for f in ("other", "landmark", "near", "before", "toward")]
    parts = [*getattr(statement, "of", ())]
    parts += [
        p for p in (getattr(statement, "first", None), getattr(statement, "second", None)) if p
    ]
    return all(n is None or n in places for n in names) and all(p in ids for p in parts)
