import { lazy, Suspense } from 'react';
import { createBrowserRouter, type RouteObject } from 'react-router';
import { OwnPages, StaffPages } from './components/ByRole';
import { Shell } from './components/Shell';
import { useSignedIn } from './components/account/useSignedIn';
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
      { path: 'account', lazy: async () => ({ Component: (await import('./pages/OwnAccount')).OwnAccountPage }) },
      {
        element: <OwnPages />,
        children: [
          { path: 'my/results', lazy: async () => ({ Component: (await import('./pages/mine/Results')).ResultsPage }) },
          { path: 'my/data', lazy: async () => ({ Component: (await import('./pages/mine/MyData')).MyDataPage }) },
          {
            path: 'my/sessions/:sessionId',
            lazy: async () => ({ Component: (await import('./pages/mine/Replay')).MyReplayPage }),
          },
          {
            path: 'my/sessions/:sessionId/live',
            lazy: async () => ({ Component: (await import('./pages/mine/Live')).MyLivePage }),
          },
        ],
      },
      {
        element: <StaffPages />,
        children: [
          {
            path: 'patients/new',
            lazy: async () => ({ Component: (await import('./pages/PatientNew')).PatientNewPage }),
          },
          {
            path: 'patients/:patientId',
            lazy: async () => ({ Component: (await import('./pages/patient/PatientPage')).PatientPage }),
          },
          {
            path: 'patients/:patientId/sessions/new',
            lazy: async () => ({ Component: (await import('./pages/session/NewSession')).NewSessionPage }),
          },
          {
            path: 'sessions/:sessionId',
            lazy: async () => ({ Component: (await import('./pages/session/replay/SessionPage')).SessionPage }),
          },
          {
            path: 'sessions/:sessionId/live',
            lazy: async () => ({ Component: (await import('./pages/session/live/LiveSession')).LiveSessionPage }),
          },
          {
            path: 'sessions/:sessionId/gait',
            lazy: async () => ({ Component: (await import('./kinds/walk/GaitPage')).GaitPage }),
          },
          {
            path: 'patients/:patientId/walks',
            lazy: async () => ({ Component: (await import('./kinds/walk/ConditionsPage')).ConditionsPage }),
          },
          {
            path: 'patients/:patientId/report',
            lazy: async () => ({ Component: (await import('./pages/report/CoursePage')).CoursePage }),
          },
          {
            path: 'sessions/:sessionId/estimators',
            lazy: async () => ({ Component: (await import('./pages/session/replay/EstimatorsPage')).EstimatorsPage }),
          },
          {
            path: 'sessions/:sessionId/report',
            lazy: async () => ({ Component: (await import('./pages/report/ReportPage')).ReportPage }),
          },
          {
            path: 'templates/record',
            lazy: async () => ({ Component: (await import('./pages/template/RecordTemplate')).RecordTemplatePage }),
          },
          {
            path: 'templates/versions/:versionId',
            lazy: async () => ({
              Component: (await import('./pages/template/editor/EditTemplate')).EditTemplatePage,
            }),
          },
          { path: 'exercises', lazy: async () => ({ Component: (await import('./pages/Exercises')).ExercisesPage }) },
          {
            path: 'exercises/:exerciseId',
            lazy: async () => ({ Component: (await import('./pages/ExercisePage')).ExercisePage }),
          },
          { path: 'clinic', lazy: async () => ({ Component: (await import('./pages/Clinic')).ClinicPage }) },
          { path: 'accuracy', lazy: async () => ({ Component: (await import('./pages/Accuracy')).AccuracyPage }) },
          { path: 'upload', lazy: async () => ({ Component: (await import('./pages/Upload')).UploadPage }) },
        ],
      },
      { path: '*', element: <NotFoundPage /> },
    ],
  },
];

export const router = createBrowserRouter(routes);
