// The page in a real browser: PAGE is its address, EVENCUT the command to compare it with, PICTURES
// the folder for screenshots.
import assert from "node:assert/strict";
import { execFile, spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";
import { promisify } from "node:util";
import { unzipSync } from "fflate";
import { QUICK, accessible, drop, launch, open, plan, ready, sha256, type } from "./browser.mjs";

const { PAGE, EVENCUT, PICTURES } = process.env;
// The page plans a single operation.
const isSingle = (name) => name.endsWith(".toml") && !readFileSync(`jobs/${name}`, "utf8").includes("[[operation]]");
const JOBS = readdirSync("jobs").filter(isSingle).map((name) => name.replace(".toml", ""));
const scratch = mkdtempSync(join(tmpdir(), "evencut-page-"));
let browser;

before(async () => {
  mkdirSync(PICTURES, { recursive: true });
  browser = await launch();
});
after(async () => {
  await browser?.close();
  rmSync(scratch, { recursive: true, force: true });
});

/** Names and digests of what the command writes, by several threads: the page has one. */
async function native(job) {
  const folder = join(scratch, job);
  await promisify(execFile)(EVENCUT, ["plan", "--quiet", "--threads", "3", "-o", folder, `jobs/${job}.toml`]);
  const names = readdirSync(folder).filter((name) => !name.startsWith("."));
  return Object.fromEntries(names.sort().map((name) => [name, sha256(readFileSync(join(folder, name)))]));
}

async function downloaded(page, locator) {
  const [download] = await Promise.all([page.waitForEvent("download"), locator.click()]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

/** All files of the result as the page gives them, by themselves and in the zip. */
async function files(page) {
  await page.locator("#tab-files").click();
  const single = {};
  for (const link of await page.locator("#files table a").all()) {
    const { name, bytes } = await downloaded(page, link);
    single[name] = sha256(bytes);
    // Chromium drops what exceeds ten downloads in a second.
    await page.waitForTimeout(120);
  }
  const zip = await downloaded(page, page.locator("#zip[href]"));
  const unzipped = Object.entries(unzipSync(zip.bytes)).map(([name, bytes]) => [name.split("/").pop(), sha256(bytes)]);
  const sorted = (entries) => Object.fromEntries(entries.sort(([a], [b]) => (a < b ? -1 : 1)));
  return { single: sorted(Object.entries(single)), zip: sorted(unzipped) };
}

describe("examples", () => {
  for (const job of JOBS) {
    it(`${job}: files are those of the command`, async () => {
      const { page, context, complaints, requests } = await open(browser, `${PAGE}?example=${job}`, { shipped: true });
      assert.equal(await page.locator("#examples").inputValue(), job);
      const [wanted] = await Promise.all([native(job), plan(page)]);
      assert.ok(Object.keys(wanted).length >= 5);
      const given = await files(page);
      assert.deepEqual(given.single, wanted);
      assert.deepEqual(given.zip, wanted);
      assert.deepEqual(complaints, []);
      const foreign = requests.filter((url) => !url.startsWith(PAGE) && !/^(blob|data):/.test(url));
      assert.deepEqual(foreign, [], "the page asks for its own files only");
      await context.close();
    });
  }

  it("the menu holds all jobs", async () => {
    const { page, context } = await open(browser, PAGE);
    const ids = await page.locator("#examples option").evaluateAll((all) => all.map((one) => one.value));
    assert.deepEqual(ids.filter(Boolean), [...JOBS].sort());
    await page.locator("#examples").selectOption(QUICK);
    await page.locator("#job-name", { hasText: `${QUICK}.toml` }).waitFor();
    assert.match(page.url(), new RegExp(`example=${QUICK}`));
    await context.close();
  });

  it("an example that is not there is told", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=nothing`);
    assert.match(await page.locator("#notice").innerText(), /no example nothing/);
    await context.close();
  });
});

describe("views", () => {
  let page;
  let context;
  let complaints;
  before(async () => {
    ({ page, context, complaints } = await open(browser, `${PAGE}?example=${QUICK}`));
    await plan(page);
  });
  after(() => context?.close());

  const text = (id) => page.locator(id).innerText();

  it("a point of the chart lights up on the maps", async () => {
    const chart = await page.locator("#chart").boundingBox();
    for (const tab of ["flat", "surface", "scallop", "removal"]) {
      await page.locator(`#tab-${tab}`).click();
      const seen = new Set();
      for (const share of [0.3, 0.6]) {
        await page.mouse.move(chart.x + share * chart.width, chart.y + 0.5 * chart.height);
        const dot = page.locator("#picture .marks circle.pointed");
        await dot.waitFor({ state: "attached" });
        seen.add(`${await dot.getAttribute("cx")} ${await dot.getAttribute("cy")}`);
      }
      assert.equal(seen.size, 2, tab);
    }
  });

  it("a point of a map shows its values and lights up in the chart", async () => {
    for (const tab of ["flat", "scallop"]) {
      await page.locator(`#tab-${tab}`).click();
      const map = await page.locator("#picture").boundingBox();
      await page.mouse.move(map.x + 0.5 * map.width, map.y + 0.55 * map.height);
      await page.locator("#readout.pointed").waitFor();
      assert.match(await text("#readout"), /Rate\s+[\d.]+ mm³\/min\s+[\d.]+ % of limit/);
      assert.match(await text("#readout"), /Engagement\s+[\d.]+°/);
      assert.match(await text("#readout"), /Height left\s+−?[\d.]+ µm/);
      assert.match(await text("#readout"), /Pass\s+\d+[\s\S]+Region\s+0/);
      assert.equal(await page.locator("#chart .marks line.pointed").count(), 1);
    }
  });

  it("playback moves the cutter", async () => {
    const dot = page.locator("#picture .marks circle.dot").first();
    const place = async () => `${await dot.getAttribute("cx")} ${await dot.getAttribute("cy")}`;
    await page.locator("#tab-flat").click();
    const start = await place();
    await page.locator("#time").focus();
    await page.keyboard.press("End");
    const end = await place();
    assert.notEqual(end, start);
    // At its slowest: it must not end before it is paused.
    await page.locator("#speed").selectOption("5");
    await page.locator("#play").click();
    const time = () => page.locator("#time").evaluate((slider) => Number(slider.value) / Number(slider.max));
    assert.ok((await time()) < 0.9, "from its end it begins again");
    await page.waitForFunction(() => Number(document.getElementById("time").value) > 1);
    await page.locator("#play[aria-label=Pause]").click();
    assert.notEqual(await place(), end);
  });

  it("pictures zoom and come back", async () => {
    const layer = page.locator("#picture .layer");
    const width = async () => (await layer.boundingBox()).width;
    const whole = await width();
    await page.locator("#picture").focus();
    await page.keyboard.press("+");
    await page.keyboard.press("+");
    assert.ok((await width()) > 1.5 * whole);
    await page.keyboard.press("0");
    assert.ok(Math.abs((await width()) - whole) < 1);
    await page.locator("#picture").hover();
    await page.mouse.wheel(0, -400);
    await page.waitForFunction((w) => document.querySelector("#picture .layer").getBoundingClientRect().width > 1.5 * w, whole);
    await page.locator("#picture").getByLabel("Show all").click();
    assert.ok(Math.abs((await width()) - whole) < 1);
  });

  it("the part turns in three dimensions", async () => {
    await page.locator("#tab-space").click();
    const canvas = page.locator("#space canvas");
    await canvas.waitFor();
    const drawn = async () => sha256(await canvas.screenshot());
    await page.waitForTimeout(300);
    const first = await drawn();
    await canvas.focus();
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowLeft");
    await page.waitForTimeout(300);
    assert.notEqual(await drawn(), first);
  });

  it("nobody is kept out, in light and dark", async () => {
    for (const theme of ["light", "dark"]) {
      const now = () => page.locator("html").getAttribute("data-theme");
      if ((await now()) !== theme) await page.locator("#theme").click();
      for (const tab of ["flat", "scallop", "space", "report", "files"]) {
        await page.locator(`#tab-${tab}`).click();
        await accessible(page, `${theme}, ${tab}`);
      }
    }
  });

  it("no word of complaint", () => assert.deepEqual(complaints, []));
});

describe("texture", () => {
  it("is simulated where one clicks, as the command does", async () => {
    const { page, context, complaints } = await open(browser, `${PAGE}?example=texture`);
    await plan(page);
    await page.locator("#tab-texture").click();
    await page.locator("#texture-result svg").waitFor();
    assert.equal(await page.locator("#texture-result").getAttribute("data-at"), null, "the job's own window");
    const map = await page.locator("#texture-map").boundingBox();
    await page.mouse.click(map.x + 0.42 * map.width, map.y + 0.5 * map.height);
    await page.locator("#texture-result[data-at] svg").waitFor();
    assert.match(await page.locator("#texture-result pre").innerText(), /Sa [\d.]+ {2}Sq/);
    await accessible(page, "texture");
    const at = await page.locator("#texture-result").getAttribute("data-at");
    const [results, folder] = ["clicked", "clicked-texture"].map((name) => join(scratch, name));
    await promisify(execFile)(EVENCUT, ["plan", "-q", "-o", results, "jobs/texture.toml"]);
    await promisify(execFile)(EVENCUT, ["texture", "-q", `--at=${at}`, "--job=jobs/texture.toml", "-o", folder, results]);
    for (const link of await page.locator("#texture-result .links a").all()) {
      const { name, bytes } = await downloaded(page, link);
      assert.equal(sha256(bytes), sha256(readFileSync(join(folder, name))), name);
    }
    assert.equal(await page.locator("#texture-result .links a").count(), 5);
    assert.deepEqual(complaints, []);
    await context.close();
  });
});

describe("the job", () => {
  it("a fault is underlined where the command reports it", async () => {
    const { page, context, complaints } = await open(browser, `${PAGE}?example=mould`);
    const wrong = readFileSync("jobs/mould.toml", "utf8").replace("feed = 1500.0", 'feed = "fast"').replace("flutes = 3", "flutes = 3.5");
    await type(page, wrong);
    await page.locator("body[data-checked=bad]").waitFor();
    const file = join(scratch, "mould.toml");
    writeFileSync(file, wrong);
    const [{ errors }] = JSON.parse(spawnSync(EVENCUT, ["check", "--json", file]).stdout);
    assert.equal(errors.length, 2);
    const items = page.locator("#faults li");
    assert.equal(await items.count(), errors.length);
    const marked = page.locator("#editor .cm-lintRange-error");
    for (const [i, { key, message, place }] of errors.entries()) {
      const item = await items.nth(i).innerText();
      assert.ok(item.includes(`line ${place.line}, column ${place.column}`) && item.includes(`${key}: ${message}`), item);
      await items.nth(i).locator("button").click();
      const line = wrong.split("\n")[place.line - 1];
      const of = marked.nth(i).locator("xpath=ancestor::div[contains(concat(' ', @class, ' '), ' cm-line ')]");
      assert.equal(await of.innerText(), line);
      assert.ok(line.slice(place.column - 1).startsWith(await marked.nth(i).innerText()));
    }
    assert.ok(await page.locator("#plan").isDisabled());
    await accessible(page, "faults");
    assert.deepEqual(complaints, []);
    await context.close();
  });

  it("text survives a reload, and goes back", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`);
    const text = readFileSync(`jobs/${QUICK}.toml`, "utf8").replace(/^name = .*$/m, 'name = "my own words"');
    await type(page, text);
    await page.locator("#edited:visible").waitFor();
    await page.reload();
    await ready(page);
    await page.locator("#editor", { hasText: "my own words" }).waitFor();
    await page.locator("#revert").click();
    await page.locator("#editor", { hasText: "crowned block" }).waitFor();
    assert.equal(await page.locator("#edited").isVisible(), false);
    await context.close();
  });

  it("keys are completed and explained by the planner", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`);
    await type(page, 'version = 1\n[cut]\ndirection = "climb"\n');
    await page.keyboard.type("scal");
    await page.locator("#editor .cm-tooltip-autocomplete", { hasText: "scallop" }).waitFor();
    await page.keyboard.press("Escape");
    // In a list over several lines, too.
    await type(page, 'version = 1\n[cut]\ndirection = "climb"\n[output]\nsvg = [\n  "path",\n  ');
    await page.keyboard.type('"sca');
    await page.locator("#editor .cm-tooltip-autocomplete", { hasText: '"scallop"' }).waitFor();
    await page.keyboard.press("Escape");
    await page.locator("#editor .cm-line", { hasText: "direction" }).locator("span").first().hover();
    await page.locator("#editor .cm-doc", { hasText: "cut.direction" }).waitFor();
    assert.match(await page.locator("#editor .cm-doc").innerText(), /Expected: one of "climb", "conventional"/);
    await context.close();
  });

  it("a plan is cancelled, and made again", async () => {
    const { page, context, complaints } = await open(browser, `${PAGE}?example=${QUICK}`, { shipped: true });
    await page.locator("#plan:enabled").click();
    await page.waitForFunction(() => document.getElementById("progress").value > 0.1);
    await page.locator("#cancel").click();
    await page.locator("body[data-state=empty]").waitFor();
    await plan(page);
    assert.match(await page.locator("#figures").innerText(), /Limits\s+kept/);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  it("the keyboard is enough", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`);
    const at = () => page.evaluate(() => document.activeElement.id);
    const met = [];
    for (let i = 0; i < 12; i++) {
      await page.keyboard.press("Tab");
      met.push(await at());
    }
    for (const id of ["examples", "open", "theme", "save", "plan", "editor"]) assert.ok(met.includes(id), `${id} in ${met}`);
    assert.notEqual(met.at(-1), "editor", "the editor lets go");
    await page.keyboard.press("Control+Enter");
    await page.locator("body[data-planned]").waitFor();
    await page.locator("#tab-flat").focus();
    await page.keyboard.press("ArrowRight");
    assert.equal(await at(), "tab-surface");
    assert.equal(await page.locator("#tab-surface").getAttribute("aria-selected"), "true");
    await context.close();
  });
});

describe("files", () => {
  const surface = readFileSync("jobs/surfaces/crowned-block.stl");

  it("a broken surface is refused in the words of the command", async () => {
    const { page, context, complaints } = await open(browser, PAGE);
    const broken = surface.subarray(0, 4321);
    await drop(page, [{ name: "broken.stl", bytes: broken }]);
    await page.locator("#notice:visible").waitFor();
    const file = join(scratch, "broken.stl");
    writeFileSync(file, broken);
    const [message] = spawnSync(EVENCUT, ["inspect", file]).stderr.toString().split("\n");
    assert.equal(await page.locator("#notice").innerText(), message.replace("error", "broken.stl"));
    assert.deepEqual(complaints, []);
    await context.close();
  });

  it("a broken surface of a job is told when it is planned", async () => {
    const { page, context } = await open(browser, PAGE);
    const job = readFileSync("jobs/crown.toml", "utf8").replace("surfaces/", "");
    await drop(page, [{ name: "my.toml", bytes: Buffer.from(job) }, { name: "crowned-block.stl", bytes: surface.subarray(0, 4321) }]);
    await page.locator("#job-name", { hasText: "my.toml" }).waitFor();
    await page.locator("body[data-checked=good]").waitFor();
    await page.locator("#plan").click();
    await page.locator("#failure:visible").waitFor();
    writeFileSync(join(scratch, "my.toml"), job);
    writeFileSync(join(scratch, "crowned-block.stl"), surface.subarray(0, 4321));
    const [message] = spawnSync(EVENCUT, ["plan", "-q", join(scratch, "my.toml")]).stderr.toString().split("\n");
    assert.ok((await page.locator("#failure").innerText()).includes(message.replace("error: ", "")), message);
    await context.close();
  });

  it("a surface alone gets a job", async () => {
    const { page, context } = await open(browser, PAGE);
    const part = readFileSync("jobs/surfaces/wigley-hull.ply");
    await drop(page, [{ name: "part.ply", bytes: part }]);
    await page.locator("#job-name", { hasText: "part.toml" }).waitFor();
    await page.locator("body[data-checked=good]").waitFor();
    await page.locator("#editor", { hasText: 'file = "part.ply"' }).waitFor();
    await context.close();
  });

  it("what is neither is told", async () => {
    const { page, context } = await open(browser, PAGE);
    await drop(page, [{ name: "notes.txt", bytes: Buffer.from("x") }]);
    await page.locator("#notice", { hasText: "notes.txt: not a job" }).waitFor();
    await context.close();
  });
});

describe("screens", () => {
  for (const [name, width, height] of [["desktop", 1440, 900], ["phone", 390, 844]]) {
    it(name, async () => {
      const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`, { viewport: { width, height } });
      await page.screenshot({ path: join(PICTURES, `${name}-job.png`) });
      await accessible(page, `${name}, job`);
      await plan(page);
      for (const tab of ["flat", "scallop", "space", "report", "files"]) {
        await page.locator(`#tab-${tab}`).click();
        if (tab === "space") await page.locator("#space canvas").waitFor();
        const wide = await page.evaluate(() => document.documentElement.scrollWidth);
        assert.ok(wide <= width, `${tab} is ${wide} px wide`);
        await page.screenshot({ path: join(PICTURES, `${name}-${tab}.png`), fullPage: true });
      }
      await accessible(page, `${name}, plan`);
      await context.close();
    });
  }
});

