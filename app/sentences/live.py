"""English sentences of live sessions and the 3D view."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "live.behind": "The estimation is behind; wait a moment.",
    "live.record_first": "Recording starts when the session is ready: connected and calibrated.",
    "live.not_recording": "Nothing is being recorded.",
    "live.recording_stopped": "Recording stopped.",
    "live.estimation_failed": "The live estimation failed. What the sensors send is stored and can be analysed"
    " afterwards.",
    "live.ticket_message": "The first message must be a JSON object with the field ticket.",
    "live.full": "As many sessions are live as this machine carries without delay. The sensors connect by themselves"
    " when another one ends.",
    "live.preparing": "The service is being prepared for this kind of session, which takes up to a minute"
    " after an installation or an update. The sensors connect by themselves when it is done.",
    "live.no_sensor_of_limb": "No sensor is worn on that limb; choose another.",
    "live.calibration_done": "{kind:calibration_kind} done, score {score:points} of 100.",
    "live.directions_left": "The directions of the {places:place} must still be set.",
    "live.of_sensor": "{place:place}. {what}",
    "live.turned_too_far": "The turn about {axis} was {excess_rad:deg} more than a whole one. Mark where you"
    " begin, and turn it once more by exactly one turn. If it was exact, turn it again: two turns that agree"
    " are accepted.",
    "live.turned_too_little": "The turn about {axis} was {missing_rad:deg} less than a whole one. Mark where"
    " you begin, and turn it once more by exactly one turn. If it was exact, turn it again: two turns that"
    " agree are accepted.",
    "calibration_kind.static_bias": "Gyroscope zero",
    "calibration_kind.six_position": "Six positions",
    "calibration_kind.magnetometer": "Compass",
    "calibration_kind.n_pose": "Standing pose",
    "calibration_kind.t_pose": "T-pose",
    "calibration_kind.functional": "Calibration by movement",
    "calibration_kind.passive": "Seated calibration",
    "calibration_kind.heading_reset": "Setting the directions",
    "source_trouble.missing": "Pulses that were asked for do not come; check that the source is switched on.",
    "source_trouble.fault": "The pulses fit no position; check the numbers of the coils and which module is"
    " where.",
    "source_trouble.disturbed": "Iron or another magnet is near; move away from it.",
    "source_trouble.saturated": "The magnetometer is at its limit: the sensor is too close to a coil.",
    "source_trouble.alone": "The source is not used; the uncertainty grows.",
    "source_trouble.wiring": "Coils fire that the source does not have; check their numbers, and which module"
    " is the source.",
    "source_trouble.over": "The source is used again.",
    "viewer.command_too_long": "A command is at most 2 kB of JSON.",
    "viewer.command": "Send `player` or `camera` commands as JSON; see the interface.",
    "viewer.no_guard": "The 3D view cannot be protected with this version of viser; install viser 1.1.",
    "viewer.version": "The 3D view does not know the page of this version of viser; install viser 1.1.",
    "viewer.protocol": "The page and the 3D view have different versions ({version}); reload the page.",
    "viewer.no_signal": "{place:place}: no signal",
    "viewer.source": "{place:place}: source",
    "viewer.sensor": "{place:place}",
    "viewer.silent": "No data from the sensors",
    "viewer.distance": "{place:place}: {distance_m:cm}",
    "viewer.distance_about": "{place:place}: about {distance_m:cm}",
    "viewer.not_ready": "The 3D view is not ready; try again.",
    "live.connected_calibrate": "Connected; calibrate when the patient holds the pose.",
    "live.connected_directions": "Connected. The sensor positions are saved from last time; set the directions"
    " before anything is measured.",
    "live.source_allowed": "The source may fire.",
    "live.gap": "{missing_s:s.2} of data is missing.",
    "live.state": "The session cannot go from “{state:state}” to “{following:state}”.",
    "live.stray_source": "A magnetic source fires in this session, which has none; its pulses are not used,"
    " and nobody was asked about implants. Switch it off, or create a session with a magnetic source.",
    "live.force_lost": "No data from the load cells of the {side:side} shoe.",
    "live.force_implausible": "The load cell readings of the {side:side} shoe are implausible; check the load"
    " cells.",
    "live.force_back": "The load cells of the {side:side} shoe measure again.",
    "state.created": "created",
    "state.calibrating": "calibrating",
    "state.ready": "ready",
    "state.recording": "recording",
    "state.link_lost": "signal lost",
    "state.closing": "closing",
    "state.analysed": "analysed",
    "state.failed": "failed",
    "viewer.not_found": "This 3D view no longer exists; open the session again.",
    "viewer.markers_live": "Markers are shown only in a replay.",
    "viewer.session_ended": "This session has ended; open a replay instead.",
    "live.closed_idle": "Ended automatically: no data arrived for ten minutes.",
    "live.closed_long": "Ended automatically: the session reached the longest time allowed. Create another"
    " session to continue.",
    "live.closed_incomplete": "Ended: the gateway stopped sending, and some data never arrived.",
    "live.no_packet": "No data from the sensors for {silence_s:s}.",
    "live.all_sent": "The gateway has sent everything.",
    "live.closed_by_person": "Session ended.",
    "live.token_expired": "The device token was revoked or has expired.",
    "live.account_inactive": "This account is no longer active.",
    "live.ticket_first": "Sign in, or send a ticket as the first message.",
    "live.stopping": "The service is stopping; connect again.",
    "live.not_closed": "The session could not be ended properly; what is stored is safe. Analyse it again.",
    "live.stopped": "The service was stopped.",
    "live.closed": "This session has ended; create another one.",
    "live.superseded": "A newer connection has taken over this session.",
    "live.connection_ended": "The connection to the gateway ended.",
    "live.not_connected": "No sensors are connected to this session; start the gateway first.",
    "live.network_changed": "This session began with other sensors (placements, rate, scales or clip levels);"
    " connect with the same ones, or end it and create another session.",
    "live.other_placements": "The sensors of the gateway are not those of the session ({places:place}); create"
    " the session for the sensors that are worn.",
    "live.cannot_calibrate": "Calibration needs connected sensors and no running recording; stop the recording"
    " or connect first.",
    "live.unknown_mark": "This kind of session has no mark {label}; use {known:or}.",
    "live.walk_uncalibrated": "A walk needs no calibration; stand still for three seconds and walk.",
    "live.magnetic_uncalibrated": "A magnetic session needs no calibration pose; stand still for three"
    " seconds.",
    "live.calibration_cancelled": "The calibration was cancelled.",
    "live.connected": "Connected.",
    "live.sends_nothing": "No data from: {sensors:place}. Check that every sensor is on and near.",
    "live.moved": "Hold still: the {sensors:place} moved.",
    "live.not_evaluated": "This calibration could not be evaluated; the earlier one remains valid. Repeat it.",
    "live.still_evaluating": "The last calibration is being evaluated; wait a moment.",
    "live.no_step": "No calibration is waiting for a step; start one.",
    "live.step_ends_itself": "This step ends by itself; follow the instruction.",
    "live.functional_sensors": "Calibration by movement needs sensors on upper arm and forearm of the same"
    " side.",
    "live.movement_not_ended": "The movement was never ended; start again and press “Done, next” after each movement.",
    "live.rest_ends_itself": "This step ends by itself; hold still.",
    "live.movement_too_short": "Make the movement three times first; it takes at least {least_s:s}.",
    "live.too_long": "It took longer than ten minutes; start again.",
    "live.no_magnetometer": "These sensors have no magnetometer, or the gateway does not send it.",
    "live.pose": "Stand upright, arms hanging, palms to the thighs, and hold still.",
    "live.never_still": "The patient was never still for {hold_s:s}; start again when ready.",
    "live.good_still": "Good, hold still.",
    "live.gap_hold": "Data was missing for a moment; hold still.",
    "live.settling": "Hold still; the sensors are settling.",
    "live.calibration_stays": "The earlier calibration remains valid. {reason}",
    "live.calibrated": "Calibrated, score {score:points} of 100.",
    "live.restarted": "The service was restarted.",
    "live.source_not_stopped": "The magnetic source fires although it was stopped. Switch it off by hand.",
}

__all__ = ["ENGLISH"]
