
# Each improvement of the start squares what its error is of its size.
ROUNDS = 4


def sensed(ride, model, motion):
    """What the sensor reads of displacement, velocity and acceleration at the samples."""
    sharp = [m[2 if model["prescribed"] else 0] for m in motion]
    how = model["sensor"]
    if how is None:
        return np.array(sharp)
    out, before = [], None
    for i in range(len(motion)):
        delay, gain, offset, lag = how(i * ride.step)
        reading = sharp[i] if delay == 0 else earlier(motion, ride.step, i - delay / ride.step)
        prompt = gain * reading + offset
        late = prompt
        if before is not None and lag > 0:
            kept, behind = exp(-ride.step / lag), (prompt - before[0]) * lag / ride.step
            late = prompt - behind + (before[1] - before[0] + behind) * kept
        out.append(late)
        before = prompt, late
    return np.array(out)


def earlier(motion, h, position):
    """The displacement between samples, from displacement, velocity and acceleration at them."""
    last = len(motion) - 1
    if position < 0 or position > last:
        z, v, a = motion[0 if position < 0 else last]
        beyond = h * (position if position < 0 else position - last)
        return z + beyond * (v + 0.5 * beyond * a)
    i = min(int(position), last - 1)
    s = position - i
    (z0, v0, a0), (z1, v1, a1) = ((z, v * h, a * h * h) for z, v, a in (motion[i], motion[i + 1]))
    d, e, f = z1 - z0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0
    high = (10 * d - 4 * e + 0.5 * f, -15 * d + 7 * e - f, 6 * d - 3 * e + 0.5 * f)
    return z0 + s * (v0 + s * (0.5 * a0 + s * (high[0] + s * (high[1] + s * high[2]))))


def rates(axles, lines, offsets, i, s, h, x):
    """Acceleration of each axle and rates of its states, at the part s of the interval after sample i."""
    out = []
    step = axles[0].ride.step
    speed, speed_rate, crank, distance = (line[i][0] + s * line[i][1] for line in lines)
    for axle, (lift, more), own in zip(axles, offsets, x):
        u, f = axle.road[i], axle.push[i]
        road = lift + u[0] + s * (u[1] + s * (u[2] + s * u[3]))
        slope = (u[1] + s * (2 * u[2] + s * 3 * u[3])) / step
        push = more + f[0] + s * (f[1] + s * (f[2] + s * f[3]))
        t = (i + s) * step
        out.append(axle.model["rates"](t, h, road, slope, push, speed, speed_rate, crank, distance, own))
    if PITCH is not None and len(axles) == 2:
        q, l_f, l_r, m_f, m_r = PITCH
        total = m_f + m_r
        front, rear = m_f * out[0][0], m_r * out[1][0]
        pushed = [
            front * ((1 + q) * l_f / l_r / total + 1 / total) - rear * q / total,
            rear * ((1 + q) * l_r / l_f / total + 1 / total) - front * q / total,
        ]
        out = [(a, [own[0], a] + own[2:]) for a, (_, own) in zip(pushed, out)]
    return out


def ahead(x, rate, h):
    return [[a + h * b for a, b in zip(own, of)] for own, (_, of) in zip(x, rate)]


def predict(axles, starts, samples):
    """What is measured at the first samples of axles that move together, by Runge-Kutta's method; without starts from the report's."""
    ride, models = axles[0].ride, [axle.model for axle in axles]
    steps = ceil(ride.step * max(model["steps"] for model in models) / STEP - 1e-3)
    h = ride.step / steps
    x, offsets = [model["start"] for model in models], [(0.0, 0.0) for _ in models]
    if starts is not None:
        x = [[(0.0, z, v)[q] for q in model["follows"]] for model, (z, v, _) in zip(models, starts)]
        # A constant force moves the place where an axle rests, from which laws may count.
        offsets = [(c / model["rests_on"], 0.0) if model["rests_on"] else (0.0, c) for model, (_, _, c) in zip(models, starts)]
    lines = [np.array([y, np.append(np.diff(y), 0)]).T.tolist() for y in ride.bicycle]
    motions = [[] for _ in axles]
    for i in range(samples):
        a = rates(axles, lines, offsets, i, 0.0, h, x)
        for motion, own, (acceleration, _) in zip(motions, x, a):
            motion.append((own[0], own[1], acceleration))
        if i == samples - 1:
            break
        for step in range(steps):
            s, half = step / steps, 0.5 / steps
            if step:
                a = rates(axles, lines, offsets, i, s, h, x)
            b = rates(axles, lines, offsets, i, s + half, h, ahead(x, a, 0.5 * h))
            c = rates(axles, lines, offsets, i, s + half, h, ahead(x, b, 0.5 * h))
            d = rates(axles, lines, offsets, i, s + 2 * half, h, ahead(x, c, h))
            x = [
                [q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4) for q, k1, k2, k3, k4 in zip(own, *of)]
                for own, *of in zip(x, *([r for _, r in rate] for rate in (a, b, c, d)))
            ]
    return [sensed(ride, model, motion) for model, motion in zip(models, motions)]


def sign(x):
    return (x > 0) - (x < 0)


def above_zero(x):
    return 1.0 if x > 0 else 0.0
