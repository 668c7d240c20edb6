/** Colours of the three coils, on the time line as in the 3D picture. */
export const COIL_COLOURS = ['--tm-series-2', '--tm-series-4', '--tm-series-3'] as const;
