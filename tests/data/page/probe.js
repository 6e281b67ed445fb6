// Uses a report's page as a reader does, and writes what came of it into the document, for `tests/suite/page.rs` to read.
addEventListener('load', () => setTimeout(() => {
  const told = { errors: window.probeErrors, checks: {}, files: [] };
  const check = (name, found, due = true) => { told.checks[name] = JSON.stringify(found) === JSON.stringify(due) ? 'ok' : `${JSON.stringify(found)}, where ${JSON.stringify(due)} is due`; };
  const attempt = (name, work) => { try { work(); } catch (error) { told.checks[name] = 'threw ' + error.message; } };
  const all = (selector, from = document) => [...from.querySelectorAll(selector)];
  const visible = (element) => element.getClientRects().length > 0;

  attempt('requests', () => check('requests', performance.getEntriesByType('resource').map((entry) => entry.name), []));
  told.interactive_ms = performance.getEntriesByType('navigation')[0].domInteractive;
  told.bytes = document.documentElement.outerHTML.length;

  attempt('links', () => {
    const links = all('a[href]').map((link) => link.getAttribute('href'));
    check('links inside', links.filter((link) => link.startsWith('#') && !document.getElementById(link.slice(1))), []);
    told.files = [...new Set(links.filter((link) => !link.startsWith('#')))];
  });
  attempt('sort', () => {
    const table = document.getElementById('table'), column = 6;
    const values = () => all('tbody tr', table).map((row) => Number(row.cells[column].dataset.value));
    const button = all('thead button', table)[column], before = values().length;
    button.click();
    const up = values();
    check('sorted up', up.every((v, k) => k === 0 || up[k - 1] <= v));
    check('sort is told', button.closest('th').getAttribute('aria-sort'), 'ascending');
    button.click();
    check('sorted down', values(), [...up].reverse().sort((a, b) => b - a));
    check('no row is lost', up.length, before);
    told.rows = before;
    all('thead button', table)[0].click();
  });
  attempt('filter', () => {
    const find = document.getElementById('find'), only = document.getElementById('only'), rows = all('#table tbody tr');
    const left = () => rows.filter(visible).length;
    find.value = 'STRATIFIED bias';
    find.dispatchEvent(new Event('input'));
    const due = rows.filter((row) => /stratified/.test(row.textContent) && /bias/.test(row.textContent)).length;
    check('found by words', left(), due);
    check('found some, not all', due > 0 && due < rows.length);
    find.value = '';
    find.dispatchEvent(new Event('input'));
    only.value = 'fail';
    only.dispatchEvent(new Event('change'));
    check('failed alone', left(), rows.filter((row) => row.dataset.verdict === 'fail').length);
    only.value = '';
    only.dispatchEvent(new Event('change'));
    check('all again', left(), rows.length);
  });
  // Failing cases are open from the start; the rest opens by hand.
  attempt('failing', () => {
    const failing = all('details.case').filter((one) => one.querySelector('summary .mark.fail'));
    check('failing cases are open', failing.every((one) => one.open));
    check('failing cases come first', all('details.case').slice(0, failing.length).every((one) => failing.includes(one)));
    told.failing = failing.length;
    told.alarms = all('.alarm li code').map((code) => code.textContent);
  });
  document.querySelector('[data-all=open]').click();
  setTimeout(() => {
    attempt('charts', () => {
      const empty = all('[data-chart]').filter((figure) => !figure.querySelector('.canvas svg path, .canvas canvas'));
      check('charts are drawn', empty.map((figure) => figure.dataset.chart), []);
      told.charts = all('[data-chart]').length;
      const broken = all('svg *').filter((element) => [...element.attributes].some((attribute) => /NaN|Infinity|undefined/.test(attribute.value)));
      check('every mark has a place', broken.map((element) => element.outerHTML).slice(0, 3), []);
    });
    attempt('values', () => {
      const figure = document.querySelector('details.case [data-chart=variance]'), svg = figure.querySelector('svg'), tip = figure.querySelector('.tip');
      svg.focus();
      svg.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true }));
      check('a key reads values', !tip.hidden && /N = \d/.test(tip.textContent) && /expected/.test(tip.textContent));
      svg.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape', bubbles: true }));
      check('and lets go', tip.hidden);
      const bounds = svg.getBoundingClientRect();
      for (let share = 0.2; share < 0.9 && tip.hidden; share += 0.02)
        svg.dispatchEvent(new PointerEvent('pointermove', { clientX: bounds.left + share * bounds.width, clientY: bounds.top + bounds.height * 0.4, bubbles: true }));
      check('a pointer reads values', !tip.hidden && tip.textContent.length > 10);
    });
    attempt('legend', () => {
      const figure = document.querySelector('details.case [data-chart=variance]'), count = () => all('.curve', figure).length, before = count();
      figure.querySelector('.legend button').click();
      check('a series can be hidden', count() < before);
      figure.querySelector('.legend button').click();
      check('and shown', count(), before);
    });
    attempt('pictures', () => {
      const figure = document.querySelector('.pictures'), shown = () => all('img', figure).map((image, k) => (visible(image) ? k : -1)).filter((k) => k >= 0);
      check('one picture', shown(), [0]);
      const buttons = all('button', figure);
      buttons[2].click();
      check('the third picture', shown(), [2]);
      buttons[2].dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true }));
      check('the next by key', shown(), [3]);
      check('the switch tells', buttons.map((button) => button.getAttribute('aria-pressed')).indexOf('true'), 3);
      check('pictures are whole', all('img').every((image) => image.naturalWidth > 0));
    });
    attempt('names', () => {
      check('pictures have words', all('img').filter((image) => !image.alt).length, 0);
      check('drawings have words', all('svg').filter((svg) => !svg.getAttribute('aria-label') && svg.getAttribute('aria-hidden') !== 'true').length, 0);
      check('buttons have words', all('button').filter((button) => !button.textContent.trim()).length, 0);
      check('fields have labels', all('input, select').filter((field) => !field.closest('label')).length, 0);
      check('identifiers are single', all('[id]').map((e) => e.id).filter((id, k, ids) => ids.indexOf(id) !== k), []);
      check('one heading of first rank', all('h1').length, 1);
      check('language', document.documentElement.lang, 'en');
    });
    attempt('contrast', () => {
      const parse = (text) => { const [r, g, b, a = 1] = text.match(/[\d.]+/g).map(Number); return { r, g, b, a }; };
      const over = (top, below) => ({ r: top.r * top.a + below.r * (1 - top.a), g: top.g * top.a + below.g * (1 - top.a), b: top.b * top.a + below.b * (1 - top.a), a: 1 });
      const light = ({ r, g, b }) => { const [x, y, z] = [r, g, b].map((v) => ((v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)); return 0.2126 * x + 0.7152 * y + 0.0722 * z; };
      const paper = (element) => {
        const layers = [];
        for (let at = element; at; at = at.parentElement) { const colour = parse(getComputedStyle(at).backgroundColor); if (colour.a > 0) { layers.push(colour); if (colour.a === 1) break; } }
        return layers.reduceRight((below, top) => over(top, below), { r: 255, g: 255, b: 255, a: 1 });
      };
      const low = new Set();
      let n = 0;
      for (const element of all('body *')) {
        if (![...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim()) || !visible(element) || element.closest('script, style, title, option')) continue;
        const style = getComputedStyle(element), svg = element instanceof SVGElement, ink = parse(svg ? style.fill : style.color);
        const below = paper(svg ? element.closest('svg') : element), [a, b] = [light(over(ink, below)), light(below)].sort((x, y) => y - x);
        const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
        n += 1;
        if ((a + 0.05) / (b + 0.05) < (large ? 3 : 4.5)) low.add(`${element.tagName}.${element.className.baseVal ?? element.className}: ${((a + 0.05) / (b + 0.05)).toFixed(2)}`);
      }
      check('contrast', [...low].slice(0, 6), []);
      told.texts = n;
    });
    attempt('width', () => check('nothing runs out of the page', document.documentElement.scrollWidth <= innerWidth));
    told.scheme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
    told.width = innerWidth;
    const told_in = document.createElement('pre');
    told_in.id = 'told';
    told_in.textContent = JSON.stringify(told);
    document.body.append(told_in);
  }, 400);
}, 100));
