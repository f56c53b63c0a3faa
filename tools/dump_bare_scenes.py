"""Write assets/scenes/<stage>.yaml: the stages and prompts that the rule agent is tested on.

Run as `python tools/dump_bare_scenes.py` in the checkout after either has changed.
"""

from __future__ import annotations

import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from physagent_studio.agent.rules import RuleGenerator  # noqa: E402
from physagent_studio.program import PhysicalProgram, SceneState  # noqa: E402
from physagent_studio.program.scene.bodies import Rigid  # noqa: E402
from physagent_studio.program.text.document import dump_entry, dump_program  # noqa: E402
from tests.agent.rules.scenes import STAGES  # noqa: E402


def scenes() -> dict[str, str]:
    """Texts of the files by stage."""
    path = ROOT / "tests" / "agent" / "rules" / "prompts.yaml"
    events = yaml.safe_load(path.read_text(encoding="utf-8"))
    states: dict[str, SceneState] = {}
    prompts: dict[str, dict[str, list[str]]] = {}
    for event in events:
        stage, wordings = STAGES[event["stage"]], event["wordings"]
        if stage.name not in states:
            # The generator's scene of any prompt; what the prompt made of it is taken away again.
            state = RuleGenerator().first(stage.case(wordings[0]), stage.reconstruct).scene
            full = stage.reconstruct(state).state
            objects = tuple(
                item.model_copy(
                    update={
                        "material": "plastic", "density": None, "friction": None,
                        "restitution": None, "body": Rigid(),
                        "support": stage.objects[item.name][2],
                    }
                )
                for item in full.objects
            )  # fmt: skip
            marks = tuple(m for m in full.landmarks if m.name in stage.landmarks)
            update = {"objects": objects, "landmarks": marks, "flags": ()}
            states[stage.name] = full.model_copy(update=update)
        prompts.setdefault(stage.name, {})[event["event"]] = wordings
    return {name: _text(state, prompts[name]) for name, state in states.items()}


def _text(state: SceneState, prompts: dict[str, list[str]]) -> str:
    program = dump_program(PhysicalProgram(scene=state))
    scene = program[program.index("scene:") :]
    return scene.split("\nevent:")[0].split("\ncontract:")[0] + dump_entry("prompts", prompts)


def main() -> None:
    """Writes all files."""
    folder = ROOT / "assets" / "scenes"
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in scenes().items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
