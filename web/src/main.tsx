// Before all else, so that the words come while the rest is read.
import { firstWords } from './i18n/first';
import '@mantine/core/styles.css';
import '@fontsource-variable/atkinson-hyperlegible-next';
import 'uplot/dist/uPlot.min.css';
// In this order: what comes later refines what came before.
import './styles/base.css';
import './styles/content.css';
import './styles/motion.css';
import './styles/adapt.css';
import './styles/gait.css';
import './styles/sheets.css';
import './styles/doing.css';
import './styles/home.css';
import { MantineProvider } from '@mantine/core';
import { QueryClient, QueryClientProvider } from '@tanstack/react-query';
import { StrictMode } from 'react';
import { createRoot } from 'react-dom/client';
import { RouterProvider } from 'react-router';
import { ApiError } from './api/client';
import { key } from './api/address';
import { meQuery } from './api/queries';
import { wantedSignOut, type SignOutReason } from './api/signOut';
import { router } from './App';
import { SignedOutFirst } from './components/account/SignedOutFirst';
import { isNotFetched } from './lib/browser/pieces';
import { pruneDrafts } from './lib/editing/drafts';
import { theme } from './theme';

const queryClient = new QueryClient({
  defaultOptions: {
    queries: {
      staleTime: 5_000,
      // What the service refused stays refused; only a lost connection is worth another try.
      retry: (count, error) => error instanceof ApiError && (error.status === 0 || error.status === 503) && count < 3,
      refetchOnWindowFocus: false,
      // Without a network the page says so at once, and looks again until the service answers.
      networkMode: 'always',
      refetchInterval: (query) => (isNotFetched(query.state.error) ? 5_000 : false),
    },
    // Without a network what was pressed fails at once, and the page says so; it never waits in silence.
    mutations: { networkMode: 'always' },
  },
});

// A sign-in that ended anywhere ends everywhere: the next render shows the sign-in page.
queryClient.getQueryCache().config.onError = (error) => {
  if (error instanceof ApiError && error.status === 401) queryClient.setQueryData(key('me'), null);
};

pruneDrafts();

const toSignIn = (reason: SignOutReason) =>
  void router.navigate(reason === 'idle' ? '/sign-in?ended=idle' : '/sign-in', { replace: true });

const root = document.getElementById('root');
if (!root) throw new Error('index.html has no element #root');
function draw(element: HTMLElement): void {
  createRoot(element).render(
    <StrictMode>
      <MantineProvider theme={theme} defaultColorScheme="auto">
        <QueryClientProvider client={queryClient}>
          <SignedOutFirst onEnded={toSignIn}>
            <RouterProvider router={router} />
          </SignedOutFirst>
        </QueryClientProvider>
      </MantineProvider>
    </StrictMode>,
  );
}

// Asked while the words are still coming. Not awaited at the top: pieces that share code with an entry that waits are cut apart,
// which costs the patient's pages 14 kB.
if (!wantedSignOut()) void queryClient.prefetchQuery(meQuery);
void firstWords.then(() => draw(root));
