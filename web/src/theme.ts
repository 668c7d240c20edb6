import { createTheme, type MantineColorsTuple } from '@mantine/core';
import { currentLanguage } from './i18n';

// One accent: a quiet deep teal. White on its sixth shade has a contrast of 6.6 to 1.
const accent: MantineColorsTuple = [
  '#eaf5f6',
  '#d3e8ea',
  '#a9d2d6',
  '#7bbac1',
  '#4fa0a9',
  '#24767f',
  '#0f6674',
  '#0c5562',
  '#0a4651',
  '#073740',
];
const gray: MantineColorsTuple = [
  '#f7f8f8',
  '#eff1f1',
  '#e2e6e6',
  '#cfd5d6',
  '#aab3b5',
  '#7d888b',
  '#566164',
  '#3c4649',
  '#262e31',
  '#171d1f',
];
const dark: MantineColorsTuple = [
  '#e9eeef',
  '#b9c3c6',
  '#8d999d',
  '#6b777b',
  '#485358',
  '#343e43',
  '#262f33',
  '#1b2226',
  '#13191c',
  '#0c1012',
];

export const theme = createTheme({
  primaryColor: 'accent',
  primaryShade: { light: 6, dark: 5 },
  colors: { accent, gray, dark },
  fontFamily: "'Atkinson Hyperlegible Next Variable', system-ui, sans-serif",
  fontFamilyMonospace: 'ui-monospace, SFMono-Regular, Menlo, Consolas, monospace',
  headings: { fontFamily: "'Atkinson Hyperlegible Next Variable', system-ui, sans-serif", fontWeight: '650' },
  fontSizes: { xs: '0.875rem', sm: '0.9375rem', md: '1rem', lg: '1.125rem', xl: '1.375rem' },
  defaultRadius: 'md',
  cursorType: 'pointer',
  respectReducedMotion: true,
  components: {
    Button: { defaultProps: { size: 'md' } },
    TextInput: { defaultProps: { size: 'md' } },
    PasswordInput: { defaultProps: { size: 'md' } },
    // Both marks are understood; which one is written follows the language, which is known when the field is drawn.
    NumberInput: {
      defaultProps: () => ({
        size: 'md',
        decimalSeparator: currentLanguage() === 'de' ? ',' : '.',
        allowedDecimalSeparators: ['.', ','],
      }),
    },
    Textarea: { defaultProps: { size: 'md' } },
    Select: { defaultProps: { size: 'md', allowDeselect: false } },
    Checkbox: { defaultProps: { size: 'md' } },
    Radio: { defaultProps: { size: 'md' } },
    Switch: { defaultProps: { size: 'md' } },
    Modal: { defaultProps: { size: 'lg', centered: true } },
    ActionIcon: { defaultProps: { size: 'lg', variant: 'subtle' } },
    Loader: { defaultProps: { type: 'bars' } },
  },
});
