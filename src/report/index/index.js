'use strict';
// Draws the page's charts from its embedded data, when their case is opened, and makes tables and pictures answer.
const cases = JSON.parse(document.getElementById('data').textContent).cases;
const LOOKS = {
  random: ['circle', ''], correlated: ['square', '7 4'], stratified: ['triangle', '8 3 2 3'], 'uniform-jitter': ['funnel', '2 3'],
  'latin-hypercube': ['plus', '13 4'], 'multi-jittered': ['diamond', '8 3 2 3 2 3'], sobol: ['star', '4 2.5'], 'solid-angle': ['diamond', '2 3'],
  cosine: ['circle', '7 4'], 'mis-balance': ['square', '2 3'], 'mis-power': ['triangle', '7 4'],
};
const REGIONS = { l: 'lit', p: 'penumbra', u: 'umbra', b: 'below horizon', e: 'edge' };
const SHADES = { l: '', p: 'var(--penumbra)', u: 'var(--umbra)', b: 'var(--below)', e: 'var(--edge)' };
// Guests differ in mark and dash, in the order in which they are met.
const GUESTS = [['funnel', '4 2.5'], ['plus', '2 3'], ['star', '8 3'], ['diamond', '13 4'], ['square', '4 2.5 1 2.5']];
const guests = new Map();
const look = (name) => {
  const known = Object.hasOwn(LOOKS, name);
  if (!known && !guests.has(name)) guests.set(name, guests.size);
  const [marker, dash] = known ? LOOKS[name] : GUESTS[guests.get(name) % GUESTS.length];
  return { colour: `var(--c-${known ? name : 'guest'})`, marker, dash };
};
const shown = (name) => (name === 'correlated' ? 'shared points' : name);

// Numbers as people write them.
const SUPER = { '-': '⁻', 0: '⁰', 1: '¹', 2: '²', 3: '³', 4: '⁴', 5: '⁵', 6: '⁶', 7: '⁷', 8: '⁸', 9: '⁹' };
const power = (k) => (k === 0 ? '1' : k === 1 ? '10' : '10' + [...String(k)].map((c) => SUPER[c]).join(''));
const number = (x, digits = 3) => {
  if (x === null || x === undefined || !isFinite(x)) return '–';
  if (x === 0) return '0';
  const size = Math.floor(Math.log10(Math.abs(x)));
  if (size < -3 || size > 4) return (x / 10 ** size).toFixed(digits - 1).replace('-', '−') + '·' + power(size);
  return x.toFixed(Math.max(0, digits - 1 - size)).replace('-', '−');
};
const percent = (x) => number(100 * x, 2) + ' %';

// SVG.
const NS = 'http://www.w3.org/2000/svg';
const make = (name, attributes, parent, text) => {
  const element = document.createElementNS(NS, name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  if (text !== undefined) element.textContent = text;
  if (parent) parent.appendChild(element);
  return element;
};
const html = (name, attributes, parent, text) => {
  const element = document.createElement(name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  if (text !== undefined) element.textContent = text;
  if (parent) parent.appendChild(element);
  return element;
};
const OUTLINES = {
  square: 'M-1-1H1V1H-1Z', triangle: 'M0-1.3L1.2.8L-1.2.8Z', diamond: 'M0-1.3L1.2 0L0 1.3L-1.2 0Z', funnel: 'M0 1.3L-1.2-.8L1.2-.8Z',
  plus: 'M-.4-1.2H.4V-.4H1.2V.4H.4V1.2H-.4V.4H-1.2V-.4H-.4Z', star: 'M0-1.5L.39-.53L1.43-.46L.63.2L.88 1.21L0 .66L-.88 1.21L-.63.2L-1.43-.46L-.39-.53Z',
};
const marker = (parent, kind, x, y, size, colour) =>
  kind === 'circle'
    ? make('circle', { cx: x.toFixed(1), cy: y.toFixed(1), r: size, fill: colour }, parent)
    : make('path', { d: OUTLINES[kind], fill: colour, transform: `translate(${x.toFixed(1)} ${y.toFixed(1)}) scale(${size})` }, parent);

// An axis: where values lie between 0 and 1, and its ticks.
const linear = (low, high, count = 6) => {
  if (!(high > low)) [low, high] = [low - (Math.abs(low) || 1), high + (Math.abs(high) || 1)];
  const rough = (high - low) / count, ten = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * ten).find((s) => s >= rough * 0.999);
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) ticks.push(k * step);
  const size = Math.floor(Math.log10(Math.max(Math.abs(low), Math.abs(high))));
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const label = (v) => (Math.abs(v) < 1e-9 * step ? '0' : size < -3 || size > 4
    ? (v / 10 ** size).toFixed(Math.max(0, places + size)).replace('-', '−') + '·' + power(size) : v.toFixed(places).replace('-', '−'));
  return { low, high, at: (v) => (v - low) / (high - low), ticks: ticks.map((v) => [v, label(v)]) };
};
const log = (low, high) => {
  const ticks = [], first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
  const every = Math.max(1, Math.ceil((last - first + 1) / 7));
  for (let k = first; k <= last; k++) ticks.push([10 ** k, (last - k) % every === 0 ? power(k) : '']);
  if (last - first < 2) for (let k = first - 1; k <= last; k++) for (const m of [2, 5]) if (m * 10 ** k >= low && m * 10 ** k <= high) ticks.push([m * 10 ** k, number(m * 10 ** k, 1)]);
  ticks.sort((a, b) => a[0] - b[0]);
  return { low, high, at: (v) => Math.log(v / low) / Math.log(high / low), ticks };
};
const counts = (values) => {
  const low = Math.min(...values) / 1.5, high = Math.max(...values) * 1.5;
  return { low, high, at: (v) => Math.log(v / low) / Math.log(high / low), ticks: [...new Set(values)].map((v) => [v, String(v)]) };
};

