"""English sentences of files that no reader takes: what each is, and what to choose instead."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "file.foreign": "{kind:foreign}",
    "foreign.workbook": "This is a workbook of a spreadsheet program (Excel). Save the sheet with the measurements"
    " as CSV and choose that file.",
    "foreign.document": "This is a document (PDF, Word), not a recording. Export the measurements as CSV from the"
    " program that recorded them.",
    "foreign.picture": "This is a picture, not a recording. Choose the file with the measurements of the sensors.",
    "foreign.video": "This is a video or a sound, not a recording of sensors. Choose the file with the measurements"
    " of the sensors.",
    "foreign.packed": "This file is compressed in another way than zip. Unpack it and choose the recording in it, or"
    " a zip of its tables.",
    "foreign.database": "This is a database, as apps and loggers have it for themselves. Export the recording there"
    " as CSV and choose that file.",
    "foreign.data_frame": "This is a file of a program for data (Parquet, Arrow, NumPy, pickle). Save its table as"
    " CSV and choose that file.",
    "foreign.xdf": "This is an XDF of Lab Streaming Layer. Save the stream of each sensor with its time stamps as"
    " CSV and choose a zip of these tables.",
    "foreign.c3d": "This is a C3D of a camera system. Its markers are added to a session that is there already;"
    " measurements of sensors in its analogue channels are to be exported as CSV.",
    "foreign.mtb": "This is a recording of Xsens sensors in the maker's own form. Export it as text in MT Manager,"
    " with acceleration, angular velocity, magnetic field and the packet counter, and choose that file.",
    "foreign.activity": "This is a recording of an activity monitor. One with a gyroscope (AX6) is read when it is"
    " exported as CSV; an accelerometer alone gives no angles.",
    "foreign.ximu3": "This is a recording of x-IMU3 devices in the maker's own form. Convert it to CSV in x-IMU3 GUI"
    " and choose a zip of Inertial.csv and Magnetometer.csv.",
    "foreign.mvnx": "This is an MVNX of MVN Analyze, with orientations of segments. What is needed is what each"
    " sensor measured, angular rate and acceleration, as CSV.",
    "foreign.web_page": "This is a web page, not a recording: perhaps the page before the download was saved."
    " Download the recording itself.",
    "foreign.xml": "This is an XML file, which is not read. Export the measurements as CSV and choose that file.",
    "foreign.json": "This is a JSON file, which is not read. Export the measurements as CSV and choose that file;"
    " apps for phones ask for the format when they export.",
    "foreign.opensim": "This is a file of OpenSim, with orientations or results. Choose the recording of the sensors"
    " from which it was made.",
    "file.hdf5_unknown": "This is an HDF5 with {names:and}, of no kind that is read. Export the measurements as CSV"
    " and choose that file.",
}
