"""English sentences of files that are read: recordings, markers, packet logs, and mappings of their columns."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "quantity.gyroscope": "gyroscope",
    "quantity.accelerometer": "accelerometer",
    "quantity.magnetometer": "magnetometer",
    "zip.damaged": "The zip cannot be read: it is cut off, damaged or packed in an unusual way. Pack its tables anew.",
    "zip.locked": "The zip has a password. Pack its tables without one.",
    "zip.many": "The zip holds {count:number} files; at most {most:number} are read. Pack the tables of one recording"
    " only.",
    "zip.nested": "The zip holds another zip or folders in folders. Pack the tables of one recording only, in one"
    " folder.",
    "zip.no_table": "The zip holds no table with measurements of a sensor ({names:and}). Pack tables of one recording"
    " as CSV; a recording in one file of another kind is chosen without the zip.",
    "zip.no_gravity": "{names:and}: acceleration without gravity, and gravity in a table of its own. Record or export"
    " the acceleration with gravity (in Sensor Logger: Total Acceleration).",
    "zip.clocks_differ": "The tables {names:and} count their time in different units; export them alike.",
    "zip.of_table": "{name}: {said}",
    "zip.joined": "{names:and} are joined by their times: the same time is taken for the same moment.",
    "zip.joined_from_start": "{names:and} each count from their own first row: they are taken to have begun at the"
    " same moment. If they did not, angles between their sensors are wrong.",
    "zip.joined_by_rows": "{names:and} have no time: their first rows are taken for the same moment.",
    "zip.pauses": {
        "one": "The recording was paused once; the pause is put back into its time.",
        "other": "The recording was paused {count:number} times; the pauses are put back into its time.",
    },
    "file.format_unknown": "There is no format {format}; choose {formats:or}.",
    "file.format_not_recognised": "The format of this file is not recognised; choose it: {formats:or}.",
    "file.csv_needs_mapping": "A CSV file needs a mapping: which column holds what, in which unit.",
    "file.sensor_name": "A sensor cannot be called {names:or}: letters, digits, blanks, _, - and . are possible,"
    " a letter or digit first. Rename it in the file.",
    "file.too_few_rows": "The file holds fewer than two rows; there is nothing to analyse.",
    "file.too_long": "The file is too long; split it into shorter recordings.",
    "file.unpacks_to_too_much": "The file has {packed_bytes:mib.1} and unpacks to more than"
    " {limit_bytes:mib~4}, the most that is read at once; split the recording.",
    "file.linked_data": "The data set {name} must be in the file itself; links and other kinds of data are not"
    " read.",
    "file.not_finite": "The file holds values that are not finite; fill or cut these gaps first.",
    "file.sensor_not_finite": "{where:place}: some values are not finite; fill or cut these gaps first.",
    "file.no_time_in_row": "Row {row} has no time; fill it in or remove the row.",
    "file.time_stands_still": "The time does not advance in row {row}; remove repeated rows.",
    "file.time_backwards": "The time runs backwards in row {row}; sort the rows by time.",
    "file.time_unit": "Read in {unit}, the time column gives {rate_hz:number~3} rows per second;"
    " {lowest_hz:number} to {highest_hz:number} are possible. {advice}",
    "file.looks_like_unit": "The values look like {unit}: declare that unit.",
    "file.check_time_unit": "Check the column and its unit.",
    "file.array_lengths": "The arrays of the file differ in length; the file is damaged.",
    "file.array_shape": "An array of the file has the shape {shape}; {expected} was expected.",
    "file.arrays_not_numbers": "The arrays of the file do not hold numbers.",
    "file.samples_and_times": "The file has {samples:number} samples and {times:number} time stamps; it is"
    " damaged.",
    "file.hdf5_of_sensors": "This is an HDF5 of several sensors, as APDM's software records it. Export the recording as"
    " CSV there and choose that file.",
    "file.not_this_kind": "The file has no {missing:and}; it is not {kind:file_kind}.",
    "file.arrays_not_this_kind": "The arrays of the file are not those of {kind:file_kind}.",
    "file.none_of_sensors": "The file has none of the sensors {names:or}; it is not {kind:file_kind}.",
    "file_kind.broad": "a trial of the BROAD benchmark",
    "file_kind.pyshoe": "a walk of the PyShoe set",
    "file_kind.qmt": "a whole-body recording of the qmt toolbox",
    "file_kind.gaitmap": "a recording of the gaitmap library",
    "file.rate_impossible": "A sampling rate of {rate_hz:hz~3} is not possible; the file is damaged.",
    "file.hdf5_unreadable": "The file cannot be read as HDF5; export it again.",
    "file.sensor_shape": "Sensor {name}: `{key}` has the shape {shape}; {samples} time stamps need {expected}.",
    "file.sensor_not_numeric": "Sensor {name}: `{key}` is missing or does not hold numbers.",
    "file.row_incomplete": "Row {row} is not complete; fill it in or remove it.",
    "file.row_not_numbers": "A row is incomplete or holds a value that is not a number.",
    "file.no_column": "The file has no column {column}; add it, or choose another format.",
    "file.uneven": "The samples are not evenly spaced in time; resample them to one rate first.",
    "file.header_then_numbers": "The file cannot be read as CSV with numbers below one header row.",
    "file.rows_and_header": "The file holds no samples, or its rows are not as long as its header.",
    "file.no_placement": "No sensor of the file is at a supported position; use {placements:or}.",
    "file.time_stamps_differ": "The sensors have different time stamps; bring them to one time column.",
    "file.left_out": "Not used, position not supported: {names:and}.",
    "mat.version": "This .mat file has version 7.3; save it as version 5 or 7.",
    "mat.unreadable": "The file cannot be read as a .mat file; save it as version 5 or 7.",
    "gaitmap.side": "The file does not say which foot it is of; put `left` or `right` into its name.",
    "gaitmap.header": "The file needs a header of one or two rows, with numbers below it.",
    "gaitmap.strides": "{file} is not a list of strides.",
    "shoe.weight": "Body weight measured by the shoes is {weight_n:number} N; a person weighs {least_n:number}"
    " to {most_n:number} N. Check the unit (newton) and that z points up against the foot.",
    "c3d.not_c3d": "This is not a C3D file; choose the format that it has.",
    "c3d.damaged": "The parameters of this C3D file are damaged; export it again.",
    "c3d.processor": "The number format {processor} of this C3D file is unknown; export it with Intel numbers.",
    "c3d.points": "The C3D file holds {points:number} points; 1 to {most:number} can be used.",
    "c3d.rate": "The C3D file states a rate of {rate_hz:hz~3}, which is not possible; export it again.",
    "c3d.no_unit": "The C3D file does not state the unit of its points; export it with {units:or}.",
    "c3d.unit": "The C3D file states its points in {unit}; export it with {units:or}.",
    "c3d.no_frames": "The C3D file holds no frames.",
    "c3d.cut_off": "The C3D file is cut off: it announces {frames:number} frames and holds fewer. Export it"
    " again.",
    "marker_file.no_marker": "The file has no marker {marker}; it has {names:and}.",
    "marker_file.never_seen": "No marker is visible at any time in this file.",
    "marker_file.far": "A marker is {far_m:m.0} from the origin, which is not possible. {advice}",
    "marker_file.unit": "The values look like mm or cm: declare that unit.",
    "marker_file.check_unit": "Check the unit.",
    "marker_file.columns": "No marker was found: each needs three columns, NAME_x, NAME_y and NAME_z. The file"
    " has: {present}.",
    "marker_file.no_time": "The file has no column time_s; add it, or declare the rate of the cameras.",
    "marker_file.rate": "The frames come at {rate_hz:hz~3}, which is not possible; check that time_s is in"
    " seconds.",
    "mapping.no_time": "The mapping names neither a time column nor a rate; give one of them.",
    "mapping.rate": "A rate of {rate_hz:number~4} Hz is not possible; use {lowest_hz:number} to"
    " {highest_hz:hz}.",
    "mapping.unit": "The {quantity:quantity} (columns {columns:and}) cannot have the unit {unit}; use"
    " {units:or}.",
    "mapping.twice": "{where:place}: the {quantity:quantity} is mapped twice, to the columns"
    " {first:and} and again to {second:and}; keep one.",
    "mapping.no_sensor": "The mapping names no sensor; map gyroscope and accelerometer of at least one.",
    "mapping.needed": "{where:place}: the {quantity:quantity} is not mapped; gyroscope and"
    " accelerometer are both needed.",
    "mapping.magnetometers": "The magnetometer is not mapped for {places:place}; map it for all sensors or for"
    " none.",
    "log.not_a_log": "The file does not start with TML1: it is not a Telemotion packet log. Choose the right"
    " format.",
    "log.hello_too_long": "The hello of the log states {length} bytes; at most {most} are allowed.",
    "log.hello_not_json": "The hello at the beginning of the log is not a JSON object.",
    "log.hello_incomplete": "The hello at the beginning of the log lacks placements, rate or scales.",
    "log.hello_refused": "The hello of the log cannot be used. {reason}",
    "log.cut_off_in_hello": "The log ends within its hello; it was cut off.",
    "log.cut_off": "The log ends within packet {number}; it was cut off.",
    "log.packet_length": "Packet {number} states {length} bytes; the log is damaged there.",
    "log.no_packet": "The log holds no intact packet.",
    "signal.foot_gyroscope": "{where:place}: the gyroscope turns by no more than {raw:number~3} {unit}"
    " although the accelerometer shows steps; a walking foot turns by 1 rad/s (57 deg/s) or more. {advice}",
    "signal.gyroscope_fast": "{where:place}: the gyroscope reads {raw:number} {unit}, faster than any"
    " sensor measures. {advice}",
    "signal.no_numbers": "{where:place}: the {quantity:quantity} holds no numbers.",
    "signal.no_gravity": "{where:place}: the accelerometer has a median of {raw:number~3} {unit};"
    " gravity (9.81 m/s²) was expected. {advice}",
    "signal.no_earth_field": "{where:place}: the magnetometer has a median of {raw:number~3} {unit};"
    " the earth's field (22 to 67 µT) was expected. {advice}",
    "signal.iron_or_unit": "Iron on the device looks so: turn the sensor about all its axes in the recording, or leave"
    " the compass out. So does another unit: declare {units:or} only if the device gives it.",
    "signal.iron_or_columns": "Iron on the device looks so: turn the sensor about all its axes in the recording, or"
    " leave the compass out. Otherwise check its columns and its unit.",
    "signal.check_columns": "Check its columns and its unit.",
    "table.endless_line": "The first line has no end; this is not a table.",
    "table.not_utf8": "The file is not UTF-8 text. Save it as CSV in UTF-8 and upload it again.",
    "table.no_column": "The file has no column {missing:and}. It has: {present}. Correct the mapping.",
    "table.no_rows": "The file has a header but no rows.",
    "table.too_long": "The file holds more than {rows:number} rows for {columns:number} columns; split it into"
    " shorter recordings.",
    "table.not_a_number_in_line": "Line {line:number}: the value in the column {column} is not a number; the columns of"
    " the mapping must hold numbers only.",
    "table.not_a_number": "A value in the column {column} is not a number; the columns of the mapping must"
    " hold numbers only.",
    "table.ragged": "Many rows have another number of columns than the header; the file is damaged.",
    "table.unreadable": "The file cannot be read as a table; check the character between its columns.",
    "table.in_columns": "{reason} (In the file: {columns:and}.)",
}
