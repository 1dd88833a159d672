// Sends a ride of the upload form, shows its progress, and follows its job to the end.

import { fill, remember } from './logs.js';
import { running, watch } from './live.js';

const STAGES = { observe: 'observer and least squares', trial: 'particle swarm', conclude: 'output error', diagnose: 'diagnosis' };

/** Says where a ride stands, in place of what was said of it before. */
export function say(ride, text, isFault = false) {
  ride.item.querySelectorAll('.note').forEach((element) => element.remove());
  ride.said.textContent = text;
  ride.said.className = isFault ? 'fault' : 'quiet small';
}

/** Sends one ride with the fields of the form: its job, or the problem if it was refused. */
export function send(ride, body) {
  ride.sent = true;
  const bar = document.createElement('progress');
  bar.max = ride.files.reduce((sum, file) => sum + file.size, 0);
  bar.value = 0;
  bar.setAttribute('aria-label', `Upload of ${ride.name}`);
  say(ride, 'sending …');
  ride.said.after(bar);
  return new Promise((resolve) => {
    const request = new XMLHttpRequest();
    ride.request = request;
    request.upload.addEventListener('progress', (event) => { bar.value = event.loaded; });
    request.addEventListener('loadend', () => {
      bar.remove();
      const answer = parse(request.responseText);
      if (request.status === 202) {
        ride.job = answer;
        ride.known = request.getResponseHeader('Veloid-Known') === 'true';
        ride.item.querySelector('button').remove();
        ride.columns?.remove();
        remember(ride);
        ride.said.className = '';
        show(ride, answer);
        watch(answer.links.job, (job) => show(ride, job));
        resolve({ job: answer });
        return;
      }
      ride.sent = false;
      const problem = answer?.detail ? answer : { detail: 'The upload did not reach the server.' };
      say(ride, problem.detail, true);
      resolve({ problem });
    });
    request.open('POST', '/v1/rides');
    request.send(fill(body, ride));
  });
}

/** Where the job of a ride stands. */
function show(ride, job) {
  const said = {
    queued: 'queued', running: STAGES[job.stage], failed: `failed: ${job.failure?.detail}`, cancelled: 'cancelled',
    succeeded: job.verdict?.replaceAll('_', ' ') ?? 'done',
  }[job.state];
  const text = `${job.state} ${said}`;
  if (ride.shown !== text) {
    ride.shown = text;
    const state = document.createElement('span');
    state.className = `state ${job.state}`;
    state.textContent = said;
    const link = document.createElement('a');
    link.href = job.links.page;
    link.textContent = job.state === 'succeeded' ? 'see the result' : running(job) ? 'follow the identification' : 'see the job';
    link.setAttribute('aria-label', `${ride.name}: ${link.textContent}`);
    const known = !ride.known ? [] : [job.state === 'succeeded' ? ' · this ride was identified before' : ' · this ride was sent before'];
    ride.said.replaceChildren(state, ...known, ' · ', link);
  }
  let bar = ride.item.querySelector('progress');
  if (!running(job)) { bar?.remove(); return; }
  if (!bar) {
    bar = document.createElement('progress');
    bar.setAttribute('aria-label', `Identification of ${ride.name}`);
    ride.item.append(bar);
  }
  bar.value = job.progress;
}

function parse(text) {
  try { return JSON.parse(text); } catch { return null; }
}
