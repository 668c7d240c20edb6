"""A zip that is larger than what the service is shown is looked into before it is sent, in a real browser."""

from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
from playwright.sync_api import expect

from tests.app.readers.odd_tables import FORCE, GYROSCOPE
from tests.e2e.conftest import Visitor
from tests.e2e.test_pages import settle


def test_the_tables_of_a_large_zip_are_shown_before_it_is_sent(visitor: Visitor, tmp_path: Path) -> None:
    path = tmp_path / "walk.zip"
    time_s = np.arange(20 * len(GYROSCOPE)) / 100.0
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for name, values in (("Accelerometer", FORCE), ("Gyroscope", GYROSCOPE)):
            rows = np.column_stack([time_s, np.tile(values, (20, 1))])
            lines = [",".join(f"{one:.9g}" for one in row) for row in rows.tolist()]
            archive.writestr(f"walk/{name}.csv", "\n".join(["Time (s),x,y,z", *lines]))
    assert path.stat().st_size > 256 * 1024
    visitor.page.goto(f"{visitor.address}/upload")
    settle(visitor)
    visitor.page.locator('input[type="file"]').first.set_input_files(path)
    for words in ("100 samples a second", "each count from their own first row"):
        expect(visitor.page.get_by_text(words).first).to_be_visible()
    visitor.picture("large-zip")
    assert visitor.faults_outside_the_view() == []
