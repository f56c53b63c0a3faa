"""The port that a studio will be served on, open before anything heavy is loaded.

Whoever connects before the studio is there waits in the kernel's queue and is answered then, so
that the address can be printed at once.
"""

from __future__ import annotations

import socket

from physagent_studio.errors import InputError

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
