// Splits a block into what a machinist tells apart at a glance. Only for colours: it judges nothing.

export type TokenKind = "comment" | "number" | "g" | "m" | "axis" | "fst" | "sequence" | "program" | "macro" | "text";
export interface Token { kind: TokenKind; text: string }

const pattern =
  /(\([^)]*\)?|;.*$)|(^\s*[O:]\s*\d+|^\s*%)|(N\s*\d+)|(G\s*\d+(?:\.\d+)?)|(M\s*\d+)|([FSTHD]\s*[-+]?[\d.]+)|([XYZABCUVWIJKRPQEL]\s*[-+]?[\d.]+)|(#\d*|\[|\]|\b(?:IF|THEN|GOTO|WHILE|DO|END|EQ|NE|GT|GE|LT|LE|AND|OR|XOR|MOD|SIN|COS|TAN|ATAN|SQRT|ABS|ROUND|FIX|FUP|BCD|BIN)\d*\b|[=*])|([-+]?\d*\.?\d+)/gi;
const kinds: TokenKind[] = ["comment", "program", "sequence", "g", "m", "fst", "axis", "macro", "number"];

/// Longer lines are cut for display: a program may hold ten megabytes on one line.
export const shownLength = 500;

export function tokens(line: string): Token[] {
  const text = line.length > shownLength ? `${line.slice(0, shownLength)} …` : line;
  const found: Token[] = [];
  let at = 0;
  for (const match of text.matchAll(pattern)) {
    if (match.index > at) found.push({ kind: "text", text: text.slice(at, match.index) });
    const group = kinds.findIndex((_, i) => match[i + 1] !== undefined);
    found.push({ kind: kinds[group] ?? "text", text: match[0] });
    at = match.index + match[0].length;
  }
  if (at < text.length) found.push({ kind: "text", text: text.slice(at) });
  return found;
}

/// Is it the same block? The machine may report it without blanks, comments or what was too long to report.
export function sameBlock(text: string, reported: string): boolean {
  const bare = (block: string) => block.replace(/\([^)]*\)?/g, "").replace(/[\s;]/g, "").toUpperCase();
  const a = bare(text), b = bare(reported);
  return a === b || (b.length >= 40 && a.startsWith(b.slice(0, 40)));
}
