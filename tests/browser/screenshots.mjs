// node screenshots.mjs [--url URL --user U --password P] [--out DIR]: every page in both languages, on a desk and on a
// tablet. Without --url it shows the made-up shop of mock/, which has every state.
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { openBrowser, signIn, sizes, useLanguage } from "./chromium.mjs";
import { startMock } from "./mock/server.mjs";
import { root } from "./paths.mjs";

const option = (name) => { const at = process.argv.indexOf(`--${name}`); return at > 0 ? process.argv[at + 1] : undefined; };
const out = option("out") ?? join(root, "build/screenshots");
const only = option("only");
const dist = process.env.HEADSTOCK_WEB_DIST ?? join(root, "build/release/web/app/dist");
mkdirSync(out, { recursive: true });

const pages = {
  floor: "#/floor", wall: "#/floor?wall=1", "machine-lathe": "#/machines/1", "machine-mill": "#/machines/2", "machine-unknown": "#/machines/9",
  programs: "#/programs?folder=%2Fshafts", "program-text": "#/programs/1", "program-revisions": "#/programs/1?tab=revisions",
  "program-diff": "#/programs/1?tab=diff", "program-check": "#/programs/1?tab=check", "program-mill-check": "#/programs/2?tab=check", "program-send": "#/programs/1?tab=send", alarms: "#/alarms", "alarms-statistics": "#/alarms?view=statistics", times: "#/times?period=7d", "times-machine": "#/times/3?period=7d", "times-shifts": "#/times", users: "#/users", "admin-rights": "#/users?tab=rights", "admin-screens": "#/users?tab=screens", "admin-audit": "#/users?tab=audit", "admin-backups": "#/users?tab=backups", "admin-messages": "#/users?tab=messages", "alarms-events": "#/alarms?view=events", account: "#/account",
};
const shop = option("url") ? { url: option("url"), user: option("user"), password: option("password"), stop: () => {} } : await startMock({ machines: 12, dist });
const crowd = option("url") ? null : await startMock({ machines: 60, dist });

for (const [sizeName, size] of Object.entries(sizes)) {
  const browser = await openBrowser({ size });
  const { page } = browser;
  for (const language of ["zh", "en"]) {
    const shoot = async (name) => { await page.screenshot({ path: join(out, `${name}-${language}-${sizeName}.png`) }); };
    await page.goto(shop.url);
    await page.locator("input[name=user]").waitFor();
    await useLanguage(page, language);
    await shoot("sign-in");
    await signIn(page, shop);
    for (const [name, hash] of Object.entries(pages)) {
      if (only && !name.includes(only)) continue;
      await page.goto(`${shop.url}/${hash}`);
      await page.locator("[data-page]").first().waitFor();
      if (name === "program-check" || name === "program-mill-check") { await page.locator("[data-action=check-all]").click(); await page.locator("[data-check] .chip").last().waitFor(); }
      if (name === "times-shifts") { await page.locator("[data-action=shifts]").click(); await page.locator("[data-dialog=shifts]").waitFor(); }
      await page.waitForTimeout(name.startsWith("machine") || name.includes("check") ? 2500 : 800);
      await shoot(name);
    }
    if (crowd && (!only || only === "crowd")) {
      await page.goto(crowd.url);
      await useLanguage(page, language);
      await signIn(page, crowd);
      await page.waitForTimeout(1500);
      await shoot("floor-60");
      await page.locator(".person-button").click();
      await page.locator("[data-action=sign-out]").click();
      await page.goto(shop.url);
    }
    await page.locator("[data-page]").first().waitFor();
    await page.goto(`${shop.url}/#/floor`);
    await page.locator(".person-button").click();
    await page.locator("[data-action=sign-out]").click();
    await page.locator("input[name=user]").waitFor();
  }
  for (const problem of browser.problems) console.log(`${sizeName}: ${problem}`);
  await browser.close();
}
shop.stop();
crowd?.stop();
console.log(out);
