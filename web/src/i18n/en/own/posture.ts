// Words that speak of how an exercise is done: `lib/posture.ts` takes the one that fits. No other words of the patient's pages
// speak of sitting, standing or a chair, but for the calibration, which is done standing.
export const posture = {
  'posture.waiting.any': 'Take your starting position again and rest for a moment',
  'posture.waiting.seated': 'Sit as at the beginning and rest for a moment',
  'posture.waiting.standing': 'Stand as at the beginning and rest for a moment',
  'posture.ready.any': 'Press Go, then do your exercise.',
  'posture.ready.seated': 'Now sit down on a chair. Press Go, then do your exercise.',
  'posture.ready.standing': 'Stay standing. Press Go, then do your exercise.',
  'posture.upright.any': 'Keep your trunk upright.',
  'posture.upright.seated': 'Keep your back on the chair.',
  'posture.upright.standing': 'Stand upright and do not lean.',
} as const;
