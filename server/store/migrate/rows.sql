INSERT INTO bike (name, document, created_at, updated_at{group})
VALUES ('lab-7', '{"bike": "lab-7", "mass_front_kg": 23.0, "mass_rear_kg": 63.0, "l_front_m": 0.808, "l_rear_m": 0.293}', 1700000000000, 1700000000001{home});

INSERT INTO ride (id, sha256, name, bytes, uploaded_at{group})
VALUES (#1, 'ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad', 'ride.csv', 3, 1700000000002{home});

INSERT INTO job (id, ride_id, bike, fingerprint, request, summary, state, stage, revision, trials_total, trials_done, takeovers, river_id,
    least_squares, verdict, failure, created_at, started_at, observed_at, finished_at{group})
VALUES (#2, #1, 'lab-7', 'f2',
    '{"bike": {"bike": "lab-7", "mass_front_kg": 23.0, "mass_rear_kg": 63.0}, "options": {"seed": 7, "trials": 1, "rate_hz": 200.0}}',
    '{"sha256": "ba78", "rows": 4000, "samples": 4000, "duration_s": 20.0, "rate_hz": 200.0, "columns": [], "ignored": ["x"], "warnings": []}',
    'succeeded', 'diagnose', 6, 1, 1, 0, NULL,
    '{"front": {"k_n_m": 110000.0, "b_n_s_m": 1200.0, "k_std_n_m": 10.0, "b_std_n_s_m": 1.0, "mass_kg": 23.0}, "rear": null}',
    'named', NULL, 1700000000003, 1700000000004, 1700000000005, 1700000000006{home});

INSERT INTO job (id, ride_id, bike, fingerprint, request, summary, state, stage, revision, trials_total, trials_done, takeovers, river_id,
    least_squares, verdict, failure, created_at, started_at, observed_at, finished_at{group})
SELECT #3, ride_id, bike, 'f3', request, summary, 'failed', 'observe', 3, 1, 0, 3, NULL,
    NULL, NULL, '{"kind": "crash", "detail": "three times"}', 1700000000007, NULL, NULL, 1700000000008{home}
FROM job WHERE id = #2;

INSERT INTO job (id, ride_id, bike, fingerprint, request, summary, state, stage, revision, trials_total, trials_done, takeovers, river_id,
    least_squares, verdict, failure, created_at, started_at, observed_at, finished_at{group})
SELECT #4, ride_id, bike, 'f4', request, summary, 'queued', 'observe', 1, 1, 0, 0, {river},
    NULL, NULL, NULL, 1700000000009, NULL, NULL, NULL{home}
FROM job WHERE id = #2;

INSERT INTO trial (job_id, trial_index, seed, river_id, cost, result, finished_at)
VALUES (#2, 0, 7, 1, 0.25, '{"seed": 7, "best_cost": [0.5, 0.25], "best_position": [[1.0, 2.0], [3.0, 4.0]], "front": null, "rear": null}', 1700000000010);

INSERT INTO result (job_id, name, document) VALUES (#2, 'report', '{"veloid": "0.1.0"}');

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#2, 'extended', 'front', 'coulomb_friction.friction', 'lab-7', 20.5, 0.5, 'N', 'named', '0.1.0', 1700000000011{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#2, 'output_error', 'front', 'k_n_m', 'lab-7', 110000.0, NULL, 'N/m', 'named', '0.1.0', 1700000000011{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#2, 'extended', 'front', 'k_n_m', 'lab-7', 109000.0, 210.0, 'N/m', 'named', '0.1.0', 1700000000011{home});

-- from 18
INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#2, 'result', 'front', 'k_n_m', 'lab-7', 109000.0, 210.0, 'N/m', 'named', '0.1.0', 1700000000011{home});

INSERT INTO idempotency_key (name, fingerprint, job_id, created_at{group})
VALUES ('once', 'f2', #2, 1700000000012{home});

INSERT INTO worker (id, version, slots, started_at, beat_at) VALUES ('w', '0.1.0', 2, 1700000000013, 1700000000014);

-- from 3
INSERT INTO api_key (id, sha256, name, group_name, scopes, max_upload_bytes, requests_per_minute, unfinished_jobs, created_at, expires_at, last_used_at, revoked_at)
VALUES (#5, 'cd', 'logger', 'default', 'upload', 1000, NULL, NULL, 1700000000015, NULL, 1700000000016, NULL);

-- from 4
UPDATE job SET key_id = #5 WHERE id = #4;

-- from 4
INSERT INTO bike (name, document, created_at, updated_at, group_name)
VALUES ('lab-7', '{"bike": "lab-7", "mass_front_kg": 9.0}', 1700000000017, 1700000000017, 'others');

-- from 17
INSERT INTO bike_event (id, group_name, bike, day, text, created_at, deleted_at)
VALUES (#6, 'default', 'lab-7', 1699920000000, 'new tyre', 1700000000018, NULL);
