"""A demonstration's people are made once; its companions make what of the past is missing."""

from pathlib import Path

from app.commands.demo import companions
from app.database.engine import create_from_url
from app.database.unit_of_work import read_only
from app.demo.people import PATIENTS, prepare
from app.patients.models import Patient


def test_people_are_made_once_and_the_past_goes_on_where_it_was(tmp_path: Path) -> None:
    url, folder = f"sqlite:///{tmp_path / 'clinic.db'}", tmp_path / "data"
    first = prepare(url, folder)
    assert not first.is_complete
    assert first.path.parent == folder, "where the service looks for it"
    first.add("one step")
    again = prepare(url, folder)
    assert again.done == {"one step": ""}
    engine = create_from_url(url)
    with read_only(engine) as session:
        assert session.query(Patient).count() == len(PATIENTS)
    engine.dispose()


def test_the_past_is_made_until_it_is_complete(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'clinic.db'}"
    progress = prepare(url, tmp_path)
    live, past = companions("http://127.0.0.1:1", 0.0, progress, url)
    assert "--stream" in live
    assert "--history" not in live
    assert past[past.index("--history") + 1] == str(tmp_path)
    assert companions("http://127.0.0.1:1", 0.0, progress, url, stream=False) == [past]
    progress.total = 0
    assert companions("http://127.0.0.1:1", 0.0, progress, url) == [live]


def test_a_clinic_of_an_earlier_version_is_left_as_it_is(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'clinic.db'}"
    prepare(url, tmp_path).path.unlink()
    assert prepare(url, tmp_path).is_complete
