"""Tables as devices, spreadsheets and small programs write them, made from one real recording; and ones to refuse.

Each is one file and what is to be read of it. Nothing in them was made to fit the reader: an oddity that somebody
has seen is one more line here.
"""

import functools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np

SOURCE = np.load(Path(__file__).parents[2] / "data" / "broad" / "fast_combined_15s.npz")
RATE_HZ = 100.0
"""As it is written: the stamps of the excerpt, 285.7 Hz, would not fit in whole milliseconds."""
ROWS = 1500
GYROSCOPE, FORCE, FIELD_UT = (
    SOURCE[name][:ROWS] * factor
    for name, factor in (
        # Slowed down to the rate written.
        ("gyroscope_radps", RATE_HZ / float(SOURCE["sampling_rate_hz"])),
        ("accelerometer_mps2", 1.0),
        ("magnetometer_ut", 1.0),
    )
)
TIME_S = np.arange(ROWS) / RATE_HZ
G = 9.80665
NINE = [f"{quantity}_{axis}" for quantity in ("gyr", "acc", "mag") for axis in "xyz"]


@dataclass
class Odd:
    """One table and what it holds.

    Attributes
    ----------
    content : bytes
    sensors : dict of str to slice or ndarray
        By name of the sensor: rows of the source that are to be read.
    pipeline : str
    name : str
        Of the file.
    options : tuple of str
        What a person must add on the command line.
    notes : set of str
        Codes of what must be said.
    has_field : bool
    time_s : ndarray or None
        What the stamps are to be; None: those of the source, from the first row.
    within_s : float
        How near they must be.
    """

    content: bytes
    sensors: dict[str, object] = field(default_factory=lambda: {"imu": slice(None)})
    pipeline: str = "orientation"
    name: str = "table.csv"
    options: tuple[str, ...] = ()
    notes: frozenset[str] = frozenset()
    has_field: bool = True
    time_s: np.ndarray | None = None
    within_s: float = 2e-6


def numbers(values: np.ndarray, digits: int = 7) -> list[list[str]]:
    return _numbers(values.shape, values.astype(float).tobytes(), digits)


@functools.cache
def _numbers(shape: tuple[int, ...], values: bytes, digits: int) -> list[list[str]]:
    rows = np.frombuffer(values).reshape(shape).tolist()
    return [[f"{value:.{digits}g}" for value in row] for row in rows]


def text(
    header: Iterable[str],
    rows: list[list[str]],
    delimiter: str = ",",
    decimal: str = ".",
    quote: str = "",
    end: str = "\n",
) -> str:
    if decimal != ".":
        rows = [[one.replace(".", decimal) for one in row] for row in rows]
    lines = (quote + f"{quote}{delimiter}{quote}".join(row) + quote for row in rows)
    return end.join([*header, *lines]) + end


def rows_of(
    *parts: np.ndarray, time_s: np.ndarray | None = TIME_S, rows: object = slice(None), digits: int = 7
) -> list[list[str]]:
    table = numbers(np.column_stack(parts)[rows], digits)
    if time_s is None:
        return table
    return [[f"{stamp:.14g}", *row] for stamp, row in zip(time_s.tolist(), table, strict=True)]


ALL = (GYROSCOPE, FORCE, FIELD_UT)
PLAIN = ",".join(["time", *NINE])


@functools.cache
def odd_tables() -> dict[str, Odd]:
    return {**_headings(), **_texts(), **_times(), **_clocks(), **_units()}


