// What people do with the page besides planning an example: PAGE is its address.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, describe, it } from "node:test";
import { QUICK, accessible, drop, launch, open, plan, quickJob, ready, sha256, type } from "./browser.mjs";

const { PAGE } = process.env;
const hull = readFileSync("jobs/surfaces/wigley-hull.ply");
const crown = readFileSync("jobs/surfaces/crowned-block.stl");
const ownJob = Buffer.from(quickJob().replace("surfaces/crowned-block.stl", "block.stl"));

let browser;
before(async () => {
  browser = await launch();
});
after(() => browser?.close());

const notice = (page, words) => page.locator("#notice", { hasText: words }).waitFor();
const named = (page, name) => page.locator("#job-name", { hasText: name }).waitFor();
const good = (page) => page.locator("body[data-checked=good]").waitFor();

/** Stops the planner's messages once one of a kind arrives, so that a stage can be looked at. */
const holdAt = (phase) => [(wanted) => {
  const Plain = Worker;
  globalThis.Worker = class extends Plain {
    set onmessage(take) {
      let held = null;
      super.onmessage = (event) => {
        const { early } = event.data;
        if (held) held.push(event);
        else take(event);
        if (early && !globalThis.free && (early.report ? "planned" : "laid") === wanted) held = [];
      };
      globalThis.goOn = () => {
        const waiting = held ?? [];
        held = null;
        waiting.forEach(take);
      };
    }
  };
}, phase];

describe("a plan as it comes", () => {
  for (const phase of ["laid", "planned"]) {
    it(`what is ${phase} is shown before the end`, async () => {
      const { page, context, complaints } = await open(browser, `${PAGE}?example=${QUICK}`, { init: holdAt(phase) });
      await page.locator("#plan:enabled").click();
      await page.locator(`body[data-state=early][data-shown=${phase}]`).waitFor();
      for (const tab of ["flat", "surface"]) {
        await page.locator(`#tab-${tab}`).click();
        await page.locator("#picture .layer > svg:not(.marks) path").first().waitFor({ state: "attached" });
      }
      assert.equal(await page.locator("#tab-scallop").count(), 0);
      assert.equal(await page.locator("#readout").isVisible(), phase === "planned");
      assert.equal(await page.locator("#tab-files").count(), phase === "planned" ? 1 : 0);
      if (phase === "planned") {
        assert.match(await page.locator("#figures").innerText(), /Peak rate\s+\d+ % of the limit\s+predicted/);
        await page.locator("#tab-files").click();
        assert.equal(await page.locator("#zip").count(), 0, "not all files are there");
        await page.locator("#files a", { hasText: "program.ngc" }).waitFor();
      }
      await accessible(page, phase);
      const tab = await page.locator("#tabs [aria-selected=true]").getAttribute("id");
      await page.evaluate(() => globalThis.goOn());
      await page.locator("body[data-state=planned][data-planned]").waitFor();
      assert.equal(await page.locator("#tabs [aria-selected=true]").getAttribute("id"), tab, "the tab stays");
      assert.match(await page.locator("#figures").innerText(), /Limits\s+kept/);
      assert.deepEqual(complaints, []);
      await context.close();
    });

    it(`cancelled when it is ${phase}`, async () => {
      const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`, { init: holdAt(phase) });
      await page.locator("#plan:enabled").click();
      await page.locator(`body[data-shown=${phase}]`).waitFor();
      await page.locator("#stop").click();
      if (phase === "laid") {
        await page.locator("body[data-state=empty]").waitFor();
      } else {
        await page.locator("#cut-short:visible").waitFor();
        assert.match(await page.locator("#figures").innerText(), /not simulated/);
      }
      assert.ok(await page.locator("#plan").isVisible());
      await page.evaluate(() => {
        globalThis.free = true;
      });
      await plan(page);
      assert.equal(await page.locator("#cut-short").isVisible(), false);
      await context.close();
    });
  }

  it("cancelled at once", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`);
    await page.locator("#plan:enabled").focus();
    await page.evaluate(() => {
      document.getElementById("plan").click();
      document.dispatchEvent(new KeyboardEvent("keydown", { key: "Escape", bubbles: true }));
    });
    await page.waitForTimeout(1500);
    assert.equal(await page.locator("body").getAttribute("data-state"), "empty");
    assert.ok(await page.locator("#plan").isEnabled());
    await context.close();
  });

  it("an edit marks the plan as of an earlier text", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`);
    await plan(page);
    await page.locator("#editor .cm-content").click();
    await page.keyboard.type("#");
    await page.locator("#stale:visible").waitFor();
    await page.keyboard.press("Control+z");
    await page.locator("#stale").waitFor({ state: "hidden" });
    await context.close();
  });
});

describe("pictures", () => {
  it("without a limit colours tell the time, and no rate is made up", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=lens`);
    await plan(page);
    await page.locator("#tab-flat").click();
    assert.match(await page.locator("#legend").innerText(), /Time of cutting\s+min:s/);
    assert.match(await page.locator("#readout").innerText(), /Measured rate\s+[\d.]+ mm³\/min\s+Engagement\s+–/);
    assert.equal(await page.locator("#chart-frame").isVisible(), false);
    await context.close();
  });

  it("three dimensions are coloured as chosen, with a legend", async () => {
    const { page, context, complaints } = await open(browser, `${PAGE}?example=${QUICK}`);
    await plan(page);
    await page.locator("#tab-space").click();
    await page.locator("#space canvas").waitFor();
    const seen = new Set();
    for (const [surface, words] of [["plain", /Removal rate/], ["height", /Height\s+z, mm/], ["residual", /Height left\s+µm/], ["rate", /Measured removal rate/]]) {
      await page.locator("#space-surface").selectOption(surface);
      await page.waitForTimeout(400);
      seen.add(sha256(await page.locator("#space canvas").screenshot()));
      assert.match(await page.locator("#legend").innerText(), words);
      await accessible(page, surface);
    }
    await page.locator("#space-lines").selectOption("plain");
    await page.waitForTimeout(400);
    seen.add(sha256(await page.locator("#space canvas").screenshot()));
    assert.equal(seen.size, 5);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  it("a picture that the page does not know is shown by its name", async () => {
    const { page, context, complaints } = await open(browser, `${PAGE}?example=${QUICK}`, { init: [() => {
      const Plain = Worker;
      globalThis.Worker = class extends Plain {
        set onmessage(take) {
          super.onmessage = (event) => {
            const svg = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 90 60"><title>Some regions</title><path d="M0 0h50v50z"/></svg>';
            event.data.value?.files?.push({ name: "regions.svg", bytes: new TextEncoder().encode(svg) });
            take(event);
          };
        }
      };
    }] });
    await plan(page);
    await page.locator("#tabs button", { hasText: "Regions" }).click();
    await page.locator('#picture path[d="M0 0h50v50z"]').waitFor();
    assert.equal(await page.locator("#legend").isVisible(), false);
    await page.locator("#picture").hover();
    assert.deepEqual(complaints, []);
    await context.close();
  });
});

