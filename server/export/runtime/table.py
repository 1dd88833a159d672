

def read(file):
    """Columns of a table, as text, by their headers: separator , ; or tab; lines with # do not count."""
    try:
        with open(file, encoding="utf-8-sig") as lines:
            lines = [line.rstrip("\r\n") for line in lines if line.strip() and not line.startswith("#")]
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f"{file}: {error}")
    if not lines:
        sys.exit(f"{file}: no table")
    separator = max(",;\t", key=lines[0].count)
    rows = [line.split(separator) for line in lines]
    columns = zip(*(row for row in rows if len(row) == len(rows[0])))
    return {cells[0].strip().strip('"'): cells[1:] for cells in columns}


def number(cell):
    try:
        return float(cell.strip().replace(",", "."))
    except ValueError:
        return np.nan


class Ride:
    """A ride on even samples; its own rows, or those between two times (s) where they are as many as the model's."""

    def __init__(self, file, part=None):
        self.table = read(file)
        self.as_read = "veloid_sample" in self.table
        t = self.column("t")
        self.rows = np.isfinite(t)
        if part is not None and not self.as_read:
            within = self.rows & (t > part[0] - 1e-9) & (t < part[1] + 1e-9)
            self.rows = within if np.sum(within) == SAMPLES else self.rows
        self.recorded = t = t[self.rows]
        n, steps = len(t), np.diff(t)
        if n < 10 or np.min(steps) <= 0 or t[-1] - t[0] > 10 * n * np.median(steps):
            sys.exit("A ride needs 10 samples or more whose times increase, most of them without a gap")
        self.t, self.step = t, (t[-1] - t[0]) / (n - 1)
        # Even stamps are off by what printing them rounds.
        digit = next((10.0**-d for d in range(9) if np.all(np.abs(t * 10**d - np.round(t * 10**d)) < 1e-3)), 1e-9)
        off = np.max(np.abs(t - np.linspace(t[0], t[-1], n)))
        self.is_even = off < max(1e-4 * self.step, min(4 / 3 * digit, 0.4 * self.step))
        if not self.is_even:
            self.step = np.median(steps)
            self.t = t[0] + self.step * np.arange(int((t[-1] - t[0]) / self.step + 1e-6) + 1)
        self.samples = len(self.t)
        self.bicycle = self.moved()

    def header(self, name):
        """Header of a channel's column, and the factor that makes it SI."""
        return (name, 1.0) if self.as_read else CHANNELS.get(name, (name, 1.0))

    def column(self, name):
        header, scale = self.header(name)
        if header not in self.table:
            sys.exit(f'There is no column for {name}: expected the header "{header}". This takes {TAKES}.')
        return scale * np.array([number(cell) for cell in self.table[header]])

    def channel(self, name):
        """A channel on even samples in SI units, blanks filled along straight lines, and where it was recorded."""
        at, x = self.recorded, self.column(name)[self.rows]
        known = np.isfinite(x)
        if not np.any(known):
            sys.exit(f"The column for {name} has no numbers")
        x = np.interp(at, at[known], x[known])
        if not self.is_even:
            place = np.interp(self.t, at, np.arange(len(at)))
            row = np.minimum((place + 1e-9).astype(int), len(at) - 2)
            # As veloid does, longer gaps are bridged straight.
            gap = np.diff(at)[row] > 4 * self.step
            x = np.where(gap, np.interp(self.t, at, x), CubicSpline(at, x)(self.t))
            nearest = (place + 0.5).astype(int)
            known = known[nearest] & (np.abs(self.t - at[nearest]) < 2 / 3 * self.step)
        if name in CENTRED and not self.as_read:
            x = x - np.mean(x)
        return x, known

    def moved(self):
        """Speed (m/s), its rate (m/s^2), angle of the crank (rad) and distance (m) at the samples."""
        none = np.zeros(self.samples)

        def integral(y):
            return np.concatenate([[0.0], np.cumsum(0.5 * self.step * (y[1:] + y[:-1]))])

        speed = self.channel("v")[0] if "v" in NEEDED else none
        cadence = self.channel("cadence")[0] if "cadence" in NEEDED else none
        rate = none
        if "speed_rate" in NEEDED and self.as_read:
            rate = self.channel("speed_rate")[0]
        elif "speed_rate" in NEEDED:
            # Over half a second: a speed is noisy, and riders brake for longer.
            v = self.channel("v")[0]
            rate = (np.interp(self.t + 0.25, self.t, v) - np.interp(self.t - 0.25, self.t, v)) / 0.5
        return speed, rate, integral(cadence) * pi / 30, integral(speed)
