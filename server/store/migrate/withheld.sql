INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#3, 'result', 'front', 'b_n_s_m', 'lab-7', 900.0, 20.0, 'SI', 'cannot_tell', '0.1.0', 1700000000011{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#3, 'output_error', 'front', 'b_n_s_m', 'lab-7', 900.0, 20.0, 'SI', 'cannot_tell', '0.1.0', 1700000000011{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#3, 'output_error', 'front', 'k_n_m', 'lab-7', 66.05, NULL, 'SI', 'cannot_tell', '0.1.0', 1700000000011{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#3, 'swarm', 'front', 'k_n_m', 'lab-7', 66.05, NULL, 'SI', 'cannot_tell', '0.1.0', 1700000000011{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#3, 'latent_road', 'front', 'k_n_m', 'lab-7', 66.05, 0.5, 'SI', 'cannot_tell', '0.1.0', 1700000000011{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#3, 'latent_road', 'rear', 'k_n_m', 'lab-7', 118200.0, 200.0, 'SI', 'cannot_tell', '0.1.0', 1700000000011{home});

INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at{group})
VALUES (#3, 'latent_road', 'rear', 'b_n_s_m', 'lab-7', 900.0, NULL, 'SI', 'cannot_tell', '0.1.0', 1700000000011{home});
