"""English sentences of what gateways and uploads send: packets, hellos and the parts of an upload."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "upload.same_signals": "The sensors on the {where:place} send the same signal: one sensor comes under several"
    " names. What is shown of them is the movement of one. Check which sensor was where, then upload the"
    " recording again.",
    "upload.multipart": "Send multipart/form-data with the parts `declaration` and `file`.",
    "upload.too_large": "The file is larger than the limit of {limit_bytes:mib}; split the recording.",
    "upload.malformed": "The body is not well-formed multipart/form-data.",
    "upload.broken_off": "The upload broke off before its end; send it again.",
    "upload.no_file": "The part `file` is missing.",
    "upload.header_too_long": "A header of a part is too long.",
    "upload.parts": "Send exactly the parts `declaration` and `file`, in this order.",
    "upload.declaration_first": "Send the part `declaration` (JSON) before the part `file`.",
    "upload.declaration_too_long": "The declaration is too long.",
    "upload.fields": "The declaration is wrong in: {fields:and}.",
    "upload.csv_needs_mapping": "A CSV upload needs `csv`: which column holds what, in which unit.",
    "upload.pose": "The pose in `calibration_pose_s` must be a start and a later end, in seconds of the"
    " recording.",
    "upload.recorded_at": "The moment of the recording needs a time zone and must lie between 2000 and now, for"
    " instance 2026-11-09T08:00:00Z.",
    "upload.day_unknown": "The file does not say when it was recorded: the session counts for the day of its upload.",
    "upload.gone": "The uploaded file no longer exists; upload it again.",
    "upload.damaged_packets": {
        "one": "{count} damaged packet was rejected.",
        "other": "{count} damaged packets were rejected.",
    },
    "upload.implausible": "The readings cannot be right. {findings} {remedy}",
    "upload.correct_or_accept": "Correct the declaration and upload the file again, or declare"
    " `accept_implausible` to analyse it as it is.",
    "process.correct_or_force": "Say where it was recorded (--hemisphere) or declare the file rightly (--mapping, in"
    ' which "sign": -1 turns all axes of a signal), or use --force to estimate it as it is.',
    "progress.reading_file": "Reading the file",
    "progress.storing": "Storing the recording",
    "progress.checking": "Checking units and axes",
    "progress.reading_markers": "Reading the markers",
    "progress.fusing": "Aligning and fusing the markers",
    "marker_fusion.cluster": "A cluster needs at least three different markers.",
    "marker_fusion.refused": "{reason} Check the segment and which axis points up.",
    "marker_fusion.up": "In the axes of the file, {axis} points up.",
    "marker_fusion.unit": "The numbers of the file look like {unit}, not {declared}: choose that unit.",
    "marker_fusion.inches": "Inches and centimetres seem to have been exchanged when the file was written.",
    "hello.too_many": "Too many tickets from this address were not valid; try again in {seconds:s}.",
    "hello.first": "The first message must be a JSON hello.",
    "hello.timeout": "Send a hello within {seconds:s} of connecting.",
    "hello.not_understood": "The hello is not valid: {faults}",
    "hello.protocol_version": "This service speaks protocol version {ours}, the hello {theirs}; update the"
    " gateway.",
    "hello.no_sensor": "The hello names no sensor; list the placements in packet order.",
    "hello.placements_unknown": "Unknown placements: {unknown:and}; use {known:or}.",
    "hello.placement_twice": "A placement is named twice; each sensor has its own.",
    "hello.serials": "The hello names {sensors} sensors and {serials} different serial numbers; send one for"
    " each sensor, or none.",
    "hello.rate": "A rate of {rate_hz:number~4} Hz is not possible; send 10 to 1000 Hz.",
    "hello.scale": "The value of {field} is {value}; it must be above 0 and at most {limit} in SI units.",
    "packet.truncated": "The packet has {size} bytes; the header alone has {header}. Send one whole packet in"
    " each message.",
    "packet.length": "The packet has {size} bytes; {sensors} sensors, {ticks} ticks and channel mask {mask}"
    " need {expected}. Check the counts in the header.",
    "packet.crc": "The CRC-32 over header bytes 0 to 27 and the payload does not match; send the packet again.",
    "packet.values": "Give float32 or int16 values of shape (ticks, sensors, values).",
    "packet.width": "{width} values per sensor do not fit channel mask {mask}.",
    "packet.all_or_none": "Give {channel} for all sensors or for none.",
    "packet.shape": "Sensor {sensor} must have {ticks} rows of three values in every channel, as sensor 0 has"
    " (of coil states: as many numbers).",
    "packet.sensors_declared": "The packet has {sensors} sensors, the hello declared {declared}; send a new"
    " hello when the network changes.",
    "packet.interval_declared": "A tick interval of {interval_us} µs does not fit the declared {rate_hz:hz~4};"
    " the interval is in microseconds.",
    "packet.mask_scale": "Channel mask {mask} has channels without a declared scale; send those as float32.",
    "packet.scale": "Counts need {field} in the hello; declare it or send float32.",
    "packet.magic": "The message does not start with BNP1: it is not a body-network packet.",
    "packet.reserved": "The reserved bytes 10 and 11 must be zero in version 1.",
    "packet.flags": "Flags {flags} have unknown bits; only bits 0 and 1 exist.",
    "packet.encoding": "Encoding {encoding} is unknown; use 0 (float32) or 1 (int16).",
    "packet.mask": "Channel mask {mask} is empty or has unknown bits; bits 0 to 7 exist.",
    "packet.sensors": "{sensors} sensors are not possible; send 1 to {most}.",
    "packet.ticks": "{ticks} ticks are not possible; send 1 to {most}.",
    "packet.interval": "A tick interval of {interval_us} µs is not possible; send {least_us} to {most_us} µs.",
    "packet.not_finite": "Tick {tick} of sensor {sensor} holds a value that is not finite. Send zeros in all"
    " channels for a sensor that gave nothing.",
    "packet.absurd": "Tick {tick} of sensor {sensor} holds a value above {limit}; send SI units.",
    "packet.sequence_reused": "This sequence number was used for another packet; after a restart, continue"
    " after the acknowledged `highest`.",
    "packet.sequence_jump": "The sequence number is {steps} ahead of the newest; count packets one by one.",
    "packet.time_later": "The device time {time_us} µs is later than that of a higher sequence number. If the"
    " device clock was reset, reconnect with a new hello.",
    "packet.time_before": "The device time {time_us} µs lies before the end of the packet before it. If the"
    " device clock was reset, reconnect with a new hello.",
    "packet.time_ahead": "The device time {time_us} µs is {gap_s:s} ahead of the packet before it. If the"
    " device clock was reset, reconnect with a new hello.",
    "packet.channels_missing": "Estimation needs gyroscope and accelerometer; set bits 0 and 1 of the channel"
    " mask.",
    "packet.too_long": "A packet of {size} bytes is too long; send at most {most}.",
    "packet.json_too_long": "A JSON message may have {limit_bytes:kib}; send binary packets.",
    "packet.not_understood": "The message is not valid: {faults}",
    "packet.nothing_right": "No valid message arrived for a long time; see docs/packet.md.",
}
