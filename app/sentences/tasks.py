"""English sentences of storage, long tasks and what analyses say of a session."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "stored.other_process": "Another process stores this session too; a session belongs to one server at a"
    " time.",
    "stored.already": "Some of these packets are stored already.",
    "stored.packet_encoding": "Packet encoding {encoding} is unknown; use 0 (float32) or 1 (counts).",
    "stored.packet_empty": "A packet needs at least one tick of at least one sensor.",
    "stored.packet_payload": "A payload of {size} bytes does not divide into {ticks} ticks.",
    "stored.packet_range": "Sequence or device time is out of range.",
    "stored.checksum": "Stored data is damaged (wrong checksum); restore it from a backup.",
    "stored.cut_off": "Stored data is cut off or damaged; restore it from a backup.",
    "stored.codec": "Stored data was written by a newer version of the service (codec {codec}); install that"
    " version.",
    "stored.length": "Stored data holds {found} bytes instead of {expected}; restore it from a backup.",
    "stored.undecodable": "Stored data cannot be decompressed; restore it from a backup.",
    "stored.layout": "Stored frames do not fit the layout of their result; restore them from a backup.",
    "stored.quota": "Your clinic has stored {used_bytes:gib.1} of signals; {limit_bytes:gib.1} are allowed."
    " Delete sessions that are no longer needed, or ask the operator of this service for more.",
    "stored.no_room": "This file of {size_bytes:mib.1} does not fit: your clinic has stored {used_bytes:mib.1}, and"
    " uploads may use {limit_bytes:mib.1}; the rest stays free for live sessions. Delete sessions that are no longer"
    " needed, or ask the operator of this service for more.",
    "stored.disk_reserve": "The disk of this service has no room for further files; the rest stays free for live"
    " sessions. Ask the operator of this service, and send the file again later.",
    "stored.not_open": "This session is not open for storing; open it first.",
    "stored.failed": "This session can no longer be stored. {reason}",
    "stored.stopping": "The service is stopping; send again to the next one.",
    "stored.behind": "Storage is behind; keep the packet and send it again.",
    "stored.not_encoded": "Its data cannot be encoded ({error}).",
    "stored.session_gone": "The session no longer exists.",
    "stored.refused": "The database refused its data.",
    "scaled.fenced": "Another worker holds these sessions by now; nothing of this one is stored any more.",
    "scaled.moving": "The session is moving to another machine; it goes on in a moment.",
    "scaled.mqtt_lost": "Messages were lost on the way; connect anew and send again what is missing.",
    "scaled.no_broker": "NATS cannot be reached: {reason}. Check TELEMOTION_NATS_URL and whether it runs.",
    "scaled.no_broker_right": "NATS does not let this process in: {reason}. Check the user and the password in"
    " TELEMOTION_NATS_URL, or the file that TELEMOTION_NATS_CREDENTIALS names.",
    "scaled.no_credentials": "{path} is no file of credentials for NATS: {reason}. It is a .creds file, or has the"
    " private NKEY of a user (SU...).",
    "scaled.no_nats_password": "TELEMOTION_NATS_URL and each address in TELEMOTION_NATS_EDGE_URL must name a user and a"
    " password, as in nats://edge-1:PASSWORD@host:4222.",
    "scaled.nats_user_name": "The name of a NATS user may have letters, digits, - and _, at most 40 of them.",
    "scaled.one_nats_user": "An edge must not have the user or the password of the workers: name users of their own in"
    " TELEMOTION_NATS_EDGE_URL.",
    "scaled.unread_packets": "This backup has packets that no worker had stored; restore it to PostgreSQL and NATS"
    " first.",
    "scaled.other_partitions": "This backup has {count:number} partitions; set TELEMOTION_PARTITIONS to that number.",
    "scaled.streams_not_empty": "The streams of NATS are not empty; name a NATS server that holds no sessions.",
    "scaled.no_gateways_here": "Gateways connect to an edge, not to a worker.",
    "service.no_process": "No process can be started at this moment; try again.",
    "limit.views": "Close one, or try again in a minute.",
    "limit.streams": "End a session, then connect again.",
    "limit.sockets": "Close one, then open this again.",
    "limit.uploads": "Wait until one has arrived, then send this again.",
    "limit.exports": "Wait until one is done, then ask again.",
    "limit.reached": "{what:limited} {scope:limit_scope}: at most {most} at once. {advice}",
    "limited.views": "Open 3D views",
    "limited.streams": "Streaming sensor boxes",
    "limited.sockets": "Open live views",
    "limited.uploads": "Uploads under way",
    "limited.exports": "Exports being made",
    "limit_scope.account": "for one account",
    "limit_scope.clinic": "in your clinic",
    "limit_scope.service": "on this service",
    "progress.reading_walk": "Reading the walk",
    "progress.estimating": "Estimating the movement",
    "progress.smoothing": "Estimating the movement, forward and backward",
    "progress.feet": "Following the feet",
    "progress.forces": "Forces and balance",
    "progress.comparing": "Comparing with the template",
    "session.not_calibrated_because": "Not calibrated, so there are no joint angles. {reason}",
    "session.no_pose": "Not calibrated, so there are no joint angles: no calibration pose was recorded.",
    "session.pose_found": "Calibration pose found in the recording.",
    "session.pose_outside": "The pose from {start_s:s.1} to {end_s:s.1} is not in the recording.",
    "session.nothing_to_estimate": "The session holds no packets that can be analysed.",
    "session.headings_left_out": "The directions set at {time_s:s} were not used. {reason}",
    "slip.turned": "The sensor on the {where:place|or} seems to have turned in its strap at {at}, by about"
    " {angle_rad:deg}. The angles of {joints:joint|and} after that are not reliable. Fasten the sensor and"
    " calibrate again.",
    "mass_centre.sensors": "The centre of mass needs sensors on both thighs and on the chest or the pelvis.",
    "series.other_kind": "The sensors of this kind of session do not measure this.",
    "series.unknown": "No session has {names:and}; there are {known:and}.",
    "walk.no_forces": "There are no forces. {reason}",
    "walk.no_forces_from": "There are no forces: no usable data came from the {places:place}.",
    "walk.no_forces_together": "There are no forces: the four load cells never measured at the same time.",
    "walk.forces_partly": "Forces are known from {start_s:s.1} to {end_s:s.1} only: at {lost_s:s.1} no usable"
    " data came from the {places:place}.",
    "walk.feet_unrelated": "The positions of the feet relative to each other are not known. {reason}",
    "bench.no_sensor": "The session has no sensor on the {place:place}.",
    "bench.too_long": "This session is longer than an hour, the most for a calibration on the bench.",
    "bench.no_coils": "The packets of this session have no coil states or no magnetometer (bits 6 and 2).",
    "bench.places": "The sensor lay still at {stops} places ({times:and}), but {places} were given. Give one"
    " for each, and leave out movements between them.",
    "bench.time": "{start_s:number} to {end_s:s}",
    "bench.no_stop": "none",
    "bench.no_fit": "The coils could not be found. {reason}",
    "bench.singular": "The places do not determine them.",
    "bench.weak": "These places determine the field only to ±{sigma:percent}. Lay the sensor at more places"
    " and nearer: 10 to 25 cm from the middle, on every side.",
}
