/// <reference types="vite/client" />
import { expect, it } from "vitest";
import en from "./en.json";
import { reasons } from "./reasons";
import zh from "./zh.json";

const flat = (tree: Record<string, Record<string, string>>): Map<string, string> =>
  new Map(Object.entries(tree).flatMap(([area, texts]) => Object.entries(texts).map(([key, text]) => [`${area}.${key}`, text] as const)));
const english = flat(en), chinese = flat(zh);
const sources = import.meta.glob("../**/*.{ts,tsx}", { query: "?raw", import: "default", eager: true }) as Record<string, string>;

it("both languages say the same things", () => expect([...chinese.keys()].sort()).toEqual([...english.keys()].sort()));

it("nothing is empty, and placeholders agree", () => {
  const placeholders = (text: string) => [...text.matchAll(/{{\w+}}/g)].map(([name]) => name).sort();
  for (const [key, text] of english) {
    expect(text, key).not.toBe("");
    expect(placeholders(chinese.get(key) ?? ""), key).toEqual(placeholders(text));
  }
});

it("Chinese is Chinese", () => {
  const same = [...chinese].filter(([key, text]) => text === english.get(key) && /[a-z]{3}/i.test(text.replace(/{{\w+}}/g, "")));
  expect(same).toEqual([]);
});

it("every text the pages ask for exists", () => {
  const missing: string[] = [];
  for (const [file, source] of Object.entries(sources)) {
    if (file.includes(".test.")) continue;
    for (const [, key = ""] of source.matchAll(/\bt\((?:[^"'`()]*\? )?"([a-z_]+\.[a-z0-9_]+)"/g)) if (!english.has(key)) missing.push(`${file}: ${key}`);
    // t(cond ? "a.b" : "c.d") and tables of keys
    for (const [, key = ""] of source.matchAll(/"((?:common|nav|link|machine|command|programs|users|account|alarms|times|floor|signin|error|override)\.[a-z0-9_]+)"/g)) if (!english.has(key)) missing.push(`${file}: ${key}`);
    // t(`area.${…}`): the area must exist at least
    for (const [, area = ""] of source.matchAll(/\bt\(`([a-z_]+)\./g)) if (!(area in en)) missing.push(`${file}: ${area}.*`);
  }
  expect(missing).toEqual([]);
});

it("no page holds a text of its own", () => {
  const found: string[] = [];
  for (const [file, source] of Object.entries(sources)) {
    if (!file.endsWith(".tsx")) continue;
    for (const [, text = ""] of source.matchAll(/>([A-Z][a-z]+ [a-z]+[^<>{}]*)</g)) found.push(`${file}: ${text}`);
    if (/[\u4e00-\u9fff]/.test(source.replaceAll("中文", ""))) found.push(`${file}: Chinese`);
  }
  expect(found).toEqual([]);
});

it("refusals have words from the table of server and machines", () => {
  expect(reasons.size).toBeGreaterThan(40);
  for (const key of ["not_armed", "not_connected", "timeout", "running", "memory_full"]) expect(reasons.get(key)?.zh, key).toMatch(/[\u4e00-\u9fff]/);
});
