import { useOutletContext } from 'react-router';
import type { Me } from '../../api/types';

/** The signed-in person; only for pages inside the shell. */
export function useSignedIn(): Me {
  return useOutletContext<Me>();
}
