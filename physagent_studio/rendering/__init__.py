"""Rendering: a scene and poses → frames with ids and depth, exact flow, clips."""

from physagent_studio.rendering.clip import frame_of, render_clip
from physagent_studio.rendering.compositor import Compositor
from physagent_studio.rendering.flow import Tracked, Tracks, flow_between, normals_of
from physagent_studio.rendering.frame import Flow, Frame
