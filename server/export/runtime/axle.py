

def cubics(values, slopes):
    """For each sample the coefficients of the cubic to the next, with these slopes for each sample, its place in it from 0 to 1."""
    d, a, b = np.diff(values), slopes[:-1], slopes[1:]
    return np.array([values, slopes, np.append(3 * d - 2 * a - b, 0), np.append(a + b - 2 * d, 0)]).T.tolist()


def spline_slopes(values):
    at = np.arange(len(values))
    return CubicSpline(at, values)(at, 1)


class Axle:
    """An axle's inputs, its measurement and its model; `own` where the ride is to be the model's."""

    def __init__(self, ride, name, model, own):
        self.ride, self.name, self.model = ride, name, model
        self.unit = "N" if model["prescribed"] else "m"
        letter, none = name[0], np.zeros(ride.samples)
        road = ride.channel("u_" + letter)[0] if model["road"] else none
        push = ride.channel("force_" + letter)[0] if model["force"] else none
        self.measured, known = None, none > 0
        if model["prescribed"]:
            road, push = ride.channel("z_" + letter)[0], none
            self.measured, known = ride.channel("force_" + letter)
            # Whether the force was logged as a reaction.
            if np.sum(np.diff(road) * (self.measured[1:] + self.measured[:-1])) < 0:
                self.measured = -self.measured
        elif not NEEDS_ROAD or ride.header("z_" + letter)[0] in ride.table:
            self.measured, known = ride.channel("z_" + letter)
        if not model["prescribed"]:
            road, push = lifted(road), lifted(push)
        slopes = spline_slopes(road)
        if model.get("read_road"):
            road, slopes = read_road(ride, model["read_road"], road, slopes)
        self.road = cubics(road, slopes)
        self.push = cubics(push, spline_slopes(push))
        i = np.arange(ride.samples)
        if own:
            self.counts = known & (i >= HELD_OUT[0]) & (i < HELD_OUT[1])
            for begin, end in model["left_out"]:
                self.counts[begin:end] = False
            self.fitted_to = self.counts
        else:
            start = model["start_s"]
            if start is None:
                self.fitted_to, self.counts = known, known
            else:
                first = i < np.argmax(known) + min(start / ride.step, ride.samples / 4)
                self.fitted_to, self.counts = known & first, known & ~first

    def is_measured_so(self):
        """Whether the measurement is the one that the model was fitted to, as far as that is known."""
        rms = self.model.get("measured_rms")
        return rms is None or abs(np.sqrt(np.mean(self.measured[self.counts] ** 2)) - rms) <= 1e-6 * rms

    def error(self, predicted):
        return np.sqrt(np.mean((self.measured - predicted)[self.counts] ** 2))
