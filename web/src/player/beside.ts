// A player with further columns that were read as a whole: what is computed of a stored session beside its frames.
import type { Player } from './types';

/** First place in times that rise at which one is not before a moment. */
function placeOf(timeS: Float64Array, momentS: number): number {
  let [low, high] = [0, timeS.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((timeS[middle] ?? 0) < momentS) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** The same player; where one of these columns is read, all are those, and what else was asked for comes empty. */
export function withColumns(player: Player, timeS: Float64Array, columns: ReadonlyMap<string, Float32Array>): Player {
  return {
    getSnapshot: () => player.getSnapshot(),
    subscribe: (listener) => player.subscribe(listener),
    clock: () => player.clock(),
    play: () => player.play(),
    pause: () => player.pause(),
    seek: (at) => player.seek(at),
    setSpeed: (speed) => player.setSpeed(speed),
    close: () => player.close(),
    read: (startS, endS, names, maxPoints) => {
      if (!names.some((name) => columns.has(name))) return player.read(startS, endS, names, maxPoints);
      const [first, stop] = [placeOf(timeS, startS), placeOf(timeS, endS)];
      return {
        timeS: timeS.slice(first, stop),
        values: names.map((name) => columns.get(name)?.slice(first, stop) ?? new Float32Array(0)),
        isComplete: true,
      };
    },
  };
}
