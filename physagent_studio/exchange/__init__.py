"""Exchange: cases in, videos, motion priors and animated scenes out."""

from physagent_studio.exchange.animation import write_glb
from physagent_studio.exchange.annotations import annotated
from physagent_studio.exchange.case_folder import case_from_image, load_case
from physagent_studio.exchange.lessons import read_lessons, write_lessons
from physagent_studio.exchange.peer_config import PeerSetup, load_peer_config
from physagent_studio.exchange.peers.reading import load_peer
from physagent_studio.exchange.prior import (
    BUNDLES,
    Prior,
    check_bundles,
    export_motion_prior,
    made_from,
    write_bundles,
)
from physagent_studio.exchange.replay import Replay, ReplayCheck, ReplayRound, replay_html
from physagent_studio.exchange.video import video_size, write_video
