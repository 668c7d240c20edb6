// What was measured and is not yet safe with the service: packets in the browser's own database.

const NAME = 'telemotion-sensors';
const PACKETS = 'packets';
const SESSIONS = 'sessions';

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

export class PacketStore {
  readonly #database: IDBDatabase;

  private constructor(database: IDBDatabase) {
    this.#database = database;
  }

  static async open(factory: IDBFactory = indexedDB): Promise<PacketStore> {
    const request = factory.open(NAME, 1);
    request.onupgradeneeded = () => {
      request.result.createObjectStore(PACKETS, { keyPath: ['sessionId', 'sequence'] });
      request.result.createObjectStore(SESSIONS, { keyPath: 'sessionId' });
    };
    return new PacketStore(await done(request));
  }

  close(): void {
    this.#database.close();
  }

  /** Remember what the packets of a session mean. */
  async declare(network: StoredNetwork): Promise<void> {
    const transaction = this.#database.transaction(SESSIONS, 'readwrite');
    transaction.objectStore(SESSIONS).put(network);
    await committed(transaction);
  }

  async network(sessionId: string): Promise<StoredNetwork | undefined> {
    const store = this.#database.transaction(SESSIONS).objectStore(SESSIONS);
    return (await done(store.get(sessionId))) as StoredNetwork | undefined;
  }

  /** The sessions of one account that have something on this device. */
  async sessions(accountId: string): Promise<StoredNetwork[]> {
    const store = this.#database.transaction(SESSIONS).objectStore(SESSIONS);
    const all = (await done(store.getAll())) as StoredNetwork[];
    return all.filter((one) => one.accountId === accountId);
  }

  /** Resolves when the packet is in the database: only then may it be sent. */
  async put(sessionId: string, sequence: number, bytes: Uint8Array): Promise<void> {
    const transaction = this.#database.transaction(PACKETS, 'readwrite');
    transaction.objectStore(PACKETS).put({ sessionId, sequence, bytes });
    await committed(transaction);
  }

  /** Packets from a sequence on, in order, at most so many. */
  async read(sessionId: string, from: number, most: number, to = Infinity): Promise<StoredPacket[]> {
    const range = IDBKeyRange.bound([sessionId, from], [sessionId, to]);
    const store = this.#database.transaction(PACKETS).objectStore(PACKETS);
    return (await done(store.getAll(range, most))) as StoredPacket[];
  }

  /** Forget what is safe: everything up to and including this sequence. */
  async forget(sessionId: string, through: number): Promise<void> {
    const transaction = this.#database.transaction([PACKETS, SESSIONS], 'readwrite');
    const sessions = transaction.objectStore(SESSIONS);
    transaction.objectStore(PACKETS).delete(IDBKeyRange.bound([sessionId, -1], [sessionId, through]));
    // A page that is opened again without a link must know how to go on numbering.
    const network = (await done(sessions.get(sessionId))) as StoredNetwork | undefined;
    if (network) sessions.put({ ...network, next: Math.max(network.next, through + 1) });
    await committed(transaction);
  }

  async count(sessionId: string): Promise<number> {
    const range = IDBKeyRange.bound([sessionId, 0], [sessionId, Infinity]);
    return done(this.#database.transaction(PACKETS).objectStore(PACKETS).count(range));
  }

  /** The highest sequence stored here; -1 when there is none. */
  async highest(sessionId: string): Promise<number> {
    const range = IDBKeyRange.bound([sessionId, 0], [sessionId, Infinity]);
    const store = this.#database.transaction(PACKETS).objectStore(PACKETS);
    const cursor = await done(store.openKeyCursor(range, 'prev'));
    return cursor ? ((cursor.key as [string, number])[1] ?? -1) : -1;
  }

  /** Forget a whole session. */
  async remove(sessionId: string): Promise<void> {
    const transaction = this.#database.transaction([PACKETS, SESSIONS], 'readwrite');
    transaction.objectStore(PACKETS).delete(IDBKeyRange.bound([sessionId, 0], [sessionId, Infinity]));
    transaction.objectStore(SESSIONS).delete(sessionId);
    await committed(transaction);
  }
}