// A chart: panels below or beside each other that share one tip. A panel has axes, series and guides.
// series: { name, key, colour, marker, dash, points: [[x, y, low, high]], band, bars, line, marks, steps, aside }
function chart(figure, panels, options = {}) {
  figure.querySelectorAll('.canvas, .legend').forEach((old) => old.remove());
  const wide = Math.max(280, figure.clientWidth || 420), columns = options.columns && wide > 430 ? options.columns : 1;
  const box = html('div', { class: 'canvas' });
  figure.insertBefore(box, figure.querySelector('figcaption'));
  const heights = panels.map((panel) => panel.height || 250);
  const rows = Math.ceil(panels.length / columns), gap = 16;
  const total = columns > 1 ? rows * heights[0] : heights.reduce((a, b) => a + b, 0);
  const svg = make('svg', { viewBox: `0 0 ${wide} ${total}`, role: 'img', tabindex: '0', 'aria-label': options.label + '. Arrow keys read its values.' }, box);
  const tip = html('div', { class: 'tip', hidden: '', role: 'status' }, box);
  const hidden = (figure.hiddenSeries = figure.hiddenSeries || new Set());
  const stops = [];
  let top = 0;
  panels.forEach((panel, k) => {
    const column = k % columns, spare = panel.room || 10, width = (wide - 58 - columns * spare - gap * (columns - 1)) / columns;
    if (columns > 1) top = Math.floor(k / columns) * heights[0];
    const left = 58 + column * (width + spare + gap);
    const room = { left, right: left + width, top: top + (panel.title && panel.yName ? 38 : panel.named ? 34 : panel.title ? 26 : 20), bottom: top + heights[k] - (panel.xName === '' ? 12 : 40) };
    drawPanel(svg, panel, room, hidden, column > 0);
    stops.push(...stopsOf(panel, room, hidden));
    if (columns === 1) top += heights[k];
  });
  const cursor = make('line', { class: 'cursor', visibility: 'hidden' }, svg);
  let current = -1;
  const show = (k) => {
    current = k;
    const stop = stops[k];
    tip.hidden = !stop;
    cursor.setAttribute('visibility', stop ? 'visible' : 'hidden');
    if (!stop) return;
    for (const [key, value] of Object.entries({ x1: stop.x, x2: stop.x, y1: stop.room.top, y2: stop.room.bottom })) cursor.setAttribute(key, value);
    tip.replaceChildren(html('b', {}, null, stop.title), ...stop.lines.map((line) => html('div', {}, null, line)));
    const scale = box.clientWidth / wide, left = stop.x * scale, over = left > box.clientWidth / 2;
    tip.style.left = over ? 'auto' : left + 10 + 'px';
    tip.style.right = over ? box.clientWidth - left + 10 + 'px' : 'auto';
    tip.style.top = stop.room.top * scale + figure.querySelector('.canvas').offsetTop + 'px';
  };
  const near = (event) => {
    const bounds = svg.getBoundingClientRect(), x = ((event.clientX - bounds.left) * wide) / bounds.width, y = ((event.clientY - bounds.top) * total) / bounds.height;
    let best = -1, distance = 40;
    stops.forEach((stop, k) => {
      if (y < stop.room.top - 16 || y > stop.room.bottom + 24 || x < stop.room.left - 12 || x > stop.room.right + 12) return;
      if (Math.abs(stop.x - x) < distance) [best, distance] = [k, Math.abs(stop.x - x)];
    });
    show(best);
  };
  svg.addEventListener('pointermove', near);
  svg.addEventListener('pointerdown', near);
  svg.addEventListener('pointerleave', () => show(-1));
  svg.addEventListener('blur', () => show(-1));
  svg.addEventListener('keydown', (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (event.key === 'Escape') show(-1);
    if (!step || !stops.length) return;
    event.preventDefault();
    show((current + step + stops.length) % stops.length);
  });
  legend(figure, panels, hidden, () => chart(figure, panels, options));
}

