import { act, fireEvent, screen, waitFor, within } from '@testing-library/react';
import userEvent, { type UserEvent } from '@testing-library/user-event';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { Job, PreviewIn, SensorPreview, TablePreview, UploadIn } from '../../../src/api/types';
import { hasUnsaved, releaseAll } from '../../../src/lib/editing/unsaved';
import { UploadPage } from '../../../src/pages/Upload';
import { renderPage } from '../render';

// Options of a list are scrolled to, which the simulated page cannot do.
Element.prototype.scrollIntoView = () => undefined;

afterEach(() => {
  releaseAll();
  sessionStorage.clear();
  vi.unstubAllGlobals();
});

const job = (change: Partial<Job>): Job => ({
  id: 'j',
  session_id: 's',
  kind: 'upload',
  status: 'failed',
  progress: 0.4,
  message: '',
  is_implausible: false,
  ...change,
});

/** Take what is sent instead of a service: `XMLHttpRequest` alone tells how much of a file has gone. */
function takeUploads(answer: Job): UploadIn[] {
  const declared: UploadIn[] = [];
  vi.stubGlobal(
    'XMLHttpRequest',
    class {
      upload = {};
      status = 202;
      responseText = JSON.stringify(answer);
      onload: () => void = () => undefined;
      open() {}
      setRequestHeader() {}
      send(form: FormData) {
        declared.push(JSON.parse(form.get('declaration') as string) as UploadIn);
        this.onload();
      }
    },
  );
  return declared;
}

const held = { endings: ['.csv'], pipeline: null, asks_pipeline: false, needs_mapping: false, description: '' };
const FORMATS = [
  { ...held, name: 'csv', title: 'Table (CSV)', asks_pipeline: true, needs_mapping: true },
  { ...held, name: 'zipped', title: 'Several tables of one recording (zip)', endings: ['.zip'], asks_pipeline: true },
  { ...held, name: 'packet_log', title: 'Packet log of a gateway', endings: ['.tmlog'], asks_pipeline: true },
  { ...held, name: 'qmt_mat', title: 'Whole-body recording (.mat)', endings: ['.mat'] },
  { ...held, name: 'gait_tracking', title: 'Walk with one foot sensor (x-io, CSV)', pipeline: 'gait' },
  { ...held, name: 'gaitmap', title: 'Walk with both feet (gaitmap, CSV)', pipeline: 'gait' },
  { ...held, name: 'pyshoe', title: 'Walk with one foot sensor (PyShoe, .mat)', endings: ['.mat'], pipeline: 'gait' },
];

const PAGE = {
  '/api/uploads/formats': FORMATS,
  '/api/patients': [{ id: 'p', given_name: 'Amara', family_name: 'Okafor', may_treat: true }],
  '/api/exercises': [],
  '/api/estimators': [{ name: 'vqf', version: '1', title: 'VQF', description: '', parameters: [], is_offline: false }],
};

/** There once the formats are known. */
const fileInput = (container: HTMLElement) =>
  waitFor(() => {
    const found = container.querySelector<HTMLInputElement>('input[type="file"]');
    if (!found) throw new Error('no input yet');
    return found;
  });

async function send(failed: Job) {
  const user = userEvent.setup();
  const declared = takeUploads(job({ status: 'queued' }));
  const view = renderPage(<UploadPage />, {
    at: '/?patient=p',
    answers: { ...PAGE, '/api/jobs/j': failed },
  });
  const input = await fileInput(view.container);
  await user.upload(input, new File(['x'], 'walk.tmlog'));
  await user.click(screen.getByRole('button', { name: 'Upload' }));
  return { user, declared, alert: await screen.findByRole('alert'), container: view.container };
}

const columns = ['t', ...['gyr', 'acc'].flatMap((one) => ['x', 'y', 'z'].map((axis) => `${one}_${axis}`))];
const preview = (change: Partial<TablePreview> = {}): TablePreview => ({
  format: 'csv',
  pipeline: 'orientation',
  columns,
  rows: [columns.map(() => '0')],
  skipped_lines: 1,
  mapping: {
    time_column: 't',
    time_unit: 's',
    signals: [
      { placement: null, sensor: 'imu', quantity: 'gyroscope', columns: columns.slice(1, 4), unit: 'deg/s' },
      { placement: null, sensor: 'imu', quantity: 'accelerometer', columns: columns.slice(4), unit: 'g' },
    ],
  } as TablePreview['mapping'],
  sensors: [],
  notes: ['The unit was assumed.'],
  doubts: [],
  missing: [],
  sentences: {},
  ...change,
});

