
# Changes of height (m), velocity (m/s) and constant force (N) that show what they do.
START_STEPS = 1e-6, 1e-5, 1e-2


def fitted(axles):
    """Height (m), velocity (m/s) and constant force (N) at the start that suit the measurement best (Gauss-Newton)."""
    if axles[0].measured is None:
        return [(axle.road[0][0], 0.0, 0.0) for axle in axles]
    for axle in axles:
        if not np.any(axle.fitted_to):
            sys.exit(f"{axle.name}: nothing was measured in the part that the start is fitted to")
    samples = max(np.flatnonzero(axle.fitted_to)[-1] for axle in axles) + 1
    starts = np.array([[axle.measured[np.argmax(axle.fitted_to)], 0.0, 0.0] for axle in axles])
    free = [(a, q) for a, axle in enumerate(axles) for q in axle.model["free"]]

    def left(starts):
        predicted = zip(axles, predict(axles, starts.tolist(), samples))
        return np.concatenate([(axle.measured[:samples] - y)[axle.fitted_to[:samples]] for axle, y in predicted])

    for _ in range(ROUNDS):
        now, slopes = left(starts), []
        for a, q in free:
            other = starts.copy()
            other[a, q] += START_STEPS[q]
            slopes.append((now - left(other)) / START_STEPS[q])
        for (a, q), change in zip(free, np.linalg.lstsq(np.array(slopes).T, now, rcond=None)[0]):
            starts[a, q] += change
    return starts.tolist()


def simulated(file, own):
    """Ride, axles and what the model predicts; nothing where the ride is to be the model's own and is another."""
    ride = Ride(file, PART if own else None)
    is_own = ride.samples == SAMPLES and abs(ride.step / STEP - 1) < 1e-6
    if own and not (is_own and (ride.as_read or "speed_rate" not in NEEDED)):
        return None
    axles = [Axle(ride, name, model, own) for name, model in MODELS.items()]
    if own and not all(axle.is_measured_so() for axle in axles):
        return None
    predicted = {}
    for group in [axles] if PITCH is not None else [[axle] for axle in axles]:
        starts = None if own and "start" in group[0].model else fitted(group)
        for axle, y in zip(group, predict(group, starts, ride.samples)):
            predicted[axle.name] = y
            known = axle.model.get("error")
            if own and known is not None and not abs(axle.error(y) / known - 1) < 1e-6:
                return None
    return ride, axles, predicted


def main(file):
    """Times (s), and by axle what the model predicts (m; N where a rig prescribes the motion)."""
    own = simulated(file, True)
    ride, axles, predicted = own or simulated(file, False)
    for axle in axles:
        y = predicted[axle.name]
        if NEEDS_ROAD:
            print(f"{axle.name}: displacement {np.std(y):.6g} m RMS")
        if axle.measured is None:
            continue
        error = f"error {axle.error(y):.6g} {axle.unit}"
        if own:
            print(f"{axle.name}: {'held-out ' if 'start' in axle.model else ''}{error}, {axle.model['report']}")
        else:
            measured = axle.measured[axle.counts]
            fit = 1 - np.linalg.norm(measured - y[axle.counts]) / np.linalg.norm(measured - np.mean(measured))
            start = np.sum(axle.fitted_to) * ride.step
            print(f"{axle.name}: {error}, fit {100 * fit:.6g} %, from a start that is fitted to {start:.3g} s")
    return ride.t, predicted


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else FILE)