function drawPanel(svg, panel, room, hidden, bare) {
  const { x, y } = panel, X = (v) => room.left + (room.right - room.left) * x.at(v), Y = (v) => room.bottom - (room.bottom - room.top) * y.at(v);
  const inside = (v) => v >= y.low && v <= y.high;
  for (const [from, to, letter, width] of panel.regions || []) {
    if (SHADES[letter]) make('rect', { x: X(from), y: room.top, width: Math.max(0, X(to) - X(from)), height: room.bottom - room.top, style: `fill:${SHADES[letter]}` }, svg);
    const name = REGIONS[letter];
    if (panel.named && X(to) - X(from) > 7 * name.length) make('text', { class: 'note', x: (X(from) + X(to)) / 2, y: room.top - 4, 'text-anchor': 'middle' }, svg, name);
  }
  for (const [v, label] of y.ticks) {
    make('line', { class: 'grid', x1: room.left, x2: room.right, y1: Y(v), y2: Y(v) }, svg);
    if (!bare || panel.own) make('text', { x: room.left - 6, y: Y(v) + 4, 'text-anchor': 'end' }, svg, label);
  }
  let free = -Infinity;
  for (const [v, label] of x.ticks) {
    make('line', { class: 'grid', x1: X(v), x2: X(v), y1: room.top, y2: room.bottom }, svg);
    const half = 3.6 * label.length;
    if (panel.xName === '' || X(v) - half < free) continue;
    make('text', { x: X(v), y: room.bottom + 16, 'text-anchor': 'middle' }, svg, label);
    free = X(v) + half + 4;
  }
  make('path', { class: 'axis', d: `M${room.left} ${room.top}V${room.bottom}H${room.right}` }, svg);
  if (panel.xName) make('text', { class: 'note', x: (room.left + room.right) / 2, y: room.bottom + 33, 'text-anchor': 'middle' }, svg, panel.xName);
  if (panel.yName && !bare) make('text', { class: 'note', x: room.left - 52, y: room.top - (panel.named ? 21 : 7) }, svg, panel.yName);
  if (panel.title) make('text', { x: room.left, y: room.top - (panel.yName ? 23 : 7), 'font-weight': 600 }, svg, panel.title);
  if (panel.zero !== undefined && inside(panel.zero)) make('line', { class: 'zero', x1: room.left, x2: room.right, y1: Y(panel.zero), y2: Y(panel.zero) }, svg);
  const clip = 'clip' + Math.random().toString(36).slice(2);
  make('rect', { x: room.left, y: room.top, width: room.right - room.left, height: room.bottom - room.top }, make('clipPath', { id: clip }, svg));
  const ink = make('g', { 'clip-path': `url(#${clip})` }, svg);
  for (const guide of panel.guides || []) {
    make('path', { class: guide.class || 'guide', d: path(guide.points, X, Y), ...(guide.colour ? { style: `stroke:${guide.colour};stroke-dasharray:${guide.dash}` } : {}) }, ink);
    if (guide.label) { const [gx, gy] = guide.points[guide.points.length - 1]; make('text', { class: 'guide-name', x: Math.min(X(gx) + 4, room.right + 2), y: Math.max(room.top + 10, Math.min(room.bottom - 2, Y(gy) + 4)) }, svg, guide.label); }
  }
  for (const s of panel.series) {
    if (hidden.has(s.name)) continue;
    const shownPoints = s.points.filter((p) => isFinite(X(p[0])) && isFinite(Y(p[1])));
    const side = s.aside || 0;
    if (s.band && shownPoints.length > 1) {
      const low = (p) => Math.max(p[2], y.low > 0 ? y.low : -Infinity);
      const up = shownPoints.map((p) => `${X(p[0]).toFixed(1)} ${Y(Math.min(p[3], y.high)).toFixed(1)}`), down = shownPoints.map((p) => `${X(p[0]).toFixed(1)} ${Y(low(p)).toFixed(1)}`).reverse();
      make('path', { class: 'band', d: 'M' + up.concat(down).join('L') + 'Z', style: `fill:${s.colour}` }, ink);
    }
    if (s.line) make('path', { class: 'curve', d: path(s.steps ? s.steps : s.fit || shownPoints, X, Y), style: `stroke:${s.colour};stroke-dasharray:${s.dash || 'none'}` }, ink);
    if (s.bars) for (const p of shownPoints) {
      const [a, b] = [Y(Math.max(p[2], y.low)), Y(Math.min(p[3], y.high))];
      make('path', { class: 'bar', d: `M${(X(p[0]) + side).toFixed(1)} ${a.toFixed(1)}V${b.toFixed(1)}`, style: `stroke:${s.colour}` }, ink);
    }
    if (s.marks) shownPoints.forEach((p, k) => { if (k % (s.every || 1) === 0) marker(inside(p[1]) ? svg : ink, s.marker, X(p[0]) + side, Y(p[1]), s.size || 3.4, s.colour); });
  }
  if (panel.exact) make('path', { class: 'exact', d: path(panel.exact, X, Y) }, ink);
}
const path = (points, X, Y) => 'M' + points.map((p) => `${X(p[0]).toFixed(1)} ${Y(p[1]).toFixed(1)}`).join('L');

function stopsOf(panel, room, hidden) {
  const at = new Map();
  for (const s of panel.series) {
    if (hidden.has(s.name)) continue;
    for (const p of s.points) {
      if (!at.has(p[0])) at.set(p[0], []);
      at.get(p[0]).push(`${s.name}: ${s.tell(p)}`);
    }
  }
  return [...at.keys()].sort((a, b) => a - b).map((v) => ({
    room, x: room.left + (room.right - room.left) * panel.x.at(v), title: (panel.title ? panel.title + ', ' : '') + panel.where(v),
    lines: [...(panel.exactAt ? [`exact: ${panel.exactAt(v)}`] : []), ...at.get(v)],
  })).filter((stop) => isFinite(stop.x));
}

