// Where bodies are in a posture, as sesc_identify::skeleton has it:
//   T_i = T_parent(i) · (anchor_i + axis θ, R_i Rot(axis, θ))        θ = factor q + offset
// Rotations are nine numbers, row by row; lengths are metres. What a body does not say is usual.
const USUAL = {
  kind: 0, joint: 0, factor: 1, offset: 0, mass: 0,
  rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], anchor: [0, 0, 0], axis: [0, 0, 0], com: [0, 0, 0],
};

/** The product of two rotations. */
function times(a, b) {
  const out = [];
  for (let i = 0; i < 3; i++) {
    for (let j = 0; j < 3; j++) {
      out.push(a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j]);
    }
  }
  return out;
}

/** A point of a frame, seen from where the frame is. */
function seen(frame, p) {
  const r = frame.rotation;
  return [0, 1, 2].map(
    (i) => frame.origin[i] + r[3 * i] * p[0] + r[3 * i + 1] * p[1] + r[3 * i + 2] * p[2]
  );
}

/** Rotation by an angle about an axis of length one. */
function about([x, y, z], angle) {
  const c = Math.cos(angle), s = Math.sin(angle), d = 1 - c;
  return [
    c + x * x * d, x * y * d - z * s, x * z * d + y * s,
    y * x * d + z * s, c + y * y * d, y * z * d - x * s,
    z * x * d - y * s, z * y * d + x * s, c + z * z * d,
  ];
}

/** Frames of all bodies in posture q; parents stand before their children. */
function place(bodies, q) {
  const frames = [];
  for (const said of bodies) {
    const body = { ...USUAL, ...said };
    const theta = body.factor * (q[body.joint] || 0) + body.offset;
    let own = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], origin: [0, 0, 0] };
    if (body.kind === 1) {
      own = { rotation: times(body.rotation, about(body.axis, theta)), origin: body.anchor };
    } else if (body.kind === 2) {
      own = { rotation: body.rotation, origin: body.anchor.map((x, i) => x + body.axis[i] * theta) };
    }
    const parent = frames[body.parent];
    frames.push(parent
      ? { rotation: times(parent.rotation, own.rotation), origin: seen(parent, own.origin) }
      : own);
  }
  return frames;
}

/** Centre of mass of the robot. */
function centre(bodies, frames) {
  const sum = [0, 0, 0];
  let mass = 0;
  bodies.forEach((said, k) => {
    const body = { ...USUAL, ...said };
    const at = seen(frames[k], body.com);
    for (let i = 0; i < 3; i++) sum[i] += body.mass * at[i];
    mass += body.mass;
  });
  return mass > 0 ? sum.map((x) => x / mass) : sum;
}

if (typeof module !== 'undefined') module.exports = { place, centre, seen };
