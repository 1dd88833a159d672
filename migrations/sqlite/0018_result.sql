-- The result of every job that finished before reports had one, among its parameters: by the extended model where the verdict
-- is on effects, else by output error or without a road; none where there is no verdict, no standard error where what acts has
-- no name.
INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at, group_name)
SELECT job_id, 'result', axle, name, bike, value, CASE WHEN verdict = 'unnamed' THEN NULL ELSE std_error END,
    unit, verdict, version, identified_at, group_name
FROM parameter AS found
WHERE name IN ('k_n_m', 'b_n_s_m', 'mass_kg') AND std_error IS NOT NULL
    AND (method = 'latent_road' OR verdict IS NULL OR verdict <> 'cannot_tell')
    AND method = (
        SELECT best.method FROM parameter AS best
        WHERE best.job_id = found.job_id AND best.axle = found.axle AND best.name = found.name
            AND best.method IN ('extended', 'output_error', 'latent_road')
            AND (best.method <> 'extended' OR found.verdict IN ('named', 'named_in_part', 'ambiguous'))
        ORDER BY CASE best.method WHEN 'extended' THEN 1 WHEN 'output_error' THEN 2 ELSE 3 END
        LIMIT 1
    );
