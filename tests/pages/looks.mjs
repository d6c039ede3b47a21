// What holds for the looks of a page: functions that run in the page.

/** Elements that reach beyond the right edge, but for those that scroll by themselves. */
export function beyond(width) {
  const scrolls = (element) => {
    for (let at = element; at; at = at.parentElement) {
      if (['auto', 'scroll', 'hidden'].includes(getComputedStyle(at).overflowX) && at !== document.body && at !== document.documentElement) return true;
    }
    return false;
  };
  const found = [];
  if (document.scrollingElement.scrollWidth > width) found.push(`page is ${document.scrollingElement.scrollWidth} px wide`);
  for (const element of document.body.querySelectorAll('*')) {
    if (element.closest('svg') && element.tagName !== 'svg') continue;
    const { right, width: own } = element.getBoundingClientRect();
    if (own > 0 && right > width + 0.5 && !scrolls(element)) {
      found.push(`${element.tagName}.${element.className?.baseVal ?? element.className} ends at ${right.toFixed(0)}: ${element.textContent.trim().slice(0, 40)}`);
    }
  }
  return found.slice(0, 8);
}

/** Texts whose contrast with what is under them is below AA. */
export function pale() {
  const parse = (text) => {
    const n = text.match(/[\d.]+/g)?.map(Number) ?? [0, 0, 0, 0];
    return [n[0], n[1], n[2], n[3] ?? 1];
  };
  const over = (top, below) => [0, 1, 2].map((i) => top[3] * top[i] + (1 - top[3]) * below[i]).concat(1);
  const light = (c) => {
    const [r, g, b] = c.slice(0, 3).map((x) => {
      const v = x / 255;
      return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (element) => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) {
      const color = parse(getComputedStyle(at).backgroundColor);
      if (color[3] > 0) layers.push(color);
      if (color[3] === 1) break;
    }
    return layers.reverse().reduce((below, top) => over(top, below), [255, 255, 255, 1]);
  };
  const under = (text, box) => {
    const stack = document.elementsFromPoint(box.x + box.width / 2, box.y + box.height / 2);
    const own = stack.filter((e) => e.ownerSVGElement === text.ownerSVGElement && e !== text && ['rect', 'circle', 'polygon'].includes(e.tagName));
    let color = ground(text.ownerSVGElement);
    for (const shape of own.reverse()) {
      const style = getComputedStyle(shape);
      if (style.fill === 'none') continue;
      const fill = parse(style.fill);
      color = over([fill[0], fill[1], fill[2], fill[3] * Number(style.fillOpacity)], color);
    }
    return color;
  };
  const found = new Map();
  for (const element of document.body.querySelectorAll('*')) {
    const svg = element.tagName === 'text';
    const words = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    if (!words || (!svg && element.closest('svg')) || ['SCRIPT', 'STYLE'].includes(element.tagName)) continue;
    const box = element.getBoundingClientRect();
    const style = getComputedStyle(element);
    if (!box.width || style.visibility === 'hidden' || element.closest('[aria-hidden]')) continue;
    const below = svg ? under(element, box) : ground(element);
    const [a, b] = [light(over(parse(svg ? style.fill : style.color), below)), light(below)].sort((x, y) => y - x);
    const ratio = (a + 0.05) / (b + 0.05);
    const size = parseFloat(style.fontSize), bold = Number(style.fontWeight) >= 700;
    const least = size >= 24 || (bold && size >= 18.66) ? 3 : 4.5;
    if (ratio < least - 0.005) {
      const what = `${ratio.toFixed(2)}: ${style.color} on ${below.slice(0, 3).map(Math.round)}`;
      if (!found.has(what)) found.set(what, element.textContent.trim().slice(0, 30));
    }
  }
  return [...found].map(([what, text]) => `${what} (${text})`).slice(0, 8);
}

/** Figures that a reader sees, by how wide they are drawn; the pointer's own apart. */
export function figures() {
  const all = [...document.querySelectorAll('svg')].filter((svg) => !svg.closest('.tip'));
  return all.map((svg) => Math.round(svg.getBoundingClientRect().width));
}

/** Bytes of the script of a page, with the data that it reads. */
export function scripted() {
  const scripts = [...document.querySelectorAll('script')];
  return scripts.reduce((sum, script) => sum + new Blob([script.textContent]).size, 0);
}

/** Texts that are shown smaller than so many pixels. */
export function tiny(least) {
  const found = new Set();
  for (const element of document.body.querySelectorAll('*')) {
    const words = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    const svg = element.ownerSVGElement;
    const told = ['SCRIPT', 'STYLE', 'style', 'title'].includes(element.tagName);
    if (!words || told || !element.getClientRects().length) continue;
    const scale = svg ? svg.getScreenCTM().a : 1;
    const size = scale * parseFloat(getComputedStyle(element).fontSize);
    if (size < least - 0.05) found.add(`${size.toFixed(1)} px: ${element.textContent.trim().slice(0, 30)}`);
  }
  return [...found].slice(0, 8);
}

/** Boxes that scroll sideways and do not say so, and tables that scroll with the page. */
export function hinted() {
  const found = [];
  for (const box of document.querySelectorAll('figure, .scroll, .xml')) {
    const hint = getComputedStyle(box, '::after').content.includes('scroll sideways');
    const scrolls = box.scrollWidth > box.clientWidth + 1;
    if (scrolls !== hint) found.push(`${box.className || box.tagName} of ${box.scrollWidth} px in ${box.clientWidth} px, hint ${hint}`);
  }
  for (const table of document.querySelectorAll('table')) if (!table.closest('.scroll')) found.push('a table in no box that scrolls');
  for (const head of document.querySelectorAll('thead tr')) {
    const heights = [...head.cells].map((cell) => cell.getBoundingClientRect().height);
    if (Math.max(...heights) > 44) found.push(`a heading ${Math.max(...heights).toFixed(0)} px high: ${head.textContent.trim().slice(0, 30)}`);
  }
  return found.slice(0, 8);
}
