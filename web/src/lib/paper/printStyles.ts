// Measuring on a screen as on paper: for one moment the rules of print hold, and nothing is drawn in between.

function* mediaRules(rules: CSSRuleList): Generator<CSSMediaRule> {
  for (const rule of rules) {
    if (rule instanceof CSSMediaRule) yield rule;
    if (rule instanceof CSSMediaRule || rule instanceof CSSSupportsRule) yield* mediaRules(rule.cssRules);
  }
}

/** A style sheet of elsewhere, as an extension of the browser adds one, shows its rules to nobody. */
function rulesOf(sheet: CSSStyleSheet): CSSRuleList | null {
  try {
    return sheet.cssRules;
  } catch {
    return null;
  }
}

/** Do something while the page has the styles of print; only what is done at once. */
export function withPrintStyles<T>(work: () => T): T {
  const before: [MediaList, string][] = [];
  for (const sheet of document.styleSheets) {
    const rules = rulesOf(sheet);
    if (!rules) continue;
    for (const { media } of mediaRules(rules)) {
      const words = media.mediaText;
      const now = /\bprint\b/.test(words) ? 'all' : /\bscreen\b/.test(words) ? 'not all' : words;
      if (now === words) continue;
      before.push([media, words]);
      media.mediaText = now;
    }
  }
  try {
    return work();
  } finally {
    for (const [media, words] of before) media.mediaText = words;
  }
}