function legend(figure, panels, hidden, redraw) {
  const entries = new Map();
  panels.forEach((panel) => panel.series.forEach((s) => { if (!entries.has(s.name)) entries.set(s.name, s); }));
  const list = html('ul', { class: 'legend' });
  figure.insertBefore(list, figure.querySelector('figcaption'));
  const sample = (parent, s) => {
    const svg = make('svg', { viewBox: '0 0 30 12', 'aria-hidden': 'true' }, parent);
    make('line', { x1: 0, x2: 30, y1: 6, y2: 6, style: `stroke:${s.colour};stroke-width:1.8;stroke-dasharray:${s.dash || 'none'}` }, svg);
    if (s.marker) marker(svg, s.marker, 15, 6, 3.6, s.colour);
  };
  if (panels.some((panel) => panel.exact)) sample(html('li', {}, list), { colour: 'var(--ink)' }), list.lastChild.append('exact');
  for (const [name, s] of entries) {
    const button = html('button', { type: 'button', 'aria-pressed': String(!hidden.has(name)), title: 'Show or hide' }, html('li', {}, list));
    sample(button, s);
    button.append(name + (s.note ? ' ' + s.note : ''));
    button.addEventListener('click', () => { hidden.has(name) ? hidden.delete(name) : hidden.add(name); redraw(); });
  }
}

// The charts of a case.
const regionName = (name) => (name === 'all' ? 'all points in the light' : name.replace('_', ' '));
const slopeName = (v) => '−' + (Number.isInteger(v) ? Math.abs(v) : Number.isInteger(2 * v) ? Math.abs(2 * v) + '/2' : Math.abs(v).toFixed(2));

