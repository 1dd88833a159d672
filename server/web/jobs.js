// The list of jobs: two to eight can be compared; running ones are looked after.

const form = document.querySelector('#compare');
const boxes = [...document.querySelectorAll('input[name=job]')];
const button = document.querySelector('#chosen');

function allow() {
  const chosen = boxes.filter((box) => box.checked).length;
  button.disabled = chosen < 2 || chosen > 8;
  button.textContent = chosen > 8 ? 'Compare at most eight' : chosen < 2 ? 'Choose two to eight to compare' : `Compare ${chosen}`;
}

if (form) {
  boxes.forEach((box) => box.addEventListener('change', allow));
  addEventListener('pageshow', allow);
  allow();
}

if (document.querySelector('.state.running, .state.queued')) {
  setInterval(async () => {
    if (document.hidden || boxes.some((box) => box.checked)) return;
    const response = await fetch(location.href);
    if (!response.ok) return;
    const fresh = new DOMParser().parseFromString(await response.text(), 'text/html').querySelector('tbody');
    const old = document.querySelector('tbody');
    if (fresh && fresh.innerHTML !== old.innerHTML) location.reload();
  }, 3000);
}
