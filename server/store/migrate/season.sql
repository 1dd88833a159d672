INSERT INTO bike (name, document, created_at, updated_at{group})
VALUES ('season-001', '{"bike": "season-001", "mass_front_kg": 23.0}', 1700000000000, 1700000000000{home});

INSERT INTO ride (id, sha256, name, bytes, uploaded_at{group})
VALUES (#6, 'season', 'season-001 0189', 0, 1700000000000{home}), (#7, 'season', 'lab-7 0189', 0, 1700000000000{home});

INSERT INTO job (id, ride_id, bike, fingerprint, request, summary, state, stage, revision, trials_total, trials_done, takeovers,
    verdict, created_at, finished_at{group})
SELECT #6, #6, 'season-001', '', request, summary, 'succeeded', 'diagnose', 1, 10, 10, 0, 'named', 1700000000000, 1700000000000{home}
FROM job WHERE id = #2;

INSERT INTO job (id, ride_id, bike, fingerprint, request, summary, state, stage, revision, trials_total, trials_done, takeovers,
    verdict, created_at, finished_at{group})
SELECT #7, #7, 'lab-7', '', request, summary, 'succeeded', 'diagnose', 1, 10, 10, 0, 'named', 1700000000000, 1700000000000{home}
FROM job WHERE id = #2;

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#6, 'swarm', 'front', 'k_n_m', 'season-001', 110000.0, NULL, 'N/m', 'named', '0.1.0', 1700000000000{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#7, 'swarm', 'front', 'k_n_m', 'lab-7', 110000.0, NULL, 'N/m', 'named', '0.1.0', 1700000000000{home});

-- from 10
INSERT INTO ride_tag (ride_id, tag) VALUES (#6, 'wet');

-- from 14
INSERT INTO bike_told (group_name, bike, axle, name, kind) VALUES ('default', 'season-001', 'front', 'k_n_m', 'drift')
