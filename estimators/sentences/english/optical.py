"""English sentences of markers that are fused with a sensor."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "markers.contradict": "The markers contradict this sensor. {wrong:lines}",
    "markers.mirrored": "They are a mirror image of what the sensor measured: the columns {one} and z are exchanged,"
    " or one has the wrong sign. Write x, y and z right-handed.",
    "markers.mirrored_columns": "They are a mirror image of what the sensor measured: two columns are exchanged, or"
    " one has the wrong sign. Write x, y and z right-handed.",
    "markers.up": "Their axis {up} points up, not z: choose {up} as the axis that points up.",
    "markers.up_mirrored": "Their axis {up} points up, not z.",
    "markers.scale": "Their lengths are {scale:number~3} ± {sigma:number~1} times those that the sensor measured."
    " Check the unit of the file.",
    "markers.shut_out": "{share:percent} of the frames contradict this sensor; at most {most:percent} may be ghosts."
    " Choose the sensor that wore the marker, and check that file and session are of the same recording.",
    "markers.far": "The marker would be {distance_m:m.2} away from its sensor, more than a body segment allows."
    " Choose the sensor that wore the marker, and check that file and session are of the same recording; or measure"
    " the distance and enter it.",
    "markers.residual": "{residual_m:mm} are left between markers and sensor, which no sensor explains. Choose the"
    " sensor that wore the marker, and check that file and session are of the same recording.",
    "markers.short": "The recording of the sensor is too short for its markers.",
    "markers.few_frames": "The marker was seen in fewer than ten frames beside the sensor.",
    "markers.seen_short": "The marker was seen for less than {least_s:s} beside the sensor.",
    "markers.moved_little": "The marker moved too little to measure the direction of the sensor. Move it briskly to"
    " and fro for some seconds.",
    "markers.unexplained": "The markers do not fit this sensor: it explains {explained:percent} of their"
    " acceleration. Choose the sensor that wore the marker.",
    "markers.no_correlation": "The markers do not fit this sensor: best correlation {correlation:number.2},"
    " elsewhere {rival:number.2}. Choose the sensor that wore the marker, or record some irregular movement.",
    "markers.little_overlap": "Markers and sensor share too little time or movement. Record a few seconds of lively"
    " movement.",
    "markers.rate_needs_three": "An angular rate needs three markers on one body. Align with one marker by its"
    " acceleration.",
    "markers.none_inside": "No marker falls into the recording of the sensor.",
    "markers.stretch": "{reason} (From {start_s:s.1} to {stop_s:s.1}.)",
    "markers.short_stretch": "Less than {least_s:s} of samples in a row.",
    "markers.six_frames": "Six frames in a row of the marker are needed to begin.",
    "markers.walk": "Markers after gaps fit only when offsets of the sensor may change {times:number~3} times as"
    " fast.",
    "markers.bridged": {
        "one": "{lost_s:s.2} of the sensor's samples, in one piece, were lost on the way and interpolated. They"
        " count with raised noise.",
        "other": "{lost_s:s.2} of the sensor's samples, in {count:number} pieces, were lost on the way and"
        " interpolated. They count with raised noise.",
    },
    "markers.uneven": "Markers and sensor each need at least ten samples at increasing times.",
}
