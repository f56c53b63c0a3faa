"""Reconstruction by other means, behind the same two Protocols as the embedded default.

Heavy models run out of process: we write a job folder, a small runner script (shipped here, run
by the user in an environment of their own) writes a result folder, and the importer reads it.
"""

from physagent_studio.reconstruction.backends.protocol import backend
