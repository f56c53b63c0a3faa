"""`VlmGenerator`: picture and sentence → scene, then contract and event program."""

from collections.abc import Callable
from dataclasses import dataclass

from physagent_studio.agent.vlm import facts, reference
from physagent_studio.agent.vlm.dialogue import converse
from physagent_studio.agent.vlm.forms import EventReply, SceneReply, SeenObject
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Invalid, Picture, Turn, VlmError, prompt, quoted
from physagent_studio.agent.vlm.pictures import with_rulers
from physagent_studio.errors import InputError
from physagent_studio.knowledge import support_kind
from physagent_studio.program import (
    Click,
    Contract,
    EventProgram,
    Grounding,
    Landmark,
    PhysicalProgram,
    SceneObject,
    SceneState,
    Support,
)
from physagent_studio.program.preflight.preflight import preflight
from physagent_studio.program.scene.bodies import Rigid
from physagent_studio.program.scene.state import Scale
from physagent_studio.program.text.document import validate_data
from physagent_studio.records import Case, Image, Scene
from physagent_studio.rendering.sheets import fitted, marked

GROUND = "floor"
MOST_DOUBTS = 12


@dataclass(frozen=True, slots=True)
class VlmGenerator:
    """Writes the first program in two calls: what is there, then what shall happen.

    The person's clicks are kept as they are. Raises `VlmError` where no valid program comes.
    """

    line: Line

    def first(self, case: Case, reconstruct: Callable[[SceneState], Scene]) -> PhysicalProgram:
        """The first program, with a complete scene."""
        if case.image is None:
            raise InputError("the VLM generator works from a photo, and this case has none")
        scene = self._see(case, case.image, reconstruct)
        return self._stage(case, case.image, scene)

    def _see(self, case: Case, image: Image, reconstruct: Callable[[SceneState], Scene]) -> Scene:
        shown = fitted(image, self.line.endpoint.picture_side)
        scale = image.shape[1] / shown.shape[1]
        task = prompt(
            "scene_task",
            width=str(shown.shape[1]),
            height=str(shown.shape[0]),
            sentence=quoted(case.prompt),
            given=_given(case, scale),
        )
        picture = Picture(with_rulers(shown), "the photograph")
        system = prompt(
            "scene",
            materials=reference.material_reference(),
            bodies=reference.body_reference(),
        )
        turns = _turns(system, task, picture)

        def check(reply: SceneReply) -> Scene:
            state = scene_of(reply, case, (image.shape[1], image.shape[0]), scale)
            try:
                return reconstruct(state)
            except InputError as error:
                raise Invalid(f"the scene cannot be reconstructed: {error}") from error

        return converse(self.line, "generator.scene", turns, SceneReply, check)

    def _stage(self, case: Case, image: Image, scene: Scene) -> PhysicalProgram:
        clip = PhysicalProgram().clip
        system = prompt(
            "event",
            steps=str(clip.steps),
            step_seconds=f"{clip.step_seconds:g}",
            actions=reference.action_reference(),
            statements=reference.statement_reference(),
        )
        task = prompt(
            "event_task",
            sentence=quoted(case.prompt),
            scene=facts.scene_lines(scene.state),
        )
        clicks = [
            (item.name, click) for item in scene.state.objects for click in item.grounding.points
        ]
        turns = _turns(system, task, Picture(marked(image, clicks), "the photograph, things named"))

        valid: list[PhysicalProgram] = []

        def check(reply: EventReply) -> PhysicalProgram:
            program = program_of(reply, case.prompt, scene.state)
            doubts = doubts_of(program)
            if doubts and not valid:
                # Said once; a program that is meant so stands if it comes again.
                valid.append(program)
                raise Invalid(prompt("doubts", doubts=doubts))
            return program

        try:
            return converse(self.line, "generator.event", turns, EventReply, check)
        except VlmError:
            if valid:
                return valid[0]
            raise


def _turns(part: str, task: str, *pictures: Picture) -> tuple[Turn, ...]:
    return (
        Turn("system", (prompt("system", part=part),)),
        Turn("user", (task, *pictures)),
    )


def _given(case: Case, scale: float) -> str:
    lines = []
    for kind, items in (
        ("object", case.objects),
        ("support", [(item.name, item.grounding) for item in case.supports]),
    ):
        for name, grounding in items:
            points = [
                f"({click.x / scale:.0f}, {click.y / scale:.0f})"
                for click in grounding.points
                if click.label
            ]
            lines.append(f"{kind} {name} at {', '.join(points) or 'no point'}")
    lines += [f"landmark {item.name} ({item.kind})" for item in case.landmarks]
    return "\n".join(lines) or "nothing"


