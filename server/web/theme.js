// Before the first paint: the theme that was asked for in the address or chosen before.
(() => {
  const asked = new URLSearchParams(location.search).get('theme');
  let theme = asked;
  try { theme ??= localStorage.getItem('theme'); } catch { /* storage may be off */ }
  if (theme === 'light' || theme === 'dark') document.documentElement.dataset.theme = theme;
})();
