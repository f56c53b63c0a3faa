"""Record and replay: one JSON file per call, named by the hash of what was said.

Pictures are kept by their hash alone. A replay looks for the exact call first; where the
rendered pixels differ (another machine), the one recorded call with the same words will do.
"""

import json
import os
import secrets
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from physagent_studio.agent.vlm.messages import Answer, Question, TapeMiss, Turn, Usage
from physagent_studio.errors import InputError

FORMAT = 1
MOST_BYTES = 8_000_000


@dataclass(frozen=True, slots=True)
class Tape:
    """A folder of recorded calls. replaying: never go to the network."""

    folder: Path
    replaying: bool

    def find(self, question: Question, model: str) -> Answer | None:
        """The recorded answer; None where there is none and calls may be made.

        Raises:
            TapeMiss: replaying, and the call was not recorded.
        """
        if not self.replaying:
            return None
        exact = self.folder / f"{question.key(model)}.json"
        if exact.is_file():
            return _read(exact)
        words = question.key(model, pictures=False)
        near = [path for path in sorted(self.folder.glob("*.json")) if _words_of(path) == words]
        if len(near) == 1:
            return _read(near[0])
        found = "none" if not near else f"{len(near)} that differ in their pictures"
        raise TapeMiss(
            f"the call {question.purpose} ({question.key(model)[:12]}) is not among the calls "
            f"recorded in {self.folder}: {found} with the same words"
        )

    def keep(self, question: Question, model: str, answer: Answer, hide: str) -> None:
        """Records a call; `hide` is a secret that must not reach the disk."""
        if self.replaying:
            return
        entry = {
            "format": FORMAT,
            "purpose": question.purpose,
            "model": model,
            "words": question.key(model, pictures=False),
            "form": question.form,
            "turns": [_turn(turn) for turn in question.turns],
            "answer": {
                "text": answer.text,
                "finish": answer.finish,
                "refusal": answer.refusal,
                "usage": [answer.usage.input, answer.usage.output, answer.usage.estimated],
            },
        }
        text = json.dumps(entry, indent=1, ensure_ascii=True)
        if hide:
            text = text.replace(hide, "***")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            _write(self.folder / f"{question.key(model)}.json", text)
        except OSError as error:
            raise InputError(
                f"the calls cannot be recorded in {self.folder}: {error.strerror}"
            ) from error


def _turn(turn: Turn) -> dict[str, Any]:
    parts = [
        part if isinstance(part, str) else {"picture": part.digest, "label": part.label}
        for part in turn.parts
    ]
    return {"role": turn.role, "parts": parts}


def _write(path: Path, text: str) -> None:
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def _load(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(f"{path} is larger than {MOST_BYTES} bytes")
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"the recorded call {path} cannot be read: {error}") from error
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise InputError(f"{path} is not a recorded call of format {FORMAT}")
    return data


def _words_of(path: Path) -> str:
    return str(_load(path).get("words"))


def _read(path: Path) -> Answer:
    try:
        answer = _load(path)["answer"]
        tokens_in, tokens_out, estimated = answer["usage"]
        usage = Usage(int(tokens_in), int(tokens_out), bool(estimated))
        return Answer(str(answer["text"]), str(answer["finish"]), str(answer["refusal"]), usage)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"the recorded call {path} is damaged: {error!r}") from error
