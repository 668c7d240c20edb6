"""English sentences of tables: what is no table, what of its time was mended, what is guessed of its columns."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "table.not_text": "The file is not text: it holds bytes that no table has. Save it as CSV and try again.",
    "table.empty": "The file holds nothing that could be a table.",
    "table.commas_twice": "The numbers have decimal commas and commas stand between them too: which is which cannot be"
    " found out. Save the table with semicolons or tabs between its columns.",
    "table.too_many_columns": "The table has {columns:number} columns; at most {most:number} are read.",
    "table.rows_left_out": {
        "one": "A row has another number of columns than the header and is left out.",
        "other": "{count:number} rows have another number of columns than the header and are left out.",
    },
    "time.missing": {
        "one": "A row has no time and is left out.",
        "other": "{count:number} rows have no time and are left out.",
    },
    "time.repeated": {
        "one": "A row has the time of the row before, or nearly; it is placed between its neighbours.",
        "other": "{count:number} rows have the time of the row before, or nearly; they are placed between their"
        " neighbours.",
    },
    "time.row_twice": {
        "one": "A row was written twice; the second one is left out.",
        "other": "{count:number} rows were written twice; the second ones are left out.",
    },
    "time.out_of_order": {
        "one": "The time of a row lies behind that of a row before; it is left out.",
        "other": "The time of {count:number} rows lies behind that of a row before; they are left out.",
    },
    "time.set_back": {
        "one": "The time was set back once in the recording; a pause of {pause_s:s} is assumed there.",
        "other": "The time was set back {count:number} times in the recording; a pause of {pause_s:s} is assumed at"
        " each.",
    },
    "time.midnight": {
        "one": "The times of day have no date and pass midnight once; the next day is assumed there.",
        "other": "The times of day have no date and pass midnight {count:number} times; the next day is assumed at"
        " each.",
    },
    "time.hour_passed": {
        "one": "The times are minutes and seconds and pass the hour once; the next hour is assumed there.",
        "other": "The times are minutes and seconds and pass the hour {count:number} times; the next hour is assumed at"
        " each.",
    },
    "table.header_again": {
        "one": "The names of the columns stand again in line {line:number}, as after a restart of a logger; that line"
        " is left out.",
        "other": "The names of the columns stand again in {count:number} lines, the first one line {line:number}, as"
        " after restarts of a logger; these lines are left out.",
    },
    "time.clock_changed": {
        "one": "The times have no zone and jump by one hour at a full hour: the clock is taken to have been put forward"
        " or back there. If the recording paused for an hour instead, write the times with their zone.",
        "other": "The times have no zone and jump by one hour at a full hour {count:number} times: the clock is taken"
        " to have been put forward or back there. If the recording paused for an hour instead, write the times with"
        " their zone.",
    },
    "time.does_not_advance": "The time column does not advance; choose another one, or give the rate instead.",
    "time.hopeless": "{count:number} of {rows:number} rows have no usable time; choose another time column, or give the"
    " rate instead.",
    "table.rows_of_none": {
        "one": "A row is left out: no sensor is called {values:and} in {column}.",
        "other": "{count:number} rows are left out: no sensor is called {values:and} in {column}.",
    },
    "table.rows_of_nobody": {
        "one": "A row is left out: {column} says nothing there.",
        "other": "{count:number} rows are left out: {column} says nothing there.",
    },
    "table.joined": "The quantities of {where:place} have times of their own; they are joined by time.",
    "table.clocks_apart": "The clocks of {where:and} have no time in common: two of them were never on at once. Upload"
    " each sensor by itself, or choose one clock for all.",
    "guess.one_device": "The column {column} changes ({values:and}), and no two of these were on at once: all rows are"
    " taken for one recording of the same sensors.",
    "guess.devices": "The rows are of several devices, one for each {column}: {values:and}.",
    "guess.tall": "Each row holds one value, of what {columns:and} says: the values of a sample are put side by side.",
    "guess.tall_unsorted": "Each row holds one value, and the beginning of the table holds {values:and} only; a sensor"
    " needs three axes of an angular rate and of an acceleration. Sort the rows by {column}, so that each sample stands"
    " together.",
    "guess.tall_lacks": "Each row holds one value, and the beginning of the table holds {values:and} only; a sensor"
    " needs three axes of an angular rate and of an acceleration.",
    "table.rows_of_no_signal": {
        "one": "A row is left out: the beginning of the table has no {values:and} in {column}.",
        "other": "{count:number} rows are left out: the beginning of the table has no {values:and} in {column}.",
    },
    "guess.own_clocks": "The sensors have clocks of their own: {columns:and}. They are taken to count from one moment.",
    "table.counters_apart": "The counters of {where:and} begin at other numbers than the first one; their samples are"
    " taken to be of the time of the rows beside them.",
    "table.sensors_joined": "The stamps of {where:and} differ; all are brought to one time.",
    "time.pauses": {
        "one": "The recording pauses once, for {longest_s:s}; nothing is known in between.",
        "other": "The recording pauses {count:number} times, for {longest_s:s} at most; nothing is known in between.",
    },
    "file.averaged_down": "{from_hz:hz} are more than movement needs: the means of {count:number} samples each are"
    " estimated, at {rate_hz:hz}.",
    "file.slow": "{rate_hz:hz.1} are less than the {least_hz:hz} that orientation needs: what turns between two samples"
    " is not seen. The angles hold for slow movement only; of faster movement they are wrong by more than the stated"
    " uncertainty.",
    "table.no_field": "{where:place}: the magnetometer is not used; there are no numbers in {columns:and}.",
    "table.iron": "{where:place}: the compass was never calibrated. Iron of {field_t:ut} on the device was found by its"
    " turning and is taken out.",
    "guess.no_names": "The table has no line with the names of its columns; add one, or say in a mapping which"
    " column is what.",
    "guess.no_signal": "No three columns are named as x, y and z of an angular rate or an acceleration.",
    "guess.not_whole": "No sensor has both an angular rate and an acceleration; both are needed.",
    "guess.orientation_only": "The table holds orientations ({columns:and}), not what the sensors measured; export"
    " angular rate and acceleration too.",
    "guess.no_gravity": "The columns {columns:and} hold acceleration without gravity; export what the accelerometer"
    " measured.",
    "guess.left_out": "Not used: {columns:and}.",
    "time.counter_holes": {
        "one": "By the counter a sample is missing; there is a hole in time there.",
        "other": "By the counter {count:number} samples are missing; there are holes in time there.",
    },
    "guess.counter": "{column} counts the samples, at {rate_hz:hz.1}; where it jumps, samples are missing.",
    "guess.clocks_left": "{columns:and} hold times too; {column} was taken.",
    "guess.microseconds": "{column} is taken to count microseconds; the rows come at {rate_hz:hz.1}.",
    "guess.time_unit": "{column} says no unit of time; {unit} is assumed, so that the rows come at {rate_hz:hz.1}.",
    "guess.counter_needs_rate": "No column is a time; {column} counts the samples. Give the rate.",
    "guess.rate_left": "A line above the table, or you, said {said_hz:hz}; by {column} the rows come at"
    " {rate_hz:hz}. The column was taken.",
    "guess.rows_counted": "No column is a time: the rows are taken to follow each other at {rate_hz:hz}. Rows"
    " that are missing would not be noticed.",
    "guess.no_time": "No column is a time and no line above the table says a rate; give the rate.",
    "guess.no_place": "These columns do not say where on the body the sensor is: {columns:and}.",
    "guess.foot_side": "The table does not say which foot it is of; the right one is assumed.",
    "guess.field_relative": "The columns {columns:and} say no unit and have a size of about one: they are taken for"
    " multiples of the field where the magnetometer was calibrated, about 45 µT.",
    "guess.unit_from_numbers": "The columns {columns:and} say no unit; their numbers are {unit:unit}.",
    "guess.no_unit": "The columns {columns:and} say no unit, and with a size of {size:number~3} their numbers are"
    " neither m/s² nor g nor mg; convert them first.",
    "guess.unit_of_others": "The columns {columns:and} say no unit and their numbers none either; {unit:unit} is taken,"
    " as of the other sensors.",
    "guess.unit_assumed": "The columns {columns:and} say no unit and their numbers none either; {unit:unit} is"
    " assumed.",
}
