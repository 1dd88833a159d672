// The preview of a ride that is about to be sent: what was understood of its files, and what is in the way.

import { offer } from './columns.js';
import { fill, learn } from './logs.js';
import { rough } from './number.js';
import { say } from './send.js';

/** Shows what the server makes of a ride, unless it is asked once more meanwhile. `fields` gives the form's fields, `changed`
 * is called after a choice of a column. */
export async function look(ride, fields, isLast, changed) {
  say(ride, 'reading …');
  ride.isRide = null;
  try {
    const ask = async () => {
      const response = await fetch('/v1/rides/preview', { method: 'POST', body: fill(fields(), ride) });
      return [response.ok, await response.json()];
    };
    let [isTable, answer] = await ask();
    // A layout and channels that were chosen for it now make another preview of it.
    for (let round = 0; round < 2 && isTable && isLast() && learn(ride, answer); round += 1) [isTable, answer] = await ask();
    if (!isLast()) return;
    if (!isTable) { say(ride, answer.detail, true); return; }
    learn(ride, answer);
    ride.isRide = answer.rate_hz !== null;
    offer(ride, answer, changed);
    describe(ride, answer);
  } catch {
    if (isLast()) say(ride, 'The preview could not be fetched.', true);
  }
}

/** Says what was understood of a ride. */
function describe(ride, answer) {
  const columns = answer.columns.map((c) => (c.header === c.channel ? `${c.channel} (${c.unit})` : `${c.channel} from ${c.header} (${c.unit})`));
  const isSingle = ride.files.length === 1;
  const parts = isSingle ? [answer.format] : [`${ride.files.length} files`];
  if (answer.rate_hz) parts.push(`${answer.duration_s.toFixed(1)} s at ${rough(answer.rate_hz)} Hz`);
  if (isSingle) parts.push(columns.join(', '));
  if (isSingle && answer.ignored.length) parts.push(`not used: ${answer.ignored.join(', ')}`);
  if (answer.gaps.length) parts.push(`${answer.gaps.length === 1 ? 'a gap' : `${answer.gaps.length} gaps, the first`} from ${answer.gaps[0].from_s.toFixed(2)} to ${answer.gaps[0].to_s.toFixed(2)} s`);
  if (answer.problem) say(ride, answer.problem, true);
  else say(ride, parts.join(' · '));
  for (const warning of [...answer.warnings].reverse()) note(ride, `Note: ${warning}`);
  for (const assumed of [...answer.reading ?? []].reverse()) note(ride, `Read: ${assumed}`);
}

function note(ride, text) {
  const line = document.createElement('p');
  line.className = 'note small';
  line.textContent = text;
  ride.said.after(line);
}
