// Tabs: one panel at a time. Without this script all of them are shown, each under its heading.

/** Makes tabs of a list whose buttons name their panels (`aria-controls`). */
export function tabs(list) {
  const all = [...list.querySelectorAll('[role="tab"]')];
  const panel = (tab) => document.getElementById(tab.getAttribute('aria-controls'));
  const open = (chosen) => {
    for (const tab of all) {
      const isChosen = tab === chosen;
      tab.setAttribute('aria-selected', String(isChosen));
      tab.tabIndex = isChosen ? 0 : -1;
      panel(tab).hidden = !isChosen;
    }
    // Figures that were drawn out of sight fit their place now.
    dispatchEvent(new Event('resize'));
  };
  for (const tab of all) {
    const own = panel(tab);
    own.setAttribute('role', 'tabpanel');
    own.setAttribute('aria-labelledby', tab.id);
    own.querySelector('h2').hidden = true;
    tab.addEventListener('click', () => open(tab));
  }
  list.addEventListener('keydown', (event) => {
    const at = all.indexOf(document.activeElement);
    const next = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: all.length - 1 }[event.key];
    if (at < 0 || next === undefined) return;
    event.preventDefault();
    const tab = all[(next + all.length) % all.length];
    tab.focus();
    open(tab);
  });
  list.hidden = false;
  open(all[0]);
}

/** Opens the tab that an element is under, if any. */
export function openFor(element) {
  const own = element?.closest('[role="tabpanel"]');
  if (own?.hidden) document.getElementById(own.getAttribute('aria-labelledby')).click();
}
