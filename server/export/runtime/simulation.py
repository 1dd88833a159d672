

def sensed(model, motion):
    """What the sensor reads of displacement, velocity and acceleration at the samples."""
    sharp = [m[2 if model["prescribed"] else 0] for m in motion]
    how = model["sensor"]
    if how is None:
        return np.array(sharp)
    out, before = [], None
    for i in range(SAMPLES):
        delay, gain, offset, lag = how(i * STEP)
        reading = sharp[i] if delay == 0 else earlier(motion, i - delay / STEP)
        prompt = gain * reading + offset
        late = prompt
        if before is not None and lag > 0:
            kept, behind = exp(-STEP / lag), (prompt - before[0]) * lag / STEP
            late = prompt - behind + (before[1] - before[0] + behind) * kept
        out.append(late)
        before = prompt, late
    return np.array(out)


def earlier(motion, position):
    """The displacement between samples, from displacement, velocity and acceleration at them."""
    last = len(motion) - 1
    if position < 0 or position > last:
        z, v, a = motion[0 if position < 0 else last]
        beyond = STEP * (position if position < 0 else position - last)
        return z + beyond * (v + 0.5 * beyond * a)
    i = min(int(position), last - 1)
    s = position - i
    (z0, v0, a0), (z1, v1, a1) = (
        (z, v * STEP, a * STEP * STEP) for z, v, a in (motion[i], motion[i + 1])
    )
    d, e, f = z1 - z0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0
    high = (10 * d - 4 * e + 0.5 * f, -15 * d + 7 * e - f, 6 * d - 3 * e + 0.5 * f)
    return z0 + s * (v0 + s * (0.5 * a0 + s * (high[0] + s * (high[1] + s * high[2]))))


def rates(axles, i, s, h, x):
    """Acceleration of each axle and rates of its states, at the part s of the interval after sample i."""
    out = []
    speed, speed_rate, crank, distance = (c[0] + s * c[1] for c in axles[0].ride.by_lines[i])
    for axle, own in zip(axles, x):
        u, f = axle.road[i], axle.push[i]
        road = u[0] + s * (u[1] + s * (u[2] + s * u[3]))
        slope = (u[1] + s * (2 * u[2] + s * 3 * u[3])) / STEP
        push = f[0] + s * (f[1] + s * (f[2] + s * f[3]))
        t = (i + s) * STEP
        out.append(axle.rates(t, h, road, slope, push, speed, speed_rate, crank, distance, own))
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


def simulate(axles):
    """Displacement, velocity and acceleration at every sample of axles that move together (Runge-Kutta)."""
    steps = max(axle.steps for axle in axles)
    h = STEP / steps
    x = [axle.start for axle in axles]
    motions = [[] for _ in axles]
    for i in range(SAMPLES):
        is_last = i == SAMPLES - 1
        a = rates(axles, i - 1, 1.0, h, x) if is_last else rates(axles, i, 0.0, h, x)
        for motion, own, (acceleration, _) in zip(motions, x, a):
            motion.append((own[0], own[1], acceleration))
        if is_last:
            return motions
        for step in range(steps):
            s, half = step / steps, 0.5 / steps
            if step:
                a = rates(axles, i, s, h, x)
            b = rates(axles, i, s + half, h, ahead(x, a, 0.5 * h))
            c = rates(axles, i, s + half, h, ahead(x, b, 0.5 * h))
            d = rates(axles, i, s + 2 * half, h, ahead(x, c, h))
            x = [
                [q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4) for q, k1, k2, k3, k4 in zip(own, *of)]
                for own, *of in zip(x, *([r for _, r in rate] for rate in (a, b, c, d)))
            ]


def sign(x):
    return (x > 0) - (x < 0)


def above_zero(x):
    return 1.0 if x > 0 else 0.0


def main(file):
    """Times (s), and by axle what the model predicts (m; N where a rig prescribes the motion)."""
    ride = Ride(file)
    axles = [Axle(ride, name, model) for name, model in MODELS.items()]
    together = [axles] if PITCH is not None else [[axle] for axle in axles]
    predicted = {}
    for group in together:
        for axle, motion in zip(group, simulate(group)):
            predicted[axle.name] = sensed(axle.model, motion)
            left = axle.measured - predicted[axle.name]
            error = sqrt(np.mean(left[axle.counts] ** 2))
            print(f"{axle.name}: held-out error {error:.6g} {axle.unit}, {axle.report}")
    return ride.t, predicted


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else FILE)
