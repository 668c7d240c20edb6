// The frame around every page of a signed-in person: skip link, top bar, theme, sign-out.
import { ActionIcon, Button, useComputedColorScheme, useMantineColorScheme } from '@mantine/core';
import { useQueryClient } from '@tanstack/react-query';
import { IconChevronDown, IconMenu2, IconMoon, IconSun } from '@tabler/icons-react';
import {
  cloneElement,
  lazy,
  Suspense,
  useEffect,
  useRef,
  useState,
  type ButtonHTMLAttributes,
  type ReactElement,
} from 'react';
import { Link, Navigate, NavLink, Outlet, useLocation } from 'react-router';
import { useMe } from '../api/queries';
import { giveUpSignIn, showSignInAgain } from '../api/signInAgain';
import { t } from '../i18n';
import '../lib/browser/escape';
import { forgetDraftsOfOthers } from '../lib/editing/drafts';
import { hasUnsaved, releaseAll } from '../lib/editing/unsaved';
import { Problem, Waiting } from './Feedback';
import { IdleWatch } from './account/IdleWatch';
import { SecondFactorRemoved } from './account/SecondFactorRemoved';
import { SecondFactorSet } from './account/SecondFactorSet';
import type { TopMenuProps } from './account/TopMenu';
import { useSignOut } from './account/useSignOut';
import './Shell.css';

const ConfirmDialog = lazy(() => import('./forms/ConfirmDialog'));
const SignInAgain = lazy(() => import('./account/SignInAgain'));

const loadMenu = () => import('./account/TopMenu');
const TopMenu = lazy(loadMenu);
/** After the page: somebody who loses the network must still be able to sign out. */
const LOAD_MENU_MS = 3000;

/** A button that becomes a menu when it is pressed. */
function LateMenu({ target, ...menu }: TopMenuProps) {
  const [isWanted, setWanted] = useState(false);
  useEffect(() => {
    const timer = setTimeout(() => void loadMenu().catch(() => undefined), LOAD_MENU_MS);
    return () => clearTimeout(timer);
  }, []);
  const button = cloneElement(target as ReactElement<ButtonHTMLAttributes<HTMLButtonElement>>, {
    'aria-haspopup': 'menu',
    'aria-expanded': false,
    onClick: () => setWanted(true),
  });
  if (!isWanted) return button;
  return (
    <Suspense fallback={button}>
      <TopMenu target={target} {...menu} />
    </Suspense>
  );
}

export function ThemeToggle() {
  const scheme = useComputedColorScheme('light');
  const { setColorScheme } = useMantineColorScheme();
  const label = scheme === 'dark' ? t('theme.light') : t('theme.dark');
  return (
    <ActionIcon
      size={44}
      color="gray"
      variant="subtle"
      aria-label={label}
      title={label}
      onClick={() => setColorScheme(scheme === 'dark' ? 'light' : 'dark')}
    >
      {scheme === 'dark' ? <IconSun size={21} aria-hidden /> : <IconMoon size={21} aria-hidden />}
    </ActionIcon>
  );
}

export function Wordmark() {
  return (
    <Link to="/" className="wordmark">
      <img src="/mark.svg" alt="" width={28} height={28} />
      {t('product.name')}
    </Link>
  );
}

/** For another account: nothing of the first one's stays in memory. */
const loadAnew = () => window.location.replace('/');

