import { describe, expect, it } from 'vitest';
import { complete, deviceOf, guessSignals, guessTime, mappingProblems } from '../../src/lib/csv';
import { readHead, splitLine } from '../../src/lib/tableHead';

describe('reading the head of a table', () => {
  it('finds the delimiter and keeps quoted fields whole', () => {
    expect(readHead('time;a x;a y\r\n0;1;2\r\n')).toMatchObject({ delimiter: ';', columns: ['time', 'a x', 'a y'], rows: [['0', '1', '2']], skippedLines: 1 });
    expect(splitLine('"a,b","say ""hi""",3', ',')).toEqual(['a,b', 'say "hi"', '3']);
  });
  it('survives an empty file and a byte order mark', () => {
    expect(readHead('').columns).toEqual([]);
    expect(readHead('\uFEFFtime,x').columns[0]).toBe('time');
  });
});

describe('guessing what the columns are', () => {
  const columns = ['timestamp', 'right_forearm_gyr_x', 'right_forearm_gyr_y', 'right_forearm_gyr_z', 'forearm_right_acc_x', 'forearm_right_acc_y', 'forearm_right_acc_z', 'temp_x', 'lonely_acc_x'];
  const found = guessSignals(columns, ['forearm_left', 'forearm_right', 'sternum']);
  it('groups triples by name and reads placement and quantity from it', () => {
    expect(found).toEqual([
      { placement: 'forearm_right', quantity: 'gyroscope', unit: 'rad/s', columns: columns.slice(1, 4) },
      { placement: 'forearm_right', quantity: 'accelerometer', unit: 'm/s^2', columns: columns.slice(4, 7) },
    ]);
  });
  it('reads units from the names', () => {
    expect(guessSignals(['gyr_x [deg/s]', 'gyr_y [deg/s]', 'gyr_z [deg/s]'], ['sternum'])[0]?.unit).toBe('deg/s');
    expect(guessSignals(['Acc X (g)', 'Acc Y (g)', 'Acc Z (g)'], ['sternum'])[0]).toMatchObject({ quantity: 'accelerometer', unit: 'g' });
  });
  it('finds the time column', () => {
    expect(guessTime({ columns, rows: [['0.5']] })).toBe('timestamp');
    expect(guessTime({ columns, rows: [['NaN']] })).toBeNull();
    expect(guessTime({ columns: ['acc_x'], rows: [['1']] })).toBeNull();
  });
  it('says what is missing before anything is sent', () => {
    expect(mappingProblems({ signals: found, time_column: 'timestamp' })).toEqual([]);
    expect(mappingProblems({ signals: [], rate_hz: 100 })).toEqual(['csv.needSignals']);
    expect(mappingProblems({ signals: found.slice(0, 1), time_column: null })).toEqual(['csv.needTime', 'csv.needAccelerometer']);
    expect(mappingProblems({ signals: [...found, ...found], rate_hz: 50 })).toContain('csv.twice');
    const nowhere = { signals: found.map((one) => ({ ...one, placement: null })), rate_hz: 50 };
    expect(mappingProblems(nowhere)).toEqual(['csv.needPlacement']);
    expect(complete(nowhere)).toBeNull();
  });
  it('knows which columns are of one sensor', () => {
    expect(deviceOf('left_sensor acc_x')).toBe(deviceOf('left_sensor gyr_x'));
    expect(deviceOf('left_sensor acc_x')).not.toBe(deviceOf('right_sensor acc_x'));
    expect(deviceOf('Static/Angular Velocity/X rad/s')).toBe(deviceOf('Static/Magnetic Field/X uT'));
    expect(deviceOf('acc_x (2)')).not.toBe(deviceOf('acc_x'));
  });
});
