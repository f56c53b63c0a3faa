"""Which endpoint, model and limits each role uses: environment first, then the config file.

The key is read here and nowhere else. It is held as a `SecretStr`, so that neither `repr` nor a
dump shows it, and messages about a bad config file never quote its values.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal
from urllib.parse import urlsplit

import platformdirs
import yaml
from pydantic import Field, SecretStr, ValidationError, field_validator

from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.program.base import Frozen
from physagent_studio.records.loop_state import ROLES, RoleName

OPENAI = "https://api.openai.com/v1"
MOST_CONFIG_BYTES = 65_536

Seconds = Annotated[float, Field(gt=0, le=3600)]
Count = Annotated[int, Field(ge=1, le=10_000_000_000)]
Amount = Annotated[float, Field(ge=0, le=1e9)]


class Prices(Frozen):
    """Per million tokens, in whatever currency the limit `money` is meant in."""

    input: Amount
    output: Amount


class Limits(Frozen):
    """Hard stops over all roles of one session; money needs prices for every role."""

    calls: Count = 120
    tokens: Count = 2_000_000
    money: Amount | None = None


class Patience(Frozen):
    """How long to wait and how often to try again.

    timeout: s for one attempt, all of it, however slowly bytes arrive. retries: further
    attempts after a failure that may pass; one where the server took its time and gave nothing.
    backoff: s before the first retry, doubled each time. total: s after which none is begun.
    """

    timeout: Seconds = 180.0
    total: Seconds = 240.0
    retries: Annotated[int, Field(ge=0, le=10)] = 3
    backoff: Annotated[float, Field(ge=0, le=60)] = 1.0


class Endpoint(Frozen):
    """Where one role's calls go.

    temperature, max_output_tokens: None leaves them out of the request. picture_side: longest
    side in pixels of a picture that is sent.
    """

    base_url: str
    model: Annotated[str, Field(min_length=1, max_length=200)]
    key: SecretStr | None = None
    prices: Prices | None = None
    patience: Patience = Patience()
    temperature: Annotated[float, Field(ge=0, le=2)] | None = None
    max_output_tokens: Annotated[int, Field(ge=16, le=1_000_000)] | None = 8000
    picture_side: Annotated[int, Field(ge=128, le=4096)] = 1536

    @field_validator("base_url")
    @classmethod
    def _plain(cls, value: str) -> str:
        parts = urlsplit(value)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError("must be an http:// or https:// address")
        if parts.username or parts.password or parts.query or parts.fragment:
            raise ValueError("must not carry a user, a password or a query; the key has its own")
        return value.rstrip("/")

    @field_validator("key")
    @classmethod
    def _fits_a_header(cls, value: SecretStr | None) -> SecretStr | None:
        text = value.get_secret_value() if value else ""
        # Further down, a header that cannot be sent would be quoted in the error.
        if not all(33 <= ord(letter) <= 126 for letter in text):
            raise ValueError("must be plain letters, digits and signs, without blanks")
        return value

    @property
    def host(self) -> str:
        """Host and port, for messages and records."""
        return urlsplit(self.base_url).netloc

    @property
    def secret(self) -> str:
        """The key itself; only for the request and for redaction."""
        return self.key.get_secret_value() if self.key else ""


class TapeSettings(Frozen):
    """Where calls are recorded or replayed. replay never touches the network."""

    folder: Path
    mode: Literal["record", "replay"] = "record"


class Settings(Frozen):
    """Everything the VLM agent is told from outside."""

    endpoints: Mapping[RoleName, Endpoint]
    limits: Limits = Limits()
    frames: Literal["sheet", "images"] = "sheet"
    tape: TapeSettings | None = None
    log: Path | None = None


class _RoleFile(Frozen):
    """What a role may say for itself in the config file; all optional."""

    base_url: str | None = None
    model: str | None = None
    key: SecretStr | None = None
    key_env: str | None = None
    prices: Prices | None = None
    patience: Patience | None = None
    temperature: Annotated[float, Field(ge=0, le=2)] | None = None
    max_output_tokens: Annotated[int, Field(ge=16, le=1_000_000)] | None = None
    picture_side: Annotated[int, Field(ge=128, le=4096)] | None = None


class _ConfigFile(_RoleFile):
    limits: Limits = Limits()
    frames: Literal["sheet", "images"] = "sheet"
    tape: TapeSettings | None = None
    log: Path | None = None
    roles: dict[RoleName, _RoleFile] = Field(default_factory=dict)


def config_path(environ: Mapping[str, str]) -> Path:
    """`$PHYSAGENT_VLM_CONFIG`, else `vlm.yaml` in the user's config folder."""
    given = environ.get("PHYSAGENT_VLM_CONFIG")
    if given:
        return Path(given).expanduser()
    return Path(platformdirs.user_config_dir("physagent", appauthor=False)) / "vlm.yaml"


def load_settings(environ: Mapping[str, str]) -> Settings:
    """Settings from environment and config file, the environment going first.

    Raises:
        BackendMissing: no model or no server is configured.
        InputError: the config file or a variable cannot be read as what it should be.
    """
    path = config_path(environ)
    data = _read(path)
    where = str(path) if path.is_file() else "the environment"
    config = _validated(_ConfigFile, _with_environment(data, environ), where)
    replaying = config.tape is not None and config.tape.mode == "replay"
    endpoints: dict[RoleName, Endpoint] = {
        role: _endpoint(role, config, environ, replaying) for role in ROLES
    }
    unpriced = [role for role in ROLES if endpoints[role].prices is None]
    if config.limits.money is not None and unpriced:
        raise InputError(
            f"a limit in money needs prices for every role; {', '.join(unpriced)} has none "
            f"(prices: {{input: …, output: …}} per million tokens in {config_path(environ)})"
        )
    return Settings(
        endpoints=endpoints,
        limits=config.limits,
        frames=config.frames,
        tape=config.tape,
        log=config.log,
    )


