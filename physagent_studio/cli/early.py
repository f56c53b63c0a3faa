"""What is wrong with the words of a command, said before the rooms that it needs are loaded."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from physagent_studio.errors import InputError

if TYPE_CHECKING:
    # Only named in annotations here; importing them would take the second that is saved.
    from physagent_studio.records.loop_state import PolicyName
    from physagent_studio.workbench.engine import AgentName

IMAGES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff")
POLICIES: dict[str, PolicyName] = {"auto": "auto", "ask": "ask", "ask_when": "ask_when"}


@dataclass(frozen=True, slots=True)
class RunRequest:
    """What was asked of `physagent run`."""

    target: str
    event: str | None
    prompt: str
    objects: tuple[str, ...]
    rounds: int
    policy: str
    by_hand: tuple[str, ...]
    frames: bool | None
    agent: str
    annotation: Path | None = None
    lessons: Path | None = None
    yes: bool = False
    horizon: float | None = None
    seconds: float | None = None
    out: Path | None = None
    masks: Path | None = None
    verbose: bool = False

    def __post_init__(self) -> None:
        """Raises `InputError` for a word that is none of those allowed."""
        from physagent_studio.cli.marks import parse_objects
        from physagent_studio.records.loop_state import ROLES

        if self.policy not in POLICIES:
            raise InputError(f"--policy {self.policy} is not known ({', '.join(POLICIES)})")
        unknown = [role for role in self.by_hand if role not in ROLES]
        if unknown:
            raise InputError(f"--by-hand {unknown[0]} is not known ({', '.join(ROLES)})")
        if agent_name(self.agent) == "vlm" and self.seconds is not None:
            raise InputError("--seconds goes with --agent rules; a model writes its own clip")
        if Path(self.target).suffix.lower() in IMAGES:
            parse_objects(self.objects)
        if self.out is not None:
            video_name(self.out)
        if self.masks is not None and self.masks.suffix.lower() != ".png":
            raise InputError(f"{self.masks} would be a PNG; call it {self.masks.stem}.png")

    @property
    def draws(self) -> bool:
        """Whether each round's frames are drawn at once: unless asked, where a model looks at them.

        Numbers are judged without pictures, and the studio draws what a person looks at.
        """
        return agent_name(self.agent) == "vlm" if self.frames is None else self.frames


def agent_name(word: str) -> AgentName:
    """The agent that the word names."""
    if word == "rules" or word == "vlm":
        return word
    raise InputError(f"--agent {word} is not known (rules, vlm)")


def size_of(word: str) -> tuple[int, int] | None:
    """Width and height of "832x480"; None of nothing. Raises InputError for anything else."""
    if not word:
        return None
    width, _, height = word.lower().replace("×", "x").partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise InputError(f"--size {word} is not of the form 832x480")
    return int(width), int(height)


def video_name(path: Path) -> None:
    """Raises `InputError` for a video that is called as another kind of file."""
    if path.suffix.lower() != ".mp4":
        raise InputError(
            f"{path} would be an MP4 video under another name; call it {path.stem}.mp4"
        )


def there(path: Path | str, wanted: str) -> None:
    """Raises `InputError` where nothing is at that path. wanted: what should be, "a program"."""
    if not Path(path).exists():
        raise InputError(f"{path} does not exist ({wanted} is needed)")


def is_session(target: str) -> bool:
    """Whether the word names a session rather than something on the disk."""
    path = Path(target)
    return not path.exists() and not path.suffix and "/" not in target


def target_there(
    target: str, workspace: Path | None, wanted: str = "a case folder, an image or a program"
) -> None:
    """Raises `InputError` for a target that is neither on the disk nor a session."""
    if is_session(target):
        session_there(target, workspace)
    else:
        there(target, wanted)


def session_there(session_id: str, workspace: Path | None) -> None:
    """Raises `InputError` where the workspace has no session of that id."""
    from physagent_studio.session import Store

    Store(workspace).folder_of(session_id)


def writable(out: Path | None) -> None:
    """Raises `InputError` where a file could not be written: before the work, not after it."""
    if out is not None and (out.is_dir() or not out.absolute().parent.is_dir()):
        raise InputError(f"--out {out} is no file in a folder that exists")
