// Names of the centre of mass among the scalars of a session.

/** Channels of the centre of mass among the scalars of a result. */
export function massChannels(scalars: readonly string[]): string[] {
  return scalars.filter((name) => /^centre_of_mass_(ahead|left|height)_m$/.test(name));
}
