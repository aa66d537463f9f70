import { launch, open, plan } from "/work/wt/page/web/tests/browser.mjs";
const b = await launch();
const url = "http://127.0.0.1:8099/";
const t0=Date.now();
const { page, complaints } = await open(b, url + "?example=" + (process.argv[2] ?? "mould"));
console.log("ready", Date.now()-t0);
await page.screenshot({ path: "/tmp/s-start.png" });
const t1=Date.now();
await plan(page);
console.log("planned", Date.now()-t1);
await page.waitForTimeout(500);
await page.screenshot({ path: "/tmp/s-flat.png" });
for (const id of ["surface","scallop","removal","space","report","files"]) {
  await page.locator("#tab-"+id).click();
  await page.waitForTimeout(id==="space"?3000:300);
  await page.screenshot({ path: `/tmp/s-${id}.png` });
}
await page.locator("#theme").click();
await page.locator("#tab-flat").click();
await page.waitForTimeout(300);
await page.screenshot({ path: "/tmp/s-dark.png" });
console.log(complaints);
await b.close();
