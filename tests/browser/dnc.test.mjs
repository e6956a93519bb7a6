// The DNC page as a person uses it: start a drip-feed, watch the bar and the line monitor, pause, resume, stop; a restart
// header that must be read; a punch that waits for approval. A real server; the control is a socket with DC1 and DC3.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { createServer } from "node:net";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";
import { openBrowser, signIn, sizes, useLanguage } from "./chromium.mjs";
import { root } from "./paths.mjs";
import { built, Shop, until } from "./shop.mjs";

const blocks = Array.from({ length: 1500 }, (_, i) => `N${i + 100} G01 X${i % 50}. Y${(i % 40) + 1}.`).join("\n");
const program = `%\nO2001(PLATE)\nG21 G17 G90 G94 G54\nS2000 M03\nG00 X0. Y0. Z20.\nG01 Z-1. F1200.\n${blocks}\nG00 Z20.\nM05\nM30\n%\n`;
const pictures = process.env.HEADSTOCK_PICTURES;
const iso = (text) => Buffer.from([...text].map((c) => { const code = c.charCodeAt(0); let ones = 0; for (let bit = 0; bit < 7; ++bit) ones ^= (code >> bit) & 1; return code | (ones << 7); }));

/// A control: reads at its own speed, stops with DC3 when its buffer is full.
class Control {
  received = []; reading = false; connected = null;
  static async start() {
    const control = new Control();
    control.server = createServer((socket) => {
      control.connected = socket;
      socket.on("data", (data) => { if (control.reading) control.received.push(data); });
      socket.on("error", () => undefined);
      socket.on("close", () => { if (control.connected === socket) control.connected = null; });
    });
    await new Promise((resolve) => control.server.listen(0, "127.0.0.1", resolve));
    control.address = `tcp://127.0.0.1:${control.server.address().port}`;
    return control;
  }
  get text() { return Buffer.concat(this.received); }
  async ask() { await until("the server connected", () => this.connected); this.received = []; this.reading = true; this.connected.write(Buffer.from([0x11])); }
  punch(text) { this.connected.write(Buffer.concat([Buffer.from([0x12]), iso(text), Buffer.from([0x14])])); }
  stop() { this.connected?.destroy(); this.server.close(); }
}

let shop, browser, page, control;
/// With HEADSTOCK_PICTURES: what is shown now, in both languages, on a desk and on a tablet.
const shoot = async (name) => {
  if (!pictures) return;
  mkdirSync(pictures, { recursive: true });
  const before = (await page.locator("html").getAttribute("lang")).slice(0, 2);
  const speak = async (language) => {
    await page.locator(`.language button[lang^=${language}]`).first().evaluate((button) => button.click());   // a dialog may be open
    await page.locator(`html[lang^=${language}]`).waitFor();
  };
  for (const language of ["zh", "en"])
    for (const [sizeName, size] of Object.entries(sizes)) {
      await speak(language);
      await page.setViewportSize(size);
      await page.screenshot({ path: join(pictures, `${name}-${language}-${sizeName}.png`) });
    }
  await page.setViewportSize(sizes.desktop);
  await speak(before);
};
const state = (wanted) => page.locator(`[data-port-transfer][data-state=${wanted}]`).waitFor();

