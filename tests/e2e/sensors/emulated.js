// Sensors that are not there, for tests: a phone's motion events, and Bluetooth sensors that speak their real bytes.
// `emulatePhone` and `emulateDots` begin: samples by tick, then sensor, six values each (rad/s, m/s^2).
(() => {
  const STEP_MS = 10;
  /** Times of the ticks on the clock of the page, so that they lie on even ticks counted from 1970. */
  const begin = (rateHz) => {
    const stepMs = 1000 / rateHz;
    const first = Math.ceil((performance.timeOrigin + performance.now()) / stepMs);
    return { first, at: (number) => (first + number) * stepMs - performance.timeOrigin };
  };
  const degrees = (value) => (value * 180) / Math.PI;
  /** Emit the samples in their order; each rest, [from, until), over and over until `emulated.goOn()`. */
  const play = (count, at, emit, rests = []) => {
    const waiting = [...rests];
    let next = 0;
    let sample = 0;
    window.emulated.goOn = () => waiting.shift();
    const timer = setInterval(() => {
      for (; sample < count && at(next) <= performance.now(); next += 1, sample += 1) {
        if (waiting.length > 0 && sample === waiting[0][1]) sample = waiting[0][0];
        // Where a sample came out: what is true of it is known by its place in the recording.
        window.emulated.shift = next - sample;
        window.emulated.order.push(sample);
        emit(next, sample);
      }
      window.emulated.emitted = next;
      window.emulated.sample = sample;
      if (sample >= count) clearInterval(timer);
    }, STEP_MS);
  };

  window.emulated = { emitted: 0, first: 0, sample: 0, shift: 0, order: [] };

  window.emulatePhone = ({ rateHz, samples, rests, sign = 1 }) => {
    const { first, at } = begin(rateHz);
    window.emulated.first = first;
    const emit = (number, sample) => {
      const [gx, gy, gz, ax, ay, az] = samples[sample];
      const event = new DeviceMotionEvent('devicemotion', {
        rotationRate: { alpha: degrees(gx), beta: degrees(gy), gamma: degrees(gz) },
        accelerationIncludingGravity: { x: sign * ax, y: sign * ay, z: sign * az },
        interval: 16,
      });
      Object.defineProperty(event, 'timeStamp', { value: at(number) });
      window.dispatchEvent(event);
    };
    play(samples.length, at, emit, rests);
  };

  const uuid = (short) => `1517${short}-4947-11e9-8646-d663bd873d93`;

  class Characteristic extends EventTarget {
    constructor({ write = () => {}, read = () => new DataView(new ArrayBuffer(0)) }) {
      super();
      Object.assign(this, { write, read, isNotifying: false, value: undefined });
    }
    async startNotifications() {
      this.isNotifying = true;
      return this;
    }
    async stopNotifications() {
      this.isNotifying = false;
      return this;
    }
    async readValue() {
      return this.read();
    }
    async writeValue(bytes) {
      this.write(new Uint8Array(bytes));
    }
    say(view) {
      if (!this.isNotifying) return;
      this.value = view;
      this.dispatchEvent(new Event('characteristicvaluechanged'));
    }
  }

  /** A Movella DOT: measures in mode 21 at 60 Hz once it was told both in the vendor's bytes. */
  class Dot extends EventTarget {
    constructor(name, clockUs) {
      super();
      Object.assign(this, { id: name, name, clockUs, isAway: false, isMeasuring: false, rateHz: 0, sinceMs: 0 });
      const control = ([mask, ...rest]) => {
        if (mask === 16) this.rateHz = rest[23] + 256 * rest[24];
      };
      const measure = ([type, isOn, mode]) => {
        if (type === 1 && mode === 21) this.isMeasuring = isOn === 1 && this.rateHz === 60;
        this.sinceMs = performance.now();
      };
      this.payload = new Characteristic({});
      const battery = new Characteristic({ read: () => new DataView(Uint8Array.of(83, 0).buffer) });
      const table = {
        1000: { 1002: new Characteristic({ write: control }) },
        2000: { 2001: new Characteristic({ write: measure }), 2003: this.payload },
        3000: { 3001: battery },
      };
      const find = (within, wanted) => {
        const found = Object.keys(within).find((short) => uuid(short) === wanted);
        if (!found || !this.gatt.connected) throw new DOMException('no such service', 'NotFoundError');
        return within[found];
      };
      this.gatt = {
        connected: false,
        connect: async () => {
          if (this.isAway) throw new DOMException('out of reach', 'NetworkError');
          this.gatt.connected = true;
          return this.gatt;
        },
        disconnect: () => this.leave(),
        getPrimaryService: async (service) => {
          const characteristics = find(table, service);
          return { getCharacteristic: async (name_) => find(characteristics, name_) };
        },
      };
    }
    leave() {
      if (!this.gatt.connected) return;
      Object.assign(this, { isMeasuring: false, rateHz: 0 });
      this.gatt.connected = false;
      this.payload.isNotifying = false;
      this.dispatchEvent(new Event('gattserverdisconnected'));
    }
    tell(number, atMs, stepUs, [gx, gy, gz, ax, ay, az]) {
      // A page that was held up emits late: what a sensor felt while it was away is lost all the same.
      if (!this.isMeasuring || atMs < this.sinceMs) return;
      const view = new DataView(new ArrayBuffer(28));
      view.setUint32(0, (this.clockUs + Math.round(number * stepUs)) % 2 ** 32, true);
      [ax, ay, az, degrees(gx), degrees(gy), degrees(gz)].forEach((one, at) => view.setFloat32(4 + 4 * at, one, true));
      this.payload.say(view);
    }
  }

  /** As many sensors as the samples have; the chooser offers the next each time. */
  window.emulateDots = ({ rateHz, samples, rests }) => {
    // The clock of the first wraps during the test, as it does once in 71 minutes.
    const dots = samples[0].map((_, sensor) => new Dot(`Movella DOT ${sensor + 1}`, 2 ** 32 - 20e6 + sensor * 7e6));
    let offered = 0;
    Object.defineProperty(navigator, 'bluetooth', {
      configurable: true,
      value: {
        requestDevice: async ({ filters, optionalServices }) => {
          const dot = dots[offered++ % dots.length];
          const isFound = filters.some(({ namePrefix }) => dot.name.startsWith(namePrefix));
          if (!isFound || !optionalServices.includes(uuid('2000'))) throw new DOMException('', 'NotFoundError');
          return dot;
        },
      },
    });
    const { first, at } = begin(rateHz);
    Object.assign(window.emulated, { first, dots });
    play(
      samples.length,
      at,
      (number, sample) => {
        const stepUs = 1e6 / rateHz;
        dots.forEach((dot, sensor) => dot.tell(number, at(number), stepUs, samples[sample][sensor]));
      },
      rests,
    );
  };
})();
