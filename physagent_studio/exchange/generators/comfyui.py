"""A ComfyUI server that runs a person's own workflow on our control inputs.

The workflow is one saved with "Export (API)": a JSON object of nodes. Where one of its values is a
text of the form `{physagent:NAME}`, ours is put in: `prompt`, `control_video` and `start_image`
(names of the files that were uploaded), `width`, `height`, `length`, `fps`, `seed`. HTTP as
ComfyUI's server has it: POST /upload/image, POST /prompt, GET /history/ID, GET /view; POST
/interrupt where it is cancelled.
"""

import json
import secrets
import time
import urllib.error
import urllib.parse
import urllib.request
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from physagent_studio import errors
from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.exchange.files import written
from physagent_studio.exchange.generators.protocol import Cancelled, Progress
from physagent_studio.exchange.prior import Prior, write_bundles
from physagent_studio.exchange.prior.generators import LONG, WAN

VIDEOS = (".mp4", ".webm", ".mkv", ".mov")
LARGEST = 512 * 2**20
"""Bytes of an answer that are taken."""
ANSWER = 30.0
"""Seconds that a request may take; the work itself is asked after again and again."""
_ASKED = "{physagent:"


@dataclass(frozen=True, slots=True)
class ComfyUI:
    """endpoint: http(s)://host:port. workflow: as saved for its API. patience: s for all of it."""

    endpoint: str
    workflow: dict[str, Any]
    seed: int = 0
    patience: float = 3600.0
    pause: float = 1.0
    name: str = "comfyui"

    def generate(
        self, prior: Prior, out: Path, *, cancelled: Cancelled = None, progress: Progress = None
    ) -> Path:
        """See `VideoGenerator`."""
        write_bundles(prior.folder, ["wan-fun"], cancelled=cancelled)
        folder = prior.folder / "wan-fun"
        values: dict[str, Any] = {
            "prompt": prior.meta["prompt"],
            "width": WAN[0],
            "height": WAN[1],
            "length": LONG,
            "fps": 16,
            "seed": self.seed,
        }
        for name, file in (
            ("control_video", "control_depth.mp4"),
            ("start_image", "start_image.png"),
        ):
            if progress is not None:
                progress("uploading", 0.0)
            values[name] = self._uploaded(folder / file)
        queued = self._posted("/prompt", {"prompt": filled(self.workflow, values)})
        if queued.get("node_errors") or "prompt_id" not in queued:
            told = json.dumps(queued.get("node_errors") or queued)[:500]
            raise InputError(f"{self.endpoint} does not take this workflow: {told}")
        found = self._awaited(str(queued["prompt_id"]), cancelled, progress)
        data = self._got("/view", found)
        with written(out) as partial:
            partial.write_bytes(data)
        return out

    def _awaited(self, key: str, cancelled: Cancelled, progress: Progress) -> dict[str, str]:
        """Where the video is once the server has made it."""
        ends = time.monotonic() + self.patience
        while time.monotonic() < ends:
            if cancelled is not None and cancelled():
                self._posted("/interrupt", {})
                raise errors.Cancelled("the generator was interrupted")
            entry = json.loads(self._got(f"/history/{urllib.parse.quote(key)}")).get(key)
            if entry is not None:
                status = entry.get("status", {})
                if status.get("status_str") == "error":
                    raise InputError(f"{self.endpoint} failed: {json.dumps(status)[:500]}")
                return _video_of(entry, self.endpoint)
            if progress is not None:
                progress("generating", 1 - (ends - time.monotonic()) / self.patience)
            time.sleep(self.pause)
        raise InputError(f"{self.endpoint} made nothing within {self.patience:.0f} s")

    def _uploaded(self, path: Path) -> str:
        """The name by which the server knows a file now."""
        mark = secrets.token_hex(16)
        head = (
            f'--{mark}\r\nContent-Disposition: form-data; name="image"; filename="{path.name}"\r\n'
            "Content-Type: application/octet-stream\r\n\r\n"
        )
        body = head.encode() + path.read_bytes() + f"\r\n--{mark}--\r\n".encode()
        kind = {"Content-Type": f"multipart/form-data; boundary={mark}"}
        told = json.loads(
            self._asked(urllib.request.Request(self._url("/upload/image"), body, kind))
        )
        folder = str(told.get("subfolder", ""))
        return f"{folder}/{told['name']}" if folder else str(told["name"])

    def _posted(self, path: str, value: dict[str, Any]) -> dict[str, Any]:
        body = json.dumps(value).encode()
        kind = {"Content-Type": "application/json"}
        data = self._asked(urllib.request.Request(self._url(path), body, kind))
        return json.loads(data) if data.strip() else {}

    def _got(self, path: str, query: dict[str, str] | None = None) -> bytes:
        asked = f"?{urllib.parse.urlencode(query)}" if query else ""
        return self._asked(urllib.request.Request(self._url(path) + asked))

    def _url(self, path: str) -> str:
        if not self.endpoint.startswith(("http://", "https://")):
            raise InputError(f"{self.endpoint} is no address of a server (http://… or https://…)")
        return self.endpoint.rstrip("/") + path

    def _asked(self, request: urllib.request.Request) -> bytes:
        try:
            with urllib.request.urlopen(request, timeout=ANSWER) as answer:
                data = answer.read(LARGEST + 1)
        except urllib.error.HTTPError as error:
            told = error.read(500).decode("utf-8", "replace")
            raise InputError(f"{self.endpoint} answered {error.code}: {told}") from error
        except (OSError, ValueError) as error:
            raise BackendMissing(f"no ComfyUI answers at {self.endpoint} ({error})") from error
        if len(data) > LARGEST:
            raise InputError(f"{self.endpoint} sent more than {LARGEST} bytes")
        return data


def filled(workflow: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """A workflow with our values in the places that ask for them.

    Raises:
        InputError: nothing asks for the control video, or something asks for what there is not.
    """
    used: set[str] = set()

    def replaced(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: replaced(own) for key, own in value.items()}
        if isinstance(value, list):
            return [replaced(own) for own in value]
        if not (isinstance(value, str) and value.startswith(_ASKED) and value.endswith("}")):
            return value
        name = value[len(_ASKED) : -1]
        if name not in values:
            raise InputError(f"the workflow asks for {value}; there is {', '.join(values)}")
        used.add(name)
        return values[name]

    made = replaced(workflow)
    if "control_video" not in used:
        raise InputError(
            f'the workflow has no place for the control video: write "{_ASKED}control_video}}" '
            "where it names its video"
        )
    return made


def _video_of(entry: dict[str, Any], endpoint: str) -> dict[str, str]:
    """Name, folder and kind of the first video among a finished prompt's outputs."""
    for node in entry.get("outputs", {}).values():
        for files in node.values():
            for file in files if isinstance(files, list) else ():
                if isinstance(file, dict) and str(file.get("filename", "")).endswith(VIDEOS):
                    kept = ("filename", "subfolder", "type")
                    return {key: str(file.get(key, "")) for key in kept}
    raise InputError(f"{endpoint} has finished, but there is no video among what it made")