def _headings() -> dict[str, Odd]:
    rows = rows_of(*ALL)
    twice = np.column_stack([GYROSCOPE, FORCE, GYROSCOPE[::-1], FORCE[::-1]])
    groups = ["time", *["Left wrist"] * 6, *["Right wrist"] * 6]
    axes = [f"{q}{a}" for q in ("Gyr", "Acc") for a in "XYZ"] * 2
    two = {"forearm_left": slice(None), "forearm_right": slice(None, None, -1)}
    units = ["s", *["deg/s"] * 3, *["g"] * 3]
    degrees = rows_of(np.degrees(GYROSCOPE), FORCE / G)
    shimmer = ["Timestamp_Unix", *(f"{q}_{a}" for q in ("Gyro", "Accel_LN", "Mag") for a in "XYZ")]
    return {
        "blanks in names": Odd(
            text(
                [" Time (s) ,  Gyro  X ,Gyro  Y,Gyro  Z,Acc X , Acc Y,Acc Z,Mag X,Mag Y,Mag Z "], rows
            ).encode()
        ),
        "repeated names": Odd(
            text([",".join(["t", *NINE[:6], *NINE[:6]])], rows_of(twice)).encode(),
            {"imu": slice(None), "2": slice(None, None, -1)},
            has_field=False,
        ),
        "two header lines": Odd(
            text([",".join(groups), ",".join(["", *axes])], rows_of(twice)).encode(),
            two,
            "arm",
            has_field=False,
        ),
        "a group named once": Odd(
            text([",Left wrist,,,,,,Right wrist,,,,,", ",".join(["time", *axes])], rows_of(twice)).encode(),
            two,
            "arm",
            has_field=False,
        ),
        "three header lines with units": Odd(
            text([",".join(groups[:7]), ",".join(["time", *axes[:6]]), ",".join(units)], degrees).encode(),
            {"forearm_left": slice(None)},
            "arm",
            has_field=False,
        ),
        "units in brackets": Odd(
            text(["Time [s],wx (deg/s),wy (deg/s),wz (deg/s),ax {g},ay {g},az {g}"], degrees).encode(),
            has_field=False,
        ),
        "lines of the maker above, one below": Odd(
            text(
                [
                    "\t".join(f"Shimmer_B663_{n}_CAL" for n in shimmer),
                    "\t".join(["CAL"] * 10),
                    "\t".join(["ms", *["deg/s"] * 3, *["m/(s^2)"] * 3, *["local_flux*"] * 3]),
                ],
                rows_of(np.degrees(GYROSCOPE), FORCE, FIELD_UT, time_s=1.7e12 + 1000.0 * TIME_S, digits=9),
                "\t",
            )
            .encode()
            .replace(b"e+12", b"e+12"),
            {"shimmer_b_663": slice(None)},
            name="shimmer.txt",
        ),
        "preamble with the rate": Odd(
            text(
                [
                    "Device: Sensor 7,,,,,,,,",
                    "Comment: slow, then fast,,,,,,,",
                    "Sampling rate (Hz): 100,,,,,,,,",
                    "",
                    ",".join(NINE),
                ],
                rows_of(*ALL, time_s=None),
            ).encode()
        ),
        "comments, and the header in one": Odd(
            text(
                ["# sensor 7", "# fs = 100 Hz", "# " + " ".join(NINE)], rows_of(*ALL, time_s=None), " "
            ).encode(),
            name="table.txt",
        ),
        "a title as a spreadsheet writes it": Odd(text(["Second session,,,,,,,,,", PLAIN], rows).encode()),
        "numbered rows": Odd(text([PLAIN], [[str(k + 1), *row] for k, row in enumerate(rows)]).encode()),
        "letters": Odd(text(["t,ax,ay,az,gx,gy,gz,mx,my,mz"], rows_of(FORCE, GYROSCOPE, FIELD_UT)).encode()),
        "german": Odd(
            text(
                [
                    "Zeit (s);"
                    + ";".join(
                        f"{q} {a}"
                        for q in ("Winkelgeschwindigkeit", "Beschleunigung", "Magnetfeld")
                        for a in "XYZ"
                    )
                ],
                rows,
                ";",
                ",",
            ).encode()
        ),
        "other columns of text": Odd(
            text(
                ["label," + PLAIN + ",state"],
                [["walk", *row, "ok" if k % 2 else ""] for k, row in enumerate(rows)],
            ).encode()
        ),
        "a foot by the name of the file": Odd(
            text([",".join(["time", *NINE[:6]])], rows_of(GYROSCOPE, FORCE)).encode(),
            {"foot_left": slice(None)},
            "gait",
            "walk_left.csv",
            ("--pipeline", "gait"),
            has_field=False,
        ),
        "feet by the names of columns": Odd(
            text(
                ["time," + ",".join(f"{s}Foot_{q}{a}" for s in "LR" for q in ("Gyr", "Acc") for a in "XYZ")],
                rows_of(twice),
            ).encode(),
            {"foot_left": slice(None), "foot_right": slice(None, None, -1)},
            "gait",
            has_field=False,
        ),
    }


