// On every page: the theme switch, and ages that stay true.

const dark = () => {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
};

const button = document.querySelector('#theme');
button.hidden = false;
button.addEventListener('click', () => {
  const theme = dark() ? 'light' : 'dark';
  document.documentElement.dataset.theme = theme;
  try { localStorage.setItem('theme', theme); } catch { /* storage may be off */ }
  document.dispatchEvent(new Event('theme'));
});

const units = [[86400, 'day'], [3600, 'hour'], [60, 'minute'], [1, 'second']];
const words = new Intl.RelativeTimeFormat('en', { numeric: 'auto' });

function showAges() {
  for (const time of document.querySelectorAll('time[data-age]')) {
    const seconds = (Date.parse(time.dateTime) - Date.now()) / 1000;
    const [size, unit] = units.find(([size]) => Math.abs(seconds) >= size) ?? units.at(-1);
    time.textContent = words.format(Math.round(seconds / size), unit);
    time.title = time.dateTime;
  }
}

showAges();
setInterval(showAges, 15000);

// Tables wider than the page scroll, by keyboard too.
const sizes = new ResizeObserver((entries) => {
  for (const { target } of entries) {
    if (target.scrollWidth > target.clientWidth) {
      target.tabIndex = 0;
      target.setAttribute('role', 'group');
      target.setAttribute('aria-label', 'Table, scrolls sideways');
    } else {
      for (const name of ['tabindex', 'role', 'aria-label']) target.removeAttribute(name);
    }
  }
});
document.querySelectorAll('.scroll').forEach((element) => sizes.observe(element));

// Filters fold on narrow screens, and say how many are set.
const narrow = matchMedia('(max-width: 40rem)');
const filters = document.querySelectorAll('details.fold');
const asides = ['theme', 'cursor', 'sort', 'order', 'deleted'];
const active = [...new URLSearchParams(location.search)].filter(([name, value]) => value && !asides.includes(name)).length;
const fold = () => filters.forEach((element) => { element.open = !narrow.matches; });
if (active) filters.forEach((element) => { element.querySelector('summary').textContent += ` (${active} active)`; });
fold();
narrow.addEventListener('change', fold);
