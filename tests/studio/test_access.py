"""Who may come in from where, and as what."""

from __future__ import annotations

import pytest

from physagent_studio.errors import InputError
from physagent_studio.studio.access import Access


def test_on_the_loopback_nobody_is_asked() -> None:
    access = Access.to("127.0.0.1")
    assert access.link(8080) == "http://127.0.0.1:8080"
    assert access.role_of("") == "editor"
    assert not access.allows_host("192.168.1.5:8080")


def test_elsewhere_a_token_becomes_a_cookie() -> None:
    access = Access.to("0.0.0.0")
    assert access.role_of("") is None
    assert access.exchange("wrong") is None
    for role in ("editor", "viewer"):
        token = access.link(8080, role).partition("token=")[2]
        cookie = access.exchange(token)
        assert cookie is not None
        assert token not in cookie
        assert {"HttpOnly", "SameSite=Strict"} <= set(cookie.split("; "))
        assert access.role_of(cookie.partition(";")[0]) == role
    assert access.role_of(f"{access.cookie_name}=\xfc") is None


@pytest.mark.parametrize("name", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", ""])
def test_a_name_that_leads_here_is_no_address(name: str) -> None:
    assert not Access.to("0.0.0.0").allows_host(name)


def test_behind_a_proxy_its_own_address_counts() -> None:
    access = Access.to("127.0.0.1", "https://demo.example/studio/")
    assert access.link(1).startswith("https://demo.example/studio/?token=")
    assert access.allows_host("demo.example")
    assert access.allows_origin("https://demo.example", "127.0.0.1:8080")
    assert not access.allows_origin("http://demo.example", "127.0.0.1:8080")
    assert access.sockets("demo.example") == "wss://demo.example"
    cookie = access.exchange(access.tokens["editor"])
    assert cookie is not None
    assert "Secure" in cookie
    assert "Path=/studio" in cookie


@pytest.mark.parametrize("public", ["demo.example", "ftp://x", "https://", "https://a/?b=c"])
def test_a_public_address_has_a_form(public: str) -> None:
    with pytest.raises(InputError, match="--public"):
        Access.to("127.0.0.1", public)
