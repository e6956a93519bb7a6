// Machine data as a person uses it: 200 offsets by keyboard, a paste from a spreadsheet with its preview, a step that needs a
// second person, two people on one offset, the tool changes ahead. A real server and a real agent.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";
import { openBrowser, signIn, useLanguage } from "./chromium.mjs";
import { binary, built, Shop, until } from "./shop.mjs";

const pictures = process.env.HEADSTOCK_PICTURES;
let shop, browser, page, machine;
const shoot = async (name) => { if (pictures) { mkdirSync(pictures, { recursive: true }); await page.screenshot({ path: join(pictures, `${name}.png`) }); } };
const panel = (...words) => execFileSync(binary("headstock-agent"), ["panel", "--data", shop.agents.get("Lathe 1").folder, ...words], { encoding: "utf8" });
const values = () => shop.call("GET", `/machines/${machine}/values`);
const value = async (what) => (await values()).values[what] ?? 0;
const cell = (what) => page.locator(`td[data-what="${what}"]`);
const write = () => page.locator("[data-action=write]").click();
const write_is_done = () => page.locator("[data-changes]").waitFor({ state: "detached" });

async function person(user) {
  await shop.call("POST", "/users", { user, password: "correct horse 7", role: "setter", must_change_password: false });
  return (await shop.call("POST", "/session", { user, password: "correct horse 7" }, null)).token;
}

