// English, complete: the catalogue that every other language is checked against.
import { balance } from '../kinds/balance/words';
import { calibration } from './en/calibration';
import { clinic } from './en/clinic';
import { common } from './en/common';
import { design } from './en/design';
import { doing } from './en/doing';
import { home } from './en/home';
import { magnetic } from './en/magnetic';
import { markers } from './en/markers';
import { motion } from './en/motion';
import { patient } from './en/patient';
import { report } from './en/report';
import { research } from './en/research';
import { sensors } from './en/sensors';
import { session } from './en/session';
import { sources } from './en/sources';
import { walking } from './en/walking';

export const en = {
  ...balance,
  ...calibration,
  ...clinic,
  ...common,
  ...design,
  ...doing,
  ...home,
  ...magnetic,
  ...markers,
  ...motion,
  ...patient,
  ...report,
  ...research,
  ...sensors,
  ...session,
  ...sources,
  ...walking,
} as const;
