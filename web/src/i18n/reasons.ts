// The words for refusals come from the table that server and machines use themselves (protocol/wire/reasons.tsv).
import table from "@shared/reasons.tsv?raw";
import type { Localised } from "../api/types";

export function readReasons(text: string): Map<string, Localised> {
  const found = new Map<string, Localised>();
  for (const row of text.split("\n").slice(1)) {
    const [key, en, zh] = row.split("\t");
    if (key && en && zh) found.set(key, { en, zh });
  }
  return found;
}

export const reasons: ReadonlyMap<string, Localised> = readReasons(table);
