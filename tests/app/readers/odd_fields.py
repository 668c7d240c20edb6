"""Tables as loggers, phones and scripts write them: odd clocks, restarts, units and names. See `odd_tables`."""

import functools

import numpy as np

from tests.app.readers.odd_tables import (
    ALL,
    FIELD_UT,
    FORCE,
    GYROSCOPE,
    NINE,
    PLAIN,
    ROWS,
    TIME_S,
    G,
    Odd,
    numbers,
    rows_of,
    text,
)

DEGREES = np.degrees(GYROSCOPE)


@functools.cache
def field_tables() -> dict[str, Odd]:
    return {
        **_rates(),
        **_counters(),
        **_arrivals(),
        **_restarts(),
        **_names(),
        **_apart(),
        **_marks(),
        **_losses(),
        **_tall(),
    }


def _rates() -> dict[str, Odd]:
    """A number beside "Hz" that is not of the samples, or contradicts their stamps."""
    rows = rows_of(*ALL)
    bare = text([",".join(NINE)], rows_of(*ALL, time_s=None))
    by_rows = frozenset({"guess.rows_counted"})
    return {
        "a filter's hertz": Odd(text(["# notch filter: 60 Hz", PLAIN], rows).encode()),
        "a heart rate": Odd(text(["Heart rate: 72", PLAIN], rows).encode()),
        "a rate that the stamps deny": Odd(
            text(["Sample rate: 60 Hz", PLAIN], rows).encode(), notes=frozenset({"guess.rate_left"})
        ),
        "a rate among other hertz": Odd(
            f"Low pass: 40 Hz\nMains 50 Hz\nUpdate Rate: 100.0Hz\n{bare}".encode(), notes=by_rows
        ),
        "two rates in one line": Odd(
            f"Low-pass filter 20 Hz, sampling rate 100 Hz\n{bare}".encode(), notes=by_rows
        ),
        "a slower compass": Odd(
            f"Magnetometer 20 Hz, accelerometer and gyroscope 100 Hz\n{bare}".encode(), notes=by_rows
        ),
        "a filter by its letters": Odd(f"DLPF: 42 Hz\nRate: 100 Hz\n{bare}".encode(), notes=by_rows),
        "milliseconds, as the rate says": Odd(
            text(["Abtastrate: 100 Hz", PLAIN], rows_of(*ALL, time_s=1e3 * TIME_S)).encode()
        ),
    }


def _counters() -> dict[str, Odd]:
    """No stamp, only what counts the samples; a hole in the counter is a hole in time."""
    there = np.ones(ROWS, dtype=bool)
    there[400:480] = there[900:940] = False
    there[np.arange(1000, ROWS, 20)] = False
    rows = np.flatnonzero(there)
    notes = frozenset({"guess.counter", "time.counter_holes"})

    def counted(name: str, count: np.ndarray) -> Odd:
        content = text(
            [",".join([name, *NINE])],
            [[str(int(c)), *row] for c, row in zip(count, numbers(np.column_stack(ALL)[rows]), strict=True)],
        )
        return Odd(content.encode(), {"imu": rows}, options=("--rate", "100"), notes=notes)

    return {
        "packets by number": counted("Packet number", 17 + rows),
        "a counter of one byte": counted("Counter", (250 + rows) % 256),
        "a counter of two bytes": counted("PacketCounter", (65_000 + rows) % 65_536),
        "a counter of four bytes": counted("sample counter", (4_294_967_000 + rows) % 2**32),
        "fine sample times": counted("SampleTimeFine", 3_000_000 + 100 * rows),
    }


