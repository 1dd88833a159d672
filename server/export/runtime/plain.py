

def first(table, names):
    """The first of these channels that the ride has, in SI units; nothing where it has none."""
    for name in names:
        if column(table, name)[0] in table:
            return channel(table, name)
    return None


def derivatives(t, y):
    """The spline through y and its three derivatives at the beginning of each interval."""
    c = CubicSpline(t, y).c
    return np.array([c[3], c[2], 2 * c[1], 6 * c[0]]).T


def simulate(t, u, F, zm, m, k, B, rest_point):
    """m z'' = k (u - z) + B (u' - z') + F, exact for cubic splines u and F; from rest on the road where z was not measured."""
    h = (t[-1] - t[0]) / (len(t) - 1)
    system = np.array([[0, 1], [-k / m, -B / m]])

    def step(into):
        whole = np.zeros((6, 6))
        whole[:2, :2] = system
        whole[1, 2 : 2 + len(into)] = into
        whole[2:, 2:] = np.diag(np.ones(3), 1)
        return expm(h * whole)[:2]

    road, push = step([k / m, B / m]), step([1 / m])[:, 2:]
    whole = np.zeros((3, 3))
    whole[:2, :2], whole[1, 2] = system, 1
    constant = expm(h * whole)[:2]
    x = np.zeros((len(t), 2))
    free = np.zeros((len(t), 3, 2))
    free[0, 0, 0] = free[0, 1, 1] = 1
    du, dF = derivatives(t, lifted(u)), derivatives(t, lifted(F))
    for i in range(len(t) - 1):
        x[i + 1] = road[:, :2] @ x[i] + road[:, 2:] @ du[i] + push @ dF[i]
        free[i + 1] = free[i] @ constant[:, :2].T
        free[i + 1, 2] += constant[:, 2]
    if zm is None:
        return x[:, 0] + u[0] * free[:, 0, 0]
    # The initial state, and on a shaker the rest point, that suit the measurement best.
    G = free[:, : 2 + rest_point, 0]
    known = np.isfinite(zm)
    return x[:, 0] + G @ np.linalg.lstsq(G[known], (zm - x[:, 0])[known], rcond=None)[0]


def answer(t, d, Fm, k, B):
    """F = k d + B d' + constant to the deflection d that a rig prescribes; the constant suits the measurement."""
    F = k * d + B * CubicSpline(t, d)(t, 1)
    return F + np.mean(Fm - F)


def main(file):
    """Times (s), and by axle what the model predicts (m; N where a rig prescribes the motion)."""
    table = read(file)
    t = channel(table, "t")
    used = np.ones(len(t), bool)
    if PART is not None:
        used = (t > PART[0] - 1e-9) & (t < PART[1] + 1e-9)
    t = t[used]
    predicted = {}
    for axle, m, k, B in AXLES:
        letter = axle[0]
        u, F, z, d = (first(table, [name + letter]) for name in ("u_", "force_", "z_", "d_"))
        u, F, z, d = (None if x is None else x[used] for x in (u, F, z, d))
        if m == 0:
            moved = z if z is not None else d if d is not None else u
            if np.sum(np.diff(moved) * (F[1:] + F[:-1])) < 0:
                F = -F
            measured, unit = F, "N"
            predicted[axle] = answer(t, moved, F, k, B)
        elif z is None:
            if u is None:
                print(f"{axle}: there is no road u_{letter}: this needs {AS_READ}", file=sys.stderr)
                continue
            if np.ptp(np.diff(t)) > 1e-3 * np.mean(np.diff(t)):
                sys.exit(f"The time stamps are not even: this needs {AS_READ}")
            predicted[axle] = z = simulate(t, u, np.zeros(len(t)), None, m, k, B, False)
            print(f"{axle}: displacement {np.std(z):.6g} m RMS on a road of {np.std(u):.6g} m RMS")
            continue
        else:
            none = np.zeros(len(t))
            rest_point = F is not None or u is None
            measured, unit = z, "m"
            predicted[axle] = simulate(
                t, none if u is None else u, none if F is None else F, z, m, k, B, rest_point
            )
        error = np.sqrt(np.nanmean((measured - predicted[axle]) ** 2))
        print(f"{axle}: error {error:.6g} {unit} over the whole ride; the report has no held-out error of this model")
    if not predicted:
        sys.exit(1)
    return t, predicted


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else FILE)
