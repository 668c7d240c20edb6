// What waits on this device is sealed: who holds the device without the account's sign-in reads none of it.

/** The account's key as the service gave it at the sign-in or when the page was opened; only in memory. */
let held = '';

export function holdStoreKey(key: string): void {
  held = key;
}

export const heldStoreKey = (): string => held;

/** A page without https has none. */
export const hasCryptography = (): boolean => (crypto as Partial<Crypto>).subtle !== undefined;

export interface Sealed {
  iv: Uint8Array<ArrayBuffer>;
  sealed: ArrayBuffer;
}

/** AES-GCM with the account's key; each piece is bound to the name under which it is stored. */
export class Seal {
  readonly #key: CryptoKey;

  private constructor(key: CryptoKey) {
    this.#key = key;
  }

  /** Rejects where this browser has no cryptography (a page without https), or there is no key. */
  static async of(base64: string): Promise<Seal> {
    const raw = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    return new Seal(await crypto.subtle.importKey('raw', raw, 'AES-GCM', false, ['encrypt', 'decrypt']));
  }

  async close(name: string, bytes: Uint8Array<ArrayBuffer>): Promise<Sealed> {
    const iv = crypto.getRandomValues(new Uint8Array(12));
    return { iv, sealed: await crypto.subtle.encrypt(how(name, iv), this.#key, bytes) };
  }

  /** Rejects where it was sealed with another key, or under another name. */
  async open(name: string, { iv, sealed }: Sealed): Promise<Uint8Array<ArrayBuffer>> {
    return new Uint8Array(await crypto.subtle.decrypt(how(name, iv), this.#key, sealed));
  }
}

const how = (name: string, iv: Uint8Array<ArrayBuffer>): AesGcmParams => ({
  name: 'AES-GCM',
  iv,
  additionalData: new TextEncoder().encode(name),
});
