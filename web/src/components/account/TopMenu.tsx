// A menu of the top bar: loaded when it is opened first, because its library is a tenth of what a patient's page loads.
import { Menu } from '@mantine/core';
import { cloneElement, useEffect, useRef, useState, type ReactElement, type Ref } from 'react';
import { useNavigate } from 'react-router';
import { t } from '../../i18n';

export interface TopMenuProps {
  /** The button that opens it. */
  target: ReactElement<{ ref?: Ref<HTMLButtonElement> }>;
  label: string;
  links: readonly { to: string; text: string }[];
  onSignOut: () => void;
}

/** It opens as soon as it is there, and gives the focus back to its button. */
export default function TopMenu({ target, label, links, onSignOut }: TopMenuProps) {
  const navigate = useNavigate();
  const button = useRef<HTMLButtonElement>(null);
  const [isOpen, setOpen] = useState(false);
  useEffect(() => {
    button.current?.focus();
    setOpen(true);
  }, []);
  return (
    <Menu position="bottom-end" width={260} opened={isOpen} onChange={setOpen}>
      <Menu.Target>{cloneElement(target, { ref: button })}</Menu.Target>
      <Menu.Dropdown>
        <Menu.Label>{label}</Menu.Label>
        {links.map((link) => (
          <Menu.Item key={link.to} fz="md" py={12} onClick={() => void navigate(link.to)}>
            {link.text}
          </Menu.Item>
        ))}
        <Menu.Divider />
        <Menu.Item fz="md" py={12} onClick={onSignOut}>
          {t('action.signOut')}
        </Menu.Item>
      </Menu.Dropdown>
    </Menu>
  );
}
