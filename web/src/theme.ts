// SPDX-License-Identifier: Apache-2.0
// Light or dark: as the system says, or as the user wants it here.

export type Theme = "auto" | "light" | "dark";

const kThemes: Theme[] = ["auto", "light", "dark"];
const kKey = "knuckle.theme";

export function remembered(key: string): string | null {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;  // a browser that keeps nothing
  }
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(key, value);
  } catch {
    // then it holds for this page
  }
}

export function currentTheme(): Theme {
  return kThemes.find((theme) => theme === document.documentElement.dataset["theme"]) ?? "auto";
}

function setTheme(theme: Theme): void {
  document.documentElement.dataset["theme"] = theme;
}

export function restoreTheme(): void {
  setTheme(kThemes.find((theme) => theme === remembered(kKey)) ?? "auto");
}

export function nextTheme(): void {
  const theme = kThemes[(kThemes.indexOf(currentTheme()) + 1) % kThemes.length]!;
  setTheme(theme);
  remember(kKey, theme);
}
