// Words of magnetic sources whose coils were measured, and of the word on implants while it holds.
export const sources = {
  'sources.title': 'Magnetic sources',
  'sources.lead': 'A source with measured coils gives more accurate distances than one that is only described.',
  'sources.none':
    'No source has been measured yet. Record a bench session (New session, Distance by magnetic source), then open it.',
  'sources.line': 'Serial number {serial}. Field uncertainty {gain} %, {method} {day}.',
  'sources.method.session': 'measured on a bench',
  'sources.method.file': 'from a file',
  'sources.method.typed': 'entered by hand',
  'sources.import': 'Import from a file',
  'sources.importHelp': 'To import one, choose the JSON file that “telemotion calibrate-source” writes.',
  'sources.notJson': 'This file is not a source: it must be the JSON file that “telemotion calibrate-source” writes.',
  'sources.retire': 'No longer offer',
  'sources.retireTitle': 'No longer offer this source?',
  'sources.retireText': '{name} will not be offered for new sessions. Recorded sessions are not changed.',

  'sources.which': 'Which source is worn',
  'sources.described': 'A source without measured coils',
  'sources.describedHelp':
    'Field strength assumed accurate to ±4 %. A measured source is more accurate and needs fewer pulses.',
  'sources.useBench': 'Bench: measure a source',
  'sources.useBenchText':
    'Nobody wears the source. It lies still, and the sensor is placed at measured positions around it.',
  'sources.length': 'Length of the winding (cm)',
  'sources.depth': 'Depth of the winding (cm)',

  'sources.calibrate': 'Measure this source',
  'sources.calibrateHelp':
    'For a bench session: the source lay still and the sensor was placed at measured positions. Enter the sensor position for each stop, in centimetres from the middle of the source: x forward, y left, z up. Leave a stop empty if it was not a measured position. Six positions or more, all around.',
  'sources.find': 'Find where the sensor lay still',
  'sources.noStops': 'The sensor never lay still while all coils were active.',
  'sources.stop': 'Stop {number}, {from} to {to} s',
  'sources.about': 'about {place} cm',
  'sources.axis': '{axis}, stop {number} (cm)',
  'sources.name': 'Name of the source',
  'sources.serial': 'Serial number',
  'sources.ruler': 'Accuracy of the positions (mm)',
  'sources.keep': 'Find the coils and save the source',
  'sources.saved': '{name} is saved: field uncertainty {gain} %, position error {off} mm.',

  'safety.until': 'The question is asked again from {at} on.',
  'safety.source': 'Source {name}, serial number {serial}: field uncertainty {gain} %.',
  'safety.sourceDescribed': 'The coils of this source were not measured: field strength assumed accurate to ±{gain} %.',
  'safety.withdraw': 'Withdraw confirmation',
  'safety.withdrawTitle': 'Stop the source?',
  'safety.withdrawText':
    'The source stops at once and stays off until you confirm again. The sensors continue, with growing uncertainty of the distances.',
  'safety.withdrawDo': 'Stop the source',
  'safety.withdrawn': 'Safety confirmation withdrawn by {name}, {at}: the source is off.',
  'safety.withdrawnNoName': 'Safety confirmation withdrawn {at}: the source is off.',
  'safety.expired': 'The safety confirmation of {at} has expired. Ask again: other people may be in the room.',
} as const;
