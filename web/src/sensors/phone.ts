// The phone's own gyroscope and accelerometer, by the browser's motion events.
import type { Sample } from './gateway/grid';
import { type OnSample, RAD_PER_DEG, rateOf, SensorFault } from './source';

/** Events that the rate is measured with. */
const RATE_EVENTS = 60;
const ANSWER_MS = 4000;
/** So long without an event, the phone no longer measures. */
export const SILENT_MS = 1500;

type Permission = { requestPermission?: () => Promise<'granted' | 'denied'> };

/** What an event measured, in our units and signs. */
export function sampleOf(event: DeviceMotionEvent, sign: 1 | -1): Sample {
  const { rotationRate, accelerationIncludingGravity: force } = event;
  const turn = rotationRate && [rotationRate.alpha, rotationRate.beta, rotationRate.gamma];
  const felt = force && [force.x, force.y, force.z];
  if (!felt || felt.some((one) => one === null)) throw new SensorFault('noAccelerometer');
  if (!turn || turn.some((one) => one === null)) throw new SensorFault('noGyroscope');
  // Alpha, beta and gamma of a rate are about x, y and z, in degrees a second.
  return [
    ...turn.map((one) => Number(one) * RAD_PER_DEG),
    ...felt.map((one) => Number(one) * sign),
  ] as unknown as Sample;
}

/**
 * The sign that makes what a phone says to what an accelerometer feels: +9.8 on the axis that points up. WebKit on
 * phones gives gravity as it pulls, everybody else as it is felt. That a browser asks for permission does not tell them
 * apart: newer Chromium does, too.
 */
export function gravitySign(): 1 | -1 {
  return navigator.vendor.startsWith('Apple') ? -1 : 1;
}

/** Why this browser has no motion interface; null where it has one. */
export function phoneFault(): SensorFault | null {
  if (!window.isSecureContext) return new SensorFault('insecure');
  return typeof DeviceMotionEvent === 'undefined' ? new SensorFault('unsupported') : null;
}

export class Phone {
  readonly device = 'phone';
  onSample: OnSample = () => undefined;
  #rateHz = 0;
  #stop: () => void = () => undefined;
  #lastMs = 0;

  get rateHz(): number {
    return this.#rateHz;
  }

  /** Whether it still measures at this moment, by the clock of events. */
  isSilent(nowMs: number): boolean {
    return nowMs - this.#lastMs > SILENT_MS;
  }

  /**
   * Ask for permission, then measure; resolves when it is known that both sensors are there and how fast they are. Must
   * be called in the answer to a tap, before anything else is waited for: iOS asks the person only then.
   */
  async start(): Promise<void> {
    const fault = phoneFault();
    if (fault) throw fault;
    const { requestPermission } = DeviceMotionEvent as Permission;
    if (requestPermission && (await requestPermission.call(DeviceMotionEvent)) !== 'granted')
      throw new SensorFault('denied');
    await this.#measure(gravitySign());
  }

  stop(): void {
    this.#stop();
  }

  #measure(sign: 1 | -1): Promise<void> {
    return new Promise((resolve, reject) => {
      const times: number[] = [];
      const refuse = (fault: unknown) => {
        this.stop();
        reject(fault instanceof Error ? fault : new SensorFault('failed'));
      };
      let empty = new SensorFault('silent');
      const timer = setTimeout(() => this.#rateHz || refuse(empty), ANSWER_MS);
      const listen = (event: DeviceMotionEvent) => {
        let sample: Sample;
        try {
          sample = sampleOf(event, sign);
        } catch (fault) {
          // A first event without values may be followed by others that have them.
          empty = fault as SensorFault;
          return;
        }
        this.#lastMs = event.timeStamp;
        if (this.#rateHz) return this.onSample(event.timeStamp, sample);
        times.push(event.timeStamp);
        if (times.length < RATE_EVENTS) return;
        try {
          this.#rateHz = rateOf(times);
          resolve();
        } catch (fault) {
          refuse(fault);
        }
      };
      this.#stop = () => {
        clearTimeout(timer);
        window.removeEventListener('devicemotion', listen);
      };
      window.addEventListener('devicemotion', listen);
    });
  }
}
