// Sliders under the robot: one over the postures, one from the model as it was to the model as
// it was found.

/** A slider with its name and what it says. */
function slider(name, attributes) {
  const input = element('input', { type: 'range', 'aria-label': name, ...attributes });
  const output = element('output');
  const row = element('div', { class: 'control' }, element('span', {}, name), input, output);
  return { row, input, output };
}

/** Postures: gives back what shows one. */
function postures(data, figure, show) {
  // Postures that the page left out have no place on it.
  const kept = [...Array(data.slider).keys()].filter((k) => data.postures[k]);
  const { row, input, output } = slider('Posture', { min: 0, max: kept.length - 1, step: 1 });
  const list = element('ul', { class: 'joints' });
  const details = element('details', {}, element('summary', {}, 'Joints of this posture'), list);
  input.addEventListener('input', () => show(kept[Number(input.value)]));
  figure.append(row, details);
  return (k) => {
    if (k < data.slider) input.value = kept.indexOf(k);
    const text = said(data, k).join(' · ');
    output.textContent = text;
    input.setAttribute('aria-valuetext', text);
    list.replaceChildren(...positions(data, k).map(([joint, value]) =>
      element('li', {}, element('code', {}, joint), ` ${value}`)));
  };
}

/** Part s of the correction: a slider, and a button for each of its ends. */
function correction(data, figure, apply) {
  const { row, input, output } = slider('Correction', { min: 0, max: 100, step: 1, value: 0 });
  const ends = data.names.map((name, k) => {
    const button = element('button', { type: 'button', 'aria-pressed': k === 0 }, name);
    button.addEventListener('click', () => set(k));
    return button;
  });
  input.before(element('span', { class: 'switch' }, ...ends));
  const bar = element('i');
  const meter = element('div', { class: 'meter', 'aria-hidden': 'true' }, bar);
  const set = (s) => {
    input.value = Math.round(100 * s);
    ends.forEach((button, k) => button.setAttribute('aria-pressed', s === k));
    const parts = data.found.map(([name, value, unit]) => {
      const number = (x) => `${significant(x)}${unit === '°' ? '' : ' '}${unit}`.replace('-', '−');
      return `${name} ${number(s * value)} of ${number(value)}`;
    });
    let share = gap(data, s) / gap(data, 0);
    if (data.chi2) {
      const [a, b, c, expected] = data.chi2;
      const chi2 = a + b * s + c * s * s;
      share = chi2 / a;
      parts.push(`χ² ${chi2.toFixed(0)}, where noise leaves ${expected.toFixed(0)}`);
    }
    parts.push(`gap ${millimetres(gap(data, s))} mm RMS per axis`);
    output.textContent = parts.join(' · ');
    input.setAttribute('aria-valuetext', output.textContent);
    bar.style.width = `${Math.min(100, 100 * share).toFixed(1)}%`;
    apply(s);
  };
  input.addEventListener('input', () => set(Number(input.value) / 100));
  figure.append(row, meter);
  set(0);
}

function significant(value) {
  const size = Math.abs(value);
  return size >= 100 ? value.toFixed(0) : size >= 10 ? value.toFixed(1) : value.toFixed(2);
}

/** RMS gap per axis under part s of the correction, m. */
function gap(data, s) {
  let sum = 0, count = 0;
  for (const { measured, predicted, outlier } of data.postures.filter((own) => own)) {
    if (measured && predicted && !outlier) {
      for (const i of [0, 1]) {
        sum += (predicted[0][i] + s * (predicted[1][i] - predicted[0][i]) - measured[i]) ** 2;
      }
      count += 2;
    }
  }
  return Math.sqrt(sum / Math.max(1, count));
}
