// How people are named, and the path from the caseload to a patient.
import { t } from '../i18n';

export function fullName(one: { given_name: string; family_name: string }): string {
  // Some people have one name only.
  return `${one.given_name} ${one.family_name}`.trim();
}

/** The caseload, and the patient as soon as the name is known. */
export function patientCrumbs(patientId: string | undefined, name: string): { to: string; text: string }[] {
  const caseload = { to: '/', text: t('nav.caseload') };
  return patientId && name ? [caseload, { to: `/patients/${patientId}`, text: name }] : [caseload];
}