/** Pages for signed-in people only; everybody else is sent to sign in and comes back afterwards. */
export function Shell({ startAnew = loadAnew }: { startAnew?: () => void }) {
  const me = useMe();
  const location = useLocation();
  const main = useRef<HTMLElement>(null);
  const first = useRef(true);
  const [signOutNow, question] = useSignOut(me.data?.account_id ?? '', me.data?.role === 'patient');
  const [again, setAgain] = useState<((isSame: boolean) => void) | null>(null);
  const [asksSignOut, setAsksSignOut] = useState(false);
  const client = useQueryClient();
  const [isAnothers, setAnothers] = useState(false);
  useEffect(
    () =>
      showSignInAgain(
        (done) => setAgain(() => done),
        (account) => {
          releaseAll();
          forgetDraftsOfOthers(account);
          setAnothers(true);
          client.clear();
          startAnew();
        },
      ),
    [client, startAnew],
  );
  const isNobody = me.data === null;
  useEffect(() => {
    if (!isNobody) return;
    giveUpSignIn();
    setAgain(null);
  }, [isNobody]);
  const signOut = () => (hasUnsaved() ? setAsksSignOut(true) : signOutNow());

  // A new page: start at its top, and let a screen reader start there too.
  useEffect(() => {
    if (first.current) {
      first.current = false;
      return;
    }
    window.scrollTo(0, 0);
    main.current?.focus({ preventScroll: true });
  }, [location.pathname]);

  // Until everything is loaded anew, another account sees nothing of the first one's page.
  if (isAnothers) {
    return (
      <div className="page">
        <Waiting lines={6} height={34} />
      </div>
    );
  }
  // Said at the first failure: the tries that follow take their time.
  const problem = me.data === undefined ? me.failureReason : null;
  if (problem) {
    return (
      <div className="page page-narrow">
        <Problem error={problem} onRetry={() => void me.refetch()} />
      </div>
    );
  }
  if (me.data === undefined) {
    return (
      <div className="page">
        <Waiting lines={6} height={34} />
      </div>
    );
  }
  if (me.data === null) {
    const next = location.pathname + location.search;
    return <Navigate to={next === '/' ? '/sign-in' : `/sign-in?next=${encodeURIComponent(next)}`} replace />;
  }
  if (me.data.must && location.pathname !== '/account') return <Navigate to="/account" replace />;
  const isPatient = me.data.role === 'patient';
  const links = isPatient
    ? [
        { to: '/', text: t('nav.today') },
        { to: '/my/results', text: t('nav.myResults') },
        { to: '/my/data', text: t('nav.myData') },
      ]
    : [
        { to: '/', text: t('nav.caseload') },
        { to: '/exercises', text: t('nav.exercises') },
        { to: '/upload', text: t('nav.upload') },
      ];
  // Seldom needed: behind the name, not in the bar.
  const more = [
    ...(me.data.role === 'administrator' ? [{ to: '/clinic', text: t('clinic.accounts') }] : []),
    ...(isPatient ? [] : [{ to: '/accuracy', text: t('nav.accuracy') }]),
    { to: '/account', text: t('account.title') },
  ];
  return (
    <div className={isPatient ? 'shell shell-patient' : 'shell'}>
      <a className="skip-link" href="#main">
        {t('nav.skip')}
      </a>
      <header className="topbar">
        <div className="topbar-in">
          <Wordmark />
          <nav className="topnav" aria-label={t('nav.main')}>
            {links.map((link) => (
              <NavLink key={link.to} to={link.to} end={link.to === '/'}>
                {link.text}
              </NavLink>
            ))}
          </nav>
          <div className="topbar-end">
            <ThemeToggle />
            <LateMenu
              target={
                <Button
                  variant="subtle"
                  color="gray"
                  visibleFrom="sm"
                  h={44}
                  rightSection={<IconChevronDown size={16} aria-hidden />}
                  className="account-button"
                >
                  {me.data.display_name}
                </Button>
              }
              label={`${me.data.clinic_name} · ${t(`role.${me.data.role}`)}`}
              links={more}
              onSignOut={signOut}
            />
            <LateMenu
              target={
                <ActionIcon hiddenFrom="sm" size={44} color="gray" variant="subtle" aria-label={t('nav.menu')}>
                  <IconMenu2 size={24} aria-hidden />
                </ActionIcon>
              }
              label={me.data.display_name}
              links={[...links, ...more]}
              onSignOut={signOut}
            />
          </div>
        </div>
      </header>
      {question}
      <Suspense fallback={null}>
        {asksSignOut && (
          <ConfirmDialog
            isOpen
            isGrave
            title={t('unsaved.signOutTitle')}
            text={t('unsaved.signOutText')}
            confirm={t('unsaved.signOut')}
            onConfirm={signOutNow}
            onClose={() => setAsksSignOut(false)}
          />
        )}
        {again && (
          <SignInAgain
            me={me.data}
            onDone={(isSame) => {
              again(isSame);
              setAgain(null);
            }}
          />
        )}
      </Suspense>
      <IdleWatch minutes={me.data.idle_minutes} />
      <main id="main" tabIndex={-1} ref={main}>
        {me.data.second_factor_since && <SecondFactorSet since={me.data.second_factor_since} />}
        {me.data.second_factor_removed_at && <SecondFactorRemoved at={me.data.second_factor_removed_at} />}
        <Outlet context={me.data} />
      </main>
    </div>
  );
}
