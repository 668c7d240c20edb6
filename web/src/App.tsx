import { lazy, Suspense, type ComponentType } from 'react';
import { createBrowserRouter, type RouteObject } from 'react-router';
import { OwnPages, StaffPages } from './components/ByRole';
import { Shell } from './components/Shell';
import { useSignedIn } from './components/account/useSignedIn';
import { sentencesReady } from './i18n/languages';
import { CrashPage } from './pages/Crash';
import { NotFoundPage } from './pages/NotFound';
import { SignInPage } from './pages/SignIn';
import { TodayPage } from './pages/mine/Today';

// A patient never needs it.
const CaseloadPage = lazy(async () => ({ default: (await import('./pages/Caseload')).CaseloadPage }));

function Home() {
  const me = useSignedIn();
  if (me.role === 'patient') return <TodayPage />;
  return (
    <Suspense fallback={null}>
      <CaseloadPage />
    </Suspense>
  );
}

/** A page in a piece of its own, opened when the words of the service's sentences are there too: sockets do not wait for them. */
function page<Name extends string>(load: () => Promise<Record<Name, ComponentType>>, name: Name) {
  return async () => {
    const [piece] = await Promise.all([load(), sentencesReady()]);
    return { Component: piece[name] };
  };
}

// Pages that are not the first to be seen come in pieces of their own.
export const routes: RouteObject[] = [
  { path: '/sign-in', element: <SignInPage />, errorElement: <CrashPage /> },
  {
    path: '/',
    element: <Shell />,
    errorElement: <CrashPage />,
    HydrateFallback: () => null,
    children: [
      { index: true, element: <Home /> },
      { path: 'account', lazy: page(() => import('./pages/OwnAccount'), 'OwnAccountPage') },
      {
        element: <OwnPages />,
        children: [
          { path: 'my/results', lazy: page(() => import('./pages/mine/Results'), 'ResultsPage') },
          { path: 'my/data', lazy: page(() => import('./pages/mine/MyData'), 'MyDataPage') },
          {
            path: 'my/sessions/:sessionId',
            lazy: page(() => import('./pages/mine/Replay'), 'MyReplayPage'),
          },
          {
            path: 'my/sessions/:sessionId/live',
            lazy: page(() => import('./pages/mine/Live'), 'MyLivePage'),
          },
        ],
      },
      {
        element: <StaffPages />,
        children: [
          {
            path: 'patients/new',
            lazy: page(() => import('./pages/PatientNew'), 'PatientNewPage'),
          },
          {
            path: 'patients/:patientId',
            lazy: page(() => import('./pages/patient/PatientPage'), 'PatientPage'),
          },
          {
            path: 'patients/:patientId/sessions/new',
            lazy: page(() => import('./pages/session/NewSession'), 'NewSessionPage'),
          },
          {
            path: 'sessions/:sessionId',
            lazy: page(() => import('./pages/session/replay/SessionPage'), 'SessionPage'),
          },
          {
            path: 'sessions/:sessionId/live',
            lazy: page(() => import('./pages/session/live/LiveSession'), 'LiveSessionPage'),
          },
          {
            path: 'sessions/:sessionId/gait',
            lazy: page(() => import('./kinds/walk/GaitPage'), 'GaitPage'),
          },
          {
            path: 'patients/:patientId/walks',
            lazy: page(() => import('./kinds/walk/ConditionsPage'), 'ConditionsPage'),
          },
          {
            path: 'patients/:patientId/report',
            lazy: page(() => import('./pages/report/CoursePage'), 'CoursePage'),
          },
          {
            path: 'sessions/:sessionId/estimators',
            lazy: page(() => import('./pages/session/replay/EstimatorsPage'), 'EstimatorsPage'),
          },
          {
            path: 'sessions/:sessionId/report',
            lazy: page(() => import('./pages/report/ReportPage'), 'ReportPage'),
          },
          {
            path: 'templates/record',
            lazy: page(() => import('./pages/template/RecordTemplate'), 'RecordTemplatePage'),
          },
          {
            path: 'templates/versions/:versionId',
            lazy: page(() => import('./pages/template/editor/EditTemplate'), 'EditTemplatePage'),
          },
          { path: 'exercises', lazy: page(() => import('./pages/Exercises'), 'ExercisesPage') },
          {
            path: 'exercises/:exerciseId',
            lazy: page(() => import('./pages/ExercisePage'), 'ExercisePage'),
          },
          { path: 'clinic', lazy: page(() => import('./pages/Clinic'), 'ClinicPage') },
          { path: 'accuracy', lazy: page(() => import('./pages/Accuracy'), 'AccuracyPage') },
          { path: 'upload', lazy: page(() => import('./pages/Upload'), 'UploadPage') },
        ],
      },
      { path: '*', element: <NotFoundPage /> },
    ],
  },
];

export const router = createBrowserRouter(routes);
