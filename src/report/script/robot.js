// The robot of the page in a posture, and its gaps under a part of the correction.

/** An element with attributes and children. */
function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function numbers(text) {
  return text.trim().split(/\s+/).map(Number);
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** A picture of the robot: a group that says from where it is seen. */
function camera(group) {
  const n = numbers(group.dataset.view);
  const [right, up, near] = [n.slice(0, 3), n.slice(3, 6), n.slice(6, 9)];
  const [scale, x, y] = n.slice(9);
  return {
    at: (p) => [x + scale * dot(p, right), y - scale * dot(p, up)],
    depth: (p) => dot(p, near),
  };
}

/** Everything of a group that moves with the robot. */
function picture(group, data) {
  const view = camera(group);
  const capsules = [...group.querySelectorAll('[data-c]')];
  const joints = [...group.querySelectorAll('[data-j]')];
  const com = group.querySelector('[data-com]');
  const drop = group.querySelector('[data-drop] path');
  const names = [...group.parentNode.querySelectorAll('[data-n]')];
  const arrows = [...group.parentNode.querySelectorAll('[data-a]')].map((mark) => {
    mark.querySelectorAll('polygon').forEach((head) => head.remove());
    mark.firstElementChild.setAttribute('fill', 'currentColor');
    return [mark.firstElementChild, numbers(mark.dataset.a)];
  });
  const still = place(data.bodies, data.postures[data.shown].q);
  const moved = (mark, from, to) =>
    mark.setAttribute('transform', `translate(${(to[0] - from[0]).toFixed(1)} ${(to[1] - from[1]).toFixed(1)})`);
  const line = ([a, b], [c, d]) => `M${a.toFixed(1)} ${b.toFixed(1)}L${c.toFixed(1)} ${d.toFixed(1)}`;
  return (frames) => {
    const order = capsules.map((mark) => {
      const [body, a, b] = data.capsules[Number(mark.dataset.c)];
      const [p, q] = [seen(frames[body], a), seen(frames[body], b)];
      const d = line(view.at(p), view.at(q));
      for (const path of mark.children) path.setAttribute('d', d);
      return [view.depth(p) + view.depth(q), mark];
    });
    order.sort((a, b) => a[0] - b[0]);
    const before = joints[0] || null;
    for (const [, mark] of order) group.insertBefore(mark, before);
    for (const mark of joints) {
      const [x, y] = view.at(frames[Number(mark.dataset.j)].origin);
      for (const disc of mark.querySelectorAll('circle')) {
        disc.setAttribute('cx', x.toFixed(1));
        disc.setAttribute('cy', y.toFixed(1));
      }
    }
    for (const mark of names) {
      const [body, ...point] = numbers(mark.dataset.n);
      moved(mark, view.at(seen(still[body], point)), view.at(seen(frames[body], point)));
    }
    for (const [path, [body, ...ends]] of arrows) {
      const [tail, tip] = [ends.slice(0, 3), ends.slice(3)].map((p) => view.at(seen(frames[body], p)));
      path.setAttribute('d', arrow(tail, tip));
    }
    const at = centre(data.bodies, frames);
    moved(com, view.at(centre(data.bodies, still)), view.at(at));
    drop.setAttribute('d', line(view.at(at), view.at([at[0], at[1], 0])));
  };
}

/** Arrows from the predicted to the measured CoP, under part s of the correction. */
function gaps(group, data) {
  const gain = Number(group.dataset.gain);
  const [left, top, right, bottom, x0, x1, y0, y1] = numbers(group.dataset.plane);
  const at = ([x, y]) => [
    left + (1e3 * x - x0) / (x1 - x0) * (right - left),
    bottom - (1e3 * y - y0) / (y1 - y0) * (bottom - top),
  ];
  const marks = [...group.querySelectorAll('[data-p]')];
  const known = marks.filter((mark) => data.postures[Number(mark.dataset.p)]);
  marks.filter((mark) => !known.includes(mark)).forEach((mark) => mark.remove());
  const arrows = known.map((mark) => {
    mark.querySelectorAll('polygon').forEach((head) => head.remove());
    const path = mark.querySelector('path');
    path.setAttribute('fill', 'currentColor');
    return [path, data.postures[Number(mark.dataset.p)]];
  });
  return (s) => {
    for (const [path, posture] of arrows) {
      const { measured, predicted } = posture;
      const tail = at([0, 1].map((i) => {
        const from = predicted[0][i] + s * (predicted[1][i] - predicted[0][i]);
        return measured[i] + gain * (from - measured[i]);
      }));
      path.setAttribute('d', arrow(tail, at(measured)));
    }
  };
}

/** A line, with a head where it is long enough for one. */
function arrow(tail, tip) {
  const by = [tip[0] - tail[0], tip[1] - tail[1]];
  const length = Math.hypot(by[0], by[1]);
  const place = ([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`;
  let d = `M${place(tail)}L${place(tip)}`;
  if (length >= 8.8) {
    const [x, y] = [by[0] / length, by[1] / length];
    const corner = (way) => [tip[0] - 5.5 * x - way * 2.2 * y, tip[1] - 5.5 * y + way * 2.2 * x];
    d += `M${place(tip)}L${place(corner(1))}L${place(corner(-1))}Z`;
  }
  return d;
}

function millimetres(value) {
  return (1e3 * value).toFixed(2).replace('-', '−');
}

/** What is said of a posture, in parts. */
function said(data, k) {
  const posture = data.postures[k];
  const place = (p) => `x ${millimetres(p[0])}, y ${millimetres(p[1])} mm`;
  const row = posture.row || `row ${k + 1} of ${data.slider}`;
  const parts = [`posture ${posture.pose}`, row];
  if (posture.measured) parts.push(`read ${place(posture.measured)}`);
  if (posture.predicted) {
    parts.push(`${data.names[0]} ${place(posture.predicted[0])}`);
    parts.push(`${data.names[1]} ${place(posture.predicted[1])}`);
  }
  if (posture.planned) parts.push(`CoP expected at ${place(posture.planned)}`);
  if (posture.said) parts.push(...posture.said);
  return parts;
}

/** Positions of all joints, as people read them. */
function positions(data, k) {
  return data.joints.map(([name, prismatic], j) => {
    const q = data.postures[k].q[j];
    const value = prismatic ? `${(1e3 * q).toFixed(1)} mm` : `${(q * 180 / Math.PI).toFixed(1)}°`;
    return [name, value.replace('-', '−')];
  });
}