const CHARTS = {
  variance(figure, c) {
    let regions = [...new Set(c.strategies.flatMap((s) => s.curves.filter((k) => k.points.length).map((k) => k.region)))];
    if (regions.length > 1) regions = regions.filter((r) => r !== 'all');
    const order = ['lit', 'penumbra', 'umbra', 'below_horizon', 'edge', 'all'];
    regions.sort((a, b) => order.indexOf(a) - order.indexOf(b));
    const all = c.strategies.flatMap((s) => s.curves.flatMap((k) => k.points)).filter((p) => p[1] > 0);
    const x = counts(all.map((p) => p[0])), y = log(Math.min(...all.map((p) => (p[2] > 0 ? p[2] : p[1]))) / 2, Math.max(...all.map((p) => p[3])) * 2);
    // Fitted slopes with their 95 % intervals, region by region.
    const slopes = (s) => regions.map((region) => [region, s.curves.find((k) => k.region === region && k.points.length)]).filter(([, k]) => k)
      .map(([region, k]) => `${regions.length > 1 ? region.replace('_', ' ') + ' ' : ''}${number(k.slope)} ± ${number((k.high - k.low) / 2, 1)}`).join(', ');
    const panels = regions.map((region) => {
      const curves = c.strategies.map((s) => [s, s.curves.find((k) => k.region === region)]).filter(([, k]) => k && k.points.some((p) => p[1] > 0));
      const guides = [...new Set(curves.map(([, k]) => k.asymptote).filter((v) => v !== null))].sort((a, b) => b - a).map((slope, i) => {
        const own = curves.filter(([, k]) => k.asymptote === slope).flatMap(([, k]) => k.points).filter((p) => p[1] > 0);
        const offsets = own.map((p) => Math.log(p[1]) - slope * Math.log(p[0])), level = i ? Math.min(...offsets) - 0.7 : Math.max(...offsets) + 0.7;
        const ends = [Math.min(...own.map((p) => p[0])), Math.max(...own.map((p) => p[0]))];
        return { points: ends.map((n) => [n, Math.exp(level + slope * Math.log(n))]), label: slopeName(slope) };
      });
      return {
        title: regionName(region), x, y, xName: 'samples N', yName: 'variance (W²/m⁴)', guides, room: 30, where: (n) => `N = ${n}`,
        series: curves.map(([s, k]) => ({
          name: shown(s.name), ...look(s.name), band: true, line: true, marks: true, note: `(slope ${slopes(s)})`, points: k.points.filter((p) => p[1] > 0),
          fit: k.intercept === null ? null : [k.points[0][0], k.points[k.points.length - 1][0]].map((n) => [n, Math.exp(k.intercept + k.slope * Math.log(n))]),
          tell: (p) => `${number(p[1])} (${number(p[2], 2)} … ${number(p[3], 2)}), slope ${number(k.slope)} ± ${number((k.high - k.low) / 2, 1)}, expected ${number(k.expected)}`,
        })),
      };
    });
    chart(figure, panels, { columns: Math.min(2, panels.length), label: 'Variance against the number of samples' });
  },
  bias(figure, c) {
    const made = c.strategies.filter((s) => s.biases.length), all = made.flatMap((s) => s.biases);
    if (!all.length) return void figure.remove();
    const reach = Math.max(...all.map(([, b, e]) => Math.abs(b) + 1.96 * e), ...made.map((s) => s.seen || 0)) * 1.1 || 1e-9;
    const finest = Math.min(...all.map(([, , e]) => e).filter((e) => e > 0));
    // Linear about zero, logarithmic beyond: errors shrink a hundredfold from the first N to the last.
    const bend = Math.max(isFinite(finest) ? finest : 0, reach / 3000), along = (v) => Math.asinh(v / bend) / Math.asinh(reach / bend);
    const ticks = [[0, '0']];
    const decades = [];
    for (let k = Math.ceil(Math.log10(bend)); 10 ** k <= reach; k++) decades.push(k);
    decades.forEach((k) => [1, -1].forEach((sign) => ticks.push([sign * 10 ** k, (decades.length < 4 || (decades[decades.length - 1] - k) % 2 === 0 ? (sign > 0 ? '+' : '−') + number(100 * 10 ** k, 1) + ' %' : '')])));
    const y = { low: -reach, high: reach, at: (v) => 0.5 + 0.5 * along(v), ticks }, n = made.length;
    chart(figure, [{
      x: counts(all.map(([samples]) => samples)), y, zero: 0, xName: 'samples N', yName: 'relative bias', where: (v) => `N = ${v}`,
      guides: made.filter((s) => s.seen).flatMap((s) => [1, -1].map((sign) => ({ colour: look(s.name).colour, dash: look(s.name).dash || '5 5', points: [[1e-3, sign * s.seen], [1e9, sign * s.seen]] }))),
      series: made.map((s, k) => ({
        name: shown(s.name), ...look(s.name), bars: true, marks: true, aside: 9 * (k - (n - 1) / 2), points: s.biases.map(([samples, b, e]) => [samples, b, b - 1.96 * e, b + 1.96 * e]),
        tell: (p) => `${p[1] > 0 ? '+' : ''}${percent(p[1])} ± ${percent((p[3] - p[2]) / 2)}`, note: s.seen ? `(would catch ${percent(s.seen)})` : '',
      })),
    }], { label: 'Bias of the mean against the number of samples' });
  },
  profile(figure, c) {
    const made = c.strategies.filter((s) => s.bias.length === c.exact.length);
    if (c.samples) figure.querySelector('h4').textContent = `Irradiance, N = ${c.samples}`;
    if (c.kind === 'map') return maps(figure, c, made);
    const line = c.kind === 'line', last = c.along[c.along.length - 1];
    const x = line ? linear(c.along[0], last) : { ...linear(-0.5, last + 0.5, 8) };
    if (!line) x.ticks = x.ticks.filter(([v]) => Number.isInteger(v) && v >= 0 && v <= last).map(([v]) => [v, String(v)]);
    const top = Math.max(...c.exact, ...made.flatMap((s) => c.exact.map((e, k) => e + s.spread[k])));
    const reach = Math.max(...made.flatMap((s) => s.bias.map((b, k) => Math.abs(b) + 1.96 * s.error[k]))) || 1e-3 * (top || 1);
    const regions = [];
    for (let k = 0, from = 0; k < c.regions.length; k++) {
      if (c.regions[k + 1] === c.regions[from]) continue;
      const middle = (i) => (i < 0 ? x.low : i + 1 >= c.along.length ? x.high : (c.along[i] + c.along[i + 1]) / 2);
      regions.push([middle(from - 1), middle(k), c.regions[from]]);
      from = k + 1;
    }
    const xName = line ? 'distance along the line (m)' : 'measurement point', n = made.length, every = Math.max(1, Math.ceil(c.along.length / 20));
    const where = (v) => (line ? `${number(v)} m` : `point ${v}`) + `, ${REGIONS[c.regions[c.along.indexOf(v)]]}`;
    const exactAt = (v) => number(c.exact[c.along.indexOf(v)]) + ' W/m²';
    chart(figure, [
      { x, y: linear(0, (top || 1) * 1.05), xName: '', yName: 'irradiance (W/m²)', regions, named: true, height: 240, where, exactAt,
        exact: line ? c.along.map((v, k) => [v, c.exact[k]]) : undefined,
        series: made.map((s, j) => ({ name: shown(s.name), ...look(s.name), band: line, bars: !line, marks: true, every: line ? every : 1, aside: line ? 0 : 5 * (j - (n - 1) / 2),
          points: c.along.map((v, k) => [v, c.exact[k] + s.bias[k], Math.max(0, c.exact[k] - s.spread[k]), c.exact[k] + s.spread[k]]),
          tell: (p) => { const k = c.along.indexOf(p[0]); return `one estimate ± ${number(s.spread[k])}`; } })) },
      { x, y: linear(-reach, reach, 4), xName, yName: 'mean − exact (W/m²)', regions, zero: 0, height: 170, where,
        series: made.map((s, j) => ({ name: shown(s.name), ...look(s.name), bars: true, marks: true, size: 2.2, aside: line ? 0 : 5 * (j - (n - 1) / 2),
          points: c.along.map((v, k) => [v, s.bias[k], s.bias[k] - 1.96 * s.error[k], s.bias[k] + 1.96 * s.error[k]]),
          tell: (p) => `${number(p[1])} ± ${number((p[3] - p[2]) / 2, 2)}` })) },
    ], { label: 'Irradiance over the measurement points' });
  },
  correlation(figure, c) {
    const made = c.strategies.filter((s) => s.correlations.length), all = made.flatMap((s) => s.correlations.flatMap(([, points]) => points));
    const x = linear(0, Math.max(...all.map((p) => p[0])), 4), y = linear(Math.max(-1, Math.min(-0.2, ...all.map((p) => p[2]))), Math.min(1, Math.max(0.2, ...all.map((p) => p[3]))), 5);
    const kinds = [['circle', ''], ['square', '7 4'], ['diamond', '8 3 2 3']];
    chart(figure, made.map((s) => ({
      title: shown(s.name), x, y, zero: 0, height: made.length > 1 ? 210 : 250, xName: 'separation (m)', yName: '', where: (v) => `${number(v)} m`,
      guides: s.correlations.filter(([, points]) => points.length > 1 && points.every((p) => p[4] !== null)).map(([, points]) => ({ class: 'guide dotted', points: points.map((p) => [p[0], p[4]]) })),
      series: s.correlations.map(([samples, points], k) => ({ name: `N = ${samples}`, colour: ['var(--one)', 'var(--two)', 'var(--three)'][k], marker: kinds[k][0], dash: kinds[k][1], band: true, line: true, marks: true,
        every: Math.max(1, Math.ceil(points.length / 8)), points, tell: (p) => `${number(p[1], 2)} (${number(p[2], 2)} … ${number(p[3], 2)})${p[4] === null ? '' : ', predicted ' + number(p[4], 2)}` })),
    })), { columns: Math.min(3, made.length), label: 'Correlation of errors against distance' });
  },
  caustic(figure, c) {
    const orders = [...new Set(c.rings.map((r) => r[0]))], lit = c.rings.filter((r) => r[4] > 0 || r[2] > 0);
    const high = Math.max(0, ...lit.map((r) => Math.max(r[4], r[2] + 1.96 * r[3]))) || 1, several = orders.length > 1;
    const y = several ? log(Math.min(high / 10, ...lit.map((r) => r[4]).filter((v) => v > 0)) / 2, high * 2) : linear(0, 1.05 * high);
    const looks = ['random', 'correlated', 'stratified', 'multi-jittered'];
    const series = orders.map((order, k) => {
      const rings = c.rings.filter((r) => r[0] === order);
      let inner = 0;
      const steps = rings.flatMap(([, middle, , , exact]) => { const outer = 2 * middle - inner, both = [[inner, exact], [outer, exact]]; inner = outer; return both; }).filter((p) => !several || p[1] > 0);
      return { name: order === 1 ? '1 interaction' : `${order || 'any'} interactions`, ...look(looks[k % 4]), steps, line: true, bars: true, marks: true, points: rings.map((r) => [r[1], r[2], r[2] - 1.96 * r[3], r[2] + 1.96 * r[3], r[4]]), tell: (p) => `${number(p[1])} ± ${number(p[1] - p[2], 2)}, exact ${number(p[4])} W/m²` };
    });
    const end = Math.max(...series.flatMap((s) => s.steps.map((p) => p[0])));
    chart(figure, [{ x: linear(0, end), y, xName: 'radius (m)', yName: 'irradiance (W/m²)', where: (v) => `${number(v)} m from the axis`, series }], { label: 'Irradiance over rings around the axis' });
  },
  texels(figure, c) {
    const budgets = [...new Set(c.texels.map((t) => t[0]))], looks = ['random', 'correlated', 'stratified', 'multi-jittered'];
    const errors = c.texels.flatMap((t) => t.slice(2)).filter((v) => v > 0), sizes = c.texels.map((t) => t[1]);
    const last = c.texels.filter((t) => t[0] === budgets[budgets.length - 1] && t[4] > 0);
    chart(figure, [{
      x: log(Math.min(...sizes) / 1.4, Math.max(...sizes) * 1.4), y: log(Math.min(...errors) / 2, Math.max(...errors) * 2), xName: 'size of a texel (m)', yName: 'relative error (rms)', where: (v) => `${number(v)} m`,
      guides: last.length > 1 ? [{ class: 'exact dotted', points: last.map((t) => [t[1], t[4]]) }] : [],
      series: budgets.map((rays, k) => ({ name: `${rays.toLocaleString('en').replaceAll(',', '\u202f')} rays`, ...look(looks[k % 4]), line: true, marks: true,
        fit: c.texels.filter((t) => t[0] === rays && t[3] > 0).map((t) => [t[1], t[3]]), points: c.texels.filter((t) => t[0] === rays && t[2] > 0).map((t) => [t[1], t[2], t[3]]),
        tell: (p) => `noise ${percent(p[1])}, predicted ${percent(p[2])}` })),
    }], { label: 'What texels are off by' });
  },
  paths(figure, c) {
    const names = [...new Set(c.paths.map((p) => p[0]))], looks = ['random', 'stratified', 'correlated'];
    const relative = (p) => [p[1], p[2] / p[4] - 1, (p[2] - 1.96 * p[3]) / p[4] - 1, (p[2] + 1.96 * p[3]) / p[4] - 1];
    const points = c.paths.filter((p) => p[4] > 0), reach = Math.max(...points.map(relative).flatMap((p) => [Math.abs(p[2]), Math.abs(p[3])])) || 1e-3;
    const most = Math.max(...points.map((p) => p[1])), x = linear(-0.5, most + 0.5, 8);
    x.ticks = x.ticks.filter(([v]) => Number.isInteger(v) && v >= 0).map(([v]) => [v, String(v)]);
    const y = linear(-reach, reach, 5);
    y.ticks = y.ticks.map(([v]) => [v, percent(v)]);
    chart(figure, [{ x, y, zero: 0, xName: 'measurement point', yName: 'measured less exact', where: (v) => `point ${v}`,
      series: names.map((name, k) => ({ name: name.replace('_', ' '), ...look(looks[k % 3]), bars: true, marks: true, aside: 4 * (k - (names.length - 1) / 2), points: points.filter((p) => p[0] === name).map(relative), tell: (p) => `${percent(p[1])} ± ${percent((p[3] - p[2]) / 2)}` })) }], { label: 'Paths from the eye against exact values' });
  },
  // Over all penumbras: variance relative to random, by N.
  ratios(figure) {
    const ratios = new Map();
    for (const c of cases) {
      const of = (s) => s && s.curves.find((k) => k.region === 'penumbra'), base = of(c.strategies.find((s) => s.name === 'random'));
      if (!base) continue;
      for (const s of c.strategies) for (const p of (of(s) || { points: [] }).points) {
        const b = base.points.find((q) => q[0] === p[0]);
        if (!b || !(b[1] > 0 && p[1] > 0)) continue;
        if (!ratios.has(s.name)) ratios.set(s.name, new Map());
        const at = ratios.get(s.name);
        if (!at.has(p[0])) at.set(p[0], []);
        at.get(p[0]).push(p[1] / b[1]);
      }
    }
    const series = [...ratios].map(([name, at]) => ({
      name: shown(name), ...look(name), line: true, marks: true, band: true,
      points: [...at].sort((a, b) => a[0] - b[0]).map(([n, all]) => { all.sort((a, b) => a - b); const h = all.length >> 1, m = all.length % 2 ? all[h] : (all[h - 1] + all[h]) / 2; return [n, m, all[0], all[all.length - 1]]; }),
      tell: (p) => `${number(p[1], 2)} (${number(p[2], 2)} … ${number(p[3], 2)})`,
    }));
    const all = series.flatMap((s) => s.points);
    if (!all.length) return;
    chart(figure, [{ x: counts(all.map((p) => p[0])), y: log(Math.min(...all.map((p) => p[2])) / 1.3, Math.max(...all.map((p) => p[3])) * 1.3), xName: 'samples N', yName: 'variance / that of random', zero: 1, where: (n) => `N = ${n}`, series, height: 280 }], { label: 'Variance relative to random points in penumbras' });
  },
};

