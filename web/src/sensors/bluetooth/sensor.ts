// One sensor on the body: connected, measuring, and connected again by itself when it was lost.
import type { Sample } from '../gateway/grid';
import { type OnSample, SensorFault, type FaultCode } from '../source';
import type { MeasuringSensor, Reading, SensorAdapter } from './adapter';
import { DeviceClock } from './clock';
import { dot } from './dot';
import { bluetooth, type GattDevice } from './gatt';

/** Every make that is known; the first whose name fits is used. */
export const ADAPTERS: readonly SensorAdapter[] = [dot];

export type SensorStatus = 'connecting' | 'measuring' | 'lost' | 'failed';

export interface SensorState {
  name: string;
  status: SensorStatus;
  fault: FaultCode | null;
  batteryPercent: number | null;
}

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 5000;
/** A sensor that is connected and says nothing is lost, too. */
const SILENT_MS = 3000;
const BATTERY_MS = 60_000;
/** So long the first samples wait: the first messages may all have been slow, and their times would be late. */
const LEARNING_MS = 1000;

/** Why this browser has no Bluetooth for pages; null where it has. */
export function bluetoothFault(): SensorFault | null {
  if (!window.isSecureContext) return new SensorFault('insecure');
  return bluetooth() ? null : new SensorFault('unsupported');
}

/** Let the person choose one sensor; must be called in the answer to a tap. */
export async function chooseDevice(): Promise<{ device: GattDevice; adapter: SensorAdapter }> {
  const fault = bluetoothFault();
  const chooser = bluetooth();
  if (fault || !chooser) throw fault ?? new SensorFault('unsupported');
  let device: GattDevice;
  try {
    device = await chooser.requestDevice({
      filters: ADAPTERS.flatMap((one) => one.namePrefixes).map((namePrefix) => ({ namePrefix })),
      optionalServices: ADAPTERS.flatMap((one) => one.services),
    });
  } catch (error) {
    const isCancelled = error instanceof DOMException && error.name === 'NotFoundError';
    throw new SensorFault(isCancelled ? 'notChosen' : 'radioOff');
  }
  const adapter = ADAPTERS.find((one) => one.namePrefixes.some((prefix) => device.name?.startsWith(prefix)));
  if (!adapter) throw new SensorFault('notOurs');
  return { device, adapter };
}

export interface WornSensorOptions {
  device: GattDevice;
  adapter: SensorAdapter;
  onSample: OnSample;
  onState: (state: SensorState) => void;
  onLost: () => void;
}

export class WornSensor {
  readonly #options: WornSensorOptions;
  #state: SensorState;
  #measuring: MeasuringSensor | null = null;
  #attempt = 0;
  #isDone = false;
  #lastMs = 0;
  #retry: ReturnType<typeof setTimeout> | undefined;
  #watch: ReturnType<typeof setInterval> | undefined;
  #batteryMs = -Infinity;
  #firstMs = Number.NaN;
  #waiting: { deviceUs: number; sample: Sample }[] = [];

  constructor(options: WornSensorOptions) {
    this.#options = options;
    const name = options.device.name ?? options.adapter.name;
    this.#state = { name, status: 'connecting', fault: null, batteryPercent: null };
    options.device.addEventListener('gattserverdisconnected', this.#gone);
  }

  get state(): SensorState {
    return this.#state;
  }

  /** Connect and measure; rejects with a `SensorFault` when the sensor can never be used so. */
  async start(): Promise<void> {
    await this.#connect();
    this.#watch = setInterval(() => this.#look(), 500);
  }

  async stop(): Promise<void> {
    this.#isDone = true;
    clearTimeout(this.#retry);
    clearInterval(this.#watch);
    this.#options.device.removeEventListener('gattserverdisconnected', this.#gone);
    await this.#measuring?.stop().catch(() => undefined);
    this.#options.device.gatt?.disconnect();
  }

  async #connect(): Promise<void> {
    const { device, adapter } = this.#options;
    if (!device.gatt) throw new SensorFault('failed');
    const clock = new DeviceClock();
    this.#firstMs = Number.NaN;
    this.#waiting = [];
    try {
      const server = await device.gatt.connect();
      this.#measuring = await adapter.start(server, (reading) => this.#take(reading, clock));
    } catch (error) {
      if (error instanceof SensorFault) {
        this.#say({ status: 'failed', fault: error.code });
        await this.stop();
        throw error;
      }
      this.#again();
      return;
    }
    this.#attempt = 0;
    this.#lastMs = performance.now();
    this.#say({ status: 'measuring', fault: null });
  }

  #take({ deviceUs, sample }: Reading, clock: DeviceClock): void {
    const nowMs = performance.now();
    this.#lastMs = nowMs;
    if (deviceUs === null) {
      this.#options.onSample(nowMs, sample);
      return;
    }
    clock.learn(deviceUs, nowMs);
    this.#waiting.push({ deviceUs, sample });
    if (Number.isNaN(this.#firstMs)) this.#firstMs = nowMs;
    if (nowMs - this.#firstMs < LEARNING_MS) return;
    for (const one of this.#waiting) this.#options.onSample(clock.place(one.deviceUs), one.sample);
    this.#waiting = [];
  }

  readonly #gone = () => {
    this.#measuring = null;
    this.#again();
  };

  #again(): void {
    if (this.#isDone) return;
    if (this.#state.status !== 'lost') {
      this.#say({ status: 'lost' });
      this.#options.onLost();
    }
    clearTimeout(this.#retry);
    const waitMs = Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** this.#attempt);
    this.#attempt += 1;
    this.#retry = setTimeout(() => void this.#connect().catch(() => undefined), waitMs);
  }

  #look(): void {
    const nowMs = performance.now();
    if (this.#state.status !== 'measuring') return;
    if (nowMs - this.#lastMs > SILENT_MS) {
      this.#options.device.gatt?.disconnect();
      this.#again();
    } else if (nowMs - this.#batteryMs > BATTERY_MS) {
      this.#batteryMs = nowMs;
      this.#measuring
        ?.battery()
        .then((batteryPercent) => this.#say({ batteryPercent }))
        .catch(() => undefined);
    }
  }

  #say(change: Partial<SensorState>): void {
    this.#state = { ...this.#state, ...change };
    this.#options.onState(this.#state);
  }
}
