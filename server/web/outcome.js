// What pressing the button came to: shown where it belongs, in view and with the focus, and repeated beside the button.

const place = document.querySelector('#outcome');

/** Leads to `element`, which says what happened, and repeats `nodes` beside the button. */
export function lead(element, isFault, ...nodes) {
  const said = document.createElement('span');
  said.className = isFault ? 'fault' : '';
  said.append(...nodes);
  place.replaceChildren(said);
  if (!element) return;
  if (!element.matches('a, button, input, select, textarea')) element.tabIndex = -1;
  element.focus({ preventScroll: true });
  element.scrollIntoView({ block: 'center' });
}

export function clear() {
  place.replaceChildren();
}