const SENSOR: SensorPreview = {
  where: 'imu',
  sentence: 'Sensor: gyroscope in °/s (gyr_x, …y, …z) and accelerometer in g (acc_x, …y, …z); 100 samples a second.',
  time_s: [0, 0.01, 0.02],
  gyroscope_radps: [
    [0, 0.1, Math.PI],
    [0, 0, null],
    [0, -0.5, 0],
  ],
  accelerometer_mps2: [
    [0, 0, 0],
    [0, 0, 0],
    [9.8, 9.7, 9.9],
  ],
  magnetometer_t: [],
  sentences: {},
};

const typeDay = () =>
  fireEvent.change(screen.getByLabelText('Day of the recording'), { target: { value: '2026-01-09' } });
const openForm = async (user: UserEvent) => user.click(await screen.findByText('Change what was guessed'));

async function choose(found: TablePreview | [number, unknown]) {
  const user = userEvent.setup();
  const declared = takeUploads(job({ status: 'queued' }));
  const view = renderPage(<UploadPage />, {
    at: '/?patient=p',
    answers: { ...PAGE, 'POST /api/uploads/preview': found, '/api/jobs/j': job({ status: 'running' }) },
  });
  await user.upload(await fileInput(view.container), new File(['t,gyr_x'], 'box.csv'));
  const asked = () =>
    view.asked.filter((one) => one.path === '/api/uploads/preview').map((one) => one.body as PreviewIn);
  return { ...view, user, declared, asked };
}

describe('a file that only its contents describe', () => {
  it('is sent without a format, for the service to recognise it', async () => {
    const user = userEvent.setup();
    const declared = takeUploads(job({ status: 'queued' }));
    const view = renderPage(<UploadPage />, {
      at: '/?patient=p',
      answers: { ...PAGE, '/api/jobs/j': job({ status: 'running' }) },
    });
    const input = await fileInput(view.container);
    await user.upload(input, new File(['x'], 'trial.mat'));
    expect(await screen.findByText('The contents are recognised once the file is uploaded.')).toBeTruthy();
    await user.click(screen.getByRole('button', { name: 'Upload' }));
    expect(declared[0]).toMatchObject({ format: null, file_name: 'trial.mat' });
  });
});

describe('a file that is not what its ending says', () => {
  const take = async (name: string, found: TablePreview | [number, unknown]) => {
    const user = userEvent.setup({ applyAccept: false });
    const declared = takeUploads(job({ status: 'queued' }));
    const view = renderPage(<UploadPage />, {
      at: '/?patient=p',
      answers: { ...PAGE, 'POST /api/uploads/preview': found, '/api/jobs/j': job({ status: 'running' }) },
    });
    await user.upload(await fileInput(view.container), new File(['x'], name));
    return { user, declared };
  };

  it('is called by its name before anything is sent', async () => {
    await take('walk.xlsx', [422, { code: 'invalid_input', message: 'This is a workbook.', details: {} }]);
    expect(await screen.findByText(/This is a workbook/)).toBeTruthy();
  });

  it('and tables in a zip are sent as what their sensors are for', async () => {
    const { user, declared } = await take('phone.zip', preview({ format: 'zipped' }));
    expect(await screen.findByRole('radio', { name: /Single sensors/ })).toHaveProperty('checked', true);
    await user.type(screen.getByLabelText('Day of the recording'), '2026-01-09');
    await user.click(screen.getByRole('button', { name: 'Upload' }));
    expect(declared[0]).toMatchObject({ format: 'zipped', pipeline: 'orientation', csv: null });
  });
});

