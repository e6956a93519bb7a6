// The two languages of the shop. Both are in the bundle: switching is at once and needs no network.
import i18next from "i18next";
import { initReactI18next } from "react-i18next";
import { ApiError } from "../api/client";
import type { Localised } from "../api/types";
import en from "./en.json";
import { reasons } from "./reasons";
import zh from "./zh.json";

export type Language = "en" | "zh";
const kept = "headstock.language";

function firstLanguage(): Language {
  const chosen = localStorage.getItem(kept);
  if (chosen === "en" || chosen === "zh") return chosen;
  return navigator.language.toLowerCase().startsWith("zh") ? "zh" : "en";
}

export function chosenLanguage(): Language | null {
  const chosen = localStorage.getItem(kept);
  return chosen === "en" || chosen === "zh" ? chosen : null;
}

export function setLanguage(language: Language): void {
  localStorage.setItem(kept, language);
  document.documentElement.lang = language === "zh" ? "zh-CN" : "en";
  void i18next.changeLanguage(language);
}

const language = firstLanguage();
document.documentElement.lang = language === "zh" ? "zh-CN" : "en";
void i18next.use(initReactI18next).init({
  resources: { en: { translation: en }, zh: { translation: zh } },
  lng: language, fallbackLng: false, interpolation: { escapeValue: false }, returnNull: false,
});

export const current = (): Language => (i18next.language === "zh" ? "zh" : "en");

export function inLanguage(text: Localised | string | null | undefined): string {
  if (!text) return "";
  if (typeof text === "string") return text;
  return text[current()] || text.en || text.zh;
}

/// The reason a machine gave for a refusal, in words; an unknown one (of a newer machine) as it came.
export function reasonText(reason: string | null | undefined): string {
  if (!reason) return "";
  return inLanguage(reasons.get(reason) ?? reason);
}

export function errorText(error: unknown): string {
  if (error instanceof ApiError) {
    if (error.reason) return reasonText(error.reason);
    if (error.text) {
      const said = inLanguage(error.text);
      if (said) return error.where ? `${said} (${error.where})` : said;
    }
    if (reasons.has(error.code)) return reasonText(error.code);
    if (i18next.exists(`error.${error.code}`)) return i18next.t(`error.${error.code}`);
    return i18next.t("error.http", { status: error.status, code: error.code });
  }
  return error instanceof Error ? error.message : String(error);
}
