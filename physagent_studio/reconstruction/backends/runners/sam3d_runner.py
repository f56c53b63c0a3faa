"""Run SAM 3D Objects on a job folder: python sam3d_runner.py JOB [CONFIG].

Run it in an environment where github.com/facebookresearch/sam-3d-objects and its weights are
installed, from that repository's folder. It needs a GPU with at least 32 GB. JOB/result is
written; the product reads it.
"""

# pyright: reportMissingImports=false

import json
import sys
from pathlib import Path
from typing import Any

CONFIG = "checkpoints/hf/pipeline.yaml"


def main(job_folder: str, config: str = CONFIG) -> None:
    """Reconstruct every masked object of a job."""
    sys.path.append("notebook")
    from inference import Inference, load_image, load_mask  # type: ignore[import-not-found]

    folder = Path(job_folder)
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    result = folder / "result.partial"
    result.mkdir(exist_ok=True)
    model = Inference(config, compile=False)
    image = load_image(str(folder / job["image"]))
    entries = []
    for index, item in enumerate(job["objects"]):
        if "mask" not in item:
            continue
        output = model(image, load_mask(str(folder / item["mask"])), seed=job["seed"])
        output["glb"].export(str(result / f"{index}.glb"))
        entries.append(
            {
                "name": item["name"],
                "mesh": f"{index}.glb",
                "rotation": _plain(output["rotation"]),
                "translation": _plain(output["translation"]),
                "scale": _plain(output["scale"]),
            }
        )
    text = json.dumps({"version": job["version"], "kind": "sam3d", "objects": entries}, indent=1)
    (result / "result.json").write_text(text, encoding="utf-8")
    result.rename(folder / "result")


def _plain(values: Any) -> list[float]:
    """A tensor or sequence as a flat list of numbers."""
    flat = values.detach().cpu().reshape(-1).tolist() if hasattr(values, "detach") else values
    return [float(value) for value in flat]


if __name__ == "__main__":
    main(*sys.argv[1:])
