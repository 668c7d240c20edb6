// English, complete: the catalogue that every other language is checked against.
import { balance } from '../../kinds/balance/words/en';
import { common } from './common';
import { motion } from './motion';
import { doing } from './own/doing';
import { home } from './own/home';
import { posture } from './own/posture';
import { sensors } from './own/sensors';
import { calibration } from './session/calibration';
import { magnetic } from './session/magnetic';
import { markers } from './session/markers';
import { session } from './session/recording';
import { sources } from './session/sources';
import { walking } from './session/walking';
import { clinic } from './staff/clinic';
import { design } from './staff/design';
import { editing } from './staff/editing';
import { patient } from './staff/patient';
import { report } from './staff/report';
import { research } from './staff/research';

export const words = {
  ...balance,
  ...calibration,
  ...clinic,
  ...common,
  ...design,
  ...doing,
  ...editing,
  ...home,
  ...magnetic,
  ...markers,
  ...motion,
  ...patient,
  ...posture,
  ...report,
  ...research,
  ...sensors,
  ...session,
  ...sources,
  ...walking,
} as const;
