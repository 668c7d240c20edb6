// Head of every page: where we are, its name, what can be done here.
import { useEffect, type ReactNode } from 'react';
import { Link } from 'react-router';
import { t } from '../i18n';
import './Page.css';

export interface Crumb {
  to: string;
  text: string;
}

export interface PageProps {
  title: string;
  lead?: ReactNode;
  crumbs?: Crumb[];
  actions?: ReactNode;
  /** One column for reading and forms. */
  narrow?: boolean;
  /** A low head, where the content needs the height. */
  compact?: boolean;
  children: ReactNode;
}

export function Page({ title, lead, crumbs, actions, narrow, compact, children }: PageProps) {
  useEffect(() => {
    document.title = `${title} · ${t('product.name')}`;
  }, [title]);
  return (
    <div className={`page ${narrow ? 'page-narrow' : ''} ${compact ? 'page-compact' : ''}`}>
      <header className="page-head">
        <div>
          {crumbs?.some((crumb) => crumb.text !== title) && (
            <nav className="crumbs" aria-label={t('nav.path')}>
              {crumbs
                .filter((crumb) => crumb.text !== title)
                .map((crumb, place) => (
                  <span key={crumb.to}>
                    {place > 0 && <span aria-hidden>/ </span>}
                    <Link to={crumb.to}>{crumb.text}</Link>
                  </span>
                ))}
            </nav>
          )}
          <h1>{title}</h1>
          {lead && <p className="lead">{lead}</p>}
        </div>
        {actions && <div className="actions">{actions}</div>}
      </header>
      {children}
    </div>
  );
}