// Maps: cividis for irradiance, blue over white to orange for deviations.
const CIVIDIS = [[0, 34, 78], [26, 56, 111], [67, 78, 108], [97, 101, 111], [125, 124, 120], [155, 148, 118], [188, 174, 108], [222, 201, 88], [254, 232, 56]];
const SIGNED = [[0, 76, 132], [104, 168, 210], [250, 250, 250], [236, 152, 92], [168, 66, 0]];
const colour = (stops, share) => {
  const along = Math.min(1, Math.max(0, share)) * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(along));
  return stops[k].map((v, i) => Math.round(v + (stops[k + 1][i] - v) * (along - k)));
};
function maps(figure, c, made) {
  figure.querySelectorAll('.canvas').forEach((old) => old.remove());
  const [nu, nv] = c.grid, box = html('div', { class: 'canvas maps' });
  figure.insertBefore(box, figure.querySelector('figcaption'));
  const top = Math.max(...c.exact) || 1, relative = (s) => c.exact.map((e, k) => (e > 0 ? s.bias[k] / e : null));
  const largest = Math.max(...made.flatMap(relative).map((v) => Math.abs(v || 0))) || 1;
  const draw = (title, values, stops, low, high, tell) => {
    const part = html('div', {}, box), name = html('p', {}, part, title);
    const canvas = html('canvas', { class: 'map', width: nu, height: nv, role: 'img', 'aria-label': `${title}, from ${tell(low)} to ${tell(high)}` }, part);
    const context = canvas.getContext('2d'), image = context.createImageData(nu, nv);
    values.forEach((v, k) => {
      const rgb = v === null ? [200, 200, 200] : colour(stops, (v - low) / (high - low)), place = ((nv - 1 - Math.floor(k / nu)) * nu + (k % nu)) * 4;
      image.data.set([...rgb, 255], place);
    });
    context.putImageData(image, 0, 0);
    html('div', { class: 'scalebar', style: `background:linear-gradient(to right,${stops.map((s) => `rgb(${s})`).join(',')})` }, part);
    const ends = html('div', { class: 'ends' }, part);
    html('span', {}, ends, tell(low)), html('span', {}, ends, tell(high));
    canvas.addEventListener('pointermove', (event) => {
      const bounds = canvas.getBoundingClientRect(), i = Math.min(nu - 1, Math.floor(((event.clientX - bounds.left) / bounds.width) * nu)), j = nv - 1 - Math.min(nv - 1, Math.floor(((event.clientY - bounds.top) / bounds.height) * nv));
      const v = values[j * nu + i];
      name.textContent = `${title}: ${v === null ? 'no light is due' : tell(v)}`;
    });
    canvas.addEventListener('pointerleave', () => (name.textContent = title));
  };
  draw('exact', c.exact, CIVIDIS, 0, top, (v) => number(v) + ' W/m²');
  for (const s of made) draw(shown(s.name) + ', off by', relative(s), SIGNED, -largest, largest, percent);
}

