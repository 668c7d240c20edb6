/** Sessions that show how much one differs from another. */
export const BASELINE = 3;
