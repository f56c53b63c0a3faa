"""Where settings come from, which goes first, and that a key stays where it belongs."""

from __future__ import annotations

from pathlib import Path

import pytest

from physagent_studio.agent.crew import Crew
from physagent_studio.agent.rules import RuleVerifier
from physagent_studio.agent.vlm import (
    CallRecord,
    VlmPlanner,
    VlmVerifier,
    config,
    crew_from_environment,
)
from physagent_studio.agent.vlm.config import Settings, load_settings
from physagent_studio.agent.vlm.messages import BudgetSpent
from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.records import Case, LoopState
from physagent_studio.records.loop_state import ROLES
from physagent_studio.session import Store
from physagent_studio.workbench.engine import Engine

LOCAL = {"PHYSAGENT_VLM_BASE_URL": "http://127.0.0.1:1/v1", "PHYSAGENT_VLM_MODEL": "m"}
KEY = "sk-secret-value"


def settings(tmp_path: Path, text: str = "", **environ: str) -> Settings:
    path = tmp_path / "vlm.yaml"
    path.write_text(text)
    return load_settings({"PHYSAGENT_VLM_CONFIG": str(path), **environ})


def test_environment_alone_is_enough(tmp_path: Path) -> None:
    found = settings(tmp_path, **LOCAL, PHYSAGENT_VLM_KEY=KEY, PHYSAGENT_VLM_CALLS="7")
    planner = found.endpoints["planner"]
    assert (planner.base_url, planner.model, planner.secret) == ("http://127.0.0.1:1/v1", "m", KEY)
    assert found.limits.calls == 7


def test_roles_may_differ_and_the_environment_goes_first(tmp_path: Path) -> None:
    text = """
base_url: http://127.0.0.1:1/v1
model: common
temperature: 0.2
patience: {timeout: 30, retries: 1}
limits: {calls: 5, tokens: 1000}
roles:
  planner: {model: thinker, temperature: 1.0}
  verifier: {model: seer, base_url: "http://127.0.0.1:2/v1"}
"""
    found = settings(tmp_path, text, PHYSAGENT_VLM_VERIFIER_MODEL="eye")
    assert {role: end.model for role, end in found.endpoints.items()} == {
        "generator": "common",
        "verifier": "eye",
        "planner": "thinker",
    }
    assert found.endpoints["verifier"].base_url == "http://127.0.0.1:2/v1"
    assert found.endpoints["planner"].temperature == 1.0
    assert found.endpoints["generator"].temperature == 0.2
    assert found.endpoints["generator"].patience.timeout == 30
    assert found.limits.calls == 5


def test_nothing_configured_says_what_to_set(tmp_path: Path) -> None:
    with pytest.raises(BackendMissing, match="set PHYSAGENT_VLM_BASE_URL, PHYSAGENT_VLM_MODEL"):
        settings(tmp_path)
    with pytest.raises(BackendMissing, match="no model is configured for the generator"):
        settings(tmp_path, OPENAI_API_KEY=KEY)


def test_a_key_is_never_sent_to_a_server_that_it_was_not_given_for(tmp_path: Path) -> None:
    elsewhere = settings(tmp_path, **LOCAL, OPENAI_API_KEY=KEY)
    assert elsewhere.endpoints["planner"].secret == ""
    own = settings(tmp_path, PHYSAGENT_VLM_MODEL="m", OPENAI_API_KEY=KEY)
    assert own.endpoints["planner"].base_url == "https://api.openai.com/v1"
    assert own.endpoints["planner"].secret == KEY
    gateway = settings(
        tmp_path, **LOCAL, OPENAI_API_KEY=KEY, OPENAI_BASE_URL="http://127.0.0.1:1/v1"
    )
    assert gateway.endpoints["planner"].secret == KEY
    text = f'key: {KEY}\nroles: {{planner: {{base_url: "http://127.0.0.1:2/v1"}}}}'
    split = settings(tmp_path, text, **LOCAL)
    assert split.endpoints["verifier"].secret == KEY
    assert split.endpoints["planner"].secret == ""


def test_a_key_may_stand_in_a_variable_of_any_name(tmp_path: Path) -> None:
    found = settings(tmp_path, "key_env: MY_KEY", **LOCAL, MY_KEY=KEY)
    assert found.endpoints["planner"].secret == KEY


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("modell: m", "modell: is not a known setting"),
        ("limits: {calls: 0}", "limits.calls: Input should be greater than or equal to 1"),
        ("base_url: ftp://host/v1", "must be an http:// or https:// address"),
        ("base_url: http://user:word@host/v1", "must not carry a user, a password or a query"),
        ("patience: {timeout: .inf}", "patience.timeout: Input should be"),
        ("- a\n- b", "must be a list of `name: value` lines"),
        ("limits: {money: 1.0}", "a limit in money needs prices for every role"),
        ("roles: {critic: {model: m}}", "roles.critic.*'generator', 'verifier' or 'planner'"),
    ],
)
def test_a_wrong_setting_is_named(text: str, message: str, tmp_path: Path) -> None:
    environ = {} if "base_url" in text else {"PHYSAGENT_VLM_BASE_URL": "http://127.0.0.1:1/v1"}
    with pytest.raises(InputError, match=message):
        settings(tmp_path, text, PHYSAGENT_VLM_MODEL="m", **environ)


