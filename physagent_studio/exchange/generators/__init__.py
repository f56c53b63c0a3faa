"""Video generators: a motion prior goes in, a video comes out.

`Composite` is there everywhere: the clip as we draw it. `ComfyUI` hands the control inputs to a
server that runs a workflow of a person's own; `Diffusers` runs Wan VACE in this process. All
keep to the `VideoGenerator` Protocol.
"""

from physagent_studio.exchange.generators.comfyui import ComfyUI
from physagent_studio.exchange.generators.diffusers import Diffusers
from physagent_studio.exchange.generators.protocol import Composite, VideoGenerator
