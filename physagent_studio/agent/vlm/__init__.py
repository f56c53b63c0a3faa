"""The VLM agent: the three roles played by any server that speaks OpenAI's chat protocol."""

from physagent_studio.agent.vlm.config import Endpoint, Limits, Settings, load_settings
from physagent_studio.agent.vlm.crew import crew_from_environment, crew_of
from physagent_studio.agent.vlm.generator import VlmGenerator
from physagent_studio.agent.vlm.line import Answers
from physagent_studio.agent.vlm.messages import VlmError
from physagent_studio.agent.vlm.planner import VlmPlanner
from physagent_studio.agent.vlm.spending import CallLog, CallRecord, Ledger
from physagent_studio.agent.vlm.verifier import VlmVerifier
