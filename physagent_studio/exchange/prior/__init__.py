"""Motion priors: a rollout as what video generators are conditioned on.

`export_motion_prior` writes the folder in one pass over the frames, `Prior` reads one again, and
`BUNDLES` rewrites it as others read it: Middlebury and KITTI flow, tables, MJCF, a recording for
Rerun, the folder of RealWonder's and PhysAgent's generators, inputs of Wan VACE, Wan-Fun and
Go-with-the-Flow.
"""

from physagent_studio.exchange.prior.bundles import BUNDLES, check_bundles, write_bundles
from physagent_studio.exchange.prior.export import export_motion_prior, made_from
from physagent_studio.exchange.prior.folder import Prior
