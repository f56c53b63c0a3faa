"""What can go wrong between the studio and a language model, one class per reaction to it."""

from __future__ import annotations

from physagent_studio.errors import StudioError


class VlmError(StudioError):
    """Root: the model gave nothing that can be used. The roles turn it into a legal outcome."""


class BudgetSpent(VlmError):
    """A limit on calls, tokens or money is reached; nothing more is sent."""


class Unreachable(VlmError):
    """The server cannot be reached, refuses the request, or keeps failing after the retries."""


class NoAnswer(VlmError):
    """The model was asked again as often as is allowed and its reply is still not valid."""


class TapeMiss(VlmError):
    """Replaying, and this call was not recorded."""


class Invalid(VlmError):
    """One reply that is not accepted; `str(error)` is the exact message the model gets back."""
