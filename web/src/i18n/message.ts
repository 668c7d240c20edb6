// Messages of the service: the part of ICU MessageFormat that `messages/*.json` use, as `estimators/sentences/_message.py` reads it.

export interface Place {
  name: string;
  /** `number`, `list` or `code`; empty for a value that is written as it is. */
  kind: string;
  style: string;
}
interface Plural {
  name: string;
  branches: Record<string, Message | undefined>;
}
export type Message = (string | Place | Plural)[];

const PART =
  /(?<text>(?:[^{}']|'')+)|\{\s*(?<name>\w+)\s*(?:,\s*(?<kind>number|list|code)\s*(?:,\s*(?<style>[^{}',]+?)\s*)?)?\}|\{\s*(?<plural>\w+)\s*,\s*plural\s*,\s*/y;
const BRANCH = /\s*(?<category>\w+)\s*\{/y;
const END = /\s*\}/y;

const known = new Map<string, Message>();

/** The parts of a message. */
export function parsed(text: string): Message {
  const message = known.get(text) ?? new Reader(text).message();
  known.set(text, message);
  return message;
}

class Reader {
  private at = 0;
  constructor(private readonly text: string) {}

  message(): Message {
    const parts: Message = [];
    for (let found = this.next(PART); found; found = this.next(PART)) {
      const { text, name = '', kind = '', style = '', plural } = found;
      if (text) parts.push(text.replaceAll("''", "'"));
      else parts.push(plural ? { name: plural, branches: this.branches() } : { name, kind, style });
    }
    return parts;
  }

  private branches(): Plural['branches'] {
    const branches: Plural['branches'] = {};
    for (let found = this.next(BRANCH); found; found = this.next(BRANCH)) {
      branches[found.category ?? ''] = this.message();
      this.next(END);
    }
    this.next(END);
    return branches;
  }

  /** The named groups of what stands here; null where something else stands. */
  private next(pattern: RegExp): Partial<Record<string, string>> | null {
    pattern.lastIndex = this.at;
    const found = pattern.exec(this.text);
    if (found) this.at = pattern.lastIndex;
    return found && (found.groups ?? {});
  }
}
