// What the service is shown of a file before anything is uploaded.
import { beginningsOf } from './zipped';

/** How much of a file the service is shown. */
export const BEGINNING_BYTES = 256 * 1024;
const LATER_BYTES = 32 * 1024;
const MOST_LATER = 12;
const ZIP_MARK = 'PK\x03\x04';

/** The beginning of a file in base64; of a zip that is larger, the beginnings of its tables as a small zip. */
export async function beginningOf(file: Blob): Promise<string> {
  const start = await base64Of(file.slice(0, BEGINNING_BYTES));
  if (file.size <= BEGINNING_BYTES || !atob(start.slice(0, 8)).startsWith(ZIP_MARK)) return start;
  // Damaged, or a browser that cannot unpack: the service says what it can of the first bytes.
  const small = await beginningsOf(file, BEGINNING_BYTES - 1).catch(() => null);
  return small ? base64Of(small) : start;
}

/** Pieces spread over the rest of a file, the last one its end: what begins later, as a second device, is in them. */
export async function laterOf(file: Blob): Promise<string[]> {
  const count = Math.min(MOST_LATER, Math.ceil((file.size - BEGINNING_BYTES) / LATER_BYTES));
  if (count <= 0 || atob(await base64Of(file.slice(0, 4))) === ZIP_MARK) return [];
  const last = Math.max(BEGINNING_BYTES, file.size - LATER_BYTES);
  const places = Array.from(
    { length: count },
    (_, k) =>
      // A character of UTF-16 begins at an even place.
      2 * Math.floor((BEGINNING_BYTES + ((last - BEGINNING_BYTES) * (k + 1)) / count) / 2),
  );
  return Promise.all(places.map((place) => base64Of(file.slice(place, place + LATER_BYTES))));
}

function base64Of(blob: Blob): Promise<string> {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    // "data:text/csv;base64,...": an empty file has no comma.
    reader.onload = () => resolve((reader.result as string).split(',')[1] ?? '');
    reader.onerror = () => reject(reader.error ?? new Error('the file cannot be read'));
    reader.readAsDataURL(blob);
  });
}
