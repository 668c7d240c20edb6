// What was measured and is not yet safe with the service: packets in the browser's own database, sealed with the key of
// the account that measured them.
import { Seal, type Sealed } from './seal';

const NAME = 'telemotion-sensors';
const PACKETS = 'packets';
const SESSIONS = 'sessions';
/** What nobody has sent for so long is deleted; the words at sign-out name it. */
export const FORGOTTEN_AFTER_DAYS = 28;
const DAY_MS = 86_400_000;

/** How a session was declared when its first packet was stored; all that follow are of the same network. */
export interface StoredNetwork {
  sessionId: string;
  /** Whose session it is: nobody else who signs in on this device sends it or learns of it. */
  accountId: string;
  placements: string[];
  rateHz: number;
  device: string;
  /** The sequence of the next packet, where all before it are safe and forgotten. */
  next: number;
}

export interface StoredPacket {
  sequence: number;
  bytes: Uint8Array<ArrayBuffer>;
}

type Described = Pick<StoredNetwork, 'placements' | 'rateHz' | 'device'>;
/** In clear is only what the database is asked by; sessions of an earlier version hold their description as it is. */
type SessionRow = Pick<StoredNetwork, 'sessionId' | 'accountId' | 'next'> & { usedMs: number } & (Sealed | Described);
type PacketRow = { sessionId: string; sequence: number } & (Sealed | { bytes: Uint8Array<ArrayBuffer> });

function done<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error('the database of this browser failed'));
  });
}

function committed(transaction: IDBTransaction): Promise<void> {
  return new Promise((resolve, reject) => {
    transaction.oncomplete = () => resolve();
    transaction.onabort = transaction.onerror = () =>
      reject(transaction.error ?? new Error('the database of this browser failed'));
  });
}

const packetsOf = (sessionId: string, through = Infinity) => IDBKeyRange.bound([sessionId, -1], [sessionId, through]);
const packetName = (sessionId: string, sequence: number) => `${sessionId}/${sequence}`;

function upgrade(request: IDBOpenDBRequest, before: number): void {
  const { result: database, transaction } = request;
  if (before < 1) {
    database.createObjectStore(PACKETS, { keyPath: ['sessionId', 'sequence'] });
    database.createObjectStore(SESSIONS, { keyPath: 'sessionId' });
    return;
  }
  // Its weeks begin now: nobody knows when it was left.
  const rows = transaction!.objectStore(SESSIONS).openCursor();
  rows.onsuccess = () => {
    const cursor = rows.result;
    if (!cursor) return;
    cursor.update({ ...(cursor.value as StoredNetwork), usedMs: Date.now() });
    cursor.continue();
  };
}

export class PacketStore {
  readonly #database: IDBDatabase;
  readonly #seal: Seal | null;
  /** Sequences that this key did not open when they were read. */
  readonly #unreadable = new Map<string, Set<number>>();

  private constructor(database: IDBDatabase, seal: Seal | null) {
    this.#database = database;
    this.#seal = seal;
  }

  /** `key` is the account's, `Me.store_key`; without one the store counts and deletes, and neither reads nor writes. */
  static async open(key: string, factory: IDBFactory = indexedDB): Promise<PacketStore> {
    const seal = key ? await Seal.of(key) : null;
    const request = factory.open(NAME, 2);
    request.onupgradeneeded = ({ oldVersion }) => upgrade(request, oldVersion);
    const database = await done(request);
    // Another window has a newer version of this page: its upgrade must not wait for this one.
    database.onversionchange = () => database.close();
    return new PacketStore(database, seal);
  }

  close(): void {
    this.#database.close();
  }

  get #withKey(): Seal {
    if (!this.#seal) throw new Error('nobody is signed in');
    return this.#seal;
  }

  /** Remember what the packets of a session mean. */
  async declare({ sessionId, accountId, next, ...described }: StoredNetwork): Promise<void> {
    const { placements, rateHz, device }: Described = described;
    const text = new TextEncoder().encode(JSON.stringify({ placements, rateHz, device }));
    const sealed = await this.#withKey.close(sessionId, text);
    const row: SessionRow = { sessionId, accountId, next, usedMs: Date.now(), ...sealed };
    const transaction = this.#database.transaction(SESSIONS, 'readwrite');
    transaction.objectStore(SESSIONS).put(row);
    await committed(transaction);
  }

  /** The sequence of a session's next packet; 0 where this device knows nothing of it. */
  async next(sessionId: string): Promise<number> {
    const store = this.#database.transaction(SESSIONS).objectStore(SESSIONS);
    return ((await done(store.get(sessionId))) as SessionRow | undefined)?.next ?? 0;
  }

  /** Rejects where it was sealed with another key. */
  async network(sessionId: string): Promise<StoredNetwork | undefined> {
    const store = this.#database.transaction(SESSIONS).objectStore(SESSIONS);
    const row = (await done(store.get(sessionId))) as SessionRow | undefined;
    return row && this.#opened(row);
  }

