"""Measures the statements of an event contract on a rollout; NumPy only."""

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.measure import MEASURES, measure, met
from physagent_studio.contract.words import INSTEAD, claim, describe
