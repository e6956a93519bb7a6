// What one real shop cannot show: sixty machines, every state, a link that is cut. Against mock/.
import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";
import { openBrowser, signIn, sizes, useLanguage } from "./chromium.mjs";
import { startMock } from "./mock/server.mjs";
import { root } from "./paths.mjs";

const dist = process.env.HEADSTOCK_WEB_DIST ?? join(root, "build/release/web/app/dist");
let browser, page, mock;
/// Pixels by which the pages and what stands at the end of the header lie over each other; they may stand on two lines.
const headerOverlap = () => page.evaluate(() => {
  const pages = document.querySelector(".header nav a:last-child").getBoundingClientRect();
  const end = document.querySelector(".header-end").getBoundingClientRect();
  return pages.bottom <= end.top || end.bottom <= pages.top ? 0 : pages.right - end.left;
});

describe("the pages", () => {
  before(async () => {
    mock = await startMock({ machines: 60, dist });
    browser = await openBrowser();
    page = browser.page;
  });
  after(async () => {
    await browser?.close();
    mock?.stop();
  });

  it("refuse a wrong password in the chosen language, switched at once", async () => {
    await page.goto(mock.url);
    await page.locator("input[name=user]").fill("admin");
    await page.locator("input[name=password]").fill("wrong-one");
    await page.keyboard.press("Enter");
    await page.getByText("User or password is wrong.").waitFor();
    await useLanguage(page, "zh");
    await page.getByText("用户名或密码错误。").waitFor();
    await page.getByRole("button", { name: "登录" }).waitFor();
  });

  it("show sixty machines, each with its state as word and shape, unknown never as idle", async () => {
    await signIn(page, mock);
    await page.locator(".card").nth(59).waitFor();
    assert.equal(await page.locator(".card").count(), 60);
    assert.equal(await page.locator(".cards.compact").count(), 1);
    const silent = page.locator('.card[data-machine="9"]');
    assert.equal(await silent.getAttribute("data-state"), "unknown");
    assert.match(await silent.locator(".card-state").innerText(), /未知/);
    assert.match(await silent.locator(".age").innerText(), /小时前/);
    assert.ok(await silent.evaluate((card) => card.classList.contains("stale")));
    assert.match(await page.locator('.card[data-state="alarm"]').first().locator("[data-field=alarm]").innerText(), /OT0500.*超程/s);
    for (const card of await page.locator(".card").all()) assert.equal(await card.locator(".card-state svg path, .card-state svg circle").count(), 1);
  });

  it("remember the language and count states in the filter", async () => {
    await page.reload();
    await page.locator(".card").nth(59).waitFor();
    assert.equal(await page.locator("html").getAttribute("lang"), "zh-CN");
    await useLanguage(page, "en");
    await page.locator(".state-filter .state-alarm").click();
    const alarms = await page.locator(".card").count();
    assert.equal(alarms, Number(await page.locator(".state-filter .state-alarm b").innerText()));
    assert.equal(await page.locator('.card:not([data-state="alarm"])').count(), 0);
    await page.locator(".state-filter button").first().click();
  });

  it("say why a machine refused, in words of both languages", async () => {
    await page.goto(`${mock.url}/#/machines/2`);
    await page.locator("[data-command=cycle_start]").click();
    await page.locator("[data-dialog=confirm] [data-confirm=cycle_start]").click();
    await page.locator("[data-toast=error]").filter({ hasText: "Remote operation is not armed at the machine" }).waitFor();
    await useLanguage(page, "zh");
    await page.locator("[data-command=cycle_start]").click();
    await page.keyboard.press("Escape");   // the safe way out
    assert.equal(await page.locator("[data-dialog=confirm]").count(), 0);
    await page.locator("[data-command=cycle_start]").click();
    await page.locator("[data-dialog=confirm] [data-confirm=cycle_start]").click();
    await page.locator("[data-toast=error]").filter({ hasText: "机床侧未授权远程操作" }).waitFor();
    await useLanguage(page, "en");
  });

  it("hold at once, without a question", async () => {
    await page.goto(`${mock.url}/#/machines/1`);
    await page.locator('[data-page=machine][data-state="running"]').waitFor();
    await page.locator("[data-command=feed_hold]").click();
    await page.locator('[data-page=machine][data-state="hold"]').waitFor();
  });

  it("draw the path of a lathe and, in space, of a mill", async () => {
    await page.locator('[data-path="lathe"] canvas').waitFor();
    await page.goto(`${mock.url}/#/machines/5`);
    const canvas = page.locator('[data-path="mill"] canvas');
    await canvas.waitFor();
    const image = await canvas.screenshot();
    assert.ok(image.length > 8_000, `an empty picture would be smaller than ${image.length} bytes`);
  });

  it("jump from a finding to its line", async () => {
    await page.goto(`${mock.url}/#/programs/1?tab=check`);
    await page.locator('[data-check="Mill 1"] [data-action=check]').click();
    await page.locator('[data-finding="PS0010"]').click();
    await page.locator('.listing .row.current[data-line="12"]').waitFor();
  });

  it("walk through a program of five million lines with a few of them in memory", async () => {
    await page.goto(`${mock.url}/#/programs/4`);
    const listing = page.locator(".listing");
    await listing.locator('[data-line="1"] code').filter({ hasText: "N1 " }).waitFor();
    await listing.focus();
    await page.keyboard.press("End");
    await listing.locator('[data-line="5000000"] code').filter({ hasText: "N5000000 " }).waitFor();
    await page.mouse.move(700, 600);
    await page.mouse.wheel(0, -220);   // ten lines, not two thousand
    await listing.locator('[data-line="4999965"]').waitFor();
    await page.locator("input.num").fill("2500000");
    await page.keyboard.press("Enter");
    await listing.locator('.row.current[data-line="2500000"] code').filter({ hasText: "N2500000 " }).waitFor();
    assert.ok(await listing.locator(".row").count() < 100);
  });

  it("work by keyboard alone", async () => {
    await page.goto(`${mock.url}/#/floor`);
    await page.reload();
    await page.locator(".card").first().waitFor();
    await page.keyboard.press("Tab");
    assert.equal(await page.evaluate(() => document.activeElement.className), "skip");
    await page.locator(".card").first().focus();
    await page.keyboard.press("Enter");
    await page.locator("[data-page=machine]").waitFor();
    const tab = page.locator('[data-panel=positions] [role=tab][aria-selected=true]');
    await tab.focus();
    await page.keyboard.press("ArrowRight");
    await page.locator('[data-positions="relative"]').waitFor();
  });

  it("fit a tablet without scrolling sideways, in both languages", async () => {
    await page.setViewportSize(sizes.tablet);
    for (const language of ["zh", "en"]) {
      await useLanguage(page, language);
      for (const hash of ["#/floor", "#/machines/1", "#/machines/2", "#/programs", "#/programs/1", "#/programs/1?tab=check", "#/programs/1?tab=send", "#/programs/1?tab=diff", "#/alarms", "#/dnc", "#/times", "#/users", "#/account"]) {
        await page.goto(`${mock.url}/${hash}`);
        await page.locator("[data-page]").first().waitFor();
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
        assert.ok(wide <= 0, `${hash} in ${language} is ${wide} px too wide`);
        const overlap = await headerOverlap();
        assert.ok(overlap <= 0, `the header of ${hash} in ${language} overlaps by ${overlap} px`);
      }
    }
    // Between a tablet and a desk the header gives way step by step.
    for (const width of [768, 901, 1021, 1261, 1481]) {
      await page.setViewportSize({ width, height: 800 });
      const overlap = await headerOverlap();
      assert.ok(overlap <= 0, `the header overlaps by ${overlap} px at ${width} px`);
    }
    await page.setViewportSize(sizes.desktop);
  });

  it("take the reason of a stop in two taps, and show what was counted", async () => {
    await useLanguage(page, "en");
    await page.goto(`${mock.url}/#/times`);
    await page.locator('[data-page=times] tr[data-machine="3"] a').click();
    await page.locator("[data-panel=counted]").getByText("Availability").waitFor();
    const stop = page.locator("[data-stop]").filter({ hasText: "no reason given" }).first();
    const from = await stop.getAttribute("data-stop");
    await stop.locator("[data-action=why]").click();
    await page.locator("[data-dialog=why] [data-reason='2']").click();
    await page.locator(`[data-stop="${from}"]`).getByText("Waiting for material").waitFor();
    await useLanguage(page, "zh");
    await page.locator(`[data-stop="${from}"]`).getByText("待料").waitFor();
    await useLanguage(page, "en");
  });

  it("show when a machine did what, and its parts beside the target", async () => {
    await page.goto(`${mock.url}/#/times/3?period=7d`);
    await page.locator("[data-panel=timeline] .timeline-day .state-running").first().waitFor();
    assert.equal(await page.locator("[data-panel=timeline] .timeline-day").count(), 7, "a line a day");
    for (const day of await page.locator("[data-panel=timeline] .timeline-day").all()) {
      const wide = await day.evaluate((line) => [...line.children].every((piece) => piece.offsetLeft >= 0 && piece.offsetLeft + piece.offsetWidth <= line.clientWidth + 2));
      assert.ok(wide, "no state reaches out of its day");
    }
    await page.locator("[data-panel=pieces] .parts-target .target").first().waitFor();
    const csv = page.locator("[data-panel=timeline] a.csv");
    assert.match(await csv.getAttribute("href"), /\/machines\/3\/states\?.*format=csv/);
  });

  it("change a shift", async () => {
    await page.goto(`${mock.url}/#/times`);
    await page.locator("[data-action=shifts]").click();
    await page.locator('[data-shift="0"] input[name=end]').fill("18:30");
    await page.locator("[data-action=add-shift]").click();
    await page.locator('[data-shift="1"] input[name=name]').fill("Night");
    await page.locator("[data-dialog=shifts] footer .primary").click();
    await page.locator("[data-dialog=shifts]").waitFor({ state: "detached" });
    await page.locator("[data-action=shifts]").click();
    assert.equal(await page.locator('[data-shift="0"] input[name=end]').inputValue(), "18:30");
    assert.equal(await page.locator("[data-shift]").count(), 2);
    await page.keyboard.press("Escape");
  });

  it("say loudly that the link is lost, let every machine become unknown, and come back by themselves", async () => {
    await useLanguage(page, "en");
    await page.goto(`${mock.url}/#/floor`);
    await page.locator('.card[data-state="running"]').first().waitFor();
    const port = Number(new URL(mock.url).port);
    mock.stop();
    await page.locator(".link-banner").getByText("Connection to the server lost").waitFor();
    await page.locator('.card:not([data-state="unknown"])').first().waitFor({ state: "detached" });
    assert.equal(await page.locator(".card").count(), 60, "they stay visible, greyed");
    mock = await startMock({ machines: 60, dist, port });
    await page.locator(".link-banner").waitFor({ state: "detached" });
    await page.locator('.card[data-state="running"]').first().waitFor();
  });

  it("have no error of their own", () => assert.deepEqual(browser.problems, []));
});
