"""Run SAM 2 on a job folder: python sam2_runner.py JOB [MODEL].

Run it in an environment where github.com/facebookresearch/sam2 is installed. MODEL is a name on
the model hub. JOB/result is written; the product reads it.
"""

# pyright: reportMissingImports=false

import json
import sys
from pathlib import Path

MODEL = "facebook/sam2.1-hiera-large"


def main(job_folder: str, model: str = MODEL) -> None:
    """Candidate masks for every object of a job."""
    import numpy as np
    from PIL import Image  # type: ignore[import-not-found]
    from sam2.sam2_image_predictor import SAM2ImagePredictor  # type: ignore[import-not-found]

    folder = Path(job_folder)
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    result = folder / "result.partial"
    result.mkdir(exist_ok=True)
    predictor = SAM2ImagePredictor.from_pretrained(model)
    predictor.set_image(np.array(Image.open(folder / job["image"]).convert("RGB")))
    entries = []
    for index, item in enumerate(job["objects"]):
        points = np.array([p[:2] for p in item["points"]], float) if item["points"] else None
        labels = np.array([p[2] for p in item["points"]], int) if item["points"] else None
        box = np.array(item["box"], float) if item["box"] else None
        if points is None and box is None:
            continue
        masks, scores, _ = predictor.predict(
            point_coords=points, point_labels=labels, box=box, multimask_output=True
        )
        names = [f"{index}_{k}.png" for k in range(len(masks))]
        for name, mask in zip(names, masks, strict=True):
            Image.fromarray((mask > 0).astype(np.uint8) * 255).save(result / name)
        entries.append({"name": item["name"], "masks": names, "scores": [float(s) for s in scores]})
    text = json.dumps({"version": job["version"], "kind": "sam2", "objects": entries}, indent=1)
    (result / "result.json").write_text(text, encoding="utf-8")
    result.rename(folder / "result")


if __name__ == "__main__":
    main(*sys.argv[1:])
