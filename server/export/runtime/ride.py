

def integral(y):
    return np.concatenate([[0.0], np.cumsum(0.5 * STEP * (y[1:] + y[:-1]))])


def cubics(values, slopes):
    """For each sample interval the coefficients of the cubic with these ends, its place in it from 0 to 1."""
    d, a, b = np.diff(values), STEP * slopes[:-1], STEP * slopes[1:]
    return list(zip(*(c.tolist() for c in (values[:-1], a, 3 * d - 2 * a - b, a + b - 2 * d))))


def lines(values):
    return list(zip(values[:-1].tolist(), np.diff(values).tolist()))


def spline_slopes(values):
    at = STEP * np.arange(len(values))
    return CubicSpline(at, values)(at, 1)


class Ride:
    """What was recorded, on the samples that the model was fitted on."""

    def __init__(self, file):
        self.table = table = read(file)
        self.used = np.ones(len(channel(table, "t")), bool)
        if "veloid_sample" not in table and PART is not None:
            t = channel(table, "t")
            self.used = (t > PART[0] - 1e-9) & (t < PART[1] + 1e-9)
        t = self["t"]
        even = len(t) == SAMPLES and abs((t[-1] - t[0]) / (SAMPLES - 1) / STEP - 1) < 1e-6
        if not even:
            sys.exit(f"This is not the ride on the samples that the model was fitted on: this needs {AS_READ}")
        self.t = t
        self.speed = self["v"] if "v" in NEEDED else np.zeros(SAMPLES)
        self.speed_rate = self["speed_rate"] if "speed_rate" in NEEDED else np.zeros(SAMPLES)
        self.crank = integral(self["cadence"]) * pi / 30 if "cadence" in NEEDED else np.zeros(SAMPLES)
        self.distance = integral(self.speed)
        self.by_lines = list(
            zip(*(lines(x) for x in (self.speed, self.speed_rate, self.crank, self.distance)))
        )

    def __getitem__(self, name):
        values = channel(self.table, name)[self.used]
        centred = name in CENTRED and "veloid_sample" not in self.table
        return values - np.mean(values) if centred else values


class Axle:
    """An axle's inputs, its measurement and its model."""

    def __init__(self, ride, name, model):
        letter = name[0]
        self.ride, self.name, self.model = ride, name, model
        self.report, self.unit = model["report"], "N" if model["prescribed"] else "m"
        self.measured = ride["z_" + letter]
        road = ride["u_" + letter] if model["road"] else np.zeros(SAMPLES)
        push = ride["force_" + letter] if model["force"] else np.zeros(SAMPLES)
        if model["prescribed"]:
            road = self.measured
            self.measured = ride["force_" + letter]
            # Whether the force was logged as a reaction.
            if np.sum(np.diff(road) * (self.measured[1:] + self.measured[:-1])) < 0:
                self.measured = -self.measured
            push = np.zeros(SAMPLES)
        if not model["prescribed"]:
            road, push = lifted(road), lifted(push)
        self.road = cubics(*self.read_road(road, spline_slopes(road)))
        self.push = cubics(push, spline_slopes(push))
        self.start = model["start"]
        self.steps = model["steps"]
        self.rates = model["rates"]
        self.counts = np.zeros(SAMPLES, bool)
        self.counts[HELD_OUT[0] : HELD_OUT[1]] = True
        for begin, end in model["left_out"]:
            self.counts[begin:end] = False
        found = sqrt(np.mean(self.measured[self.counts] ** 2))
        if not abs(found - model["measured_rms"]) <= 1e-6 * model["measured_rms"]:
            sys.exit(f"The {name} axle was not measured so where the model is from: this needs {AS_READ}")

    def read_road(self, values, slopes):
        """Heights and slopes as the effects have them."""
        how = self.model["read_road"]
        if how is None:
            return values, slopes
        pieces = cubics(values, slopes)
        area = [STEP * (c[0] + c[1] / 2 + c[2] / 3 + c[3] / 4) for c in pieces]
        area = np.concatenate([[0.0], np.cumsum(area)]).tolist()
        last = SAMPLES - 1

        def place(position):
            position = min(max(position, 0.0), float(last))
            i = min(int(position), last - 1)
            return i, position - i, pieces[i]

        def height(position):
            i, s, c = place(position)
            return c[0] + s * (c[1] + s * (c[2] + s * c[3]))

        def slope(position):
            i, s, c = place(position)
            return (c[1] + s * (2 * c[2] + s * 3 * c[3])) / STEP

        def integrated(position):
            i, s, c = place(position)
            return area[i] + STEP * s * (c[0] + s * (c[1] / 2 + s * (c[2] / 3 + s * c[3] / 4)))

        heights, rates = np.array(values), np.array(slopes)
        speed, distance = self.ride.speed.tolist(), self.ride.distance.tolist()
        for i in range(SAMPLES):
            shift, half_window, more, more_rate = how(speed[i], distance[i])
            if shift or half_window:
                centre = i - shift / STEP
                inside = min(max(centre, 0.0), float(last))
                half = min(half_window / STEP, inside, last - inside)
                if half < 1e-6:
                    heights[i], rates[i] = height(centre), slope(centre)
                else:
                    width = 2 * half * STEP
                    heights[i] = (integrated(centre + half) - integrated(centre - half)) / width
                    rates[i] = (height(centre + half) - height(centre - half)) / width
            heights[i] += more
            rates[i] += more_rate
        return heights, rates
