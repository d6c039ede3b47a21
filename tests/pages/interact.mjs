// What a page does under a pointer and under keys.

/** Try everything that answers on a page. */
export async function interact(page, expect) {
  await tables(page, expect);
  await worded(page, expect);
  if (!(await page.evaluate("Boolean(document.querySelector('.controls'))"))) return;
  await postures(page, expect);
  await dots(page, expect);
  await correction(page, expect);
}

/** What the robot looks like now. */
const DRAWN = "[...document.querySelectorAll('.robot [data-c] path')].map((p) => p.getAttribute('d')).join()";

async function tables(page, expect) {
  const found = await page.evaluate(`(() => {
    const tables = [...document.querySelectorAll('table')].filter((t) => t.tBodies[0].rows.length > 1);
    return tables.flatMap((table) => {
      const heading = table.tHead.rows[0].cells[0];
      if (!heading.querySelector('button')) return ['a table has no buttons'];
      heading.querySelector('button').click();
      const first = heading.getAttribute('aria-sort');
      const up = [...table.tBodies[0].rows].map((row) => row.cells[0].textContent);
      heading.querySelector('button').click();
      const down = [...table.tBodies[0].rows].map((row) => row.cells[0].textContent);
      const second = heading.getAttribute('aria-sort');
      const faults = [];
      if (first !== 'ascending' || second !== 'descending') faults.push('aria-sort is ' + [first, second]);
      if (new Set(up).size > 1 && up.join() === down.join()) faults.push('a table does not sort');
      heading.querySelector('button').click();
      return faults;
    });
  })()`);
  found.forEach((what) => expect(false, what));
}

async function postures(page, expect) {
  const at = "document.querySelector('.controls input')";
  const said = "document.querySelector('.controls output').textContent";
  const [before, words] = [await page.evaluate(DRAWN), await page.evaluate(said)];
  expect(/^posture -?\d+ · row \d+( of \d+)?( · |$)/.test(words), `the slider says "${words}"`);
  await page.evaluate(`${at}.focus()`);
  const first = Number(await page.evaluate(`${at}.value`));
  const key = first > 0 ? ['ArrowLeft', 37] : ['ArrowRight', 39];
  await page.press(...key);
  expect(await page.evaluate(DRAWN) !== before, 'the slider over postures moves no robot');
  expect(await page.evaluate(said) !== words, 'the slider over postures says nothing new');
  const joints = await page.evaluate("document.querySelectorAll('.joints li').length");
  expect(joints > 0, 'no joint positions are listed');
}

/** Postures that the page has: of a large robot, some are left out. */
const POSED = "JSON.parse(document.getElementById('robot').textContent).postures";

async function dots(page, expect) {
  const count = await page.evaluate("[...document.querySelectorAll('svg')].filter((s) => s.querySelector(':scope [data-p] circle') && !s.closest('.tip')).length");
  if (!count) return;
  const mute = await page.evaluate("document.querySelectorAll('.health [data-v]').length");
  expect(mute === 0, `${mute} dots of findings show no posture`);
  for (let k = 0; k < count; k++) {
    const place = await page.evaluate(`(() => {
      const svg = [...document.querySelectorAll('svg')].filter((s) => s.querySelector(':scope [data-p] circle') && !s.closest('.tip'))[${k}];
      svg.scrollIntoView({ block: 'center' });
      const groups = [...svg.querySelectorAll('[data-p]')].filter((g) => g.querySelector('circle') && ${POSED}[g.dataset.p]);
      const group = groups[Math.floor(groups.length / 3)];
      const { x, y, width, height } = group.querySelector('circle').getBoundingClientRect();
      return [x + width / 2, y + height / 2, svg.getAttribute('aria-label')];
    })()`);
    await page.point(1, 1);
    await page.point(place[0], place[1]);
    const tip = await page.evaluate("(() => { const t = document.querySelector('.tip'); const b = t.getBoundingClientRect(); return [t.hidden, t.textContent, b.right <= innerWidth && b.left >= 0 && t.querySelectorAll('[data-c]').length > 0]; })()");
    expect(!tip[0] && /posture -?\d+ · row/.test(tip[1]), `no posture is named at a dot of "${place[2]}"`);
    expect(tip[2], 'the robot beside the pointer is not there or leaves the window');
    const rings = await page.evaluate("document.querySelectorAll('circle[r=\"7\"][fill=none]').length");
    expect(rings > 0, 'no dot is ringed');
  }
  const keys = await page.evaluate(`(() => {
    const svg = [...document.querySelectorAll('svg[tabindex]')].pop();
    svg.focus();
    const said = () => document.querySelector('.controls output').textContent;
    const press = (key) => svg.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    press('ArrowLeft');
    const before = said();
    press('ArrowRight');
    const after = said();
    press('Escape');
    return [before !== after, document.querySelector('.tip').hidden];
  })()`);
  expect(keys[0], 'arrow keys do not walk along dots');
  expect(keys[1], 'Escape hides no tip');
}

