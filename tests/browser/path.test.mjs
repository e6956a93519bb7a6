// The path of a part, as a person walks it: upload, check, release, send, select, arm at the machine, cycle start, one part
// counted on the card and in the store, exactly once; then an alarm that stops the axes and is cleared by reset. Mouse and
// keyboard, Chinese and English, against a real server and real agents.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";
import { openBrowser, signIn, useLanguage } from "./chromium.mjs";
import { built, Shop, until } from "./shop.mjs";
import { root } from "./paths.mjs";

const lathe = `%
O0100 (TURNED PIN)
G21 G40 G99
T0101
G97 S800 M03
G00 X42. Z2.
G01 Z-12. F0.4
X44.
G00 Z2.
G01 X38. F0.5
Z-8.
G02 X42. Z-10. R2.
G00 X60. Z20.
M05
M30
%
`;
// The second revision only feeds faster: the difference must call it that.
const lathe2 = lathe.replace("F0.4", "F0.5");
// Without the lap it makes first, and faster: what is looked at is how it ends.
const overtravelText = readFileSync(join(root, "deploy/examples/mill-1/O1190_passes_soft_limit.nc"), "utf8")
  .replace(/N80 .*N110[^\n]*\n/s, "N80 F8000\n");

const words = {
  zh: { start: "循环启动", hold: "进给保持", reset: "复位", running: "运行中", notArmed: "机床侧未授权远程操作", released: "已发布", alarm: "报警", feed: "进给或转速" },
  en: { start: "Cycle start", hold: "Feed hold", reset: "Reset", running: "Running", notArmed: "Remote operation is not armed at the machine", released: "released", alarm: "Alarm", feed: "feed or speed" },
};

let shop, browser, page;
// The listing's running block is one of these lines. A selector, because the pages' security policy forbids evaluated strings.
const lines = (first, last) => Array.from({ length: last - first + 1 }, (_, i) => `.listing .row.current[data-line="${first + i}"]`).join(",");
const file = (name, text) => ({ name, mimeType: "text/plain", buffer: Buffer.from(text) });
const upload = async (files, note) => {
  await page.locator(".upload-button input[type=file]").setInputFiles(files);
  await page.locator("[data-dialog=upload] input[name=note]").fill(note);
  await page.keyboard.press("Enter");
  for (const one of files) await page.locator(`[data-upload="${one.name}"][data-state=done]`).waitFor();
  await page.locator("[data-dialog=upload] footer button").click();
};
const drop = async (name, text) => {
  const data = await page.evaluateHandle(([fileName, content]) => { const transfer = new DataTransfer(); transfer.items.add(new File([content], fileName)); return transfer; }, [name, text]);
  await page.dispatchEvent("[data-page=programs]", "dragover", { dataTransfer: data });
  await page.locator(".drop-sign").waitFor();
  await page.dispatchEvent("[data-page=programs]", "drop", { dataTransfer: data });
};
const checkOn = async (machine, result) => {
  await page.locator("[data-tab=check]").click();
  await page.locator(`[data-check="${machine}"] [data-action=check]`).click();
  await page.locator(`[data-check="${machine}"][data-result="${result}"]`).waitFor();
};
const release = async (why) => {
  await page.locator("[data-action=release]").click();
  await page.locator("[data-dialog=reason] input[name=why]").fill(why);
  await page.keyboard.press("Enter");
  await page.locator("[data-field=released].good").waitFor();
};
const sendTo = async (machine) => {
  await page.locator("[data-tab=send]").click();
  await page.locator(`[data-send-to="${machine}"] input[type=checkbox]`).check();
  await page.locator("[data-action=send]").click();
  await page.locator('[data-panel=send-results] [data-state="done"]').waitFor();
};
const select = async (id, name) => {
  await page.goto(`${shop.url}/#/machines/${id}`);
  const row = page.locator(`[data-resident="${name}"]`);
  await row.waitFor();
  await row.locator(`[data-select="${name}"]`).click();
  await page.locator('[data-panel=program] [data-field=program]').filter({ hasText: name.replace(/\..*$/, "") }).waitFor();
};
const start = async () => {
  await page.locator("[data-command=cycle_start]").click();
  await page.locator("[data-dialog=confirm] [data-confirm=cycle_start]").click();
};
const parts = async (id) => (await shop.list(`/parts?machine=${id}`)).length;

