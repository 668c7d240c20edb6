// Words of the patient's page, exercises and prescriptions.
export const patient = {
  'patient.add': 'Add patient',
} as const;