/** Figures with a dot that stands for no posture and has no words, beside keys and robots. */
const SILENT = `[...document.querySelectorAll('main svg')]
  .filter((svg) => !svg.closest('.sheet') && !svg.querySelector('[data-view]'))
  .filter((svg) => [...svg.querySelectorAll('circle')].some((disc) => !disc.closest('[data-p], [data-v]')
    && disc.getAttribute('fill') !== 'none' // a ring of the pointer's
    && disc.previousElementSibling?.tagName !== 'text'))
  .map((svg) => svg.getAttribute('aria-label'))`;

/** Dots that stand for no posture say what they are, without the robot. */
async function worded(page, expect) {
  for (const figure of await page.evaluate(SILENT)) expect(false, `a dot of "${figure}" says nothing`);
  const place = await page.evaluate(`(() => {
    const disc = document.querySelector('[data-v] circle');
    if (!disc) return null;
    disc.scrollIntoView({ block: 'center' });
    const { x, y, width, height } = disc.getBoundingClientRect();
    return [x + width / 2, y + height / 2, disc.parentNode.dataset.v];
  })()`);
  if (!place) return;
  await page.point(1, 1);
  await page.point(place[0], place[1]);
  const tip = await page.evaluate("(() => { const t = document.querySelector('.tip'); const svg = t.querySelector('svg'); return [t.hidden, t.textContent, Boolean(svg && svg.getBoundingClientRect().width)]; })()");
  expect(!tip[0] && tip[1].includes(place[2]) && !tip[2], `a dot is told as "${tip[1]}", not as "${place[2]}"`);
}

async function correction(page, expect) {
  const arrows = "[...document.querySelectorAll('[data-gain] path')].map((p) => p.getAttribute('d')).join()";
  if (!(await page.evaluate("Boolean(document.querySelector('[data-gain]'))"))) return;
  const said = "document.querySelectorAll('.controls output')[1].textContent";
  const gap = async () => Number(/gap ([\d.]+) mm/.exec(await page.evaluate(said))?.[1]);
  const chi2 = async () => Number(/χ² (\d+)/.exec(await page.evaluate(said))?.[1] ?? NaN);
  const pressed = "[...document.querySelectorAll('.switch button')].map((b) => b.getAttribute('aria-pressed')).join()";
  const [from, gap0, chi0] = [await page.evaluate(arrows), await gap(), await chi2()];
  expect(await page.evaluate(pressed) === 'true,false', 'CAD is not pressed at first');
  await page.evaluate("document.querySelectorAll('.controls input')[1].focus()");
  for (let k = 0; k < 5; k++) await page.press('PageUp', 33);
  const [gap1, chi1] = [await gap(), await chi2()];
  await page.press('End', 35);
  const [gap2, chi2_] = [await gap(), await chi2()];
  expect(await page.evaluate(arrows) !== from, 'arrows do not change under the correction');
  // Hundredths of a millimetre may be too coarse for half of the way.
  expect(gap0 > gap2 && gap0 >= gap1 && gap1 >= gap2, `the gap goes ${gap0}, ${gap1}, ${gap2} mm`);
  if (!Number.isNaN(chi0)) expect(chi0 > chi1 && chi1 > chi2_, `χ² goes ${chi0}, ${chi1}, ${chi2_}`);
  expect(await page.evaluate(pressed) === 'false,true', 'the end of the slider presses no button');
  await page.evaluate("document.querySelector('.switch button').click()");
  expect(await page.evaluate(arrows) === from, 'the switch does not lead back');
}