// Charts are drawn when they come to be seen.
const drawIn = (element) => element.querySelectorAll('[data-chart]').forEach((figure) => {
  const owner = figure.closest('[data-case]');
  try {
    CHARTS[figure.dataset.chart](figure, owner ? cases[owner.dataset.case] : null);
  } catch (error) {
    // The rest of the page goes on.
    console.error(`${figure.dataset.chart} of ${owner ? cases[owner.dataset.case].name : 'all'}: ${error.message}`);
  }
});
const details = [...document.querySelectorAll('details.case')];
details.forEach((element) => element.addEventListener('toggle', () => { if (element.open) drawIn(element); }));
const sampler = document.getElementById('sampler');
if (sampler) drawIn(sampler);
details.filter((element) => element.open).forEach(drawIn);
const goTo = () => {
  const target = location.hash.length > 1 && document.getElementById(location.hash.slice(1));
  if (target && target.matches('details')) { target.open = true; target.scrollIntoView(); }
};
addEventListener('hashchange', goTo);
goTo();
document.querySelectorAll('[data-all]').forEach((button) => button.addEventListener('click', () => details.forEach((element) => (element.open = button.dataset.all === 'open'))));
// An opened case says so later than paper waits.
addEventListener('beforeprint', () => details.forEach((element) => { if (!element.open) { element.open = true; drawIn(element); } }));
let resized, width = innerWidth;
addEventListener('resize', () => {
  if (innerWidth === width) return;
  width = innerWidth;
  clearTimeout(resized);
  resized = setTimeout(() => { if (sampler) drawIn(sampler); details.filter((element) => element.open).forEach(drawIn); }, 150);
});

