"""One request over the `openai` SDK: bounded in time and bytes, cancellable, never redirected.

The SDK's own retries are off, since each attempt counts against the budget and waits must be
cancellable. Bodies are read here and not by the SDK, so that a reply of any size stays bounded.
"""

import asyncio
import concurrent.futures
import importlib
import json
import logging
import threading
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any, TypeVar

from physagent_studio.agent.vlm.config import Endpoint
from physagent_studio.agent.vlm.messages import Answer, Usage, VlmError
from physagent_studio.errors import BackendMissing, Cancelled

MOST_BYTES = 2_000_000
MOST_ERROR_BYTES = 20_000
_TALKATIVE = ("openai", "httpx", "httpx2", "httpcore", "httpcore2")


class WireFailure(VlmError):
    """One attempt that failed. outcome: the word for the record. passing: worth another try.

    billed: the server may have worked on it, so that it counts against the budget.
    """

    def __init__(
        self,
        outcome: str,
        detail: str,
        *,
        status: int | None = None,
        passing: bool = False,
        billed: bool = False,
        wait: float | None = None,
    ) -> None:
        self.outcome, self.detail, self.status = outcome, detail, status
        self.passing, self.billed, self.wait = passing, billed, wait
        super().__init__(detail)


@dataclass(frozen=True, slots=True)
class _Raw:
    status: int
    headers: dict[str, str]
    body: bytes


class _Stop(Exception):
    """Carries a response that is not a success out of the SDK's own handling."""

    def __init__(self, raw: _Raw) -> None:
        self.raw = raw
        super().__init__(f"HTTP {raw.status}")


def check_installed() -> None:
    """Raises `BackendMissing` where the SDK is not installed."""
    try:
        import openai  # noqa: F401
    except ImportError as error:
        raise BackendMissing(
            "the VLM agent needs the openai package, which is not installed: "
            'pip install "physagent-studio[vlm]"'
        ) from error


def hush() -> None:
    """Keeps the SDK and what is below it from logging requests, whatever levels are set.

    Their debug output holds headers and bodies, so a server that repeats the key in an answer
    would put it into a log file.
    """
    for name in _TALKATIVE:
        logging.getLogger(name).setLevel(logging.WARNING)


def send(endpoint: Endpoint, payload: dict[str, Any], cancelled: Callable[[], bool]) -> Answer:
    """Sends one chat completion request and reads its answer.

    payload: the body of the request. Raises `WireFailure`, or `Cancelled`.
    """
    check_installed()
    import openai

    hush()
    try:
        raw = run_cancellable(
            lambda: _post(endpoint, payload), endpoint.patience.timeout, cancelled
        )
    except (TimeoutError, openai.APITimeoutError):
        seconds = endpoint.patience.timeout
        text = f"{endpoint.host} did not answer within {seconds:g} s"
        raise WireFailure("timeout", text, passing=True, billed=True) from None
    except (_Stop, openai.APIConnectionError, _transport_errors()) as error:
        # Some releases of the SDK wrap what its transport raises, some do not.
        cause = error.__cause__ if isinstance(error, openai.APIConnectionError) else error
        if isinstance(cause, _Stop):
            raise _status_failure(endpoint, cause.raw) from None
        text = f"no connection to {endpoint.host}: {cause or error}"
        raise WireFailure("no connection", text, passing=True) from None
    except openai.OpenAIError as error:
        raise WireFailure("malformed", f"{endpoint.host}: {error}", billed=True) from None
    return _answer(endpoint, raw)


def _transport_errors() -> type[Exception]:
    """The root of the errors of the HTTP library that the installed SDK stands on."""
    import openai

    base = openai.DefaultAsyncHttpxClient.__mro__[1]
    return importlib.import_module(base.__module__.partition(".")[0]).HTTPError


async def _post(endpoint: Endpoint, payload: dict[str, Any]) -> _Raw:
    import openai

    timeout = endpoint.patience.timeout
    async with (
        # A redirect would carry pictures to a server that nobody named.
        openai.DefaultAsyncHttpxClient(
            follow_redirects=False,
            # Without TLS there is nothing to verify, and loading certificates takes its time.
            verify=endpoint.base_url.startswith("https:"),
            event_hooks={"response": [_only_success]},
        ) as http,
        openai.AsyncOpenAI(
            api_key=endpoint.secret or "none",
            base_url=endpoint.base_url,
            timeout=timeout,
            max_retries=0,
            http_client=http,
        ) as client,
    ):
        call = client.chat.completions.with_streaming_response.create(
            **payload, extra_headers={"Accept-Encoding": "identity"}
        )
        async with call as response:
            return await _read(response.status_code, response.headers, response.iter_bytes())


async def _only_success(response: Any) -> None:
    """Runs before the SDK looks at a response, whose error bodies it would read without bound."""
    if response.headers.get("content-encoding", "identity").lower() not in ("", "identity"):
        head = _Raw(0, {}, b"the server sends a compressed body although it was asked not to")
        raise _Stop(head)
    if not 200 <= response.status_code < 300:
        body = response.aiter_bytes()
        raise _Stop(await _read(response.status_code, response.headers, body, MOST_ERROR_BYTES))


