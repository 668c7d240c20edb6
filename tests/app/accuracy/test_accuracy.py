"""The accuracy page gets what the command measured, and the command tells when a protocol falls short."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import validation
from app.accuracy import AccuracyReport, stored_report
from app.accuracy.report import fresh_seed
from app.cli import cli
from validation import Figure, Protocol

SHORT = {
    "broad_conditions",
    "broad_offline",
    "foot_rates_and_links",
    "guidance_cues",
    "guidance_phase",
    "magnetic_fusion_checks",
    "orientation_covariance",
    "orientation_cuts",
    "orientation_honesty",
    "orientation_worlds",
    "repetitions",
}
"""What falls short today; the page shows it. Nothing else may."""


def test_the_stored_report_holds_what_it_must():
    report = stored_report()
    assert {entry.name for entry in report.protocols if entry.verdict == "short"} <= SHORT
    assert {(entry.seeds, entry.first_seed) for entry in report.protocols} == {(50, fresh_seed())}
    assert (report.seeds, report.first_seed) == (50, fresh_seed())
    assert report.data, "made without the recordings"
    assert any(protocol.plots for protocol in report.protocols)


@pytest.mark.slow
def test_the_stored_report_is_of_this_tree():
    measured = {
        entry.name: [(f.name, f.required) for f in entry.figures] for entry in stored_report().protocols
    }
    wanted = {entry.name: [(f.name, f.required) for f in entry.figures] for entry in validation.protocols()}
    assert measured == wanted, (
        "run `telemotion validate NAME --seeds 50 --data FOLDER --into app/accuracy/report.json`"
    )


def test_everybody_who_is_signed_in_sees_it(sign_in, nobody):
    assert nobody.get("/api/accuracy").status_code == 401
    answer = sign_in("therapist").get("/api/accuracy")
    assert answer.status_code == 200
    assert AccuracyReport.model_validate(answer.json()) == stored_report()


def made_up(required: float) -> Protocol:
    return Protocol(
        "made_up",
        "Made up",
        "nowhere",
        "Nothing.",
        (Figure("x", "m", required),),
        lambda seeds, data: {"x": np.ones(len(seeds))},
    )


@pytest.mark.parametrize(("required", "code"), [(2.0, 0), (0.5, 1)])
def test_the_command_fails_when_a_protocol_does(monkeypatch, tmp_path, required, code):
    monkeypatch.setattr(validation, "_PROTOCOLS", (made_up(required),))
    told = CliRunner().invoke(cli, ["validate"])
    assert told.exit_code == code
    assert ("SHORT" in told.output) == bool(code)
    out = tmp_path / "report.json"
    told = CliRunner().invoke(
        cli, ["validate", "--json", "--seeds", "3", "--first-seed", "40", "--out", str(out)]
    )
    assert told.exit_code == code
    report = AccuracyReport.model_validate_json(told.stdout)
    assert report.protocols[0].verdict == ("short" if code else "pass")
    assert (report.seeds, report.first_seed) == (3, 40)
    assert report.protocols[0].figures[0].values == [1.0, 1.0, 1.0]
    assert report.command == "telemotion validate --seeds 3 --first-seed 40"
    assert AccuracyReport.model_validate(json.loads(out.read_text())) == report


def test_what_is_measured_anew_takes_its_place_in_a_report(monkeypatch, tmp_path):
    first, second = (replace(made_up(2.0), name=name) for name in ("first", "second"))
    monkeypatch.setattr(validation, "_PROTOCOLS", (first, second))
    report, page = tmp_path / "report.json", tmp_path / "page.md"
    run = CliRunner().invoke
    assert run(cli, ["validate", "--seeds", "3", "--first-seed", "7", "--out", str(report)]).exit_code == 0
    said = [
        "validate",
        "second",
        "--seeds",
        "5",
        "--first-seed",
        "40",
        "--into",
        str(report),
        "--page",
        str(page),
    ]
    assert run(cli, said).exit_code == 0
    both = AccuracyReport.model_validate_json(report.read_text())
    assert [(entry.name, entry.first_seed, entry.seeds) for entry in both.protocols] == [
        ("first", 7, 3),
        ("second", 40, 5),
    ]
    # The command is that of the whole page; what was measured otherwise is named on it.
    assert both.command == "telemotion validate --seeds 3 --first-seed 7"
    assert "With 5 seeds from 40 on: second." in page.read_text()
    # An experiment whose limit has changed since is not as measured.
    monkeypatch.setattr(validation, "_PROTOCOLS", (replace(made_up(3.0), name="first"), second))
    assert run(cli, said).exit_code == 0
    assert [entry.name for entry in AccuracyReport.model_validate_json(report.read_text()).protocols] == [
        "second"
    ]
    assert run(cli, [*said, "--out", str(report)]).exit_code != 0


def test_by_default_twenty_seeds_that_the_version_draws(monkeypatch):
    seen = []
    protocol = replace(
        made_up(2.0), measure=lambda seeds, data: seen.extend(seeds) or {"x": np.ones(len(seeds))}
    )
    monkeypatch.setattr(validation, "_PROTOCOLS", (protocol,))
    told = CliRunner().invoke(cli, ["validate", "--json"])
    report = AccuracyReport.model_validate_json(told.stdout)
    assert (report.seeds, report.first_seed) == (20, fresh_seed())
    assert seen == list(range(fresh_seed(), fresh_seed() + 20))


def test_more_processes_measure_the_same(tmp_path):
    # Noise of single seeds: a lost or doubled batch would show.
    said = ["validate", "arm_bias_states", "--seeds", "23", "--json", "--processes"]
    one, two = (json.loads(CliRunner().invoke(cli, [*said, count]).stdout) for count in ("1", "2"))
    assert [f["values"] for f in one["protocols"][0]["figures"]] == [
        f["values"] for f in two["protocols"][0]["figures"]
    ]
