// What the service is shown of a file before anything is uploaded.
import { beginningsOf } from './zipped';

/** How much of a file the service is shown. */
export const BEGINNING_BYTES = 256 * 1024;
const ZIP_MARK = 'PK\x03\x04';

/** The beginning of a file in base64; of a zip that is larger, the beginnings of its tables as a small zip. */
export async function beginningOf(file: Blob): Promise<string> {
  const start = await base64Of(file.slice(0, BEGINNING_BYTES));
  if (file.size <= BEGINNING_BYTES || !atob(start.slice(0, 8)).startsWith(ZIP_MARK)) return start;
  // Damaged, or a browser that cannot unpack: the service says what it can of the first bytes.
  const small = await beginningsOf(file, BEGINNING_BYTES - 1).catch(() => null);
  return small ? base64Of(small) : start;
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
