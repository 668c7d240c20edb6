// Sensors that are not there, for tests: a phone's motion events, and Bluetooth sensors that speak their real bytes.
// `emulate({rateHz, samples})` begins: samples by tick, then sensor, six values each (rad/s, m/s^2).
(() => {
  const STEP_MS = 10;
  /** Times of the ticks on the clock of the page, so that they lie on even ticks counted from 1970. */
  const begin = (rateHz) => {
    const stepMs = 1000 / rateHz;
    const first = Math.ceil((performance.timeOrigin + performance.now()) / stepMs);
    return { first, at: (number) => (first + number) * stepMs - performance.timeOrigin };
  };
  const degrees = (value) => (value * 180) / Math.PI;
  const play = (count, at, emit) => {
    let next = 0;
    const timer = setInterval(() => {
      for (; next < count && at(next) <= performance.now(); next += 1) emit(next);
      window.emulated.emitted = next;
      if (next >= count) clearInterval(timer);
    }, STEP_MS);
  };

  window.emulated = { emitted: 0, first: 0 };

  window.emulatePhone = ({ rateHz, samples, sign = 1 }) => {
    const { first, at } = begin(rateHz);
    window.emulated.first = first;
    play(samples.length, at, (number) => {
      const [gx, gy, gz, ax, ay, az] = samples[number];
      const event = new DeviceMotionEvent('devicemotion', {
        rotationRate: { alpha: degrees(gx), beta: degrees(gy), gamma: degrees(gz) },
        accelerationIncludingGravity: { x: sign * ax, y: sign * ay, z: sign * az },
        interval: 16,
      });
      Object.defineProperty(event, 'timeStamp', { value: at(number) });
      window.dispatchEvent(event);
    });
  };
})();
