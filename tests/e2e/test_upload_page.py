"""What the upload page takes a table for: seen as curves and sentences before anything is sent, and changed there."""

import re

import numpy as np
import pytest
from playwright.sync_api import expect

from app.demo.people import THERAPIST
from tests.e2e.conftest import House, Visitor
from tests.e2e.test_pages import overflow, serious, settle

RATE_HZ, SECONDS = 50.0, 20.0


def swinging() -> bytes:
    """A sensor that rests and then swings about its first axis, with counted rows and a clock in milliseconds."""
    time_s = np.arange(round(SECONDS * RATE_HZ)) / RATE_HZ
    swings = np.where(time_s > 4.0, 1.0 - np.cos(1.5 * (time_s - 4.0)), 0.0)
    rate = np.gradient(0.5 * swings, time_s)
    angle = 0.5 * swings
    zero = np.zeros_like(time_s)
    force = 9.81 * np.column_stack((zero, np.sin(angle), np.cos(angle)))
    columns = np.column_stack((1000.0 * time_s, np.degrees(rate), zero, zero, force))
    noise = np.random.default_rng(7).normal(0.0, (0.0, 0.05, 0.05, 0.05, 0.02, 0.02, 0.02), columns.shape)
    names = "t_ms,gyr_x (deg/s),gyr_y (deg/s),gyr_z (deg/s),acc_x (m/s2),acc_y (m/s2),acc_z (m/s2)"
    rows = "\n".join(",".join(f"{one:.5f}" for one in row) for row in columns + noise)
    return f"{names}\n{rows}\n".encode()


@pytest.mark.parametrize("visitor", [(THERAPIST, 1440), (THERAPIST, 390)], indirect=True)
def test_a_table_is_seen_before_it_is_sent(visitor: Visitor, house: House) -> None:
    page = visitor.page
    page.goto(house.address + "/upload")
    settle(visitor)
    table = {"name": "swing.csv", "mimeType": "text/csv", "buffer": swinging()}
    page.locator("input[type=file]").set_input_files(files=[table])  # type: ignore[list-item]
    look = page.get_by_role("region", name="What the file is taken for")
    expect(look).to_contain_text("50 samples a second")
    expect(look).to_contain_text("gyroscope in \u00b0/s")
    expect(look.get_by_role("heading", name="What is assumed")).to_be_visible()
    curves = look.get_by_role("img")
    expect(curves).to_have_count(2)
    drawn = curves.first.bounding_box()
    assert drawn is not None
    assert drawn["width"] > 200.0
    assert drawn["height"] > 60.0
    visitor.picture(f"upload-look-{page.viewport_size['width']}")  # type: ignore[index]
    assert serious(visitor) == []
    assert overflow(visitor) <= 0
    page.get_by_text("Change what was guessed").click()
    page.get_by_label(re.compile(": unit$")).first.click()
    page.get_by_role("option", name="rad/s").first.click()
    expect(look).to_contain_text("gyroscope in rad/s")
    assert visitor.faults_outside_the_view() == []
