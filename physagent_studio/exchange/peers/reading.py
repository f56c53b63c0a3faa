"""Which peer a file is of."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from physagent_studio.exchange.peer_config import PeerSetup, is_peer_config, load_peer_config
from physagent_studio.exchange.peers.forces import is_force_file, load_forces
from physagent_studio.exchange.peers.physgen import load_physgen


def load_peer(
    path: Path | str, names: Sequence[str] = (), prompt: str = "", event: str | None = None
) -> PeerSetup | None:
    """What a file of PhysAgent, RealWonder, PhysGen, Force Prompting or Goal Force says; None for

    others. prompt: the sentence where the file has none, or another.

    Raises:
        InputError: in one sentence: what is wrong and what is allowed.
    """
    path, prompt = Path(path), " ".join(prompt.split())
    if path.name == "sim.yaml" and (path.parent / "mask.png").is_file():
        return load_physgen(path, names, prompt)
    if is_force_file(path):
        setup = load_forces(path, names, event)
    elif path.suffix.lower() in (".yaml", ".yml") and is_peer_config(path):
        setup = load_peer_config(path, names=names)
    else:
        return None
    if not prompt:
        return setup
    events = (("given", prompt),)
    return replace(setup, case=replace(setup.case, prompt=prompt, event="given", events=events))
