import { screen, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { Job, UploadIn } from '../../src/api/types';
import { UploadPage } from '../../src/pages/Upload';
import { renderPage } from './render';

// Options of a list are scrolled to, which the simulated page cannot do.
Element.prototype.scrollIntoView = () => undefined;

afterEach(() => vi.unstubAllGlobals());

const job = (change: Partial<Job>): Job => ({ id: 'j', session_id: 's', kind: 'upload', status: 'failed', progress: 0.4, message: '', is_implausible: false, ...change });

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

async function send(failed: Job) {
  const user = userEvent.setup();
  const declared = takeUploads(job({ status: 'queued' }));
  const view = renderPage(<UploadPage />, {
    at: '/?patient=p',
    answers: {
      '/api/patients': [{ id: 'p', given_name: 'Amara', family_name: 'Okafor', may_treat: true }],
      '/api/exercises': [],
      '/api/estimators': [{ name: 'vqf', version: '1', title: 'VQF', description: '', parameters: [], is_offline: false }],
      '/api/jobs/j': failed,
    },
  });
  const input = view.container.querySelector('input[type="file"]') as HTMLInputElement;
  await user.upload(input, new File(['x'], 'walk.tmlog'));
  await user.click(screen.getByRole('button', { name: 'Upload' }));
  return { user, declared, alert: await screen.findByRole('alert') };
}

describe('upload', () => {
  it('offers to estimate implausible readings only after the service has said what is wrong', async () => {
    const { user, declared, alert } = await send(job({ is_implausible: true, message: 'forearm_right: the axes do not fit.' }));
    expect(within(alert).getByText(/axes do not fit/)).toBeTruthy();
    expect(declared[0]).toMatchObject({ accept_implausible: false, hemisphere: 'north' });
    await user.click(screen.getByRole('checkbox', { name: 'Analyse it as it is' }));
    await user.click(screen.getByRole('combobox', { name: 'Recorded' }));
    await user.click(await screen.findByRole('option', { name: 'South of the equator' }));
    await user.click(screen.getByRole('button', { name: 'Upload again' }));
    expect(declared[1]).toMatchObject({ accept_implausible: true, hemisphere: 'south', patient_id: 'p' });
  });

  it('lets a file that could not be read be sent again, with nothing to accept', async () => {
    const { alert } = await send(job({ message: 'The file holds no sound packet.' }));
    expect(within(alert).getByText(/no sound packet/)).toBeTruthy();
    expect(screen.queryByRole('checkbox', { name: 'Analyse it as it is' })).toBeNull();
    expect(screen.getByRole('button', { name: 'Upload again' })).toHaveProperty('disabled', false);
  });
});