def _texts() -> dict[str, Odd]:
    rows = rows_of(*ALL)
    degrees = rows_of(np.degrees(GYROSCOPE), FORCE, FIELD_UT)
    signs = ["Zeit,wx [°/s],wy [°/s],wz [°/s],ax [m/s²],ay [m/s²],az [m/s²],mx [µT],my [µT],mz [µT]"]
    quoted = '"time",' + ",".join(f'"{name}"' for name in NINE)
    return {
        "byte order mark": Odd(text([PLAIN], rows).encode("utf-8-sig")),
        "utf-16": Odd(text([PLAIN], rows).encode("utf-16")),
        "utf-16 without a mark": Odd(text([PLAIN], rows).encode("utf-16-le")),
        "latin-1": Odd(text(signs, degrees).encode("latin-1")),
        "signs in utf-8": Odd(text(signs, degrees).encode()),
        "semicolons and decimal commas": Odd(text([PLAIN.replace(",", ";")], rows, ";", ",").encode()),
        "tabs and decimal commas": Odd(text([PLAIN.replace(",", "\t")], rows, "\t", ",").encode()),
        "quoted decimal commas": Odd(text([quoted], rows, ",", ",", '"').encode()),
        "bars": Odd(text([PLAIN.replace(",", "|")], rows, "|").encode()),
        "separator named by a spreadsheet": Odd(text(["sep=;", PLAIN.replace(",", ";")], rows, ";").encode()),
        "columns under each other by blanks": Odd(
            text(["   ".join(["time", *NINE])], [[f"{one:>14}" for one in row] for row in rows], " ").encode()
        ),
        "carriage returns": Odd(text([PLAIN], rows, end="\r").encode()),
        "windows": Odd(text([PLAIN], rows, end="\r\n").encode() + b"\x1a"),
        "a delimiter too many": Odd(text([PLAIN], [[*row, ""] for row in rows]).encode()),
        "cut in its last line": Odd(
            text([PLAIN], rows)[:-50].encode(),
            {"imu": slice(0, ROWS - 1)},
            notes=frozenset({"table.rows_left_out"}),
        ),
        "nothing where a sample is missing": Odd(
            text(
                [PLAIN],
                [
                    [row[0], *["-" if k in (700, 701) else one for one in row[1:]]]
                    for k, row in enumerate(rows)
                ],
            ).encode(),
            {"imu": np.r_[0:700, 702:ROWS]},
        ),
    }


def _times() -> dict[str, Odd]:
    rows = rows_of(*ALL)
    some = list(range(200, 1400, 400))

    def stamped(stamps: np.ndarray, **more: object) -> Odd:
        return Odd(text([PLAIN], rows_of(*ALL, time_s=stamps, digits=9)).encode(), **more)  # type: ignore[arg-type]

    repeated, late = TIME_S.copy(), TIME_S.copy()
    repeated[some] = repeated[[k - 1 for k in some]]
    late[some] = late[[k - 5 for k in some]]
    spike = TIME_S.copy()
    spike[700] = 1e6
    again = np.concatenate([TIME_S[:800], TIME_S[:700]])
    empty = [["" if k in some else row[0], *row[1:]] for k, row in enumerate(rows)]
    after = np.concatenate([TIME_S[:800], TIME_S[799] + 1.0 + TIME_S[:700]])
    sound = np.setdiff1d(np.arange(ROWS), some)
    out_of_order = frozenset({"time.out_of_order"})
    return {
        "stamps that repeat": stamped(repeated, notes=frozenset({"time.repeated"}), time_s=TIME_S),
        "rows written twice": Odd(
            text([PLAIN], [row for k, row in enumerate(rows) for _ in range(1 + (k in some))]).encode(),
            notes=frozenset({"time.row_twice"}),
        ),
        "stamps coarser than the rate": stamped(
            np.floor(TIME_S * 20.0 + 1e-9) / 20.0, notes=frozenset({"time.repeated"})
        ),
        "rows that came late": stamped(late, sensors={"imu": sound}, notes=out_of_order),
        "one stamp far away": stamped(
            spike, sensors={"imu": np.setdiff1d(np.arange(ROWS), [700])}, notes=out_of_order
        ),
        "a clock that starts again": stamped(again, notes=frozenset({"time.set_back"}), time_s=after),
        "a counter that runs over": Odd(
            text(
                [PLAIN.replace("time", "time_ms")],
                rows_of(*ALL, time_s=np.mod(60_000.0 + 1000.0 * TIME_S, 65536.0), digits=9),
            ).encode()
        ),
        "rows without time": Odd(
            text([PLAIN], empty).encode(), {"imu": sound}, notes=frozenset({"time.missing"})
        ),
        "microseconds that nobody names": stamped(np.round(1e6 * TIME_S)),
        "nanoseconds since an epoch": Odd(
            text(
                [PLAIN.replace("time", "timestamp")],
                [[str(1_700_000_000_000_000_000 + k * 10_000_000), *row[1:]] for k, row in enumerate(rows)],
            ).encode()
        ),
        "no time": Odd(
            text([",".join(NINE)], rows_of(*ALL, time_s=None)).encode(), options=("--rate", "100")
        ),
        "time without a name": Odd(text(["," + ",".join(NINE)], rows).encode()),
    }


