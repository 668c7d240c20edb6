// The browser and the command line guess the same of the same files; tests/app/ingest/test_tables.py reads them too.
import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import type { Placement } from '../../src/api/types';
import { guessMapping, type CsvDraft } from '../../src/lib/csv';
import { readHead } from '../../src/lib/tableHead';

const FOLDER = `${import.meta.dirname}/../../../tests/data/tables`;
const EXPECTED = JSON.parse(readFileSync(`${FOLDER}/expected.json`, 'utf8')) as Record<string, { skipped_lines: number; columns: string[]; first_row: string[]; mapping: CsvDraft }>;
const PLACEMENTS: Placement[] = ['head', 'sternum', 'pelvis', 'forearm_left', 'forearm_right'];

describe('tables of other devices', () => {
  it.each(Object.entries(EXPECTED))('%s is read as the command line reads it', (name, expected) => {
    const head = readHead(readFileSync(`${FOLDER}/${name}`, 'utf8'));
    expect(head.columns).toEqual(expected.columns);
    expect(new Set(head.columns).size).toBe(head.columns.length);
    expect(head.skippedLines).toBe(expected.skipped_lines);
    expect(head.rows[0]).toEqual(expected.first_row);
    expect(guessMapping(head, PLACEMENTS)).toEqual(expected.mapping);
  });
});
