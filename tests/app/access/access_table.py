"""Every route of the service and who may use it. A route without a line here fails `test_access_matrix`.

`{name}` in paths and bodies stands for Ada's thing of that name in the seed (`patient_id`, `session_id`,
...); `{foreign:name}` for Carl's.
"""

from dataclasses import dataclass, field
from typing import Any, Literal

from tests.app.conftest import PASSWORD

READ = frozenset({"therapist", "reader", "patient", "administrator"})
STATUS = READ | {"device"}
RECORD = frozenset({"therapist", "patient", "device"})
TREAT = frozenset({"therapist"})
MANAGE = frozenset({"therapist", "administrator"})
OWN_OR_MANAGE = MANAGE | {"patient"}

INSIDERS = ("therapist", "reader", "patient", "administrator", "device")
"""Everybody who has some right to Ada's data."""

OUTSIDERS = (
    "nobody",
    "other_patient",
    "foreign_therapist",
    "foreign_administrator",
    "colleague",
    "former",
    "expired",
    "integrator",
    "other_device",
    "foreign_device",
    "revoked_device",
    "forged_cookie",
)
"""Everybody who has none."""

WITHOUT_SIGN_IN = frozenset({"nobody", "revoked_device", "forged_cookie"})
DEVICES = frozenset({"device", "other_device", "foreign_device"})

Kind = Literal["public", "signed_in", "clinic", "list", "patient", "role", "device", "socket"]


@dataclass(frozen=True)
class Line:
    """One request and who may make it.

    Attributes
    ----------
    kind : str
        `patient`: Ada's data; outsiders get 404 as if it did not exist, insiders without the level 403.
        `clinic`: data of clinic A; other clinics get 404. `list`: answers everybody who is signed in, with
        what is theirs. `signed_in`: the same for everybody who is signed in. `role`: decided by the role
        alone. `device`: any device token, about its own patient only. `socket`: see the test of sockets.
        `public`: anybody.
    allowed : frozenset of str
        Who of the insiders may, for `patient` and `role`.
    status : int
        What an allowed subject gets: below 300, or a refusal that comes after the access check.
    """

    method: str
    path: str
    kind: Kind
    allowed: frozenset[str] = frozenset()
    body: Any = None
    query: dict[str, str] = field(default_factory=dict)
    status: int = 200
    files: bool = False
    prepare: str | None = None
    note: str = ""

    @property
    def name(self) -> str:
        """A readable identifier."""
        return f"{self.method} {self.path}{' ' + self.note if self.note else ''}"


def patient(method: str, path: str, allowed: frozenset[str], **more: Any) -> Line:
    """Return a line of the kind `patient`."""
    return Line(method, path, "patient", allowed, **more)


PATIENT = {"given_name": "New", "family_name": "Person"}
ACCOUNT = {"email": "n@e.example", "display_name": "N", "role": "therapist", "password": "long enough one"}
DRAWN = {"based_on": "{version_id}", "design": {}, "reason": "narrower"}
EXERCISE = {
    "name": "New",
    "movement": "flexion",
    "primary_angle": "humerus_forearm_right_zxy_flexion",
}
SESSION = {"patient_id": "{patient_id}", "placements": ["upper_arm_right", "forearm_right"]}
SOURCE = {
    "name": "Belt",
    "serial": "S-1",
    "gain_sigma": 0.005,
    "coils": [
        {"turns": 50.0, "radius_m": 0.055, "centre_m": [0.06, 0, 0], "axis": [1, 0, 0]},
        {"turns": 50.0, "radius_m": 0.055, "centre_m": [0, 0.06, 0], "axis": [0, 1, 0]},
        {"turns": 50.0, "radius_m": 0.055, "centre_m": [0, 0, 0.06], "axis": [0, 0, 1]},
    ],
}
UPLOAD = {"patient_id": "{patient_id}", "format": "packet_log"}

