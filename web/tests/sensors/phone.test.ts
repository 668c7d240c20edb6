import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Phone } from '../../src/sensors/phone';
import { rateOf, type FaultCode } from '../../src/sensors/source';

const G = 9.81;
type Values = { x: number | null; y: number | null; z: number | null };

class MotionEvent extends Event {
  readonly rotationRate: object | null;
  readonly accelerationIncludingGravity: Values | null;

  constructor(turn: [number, number, number] | null, force: Values | null, timeMs: number) {
    super('devicemotion');
    this.rotationRate = turn && { alpha: turn[0], beta: turn[1], gamma: turn[2] };
    this.accelerationIncludingGravity = force;
    Object.defineProperty(this, 'timeStamp', { value: timeMs });
  }
}

const FACE_UP: Values = { x: 0, y: 0, z: G };

function play(count: number, stepMs: number, event: (timeMs: number) => MotionEvent, fromMs = 0): void {
  for (let n = 0; n < count; n += 1) window.dispatchEvent(event(fromMs + n * stepMs));
}

async function faultOf(started: Promise<void>): Promise<FaultCode> {
  const fault: unknown = await started.then(
    () => null,
    (error: unknown) => error,
  );
  return (fault as { code: FaultCode }).code;
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('DeviceMotionEvent', MotionEvent);
  vi.stubGlobal('isSecureContext', true);
  vi.spyOn(navigator, 'vendor', 'get').mockReturnValue('Google Inc.');
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe('the phone as a sensor', () => {
  it('gives rad/s about x, y, z and what an accelerometer feels', async () => {
    const phone = new Phone();
    const onSample = vi.fn();
    phone.onSample = onSample;
    const started = phone.start();
    const event = (ms: number) => new MotionEvent([180, -90, 45], FACE_UP, ms);
    play(60, 1000 / 60, event);
    await started;
    expect(phone.rateHz).toBe(60);
    play(1, 0, event, 1000);
    const [timeMs, sample] = onSample.mock.calls[0] as [number, number[]];
    expect(timeMs).toBe(1000);
    [Math.PI, -Math.PI / 2, Math.PI / 4, 0, 0, G].forEach((value, at) => expect(sample[at]).toBeCloseTo(value));
    phone.stop();
    play(1, 0, event, 1017);
    expect(onSample).toHaveBeenCalledOnce();
  });

  it('turns the sign where gravity is given as it pulls, and asks there for permission first', async () => {
    vi.spyOn(navigator, 'vendor', 'get').mockReturnValue('Apple Computer, Inc.');
    const requestPermission = vi.fn(() => Promise.resolve('granted'));
    vi.stubGlobal('DeviceMotionEvent', Object.assign(class extends MotionEvent {}, { requestPermission }));
    const phone = new Phone();
    const onSample = vi.fn();
    phone.onSample = onSample;
    const started = phone.start();
    expect(requestPermission).toHaveBeenCalledOnce();
    await Promise.resolve();
    play(61, 1000 / 60, (ms) => new MotionEvent([0, 0, 0], { x: 0, y: 0, z: -G }, ms));
    await started;
    expect((onSample.mock.calls[0] as [number, number[]])[1][5]).toBeCloseTo(G);
  });

  it('keeps the sign of a browser that is not WebKit though it asks for permission', async () => {
    const requestPermission = vi.fn(() => Promise.resolve('granted'));
    vi.stubGlobal('DeviceMotionEvent', Object.assign(class extends MotionEvent {}, { requestPermission }));
    const phone = new Phone();
    const onSample = vi.fn();
    phone.onSample = onSample;
    const started = phone.start();
    await Promise.resolve();
    play(61, 1000 / 60, (ms) => new MotionEvent([0, 0, 0], FACE_UP, ms));
    await started;
    expect((onSample.mock.calls[0] as [number, number[]])[1][5]).toBeCloseTo(G);
  });

  it('says what is missing', async () => {
    const nothing = { x: null, y: null, z: null };
    const cases: [FaultCode, (ms: number) => MotionEvent, number][] = [
      ['noGyroscope', (ms) => new MotionEvent(null, FACE_UP, ms), 60],
      ['noAccelerometer', (ms) => new MotionEvent([0, 0, 0], nothing, ms), 60],
      ['silent', () => new MotionEvent(null, null, 0), 0],
    ];
    for (const [code, event, count] of cases) {
      const started = faultOf(new Phone().start());
      play(count, 1000 / 60, event);
      await vi.advanceTimersByTimeAsync(5000);
      expect(await started).toBe(code);
    }
    const slow = faultOf(new Phone().start());
    play(60, 100, (ms) => new MotionEvent([0, 0, 0], FACE_UP, ms));
    expect(await slow).toBe('tooSlow');
    vi.stubGlobal('isSecureContext', false);
    expect(await faultOf(new Phone().start())).toBe('insecure');
  });

  it('says when it was not allowed, and when the browser has nothing of the kind', async () => {
    const requestPermission = () => Promise.resolve('denied');
    vi.stubGlobal('DeviceMotionEvent', Object.assign(class extends MotionEvent {}, { requestPermission }));
    expect(await faultOf(new Phone().start())).toBe('denied');
    vi.stubGlobal('DeviceMotionEvent', undefined);
    expect(await faultOf(new Phone().start())).toBe('unsupported');
  });
});

describe('rateOf', () => {
  it('declares the usual rate that is not above what comes', () => {
    const even = (hz: number) => Array.from({ length: 60 }, (_, n) => (n * 1000) / hz);
    expect([100, 60, 59, 50, 33, 20].map((hz) => rateOf(even(hz)))).toEqual([60, 60, 60, 50, 30, 20]);
    const jittered = even(60).map((ms, n) => ms + 4 * Math.sin(7 * n));
    expect(rateOf(jittered)).toBe(60);
  });
});
