"""Who may use a studio, from where, as what, and on which port; knows nothing of viser.

On the loopback everybody is an editor. Anywhere else a token in the opened address is exchanged for
a cookie that scripts cannot read and other sites cannot send; a second token makes a viewer.

The port is open before anything heavy is loaded: whoever connects before the studio is there waits
in the kernel's queue and is answered then, so that the address can be printed at once.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import secrets
import socket
import urllib.parse
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Literal

from physagent_studio.errors import InputError

Role = Literal["editor", "viewer"]
LOOPBACK_NAMES = ("127.0.0.1", "localhost", "[::1]")
TOKEN_BYTES = 24
"""Of randomness in a token; nobody guesses 192 bits."""


def _token() -> str:
    return secrets.token_urlsafe(TOKEN_BYTES)


@dataclass(frozen=True, slots=True)
class Access:
    """host: the address that is listened on. public: where a reverse proxy shows the studio, such
    as `https://demo.example/studio`, "" without one. guarded: whether tokens are asked for."""

    host: str = "127.0.0.1"
    public: str = ""
    guarded: bool = False
    tokens: dict[Role, str] = field(
        default_factory=lambda: {"editor": _token(), "viewer": _token()}, repr=False
    )
    cookies: dict[Role, str] = field(
        default_factory=lambda: {"editor": _token(), "viewer": _token()}, repr=False
    )

    @classmethod
    def to(cls, host: str, public: str = "", *, viewers: bool = False) -> Access:
        """Access by that address; tokens wherever somebody else could come."""
        if public:
            parts = urllib.parse.urlsplit(public)
            if parts.scheme not in ("http", "https") or not parts.hostname or parts.query:
                raise InputError(f"--public {public} is not of the form https://host/path")
        away = host not in ("127.0.0.1", "localhost", "::1")
        return cls(host, public.rstrip("/"), away or bool(public) or viewers)

    @property
    def cookie_name(self) -> str:
        """Of this studio alone: cookies of one host are shared by all of its ports."""
        return f"physagent-{hashlib.sha256(self.tokens['editor'].encode()).hexdigest()[:12]}"

    def link(self, port: int, role: Role = "editor") -> str:
        """The address to open."""
        host = "127.0.0.1" if self.host in ("0.0.0.0", "::") else self.host
        base = self.public or f"http://{f'[{host}]' if ':' in host else host}:{port}"
        if not self.guarded:
            return base
        return f"{base}/?token={self.tokens[role]}"

    def role_of(self, cookies: str) -> Role | None:
        """What the sender of these cookies is; None for a stranger."""
        if not self.guarded:
            return "editor"
        try:
            morsel = SimpleCookie(cookies).get(self.cookie_name)
        except CookieError:
            return None
        return self._matching(self.cookies, "" if morsel is None else morsel.value)

    def exchange(self, token: str) -> str | None:
        """The cookie (of `Set-Cookie`) for a token; None for a wrong one."""
        role = self._matching(self.tokens, token)
        if role is None or not self.guarded:
            return None
        path = urllib.parse.urlsplit(self.public).path or "/"
        secure = "; Secure" if self.public.startswith("https:") else ""
        value = f"{self.cookie_name}={self.cookies[role]}"
        return f"{value}; Path={path}; HttpOnly; SameSite=Strict{secure}"

    @staticmethod
    def _matching(known: dict[Role, str], given: str) -> Role | None:
        found: Role | None = None
        for role, value in known.items():
            # All of them are compared, so that time says nothing.
            if hmac.compare_digest(value.encode(), given.encode("utf-8", "surrogatepass")):
                found = role
        return found

    def allows_host(self, host: str) -> bool:
        """Whether a Host header names this server; a name that only leads here does not."""
        if is_loopback(host):
            return True
        name = _name_of(host)
        if self.public and host == urllib.parse.urlsplit(self.public).netloc:
            return True
        if self.host in ("127.0.0.1", "localhost", "::1"):
            return False
        # Whoever leads a name of their own here has to use that name, never a number.
        own = socket.gethostname().lower()
        return name in (self.host, own, f"{own}.local") or _is_number(name)

    def allows_origin(self, origin: str, host: str) -> bool:
        """Whether a page of that origin may use the server that it calls `host`."""
        if self.public:
            parts = urllib.parse.urlsplit(self.public)
            if origin == f"{parts.scheme}://{parts.netloc}":
                return True
        return origin == f"http://{host}"

    def sockets(self, host: str) -> str:
        """Where pages may open sockets to, for their policy."""
        if self.public:
            parts = urllib.parse.urlsplit(self.public)
            return f"{'wss' if parts.scheme == 'https' else 'ws'}://{parts.netloc}"
        return f"ws://{host}"


def is_loopback(host: str) -> bool:
    """Whether a Host header names this machine; any port, since a tunnel may change it."""
    name, _, port = host.rpartition(":") if not host.endswith("]") else (host, "", "")
    if not name:
        name, port = port, ""
    return name in LOOPBACK_NAMES and (port == "" or port.isdecimal())


def _name_of(host: str) -> str:
    try:
        return urllib.parse.urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _is_number(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


FIRST_PORT = 8080
PORTS = 1000
"""How many are tried, from the first on."""
WAITING = 64
"""Connections that may wait for the studio to be there."""
IN_USE = (48, 98)
"""Error numbers of a port that is taken, on macOS and Linux."""


def listening(host: str, port: int | None) -> socket.socket:
    """A socket that listens there; port None: the next free one from 8080, 0: any.

    Raises:
        InputError: the port that was asked for is busy, or not a port; there is no such address.
    """
    if port is not None and not 0 <= port <= 65535:
        raise InputError(f"--port {port} is not a port; allowed: 0 … 65535")
    wanted = range(FIRST_PORT, FIRST_PORT + PORTS) if port is None else (port,)
    for number in wanted:
        try:
            return _bound(host, number)
        except OSError as error:
            if error.errno in IN_USE and port is None:
                continue
            raise InputError(_why(host, number, error)) from error
    raise InputError(f"no port from {FIRST_PORT} on is free; choose one with --port")


def _bound(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family, socket.SOCK_STREAM)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((host, port))
        made.listen(WAITING)
    except OSError:
        made.close()
        raise
    return made


def _why(host: str, port: int, error: OSError) -> str:
    if error.errno in IN_USE:
        return f"port {port} is in use; choose another with --port, or none"
    return f"{host}, port {port}, cannot be used ({error.strerror})"
