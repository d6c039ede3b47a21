// Puts life into a page; without it every figure stands still and says the same.

function start() {
  document.querySelectorAll('table').forEach(sortable);
  const source = document.getElementById('robot');
  if (!source) return;
  const data = JSON.parse(source.textContent);
  const figure = source.closest('figure');
  if (!data.postures.length) return;
  const hint = tip(figure);
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
