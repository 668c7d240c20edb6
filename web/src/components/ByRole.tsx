// Which pages are whose: a patient never reaches the workstation, whatever address is typed or linked.
import { matchPath, Navigate, Outlet, useLocation } from 'react-router';
import { useSignedIn } from './account/useSignedIn';

/** Where a patient is sent who opens a page of the staff: to the same session on their own pages, else to their first page. */
export function ownPage(path: string): string {
  const session = matchPath('/sessions/:sessionId/*', path);
  if (!session) return '/';
  const own = `/my/sessions/${session.params.sessionId}`;
  return session.params['*'] === 'live' ? `${own}/live` : own;
}

/** Pages of therapists and administrators. */
export function StaffPages() {
  const me = useSignedIn();
  const { pathname } = useLocation();
  return me.role === 'patient' ? <Navigate to={ownPage(pathname)} replace /> : <Outlet context={me} />;
}

/** The patient's own pages. */
export function OwnPages() {
  const me = useSignedIn();
  return me.role === 'patient' ? <Outlet context={me} /> : <Navigate to="/" replace />;
}
