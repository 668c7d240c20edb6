"""Colours of the scene: warm greys that hold on a light and on a dark floor, and one accent.

The accent means the template and nothing else.

Only floor, light and page differ between the themes. What stands in the scene keeps its colours, so that one
scene can be watched by a colleague in a bright room and by one in a dark room at the same time.
"""

from dataclasses import dataclass
from typing import Final, Literal

Rgb = tuple[int, int, int]
Theme = Literal["light", "dark"]

MATERIAL_COLOURS: Final[dict[str, Rgb]] = {
    "skin": (224, 178, 148),
    "hair": (104, 90, 82),
    "shirt": (206, 203, 199),
    "trousers": (120, 122, 130),
    "shoe": (92, 90, 94),
    "band": (48, 46, 48),
}
UNMEASURED_SKIN: Final[Rgb] = (204, 191, 181)
"""Skin of segments that carry no sensor: paler, so that the eye goes to what was measured."""
LOST: Final[Rgb] = (150, 150, 150)
"""A segment whose sensor gives nothing at the moment; drawn translucent as well."""
ACCENT: Final[Rgb] = (30, 168, 182)
"""The template: its ghost and its path, nothing else."""
TRAIL: Final[Rgb] = (176, 112, 74)
"""Where the patient's hand has just been."""
FRAME: Final[Rgb] = (91, 78, 163)
"""A marker as cameras saw it."""
FILLED: Final[Rgb] = (160, 44, 109)
"""A gap of the cameras that a sensor filled."""
HALO: Final[Rgb] = (238, 178, 110)
"""Two standard deviations of where elbow and hand may be."""


@dataclass(frozen=True)
class Palette:
    """One theme.

    Attributes
    ----------
    background_top, background_bottom : str
        CSS colours of the page behind the transparent canvas.
    floor_line, floor_section, floor_text : Rgb
        Grid every 0.5 m and every 1 m, and its numbers.
    floor_shadow : float
        Darkness of the shadow on the floor, 0 to 1.
    sky, ground, key : Rgb
        Light from above, from below, and the lamp that casts the shadow.
    sky_intensity, key_intensity, fill_intensity : float
        Strengths; the fill is a weak lamp opposite the key.
    """

    background_top: str
    background_bottom: str
    floor_line: Rgb
    floor_section: Rgb
    floor_text: Rgb
    floor_shadow: float
    sky: Rgb
    ground: Rgb
    key: Rgb
    sky_intensity: float
    key_intensity: float
    fill_intensity: float


PALETTES: Final[dict[Theme, Palette]] = {
    "light": Palette(
        background_top="#fafafa",
        background_bottom="#e5e6e6",
        floor_line=(214, 209, 202),
        floor_section=(180, 176, 170),
        floor_text=(120, 116, 110),
        floor_shadow=0.20,
        sky=(255, 253, 250),
        ground=(176, 164, 154),
        key=(255, 246, 236),
        sky_intensity=1.55,
        key_intensity=2.3,
        fill_intensity=0.55,
    ),
    "dark": Palette(
        background_top="#272d31",
        background_bottom="#101416",
        floor_line=(64, 65, 69),
        floor_section=(98, 102, 108),
        floor_text=(150, 156, 162),
        floor_shadow=0.50,
        sky=(226, 232, 244),
        ground=(96, 94, 96),
        key=(255, 244, 230),
        sky_intensity=1.45,
        key_intensity=2.3,
        fill_intensity=1.0,
    ),
}