describe('a table', () => {
  it('is shown as the service guesses it before it is sent, and a single sensor needs no placement', async () => {
    const { user, declared } = await choose(preview());
    expect(await screen.findByText('The unit was assumed.')).toBeTruthy();
    expect(screen.getByRole('radio', { name: /Single sensors/ })).toHaveProperty('checked', true);
    expect(declared).toEqual([]);
    typeDay();
    await user.click(screen.getByRole('button', { name: 'Upload' }));
    expect(declared[0]).toMatchObject({
      format: 'csv',
      pipeline: 'orientation',
      file_name: 'box.csv',
      csv: preview().mapping,
    });
  });

  it('is shown with its columns and first rows', async () => {
    const { user } = await choose(
      preview({
        rows: [
          ['0.00', '1', '2', '3', '4', '5', '6'],
          ['0.01', '7', '8', '9', '10', '11', '12'],
        ],
      }),
    );
    await openForm(user);
    const table = within(await screen.findByRole('region', { name: 'First lines of the file' })).getByRole('table');
    expect(
      within(table)
        .getAllByRole('columnheader')
        .map((one) => one.textContent),
    ).toEqual(columns);
    expect(
      within(table)
        .getAllByRole('row')
        .map((row) => row.textContent),
    ).toEqual([columns.join(''), '0.00123456', '0.01789101112']);
  });

  it('is sent as a person corrects the guess', async () => {
    const { user, declared } = await choose(preview());
    await openForm(user);
    const pick = async (box: string | RegExp, option: string) => {
      await user.click(await screen.findByRole('combobox', { name: box }));
      await user.click(await screen.findByRole('option', { name: option }));
    };
    await pick('Unit of time', 'Times of day as text');
    await pick('Signal 1: unit', 'rad/s');
    await pick('Signal 2: column of x', 'gyr_x');
    typeDay();
    await user.click(screen.getByRole('button', { name: 'Upload' }));
    const [gyroscope, accelerometer] = preview().mapping!.signals;
    expect(declared[0]?.csv).toEqual({
      ...preview().mapping,
      time_unit: 'clock',
      signals: [
        { ...gyroscope, unit: 'rad/s' },
        { ...accelerometer, columns: ['gyr_x', 'acc_y', 'acc_z'] },
      ],
    });
  });

  it('that is none is refused in words and cannot be sent', async () => {
    const { declared } = await choose([
      422,
      { code: 'recording_format', message: 'The file is not text: it holds bytes that no table has.', details: {} },
    ]);
    expect(await screen.findByText(/not text/)).toBeTruthy();
    expect(screen.queryByRole('region', { name: 'First lines of the file' })).toBeNull();
    expect(screen.getByRole('button', { name: 'Upload' })).toHaveProperty('disabled', true);
    expect(declared).toEqual([]);
  });

  it('cannot be sent for joints while nobody has said where its sensor is worn', async () => {
    await choose(preview({ pipeline: 'arm', missing: ['These columns do not say where on the body the sensor is.'] }));
    expect(await screen.findByText(/do not say where/)).toBeTruthy();
    expect(screen.getByText('Choose where each sensor is worn.')).toBeTruthy();
    expect(screen.getByText('Assign the columns first.')).toBeTruthy();
    expect(screen.getByRole('button', { name: 'Upload' })).toHaveProperty('disabled', true);
  });

  it('of a known kind needs no columns', async () => {
    const { user, declared } = await choose(preview({ format: 'gaitmap', pipeline: 'gait', mapping: null }));
    expect(await screen.findByText('Walk with both feet (gaitmap, CSV)')).toBeTruthy();
    expect(screen.queryByRole('radio', { name: /gaitmap/ })).toBeNull();
    typeDay();
    await user.click(screen.getByRole('button', { name: 'Upload' }));
    expect(declared[0]).toMatchObject({ format: 'gaitmap', csv: null });
  });

  it('recognised as something else than it is can be corrected', async () => {
    const { user, declared } = await choose(preview({ format: 'gaitmap', pipeline: 'gait', mapping: null }));
    await user.click(await screen.findByRole('button', { name: 'Not right?' }));
    expect(screen.getByRole('radio', { name: /gaitmap/ })).toHaveProperty('checked', true);
    await user.click(screen.getByRole('radio', { name: /x-io/ }));
    typeDay();
    await user.click(screen.getByRole('button', { name: 'Upload' }));
    expect(declared[0]).toMatchObject({ format: 'gait_tracking' });
  });
});

describe('what a table is taken for', () => {
  it('is said once, also of the next file', async () => {
    const { container, user } = await choose(preview({ sensors: [SENSOR] }));
    await screen.findByText('Recognised as');
    await user.upload(await fileInput(container), new File(['t,gyr_x'], 'other.csv'));
    await screen.findByText('other.csv');
    expect(await screen.findAllByText('Recognised as')).toHaveLength(1);
  });

  it('is said in a sentence with the curves of each sensor, before anything is sent', async () => {
    await choose(preview({ sensors: [SENSOR] }));
    expect(await screen.findByText(/gyroscope in °\/s/)).toBeTruthy();
    expect(screen.getByText('The first 0.0 s')).toBeTruthy();
    expect(
      screen.getByRole('img', { name: 'Sensor, Angular rate: from −29 °/s to 180 °/s in the first seconds' }),
    ).toBeTruthy();
    expect(screen.getByRole('img', { name: /Acceleration: from 0.0 m\/s² to 9.9 m\/s²/ })).toBeTruthy();
    expect(screen.queryByRole('img', { name: /Magnetic field/ })).toBeNull();
  });

  it('is looked at again once it was changed', async () => {
    const { user, asked } = await choose(preview({ sensors: [SENSOR], doubts: ['It cannot be g.'] }));
    expect(await screen.findByText('It cannot be g.')).toBeTruthy();
    await openForm(user);
    await user.click(await screen.findByRole('button', { name: 'Signal 2: column of z, points the other way' }));
    await user.click(await screen.findByRole('combobox', { name: 'Signal 1: unit' }));
    await user.click(await screen.findByRole('option', { name: 'rad/s' }));
    await waitFor(() => expect(asked().at(-1)?.mapping?.signals[0]?.unit).toBe('rad/s'));
    expect(asked().at(-1)?.mapping?.signals[1]?.columns).toEqual(['acc_x', 'acc_y', '-acc_z']);
  });

  it('stays calm with many sensors: only the first one shows its curves until another is opened', async () => {
    const many = Array.from({ length: 17 }, (_, at) => ({
      ...SENSOR,
      where: `s${at}`,
      sentence: `S${at}: as the rest.`,
    }));
    const { container, user } = await choose(preview({ sensors: many }));
    expect(await screen.findByText('17 sensors')).toBeTruthy();
    expect(container.querySelectorAll('.axes-chart')).toHaveLength(2);
    await user.click(screen.getByText('S3'));
    await waitFor(() => expect(container.querySelectorAll('.axes-chart')).toHaveLength(4));
  });

  it('has its hemisphere changed with it where a field is measured', async () => {
    const found = preview({ sensors: [SENSOR] });
    const field = { ...found.mapping!.signals[1]!, quantity: 'magnetometer' as const, unit: 'uT' as const };
    found.mapping = { ...found.mapping!, signals: [...found.mapping!.signals, field] };
    const { user, asked } = await choose(found);
    await openForm(user);
    await user.click(await screen.findByRole('combobox', { name: 'Recorded' }));
    await user.click(await screen.findByRole('option', { name: 'South of the equator' }));
    await waitFor(() => expect(asked()[1]).toMatchObject({ hemisphere: 'south' }));
  });
});

