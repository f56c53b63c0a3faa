"""Small scenes without a photograph, with prompts in several wordings: `assets/scenes`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import yaml
from pydantic import Field, ValidationError

from physagent_studio.errors import InputError, ProgramError
from physagent_studio.program.base import Frozen
from physagent_studio.program.scene.state import SceneObject, SceneState
from physagent_studio.program.text.document import validate_data
from physagent_studio.records import Case, Scene
from physagent_studio.workbench.engine import Engine


class BareScene(Frozen):
    """scene: complete, every number stated. prompts: wordings of each event, all alike."""

    scene: SceneState
    prompts: Mapping[str, tuple[str, ...]] = Field(min_length=1)

    def case(self, name: str, prompt: str) -> Case:
        """What a person would bring: names, clicks, landmarks and the prompt."""
        clicked = tuple(
            item.model_copy(update={"shape": None})
            for item in self.scene.supports
            if item.grounding.points
        )
        return Case(
            name=name,
            image=None,
            image_hash="",
            objects=tuple((item.name, item.grounding) for item in self.scene.objects),
            supports=clicked,
            landmarks=self.scene.landmarks,
            prompt=prompt,
        )

    def filled(self, state: SceneState) -> SceneState:
        """The state with its open fields taken from the scene."""
        supports = {item.name: item for item in self.scene.supports}
        grounds = [s for s in self.scene.supports if s.shape and s.shape.kind == "floor"]
        known = [supports.get(item.name, *grounds[:1]) for item in state.supports]
        return state.model_copy(
            update={
                "camera": state.camera or self.scene.camera,
                "objects": tuple(self._object(item) for item in state.objects),
                "supports": tuple(
                    item if item.shape is not None else item.model_copy(update={"shape": own.shape})
                    for item, own in zip(state.supports, known, strict=True)
                ),
            }
        )

    def _object(self, item: SceneObject) -> SceneObject:
        own = self.scene.object(item.name)
        if own is None:
            return item
        update = {
            "shape": item.shape or own.shape,
            "position": item.position or own.position,
            "rotation": own.rotation if item.shape is None else item.rotation,
            "support": item.support or own.support,
        }
        return item.model_copy(update=update)


@dataclass
class BareEngine(Engine):
    """An engine whose reconstruction is the scene itself."""

    truth: BareScene = field(kw_only=True)

    def reconstruct(self, state: SceneState, previous: Scene | None) -> Scene:
        """The scene of that state, with its open fields filled."""
        return super().reconstruct(self.truth.filled(state), previous)


def load_bare_scene(path: Path) -> BareScene:
    """The scene of a file; raises InputError where it is not one."""
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        if not isinstance(data, dict):
            raise InputError(f"{path} is no scene with prompts: it is no mapping")
        scene = validate_data({"scene": data.get("scene")}).scene
        return BareScene.model_validate({**data, "scene": scene})
    except (OSError, yaml.YAMLError, ValidationError, ProgramError) as error:
        raise InputError(f"{path} is no scene with prompts: {error}") from error