LINES: tuple[Line, ...] = (
    # --- service ---
    Line("GET", "/api/health", "public"),
    Line("GET", "/api/ready", "public"),
    Line("GET", "/{path:path}", "public"),
    Line("GET", "/api/openapi.json", "signed_in"),
    Line("GET", "/api/docs", "signed_in"),
    Line("GET", "/api/accuracy", "signed_in"),
    Line("GET", "/api/demonstration", "signed_in"),
    # --- accounts ---
    Line("POST", "/api/sign-in", "public", body={"email": "a@b.example", "password": "x"}),
    Line("POST", "/api/sign-out", "signed_in", status=204, note="(cookies only)"),
    Line("GET", "/api/me", "signed_in", note="(cookies only)"),
    Line("PATCH", "/api/me", "signed_in", body={"locale": ""}, status=204, note="(cookies only)"),
    Line("GET", "/api/clinic", "list"),
    Line("PATCH", "/api/clinic", "role", frozenset({"administrator"}), body={"time_zone": "Europe/Oslo"}),
    Line("GET", "/api/accounts", "list"),
    Line("POST", "/api/accounts", "role", frozenset({"administrator"}), body=ACCOUNT, status=201),
    patient(
        "POST",
        "/api/accounts",
        frozenset({"administrator"}),
        body=ACCOUNT | {"role": "patient", "patient_id": "{patient_id}"},
        status=201,
        note="for a patient",
    ),
    Line(
        "POST",
        "/api/me/password",
        "signed_in",
        body={"old_password": PASSWORD, "new_password": "quite another password"},
        status=204,
        note="(cookies only)",
    ),
    Line("GET", "/api/me/second-factor", "signed_in", note="(cookies only)"),
    Line(
        "POST",
        "/api/me/second-factor",
        "signed_in",
        body={"password": PASSWORD},
        note="(cookies only)",
    ),
    Line(
        "POST",
        "/api/me/second-factor/confirm",
        "signed_in",
        body={"code": "000000"},
        status=409,
        note="(cookies only)",
    ),
    Line("POST", "/api/me/second-factor/noted", "signed_in", status=204, note="(cookies only)"),
    Line(
        "POST",
        "/api/me/second-factor/remove",
        "signed_in",
        body={"password": PASSWORD},
        status=204,
        note="(cookies only)",
    ),
    patient(
        "PATCH",
        "/api/accounts/{account_id}",
        frozenset({"administrator"}),
        body={"is_active": False},
    ),
    # --- patients ---
    Line("GET", "/api/caseload", "list"),
    Line("GET", "/api/patients", "list"),
    Line("POST", "/api/patients", "role", MANAGE | {"reader"}, body=PATIENT, status=201),
    patient("GET", "/api/patients/{patient_id}", READ),
    patient("PATCH", "/api/patients/{patient_id}", MANAGE, body={"notes": "changed"}),
    patient("PATCH", "/api/patients/{patient_id}", MANAGE, body={"is_archived": True}, note="archive"),
    patient(
        "DELETE",
        "/api/patients/{patient_id}",
        frozenset({"administrator"}),
        body={"confirmation": "ERASE"},
        status=204,
        prepare="archive",
    ),
    patient("GET", "/api/patients/{patient_id}/export", READ),
    patient("GET", "/api/patients/{patient_id}/worries", READ),
    patient(
        "POST",
        "/api/patients/{patient_id}/worries/seen",
        TREAT,
        body={
            "worries": [{"session_id": "{session_id}", "kind": "pain", "known_at": "2026-01-01T00:00:00Z"}]
        },
        status=404,
        note="of a session without pain",
    ),
    patient("GET", "/api/patients/{patient_id}/progress", READ),
    patient("GET", "/api/patients/{patient_id}/course", READ, query={"exercise_id": "{exercise_id}"}),
    patient(
        "POST",
        "/api/patients/{patient_id}/course-notes",
        TREAT,
        body={"exercise_id": "{exercise_id}", "text": "Reaches further."},
        status=201,
    ),
    patient("GET", "/api/patients/{patient_id}/grants", READ),
    patient(
        "POST",
        "/api/patients/{patient_id}/grants",
        MANAGE,
        body={"account_id": "{account:colleague}"},
        status=201,
    ),
    patient("DELETE", "/api/grants/{grant_id}", MANAGE, status=204),
    patient("GET", "/api/patients/{patient_id}/audit", READ),
    patient("GET", "/api/patients/{patient_id}/device-tokens", OWN_OR_MANAGE),
    patient(
        "POST",
        "/api/patients/{patient_id}/device-tokens",
        OWN_OR_MANAGE,
        body={"label": "phone"},
        status=201,
    ),
    patient(
        "POST",
        "/api/patients/{patient_id}/pairing-codes",
        OWN_OR_MANAGE,
        body={"label": "tablet"},
        status=201,
    ),
    # What it takes is the code.
    Line("POST", "/api/devices/pair", "public", body={"code": "2345 6789"}, status=401),
    patient("DELETE", "/api/device-tokens/{token_id}", OWN_OR_MANAGE, status=204),
    patient("GET", "/api/patients/{patient_id}/consents", READ),
    patient(
        "PUT",
        "/api/patients/{patient_id}/consents",
        OWN_OR_MANAGE,
        body={"purpose": "research", "granted": True},
    ),
    patient(
        "POST",
        "/api/patients/{patient_id}/merge",
        TREAT,
        body={"other_id": "{patient_id}", "reason": "entered twice"},
        status=422,
    ),
    # --- exercises ---
    Line("GET", "/api/exercises", "list"),
    Line("POST", "/api/exercises", "role", MANAGE | {"reader"}, body=EXERCISE, status=201),
    Line("GET", "/api/exercises/{exercise_id}", "clinic"),
    Line("PATCH", "/api/exercises/{exercise_id}", "role", MANAGE | {"reader"}, body={"posture": "seated"}),
    patient("GET", "/api/patients/{patient_id}/prescriptions", READ),
    patient(
        "POST",
        "/api/patients/{patient_id}/prescriptions",
        TREAT,
        body={"exercise_id": "{exercise_id}", "template_id": "{template_id}"},
        status=201,
    ),
    patient("PATCH", "/api/prescriptions/{prescription_id}", TREAT, body={"number": 1, "sets": 2}),
    patient("DELETE", "/api/prescriptions/{prescription_id}", TREAT, status=204),
    # --- sessions ---
    patient("POST", "/api/sessions", RECORD, body=SESSION, status=201),
    patient(
        "POST", "/api/sessions", TREAT, body=SESSION | {"purpose": "template"}, status=201, note="template"
    ),
    patient("GET", "/api/patients/{patient_id}/sessions", READ),
    patient("GET", "/api/sessions/{session_id}", READ),
    patient("DELETE", "/api/sessions/{session_id}", TREAT, status=204),
    patient(
        "PATCH",
        "/api/sessions/{session_id}",
        TREAT,
        body={"exercise_id": "{exercise_id}", "reason": "mistaken"},
        status=422,
    ),
    patient("GET", "/api/sessions/{session_id}/raw", READ),
    patient("POST", "/api/sessions/{session_id}/reprocess", TREAT, body={"orientation": "vqf"}, status=202),
    patient(
        "GET",
        "/api/sessions/{session_id}/sequences",
        READ,
        query={"joint": "humerus_forearm", "side": "right", "sequence": "zxy"},
    ),
    patient("POST", "/api/sessions/{session_id}/reprocess-all", TREAT, body={}, status=202),
    patient(
        "GET",
        "/api/sessions/{session_id}/results/differences",
        READ,
        query={"result_a": "{result_id}", "result_b": "{result_id}"},
    ),
    # Ada's session moves an arm: who may read it learns that it is no balance test and no walk.
    patient("GET", "/api/sessions/{session_id}/balance", READ, status=409),
    patient("GET", "/api/sessions/{session_id}/gait", READ, status=409),
    patient("GET", "/api/sessions/{session_id}/gait/curves", READ, status=409),
    patient("GET", "/api/sessions/{session_id}/gait/strides", READ, status=409),
    patient("GET", "/api/patients/{patient_id}/walks", READ),
    # The same session twice: who may read Ada learns that.
    patient(
        "POST",
        "/api/patients/{patient_id}/walks/comparison",
        READ,
        body={"a": ["{session_id}"], "b": ["{session_id}"]},
        status=422,
    ),
    # Nor has it a magnetic source.
    patient("GET", "/api/sessions/{session_id}/magnetic-safety", READ),
    patient(
        "POST",
        "/api/sessions/{session_id}/magnetic-safety",
        TREAT,
        body={"patient_has_no_implant": True, "people_nearby_have_none": True},
        status=409,
    ),
    patient("DELETE", "/api/sessions/{session_id}/magnetic-safety", TREAT, status=409),
    patient("GET", "/api/sessions/{session_id}/source-use", READ, status=409),
    patient("GET", "/api/sessions/{session_id}/source-stops", TREAT, status=409),
    patient(
        "POST",
        "/api/sessions/{session_id}/source-calibration",
        TREAT,
        body={"name": "Belt", "serial": "S-1", "positions_m": [[0.3, 0, 0]] * 6},
        status=409,
    ),
    Line("GET", "/api/magnetic-sources", "role", MANAGE | {"reader"}),
    Line("POST", "/api/magnetic-sources", "role", MANAGE | {"reader"}, body=SOURCE, status=201),
    Line("DELETE", "/api/magnetic-sources/{source_id}", "role", MANAGE | {"reader"}, status=204),
    patient("GET", "/api/sessions/{session_id}/jobs", STATUS),
    patient("GET", "/api/jobs/{job_id}", STATUS),
    patient("GET", "/api/sessions/{session_id}/frames", READ),
    patient("GET", "/api/sessions/{session_id}/layout", READ),
    patient("GET", "/api/sessions/{session_id}/series", READ, query={"names": "arm_points"}),
    patient(
        "POST",
        "/api/sessions/{session_id}/markers",
        TREAT,
        body={"segment": "forearm_right", "format": "c3d"},
        files=True,
        status=422,
        note="(the file of the seed holds none)",
    ),
    patient("GET", "/api/sessions/{session_id}/markers", READ),
    patient("GET", "/api/sessions/{session_id}/markers/motion", READ, status=404),
    patient("GET", "/api/sessions/{session_id}/markers/motion/stretch", READ, status=404),
    patient("POST", "/api/uploads", RECORD, body=UPLOAD, files=True, status=202),
    Line(
        "POST",
        "/api/uploads/preview",
        "signed_in",
        body={"file_name": "table.csv", "beginning": "dCxneXJfeAowLDEKMSwyCg=="},
    ),
    Line("GET", "/api/uploads/formats", "signed_in"),
    Line("GET", "/api/estimators", "signed_in"),
    # --- live ---
    patient("POST", "/api/sessions/{session_id}/ticket", READ, body={"purpose": "live"}),
    patient("POST", "/api/sessions/{session_id}/ticket", RECORD, body={"purpose": "ingest"}, note="ingest"),
    patient("POST", "/api/sessions/{session_id}/calibrate", RECORD, status=409),
    patient("POST", "/api/sessions/{session_id}/record", RECORD, status=409),
    patient("POST", "/api/sessions/{session_id}/stop", RECORD, status=409),
    Line("GET", "/api/calibrations", "signed_in"),
    patient(
        "POST", "/api/sessions/{session_id}/calibration/start", RECORD, body={"kind": "n_pose"}, status=409
    ),
    patient("GET", "/api/sessions/{session_id}/calibration", READ, status=409),
    patient("POST", "/api/sessions/{session_id}/calibration/next", RECORD, status=409),
    patient("POST", "/api/sessions/{session_id}/calibration/cancel", RECORD, status=409),
    patient("POST", "/api/sessions/{session_id}/mark", RECORD, body={"text": "here"}, status=409),
    patient("GET", "/api/sessions/{session_id}/answers", READ),
    patient("PUT", "/api/sessions/{session_id}/answers", RECORD, body={"pain": 2, "effort": 4}),
    patient("GET", "/api/sessions/{session_id}/guidance", READ, status=409),
    patient("POST", "/api/sessions/{session_id}/guidance", RECORD, body={"command": "pain"}, status=409),
    patient("POST", "/api/sessions/{session_id}/close", RECORD),
    patient("POST", "/api/sessions/{session_id}/reopen", RECORD, status=409),
    patient("GET", "/api/sessions/{session_id}/state", STATUS),
    # Ada's sessions are over: her devices learn that there is none to join.
    Line("POST", "/api/devices/next-session", "device", status=404),
    Line("WS", "/ws/live/{session_id}", "socket", READ),
    Line("WS", "/ws/ingest", "socket"),
    # --- templates and comparisons ---
    Line("GET", "/api/templates", "list"),
    patient("GET", "/api/templates", READ, query={"patient_id": "{patient_id}"}, note="of a patient"),
    patient("POST", "/api/templates/preview", TREAT, body={"session_id": "{session_id}"}),
    patient(
        "POST",
        "/api/templates",
        TREAT,
        body={
            "session_id": "{session_id}",
            "exercise_id": "{exercise_id}",
            "patient_id": "{patient_id}",
            "name": "New",
        },
        status=201,
    ),
    patient("GET", "/api/template-versions/{version_id}", READ),
    patient("POST", "/api/templates/{template_id}/versions", TREAT, body=DRAWN, status=201),
    patient(
        "PATCH", "/api/templates/{template_id}/entry", TREAT, body={"tags": ["arm"], "is_retired": False}
    ),
    patient(
        "POST",
        "/api/template-versions/{version_id}/copies",
        TREAT,
        body={
            "patient_id": "{patient_id}",
            "name": "Left",
            "reason": "other arm",
        },
        status=201,
    ),
    patient("GET", "/api/sessions/{session_id}/comparisons", READ),
    patient(
        "POST",
        "/api/sessions/{session_id}/comparisons",
        TREAT,
        body={"template_version_id": "{version_id}"},
        status=201,
    ),
    patient("GET", "/api/comparisons/{comparison_id}", READ),
    # --- views ---
    patient("POST", "/api/sessions/{session_id}/views", READ, body={"mode": "replay"}, status=201),
    patient(
        "GET",
        "/viewer/{view_id}/",
        frozenset({"therapist"}),
        prepare="view",
        note="(of the account that opened it)",
    ),
    Line("WS", "/viewer/{view_id}", "socket", frozenset({"therapist"}), prepare="view"),
    Line("WS", "/ws/views/{view_id}", "socket", frozenset({"therapist"}), prepare="view"),
)

