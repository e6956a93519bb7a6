// What an administrator keeps the shop with, in a real browser on a real shop: a machine's backup restored on a new agent,
// the audit trail verified, a right on one machine, a screen that only looks.
import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";
import { openBrowser, signIn, useLanguage } from "./chromium.mjs";
import { built, Shop, until } from "./shop.mjs";

const program = "O1001\nN10 G21 G99 G97 S1000 M03\nN20 G00 X40. Z2.\nN30 G01 Z-5. F0.5\nN40 M30\n";
let shop, browser, page, first;
const open = async (tab) => { await page.goto(`${shop.url}/#/users?tab=${tab}`); await page.locator(`[data-tab=${tab}][aria-selected=true]`).waitFor(); };
const residents = async (machine) => (await shop.list(`/machines/${machine}/programs`)).map((one) => one.name);

describe("keeping the shop", { skip: !built() && "not built" }, () => {
  before(async () => {
    shop = await Shop.start();
    first = await shop.addMachine("Lathe 1", "fanuc-0i-t", "lathe-1.toml");
    const response = await fetch(`${shop.url}/api/v1/programs?folder=&name=O1001&note=first`, { method: "POST", body: program, headers: { "Content-Type": "application/octet-stream", Authorization: `Bearer ${shop.token}` } });
    const id = (await response.json()).program.id;
    await shop.call("POST", `/programs/${id}/revisions/1/check`, { machine: first });
    await until("checked", async () => (await shop.list(`/programs/${id}/revisions/1/checks`)).length > 0);
    await shop.call("POST", `/programs/${id}/revisions/1/release`, { why: "test" });
    await shop.call("POST", "/distributions", { program: id, revision: 1, machines: [first] });
    await until("on the machine", async () => (await residents(first)).includes("O1001"));
    browser = await openBrowser({ language: "en" });
    page = browser.page;
    await page.goto(shop.url);
    await useLanguage(page, "en");
    await signIn(page, shop);
  });
  after(async () => { await browser?.close(); await shop?.stop(); });

  it("restores a machine's backup on a new agent", async () => {
    await open("backups");
    await page.locator("select[name=machine]").selectOption(String(first));
    await page.locator("[data-action=backup-machine]").click();
    await page.locator("[data-kind=machine]").waitFor();
    const replacement = await shop.addMachine("Lathe 1 new", "fanuc-0i-t", "lathe-1.toml");
    assert.deepEqual(await residents(replacement), []);
    await page.reload();
    await page.locator("[data-kind=machine] [data-action=restore]").click();
    const dialog = page.locator("[data-dialog=restore]");
    await dialog.locator("select[name=target]").selectOption(String(replacement));
    await dialog.getByRole("button", { name: "Restore" }).click();
    await dialog.locator(`[data-restored="${replacement}"]`).getByText("O1001").waitFor();
    await until("the program is on the new machine", async () => (await residents(replacement)).includes("O1001"));
    await dialog.getByRole("button", { name: "Done" }).click();
  });

  it("backs up the whole server and verifies the file", async () => {
    await open("backups");
    await page.locator("[data-action=backup-server]").click();
    await page.locator("[data-kind=server]").waitFor();
    await page.locator("[data-kind=server]").getByRole("button", { name: /Verify/ }).click();
    await page.getByText(/is whole/).waitFor();
  });

  it("shows and verifies the audit trail", async () => {
    await open("audit");
    await page.locator("tr[data-audit]").first().waitFor();
    await page.getByRole("button", { name: "Verify the chain" }).click();
    await page.getByText(/^Whole:/).waitFor();
  });

  it("a right on one machine opens that machine only", async () => {
    await shop.call("POST", "/users", { user: "li", password: "correct horse 7", role: "viewer", must_change_password: false });
    await open("rights");
    await page.locator("tr[data-user=li]").getByRole("button").click();
    const dialog = page.locator("[data-dialog=grants]");
    await dialog.getByRole("button", { name: "Add a right" }).click();
    await dialog.getByLabel("What").selectOption("r:setter");
    await dialog.getByLabel("Where").selectOption(`m${first}`);
    await dialog.getByRole("button", { name: "Save" }).click();
    await dialog.waitFor({ state: "detached" });
    const { token, machine_roles } = await shop.call("POST", "/session", { user: "li", password: "correct horse 7" }, null);
    assert.deepEqual(machine_roles, { [first]: "setter" });
    await shop.call("PATCH", `/machines/${first}`, { parts_required: 3 }, token);
    await assert.rejects(shop.call("POST", "/folders", { path: "/x" }, token), /403/);
  });

  it("a screen's address shows the floor and nothing to press", async () => {
    await open("screens");
    await page.getByRole("button", { name: "Add screen" }).click();
    await page.locator("[data-dialog=screen] input[name=name]").fill("Hall 1");
    await page.locator("[data-dialog=screen]").getByRole("button", { name: "Create" }).click();
    const address = await page.locator("[data-screen-address]").inputValue();
    const other = await openBrowser({ language: "en" });
    try {
      await other.page.goto(address);
      await other.page.locator("[data-page=floor]").waitFor();
      assert.ok(!other.page.url().includes("screen/"), "the secret does not stay in the address");
      const refused = await other.page.evaluate(async () => (await fetch("/api/v1/machines", { method: "POST", headers: { "X-Headstock": "1", "Content-Type": "application/json" }, body: "{}" })).status);
      assert.equal(refused, 403);
    } finally { await other.close(); }
  });
});
