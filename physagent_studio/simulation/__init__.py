"""Program → MuJoCo model → rollout."""

from physagent_studio.simulation.simulator import Simulator, simulate
