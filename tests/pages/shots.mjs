// Pictures of pages for the documentation, and whether they still show these pages.
//
// docs/pages/shots.json has, for each picture, a hash of the page that it was taken of: elements,
// classes, words and styles. Numbers and places are left out of it, since their last digits differ
// from machine to machine, and so do pixels with fonts. So a picture is called stale when the page
// has other parts, words or colours, and not when the same page shows other numbers.

import { createHash } from 'node:crypto';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

const LIST = 'shots.json';

/** The name of a page's picture; none of pages that have none. */
export function pictureOf(page) {
  const name = page.replace(/\.html$/, '');
  if (name.includes('_')) return null;
  const [folder, robot] = name.split('/');
  // One robot stands for the others.
  return !robot ? `${name}.png` : robot === 'r1' ? `${folder}-robot.png` : null;
}

/** What a page consists of, as text; runs in the page. */
function structure() {
  const plain = (text) => text.replace(/[0-9a-f]{16}/g, '#').replace(/[−+-]?\d[\d.,]*(e[−+-]?\d+)?/g, '#').replace(/\s+/g, ' ').trim();
  const parts = [];
  const walk = (element) => {
    if (element.tagName === 'SCRIPT') return;
    const classes = (element.getAttribute('class') ?? '').trim();
    const words = [...element.childNodes].filter((node) => node.nodeType === 3).map((node) => plain(node.data)).filter(Boolean);
    const label = plain(element.getAttribute('aria-label') ?? '');
    const part = [element.tagName.toLowerCase(), classes, label, ...words].join('|');
    // How many dots or ticks there are is a number, too.
    if (parts[parts.length - 1] !== part) parts.push(part);
    [...element.children].forEach(walk);
  };
  walk(document.documentElement);
  return parts.join('\n');
}

/** Pictures that are committed, and the hashes of their pages. */
export class Shots {
  constructor(folder, write) {
    this.folder = folder;
    this.write = write;
    const list = join(folder, LIST);
    this.known = existsSync(list) ? JSON.parse(readFileSync(list, 'utf8')) : {};
    this.found = {};
  }

  /** Take the pictures of a page, or say that they are stale. */
  async of(page, name, url, expect) {
    const file = pictureOf(name);
    if (!file) return;
    await page.size(1100, 900, 1);
    await page.open(url);
    const text = await page.ask(structure);
    const hash = createHash('sha256').update(text).digest('hex');
    const others = name === 'diagnose.html' ? ['diagnose-dark.png'] : [];
    for (const own of [file, ...others]) {
      this.found[own] = hash;
      if (this.write) continue;
      const stands = existsSync(join(this.folder, own)) && this.known[own] === hash;
      expect(stands, `docs/pages/${own} is of another page: tests/pages/run --shots takes it again`);
    }
    if (!this.write) return;
    await this.shot(page, file);
    for (const own of others) {
      await page.media('screen', 'dark');
      await page.open(url);
      await this.shot(page, own);
      await page.media('screen', 'light');
    }
  }

  /** The top of the page that is open. */
  async shot(page, file) {
    const height = await page.evaluate('Math.min(1240, document.documentElement.scrollHeight)');
    const clip = { x: 0, y: 0, width: 1100, height, scale: 0.68 };
    writeFileSync(join(this.folder, file), await page.picture(clip));
  }

  /** Keep the hashes of the pictures that were taken; pictures of no page. */
  finish() {
    if (!this.write) return Object.keys(this.known).filter((file) => !(file in this.found));
    const sorted = Object.fromEntries(Object.entries(this.found).sort());
    writeFileSync(join(this.folder, LIST), `${JSON.stringify(sorted, null, 2)}\n`);
    return [];
  }
}
