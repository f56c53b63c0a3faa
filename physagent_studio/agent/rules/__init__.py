"""The embedded agent: rules, mechanics and search; needs nothing but the program's own rooms."""

from physagent_studio.agent.rules.generator import RuleGenerator
from physagent_studio.agent.rules.planner.easing import Easing
from physagent_studio.agent.rules.planner.planner import RulePlanner
from physagent_studio.agent.rules.verifier.verifier import RuleVerifier