describe("machine data", { skip: !built() && "not built" }, () => {
  before(async () => {
    shop = await Shop.start();
    machine = await shop.addMachine("Lathe 1", "fanuc-0i-t", "lathe-1.toml");
    await until("reported", async () => (await values()).reported);
    shop.second = await person("li");
    browser = await openBrowser();
    page = browser.page;
    await signIn(page, shop);
    await page.goto(`${shop.url}/#/data/${machine}`);
    await page.locator(".table.grid").waitFor();
  });
  after(async () => {
    await browser?.close();
    await shop?.stop();
  });

  it("edits by keyboard, adds as the controller does, and writes what was read back", async () => {
    assert.equal(await page.locator(".table.grid tbody tr").count(), 200);
    await cell("tool/1/wear/X").click();
    await page.keyboard.type("0.02");
    await page.keyboard.press("Enter");           // down to tool 2
    await page.keyboard.type("+0.015");
    await page.keyboard.press("Tab");             // right: Z
    await page.keyboard.type("x1");
    assert.equal(await page.locator("[data-changes]").getAttribute("data-changes"), "2");
    await shoot("data-edits");
    await page.keyboard.press("Escape");
    await write();
    await write_is_done();
    assert.equal(await value("tool/1/wear/X"), 0.02);
    assert.equal(await value("tool/2/wear/X"), 0.015);
    await until("shown", async () => (await cell("tool/1/wear/X").textContent()).trim() === "0.02");
  });

  it("finds one of the 200 and shows only what is set", async () => {
    await page.locator("[data-field=search]").fill("150-152");
    assert.equal(await page.locator(".table.grid tbody tr").count(), 3);
    await page.locator("[data-field=search]").fill("");
    await page.locator(".data-bar .check input").check();
    assert.equal(await page.locator(".table.grid tbody tr").count(), 2);
    await page.locator(".data-bar .check input").uncheck();
  });

  it("shows a paste before anything is taken over", async () => {
    await cell("tool/5/geometry/X").click();
    await page.evaluate(() => {
      const data = new DataTransfer();
      data.setData("text/plain", "-112,5\t0,01\t-80\r\n-100\tabc\t-75.25\r\n");
      document.querySelector(".grid-box").dispatchEvent(new ClipboardEvent("paste", { clipboardData: data, bubbles: true, cancelable: true }));
    });
    await page.locator("[data-dialog=preview]").waitFor();
    await shoot("data-preview");
    assert.equal(await page.locator("[data-preview].wrong").count(), 1);
    assert.ok(await page.locator("[data-action=take]").isDisabled(), "nothing is taken over while a cell is wrong");
    await page.keyboard.press("Escape");
    await page.locator("[data-dialog=preview]").waitFor({ state: "detached" });
    assert.equal(await page.locator("[data-changes]").count(), 0);
    await page.evaluate(() => {
      const data = new DataTransfer();
      data.setData("text/plain", "-112,5\t0,01\t-80\r\n-100\t\t-75.25\r\n");
      document.querySelector(".grid-box").dispatchEvent(new ClipboardEvent("paste", { clipboardData: data, bubbles: true, cancelable: true }));
    });
    await page.locator("[data-action=take]").click();
    assert.equal(await page.locator("[data-changes]").getAttribute("data-changes"), "5");
    await write();
    await write_is_done();
    assert.equal(await value("tool/6/geometry/Z"), -75.25);
    const newest = (await shop.list(`/machines/${machine}/value-changes?what=tool/6/`))[0];
    assert.equal(newest.origin, "import");
  });

  it("waits for a second person when the step is above the limit", async () => {
    await cell("tool/1/wear/X").click();
    await page.keyboard.type("0.6");
    await page.keyboard.press("Enter");
    await write();
    await page.locator("[data-request]").waitFor();
    await shoot("data-second-person");
    assert.equal(await value("tool/1/wear/X"), 0.02, "nothing is written yet");
    assert.ok(await page.locator("[data-action=agree]").isDisabled(), "not by the same person");
    const [waiting] = await shop.list("/value-requests?state=waiting");
    assert.equal((await shop.call("POST", `/value-requests/${waiting.id}/agree`, {}, shop.second)).state, "done");
    await page.locator("[data-request]").waitFor({ state: "detached" });
    await until("shown", async () => (await cell("tool/1/wear/X").textContent()).trim() === "0.6");
  });

  it("does not overwrite what another has changed since it was seen", async () => {
    await cell("tool/3/wear/Z").click();
    await page.keyboard.type("0.05");
    await page.keyboard.press("Enter");
    panel("set", "tool/3/wear/Z=0.01");
    await page.locator("td.clash").waitFor();
    assert.ok(await page.locator("[data-action=write]").isDisabled());
    await shoot("data-clash");
    await page.locator("[data-action=discard]").click();
    await until("shown", async () => (await cell("tool/3/wear/Z").textContent()).trim() === "0.01");
  });

  it("tells the next tool change, and who changed what", async () => {
    await shop.call("POST", `/machines/${machine}/values`, { values: [["unit", 0], ["life", 50], ["tool/0", 1], ["offset/0", 1], ["used/0", 45], ["tool/1", 2]].map(([field, after]) => ({ what: `tool_life/1/${field}`, before: null, after })) });
    await page.goto(`${shop.url}/#/data`);
    const row = page.locator(`[data-life="${machine}/1"]`);
    await row.waitFor();
    assert.match(await row.textContent(), /5 \/ 50/);
    assert.match(await row.textContent(), /55/, "of both tools");
    await shoot("data-tool-changes");
    await page.goto(`${shop.url}/#/data/${machine}?tab=tool_life`);
    await page.locator("[data-action=new-tool]").first().click();
    await write();
    await write_is_done();
    assert.equal(await value("tool_life/1/used/0"), 0);
    await page.goto(`${shop.url}/#/data/${machine}?tab=history`);
    await page.locator('[data-change-row="tool/3/wear/Z"]').waitFor();
    await shoot("data-history");
  });

  it("has the manual's parameters, in both languages, and says why they cannot be written", async () => {
    for (const language of ["zh", "en"]) {
      await useLanguage(page, language);
      await page.goto(`${shop.url}/#/data/${machine}?tab=parameters`);
      await page.locator("[data-parameter]").first().waitFor();
      await page.locator("[data-field=search]").fill("6713");
      await page.locator("[data-parameter='6713']").waitFor();
      await shoot(`data-parameters-${language}`);
    }
    await page.locator("input[aria-label='parameter/6713']").fill("50");
    await page.keyboard.press("Enter");
    await write();
    await page.locator(".change-bar .note.error").waitFor();
    assert.match(await page.locator(".change-bar .note.error").textContent(), /not switched on/);
    assert.equal((await values()).values["parameter/6713"], undefined);
    panel("parameter-write", "on");
    panel("mode", "mdi");
    await write();
    await write_is_done();
    assert.equal((await values()).values["parameter/6713"], 50);
  });

  it("fits a tablet", async () => {
    await page.setViewportSize({ width: 820, height: 1180 });
    await page.goto(`${shop.url}/#/data/${machine}`);
    await page.locator(".table.grid").waitFor();
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth + 1), "no sideways scrolling of the page");
    await shoot("data-tablet");
  });
});
