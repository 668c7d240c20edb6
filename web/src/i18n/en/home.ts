// Words of the patient's own live page and replay, of consents, and of connecting sensors at home.
export const home = {
  'consent.title': 'Consent',
  'consent.lead': 'What the patient has agreed to. Ask, then write down the answer; the patient sees it and can change it.',
  'consent.yes': 'Yes',
  'consent.no': 'No',
  'consent.since': 'Answered on {date}.',
  'consent.notAsked': 'Not asked yet.',
  'consent.staff.treatment': 'Treatment',
  'consent.staff.treatment.text': 'Therapists of this clinic may use the movement data to treat the patient.',
  'consent.staff.home_streaming': 'Exercising at home',
  'consent.staff.home_streaming.text': 'Sensors may send movement from home. Without a yes, nothing recorded at home is accepted.',
  'consent.staff.research': 'Research',
  'consent.staff.research.text': 'The data may be used for research, without the name.',
  'caseload.filter.archived': 'Archived',
  'caseload.archivedNone': 'Nobody is archived.',
  'caseload.archivedOn': 'Archived on {date}',
  'caseload.archivedSeen': 'Look at archived patients',
} as const;
