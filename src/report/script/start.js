// Puts life into a page; without it every figure stands still and says the same.

/** What reaches beyond its box says that it scrolls. */
function hints() {
  for (const box of document.querySelectorAll('.scroll, figure, .xml')) {
    box.classList.toggle('more', box.scrollWidth > box.clientWidth + 1);
  }
}

function start() {
  hints();
  window.addEventListener('resize', hints);
  document.querySelectorAll('table').forEach(sortable);
  const source = document.getElementById('robot');
  const data = source ? JSON.parse(source.textContent) : { postures: [] };
  const figure = source && source.closest('figure');
  const hint = tip(figure);
  if (!data.postures.length) return plots(data, hint, () => {});
  const groups = [...document.querySelectorAll('[data-view]')];
  const pictures = groups.map((group) => picture(group, data));
  const marks = [];
  const show = (k) => {
    const frames = place(data.bodies, data.postures[k].q);
    pictures.forEach((draw) => draw(frames));
    marks.forEach((mark) => mark(k));
  };
  const panel = element('div', { class: 'controls' });
  figure.querySelector('figcaption').before(panel);
  marks.push(postures(data, panel, show));
  const arrows = [...document.querySelectorAll('[data-gain]')].map((group) => gaps(group, data));
  if (arrows.length) correction(data, panel, (s) => arrows.forEach((draw) => draw(s)));
  marks.push(plots(data, hint, show));
  show(data.shown);
}

if (typeof document !== 'undefined') start();
