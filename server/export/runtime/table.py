

def read(file):
    """Columns of a table, as text, by their headers: separator , ; or tab; lines with # do not count."""
    with open(file, encoding="utf-8-sig") as lines:
        lines = [line for line in lines if line.strip() and not line.startswith("#")]
    separator = max(",;\t", key=lines[0].count)
    rows = zip(*(line.rstrip("\r\n").split(separator) for line in lines))
    return {cells[0].strip().strip('"'): cells[1:] for cells in rows}


def number(cell):
    return float(cell.strip().replace(",", ".") or "nan")


def column(table, name):
    """Header and factor of a channel; the table is the ride's file, or the ride as veloid read it."""
    return (name, 1.0) if "veloid_sample" in table else CHANNELS.get(name, (None, 1.0))


def channel(table, name):
    """A channel in SI units."""
    header, scale = column(table, name)
    if header not in table:
        sys.exit(f"There is no column for {name}: this needs {AS_READ}")
    return scale * np.array([number(cell) for cell in table[header]])
