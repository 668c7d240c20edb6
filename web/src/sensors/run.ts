// What measures on this device for one session: started by a tap, shown by any page of the session, ended with it.
import type { Placement } from '../api/types';
import { keepAwake } from './awake';
import type { SensorState, WornSensor } from './bluetooth/sensor';
import { BrowserGateway, type GatewaySnapshot } from './gateway/browserGateway';
import type { StoredNetwork } from './gateway/store';
import type { Phone } from './phone';
import { measuringFor, setMeasuring } from './registry';
import { answerOthers } from './rest';
import { giveUpTurn, takeTurn } from './turn';

export interface RunSnapshot {
  kind: 'phone' | 'bluetooth';
  gateway: GatewaySnapshot | null;
  /** Bluetooth sensors by where they are worn. */
  sensors: Partial<Record<Placement, SensorState>>;
  isAwake: boolean;
  /** The phone gives nothing at this moment. */
  isSilent: boolean;
}

const LOOK_MS = 500;

export type Owner = Pick<StoredNetwork, 'sessionId' | 'accountId' | 'next'>;

export class SensorRun {
  readonly sessionId: string;
  readonly #owner: Owner;
  readonly #placements: readonly Placement[];
  readonly #listeners = new Set<() => void>();
  readonly #worn = new Map<Placement, WornSensor>();
  readonly #letSleep: () => void;
  readonly #endAnswers: () => void;
  #phone: Phone | null = null;
  #gateway: BrowserGateway | null = null;
  #watch: ReturnType<typeof setInterval>;
  #snapshot: RunSnapshot;

  private constructor(kind: RunSnapshot['kind'], owner: Owner, placements: readonly Placement[]) {
    this.sessionId = owner.sessionId;
    this.#owner = owner;
    this.#placements = placements;
    this.#snapshot = { kind, gateway: null, sensors: {}, isAwake: false, isSilent: false };
    this.#letSleep = keepAwake((isAwake) => this.#say({ isAwake }));
    this.#watch = setInterval(() => this.#look(), LOOK_MS);
    this.#endAnswers = answerOthers(this);
    setMeasuring(this);
  }

  /** The run of this session, if this page has one. */
  static of(sessionId: string): SensorRun | null {
    const found = measuringFor(sessionId);
    return found instanceof SensorRun ? found : null;
  }

  /**
   * With a phone that measures already: it was asked in the answer to a tap. Rejects with a `SensorFault` while another
   * window measures.
   */
  static async withPhone(phone: Phone, owner: Owner, placement: Placement): Promise<SensorRun> {
    await takeTurn();
    const run = new SensorRun('phone', owner, [placement]);
    run.#phone = phone;
    run.#send(phone.rateHz, phone.device);
    phone.onSample = (timeMs, sample) => run.#gateway?.add(0, timeMs, sample);
    return run;
  }

  /** Rejects with a `SensorFault` while another window measures. */
  static async withBluetooth(owner: Owner, placements: readonly Placement[]): Promise<SensorRun> {
    await takeTurn();
    return new SensorRun('bluetooth', owner, placements);
  }

  /** Let the person choose the sensor that is worn at a place; sending begins when every place has one. */
  async choose(placement: Placement): Promise<void> {
    const { WornSensor: Worn, chooseDevice } = await import('./bluetooth/sensor');
    const { device, adapter } = await chooseDevice();
    const number = this.#placements.indexOf(placement);
    await this.#worn.get(placement)?.stop();
    const sensor = new Worn({
      device,
      adapter,
      onSample: (timeMs, sample) => this.#gateway?.add(number, timeMs, sample),
      onState: (state) => this.#say({ sensors: { ...this.#snapshot.sensors, [placement]: state } }),
      onLost: () => this.#gateway?.leave(number),
    });
    this.#worn.set(placement, sensor);
    await sensor.start();
    if (!this.#gateway && this.#placements.every((place) => this.#worn.has(place)))
      this.#send(adapter.rateHz, adapter.name);
  }

  stop = (): void => {
    clearInterval(this.#watch);
    this.#letSleep();
    this.#endAnswers();
    this.#phone?.stop();
    for (const sensor of this.#worn.values()) void sensor.stop();
    this.#gateway?.close();
    if (measuringFor(this.sessionId) !== this) return;
    setMeasuring(null);
    giveUpTurn();
  };

  async settled(withinMs: number): Promise<boolean> {
    // What the page last heard may be older than samples that are still on their way to the worker.
    const isSafe = () => {
      const recorder = this.#snapshot.gateway?.recorder;
      return recorder?.isComplete === true && recorder.waiting === 0;
    };
    this.#phone?.stop();
    for (const sensor of this.#worn.values()) void sensor.stop();
    this.#gateway?.finish(false);
    const untilMs = performance.now() + withinMs;
    do await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
    while (!isSafe() && performance.now() < untilMs);
    return isSafe();
  }

  subscribe = (listener: () => void): (() => void) => {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  };

  getSnapshot = (): RunSnapshot => this.#snapshot;

  #send(rateHz: number, device: string): void {
    const gateway = new BrowserGateway({ ...this.#owner, placements: [...this.#placements], rateHz, device });
    this.#gateway = gateway;
    gateway.subscribe(() => this.#say({ gateway: gateway.getSnapshot() }));
    this.#say({ gateway: gateway.getSnapshot() });
  }

  #look(): void {
    const isSilent = this.#phone?.isSilent(performance.now()) ?? false;
    if (isSilent !== this.#snapshot.isSilent) this.#say({ isSilent });
    const link = this.#snapshot.gateway?.recorder?.link;
    // The session is over: nothing is measured for it any more.
    if (link?.status === 'ended') this.stop();
  }

  #say(change: Partial<RunSnapshot>): void {
    this.#snapshot = { ...this.#snapshot, ...change };
    for (const listener of this.#listeners) listener();
  }
}
