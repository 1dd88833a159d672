// The page of one job: live while it runs, figures once its report is there.

import { Figure } from './plot.js';
import { follow } from './live.js';
import { drawAll } from './figures.js';
import { measured } from './number.js';
import { openFor, tabs } from './tabs.js';

const about = document.querySelector('#job').dataset;

if ('report' in about) {
  const list = document.querySelector('#inside [role="tablist"]');
  if (list) tabs(list);
  drawAll(about.job);
  reveal();
  addEventListener('hashchange', reveal);
  const print = document.querySelector('#print');
  print.hidden = false;
  print.addEventListener('click', () => window.print());
} else if (about.state === 'queued' || about.state === 'running') {
  watch();
}

/** Opens the part that the address names. */
function reveal() {
  const part = document.getElementById(location.hash.slice(1));
  openFor(part);
  if (part instanceof HTMLDetailsElement) part.open = true;
}

function watch() {
  const curves = new Map();
  const host = document.querySelector('#live');
  const figure = new Figure(host, () => ({
    hover: 'closest',
    x: { label: 'iteration' },
    panels: [{
      label: 'best cost', log: true,
      traces: [...curves].sort(([a], [b]) => a - b).map(([trial, costs]) => ({
        name: `trial ${trial + 1}`, x: costs.map((_, i) => i + 1), y: costs, legend: false,
        ink: 'series-swarm', width: 1.3,
      })),
    }],
  }), { eager: true });
  let due = 0;
  const redraw = () => {
    due ||= setTimeout(() => { due = 0; figure.refresh(); }, 250);
  };

  const show = (job) => {
    document.querySelector('#progress').value = 100 * job.progress;
    document.querySelector('#said').textContent = job.state === 'queued' ? 'waiting for a free worker'
      : `${job.trials.done} of ${job.trials.total} swarm trials done`;
    const state = document.querySelector('#state');
    state.className = `state ${job.state}`;
    state.textContent = job.state;
    const stages = [...document.querySelectorAll('#stages li')];
    const now = stages.findIndex((stage) => stage.dataset.stage === job.stage);
    stages.forEach((stage, i) => {
      stage.className = i < now ? 'done' : i === now && job.state === 'running' ? 'now' : '';
    });
    if (job.least_squares) showEarly(job.least_squares);
  };

  const searched = ({ steps, budget }) => {
    const share = Math.min(100, Math.round(100 * steps / budget));
    document.querySelector('#said').textContent = `searching for missing physics: ${share} % of the steps it may take`;
  };

  follow(about.job, {
    snapshot({ job, trials, searched: known }) {
      curves.clear();
      for (const { trial, best_cost: costs } of trials) if (costs.length) curves.set(trial, costs);
      host.hidden = curves.size === 0;
      show(job);
      if (known) searched(known);
      redraw();
    },
    iteration({ trial, iteration, best_cost: cost }) {
      if (!curves.has(trial)) curves.set(trial, []);
      curves.get(trial)[iteration] = cost;
      host.hidden = false;
      redraw();
    },
    searched,
    stage: show,
    done() { location.reload(); },
  });
}

/** The same table as the server renders, as soon as there is something to put into it. */
function showEarly(estimates) {
  const section = document.querySelector('#early');
  if (!section.hidden) return;
  const body = section.querySelector('tbody');
  const unknown = (error) => (error === null ? ', not identifiable' : '');
  for (const axle of ['front', 'rear']) {
    const found = estimates[axle];
    if (!found) continue;
    const row = body.insertRow();
    const head = document.createElement('th');
    head.scope = 'row';
    head.textContent = axle;
    row.append(head);
    for (const text of [
      `${measured(found.k_n_m, found.k_std_n_m)} N/m${unknown(found.k_std_n_m)}`,
      `${measured(found.b_n_s_m, found.b_std_n_s_m)} N s/m${unknown(found.b_std_n_s_m)}`,
    ]) {
      const cell = row.insertCell();
      cell.className = 'number';
      cell.textContent = text;
    }
  }
  section.hidden = false;
}
