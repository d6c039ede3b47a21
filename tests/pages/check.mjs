// Pages of sesc in a browser: nothing on the console, nothing from the network, pointers and
// sliders answer, phones and paper show everything, texts stand out by day and by night.
//
//     node tests/pages/check.mjs FOLDER PICTURES [--shots]
//
// PICTURES is the folder of the pictures of the documentation: they are compared with the pages
// (shots.mjs says how), or taken with --shots.
//
// Exits with 1 if something does not hold, with 3 where no Chromium is installed.

import { readdirSync } from 'node:fs';
import { resolve } from 'node:path';
import { launch } from './browser.mjs';
import { beyond, figures, hinted, pale, scripted, tiny } from './looks.mjs';
import { interact } from './interact.mjs';
import { Shots } from './shots.mjs';

/** Script and data of a page stay below so many bytes, of a robot of hundreds of joints, too. */
const INLINE = 150_000;

const [folder, pictures, write] = process.argv.slice(2);
const files = readdirSync(folder, { recursive: true }).filter((file) => file.endsWith('.html')).sort();
const shots = new Shots(pictures, write === '--shots');
const browser = await launch();
if (!browser) {
  console.error('no Chromium is installed');
  process.exit(3);
}

let faults = 0;
for (const file of files) {
  const found = await check(file);
  faults += found.length;
  console.log(`${found.length ? 'FAILS' : 'ok   '} ${file}`);
  found.forEach((what) => console.log(`      ${what}`));
}
await browser.close();
for (const file of shots.finish()) {
  faults++;
  console.log(`FAILS docs/pages/${file} is of no page`);
}
process.exit(faults || !files.length ? 1 : 0);

/** Everything that does not hold for a page. */
async function check(file) {
  const faults = [];
  const expect = (holds, what) => { if (!holds) faults.push(what); };
  const url = `file://${resolve(folder, file)}`;
  const page = await browser.page();
  await page.media('screen', 'light');
  await page.size(1100, 900);
  await page.open(url);
  const count = (await page.ask(figures)).length;
  expect(count > 0 || file.startsWith('fleet'), 'has no figure');
  const inline = await page.ask(scripted);
  expect(inline < INLINE, `its script and data are ${inline} bytes`);

  await interact(page, expect);

  for (const scheme of ['light', 'dark']) {
    await page.media('screen', scheme);
    const height = await page.evaluate('document.documentElement.scrollHeight');
    await page.size(1100, Math.min(height, 16000));
    for (const what of await page.ask(pale)) expect(false, `contrast by ${scheme}: ${what}`);
  }
  await page.media('screen', 'light');
  for (const width of [360, 768]) {
    await page.size(width, 800);
    for (const what of await page.ask(beyond, width)) expect(false, `at ${width} px: ${what}`);
  }

  await page.size(390, 844);
  await page.open(url);
  for (const what of await page.ask(tiny, 11)) expect(false, `at 390 px: ${what}`);
  for (const what of await page.ask(hinted)) expect(false, `at 390 px: ${what}`);

  await page.size(1100, 900);
  await page.media('print', 'light');
  const printed = await page.ask(figures);
  expect(printed.length === count && printed.every((width) => width > 0),
    `on paper ${printed.filter((width) => width > 0).length} of ${count} figures`);
  await page.size(718, 900);
  for (const what of await page.ask(beyond, 718)) expect(false, `on paper: ${what}`);
  expect(await page.evaluate("![...document.querySelectorAll('.controls, .tip')].some((e) => e.offsetWidth)"),
    'sliders are printed');
  const { data } = await page.tell('Page.printToPDF', {});
  expect(data.length > 10000, 'prints nothing');

  await page.media('screen', 'light');
  await shots.of(page, file, url, expect);
  expect(page.complaints.length === 0, `console: ${page.complaints.join('; ')}`);
  const others = page.requests.filter((asked) => asked !== url);
  expect(others.length === 0, `asks for ${others}`);

  await page.tell('Emulation.setScriptExecutionDisabled', { value: true });
  await page.open(url);
  const still = await page.ask(figures);
  expect(still.length === count && still.every((width) => width > 0), 'without script figures are missing');
  await page.close();
  return faults;
}
