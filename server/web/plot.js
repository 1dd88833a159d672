// Figures: plotly behind our own theme, toolbar, table and keyboard.
//
// A figure is described as { panels: [{ label, log, range, traces }], x: { label, log }, marks: [{ from, to }], events: [{ at, label }] },
// a trace as { name, x, y, ink, dash, dots, band, shown }. Panels stand above each other and share their x axis.

import { rough } from './number.js';

const source = new URL('plotly.js', import.meta.url);
let library;

function plotly() {
  library ??= new Promise((resolve, reject) => {
    const script = document.createElement('script');
    script.src = source;
    script.onload = () => resolve(window.Plotly);
    script.onerror = () => reject(new Error('the plotting library could not be loaded'));
    document.head.append(script);
  });
  return library;
}

/** The time window that all figures along the ride share. */
export class Timeline {
  range = null;
  #figures = new Set();

  join(figure) { this.#figures.add(figure); }

  set(range) {
    if (String(range) === String(this.range)) return;
    this.range = range;
    for (const figure of this.#figures) figure.refresh();
  }
}

const probe = document.createElement('span');
probe.hidden = true;

/** A colour of the style sheet as plotly understands it. */
function ink(name) {
  if (!probe.isConnected) document.body.append(probe);
  probe.style.color = `var(--${name})`;
  return getComputedStyle(probe).color;
}

function faint(name, share) {
  const [r, g, b] = ink(name).match(/[\d.]+/g);
  return `rgba(${r},${g},${b},${share})`;
}

const narrow = () => innerWidth < 640;

function toPlotly(trace, axis) {
  const color = ink(trace.ink ?? 'series-other');
  if (trace.kind === 'heat') {
    return {
      type: 'heatmap', name: trace.name, x: trace.x, y: trace.y, z: trace.z, yaxis: axis, zmid: 0,
      colorscale: [[0, ink('series-extended')], [0.5, ink('paper')], [1, ink('series-plain')]],
      colorbar: { thickness: 10, title: { text: trace.unit, side: 'right' } },
      hovertemplate: `%{x:,.4~r}, %{y:,.4~r}: %{z:,.4~r} ${trace.unit}<extra></extra>`,
    };
  }
  return {
    type: 'scatter', name: trace.name, x: trace.x, y: trace.y, yaxis: axis, text: trace.text,
    mode: trace.dots ? 'markers' : 'lines', showlegend: trace.legend ?? true,
    visible: trace.shown === false ? 'legendonly' : true, legendgroup: trace.name,
    line: { color, width: trace.width ?? 1.4, dash: trace.dash, simplify: true },
    marker: { color, size: trace.size ?? 6, symbol: trace.symbol ?? 'circle', line: { color: ink('raised'), width: 0.5 } },
    error_y: trace.error && { type: 'data', array: trace.error, color, thickness: 1, width: 0 },
    fill: trace.band ? 'tonexty' : undefined, fillcolor: trace.band ? faint(trace.ink, 0.18) : undefined,
    connectgaps: false, hoverlabel: { namelength: -1 },
    hovertemplate: trace.text ? '%{text}<extra></extra>' : undefined,
  };
}

/** A text as it stands beside a mark: short, and without what plotly takes for markup. */
function plain(text) {
  const short = text.length > 28 ? `${text.slice(0, 27)}…` : text;
  return short.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('>', '&gt;');
}

/** Powers of ten that a panel's curves run through: ticks at 1, 2 and 5 say little within one. */
function decades({ traces }) {
  const seen = traces.flatMap(({ y }) => [...y]).filter((value) => value > 0);
  const [least, most] = seen.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)], [Infinity, 0]);
  return Math.log10(most / least);
}