def scene_of(reply: SceneReply, case: Case, size: tuple[int, int], scale: float) -> SceneState:
    """The scene state that a reply and the person's marks make together.

    size: of the photo, pixels. scale: photo pixels per pixel of the picture that was shown.
    Raises `Invalid` or `ProgramError` with what the model has to correct.
    """
    marked_objects = dict(case.objects)
    said = {item.name for item in reply.objects}
    missing = [name for name in marked_objects if name not in said]
    if missing:
        raise Invalid(f"objects: the person marked {', '.join(missing)}; list them too")
    objects = [_object(item, marked_objects, size, scale) for item in reply.objects]
    given = {item.name for item in (*case.supports, *case.landmarks)}
    supports = list(case.supports)
    for item in reply.supports:
        if item.name not in given:
            points = tuple(_click(click, size, scale, item.name) for click in item.points)
            grounding = Grounding(points=points)
            supports.append(Support(name=item.name, grounding=grounding, material=item.material))
    landmarks = list(case.landmarks)
    for item in reply.landmarks:
        if item.name not in given:
            pixels = tuple((x * scale, y * scale) for x, y in item.pixels)
            landmarks.append(Landmark(name=item.name, kind=item.kind, on=item.on, pixels=pixels))
    if not any(support_kind(item.name) == "floor" for item in supports):
        supports.append(Support(name=GROUND, material="concrete"))
    return _validated(
        SceneState(
            horizon=case.horizon,
            roll=case.roll,
            scale=case.scale if case.scale.metres is not None else _scale(reply),
            objects=tuple(objects),
            supports=tuple(supports),
            landmarks=tuple(landmarks),
        )
    )


def _object(
    item: SeenObject, given: dict[str, Grounding], size: tuple[int, int], scale: float
) -> SceneObject:
    grounding = given.get(item.name)
    if grounding is None:
        if not any(click.label for click in item.points):
            raise Invalid(f"objects.{item.name}.points: needs a point with label 1")
        points = tuple(_click(click, size, scale, item.name) for click in item.points)
        grounding = Grounding(points=points, box=_box(item, scale))
    return SceneObject(
        name=item.name,
        grounding=grounding,
        support=item.support,
        material=item.material,
        density=item.density,
        body=item.body or Rigid(),
    )


def _click(click: Click, size: tuple[int, int], scale: float, name: str) -> Click:
    x, y = click.x * scale, click.y * scale
    if not (0 <= x < size[0] and 0 <= y < size[1]):
        width, rows = size[0] / scale, size[1] / scale
        raise Invalid(
            f"{name}.points: ({click.x:g}, {click.y:g}) lies outside the picture "
            f"(0 to {width:.0f}, 0 to {rows:.0f})"
        )
    return Click(x=round(x, 2), y=round(y, 2), label=click.label)


def _box(item: SeenObject, scale: float) -> tuple[float, float, float, float] | None:
    if item.box is None:
        return None
    left, top, right, bottom = (round(part * scale, 2) for part in item.box)
    if left >= right or top >= bottom:
        raise Invalid(f"objects.{item.name}.box: wants left < right and top < bottom")
    return (left, top, right, bottom)


def _scale(reply: SceneReply) -> Scale:
    name = reply.scale_reference
    sizes = {item.name: item.longest_side for item in reply.objects}
    if name is not None and name not in sizes:
        known = ", ".join(sizes)
        raise Invalid(f"scale_reference: there is no object '{name}' (objects: {known})")
    if name is None or sizes[name] is None:
        return Scale()
    return Scale(reference=name, metres=sizes[name], source="estimated")


def _validated(scene: SceneState) -> SceneState:
    """The same validation as for a program by hand; raises `ProgramError`."""
    return validate_data({"scene": scene.model_dump(mode="json")}).scene


def doubts_of(program: PhysicalProgram) -> str:
    """What preflight doubts about schedule and contract, a line each; "" where nothing."""
    found = [item for item in preflight(program) if item.path.startswith(("event.", "contract."))]
    return "\n".join(f"- {item.path}: {item.message}" for item in found[:MOST_DOUBTS])


def program_of(reply: EventReply, sentence: str, scene: SceneState) -> PhysicalProgram:
    """The whole program of a reply on a completed scene; raises `ProgramError`."""
    contract = Contract(
        clauses=reply.clauses, statements=reply.statements, not_understood=reply.not_understood
    )
    if all(item.id in contract.serving for item in contract.statements):
        raise Invalid("statements: none of them has to hold by itself")
    event = EventProgram(prompt=sentence, actions=reply.actions)
    return validate_data(
        {
            "scene": scene.model_dump(mode="json"),
            "event": event.model_dump(mode="json"),
            "contract": contract.model_dump(mode="json"),
        }
    )
