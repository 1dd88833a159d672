// The columns of a ride that is about to be sent: each is given a channel by a drop-down. What the server guesses from a header is
// chosen beforehand and marked; a guess whose unit would not be read is only told.

const CHANNELS = {
  t: 'time', u_f: 'road, front', u_r: 'road, rear', z_f: 'displacement, front', z_r: 'displacement, rear',
  d_f: 'deflection, front', d_r: 'deflection, rear', a_f: 'acceleration, front', a_r: 'acceleration, rear',
  force_f: 'force, front', force_r: 'force, rear', v: 'speed', v_lat: 'lateral speed', cadence: 'cadence',
  roll: 'roll angle', steer: 'steering angle', yaw_rate: 'yaw rate',
};

/** The parts `map` of a ride. */
export function mapped(ride) {
  return [...ride.maps ?? []].map(([header, channel]) => `${channel}=${header}`);
}

/** Takes the first guesses over as choices; whether there were any, so that the preview is another one. */
export function guessed(ride, guesses) {
  if (ride.maps) return false;
  const read = guesses.filter((guess) => !guess.unread_unit);
  ride.maps = new Map(read.map(({ header, channel }) => [header, channel]));
  ride.guesses = new Map(guesses.map((guess) => [guess.header, guess]));
  return read.length > 0;
}

/** Shows a drop-down for each column; `changed` is called once another channel is chosen. */
export function offer(ride, answer, changed) {
  const own = new Map(answer.columns.map((column) => [column.header, column]));
  const headers = [...own.keys(), ...answer.ignored.filter((header) => !own.has(header))].sort();
  if (headers.join('\n') !== ride.headers) {
    ride.headers = headers.join('\n');
    ride.columns?.remove();
    ride.columns = table(ride, headers, own, changed);
    ride.item.append(ride.columns);
    ride.columns.open = ride.guesses.size > 0 || Boolean(answer.problem);
  }
  for (const row of ride.columns.querySelectorAll('.column')) describe(ride, row, own.get(row.dataset.header));
}

function table(ride, headers, own, changed) {
  const details = document.createElement('details');
  details.className = 'columns';
  details.innerHTML = '<summary>Columns</summary>';
  for (const header of headers) {
    const row = document.createElement('div');
    row.className = 'column';
    row.dataset.header = header;
    row.innerHTML = '<label></label><select></select><p class="hint"></p>';
    const select = row.querySelector('select');
    const label = row.querySelector('label');
    label.textContent = header;
    select.id = label.htmlFor = `column-${crypto.getRandomValues(new Uint32Array(1))[0]}`;
    const natural = ride.maps.has(header) ? null : own.get(header);
    select.append(new Option(natural ? `as its name says: ${CHANNELS[natural.channel]}` : 'not used', ''));
    for (const [channel, words] of Object.entries(CHANNELS)) select.append(new Option(`${channel} – ${words}`, channel));
    select.value = ride.maps.get(header) ?? '';
    select.addEventListener('change', (event) => {
      event.stopPropagation();
      if (select.value) ride.maps.set(header, select.value);
      else ride.maps.delete(header);
      ride.guesses.delete(header);
      changed();
    });
    details.append(row);
  }
  return details;
}

/** What is said below a column: how it is read, and that it is a guess. */
function describe(ride, row, column) {
  const guess = ride.guesses.get(row.dataset.header);
  const said = [];
  if (guess?.unread_unit) {
    said.push(`Perhaps ${CHANNELS[guess.channel]}, but “${guess.unread_unit}” is not read there and SI would be assumed: write [${guess.unread_unit}] in the file's header.`);
  } else if (guess) said.push('Guessed from the header: please check.');
  if (column) said.push(`Read in ${column.unit}.`);
  row.querySelector('.hint').textContent = said.join(' ');
}
