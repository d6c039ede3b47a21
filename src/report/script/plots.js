// Dots of figures that stand for a posture: pointing at one shows the robot in it, and marks
// the same posture in every figure. Dots that stand for no posture say what they are.

/** A small robot beside the pointer, with what is said of the posture. */
function tip(figure) {
  const svg = figure && figure.querySelector('svg');
  const text = element('p');
  const box = element('div', { class: 'tip', role: 'status', hidden: '' }, text);
  if (svg) {
    const small = svg.cloneNode(true);
    small.removeAttribute('aria-label');
    small.setAttribute('aria-hidden', 'true');
    small.querySelectorAll('style').forEach((style) => style.remove());
    box.prepend(small);
  }
  document.body.append(box);
  return {
    box,
    /** With the robot, or with words alone. */
    show(parts, x, y, alone = false) {
      box.classList.toggle('alone', alone);
      text.textContent = parts.join(' · ');
      box.hidden = false;
      const { width, height } = box.getBoundingClientRect();
      const wide = document.documentElement.clientWidth;
      box.style.left = `${Math.max(8, Math.min(x + 16, wide - width - 8))}px`;
      box.style.top = `${y + 16 + height > innerHeight ? Math.max(8, y - height - 16) : y + 16}px`;
    },
    hide() { box.hidden = true; },
  };
}

/** Places of the dots of a figure, in its own units. */
function dots(svg) {
  const found = [];
  for (const group of svg.querySelectorAll('[data-p], [data-v]')) {
    for (const disc of group.querySelectorAll('circle')) {
      found.push({
        k: 'p' in group.dataset ? Number(group.dataset.p) : -1,
        words: group.dataset.v,
        x: Number(disc.getAttribute('cx')),
        y: Number(disc.getAttribute('cy')),
      });
    }
  }
  return found;
}

/** The dot nearest to a place, if it is near. */
function nearest(all, x, y, within) {
  let best = null, least = within * within;
  for (const dot of all) {
    const away = (dot.x - x) ** 2 + (dot.y - y) ** 2;
    if (away < least) [best, least] = [dot, away];
  }
  return best;
}

/** Make the figures of the page point at postures; `show` poses the robot. */
function plots(data, tip, show) {
  const figures = [...document.querySelectorAll('svg')]
    .filter((svg) => svg.querySelector('[data-p], [data-v]'))
    .map((svg) => ({ svg, all: dots(svg), rings: [] }));
  const mark = (k) => {
    for (const figure of figures) {
      figure.rings.forEach((ring) => ring.remove());
      const own = figure.all.filter((dot) => dot.k === k);
      figure.rings = own.map((dot) => {
        const ring = document.createElementNS(figure.svg.namespaceURI, 'circle');
        const attributes = { class: 'ink', cx: dot.x, cy: dot.y, r: 7, fill: 'none', stroke: 'currentColor', 'stroke-width': 2 };
        for (const [key, value] of Object.entries(attributes)) ring.setAttribute(key, value);
        figure.svg.append(ring);
        return ring;
      });
    }
  };
  let shown = data.shown;
  const select = (k) => {
    shown = k;
    show(k);
  };
  for (const { svg, all } of figures) {
    const point = (event) => {
      const matrix = svg.getScreenCTM().inverse();
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
      const dot = nearest(all, at.x, at.y, 14);
      if (!dot) return tip.hide();
      if (dot.k < 0 || !data.postures[dot.k]) {
        return dot.words ? tip.show([dot.words], event.clientX, event.clientY, true) : tip.hide();
      }
      select(dot.k);
      tip.show(said(data, dot.k), event.clientX, event.clientY);
    };
    svg.addEventListener('pointermove', point);
    svg.addEventListener('pointerdown', point);
    svg.addEventListener('pointerleave', () => tip.hide());
    // Keys walk from posture to posture.
    if (!all.some((dot) => data.postures[dot.k])) continue;
    svg.setAttribute('tabindex', '0');
    svg.setAttribute('role', 'group');
    svg.addEventListener('blur', () => tip.hide());
    const beside = () => {
      const own = all.find((dot) => dot.k === shown);
      if (!own) return;
      const at = new DOMPoint(own.x, own.y).matrixTransform(svg.getScreenCTM());
      tip.show(said(data, shown), at.x, at.y);
    };
    svg.addEventListener('focus', () => { if (svg.matches(':focus-visible')) beside(); });
    svg.addEventListener('keydown', (event) => {
      const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
      if (event.key === 'Escape') tip.hide();
      if (!step) return;
      event.preventDefault();
      const own = [...new Set(all.map((dot) => dot.k))].filter((k) => k >= 0).sort((a, b) => a - b)
        .filter((k) => data.postures[k]);
      if (!own.length) return;
      if (!own.includes(shown)) shown = step > 0 ? own[0] - 1 : own[own.length - 1] + 1;
      const next = step > 0 ? own.find((k) => k > shown) : own.reverse().find((k) => k < shown);
      select(next === undefined ? shown : next);
      beside();
    });
  }
  for (const item of document.querySelectorAll('li[data-p]')) {
    const k = Number(item.dataset.p);
    if (!data.postures[k]) continue;
    item.setAttribute('tabindex', '0');
    item.addEventListener('click', () => select(k));
    item.addEventListener('focus', () => select(k));
  }
  return mark;
}
