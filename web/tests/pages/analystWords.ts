/** Words of those who build, run or analyse: none of them stands on a page of a patient. */
export const ANALYST_WORDS: readonly RegExp[] = [
  /\bcaseload\b/i,
  /\bgateway/i,
  /\bdelay\b/i,
  /\blatency\b/i,
  /\bjitter\b/i,
  /\bpackets?\b/i,
  /\bstream/i,
  /\btokens?\b/i,
  /\btickets?\b/i,
  /\bserver\b/i,
  /\bcommand/i,
  /\btelemotion \w+ --|\s--\w/,
  /\bwss?:|\bhttps?:|\/ws\/|\/api\//,
  /\bestimat/i,
  /\balgorithm/i,
  /\bpipeline/i,
  /\bcalibrat/i,
  /\bN-pose\b|\bT-pose\b/i,
  /\bgyroscope|\baccelerometer|\bmagnet|\bcompass/i,
  /\bheading\b|\byaw\b|\bpitch\b|\broll\b/i,
  /\bangles?\b/i,
  /\bflexion\b|\bextension\b|\babduction\b|\bpronation\b|\bdeviation\b/i,
  /\bthorax\b|\bhumerus\b|\bradius\b|\bulna\b/i,
  /\bquaternion|\borientation\b|\baxis\b|\baxes\b/i,
  /\bsigma\b|σ|±/i,
  /\buncertaint|\bstandard deviation\b|\bRMS\b|\bresidual/i,
  /\bscore\b|\bof 100\b|\d\s?%/i,
  /\bquality\b|\bsmoothness\b|\bSPARC\b/i,
  /\btemplate/i,
  /\bwarp/i,
  /\bbands?\b/i,
  /\d\s?(?:ms|Hz|ppm|rad|dB)\b/,
  /\brange of motion\b/i,
  /\bnull\b|\bundefined\b|\bNaN\b|\{\w+\}/,
  // Codes of the service.
  /\b[a-z]+_[a-z]+\b/,
];

/** Every analyst's word in what a person can see or hear of a page. */
export function analystWordsIn(root: ParentNode): string[] {
  const texts: string[] = [];
  for (const element of root.querySelectorAll('*')) {
    if (element.tagName === 'STYLE' || element.tagName === 'SCRIPT') continue;
    for (const node of element.childNodes) if (node.nodeType === Node.TEXT_NODE) texts.push(node.textContent ?? '');
    // How far holding still has come is a share of time, and no judgement.
    if (element.getAttribute('role') === 'progressbar') continue;
    for (const name of ['aria-label', 'aria-valuetext', 'aria-description', 'title', 'placeholder', 'alt'])
      texts.push(element.getAttribute(name) ?? '');
  }
  return texts.flatMap((text) =>
    ANALYST_WORDS.filter((word) => word.test(text)).map((word) => `${word} in: ${text.trim()}`),
  );
}
