"""English sentences of sessions, their results and tasks."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "job.analysis_failed": "Analysis failed. {reason}",
    "job.internal": "An internal error stopped this task and was logged. The recorded data is stored.",
    "job.unknown_kind": "This service cannot do tasks of the kind {kind}.",
    "job.memory": "This needs more memory than the {limit_bytes:gib.1} that one task may take. Split the"
    " recording and upload the parts.",
    "job.interrupted": "Interrupted; the task starts again.",
    "job.given_up": "The task was interrupted several times and is not tried again; the recorded data is"
    " stored.",
    "job.session_deleted": "The session of this task was deleted.",
    "magnetic.withdrawn": "The safety confirmation for the magnetic source was withdrawn; the source may not"
    " fire until a therapist confirms again that nobody near it has an implant.",
    "magnetic.expired": "The safety confirmation for the magnetic source has expired; a therapist must confirm"
    " again that nobody near it has an implant before the source may fire.",
    "magnetic.not_confirmed": "This session has a magnetic source: before it can start, a therapist must"
    " confirm that neither the patient nor people nearby have a pacemaker or a similar implant.",
    "magnetic.event_confirmed": "Safety confirmed: no implants.",
    "magnetic.event_withdrawn": "Safety confirmation withdrawn; the source may not fire.",
    "result.no_frames": "This result holds no movement data; analyse the session first.",
    "session.not_found": "Session not found, or not shared with you.",
    "session.other_prescription": "The prescription does not belong to this patient.",
    "session.other_exercise": "The exercise is not the one that was prescribed.",
    "result.not_yet": "This session has no result yet; wait until its analysis is finished.",
    "result.not_found": "This session has no such result.",
    "job.not_found": "Task not found.",
    "session.delete_live": "This session is live; end it before deleting it.",
    "session.move_live": "A session is live or being analysed; wait until that has ended, then move it.",
    "session.move_template": "The patient's own template “{name}” was made from this session: it would show"
    " somebody else's movement. Retire the template and record another one first.",
    "session.nothing_to_move": "Choose another patient or another exercise.",
    "session.reason_needed": "Write why.",
    "session.moved": "Moved here from another patient's record. {reason}",
    "session.exercise_changed": "The exercise of this session was changed. {reason}",
    "source.not_found": "Magnetic source not found in your clinic.",
    "session.no_samples": "This session holds no samples.",
    "markers.limit": "This session holds as many marker files as it may ({limit_bytes:mib}).",
    "source.impossible": "These values do not describe a source that can be worn. {reason}",
    "magnetic.warning": "The source makes magnetic pulses. Nobody with a pacemaker, an implanted"
    " defibrillator, a nerve stimulator, a cochlear implant or a medicine pump may wear it or be close to it"
    " while it is worn.",
    "markers.none": "This session has no fused markers yet.",
    "markers.too_long": "Ask for at most {longest_s:s} of the recording.",
    "markers.not_closed": "Markers can be added only to a session that has ended and is analysed.",
    "markers.no_such_sensor": "This session has no sensor on the {place:place}; it has {sent:place}.",
    "markers.gone": "The uploaded markers no longer exist; upload them again.",
    "magnetic.nothing_to_confirm": "This session has no magnetic source; there is nothing to confirm.",
    "magnetic.nothing_to_withdraw": "This session has no magnetic source; there is nothing to withdraw.",
    "magnetic.not_confirmed_yet": "No safety confirmation exists for this session; the source may not fire.",
    "source.not_allowed": "Only staff of the clinic can manage its magnetic sources.",
    "magnetic.no_source": "This session has no magnetic source.",
    "session.not_finished": "This session is not finished; wait until it is analysed.",
    "magnetic.result_of_walk": "This result is of the walk; choose one of the magnetic source.",
    "result.not_complete": "A result that is not complete cannot be compared; wait until it is.",
    "walk.one_estimator": "A walk has one estimator, which has run already; there is no other to choose.",
    "magnetic.one_estimator": "A session with a magnetic source has one estimator, which has run already.",
    "session.no_packets": "This session holds no data: no sensor box ever connected.",
    "session.no_sensor": "The session has no sensor on the {places:place}.",
    "result.no_sequence": "There is no rotation sequence {sequence}.",
    "session.parameter_type": "A parameter of the estimator has a value of the wrong type.",
    "session.offline_estimator": "{wanted} needs the whole session. Record with {live}; {wanted} follows"
    " when the session ends.",
    "magnetic.only_magnetic": "Only a magnetic session has a source.",
    "session.no_estimator": "There is no estimator {unknown:or}; choose {known:or}.",
    "walk.in_both": "A walk is in both conditions; choose different ones.",
    "walk.not_analysed": "A chosen session is not an analysed walk of this patient.",
    "balance.eyes_open_firm": "Eyes open, firm ground",
    "balance.eyes_closed_firm": "Eyes closed, firm ground",
    "balance.eyes_open_foam": "Eyes open, foam",
    "balance.eyes_closed_foam": "Eyes closed, foam",
    "balance.reach": "Reaching forward",
    "balance.rest": "End of the test",
    "balance.no_test": "This session is not a balance test; record one with sensors on pelvis and chest.",
    "balance.nothing_marked": "Nothing was marked while it was recorded: all of it counts as one test of standing.",
    "balance.too_short": "Too short: {shortest_s:s} or more without a gap are needed.",
    "balance.one_link": "Displacement is that of the hips, {height_m:m.2} above the ankles, if the body moves as one"
    " stiff link on the ankles; who bends at the hips moves less than shown.",
    "walk.no_walk": "This session is not a walk; record or upload one with sensors on the feet.",
    "walk.no_strides": "This result has no strides: a live result has none, and an analysis may still be"
    " running.",
    "result.no_movement": "This result holds no movement yet; wait until its analysis is finished.",
    "session.analysed": "Analysed.",
}
