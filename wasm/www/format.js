// Numbers for people.

export const grouped = (n) => Math.round(n).toLocaleString('en-US').replaceAll(',', '\u2009');

export function bytes(n) {
  for (const unit of ['B', 'KiB', 'MiB']) {
    if (n < 1024) return `${unit === 'B' ? n : digits(n)} ${unit}`;
    n /= 1024;
  }
  return `${digits(n)} GiB`;
}

export const time = (ms) => (ms < 1000 ? `${digits(ms)} ms` : `${digits(ms / 1000)} s`);

// Three of them.
export const digits = (x) => {
  if (x === 0) return '0';
  const shown = Number(x.toPrecision(3));
  return Math.abs(shown) < 1e-4 || Math.abs(shown) >= 1e6 ? shown.toExponential(1) : String(shown);
};

export function rate(perSecond) {
  return perSecond < 1e6 ? `${digits(perSecond / 1e3)} k/s` : `${digits(perSecond / 1e6)} M/s`;
}