function toLayout(drawing, range) {
  const axis = {
    gridcolor: ink('line'), zerolinecolor: ink('line'), linecolor: ink('line'), tickcolor: ink('line'),
    automargin: true, exponentformat: 'power', minexponent: 6, title: { standoff: 6 },
  };
  const layout = {
    font: { family: getComputedStyle(document.body).fontFamily, size: 12, color: ink('ink') },
    paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)',
    separators: '.\u202f', margin: { l: 12, r: 8, t: 6, b: 12 }, hovermode: drawing.hover ?? 'x unified', dragmode: 'zoom',
    hoverlabel: { bgcolor: ink('raised'), bordercolor: ink('line'), font: { color: ink('ink') } },
    legend: { orientation: 'h', y: 1.02, yanchor: 'bottom', x: 0, xanchor: 'left', bgcolor: 'rgba(0,0,0,0)' },
    xaxis: { ...axis, title: { ...axis.title, text: drawing.x.label }, type: drawing.x.log ? 'log' : drawing.x.type ?? 'linear', anchor: 'y' },
    shapes: [...(drawing.marks ?? []).map(({ from, to }) => ({
      type: 'rect', xref: 'x', yref: 'paper', x0: from, x1: to, y0: 0, y1: 1, line: { width: 0 },
      fillcolor: faint('accent', 0.1), layer: 'below',
    })), ...(drawing.events ?? []).map(({ at }) => ({
      type: 'line', xref: 'x', yref: 'paper', x0: at, x1: at, y0: 0, y1: 1, layer: 'below',
      line: { width: 1.2, dash: 'dot', color: ink('quiet') },
    }))],
    annotations: (drawing.events ?? []).map(({ at, label }) => ({
      x: at, xref: 'x', y: 1, yref: 'paper', yanchor: 'top', xanchor: 'right', showarrow: false, textangle: -90,
      text: plain(label), font: { size: 11, color: ink('quiet') },
    })),
  };
  if (range) layout.xaxis.range = range;
  const count = drawing.panels.length;
  const gap = count > 1 ? 0.06 : 0;
  const weights = drawing.panels.map((panel) => panel.weight ?? 1);
  const unit = (1 - gap * (count - 1)) / weights.reduce((sum, weight) => sum + weight, 0);
  let top = 1;
  drawing.panels.forEach((panel, i) => {
    const bottom = Math.max(0, top - weights[i] * unit);
    layout[i ? `yaxis${i + 1}` : 'yaxis'] = {
      ...axis, domain: [bottom, top], title: { ...axis.title, text: panel.label }, type: panel.log ? 'log' : 'linear',
      anchor: 'x', rangemode: panel.zero ? 'tozero' : 'normal', nticks: narrow() ? 5 : 7,
      ...(panel.log && decades(panel) > 1 && { dtick: 'D2' }), ...(panel.range && { range: panel.range }),
    };
    top = bottom - gap;
  });
  // The x axis stands below the last panel.
  layout.xaxis.anchor = count > 1 ? `y${count}` : 'y';
  return layout;
}

export class Figure {
  #host; #plot; #draw; #timeline; #drawn; #drawing; #table; #turn = 0;