async def _read(status: int, headers: Any, chunks: Any, most: int = MOST_BYTES) -> _Raw:
    found = bytearray()
    async for chunk in chunks:
        found += chunk
        if len(found) > most:
            break
    return _Raw(status, {key.lower(): value for key, value in headers.items()}, bytes(found))


def _status_failure(endpoint: Endpoint, raw: _Raw) -> WireFailure:
    host, status, words = endpoint.host, raw.status, _words(raw.body)
    said = f": {words}" if words else ""
    if status == 0:
        return WireFailure("malformed", f"{host}: {words}")
    if 300 <= status < 400:
        target = raw.headers.get("location", "another address")
        text = f"{host} redirects to {target[:200]}; configure the address that is meant"
        return WireFailure(f"http {status}", text, status=status)
    if status in (401, 403):
        text = f"{host} refuses the key (HTTP {status}); check PHYSAGENT_VLM_KEY{said}"
        return WireFailure(f"http {status}", text, status=status)
    if status == 404:
        text = f"{host} does not know this model or address (HTTP 404){said}"
        return WireFailure("http 404", text, status=404)
    # A quota that is used up does not come back within a retry.
    passing = status in (408, 409, 429) or status >= 500
    passing = passing and "insufficient_quota" not in words
    text = f"{host} answers HTTP {status}{said}"
    return WireFailure(
        f"http {status}", text, status=status, passing=passing, wait=_retry_after(raw.headers)
    )


def _words(body: bytes) -> str:
    """What an error body says, shortened."""
    text = body.decode("utf-8", "replace")
    try:
        data = json.loads(text)
        error = data.get("error", data) if isinstance(data, dict) else data
        if isinstance(error, dict):
            parts = (error.get("code"), error.get("message"))
            text = " ".join(str(part) for part in parts if part)
    except (ValueError, RecursionError):
        pass
    return " ".join(text.split())[:400]


def _retry_after(headers: dict[str, str]) -> float | None:
    try:
        return max(0.0, float(headers.get("retry-after", "")))
    except ValueError:
        return None


def _answer(endpoint: Endpoint, raw: _Raw) -> Answer:
    if len(raw.body) > MOST_BYTES:
        text = f"the reply is larger than {MOST_BYTES} bytes"
        raise WireFailure("too large", f"{endpoint.host}: {text}", billed=True)
    try:
        data = json.loads(raw.body)
        choice = data["choices"][0]
        message = choice["message"]
        text, refusal = message.get("content"), message.get("refusal")
        finish = choice.get("finish_reason")
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, RecursionError):
        text = f"{endpoint.host} does not answer in the form of a chat completion"
        raise WireFailure("malformed", text, passing=True, billed=True) from None
    return Answer(
        text=_text(text),
        finish=str(finish or "stop"),
        refusal=_text(refusal),
        usage=_usage(data.get("usage")),
    )


def _text(content: Any) -> str:
    """The words of a message; some servers send a list of parts."""
    if isinstance(content, list):
        parts = [part.get("text", "") for part in content if isinstance(part, dict)]
        return "".join(str(part) for part in parts)
    return content if isinstance(content, str) else ""


def _usage(data: Any) -> Usage:
    if isinstance(data, dict):
        sent, came = _count(data.get("prompt_tokens")), _count(data.get("completion_tokens"))
        # A count that makes no sense would let the budget run away, so it is estimated instead.
        if sent is not None and came is not None:
            return Usage(sent, came)
    return Usage(estimated=True)


def _count(value: Any) -> int | None:
    return value if type(value) is int and 0 <= value < 10**9 else None


T = TypeVar("T")
POLL_SECONDS = 0.05


def run_cancellable(
    work: Callable[[], Coroutine[Any, Any, T]], timeout: float, cancelled: Callable[[], bool]
) -> T:
    """The coroutine's result.

    It runs in an event loop of its own in a daemon thread, so that cancelling it closes its
    sockets even while a server drips one byte at a time.

    Raises:
        TimeoutError: it took longer than `timeout` seconds in all.
        Cancelled: `cancelled()` became true; the caller is free within `POLL_SECONDS`.
    """
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=_serve, args=(loop,), name="vlm-call", daemon=True)
    thread.start()
    future = asyncio.run_coroutine_threadsafe(asyncio.wait_for(work(), timeout), loop)
    try:
        while not future.done():
            if cancelled():
                raise Cancelled("cancelled")
            concurrent.futures.wait([future], POLL_SECONDS)
        return future.result()
    finally:
        # Also where the caller is interrupted: nothing goes on behind its back.
        future.cancel()
        loop.call_soon_threadsafe(loop.stop)


def _serve(loop: asyncio.AbstractEventLoop) -> None:
    asyncio.set_event_loop(loop)
    loop.run_forever()
    left = asyncio.all_tasks(loop)
    for task in left:
        task.cancel()
    loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
    loop.run_until_complete(loop.shutdown_asyncgens())
    loop.close()


def wait(seconds: float, cancelled: Callable[[], bool]) -> None:
    """Sleeps, or raises `Cancelled` as soon as `cancelled()` is true."""
    quiet = threading.Event()
    left = seconds
    while True:
        if cancelled():
            raise Cancelled("cancelled")
        if left <= 0:
            return
        quiet.wait(min(left, POLL_SECONDS))
        left -= POLL_SECONDS
