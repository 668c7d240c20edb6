// What a make of sensors must say of itself to be used: another make is one more file beside `dot.ts`.
import type { Sample } from '../gateway/grid';
import type { GattServer } from './gatt';

export interface Reading {
  /** The sensor's own clock, counted up without wraps, microseconds; null where it sends none. */
  deviceUs: number | null;
  sample: Sample;
}

export interface MeasuringSensor {
  /** Charge in percent; null where it does not say. */
  battery(): Promise<number | null>;
  stop(): Promise<void>;
}

export interface SensorAdapter {
  /** As it is known to people. */
  name: string;
  /** Beginnings of the names under which its sensors are found. */
  namePrefixes: readonly string[];
  services: readonly string[];
  rateHz: number;
  /** Make a connected sensor measure, at `rateHz`. Rejects with a `SensorFault` that says why it cannot. */
  start(server: GattServer, onReading: (reading: Reading) => void): Promise<MeasuringSensor>;
}
