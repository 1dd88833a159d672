

def read_road(ride, how, values, slopes):
    """Heights and slopes (for each sample) as the effects have them."""
    pieces = cubics(values, slopes)
    area = np.cumsum([0.0] + [c[0] + c[1] / 2 + c[2] / 3 + c[3] / 4 for c in pieces]).tolist()
    last = ride.samples - 1

    def at(position):
        """Height, slope and integral of the road at a place in samples."""
        position = min(max(position, 0.0), float(last))
        i = min(int(position), last - 1)
        s, c = position - i, pieces[i]
        height = c[0] + s * (c[1] + s * (c[2] + s * c[3]))
        slope = c[1] + s * (2 * c[2] + s * 3 * c[3])
        return height, slope, area[i] + s * (c[0] + s * (c[1] / 2 + s * (c[2] / 3 + s * c[3] / 4)))

    heights, rates = np.array(values), np.array(slopes)
    speed, _, _, distance = ride.bicycle
    for i in range(ride.samples):
        shift, half_window, more, more_rate = how(float(speed[i]), float(distance[i]))
        if shift or half_window:
            centre = i - shift / ride.step
            inside = min(max(centre, 0.0), float(last))
            half = min(half_window / ride.step, inside, last - inside)
            if half < 1e-6:
                heights[i], rates[i], _ = at(centre)
            else:
                (above, _, to), (below, _, begin) = at(centre + half), at(centre - half)
                heights[i], rates[i] = (to - begin) / (2 * half), (above - below) / (2 * half)
        heights[i] += more
        rates[i] += more_rate * ride.step
    return heights, rates
