"""English sentences of accounts, sign-in and who may see which patient."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "level.status": "see the status",
    "level.read": "read",
    "level.record": "record",
    "level.treat": "treat",
    "level.manage": "manage",
    "level.erase": "erase",
    "account.not_found": "Account not found in your clinic.",
    "account.list_not_allowed": "Only the clinic's staff can list its accounts.",
    "account.create_not_allowed": "Only an administrator of the clinic can create accounts.",
    "account.patient_id": "An account with the role patient needs patient_id; accounts with other roles must"
    " not have it.",
    "account.email_form": "Enter a complete e-mail address, for instance name@example.org.",
    "account.change_not_allowed": "Only an administrator of the clinic can change accounts.",
    "clinic.change_not_allowed": "Only an administrator can change the clinic.",
    "clinic.no_such_zone": "There is no such time zone; choose one from the list, for instance Europe/Oslo.",
    "account.no_such_patient": "Patient not found in this clinic.",
    "account.email_taken": "There is already an account with this e-mail address.",
    "account.own": "This is your own account: another administrator can switch it off; to change your"
    " password, enter the current one.",
    "sign_in.origin": "This request did not come from a page of this service (wrong or missing Origin).",
    "sign_in.required": "Please sign in.",
    "sign_in.csrf": "The header {header} is missing or wrong; read it again from /api/me.",
    "sign_in.bearer_only": "Only `Authorization: Bearer` with a device token is understood.",
    "sign_in.no_device_token": "A device token cannot be used here; sign in.",
    "sign_in.device_token_only": "This is for gateways: it needs a device token.",
    "device.no_open_session": "No session is open for this patient. Create one, then ask again.",
    "device.code_refused": "This pairing code is wrong, was used before or is older than ten minutes; make a"
    " new one.",
    "device.too_many_codes": "Too many wrong pairing codes; try again in {seconds:s}.",
    "device.token_refused": "The device token is not valid, has expired or was revoked; ask the clinic for a"
    " new one.",
    "device.token_not_found": "Device token not found, or not shared with you.",
    "sign_in.busy": "Many people are signing in at this moment; try again.",
    "sign_in.too_many": "Too many failed sign-ins; try again in {seconds:s}.",
    "sign_in.wrong": "The e-mail address or the password is wrong.",
    "account.password_wrong": "The current password is wrong.",
    "account.password_same": "The new password is the current one; choose another.",
    "account.password_changed_elsewhere": "The password was changed in another browser a moment ago; sign in"
    " again.",
    "sign_in.code_needed": "Type the code of your authenticator app, or one of your recovery codes.",
    "sign_in.code_wrong": "This code is wrong or was used before. Wait for the next one.",
    "sign_in.change_password_first": "Choose a password of your own first: somebody else knows the current"
    " one.",
    "sign_in.second_factor_first": "Set up two-step sign-in first: this service asks for it.",
    "second_factor.is_on": "Two-step sign-in is on already; turn it off first to set it up anew.",
    "second_factor.not_begun": "Begin with setting up the authenticator app.",
    "second_factor.code_wrong": "This code is wrong. Check that the telephone's clock is right and type the"
    " newest code.",
    "password.short": "This password is shorter than {least} characters; choose another, for example four"
    " words.",
    "password.common": "This password is among the most common ones; choose another, for example four words.",
    "password.repeats": "This password repeats itself; choose another, for example four words.",
    "password.row": "This password is a row of letters, numbers or keys; choose another, for example four"
    " words.",
    "password.own": "This password is made of your name or e-mail address; choose another, for example four"
    " words.",
    "sign_in.ticket_refused": "The ticket is not valid here, was used before or is older than 30 seconds; ask"
    " for a new one.",
    "sign_in.no_role": "This account has no role that may sign in.",
    "patient.not_found": "Patient not found, or not shared with you.",
    "patient.level": "Your access to this patient does not cover this; it needs the right to {level:level}.",
    "patient.archived": "This patient is archived: existing data can be read, nothing can be added.",
    "patient.consent_withdrawn": "The patient has withdrawn the consent to treatment: existing data can be"
    " read, nothing can be added.",
    "patient.no_consent": "It is not recorded yet that the patient agrees to treatment. Ask the patient, and"
    " record the answer under Consent on the patient's page.",
    "patient.no_home_consent": "The patient has not consented to recording at home. Record the consent on the"
    " patient's page first.",
    "grant.not_found": "Access right not found, or not shared with you.",
    "patient.create_not_allowed": "Only therapists and administrators can add patients.",
    "grant.no_account": "There is no such active account in this clinic.",
    "grant.own_data": "Patients see their own data without an access right.",
    "grant.ends_in_past": "The end of an access right must be in the future.",
    "grant.end_needs_zone": "The end of an access right needs a time zone, for instance 2030-01-31T12:00:00Z.",
    "patient.twin": "There is already a patient with this name and date of birth. Open that record, or say that this is"
    " another person.",
    "patient.no_name": "Write at least one name.",
    "patient.merge_itself": "Choose another record than this one.",
    "patient.merged_before": "This record was merged into another one before, and is empty.",
    "patient.archive_first": "Archive the patient first; erasing cannot be undone.",
    "patient.session_live": "A session of this patient is live; end it first.",
    "patient.being_analysed": "A recording of this patient is being analysed; try again in a minute.",
}