describe("the DNC page", { skip: !built() && "not built" }, () => {
  before(async () => {
    shop = await Shop.start();
    control = await Control.start();
    const machine = (await shop.call("POST", "/machines", { name: "Old mill", profile: "fanuc-0i-m" })).id;
    const response = await fetch(`${shop.url}/api/v1/programs?folder=&name=O2001&note=first`, { method: "POST", body: program, headers: { "Content-Type": "application/octet-stream", Authorization: `Bearer ${shop.token}` } });
    const made = await response.json();
    await shop.call("POST", `/programs/${made.program.id}/revisions/1/check`, { machine });
    await until("checked", async () => (await shop.list(`/programs/${made.program.id}/revisions/1/checks`)).length > 0);
    await shop.call("POST", `/programs/${made.program.id}/revisions/1/release`, { why: "test" });
    browser = await openBrowser();
    page = browser.page;
    await signIn(page, shop);
  });
  after(async () => {
    await browser?.close();
    control?.stop();
    await shop?.stop();
  });

  it("adds a port from the protocol's settings", async () => {
    await page.goto(`${shop.url}/#/dnc`);
    await page.locator("[data-action=add-port]").click();
    const form = page.locator("[data-dialog=port]");
    await form.locator("[data-field=name]").fill("Line 1");
    await form.locator("[data-field=address]").fill("/etc/passwd");
    await form.locator("[data-field=protocol]").selectOption("dc1-dc4");
    await form.locator("[data-action=save]").click();
    await form.getByText("address").last().waitFor();   // refused: not a device
    await form.locator("[data-field=address]").fill(control.address);
    await form.locator("select").first().selectOption({ label: "Old mill" });
    await form.locator("[data-field=line]").fill("38400-8-N-2-software");
    await form.locator("[data-field=after_stop]").fill("64");
    await form.locator("[data-field=listens]").check();
    await shoot("dnc-port");
    await form.locator("[data-action=save]").click();
    await form.waitFor({ state: "detached" });
    await page.locator("[data-port-state=listening]").waitFor();
  });

  it("drip-feeds: bar, line monitor, pause, resume, and the control has every character", async () => {
    await page.locator("[data-action=send]").click();
    const dialog = page.locator("[data-dialog=port-send]");
    await dialog.locator("[data-field=program]").selectOption({ index: 0 });
    await dialog.locator("[data-field=drip]").check();
    await shoot("dnc-send");
    await dialog.locator("[data-action=send-now]").click();
    await dialog.waitFor({ state: "detached" });
    await state("waiting");
    await page.locator("[data-action=monitor]").click();
    await control.ask();
    await state("sending");
    await page.locator(".monitor-line.in .control").filter({ hasText: "DC1" }).first().waitFor();
    await page.locator(".monitor-line.out").first().waitFor();
    const bar = page.locator("[data-port-transfer] [role=progressbar]");
    const part = async () => Number(await bar.getAttribute("aria-valuenow"));
    await until("the bar moves", async () => (await part()) >= 5);
    control.connected.write(Buffer.from([0x93]));
    await state("held");
    control.connected.write(Buffer.from([0x11]));
    await state("sending");
    await page.locator("[data-action=pause]").click();
    await state("paused");
    const paused = control.text.length;
    await shoot("dnc-paused");
    await useLanguage(page, "zh");
    await page.getByText("已暂停").first().waitFor();
    assert.ok(control.text.length <= paused + 64, "nothing goes out while paused");
    await page.locator("[data-action=resume]").click();
    await useLanguage(page, "en");
    await page.locator("[data-port-state=listening]").waitFor();
    assert.deepEqual(control.text, iso(program));
    await page.locator("[data-tab=history]").click();
    await page.locator("[data-history]").first().getByText("Done").waitFor();
    await shoot("dnc-history");
    await page.locator("[data-history] [data-action=certificate]").first().click();
    const tail = page.locator("[data-dialog=certificate] [data-tail]");
    await tail.waitFor();
    assert.ok((await tail.textContent()).endsWith("M30\n%\n"));
    await shoot("dnc-certificate");
    await page.keyboard.press("Escape");
  });

  it("shows the restart header and sends nothing before it is confirmed", async () => {
    await page.locator("[data-tab=ports]").click();
    await page.locator("[data-action=send]").click();
    const dialog = page.locator("[data-dialog=port-send]");
    await dialog.locator("[data-field=program]").selectOption({ index: 0 });
    await dialog.locator("[data-field=by]").selectOption("sequence");
    await dialog.locator("[data-field=line]").fill("115");
    await dialog.locator("[data-action=ask-restart]").click();
    const header = dialog.locator("[data-field=header]");
    await until("the header", async () => (await header.inputValue()).includes("S2000 M03"));
    await dialog.getByText("N115 G01").waitFor();
    assert.ok(await dialog.locator("[data-action=send-now]").isDisabled());
    await shoot("dnc-restart");
    await dialog.locator("[data-field=read]").check();
    await dialog.locator("[data-action=send-now]").click();
    await state("waiting");
    await control.ask();
    await state("sending");
    await page.locator("[data-action=cancel]").click();
    await page.locator("[data-port-transfer]").waitFor({ state: "detached" });
    assert.ok(control.text.toString("latin1").startsWith(iso("%\nO2001(PLATE)\n(RESTART").toString("latin1")));
  });

  it("plans a transfer and takes it back", async () => {
    await page.locator("[data-action=send]").click();
    const dialog = page.locator("[data-dialog=port-send]");
    await dialog.locator("[data-field=program]").selectOption({ index: 0 });
    await dialog.locator("[data-field=when]").selectOption("time");
    assert.ok(await dialog.locator("[data-action=send-now]").isDisabled(), "no time, no plan");
    await dialog.locator("[data-field=time]").fill("2099-01-31T06:00");
    await dialog.locator("[data-action=send-now]").click();
    await dialog.getByText("cannot be used").waitFor();   // too far
    const soon = new Date(Date.now() + 26 * 3_600_000);
    await dialog.locator("[data-field=time]").fill(new Date(soon.getTime() - soon.getTimezoneOffset() * 60_000).toISOString().slice(0, 16));
    await shoot("dnc-plan");
    await dialog.locator("[data-action=send-now]").click();
    await dialog.waitFor({ state: "detached" });
    await page.locator("[data-plan][data-state=planned]").waitFor();
    await shoot("dnc-planned");
    await page.locator("[data-action=unplan]").click();
    await page.locator("[data-plan]").waitFor({ state: "detached" });
  });

  it("keeps a punch apart until somebody accepts it", async () => {
    control.reading = false;
    await page.locator("[data-port-state=listening]").waitFor();
    control.punch(program.replace("F1200.", "F900."));
    await page.locator("[data-tab=received] .count").waitFor();
    await page.locator("[data-tab=received]").click();
    await page.locator("[data-received] [data-action=look]").first().click();
    const dialog = page.locator("[data-dialog=received]");
    await dialog.locator("tr.changed").waitFor();
    await shoot("dnc-received");
    await dialog.locator("[data-action=accept]").click();
    await page.locator("[data-received][data-state=accepted]").waitFor();
    const revisions = await shop.list(`/programs/1/revisions`);
    assert.equal(revisions.length, 2);
    assert.match(revisions[0].origin, /^machine:/);
    assert.equal(revisions[0].released, null);
  });

  it("shows what lies in the machines and what changed in their data", async () => {
    await page.locator("[data-tab=census]").click();
    await page.locator("[data-resident=O2001][data-state=older]").waitFor();
    await shoot("dnc-census");
    for (const wear of ["-1.25", "-1.5"]) {
      await page.locator("[data-tab=ports]").click();
      await page.locator("[data-port-state=listening]").waitFor();
      control.punch(`%\nG10 G90 L10 P1 R120.5\nG10 G90 L11 P1 R${wear}\n%\n`);
      await page.locator("[data-tab=received] .count").waitFor();
      await page.locator("[data-tab=received]").click();
      await page.locator("[data-received][data-state=waiting] [data-action=look]").first().click();
      await page.locator("[data-dialog=received] [data-field=write]").waitFor();
      if (wear === "-1.5") await shoot("dnc-received-data");
      await page.locator("[data-dialog=received] [data-action=accept]").click();
      await page.locator("[data-dialog=received]").waitFor({ state: "detached" });
      const { values } = await shop.call("GET", "/machines/1/values");
      assert.deepEqual([values["tool/1/geometry/Z"], values["tool/1/wear/Z"]], [120.5, Number(wear)], "the machine has what it has punched");
      await page.locator("[data-tab=received] .count").waitFor({ state: "detached" });
    }
    await page.locator("[data-tab=data]").click();
    await page.locator("[data-punched] [data-action=look]").first().click();
    const change = page.locator("[data-dialog=machine-data] [data-change]");
    await change.filter({ hasText: "-1.25" }).filter({ hasText: "-1.5" }).waitFor();
    await shoot("dnc-data");
    await page.keyboard.press("Escape");
    await useLanguage(page, "zh");
    await page.locator("[data-tab=census]").click();
    await page.getByText("不是发布版本").first().waitFor();
    assert.deepEqual(browser.problems, []);
  });
});
