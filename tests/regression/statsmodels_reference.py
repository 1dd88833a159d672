"""What statsmodels says of a made-up fleet: the numbers that server/fleet/regression is held against.

    python -m venv venv && venv/bin/pip install statsmodels==0.15.0
    venv/bin/python tests/regression/statsmodels_reference.py > tests/regression/statsmodels.json

Once without errors of the rides, by MixedLM; once with them, which MixedLM does not know: variances by maximising the restricted
likelihood with dense matrices (scipy), coefficients by GLS at them. A third one is a single bicycle.
"""

import json

import numpy as np
from scipy.optimize import minimize
from statsmodels.regression.linear_model import GLS
from statsmodels.regression.mixed_linear_model import MixedLM

random = np.random.default_rng(20261123)
RIDES = [14, 9, 21, 6, 17, 11, 3]


def fleet(rides):
    bikes = np.repeat(np.arange(len(rides)), rides)
    pressure = 2.2 + 0.3 * random.standard_normal(len(bikes)) + 0.2 * random.standard_normal(len(rides))[bikes]
    temperature = 15 + 7 * random.standard_normal(len(bikes))
    errors = 300 * np.exp(0.6 * random.standard_normal(len(bikes)))
    levels = 4000 * random.standard_normal(len(rides))
    scatter = 900 * random.standard_normal(len(bikes)) + errors * random.standard_normal(len(bikes))
    values = 110e3 + 21e3 * (pressure - 2.2) - 120 * (temperature - 15) + levels[bikes] + scatter
    return bikes, values.round(3), errors.round(3), np.column_stack([pressure, temperature]).round(4)


def dense(bikes, values, errors, facts):
    design = np.column_stack([np.ones(len(values)), facts - facts.mean(axis=0)])
    same = (bikes[:, None] == bikes[None, :]).astype(float)
    several = len(set(bikes)) > 1

    def covariance(logs):
        between = np.exp(logs[1]) * same if several else 0.0
        return np.diag(np.exp(logs[0]) + errors**2) + between

    def criterion(logs):
        v = covariance(logs)
        inverse = np.linalg.inv(v)
        information = design.T @ inverse @ design
        left = values - design @ np.linalg.solve(information, design.T @ inverse @ values)
        return np.linalg.slogdet(v)[1] + np.linalg.slogdet(information)[1] + left @ inverse @ left

    options = {"xatol": 1e-10, "fatol": 1e-12, "maxiter": 4000}
    found = minimize(criterion, np.log([8e5, 1.6e7])[: 1 + several], method="Nelder-Mead", options=options)
    fit = GLS(values, design, sigma=covariance(found.x)).fit()
    errors = np.sqrt(np.diag(fit.normalized_cov_params))
    return fit.params, errors, np.sqrt(np.exp(found.x))


def mixed(bikes, values, errors, facts):
    design = np.column_stack([np.ones(len(values)), facts - facts.mean(axis=0)])
    # In thousands: its optimiser stops by absolute sizes.
    fit = MixedLM(values / 1e3, design, groups=bikes).fit(reml=True, method="lbfgs", gtol=1e-10)
    deviations = np.sqrt([fit.scale, fit.cov_re[0, 0]])
    return 1e3 * fit.fe_params, 1e3 * fit.bse_fe, 1e3 * deviations


def case(name, method, data):
    params, errors, deviations = method(*data)
    bikes, values, known, facts = data
    return {
        "name": name, "bikes": bikes.tolist(), "values": values.tolist(), "errors": known.tolist(), "facts": facts.tolist(),
        "params": list(params), "std_errors": list(errors), "between_rides": deviations[0],
        "between_bikes": deviations[1] if len(deviations) > 1 else None,
    }


bikes, values, errors, facts = fleet(RIDES)
cases = [
    case("MixedLM", mixed, (bikes, values, np.zeros_like(errors), facts)),
    case("GLS at REML", dense, (bikes, values, errors, facts)),
    case("one bicycle", dense, fleet([40])),
]
print(json.dumps(cases, indent=None).replace('{"name"', '\n{"name"'))