describe("trouble", () => {
  it("a panic is told as a bug", async () => {
    const { page, context } = await open(browser, PAGE);
    const told = await page.evaluate(async () => {
      const [module, script] = await Promise.all(["evencut.wasm", "worker.js"].map(async (name) => (await fetch(name)).arrayBuffer()));
      const worker = new Worker(URL.createObjectURL(new Blob([script], { type: "text/javascript" })), { type: "module" });
      const first = new Promise((resolve) => {
        worker.onmessage = ({ data }) => resolve(data);
      });
      worker.postMessage(await WebAssembly.compile(module));
      worker.postMessage({ id: 1, ask: { mill: {} } });
      return first;
    });
    assert.match(told.ended.message, /^This is a bug in evencut: .*unknown variant `mill`/s);
    await context.close();
  });

  it("a module without memory is a message, and the page goes on", async () => {
    const small = await launch("--js-flags=--wasm-max-mem-pages=400");
    try {
      const { page } = await open(small, `${PAGE}?example=mould`);
      await page.locator("#plan:enabled").click();
      await page.locator("#failure:visible").waitFor();
      assert.match(await page.locator("#failure").innerText(), /ran out of memory/);
      await page.locator("#examples").selectOption(QUICK);
      await page.locator("body[data-checked=good]").waitFor();
    } finally {
      await small.close();
    }
  });
});