def _read(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as stream:
            text = stream.read(MOST_CONFIG_BYTES + 1)
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    if len(text) > MOST_CONFIG_BYTES:
        raise InputError(f"{path} is larger than {MOST_CONFIG_BYTES} bytes")
    try:
        data = yaml.safe_load(text)
    except yaml.MarkedYAMLError as error:
        # The parser's own message quotes the line, which may hold the key.
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise InputError(f"{path}, line {line}: this is not valid YAML") from None
    except (yaml.YAMLError, UnicodeDecodeError):
        raise InputError(f"{path} is not valid YAML in UTF-8") from None
    if not isinstance(data, dict | None):
        raise InputError(f"{path} must be a list of `name: value` lines")
    return data or {}


_VARIABLES = {
    "PHYSAGENT_VLM_BASE_URL": ("base_url",),
    "PHYSAGENT_VLM_MODEL": ("model",),
    "PHYSAGENT_VLM_KEY": ("key",),
    "PHYSAGENT_VLM_CALLS": ("limits", "calls"),
    "PHYSAGENT_VLM_TOKENS": ("limits", "tokens"),
    "PHYSAGENT_VLM_MONEY": ("limits", "money"),
    "PHYSAGENT_VLM_TIMEOUT": ("patience", "timeout"),
    "PHYSAGENT_VLM_FRAMES": ("frames",),
    "PHYSAGENT_VLM_TAPE": ("tape", "folder"),
    "PHYSAGENT_VLM_TAPE_MODE": ("tape", "mode"),
    "PHYSAGENT_VLM_LOG": ("log",),
    **{f"PHYSAGENT_VLM_{role.upper()}_MODEL": ("roles", role, "model") for role in ROLES},
    **{f"PHYSAGENT_VLM_{role.upper()}_BASE_URL": ("roles", role, "base_url") for role in ROLES},
    **{f"PHYSAGENT_VLM_{role.upper()}_KEY": ("roles", role, "key") for role in ROLES},
}


def _with_environment(data: dict[str, Any], environ: Mapping[str, str]) -> dict[str, Any]:
    merged = _copied(data)
    for variable, path in _VARIABLES.items():
        value = environ.get(variable, "").strip()
        if not value:
            continue
        node = merged
        for part in path[:-1]:
            inner = node.get(part)
            node[part] = inner if isinstance(inner, dict) else {}
            node = node[part]
        node[path[-1]] = value
        if path[-1] == "key":
            # The environment goes first, also before a variable that the file names.
            node.pop("key_env", None)
    return merged


def _copied(data: Any) -> Any:
    return {key: _copied(value) for key, value in data.items()} if isinstance(data, dict) else data


def _validated(model: type[_ConfigFile], data: dict[str, Any], where: str) -> _ConfigFile:
    try:
        return model.model_validate(data)
    except ValidationError as error:
        # Only places and messages: the values could be a key.
        rows = [
            f"{'.'.join(str(part) for part in item['loc'])}: {_plain(item)}"
            for item in error.errors(include_url=False, include_input=False)
        ]
        raise InputError(f"the VLM settings in {where}: {'; '.join(rows)}") from None


def _plain(item: Any) -> str:
    if item["type"] == "extra_forbidden":
        return "is not a known setting"
    return str(item["msg"]).removeprefix("Value error, ")


def _endpoint(
    role: RoleName, config: _ConfigFile, environ: Mapping[str, str], replaying: bool
) -> Endpoint:
    own = config.roles.get(role, _RoleFile())
    model = own.model or config.model
    base_url = own.base_url or config.base_url
    key = _key(own, config, base_url, environ)
    if base_url is None and (key is not None or replaying):
        base_url = OPENAI
    if not model or base_url is None:
        raise BackendMissing(_how_to(role, "model" if base_url else "server", environ))
    shared = ("prices", "patience", "temperature", "max_output_tokens", "picture_side")
    fields: dict[str, Any] = {"base_url": base_url, "model": model, "key": key}
    for name in shared:
        value = getattr(own, name)
        value = getattr(config, name) if value is None else value
        if value is not None:
            fields[name] = value
    try:
        return Endpoint(**fields)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise InputError(f"the VLM settings of the {role}: {where} {_plain(first)}") from None


def _how_to(role: str, what: str, environ: Mapping[str, str]) -> str:
    return (
        f"no {what} is configured for the {role}: set PHYSAGENT_VLM_BASE_URL, PHYSAGENT_VLM_MODEL "
        f"and, where the server wants one, PHYSAGENT_VLM_KEY, or write them to "
        f"{config_path(environ)}"
    )


def _key(
    own: _RoleFile, config: _ConfigFile, base_url: str | None, environ: Mapping[str, str]
) -> SecretStr | None:
    """The role's key, else the common one, else OpenAI's own variable for OpenAI's own server."""
    for part in (own, config):
        if part is config and own.base_url and _netloc(own.base_url) != _netloc(config.base_url):
            # A key is never sent to a server that it was not given for.
            break
        if part.key is not None:
            return part.key
        if part.key_env and environ.get(part.key_env):
            return SecretStr(environ[part.key_env])
    trusted = {_netloc(OPENAI), _netloc(environ.get("OPENAI_BASE_URL"))} - {""}
    if base_url is None or _netloc(base_url) in trusted:
        found = environ.get("OPENAI_API_KEY", "").strip()
        return SecretStr(found) if found else None
    return None


def _netloc(url: str | None) -> str:
    return urlsplit(url or "").netloc.lower()