describe('an upload that is left', () => {
  it('asks first, and offers on coming back all but the file, whose corrections hold once it is chosen again', async () => {
    const { user, router, asked, container } = await choose(preview({ sensors: [SENSOR] }));
    await openForm(user);
    await user.click(await screen.findByRole('button', { name: 'Signal 2: column of z, points the other way' }));
    typeDay();
    await act(() => router.navigate('/elsewhere'));
    await user.click(await screen.findByRole('button', { name: 'Leave, go on later' }));
    expect(await screen.findByText('elsewhere')).toBeTruthy();
    await act(() => router.navigate('/?patient=p'));
    await user.click(await screen.findByRole('button', { name: 'Continue with it' }));
    expect(screen.getByLabelText<HTMLInputElement>('Day of the recording').value).toContain('2026');
    expect(screen.getByText(/Choose the file box.csv again/)).toBeTruthy();
    await user.upload(await fileInput(container), new File(['t,gyr_x'], 'box.csv'));
    await waitFor(() => expect(asked().at(-1)?.mapping?.signals[1]?.columns).toEqual(['acc_x', 'acc_y', '-acc_z']));
  });

  it('asks nothing once the service has it', async () => {
    const { user, router } = await choose(preview({ sensors: [SENSOR] }));
    await screen.findByText(/gyroscope in/);
    typeDay();
    await waitFor(() => expect(screen.getByRole('button', { name: 'Upload' })).toHaveProperty('disabled', false));
    await user.click(screen.getByRole('button', { name: 'Upload' }));
    await waitFor(() => expect(hasUnsaved()).toBe(false));
    await act(() => router.navigate('/elsewhere'));
    expect(screen.getByText('elsewhere')).toBeTruthy();
  });
});

describe('upload', () => {
  it('offers to estimate implausible readings only after the service has said what is wrong', async () => {
    const { user, declared, alert, container } = await send(
      job({ is_implausible: true, message: 'forearm_right: the axes do not fit.' }),
    );
    expect(within(alert).getByText(/axes do not fit/)).toBeTruthy();
    expect(declared[0]).toMatchObject({ accept_implausible: false, hemisphere: null });
    await user.click(screen.getByRole('checkbox', { name: 'Analyse it as it is' }));
    await user.click(screen.getByRole('combobox', { name: 'Recorded' }));
    await user.click(await screen.findByRole('option', { name: 'South of the equator' }));
    await user.click(screen.getByRole('button', { name: 'Upload again' }));
    expect(declared[1]).toMatchObject({ accept_implausible: true, hemisphere: 'south', patient_id: 'p' });
    // Of the next file nobody has said it.
    await user.upload(await fileInput(container), new File(['x'], 'another.tmlog'));
    await user.click(screen.getByRole('button', { name: 'Upload' }));
    expect(declared[2]).toMatchObject({ accept_implausible: false, hemisphere: null });
  });

  it('lets a file that could not be read be sent again, with nothing to accept', async () => {
    const { alert } = await send(job({ message: 'The file holds no sound packet.' }));
    expect(within(alert).getByText(/no sound packet/)).toBeTruthy();
    expect(screen.queryByRole('checkbox', { name: 'Analyse it as it is' })).toBeNull();
    expect(screen.getByRole('button', { name: 'Upload again' })).toHaveProperty('disabled', false);
  });
});
