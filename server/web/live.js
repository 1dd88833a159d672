// Follows a running job: by server-sent events, or, where none arrive, by polling with its ETag. Many jobs
// are asked after in turn: a stream for each would take up the few connections that a browser has.

export const running = (job) => ['queued', 'running'].includes(job.state);

/** Calls `on.snapshot`, `on.iteration`, `on.searched`, `on.stage`, `on.done` as the job moves. */
export function follow(job, on) {
  const source = new EventSource(`${job}/events`);
  let heard = false;
  let ended = false;
  const listen = (name) => source.addEventListener(name, (event) => {
    heard = true;
    if (name === 'done') { ended = true; source.close(); }
    on[name]?.(JSON.parse(event.data));
  });
  ['snapshot', 'iteration', 'searched', 'stage', 'done'].forEach(listen);
  const fall = () => {
    if (ended) return;
    ended = true;
    source.close();
    poll(job, on);
  };
  // The browser reconnects by itself, with Last-Event-ID, unless the answer was no stream at all.
  source.addEventListener('error', () => { if (source.readyState === EventSource.CLOSED) fall(); });
  // A proxy that holds events back is as good as none.
  setTimeout(() => { if (!heard) fall(); }, 6000);
}

async function poll(job, on) {
  const known = { etag: null };
  for (;;) {
    try {
      const response = await ask(`${job}?wait=20`, known);
      if (response.status === 200) {
        const view = await response.json();
        if (!running(view)) { on.done?.(view); return; }
        on.stage?.(view);
        const trials = await (await fetch(view.links.trials)).json();
        on.snapshot?.({
          job: view,
          trials: trials.items.map((trial) => ({ trial: trial.index, best_cost: trial.result?.best_cost ?? [], done: Boolean(trial.result) })),
        });
      } else if (response.status !== 304) {
        await pause(2000);
      }
    } catch {
      await pause(2000);
    }
  }
}

/** Asks for what has changed since the answer whose ETag is `known`. */
async function ask(address, known) {
  const headers = known.etag ? { 'If-None-Match': known.etag } : {};
  const response = await fetch(address, { headers, cache: 'no-store' });
  if (response.status === 200) known.etag = response.headers.get('ETag');
  return response;
}

const watched = new Map();
/** Time between two rounds of asking (ms). */
const ROUND = 1000;

/** Calls `show` with the job whenever it has changed, to its end. Several may watch one job: the same ride sent twice. */
export function watch(job, show) {
  const idle = watched.size === 0;
  // A round may be asking after this job just now: it has to find whoever has joined.
  const known = watched.get(job) ?? { shows: [] };
  known.shows.push(show);
  known.etag = null;
  watched.set(job, known);
  if (idle) round();
}

async function round() {
  while (watched.size) {
    await pause(ROUND);
    for (const [job, known] of watched) {
      try {
        const response = await ask(job, known);
        if (response.status === 200) {
          const view = await response.json();
          for (const show of known.shows) show(view);
          if (!running(view)) watched.delete(job);
        } else if (response.status === 404) {
          watched.delete(job);
        } else if (response.status !== 304) {
          await pause(2 * ROUND);
        }
      } catch {
        await pause(2 * ROUND);
      }
    }
  }
}

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
