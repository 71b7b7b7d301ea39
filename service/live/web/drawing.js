// Pictures and tables of the live page: the map of the plan, how the swarms converge, the robot as
// known so far. Marks differ in shape, not only in colour.
'use strict';
const drawing = (() => {
  const kName = 'http://www.w3.org/2000/svg';

  function node(parent, name, attributes, text) {
    const made = document.createElementNS(kName, name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    if (text !== undefined) made.textContent = text;
    parent.appendChild(made);
    return made;
  }

  function mark(parent, kind, x, y, title) {
    const group = node(parent, 'g', { 'data-mark': kind });
    if (kind === 'open') node(group, 'circle', { class: 'open', cx: x, cy: y, r: 4 });
    if (kind === 'done') node(group, 'circle', { class: 'done', cx: x, cy: y, r: 5 });
    if (kind === 'suspect') node(group, 'path', { class: 'suspect', d: `M${x} ${y - 8}l8 14h-16z` });
    if (kind === 'left') node(group, 'path', { class: 'left', d: `M${x - 4} ${y - 4}l8 8m0 -8l-8 8` });
    if (kind === 'next') {
      node(group, 'circle', { class: 'next', cx: x, cy: y, r: 11 });
      node(group, 'path', { class: 'next', d: `M${x - 17} ${y}h8m18 0h8M${x} ${y - 17}v8m0 18v8` });
    }
    if (title) node(group, 'title', {}, title);
    return group;
  }

  // Steps of 1, 2 or 5 that give about five lines.
  function ticks(low, high) {
    const raw = (high - low) / 5 || 1;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= raw);
    const all = [];
    for (let at = Math.ceil(low / step) * step; at <= high + 1e-9; at += step) all.push(+at.toFixed(9));
    return all;
  }

  /// points: [{x, y, state, name, why}], next: {x, y} or null, tool: {x, y} or null. W frame, mm.
  function map(svg, points, next) {
    svg.replaceChildren();
    const xs = points.map((p) => p.x), ys = points.map((p) => p.y);
    const wide = 480, room = 46;
    if (points.length === 0) {
      svg.setAttribute('viewBox', `0 0 ${wide} 120`);
      node(svg, 'text', { x: wide / 2, y: 60, 'text-anchor': 'middle' }, 'No plan yet: its points come here.');
      return;
    }
    const x0 = Math.min(...xs) - 2, x1 = Math.max(...xs) + 2, y0 = Math.min(...ys) - 2, y1 = Math.max(...ys) + 2;
    const scale = Math.min((wide - room - 14) / (x1 - x0), 430 / (y1 - y0));
    const left = room + (wide - room - 14 - scale * (x1 - x0)) / 2;
    const high = scale * (y1 - y0);
    const px = (x) => left + (x - x0) * scale, py = (y) => 12 + (y1 - y) * scale;
    svg.setAttribute('viewBox', `0 0 ${wide} ${high + 56}`);
    node(svg, 'rect', { class: 'axis', x: px(x0), y: py(y1), width: scale * (x1 - x0), height: high });
    for (const x of ticks(x0, x1)) {
      node(svg, 'path', { class: 'axis', d: `M${px(x)} ${py(y0)}v5` });
      node(svg, 'text', { x: px(x), y: py(y0) + 19, 'text-anchor': 'middle' }, x);
    }
    for (const y of ticks(y0, y1)) {
      node(svg, 'path', { class: 'axis', d: `M${px(x0)} ${py(y)}h-5` });
      node(svg, 'text', { x: px(x0) - 9, y: py(y) + 4, 'text-anchor': 'end' }, y);
    }
    node(svg, 'text', { x: px((x0 + x1) / 2), y: high + 50, 'text-anchor': 'middle' }, 'target x in mm (table frame W)');
    node(svg, 'text', { x: 12, y: py((y0 + y1) / 2), 'text-anchor': 'middle', transform: `rotate(-90 12 ${py((y0 + y1) / 2)})` }, 'target y in mm');
    for (const order of ['open', 'left', 'done', 'suspect']) {
      for (const p of points) {
        if (p.state === order) mark(svg, p.state, px(p.x), py(p.y), `${p.name}: ${p.state}${p.why ? ', ' + p.why : ''}`);
      }
    }
    if (next) mark(svg, 'next', px(next.x), py(next.y), 'in hand');
  }

  /// swarms: [{name, points: [[iteration, best]]}]; logarithmic upwards.
  function convergence(svg, swarms) {
    svg.replaceChildren();
    const wide = 480, high = 190, left = 60, room = 40;
    const all = swarms.flatMap((s) => s.points);
    if (all.length === 0) return;
    svg.setAttribute('viewBox', `0 0 ${wide} ${high + room}`);
    const last = Math.max(1, ...all.map((p) => p[0]));
    let low = Math.log10(Math.min(...all.map((p) => p[1]))), top = Math.log10(Math.max(...all.map((p) => p[1])));
    if (top - low < 0.1) { low -= 0.05; top += 0.05; }
    const px = (n) => left + (n / last) * (wide - left - 12);
    const py = (v) => 12 + ((top - Math.log10(v)) / (top - low)) * (high - 24);
    node(svg, 'path', { class: 'axis', d: `M${left} 4V${high}H${wide - 8}` });
    for (const share of [0, 0.5, 1]) {
      const value = 10 ** (low + share * (top - low));
      node(svg, 'text', { x: left - 6, y: py(value) + 4, 'text-anchor': 'end' }, value.toPrecision(3));
    }
    for (const n of ticks(0, last)) node(svg, 'text', { x: px(n), y: high + 16, 'text-anchor': 'middle' }, n);
    node(svg, 'text', { x: (left + wide) / 2, y: high + 34, 'text-anchor': 'middle' }, 'iteration');
    node(svg, 'text', { x: 4, y: high + 34 }, 'best error, mm');
    swarms.forEach((swarm, i) => {
      if (swarm.points.length === 0) return;
      const d = swarm.points.map((p, n) => `${n ? 'L' : 'M'}${px(p[0]).toFixed(1)} ${py(p[1]).toFixed(1)}`).join('');
      node(svg, 'path', { class: `line${i + 1}`, d });
      node(svg, 'path', { class: `line${i + 1}`, d: `M${wide - 190} ${16 + 16 * i}h30` });
      node(svg, 'text', { x: wide - 154, y: 20 + 16 * i }, swarm.name);
    });
  }

  function legend(list) {
    const words = { done: 'done', suspect: 'suspect: look again', next: 'in hand', open: 'still open', left: 'skipped' };
    for (const kind in words) {
      const item = document.createElement('li');
      const svg = node(item, 'svg', { viewBox: kind === 'next' ? '-19 -19 38 38' : '-10 -10 20 20' });
      mark(svg, kind, 0, 0);
      item.append(' ' + words[kind]);
      list.appendChild(item);
    }
  }

  /// The rows of the table of parameters: value and expanded uncertainty, angles in degrees.
  function parameters(body, estimate, { element, fixed, coverage }) {
    body.replaceChildren();
    for (const p of estimate.parameters) {
      const angle = p.unit === 'rad', times = angle ? 180 / Math.PI : 1, unsure = estimate.undetermined.includes(p.name);
      const row = element(body, 'tr', unsure ? 'open-parameter' : '');
      const name = element(row, 'td', '', p.name);
      element(name, 'small', '', ` ${p.meaning || ''}`);
      element(row, 'td', 'n', fixed(p.value * times, 4));
      element(row, 'td', 'n', fixed(coverage * p.sd * times, 4));
      element(row, 'td', '', angle ? 'deg' : 'mm');
      element(row, 'td', '', unsure ? '… needs more points' : '✓');
    }
  }
  return { map, convergence, legend, parameters };
})();