describe("what stays", () => {
  it("a surface survives a reload until it is forgotten", async () => {
    const { page, context } = await open(browser, PAGE);
    await drop(page, [{ name: "my.toml", bytes: ownJob }, { name: "block.stl", bytes: crown }]);
    await named(page, "my.toml");
    await good(page);
    await page.reload();
    await ready(page);
    await named(page, "my.toml");
    await good(page);
    await plan(page);
    await page.locator("#forget").click();
    await page.locator("body[data-checked=bad]").waitFor();
    await page.reload();
    await ready(page);
    assert.match(await page.locator("#faults").innerText(), /there is no file block.stl/);
    assert.equal(await page.locator("#forget").count(), 0);
    await context.close();
  });

  it("where nothing may be stored the page works, and says so", async () => {
    const { page, context, complaints } = await open(browser, PAGE, { init: [() => {
      IDBFactory.prototype.open = () => {
        throw new DOMException("no", "SecurityError");
      };
      Storage.prototype.getItem = Storage.prototype.setItem = () => {
        throw new DOMException("no", "SecurityError");
      };
    }] });
    await drop(page, [{ name: "my.toml", bytes: ownJob }, { name: "block.stl", bytes: crown }]);
    await notice(page, "gone when the page is closed");
    await good(page);
    assert.deepEqual(complaints, []);
    await context.close();
  });

  it("back and forward go between jobs, with their edits", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`);
    await type(page, readFileSync(`jobs/${QUICK}.toml`, "utf8").replace(/^name = .*$/m, 'name = "edited here"'));
    await page.locator("#edited:visible").waitFor();
    await page.locator("#examples").selectOption("lens");
    await named(page, "lens.toml");
    await page.goBack();
    await named(page, `${QUICK}.toml`);
    await page.locator("#editor", { hasText: "edited here" }).waitFor();
    assert.equal(await page.locator("#examples").inputValue(), QUICK);
    await page.goForward();
    await named(page, "lens.toml");
    await drop(page, [{ name: "my.toml", bytes: ownJob }]);
    await named(page, "my.toml");
    await page.goBack();
    await named(page, "lens.toml");
    await page.locator("#examples").selectOption("");
    await named(page, "my.toml");
    await context.close();
  });

  it("an edited job of one's own that gives way comes back", async () => {
    const { page, context } = await open(browser, PAGE);
    await drop(page, [{ name: "mine.toml", bytes: ownJob }]);
    await named(page, "mine.toml");
    await type(page, String(ownJob).replace(/^name = .*$/m, 'name = "long thought"'));
    await page.locator("#edited:visible").waitFor();
    await drop(page, [{ name: "other.toml", bytes: ownJob }]);
    await named(page, "other.toml");
    await notice(page, "mine.toml had edits and was replaced");
    await page.getByRole("button", { name: "Back to mine.toml" }).click();
    await named(page, "mine.toml");
    await page.locator("#editor", { hasText: "long thought" }).waitFor();
    await context.close();
  });

  it("two tabs do not disturb each other", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`);
    const other = await context.newPage();
    await other.goto(`${PAGE}?example=lens`);
    await ready(other);
    const worded = (job, words) => readFileSync(`jobs/${job}.toml`, "utf8").replace(/^name = .*$/m, `name = "${words}"`);
    await type(page, worded(QUICK, "first tab"));
    await type(other, worded("lens", "second tab"));
    await page.reload();
    await ready(page);
    await page.locator("#editor", { hasText: "first tab" }).waitFor();
    await other.reload();
    await ready(other);
    await other.locator("#editor", { hasText: "second tab" }).waitFor();
    await context.close();
  });

  it("planning goes on without the server", async () => {
    const { page, context } = await open(browser, `${PAGE}?example=lens`, { shipped: true });
    await context.setOffline(true);
    await plan(page);
    await plan(page);
    await page.locator("#examples").selectOption(QUICK);
    await notice(page, "the server of this page does not answer");
    assert.equal(await page.locator("#job-name").innerText(), "lens.toml");
    assert.equal(await page.locator("#examples").inputValue(), "lens");
    await context.close();
  });
});