@pytest.mark.parametrize(
    "text",
    [
        f"key: [{KEY}]",
        f"model: m\nkey: '{KEY}\n",
        f"key: {KEY}: {KEY}",
        f"key: {KEY}\nframes: {{a: 1}}",
        f"keys: {KEY}",
        f'key: "{KEY}\\n"\nbase_url: http://127.0.0.1:1/v1',
        f'key: "{KEY}ü"\nbase_url: http://127.0.0.1:1/v1',
        f"base_url: http://{KEY}@host/v1",
        f"base_url: http://host/v1?key={KEY}",
    ],
)
def test_no_message_quotes_a_value(text: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        settings(tmp_path, text, PHYSAGENT_VLM_MODEL="m")
    assert KEY not in str(caught.value)
    assert caught.value.__suppress_context__


def test_a_dump_and_a_repr_hide_the_key(tmp_path: Path) -> None:
    found = settings(tmp_path, **LOCAL, PHYSAGENT_VLM_KEY=KEY)
    assert KEY not in repr(found)
    assert KEY not in found.model_dump_json()


def never() -> bool:
    return False


def test_only_the_named_roles_are_played_by_the_model(tmp_path: Path) -> None:
    environ = {**LOCAL, "PHYSAGENT_VLM_CONFIG": str(tmp_path / "none.yaml")}
    everyone = crew_from_environment(never, environ=environ)
    some = crew_from_environment(
        never,
        default=Crew(None, None, None),  # type: ignore[arg-type]
        environ=environ | {"PHYSAGENT_VLM_ROLES": "planner, verifier"},
    )
    assert isinstance(everyone.planner, VlmPlanner)
    assert some.generator is None
    assert isinstance(some.verifier, VlmVerifier)
    assert isinstance(some.planner, VlmPlanner)
    # All roles spend from one purse.
    assert some.verifier.line.ledger is some.planner.line.ledger


def test_limits_hold_over_all_crews_of_a_session(tmp_path: Path) -> None:
    spent = CallRecord(
        at="now", role="planner", purpose="p", model="m", host="h", key="k", attempt=1,
        outcome="ok", seconds=1, tokens_in=900, tokens_out=100, money=0.5,
    )  # fmt: skip
    environ = {**LOCAL, "PHYSAGENT_VLM_CONFIG": str(tmp_path / "none.yaml")}
    crew = crew_from_environment(
        never, earlier=[spent] * 3, environ=environ | {"PHYSAGENT_VLM_CALLS": "3"}
    )
    assert isinstance(crew.planner, VlmPlanner)
    with pytest.raises(BudgetSpent, match="3 calls"):
        crew.planner.line.ledger.check()


@pytest.mark.parametrize(
    ("roles", "message"),
    [("judge", r"there is no role judge \(generator, verifier, planner\)"),
     ("planner", "leaves out generator, verifier")],
)  # fmt: skip
def test_a_wrong_choice_of_roles_is_said(roles: str, message: str, tmp_path: Path) -> None:
    environ = {**LOCAL, "PHYSAGENT_VLM_CONFIG": str(tmp_path / "none.yaml")}
    with pytest.raises(InputError, match=message):
        crew_from_environment(never, environ=environ | {"PHYSAGENT_VLM_ROLES": roles})


def test_the_config_file_lies_in_the_users_config_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("platformdirs.user_config_dir", lambda *args, **options: str(tmp_path))
    (tmp_path / "vlm.yaml").write_text("base_url: http://127.0.0.1:9/v1\nmodel: from-file\n")
    assert load_settings({}).endpoints["planner"].model == "from-file"


def test_every_variable_is_documented(repository: Path) -> None:
    text = (repository / "docs" / "vlm.md").read_text(encoding="utf-8")
    for variable in config._VARIABLES:
        general = variable
        for role in ROLES:
            general = general.replace(f"_{role.upper()}_", "_ROLE_")
        assert f"`{general}`" in text


def test_a_model_is_not_asked_for_the_verdicts_of_a_person(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = {"PHYSAGENT_VLM_CONFIG": str(tmp_path / "none.yaml"), "PHYSAGENT_VLM_KEY": KEY}
    for name, value in (LOCAL | own).items():
        monkeypatch.setenv(name, value)
    case = Case("bare", None, "", (), (), (), "The ball moves.")
    session = Store(tmp_path).create(case, LoopState())
    engine = Engine(session, case, agent="vlm")
    assert isinstance(engine.crew().verifier, VlmVerifier)
    mine = engine.crew(("verifier",))
    assert isinstance(mine.verifier, RuleVerifier)
    assert isinstance(mine.planner, VlmPlanner)
    session.close()
