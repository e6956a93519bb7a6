export type Theme = "dark" | "light";
const kept = "headstock.theme";

export const chosenTheme = (): Theme => (localStorage.getItem(kept) === "light" ? "light" : "dark");

export function setTheme(theme: Theme): void {
  localStorage.setItem(kept, theme);
  document.documentElement.dataset["theme"] = theme;
}

document.documentElement.dataset["theme"] = chosenTheme();
