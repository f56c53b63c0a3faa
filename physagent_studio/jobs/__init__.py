"""Pure tasks under limits: a function and values in, its result or the reason why not out.

Knows nothing of physics. `shared()` is the pool of processes in which everything of strangers is
decoded; `Inline` runs a task here and now, for tests and for what is trusted.
"""

from physagent_studio.jobs.executor import Executor, Inline, JobFailed, Limits, hearing
from physagent_studio.jobs.processes import Processes, shared, within
