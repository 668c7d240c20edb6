"""The seat of a seated figure: a plain stool, as high as the person's knees want it."""

from typing import Any, Final

import viser

from app.viewer.figure.proportions import REFERENCE_STATURE_M, hip_height_m
from estimators.body import BodyDimensions

_WOOD: Final = (186, 168, 146)
_THIGH_M: Final = 0.080
"""From the middle of the thigh to the seat, at the reference stature."""
_DEEP_M, _WIDE_M, _BOARD_M, _LEG_M = 0.36, 0.40, 0.035, 0.032
_FORWARD_M: Final = 0.05
_INSET_M: Final = 0.03


def seat_height_m(body: BodyDimensions) -> float:
    """Return the height of the seat above the floor."""
    return hip_height_m(body, "seated") - _THIGH_M * body.stature_m / REFERENCE_STATURE_M


def add_seat(server: viser.ViserServer, body: BodyDimensions) -> Any:
    """Add a stool under the hips of who sits; returns the frame by which it is shown and hidden."""
    size, top = body.stature_m / REFERENCE_STATURE_M, seat_height_m(body)
    seat = server.scene.add_frame("/seat", show_axes=False, position=(_FORWARD_M * size, 0.0, 0.0))
    board, leg = _BOARD_M * size, _LEG_M * size
    boxes = [((0.0, 0.0, top - 0.5 * board), (_DEEP_M * size, _WIDE_M * size, board))]
    long = top - board
    for x in (-1.0, 1.0):
        for y in (-1.0, 1.0):
            corner = (
                x * (0.5 * _DEEP_M - _INSET_M) * size,
                y * (0.5 * _WIDE_M - _INSET_M) * size,
                0.5 * long,
            )
            boxes.append((corner, (leg, leg, long)))
    for number, (position, dimensions) in enumerate(boxes):
        server.scene.add_box(f"/seat/{number}", color=_WOOD, dimensions=dimensions, position=position)
    return seat
