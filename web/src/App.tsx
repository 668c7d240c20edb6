import { createBrowserRouter } from 'react-router';
import { Shell } from './components/Shell';
import { useSignedIn } from './components/useSignedIn';
import { CaseloadPage } from './pages/Caseload';
import { CrashPage } from './pages/Crash';
import { NotFoundPage } from './pages/NotFound';
import { SignInPage } from './pages/SignIn';

function Home() {
  const me = useSignedIn();
  return me.role === 'patient' ? null : <CaseloadPage />;
}

export const router = createBrowserRouter([
  { path: '/sign-in', element: <SignInPage />, errorElement: <CrashPage /> },
  {
    path: '/',
    element: <Shell />,
    errorElement: <CrashPage />,
    children: [
      { index: true, element: <Home /> },
      { path: '*', element: <NotFoundPage /> },
    ],
  },
]);
