// The part of Web Bluetooth that is used here; no browser's type library has it.

export interface GattCharacteristic extends EventTarget {
  readonly value?: DataView;
  startNotifications(): Promise<GattCharacteristic>;
  stopNotifications(): Promise<GattCharacteristic>;
  readValue(): Promise<DataView>;
  writeValue(bytes: Uint8Array<ArrayBuffer>): Promise<void>;
}

export interface GattService {
  getCharacteristic(uuid: string): Promise<GattCharacteristic>;
}

export interface GattServer {
  readonly connected: boolean;
  connect(): Promise<GattServer>;
  disconnect(): void;
  getPrimaryService(uuid: string): Promise<GattService>;
}

export interface GattDevice extends EventTarget {
  readonly id: string;
  readonly name?: string;
  readonly gatt?: GattServer;
}

export interface Chooser {
  requestDevice(options: {
    filters: readonly { namePrefix: string }[];
    optionalServices: readonly string[];
  }): Promise<GattDevice>;
}

/** The browser's Bluetooth, or null where it has none. */
export function bluetooth(): Chooser | null {
  return (navigator as { bluetooth?: Chooser }).bluetooth ?? null;
}