describe("unusual files", () => {
  it("a job without its surface says what it waits for, and takes it", async () => {
    const { page, context } = await open(browser, PAGE);
    await drop(page, [{ name: "my.toml", bytes: Buffer.from(String(ownJob).replace("block.stl", "parts/block.stl")) }]);
    await named(page, "my.toml");
    await page.locator("body[data-checked=bad]").waitFor();
    assert.match(await page.locator("#surface").innerText(), /not here yet/);
    assert.ok(await page.locator("#plan").isDisabled());
    await drop(page, [{ name: "block.stl", bytes: crown }]);
    await good(page);
    await named(page, "my.toml");
    await context.close();
  });

  it("a job with a post of its own waits for it, and is planned with it", async () => {
    const { page, context } = await open(browser, PAGE);
    const job = String(ownJob).replace('post = "linuxcnc"', 'post_file = "shop.post.toml"');
    const post = readFileSync("core/posts/grbl.toml", "utf8").replace('extension = "nc"', 'extension = "tap"');
    await drop(page, [{ name: "my.toml", bytes: Buffer.from(job) }, { name: "block.stl", bytes: crown }]);
    await named(page, "my.toml");
    await page.locator("body[data-checked=bad]").waitFor();
    assert.match(await page.locator("#surface").innerText(), /post shop\.post\.toml not here yet/);
    await drop(page, [{ name: "shop.post.toml", bytes: Buffer.from(post) }]);
    await good(page);
    await named(page, "my.toml");
    await plan(page);
    await page.locator("#tab-files").click();
    await page.locator("#files", { hasText: "program.tap" }).waitFor();
    await context.close();
  });

  it("a job with a library of tools waits for it, and is planned with it", async () => {
    const { page, context } = await open(browser, PAGE);
    const job = String(ownJob).replace(/\[tool\][^[]*/, '[tool]\nlibrary = "shop.tools.toml"\nnumber = 7\n\n');
    const tools = "[[tool]]\nnumber = 7\nkind = \"ball\"\ndiameter = 6.0\n";
    await drop(page, [{ name: "my.toml", bytes: Buffer.from(job) }, { name: "block.stl", bytes: crown }]);
    await named(page, "my.toml");
    await page.locator("body[data-checked=bad]").waitFor();
    assert.match(await page.locator("#surface").innerText(), /with shop\.tools\.toml not here yet/);
    await drop(page, [{ name: "shop.tools.toml", bytes: Buffer.from(tools) }]);
    await good(page);
    await named(page, "my.toml");
    await plan(page);
    await context.close();
  });

  it("another surface than the job waits for is asked about", async () => {
    const { page, context } = await open(browser, PAGE);
    const start = async () => {
      await drop(page, [{ name: "my.toml", bytes: ownJob }]);
      await named(page, "my.toml");
      await drop(page, [{ name: "hull.ply", bytes: hull }]);
      await notice(page, "my.toml asks for block.stl, not for hull.ply");
      await accessible(page, "question");
    };
    await start();
    await page.getByRole("button", { name: "Use hull.ply in my.toml" }).click();
    await page.locator("#editor", { hasText: 'file = "hull.ply"' }).waitFor();
    await good(page);
    await start();
    await page.getByRole("button", { name: "New job for hull.ply" }).click();
    await named(page, "hull.toml");
    await good(page);
    await context.close();
  });

  it("several jobs, files without use and folders are told together", async () => {
    const { page, context } = await open(browser, PAGE);
    await drop(page, [
      { name: "a.toml", bytes: ownJob }, { name: "b.toml", bytes: ownJob }, { name: "block.stl", bytes: crown }, { name: "notes.txt", bytes: Buffer.from("x") },
    ]);
    await notice(page, "b.toml: one job at a time; a.toml was opened");
    await notice(page, "notes.txt: not a job");
    await named(page, "a.toml");
    await good(page);
    await context.close();
  });

  it("a file that is too large is refused before it is read", async () => {
    const { page, context, complaints } = await open(browser, PAGE);
    await page.evaluate(() => {
      const file = new File(["x"], "huge.stl");
      Object.defineProperty(file, "size", { value: 3e9 });
      const event = new DragEvent("drop", { dataTransfer: new DataTransfer(), bubbles: true, cancelable: true });
      Object.defineProperty(event.dataTransfer, "types", { value: ["Files"] });
      Object.defineProperty(event.dataTransfer, "files", { value: [file] });
      document.body.dispatchEvent(event);
    });
    await notice(page, "huge.stl: 3000.0 MB is too large for a browser tab");
    assert.deepEqual(complaints, []);
    await context.close();
  });

  it("a file that cannot be read is told", async () => {
    const { page, context } = await open(browser, PAGE);
    await page.evaluate(() => {
      const file = new File(["x"], "folder.stl");
      file.arrayBuffer = () => Promise.reject(new DOMException("gone", "NotFoundError"));
      const event = new DragEvent("drop", { dataTransfer: new DataTransfer(), bubbles: true, cancelable: true });
      Object.defineProperty(event.dataTransfer, "types", { value: ["Files"] });
      Object.defineProperty(event.dataTransfer, "files", { value: [file] });
      document.body.dispatchEvent(event);
    });
    await notice(page, "folder.stl: it cannot be read; folders cannot be opened");
    await context.close();
  });

  it("text without a job is told when it is pasted", async () => {
    const { page, context } = await open(browser, PAGE);
    const paste = (text) => page.evaluate((pasted) => {
      const clipboardData = new DataTransfer();
      clipboardData.setData("text/plain", pasted);
      document.body.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
    }, text);
    await paste("a shopping list");
    await notice(page, "What was pasted is not a job");
    await paste(readFileSync("jobs/lens.toml", "utf8"));
    await named(page, "job.toml");
    await good(page);
    await context.close();
  });
});

describe("a window of any size", () => {
  for (const [width, height] of [[320, 480], [700, 400], [1024, 600]]) {
    it(`${width} x ${height}`, async () => {
      const { page, context } = await open(browser, `${PAGE}?example=${QUICK}`, { viewport: { width, height } });
      const fits = async (what) => assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width, what);
      await fits("job");
      await plan(page);
      for (const tab of ["flat", "scallop", "space", "report", "files"]) {
        await page.locator(`#tab-${tab}`).click();
        await fits(tab);
      }
      await context.close();
    });
  }
});