  async #opened(row: SessionRow): Promise<StoredNetwork> {
    const { sessionId, accountId, next } = row;
    const described =
      'sealed' in row
        ? (JSON.parse(new TextDecoder().decode(await this.#withKey.open(sessionId, row))) as Described)
        : { placements: row.placements, rateHz: row.rateHz, device: row.device };
    return { sessionId, accountId, next, ...described };
  }

  async #rows(): Promise<SessionRow[]> {
    const store = this.#database.transaction(SESSIONS).objectStore(SESSIONS);
    return (await done(store.getAll())) as SessionRow[];
  }

  /** The identifiers of the sessions of one account that have something on this device. */
  async sessions(accountId: string): Promise<string[]> {
    return (await this.#rows()).filter((one) => one.accountId === accountId).map((one) => one.sessionId);
  }

  /** Resolves when the packet is in the database: only then may it be sent. */
  async put(sessionId: string, sequence: number, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
    const sealed = await this.#withKey.close(packetName(sessionId, sequence), bytes);
    const transaction = this.#database.transaction(PACKETS, 'readwrite');
    transaction.objectStore(PACKETS).put({ sessionId, sequence, ...sealed } satisfies PacketRow);
    await committed(transaction);
  }

  /**
   * Packets from a sequence on, in order, at most so many; empty only where none follows that this key opens: those of
   * another key are passed over, and stay until the service has given them up.
   */
  async read(sessionId: string, from: number, most: number, to = Infinity): Promise<StoredPacket[]> {
    for (let next = from; next <= to;) {
      const range = IDBKeyRange.bound([sessionId, next], [sessionId, to]);
      const store = this.#database.transaction(PACKETS).objectStore(PACKETS);
      const rows = (await done(store.getAll(range, most))) as PacketRow[];
      const last = rows.at(-1);
      if (!last) break;
      const found = await this.#readable(rows);
      if (found.length > 0) return found;
      next = last.sequence + 1;
    }
    return [];
  }

  async #readable(rows: readonly PacketRow[]): Promise<StoredPacket[]> {
    const opened = await Promise.allSettled(
      rows.map(async (row): Promise<StoredPacket> => ({
        sequence: row.sequence,
        bytes: 'sealed' in row ? await this.#withKey.open(packetName(row.sessionId, row.sequence), row) : row.bytes,
      })),
    );
    return opened.flatMap((one, at) => {
      if (one.status === 'fulfilled') return [one.value];
      const { sessionId, sequence } = rows[at]!;
      if (this.#seal) this.#unreadableOf(sessionId).add(sequence);
      return [];
    });
  }

  #unreadableOf(sessionId: string): Set<number> {
    const found = this.#unreadable.get(sessionId) ?? new Set();
    this.#unreadable.set(sessionId, found);
    return found;
  }

  /** Forget what is safe: everything up to and including this sequence. */
  async forget(sessionId: string, through: number): Promise<void> {
    const transaction = this.#database.transaction([PACKETS, SESSIONS], 'readwrite');
    const sessions = transaction.objectStore(SESSIONS);
    transaction.objectStore(PACKETS).delete(packetsOf(sessionId, through));
    // A page that is opened again without a link must know how to go on numbering.
    const row = (await done(sessions.get(sessionId))) as SessionRow | undefined;
    if (row) sessions.put({ ...row, next: Math.max(row.next, through + 1), usedMs: Date.now() });
    await committed(transaction);
    const unreadable = this.#unreadableOf(sessionId);
    for (const sequence of unreadable) if (sequence <= through) unreadable.delete(sequence);
  }

  /** How many packets wait; without those that were read and cannot be opened, which nothing waits for. */
  async count(sessionId: string): Promise<number> {
    const all = await done(this.#database.transaction(PACKETS).objectStore(PACKETS).count(packetsOf(sessionId)));
    return all - this.#unreadableOf(sessionId).size;
  }

  /** The highest sequence stored here; -1 when there is none. */
  async highest(sessionId: string): Promise<number> {
    const store = this.#database.transaction(PACKETS).objectStore(PACKETS);
    const cursor = await done(store.openKeyCursor(packetsOf(sessionId), 'prev'));
    return cursor ? ((cursor.key as [string, number])[1] ?? -1) : -1;
  }

  /** Forget a whole session. */
  async remove(sessionId: string): Promise<void> {
    const transaction = this.#database.transaction([PACKETS, SESSIONS], 'readwrite');
    transaction.objectStore(PACKETS).delete(packetsOf(sessionId));
    transaction.objectStore(SESSIONS).delete(sessionId);
    await committed(transaction);
    this.#unreadable.delete(sessionId);
  }

  /** Delete what nobody has sent for weeks, whoever measured it. */
  async removeOld(nowMs = Date.now()): Promise<void> {
    for (const { sessionId, usedMs } of await this.#rows())
      if (nowMs - usedMs > FORGOTTEN_AFTER_DAYS * DAY_MS) await this.remove(sessionId);
  }
}
