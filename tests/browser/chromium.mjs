// A fresh headless Chromium for one test file, with software WebGL for the 3-D view.
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

export const sizes = { desktop: { width: 1440, height: 900 }, tablet: { width: 820, height: 1180 } };

export async function openBrowser({ size = sizes.desktop, language = "en" } = {}) {
  const profile = mkdtempSync(join(tmpdir(), "headstock-chromium-"));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", headless: true, timeout: 120_000, viewport: size,
    locale: language === "zh" ? "zh-CN" : "en-GB", acceptDownloads: true,
    args: ["--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
      "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
  context.setDefaultTimeout(120_000);   // ends a test that will never pass; no measure of anything
  const page = context.pages()[0] ?? await context.newPage();
  const problems = [];
  page.on("pageerror", (error) => problems.push(`page error: ${error.message}`));
  page.on("console", (message) => {
    // Refused requests are part of the tests; anything else on the console is a defect of the page.
    if (message.type() === "error" && !/Failed to load resource|WebSocket connection/.test(message.text())) problems.push(`console: ${message.text()}`);
  });
  return { context, page, problems, close: async () => { await context.close(); rmSync(profile, { recursive: true, force: true }); } };
}

export async function signIn(page, { url, user, password }) {
  await page.goto(url);
  await page.locator("input[name=user]").fill(user);
  await page.locator("input[name=password]").fill(password);
  await page.keyboard.press("Enter");
  await page.locator("[data-page]").first().waitFor();
}

export async function useLanguage(page, language) {
  await page.locator(`.language button[lang^=${language}]`).first().click();
  await page.locator(`html[lang^=${language}]`).waitFor();
}