CROSS: tuple[Line, ...] = (
    # Carl's therapist, with every right to Carl, puts Ada's things into requests about Carl.
    Line(
        "POST",
        "/api/patients/{foreign:patient_id}/prescriptions",
        "patient",
        body={"exercise_id": "{exercise_id}"},
    ),
    Line(
        "POST",
        "/api/patients/{foreign:patient_id}/prescriptions",
        "patient",
        body={"exercise_id": "{foreign:exercise_id}", "template_id": "{template_id}"},
        note="template",
    ),
    Line(
        "POST",
        "/api/patients/{foreign:patient_id}/grants",
        "patient",
        body={"account_id": "{account:therapist}"},
    ),
    Line(
        "POST",
        "/api/sessions",
        "patient",
        body=SESSION | {"patient_id": "{foreign:patient_id}", "exercise_id": "{exercise_id}"},
        note="exercise",
    ),
    Line(
        "POST",
        "/api/sessions",
        "patient",
        body=SESSION | {"patient_id": "{foreign:patient_id}", "prescription_id": "{prescription_id}"},
        note="prescription",
    ),
    Line(
        "POST",
        "/api/uploads",
        "patient",
        body=UPLOAD | {"patient_id": "{foreign:patient_id}", "prescription_id": "{prescription_id}"},
        files=True,
    ),
    Line("GET", "/api/sessions/{foreign:session_id}/frames", "patient", query={"result_id": "{result_id}"}),
    Line("GET", "/api/sessions/{foreign:session_id}/layout", "patient", query={"result_id": "{result_id}"}),
    Line(
        "GET",
        "/api/patients/{foreign:patient_id}/progress",
        "patient",
        query={"exercise_id": "{exercise_id}"},
    ),
    Line("GET", "/api/templates", "patient", query={"patient_id": "{patient_id}"}),
    Line(
        "POST",
        "/api/templates/preview",
        "patient",
        body={"session_id": "{foreign:session_id}", "result_id": "{result_id}"},
    ),
    Line(
        "POST",
        "/api/templates",
        "patient",
        body={
            "session_id": "{foreign:session_id}",
            "exercise_id": "{foreign:exercise_id}",
            "template_id": "{template_id}",
            "name": "x",
        },
        note="version of another's template",
    ),
    Line(
        "POST",
        "/api/templates",
        "patient",
        body={
            "session_id": "{foreign:session_id}",
            "exercise_id": "{foreign:exercise_id}",
            "patient_id": "{patient_id}",
            "name": "x",
        },
        note="for another's patient",
    ),
    Line(
        "POST",
        "/api/templates",
        "patient",
        body={"session_id": "{foreign:session_id}", "exercise_id": "{exercise_id}", "name": "x"},
        note="of another's exercise",
    ),
    Line(
        "POST",
        "/api/sessions/{foreign:session_id}/comparisons",
        "patient",
        body={"template_version_id": "{version_id}"},
    ),
    Line(
        "POST",
        "/api/sessions/{foreign:session_id}/comparisons",
        "patient",
        body={"template_version_id": "{foreign:version_id}", "result_id": "{result_id}"},
        note="result",
    ),
    Line(
        "POST",
        "/api/sessions/{foreign:session_id}/views",
        "patient",
        body={"mode": "replay", "template_version_id": "{version_id}"},
        note="template",
    ),
    Line(
        "POST",
        "/api/sessions/{foreign:session_id}/views",
        "patient",
        body={"mode": "replay", "result_id": "{result_id}"},
        note="result",
    ),
)
"""Requests whose path is in reach and whose content points at another's data."""
