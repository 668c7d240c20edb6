// Movella DOT (earlier Xsens DOT): services, commands and payloads of the vendor's Bluetooth specification XD0506P.
import { RAD_PER_DEG, SensorFault } from '../source';
import type { MeasuringSensor, Reading, SensorAdapter } from './adapter';
import { Unwrapped } from './clock';
import type { GattCharacteristic, GattServer } from './gatt';

const uuid = (short: string) => `1517${short}-4947-11e9-8646-d663bd873d93`;
const CONFIGURATION = uuid('1000');
const CONTROL = uuid('1002');
const MEASUREMENT = uuid('2000');
const MEASUREMENT_CONTROL = uuid('2001');
const MEDIUM_PAYLOAD = uuid('2003');
const BATTERY = uuid('3000');
const BATTERY_LEVEL = uuid('3001');

/** Angular rate and acceleration with the time of the sensor, as they were measured: no vendor's filter is needed. */
export const RATE_QUANTITIES = 21;
const RATE_HZ = 60;
const PAYLOAD_BYTES = 28;
const ACCELERATION_AT = 4;
const RATE_AT = 16;

/** Set the output rate: 32 bytes, the first says what is meant. */
export function rateCommand(rateHz: number): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(32);
  bytes[0] = 1 << 4;
  new DataView(bytes.buffer).setUint16(24, rateHz, true);
  return bytes;
}

export function measureCommand(isOn: boolean): Uint8Array<ArrayBuffer> {
  return Uint8Array.of(1, isOn ? 1 : 0, RATE_QUANTITIES);
}

/** Read one message of the mode; `counter` undoes the wraps of the sensor's clock, every 71.6 minutes. */
export function readPayload(view: DataView, counter: Unwrapped): Reading {
  // Where the radio's messages are too small the rest is cut off, and the page cannot ask for larger ones.
  if (view.byteLength < PAYLOAD_BYTES) throw new SensorFault('cut');
  const three = (at: number) => [0, 4, 8].map((step) => view.getFloat32(at + step, true));
  const [gx = 0, gy = 0, gz = 0] = three(RATE_AT).map((one) => one * RAD_PER_DEG);
  const [ax = 0, ay = 0, az = 0] = three(ACCELERATION_AT);
  return { deviceUs: counter.of(view.getUint32(0, true)), sample: [gx, gy, gz, ax, ay, az] };
}

async function characteristic(server: GattServer, service: string, name: string): Promise<GattCharacteristic> {
  return (await server.getPrimaryService(service)).getCharacteristic(name);
}

async function start(server: GattServer, onReading: (reading: Reading) => void): Promise<MeasuringSensor> {
  const control = await characteristic(server, CONFIGURATION, CONTROL);
  const measurement = await characteristic(server, MEASUREMENT, MEASUREMENT_CONTROL);
  const payload = await characteristic(server, MEASUREMENT, MEDIUM_PAYLOAD);
  // It may still measure from an earlier connection, and then takes no other rate.
  await measurement.writeValue(measureCommand(false));
  await control.writeValue(rateCommand(RATE_HZ));
  const counter = new Unwrapped();
  return new Promise((resolve, reject) => {
    const listen = (event: Event) => {
      const view = (event.target as GattCharacteristic).value;
      if (!view) return;
      try {
        onReading(readPayload(view, counter));
      } catch (fault) {
        void stop();
        reject(fault instanceof SensorFault ? fault : new SensorFault('failed'));
      }
    };
    const stop = async () => {
      payload.removeEventListener('characteristicvaluechanged', listen);
      if (!server.connected) return;
      await measurement.writeValue(measureCommand(false));
      await payload.stopNotifications();
    };
    const battery = async () => {
      const level = await (await characteristic(server, BATTERY, BATTERY_LEVEL)).readValue();
      return level.byteLength > 0 ? level.getUint8(0) : null;
    };
    payload.addEventListener('characteristicvaluechanged', listen);
    payload
      .startNotifications()
      .then(() => measurement.writeValue(measureCommand(true)))
      .then(() => resolve({ battery, stop }), reject);
  });
}

export const dot: SensorAdapter = {
  name: 'Movella DOT',
  namePrefixes: ['Movella DOT', 'Xsens DOT'],
  services: [CONFIGURATION, MEASUREMENT, BATTERY],
  rateHz: RATE_HZ,
  start,
};