  /** `draw` gives the figure for a time window, or null where there is nothing to show. */
  constructor(host, draw, { timeline = null, eager = false } = {}) {
    this.#host = host;
    this.#draw = draw;
    this.#timeline = timeline;
    this.#plot = host.querySelector('.plot');
    this.#plot.classList.add('waiting');
    this.#tools();
    timeline?.join(this);
    document.addEventListener('theme', () => this.#drawn && this.refresh());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.#drawn && this.refresh());
    matchMedia('print').addEventListener('change', ({ matches }) => this.#fit(matches));
    if (eager) { this.#begin(); return; }
    const watch = new IntersectionObserver(([entry]) => {
      if (!entry.isIntersecting) return;
      watch.disconnect();
      this.#begin();
    }, { rootMargin: '400px' });
    watch.observe(host);
  }

  #begin() {
    if (this.#drawn) return;
    this.#drawn = true;
    this.refresh();
  }

  /** Draws for paper, or for the screen again. */
  #fit(paper) {
    if (!this.#plot.classList.contains('js-plotly-plot') || !this.#plot.offsetWidth) return;
    // Half a page wide; the browser tells the paper's size only when it is too late.
    window.Plotly.relayout(this.#plot, paper ? { width: 340, height: 160, 'font.size': 8 } : { width: null, height: null, autosize: true, 'font.size': 12 });
  }

  async refresh() {
    if (!this.#drawn) return;
    const turn = ++this.#turn;
    try {
      const [Plotly, drawing] = await Promise.all([plotly(), this.#draw(this.#timeline?.range ?? null)]);
      if (turn !== this.#turn) return;
      this.#drawing = drawing;
      this.#host.hidden = !drawing;
      if (!drawing) return;
      const range = this.#timeline?.range ?? this.#plot.layout?.xaxis?.range;
      const zoomed = this.#timeline ? this.#timeline.range : this.#plot.dataset.zoomed && range;
      const traces = drawing.panels.flatMap((panel, i) =>
        panel.traces.map((trace) => toPlotly(trace, i ? `y${i + 1}` : 'y')));
      const first = !this.#plot.classList.contains('js-plotly-plot');
      await Plotly.react(this.#plot, traces, toLayout(drawing, zoomed || null),
        { displayModeBar: false, responsive: true, doubleClick: 'reset', scrollZoom: false });
      this.#plot.classList.remove('waiting');
      this.#plot.dataset.points = String(traces.reduce((sum, trace) => sum + (trace.x?.length ?? 0), 0));
      if (first) this.#listen();
      if (this.#table) this.#fill();
    } catch (error) {
      this.#plot.classList.remove('waiting');
      this.#plot.textContent = `This figure could not be drawn: ${error.message}.`;
    }
  }

  #listen() {
    this.#plot.on('plotly_relayout', (change) => {
      if (change['xaxis.autorange'] || change['xaxis.range[0]'] !== undefined || change['xaxis.range']) {
        const reset = Boolean(change['xaxis.autorange']);
        const range = reset ? null : [...this.#plot.layout.xaxis.range];
        if (reset) delete this.#plot.dataset.zoomed; else this.#plot.dataset.zoomed = '1';
        this.#timeline?.set(range);
      }
    });
    this.#plot.addEventListener('keydown', (event) => this.#key(event));
  }

  #key(event) {
    const step = { ArrowLeft: [-0.2, 1], ArrowRight: [0.2, 1], '+': [0, 0.5], '=': [0, 0.5], '-': [0, 2] }[event.key];
    if (event.key === '0' || event.key === 'Escape') { this.#reset(); event.preventDefault(); return; }
    if (!step) return;
    event.preventDefault();
    const [shift, scale] = step;
    const [from, to] = this.#plot.layout.xaxis.range.map(Number);
    const middle = (from + to) / 2 + shift * (to - from);
    const half = scale * (to - from) / 2;
    window.Plotly.relayout(this.#plot, { 'xaxis.range': [middle - half, middle + half] });
  }

  #reset() {
    window.Plotly?.relayout(this.#plot, { 'xaxis.autorange': true, 'yaxis.autorange': true });
  }

  #tools() {
    const title = this.#host.querySelector('h3').textContent;
    this.#plot.tabIndex = 0;
    this.#plot.setAttribute('role', 'group');
    this.#plot.setAttribute('aria-label', `Plot: ${title}. Arrow keys pan, plus and minus zoom, 0 resets.`);
    const tools = document.createElement('div');
    tools.className = 'tools';
    const button = (text, what, act) => {
      const element = document.createElement('button');
      element.type = 'button';
      element.textContent = text;
      element.setAttribute('aria-label', `${text}: ${what}, ${title}`);
      element.addEventListener('click', act);
      tools.append(element);
      return element;
    };
    button('Reset', 'Show all again', () => this.#reset());
    const table = button('Table', 'Show as a table', () => {
      this.#table ? (this.#table.remove(), this.#table = null) : this.#open();
      table.setAttribute('aria-expanded', String(Boolean(this.#table)));
    });
    table.setAttribute('aria-expanded', 'false');
    button('CSV', 'Download the data as CSV', () => save(`${this.#name()}.csv`, csv(this.#drawing)));
    for (const format of ['svg', 'png']) {
      button(format.toUpperCase(), `Download as ${format.toUpperCase()}`, async () => {
        const image = await window.Plotly.toImage(this.#plot, { format, width: 1200, height: 700, scale: format === 'png' ? 2 : 1 });
        link(image, `${this.#name()}.${format}`);
      });
    }
    this.#host.querySelector('h3').after(tools);
  }

  #name() { return this.#host.id || 'figure'; }

  #open() {
    this.#table = document.createElement('div');
    this.#table.className = 'data';
    this.#table.tabIndex = 0;
    this.#table.setAttribute('role', 'region');
    this.#table.setAttribute('aria-label', `Data of ${this.#host.querySelector('h3').textContent}`);
    this.#host.append(this.#table);
    this.#fill();
  }

  #fill() {
    const most = 300;
    const [head, ...rows] = table(this.#drawing);
    const element = document.createElement('table');
    const row = element.createTHead().insertRow();
    for (const text of head) {
      const cell = document.createElement('th');
      cell.scope = 'col';
      cell.textContent = text;
      row.append(cell);
    }
    const body = element.createTBody();
    for (const values of rows.slice(0, most)) {
      const line = body.insertRow();
      for (const value of values) {
        const cell = line.insertCell();
        cell.className = 'number';
        cell.textContent = typeof value === 'number' ? rough(value, 6) : value ?? '';
      }
    }
    if (rows.length > most) {
      element.createCaption().textContent = `The first ${most} of ${rows.length} rows; the CSV holds all.`;
    }
    this.#table.replaceChildren(element);
  }
}

/** The numbers of a drawing as rows, the first one the header. */
function table(drawing) {
  const traces = drawing?.panels.flatMap((panel) => panel.traces.map((trace) => ({ ...trace, label: panel.label }))) ?? [];
  const heat = traces.find((trace) => trace.kind === 'heat');
  if (heat) {
    return [[heat.label, ...heat.x], ...heat.y.map((y, i) => [y, ...heat.z[i]])];
  }
  const shared = traces.every((trace) => trace.x === traces[0].x);
  if (shared && traces.length) {
    const head = [drawing.x.label, ...traces.map((trace) => `${trace.name}, ${trace.label}`)];
    return [head, ...traces[0].x.map((x, i) => [x, ...traces.map((trace) => trace.y[i])])];
  }
  const events = (drawing?.events ?? []).map(({ at, label }) => ['event', at, label]);
  const rows = [...traces.flatMap((trace) => trace.x.map((x, i) => [trace.name, x, trace.y[i]])), ...events];
  return [['curve', drawing?.x.label ?? 'x', traces[0]?.label ?? 'y'], ...rows];
}

function csv(drawing) {
  const cell = (value) => (typeof value === 'string' && /[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value ?? '');
  return table(drawing).map((row) => row.map(cell).join(',')).join('\n') + '\n';
}

function save(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: 'text/csv' }));
  link(url, name);
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

function link(url, name) {
  const anchor = document.createElement('a');
  anchor.href = url;
  anchor.download = name;
  anchor.click();
}