def _arrivals() -> dict[str, Odd]:
    """Stamps of the arrival of samples that were measured evenly."""
    rng = np.random.default_rng(5)
    burst = TIME_S[(np.arange(ROWS) // 8) * 8] + 2e-4 * (np.arange(ROWS) % 8)
    late = TIME_S.copy()
    late[rng.choice(np.arange(5, ROWS - 5, 4), 60, replace=False)] += 0.0098
    said = frozenset({"time.repeated"})

    def stamped(stamps: np.ndarray) -> Odd:
        return Odd(
            text([PLAIN], rows_of(*ALL, time_s=stamps, digits=9)).encode(),
            notes=said,
            time_s=TIME_S,
            within_s=3e-4,
        )

    return {"samples in bursts": stamped(burst), "samples that nearly coincide": stamped(late)}


def _restarts() -> dict[str, Odd]:
    rows = rows_of(*ALL)
    lines = text([PLAIN], rows).split("\n")
    again = [*lines[:801], PLAIN, *lines[801:]]
    thrice = [*lines[:301], PLAIN, *lines[301:901], PLAIN, *lines[901:]]
    blanks = "\n".join(again).replace(",", " ")
    said = frozenset({"table.header_again"})
    return {
        "a head that stands again": Odd("\n".join(again).encode(), notes=said),
        "a head that stands thrice": Odd("\n".join(thrice).encode(), notes=said),
        "a head that stands again, decimal commas": Odd(
            "\n".join(again).replace(",", ";").replace(".", ",").encode(), notes=said
        ),
        "a head that stands again between blanks": Odd(blanks.encode(), notes=said),
    }


def _names() -> dict[str, Odd]:
    def six(gyroscope: list[str], force: list[str], *parts: np.ndarray) -> Odd:
        return Odd(
            text([",".join(["time_s", *gyroscope, *force])], rows_of(*parts)).encode(), has_field=False
        )

    def axes(pattern: str, order: str = "xyz") -> list[str]:
        return [pattern.format(a) for a in order]

    backwards = [2, 1, 0]
    return {
        "the ordinal sign": six(axes("Gyr {} (º/s)"), axes("Acc {} (m/s²)"), DEGREES, FORCE),
        "the ring": six(axes("Gyr {} [˚/s]"), axes("Acc {} [g]"), DEGREES, FORCE / G),
        "units as a script has them": six(
            axes("gyro_{} (rad/s)"), axes("accel_{} (m/s**2)"), GYROSCOPE, FORCE
        ),
        "units in words": six(
            axes("Gyroscope {} (degrees per second)"),
            axes("Accelerometer {} (meters per second squared)"),
            DEGREES,
            FORCE,
        ),
        "an unknown unit": six(axes("gyr_{} (x/s)"), axes("acc_{} [bits/g]"), DEGREES, FORCE / G),
        "multiples of gravity": six(axes("w{}"), axes("gF{}"), GYROSCOPE, FORCE / G),
        "letters beside a word": Odd(
            text(
                [",".join(["time", *axes("a{}"), *axes("g{}"), *axes("mag{}")])],
                rows_of(FORCE, GYROSCOPE, FIELD_UT),
            ).encode()
        ),
        "a field in units of its own": Odd(
            text(
                [",".join(["time", *NINE[:6], *axes("Mag_{}_CAL (local_flux)")])],
                rows_of(GYROSCOPE, FORCE, FIELD_UT / 45.0),
            ).encode(),
            notes=frozenset({"guess.field_relative"}),
        ),
        "z, y and x": six(
            axes("rot_rate_{}", "zyx"), axes("acc_{}", "zyx"), GYROSCOPE[:, backwards], FORCE[:, backwards]
        ),
    }


def _apart() -> dict[str, Odd]:
    """Rows of several devices or kinds, and clocks of their own."""
    one, other = np.column_stack([GYROSCOPE, FORCE]), np.column_stack([GYROSCOPE[::-1], FORCE[::-1]])
    both = {"first": slice(None), "second": slice(None, None, -1)}
    stamps = [f"{stamp:.14g}" for stamp in TIME_S]

    def devices(names: tuple[str, str], *, is_block: bool = False) -> bytes:
        first, second = (
            [[stamp, name, *row] for stamp, row in zip(stamps, numbers(part), strict=True)]
            for name, part in zip(names, (one, other), strict=True)
        )
        rows = (
            [*first, *second]
            if is_block
            else [row for pair in zip(first, second, strict=True) for row in pair]
        )
        return text([",".join(["time", "device", *NINE[:6]])], rows).encode()

    said = frozenset({"guess.devices"})
    kinds = [
        [stamp, kind, *row]
        for k, stamp in enumerate(stamps)
        for kind, row in (
            ("accelerometer", numbers(FORCE[k : k + 1])[0]),
            ("gyroscope", numbers(GYROSCOPE[k : k + 1])[0]),
            ("magnetometer", numbers(FIELD_UT[k : k + 1])[0]),
        )
    ]
    empty = ["", "", ""]
    halves = [
        row
        for stamp, gyroscope, force in zip(stamps, numbers(GYROSCOPE), numbers(FORCE), strict=True)
        for row in ([stamp, *gyroscope, *empty], [stamp, *empty, *force])
    ]
    marked = [
        [*row, str(int(k % 700 > 350)), ("rest", "reach", "back")[k // 100 % 3], str(k % 7 < 3)]
        for k, row in enumerate(rows_of(*ALL))
    ]
    return {
        "rows of two devices": Odd(devices(("first", "second")), both, notes=said, has_field=False),
        "rows of two devices by address": Odd(
            devices(("WT901(a1:01)", "WT901(b2:02)")),
            {"WT901_a1_01": slice(None), "WT901_b2_02": slice(None, None, -1)},
            notes=said,
            has_field=False,
        ),
        "rows of two devices by number": Odd(
            devices(("17", "4")),
            {"device_17": slice(None), "device_4": slice(None, None, -1)},
            notes=said,
            has_field=False,
        ),
        "one device below the other": Odd(
            devices(("first", "second"), is_block=True), both, notes=said, has_field=False
        ),
        "rows of three kinds": Odd(
            text(["time,sensor,x,y,z"], kinds).encode(), notes=frozenset({"table.joined"})
        ),
        "rows of halves": Odd(text([",".join(["time", *NINE[:6]])], halves).encode(), has_field=False),
        "a clock for each sensor": Odd(
            text(
                [
                    ",".join(
                        f"{name}_{column}" for name in ("alpha", "beta") for column in ["time", *NINE[:6]]
                    )
                ],
                [
                    [stamp, *row, stamp, *another]
                    for stamp, row, another in zip(stamps, numbers(one), numbers(other), strict=True)
                ],
            ).encode(),
            {"alpha": slice(None), "beta": slice(None, None, -1)},
            notes=frozenset({"guess.own_clocks"}),
            has_field=False,
        ),
        "a clock for each quantity": Odd(
            text(
                [",".join(["gyr_time", *NINE[:3], "acc_time", *NINE[3:6]])],
                [[stamp, *row[:3], stamp, *row[3:]] for stamp, row in zip(stamps, numbers(one), strict=True)],
            ).encode(),
            notes=frozenset({"guess.own_clocks"}),
            has_field=False,
        ),
        "marks among the columns": Odd(text([f"{PLAIN},button,phase,contact"], marked).encode()),
    }


def _marks() -> dict[str, Odd]:
    """Columns that take turns or begin again and are no devices."""
    rows = rows_of(*ALL)

    def marked(name: str, marks: list[str], *, content: list[list[str]] = rows, notes: str = "") -> Odd:
        lines = [[mark, *row] for mark, row in zip(marks, content, strict=True)]
        return Odd(text([f"{name},{PLAIN}"], lines).encode(), notes=frozenset({notes} - {""}))

    again = [[f"{k % 300 / 100:.2f}", *row[1:]] for k, row in enumerate(rows)]
    paused = np.concatenate([300 / 100 * k + k * 0.99 + TIME_S[:300] for k in range(5)])
    trials = marked("trial", [str(1 + k // 300) for k in range(ROWS)], content=again, notes="time.set_back")
    trials.time_s = paused
    named = marked(
        "repetition",
        [("first", "second", "third", "fourth", "fifth")[k // 300] for k in range(ROWS)],
        content=again,
        notes="time.set_back",
    )
    named.time_s = paused
    return {
        "trials below each other": trials,
        "repetitions by name": named,
        "a pulse in each other row": marked("sync", [str(k % 2) for k in range(ROWS)]),
        "a line that toggles": marked("digital in", [str(k % 2) for k in range(ROWS)]),
        "the place in a packet": marked("slot", [str(k % 4) for k in range(ROWS)]),
        "a number of four bits": marked("seq", [str(k % 16) for k in range(ROWS)]),
    }


def _tall() -> dict[str, Odd]:
    """One value a row."""
    said = frozenset({"guess.tall"})
    rows = rows_of(*ALL)
    of_one_name = [[row[0], name, value] for row in rows for name, value in zip(NINE, row[1:], strict=True)]
    apart = [[one[0], *one[1].split("_"), one[2]] for one in of_one_name]
    return {
        "one value a row": Odd(text(["time,channel,value"], of_one_name).encode(), notes=said),
        "one value a row, quantity and axis apart": Odd(
            text(["time;quantity;axis;value"], apart, ";", ",").encode(), notes=said
        ),
    }


def _losses() -> dict[str, Odd]:
    """Stamps of the device with more lost than there, and counters that begin again at any number."""
    said = "# sampling rate 100 Hz"

    def some(there: np.ndarray) -> Odd:
        rows = np.flatnonzero(there)
        content = text([PLAIN], rows_of(*ALL, time_s=TIME_S[rows], rows=rows))
        return Odd(content.encode(), {"imu": rows})

    def counted(count: np.ndarray, name: str = "counter") -> Odd:
        lines = [[str(int(c)), *row] for c, row in zip(count, rows_of(*ALL, time_s=None), strict=True)]
        return Odd(text([said, ",".join([name, *NINE])], lines).encode(), notes=frozenset({"guess.counter"}))

    k = np.arange(ROWS)
    hole = np.flatnonzero((k < 700) | (k >= 1100))
    return {
        "six of twenty rows": some(k % 20 < 6),
        "on for 0.3 s, off for 0.45 s": some(k % 75 < 30),
        "on for 0.1 s, off for 0.3 s": some(k % 40 < 10),
        **{f"a counter to {most}": counted(k % most) for most in (100, 128, 160, 200, 512)},
        "a clock that is called of samples": Odd(
            text(
                [said, PLAIN.replace("time", "Sample Time (s)")],
                rows_of(*ALL, time_s=TIME_S[hole], rows=hole),
            ).encode(),
            {"imu": hole},
        ),
        "a temperature called T": Odd(
            text(
                [said, ",".join(["T", "counter", *NINE])],
                [[str(20 + j), str(j), *row] for j, row in enumerate(rows_of(*ALL, time_s=None))],
            ).encode(),
            notes=frozenset({"guess.counter"}),
        ),
        "two counters, one with its rate": Odd(
            text(
                [",".join(["PacketCounter", "SampleTimeFine", *NINE])],
                [[str(j), str(100 * j), *row] for j, row in enumerate(rows_of(*ALL, time_s=None))],
            ).encode(),
            notes=frozenset({"guess.counter"}),
        ),
    }
