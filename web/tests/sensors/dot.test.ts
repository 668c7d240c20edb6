import { describe, expect, it } from 'vitest';
import { DeviceClock, Unwrapped } from '../../src/sensors/bluetooth/clock';
import { measureCommand, rateCommand, readPayload } from '../../src/sensors/bluetooth/dot';

/** A message of mode 21, byte by byte as the vendor's specification orders it. */
function message(timeUs: number, acceleration: number[], degrees: number[]): DataView {
  const view = new DataView(new ArrayBuffer(28));
  view.setUint32(0, timeUs, true);
  acceleration.forEach((value, at) => view.setFloat32(4 + 4 * at, value, true));
  degrees.forEach((value, at) => view.setFloat32(16 + 4 * at, value, true));
  return view;
}

describe('Movella DOT', () => {
  it('is told the rate and the mode in its own bytes', () => {
    const rate = rateCommand(60);
    expect(rate).toHaveLength(32);
    expect([rate[0], rate[24], rate[25]]).toEqual([0x10, 60, 0]);
    expect(rate.reduce((sum, byte) => sum + byte, 0)).toBe(0x10 + 60);
    expect([...measureCommand(true)]).toEqual([1, 1, 21]);
    expect([...measureCommand(false)]).toEqual([1, 0, 21]);
  });

  it('reads time, acceleration in m/s² and rates in degrees a second', () => {
    const bytes = Buffer.from(
      '40420f00' + '00000000' + '00002041' + '000080bf' + '00003443' + '0000b4c2' + '00000000',
      'hex',
    );
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    const { deviceUs, sample } = readPayload(view, new Unwrapped());
    expect(deviceUs).toBe(1_000_000);
    [Math.PI, -Math.PI / 2, 0, 0, 10, -1].forEach((value, at) => expect(sample[at]).toBeCloseTo(value, 6));
  });

  it('goes on counting where its clock of 32 bits begins anew', () => {
    const counter = new Unwrapped();
    const read = (timeUs: number) => readPayload(message(timeUs, [0, 0, 9.8], [0, 0, 0]), counter).deviceUs ?? 0;
    const before = read(2 ** 32 - 10_000);
    expect(read(6667) - before).toBeCloseTo(16_667);
    // A message that was overtaken at the seam is no other turn.
    expect(read(23_334) - before).toBeCloseTo(33_334);
  });

  it('refuses messages that the radio has cut', () => {
    const cut = new DataView(message(0, [0, 0, 9.8], [0, 0, 0]).buffer, 0, 20);
    expect(() => readPayload(cut, new Unwrapped())).toThrowError('cut');
  });
});

describe('DeviceClock', () => {
  /** A sensor whose quartz is off and whose messages wait for the radio, as the method page simulates them. */
  function errors(ppm: number, intervalMs: number): number[] {
    let seed = 12345;
    const random = () => (seed = (seed * 1103515245 + 12345) % 2 ** 31) / 2 ** 31;
    const clock = new DeviceClock();
    const found: number[] = [];
    for (let n = 0; n < 60 * 60; n += 1) {
      const trueMs = 5000 + (n * 1000) / 60;
      const deviceUs = 777_000 + (trueMs - 5000) * 1000 * (1 + ppm * 1e-6);
      const isRepeated = random() < 0.03;
      const arrivalMs = Math.ceil(trueMs / intervalMs) * intervalMs + 2 + random() + (isRepeated ? intervalMs : 0);
      clock.learn(deviceUs, arrivalMs);
      const placedMs = clock.place(deviceUs);
      if (n > 60 * 15) found.push(placedMs - trueMs);
    }
    return found;
  }

  it('places samples to some milliseconds, and two sensors alike', () => {
    for (const [first, second] of [
      [errors(40, 31), errors(-40, 17)],
      [errors(-20, 15), errors(35, 47)],
    ] as const) {
      const apart = first.map((one, n) => Math.abs(one - (second[n] ?? 0))).sort((a, b) => a - b);
      expect(apart[Math.floor(0.95 * apart.length)]).toBeLessThan(4.6);
    }
  });

  it('is not led astray by a page that stands still for seconds', () => {
    const clock = new DeviceClock();
    const found: number[] = [];
    for (let n = 0; n < 60 * 40; n += 1) {
      const trueMs = (n * 1000) / 60;
      // What came meanwhile is all handed over when the page goes on.
      const heardMs = trueMs + 3 > 15_000 && trueMs + 3 < 22_000 ? 22_000 : trueMs + 3;
      clock.learn(trueMs * 1000, heardMs);
      found.push(clock.place(trueMs * 1000) - trueMs);
    }
    expect(Math.max(...found)).toBeLessThan(4);
  });

  it('leaves soon what slow first messages made it believe', () => {
    const clock = new DeviceClock();
    const found: number[] = [];
    for (let n = 0; n < 60 * 20; n += 1) {
      const trueMs = (n * 1000) / 60;
      clock.learn(trueMs * 1000, trueMs + 3 + (n < 60 ? 400 : 0));
      found.push(clock.place(trueMs * 1000) - trueMs);
    }
    expect(found[60 * 6]).toBeLessThan(9);
    expect(found.every((one, at) => at === 0 || one - (found[at - 1] ?? 0) > -1000 / 60)).toBe(true);
  });

  it('never lets time step back', () => {
    const placed = errors(40, 31).map((error, n) => error + (n * 1000) / 60);
    expect(placed.slice(1).every((ms, n) => ms > (placed[n] ?? 0))).toBe(true);
  });
});