def _clocks() -> dict[str, Odd]:
    """Times of day as text; whole numbers of milliseconds."""

    def written(start: str, pattern: str, changes: Callable[[datetime], datetime] | None = None) -> list[str]:
        moments = [datetime.fromisoformat(start) + timedelta(milliseconds=10 * k) for k in range(ROWS)]
        moments = moments if changes is None else [changes(moment) for moment in moments]
        return [
            moment.strftime(pattern).replace("<ms>", f"{moment.microsecond // 1000:03d}")
            for moment in moments
        ]

    def clocks(stamps: list[str], notes: str = "", heading: str = "time", delimiter: str = ",") -> Odd:
        rows = [[stamp, *row] for stamp, row in zip(stamps, rows_of(*ALL, time_s=None), strict=True)]
        names = PLAIN.replace("time", heading).replace(",", delimiter)
        return Odd(text([names], rows, delimiter).encode(), notes=frozenset({notes} - {""}))

    # Central Europe: summer time begins on 29 March and ends on 25 October 2026, at 01:00 UTC.
    def local(moment: datetime, zone: bool) -> datetime:
        begins, ends = datetime.fromisoformat("2026-03-29T01:00"), datetime.fromisoformat("2026-10-25T01:00")
        ahead = timedelta(hours=2 if begins <= moment < ends else 1)
        return (moment + ahead).replace(tzinfo=timezone(ahead) if zone else None)

    iso, spring, autumn = "%Y-%m-%dT%H:%M:%S.<ms>", "2026-03-29T00:59:53", "2026-10-25T00:59:53"
    return {
        "moments in UTC": clocks(written("2026-11-22T10:00:00", iso + "Z")),
        "moments without a zone": clocks(written("2026-11-22T10:00:00", iso), heading="Timestamp"),
        "date and time": clocks(written("2026-11-22T10:00:00", "%Y-%m-%d %H:%M:%S.<ms>"), heading="DateTime"),
        "german date": clocks(
            written("2026-11-22T10:00:00", "%d.%m.%Y %H:%M:%S.<ms>"), heading="Zeit", delimiter=";"
        ),
        "times of day": clocks(written("2026-11-22T10:00:00", "%H:%M:%S.<ms>"), heading="Clock"),
        "twelve hours": clocks(written("2026-11-22T11:59:53", "%I:%M:%S.<ms> %p")),
        "times of day past midnight": clocks(
            written("2026-11-22T23:59:53", "%H:%M:%S.<ms>"), "time.midnight"
        ),
        "moments past midnight": clocks(written("2026-12-31T23:59:53", iso)),
        "summer time begins": clocks(written(spring, iso, lambda m: local(m, False)), "time.clock_changed"),
        "summer time ends": clocks(written(autumn, iso, lambda m: local(m, False)), "time.clock_changed"),
        "summer time begins, with zones": clocks(written(spring, iso + "%z", lambda m: local(m, True))),
        "summer time ends, with zones": clocks(written(autumn, iso + "%z", lambda m: local(m, True))),
        "clock of whole seconds": clocks(
            written("2026-11-22T10:00:00", "%Y-%m-%d %H:%M:%S"), "time.repeated"
        ),
    }