describe("the path of a part", { skip: built() ? false : "headstock-server and headstock-agent are not built" }, () => {
  const ids = {};
  before(async () => {
    shop = await Shop.start({ keepFirst: true });
    browser = await openBrowser({ language: "en" });
    page = browser.page;
  });
  after(async () => {
    await browser?.close();
    await shop?.stop();
  });

  it("begins with the first sign-in and an own password", async () => {
    await page.goto(shop.url);
    await useLanguage(page, "zh");
    await signIn(page, shop);
    if (await page.locator("[data-page=account]").count()) {
      await page.locator("input[name=old]").fill(shop.password);
      await page.locator("input[name=new]").fill("a better one 7");
      await page.locator("input[name=again]").fill("a better one 7");
      await page.keyboard.press("Enter");
      shop.password = "a better one 7";
    }
    await page.locator("[data-page=floor]").waitFor();
    await shop.signIn();   // the change has ended the session the test had beside the browser
  });

  it("a machine is added in the browser and joins with the token shown once", async () => {
    await page.getByRole("button", { name: "添加机床" }).click();
    await page.locator("[data-dialog=add-machine] input").fill("Lathe 1");
    await page.locator("[data-dialog=add-machine] select").selectOption("fanuc-0i-t");
    await page.getByRole("button", { name: "新建" }).click();
    const token = await page.locator("[data-field=token]").innerText();
    assert.match(token, /^HS1-/);
    await page.locator("[data-dialog=token] footer button").click();
    const id = (await shop.list("/machines")).find((one) => one.name === "Lathe 1").id;
    await page.locator(`.card[data-machine="${id}"][data-state="unknown"]`).waitFor();
    ids.lathe = await shop.addMachine("Lathe 1", "fanuc-0i-t", "lathe-1.toml", token);
    assert.equal(ids.lathe, id);
    await page.locator(`.card[data-machine="${id}"][data-state="idle"]`).waitFor();
    ids.mill = await shop.addMachine("Mill 1", "fanuc-0i-m", "mill-1.toml");
    await page.locator(`.card[data-machine="${ids.mill}"][data-state="idle"]`).waitFor();
  });

  for (const [round, language] of ["zh", "en"].entries()) {
    const say = words[language];
    const name = round === 0 ? "O0100.nc" : "O0200.nc";
    const mill = overtravelText.replace("O1190", round === 0 ? "O1190" : "O1191");
    const overtravel = round === 0 ? "O1190" : "O1191";
    const text = (source) => (round === 0 ? source : source.replace("O0100", "O0200"));

    describe(`in ${language === "zh" ? "Chinese" : "English"}`, () => {
      let program;
      it("upload by drag and drop, and a second revision by the button", async () => {
        await useLanguage(page, language);
        await page.locator("[data-nav=programs]").click();
        await page.locator("[data-page=programs]").waitFor();
        await drop(name, text(lathe));
        await page.locator("[data-dialog=upload] input[name=note]").fill("first");
        await page.keyboard.press("Enter");
        await page.locator(`[data-upload="${name}"][data-state=done]`).waitFor();
        await page.locator("[data-dialog=upload] footer button").click();
        await upload([file(name, text(lathe2))], "faster");
        await page.locator(`[data-program="${name}"]`).click();
        await page.locator('[data-page=program][data-revision="2"]').waitFor();
        program = Number(/programs\/(\d+)/.exec(page.url())[1]);
        await page.locator('.listing [data-line="2"]').filter({ hasText: "TURNED PIN" }).waitFor();
      });

      it("the difference says that only a feed was changed", async () => {
        await page.locator("[data-tab=diff]").click();
        await page.locator('[data-panel=diff] [data-class="feed_speed"]').filter({ hasText: say.feed }).waitFor();
        assert.equal(await page.locator('[data-panel=diff] [data-class="geometry"]').count(), 0);
        assert.equal(await page.locator(".diff tr.changed").count(), 1);
      });

      it("a release without a check is refused, after a check it is not", async () => {
        await page.locator("[data-action=release]").click();
        await page.locator("[data-dialog=reason] input[name=why]").fill("impatient");
        await page.keyboard.press("Enter");
        await page.locator("[data-dialog=reason] .note.error").waitFor();
        await page.keyboard.press("Escape");
        await checkOn("Lathe 1", "ok");
        const time = await page.locator('[data-check="Lathe 1"] td.num').innerText();
        assert.match(time, /^\d+:\d\d$/, "predicted time");
        await page.locator("[data-path=lathe] canvas").waitFor();
        await release("first piece measured");
        assert.match(await page.locator("[data-field=released]").innerText(), new RegExp(say.released));
      });

      it("it is sent to the machine and selected there", async () => {
        await sendTo("Lathe 1");
        const resident = (await shop.list(`/machines/${ids.lathe}/programs`)).find((one) => one.program_id === program);
        assert.equal(resident?.revision, 2);
        await select(ids.lathe, resident.name);
      });

      it("cycle start is refused in words until remote operation is armed at the machine", async () => {
        const [before] = [await parts(ids.lathe)];
        await page.getByRole("button", { name: say.hold }).waitFor();
        await start();
        await page.locator("[data-toast=error]").filter({ hasText: say.notArmed }).waitFor();
        assert.equal(await parts(ids.lathe), before);
        await shop.panel("Lathe 1", "arm");
        await page.locator('[data-field=armed][data-armed="true"]').waitFor();
      });

      it("it runs, and one part is counted, exactly once", async () => {
        const before = await parts(ids.lathe);
        await start();
        await page.locator('[data-page=machine][data-state="running"]').waitFor();
        await page.getByText(say.running).first().waitFor();
        await page.locator(lines(7, 15)).first().waitFor();
        await page.locator('[data-page=machine][data-state="idle"]').waitFor();
        await page.locator("[data-nav=floor]").click();
        await page.locator(`.card[data-machine="${ids.lathe}"] [data-field=parts]`).filter({ hasText: new RegExp(`^${before + 1}\\b`) }).waitFor();
        assert.equal(await until("the part in the store", async () => (await parts(ids.lathe)) > before && (await parts(ids.lathe))), before + 1);
        await shop.panel("Lathe 1", "disarm");
      });

      it("the check sees a soft limit before the machine does, and names the block", async () => {
        await page.locator("[data-nav=programs]").click();
        await upload([file(`${overtravel}.nc`, mill)], "for the alarm");
        await page.locator(`[data-program="${overtravel}.nc"]`).click();
        await checkOn("Mill 1", "bad");
        await page.locator("[data-finding]").first().click();
        await page.locator(".listing .row.current").filter({ hasText: "N140" }).waitFor();
      });

      it("loaded at the machine itself, it stops with the controller's own alarm, which reset clears", async () => {
        const path = join(shop.data, `${overtravel}.nc`);
        writeFileSync(path, mill);
        // Armed first: a machine takes a reset over the network only while its operator allows it.
        await shop.panel("Mill 1", "arm");
        await shop.panel("Mill 1", "load", path);
        await shop.panel("Mill 1", "select", `${overtravel}.nc`);
        await page.locator("[data-nav=floor]").click();
        await shop.panel("Mill 1", "start");
        const card = page.locator(`.card[data-machine="${ids.mill}"][data-state="alarm"]`);
        await card.waitFor();
        assert.match(await card.locator(".card-state").innerText(), new RegExp(say.alarm));
        const shown = await card.locator("[data-field=alarm]").innerText();
        assert.match(shown, /^OT05\d\d/);
        assert.match(shown, language === "zh" ? /[\u4e00-\u9fff]{2}/ : /[A-Za-z]{4}/);
        await card.click();
        await page.locator("[data-field=alarms]").filter({ hasText: /OT05\d\d/ }).waitFor();
        await page.locator("[data-command=reset]").click();
        await page.locator("[data-field=alarms]").waitFor({ state: "detached" });
        await page.locator('[data-page=machine][data-state="alarm"]').waitFor({ state: "detached" });
        assert.equal(await parts(ids.mill), 0);
      });
    });
  }

  it("the history holds both alarms, with filters", async () => {
    await page.locator("[data-nav=alarms]").click();
    await page.locator("[data-page=alarms]").waitFor();
    await page.locator("tr[data-alarm^=OT05]").nth(1).waitFor();
    await page.locator("input[name=active]").check();
    await page.locator(".empty").waitFor();
    await page.locator("input[name=active]").uncheck();
    await page.locator("select[name=machine]").selectOption({ label: "Lathe 1" });
    await page.locator(".empty").waitFor();
    await page.locator("select[name=machine]").selectOption({ label: "Mill 1" });
    await page.locator("tr[data-alarm]").nth(1).waitFor();
  });

  it("a machine that is cut off becomes unknown, not idle", async () => {
    await page.locator("[data-nav=floor]").click();
    const agent = shop.agents.get("Lathe 1");
    await shop.end(agent.process, "SIGKILL");
    const card = page.locator(`.card[data-machine="${ids.lathe}"]`);
    await page.locator(`.card[data-machine="${ids.lathe}"][data-state="unknown"]`).waitFor();
    assert.match(await card.locator(".card-state").innerText(), /Unknown/);
    shop.restartAgent("Lathe 1");
    await page.locator(`.card[data-machine="${ids.lathe}"][data-state="idle"]`).waitFor();
  });

  it("leaves no error in the page", () => assert.deepEqual(browser.problems, []));
});