// Watched: the page loads itself again, and what was open stays so.
if ('watched' in document.body.dataset) {
  const kept = 'etendue open cases';
  try {
    const open = JSON.parse(sessionStorage.getItem(kept) || '[]');
    details.forEach((element) => { if (open.includes(element.querySelector('code').textContent)) element.open = true; });
  } catch { /* Without a memory it all begins closed. */ }
  setInterval(() => {
    if (document.hidden || ['INPUT', 'SELECT'].includes(document.activeElement.tagName)) return;
    try {
      sessionStorage.setItem(kept, JSON.stringify(details.filter((element) => element.open).map((element) => element.querySelector('code').textContent)));
    } catch { /* As above. */ }
    location.reload();
  }, 2500);
}

// Tables.
const table = document.getElementById('table');
if (table) {
  const rows = [...table.tBodies[0].rows], heads = [...table.tHead.rows[0].cells];
  const value = (row, k) => { const cell = row.cells[k]; return 'value' in cell.dataset ? (cell.dataset.value === '' ? -Infinity : Number(cell.dataset.value)) : cell.textContent; };
  heads.forEach((head, k) => head.querySelector('button').addEventListener('click', () => {
    const down = head.getAttribute('aria-sort') === 'ascending';
    heads.forEach((other) => other.removeAttribute('aria-sort'));
    head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
    rows.sort((a, b) => { const [x, y] = [value(a, k), value(b, k)]; const order = typeof x === 'number' ? x - y : x.localeCompare(y, 'en'); return down ? -order : order; });
    table.tBodies[0].append(...rows);
  }));
  const find = document.getElementById('find'), only = document.getElementById('only'), found = document.getElementById('found');
  const filter = () => {
    const words = find.value.toLowerCase().split(/\s+/).filter(Boolean);
    let n = 0;
    rows.forEach((row) => {
      const text = row.textContent.toLowerCase(), matches = (!only.value || row.dataset.verdict === only.value) && words.every((word) => text.includes(word));
      row.hidden = !matches;
      n += matches;
    });
    found.textContent = n === rows.length ? '' : `${n} of ${rows.length}`;
  };
  find.addEventListener('input', filter);
  only.addEventListener('change', filter);
}

// Pictures.
document.querySelectorAll('.pictures').forEach((figure) => {
  const buttons = [...figure.querySelectorAll('button')], images = [...figure.querySelectorAll('img')];
  const show = (k) => {
    buttons.forEach((button, i) => button.setAttribute('aria-pressed', String(i === k)));
    images.forEach((image, i) => (image.hidden = i !== k));
  };
  buttons.forEach((button, k) => {
    button.addEventListener('click', () => show(k));
    button.addEventListener('keydown', (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const next = (k + step + buttons.length) % buttons.length;
      show(next);
      buttons[next].focus();
    });
  });
});
document.querySelectorAll('[data-copy]').forEach((button) => button.addEventListener('click', () => {
  const text = button.previousElementSibling.textContent;
  const done = () => { button.textContent = 'Copied'; setTimeout(() => (button.textContent = 'Copy'), 1500); };
  if (navigator.clipboard) navigator.clipboard.writeText(text).then(done, () => {});
}));