def _units() -> dict[str, Odd]:
    return {
        "degrees that nobody names": Odd(
            text([PLAIN], rows_of(np.degrees(GYROSCOPE), FORCE / G, FIELD_UT)).encode()
        ),
        "thousandths": Odd(
            text(
                [
                    "time,"
                    + ",".join(
                        f"{q}_{a} [{u}]" for q, u in (("G", "mdps"), ("A", "mg"), ("M", "mG")) for a in "XYZ"
                    )
                ],
                rows_of(1e3 * np.degrees(GYROSCOPE), 1e3 * FORCE / G, 10.0 * FIELD_UT),
            ).encode()
        ),
        "units in the names": Odd(
            text(
                [
                    "time_s,"
                    + ",".join(f"{q}_{a}_{u}" for q, u in (("gyro", "dps"), ("accel", "mps2")) for a in "xyz")
                ],
                rows_of(np.degrees(GYROSCOPE), FORCE),
            ).encode(),
            has_field=False,
        ),
    }


Refused = tuple[bytes, str]


def refused_tables() -> dict[str, Refused]:
    """By name: the file, and the code of the reason."""
    rows = rows_of(*ALL)
    plain = text([PLAIN], rows)
    orientation = ["time", "q_w", "q_x", "q_y", "q_z"]
    free = [f"Linear Acceleration {a} (m/s^2)" for a in "xyz"]
    ragged = [row[: 5 + k % 5] for k, row in enumerate(rows)]
    still = rows_of(*ALL, time_s=np.zeros(ROWS))
    shuffled = rows_of(*ALL, time_s=np.random.default_rng(1).permutation(TIME_S))
    files: dict[str, tuple[bytes | Callable[[], bytes], str]] = {
        "decimal commas between commas": (text([PLAIN], rows, ",", ",").encode(), "table.commas_twice"),
        "orientation only": (
            text([",".join(orientation)], rows_of(np.ones((ROWS, 4)))).encode(),
            "guess.orientation_only",
        ),
        "without gravity": (
            text([",".join(["time", "gyr_x", "gyr_y", "gyr_z", *free])], rows_of(GYROSCOPE, FORCE)).encode(),
            "guess.no_gravity",
        ),
        "no header": (text([], rows).encode(), "guess.no_names"),
        "no gyroscope": (text(["time,acc_x,acc_y,acc_z"], rows_of(FORCE)).encode(), "guess.not_whole"),
        "counts of a converter": (
            text([",".join(["time", *NINE[:6]])], rows_of(GYROSCOPE, FORCE / G * 4096)).encode(),
            "guess.no_unit",
        ),
        "a picture": (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR" + bytes(range(256)) * 40, "file.foreign"),
        "a spreadsheet's own format": (
            b"PK\x03\x04\x14\x00\x06\x00\x08\x00" + bytes(range(256)) * 40 + b"xl/worksheets/sheet1.xml",
            "file.foreign",
        ),
        "nothing": (b"", "table.empty"),
        "blanks": (b" \n" * 100, "table.empty"),
        "a header only": ((PLAIN + "\n").encode(), "table.no_rows"),
        "one row": (text([PLAIN], rows[:1]).encode(), "file.too_few_rows"),
        "rows of any length": (text([PLAIN], ragged).encode(), "table.ragged"),
        "words among numbers": (plain.replace(rows[900][3], "broken").encode(), "table.not_a_number_in_line"),
        "time stands still": (text([PLAIN], still).encode(), "time.does_not_advance"),
        "rows in any order": (text([PLAIN], shuffled).encode(), "time.does_not_advance"),
        "one line without end": (b"1," * 200_000, "table.endless_line"),
        "too many columns": (
            (",".join(f"c{k}" for k in range(5000)) + "\n" + ",".join(["1"] * 5000) + "\n").encode(),
            "table.too_many_columns",
        ),
        "a quote that never ends": (
            (PLAIN + '\n"' + "1,2,3,4,5,6,7,8,9,10\n" * 50).encode(),
            "guess.no_names",
        ),
        "units that contradict gravity": (
            text(
                ["time,gyr_x,gyr_y,gyr_z,acc_x (g),acc_y (g),acc_z (g)"], rows_of(GYROSCOPE, FORCE)
            ).encode(),
            "signal.no_gravity",
        ),
        "markers of cameras": (
            text(
                [",L_TOE,L_TOE,L_TOE", ",x,y,z"], [[str(k), *row[1:4]] for k, row in enumerate(rows)]
            ).encode(),
            "guess.no_signal",
        ),
    }
    return {
        name: (content() if callable(content) else content, code) for name, (content, code) in files.items()
    }
