-- Numbers that the methods gave where the result withholds k or B. An axle that only the method without a road
-- identified keeps what has a standard error: its reports lack a result. A base model without a spring has no k.
DELETE FROM parameter
WHERE method <> 'result' AND name IN ('k_n_m', 'b_n_s_m')
    AND NOT EXISTS (
        SELECT 1 FROM parameter AS stated
        WHERE stated.job_id = parameter.job_id AND stated.method = 'result'
            AND stated.axle = parameter.axle AND stated.name = parameter.name
    )
    AND NOT (
        method = 'latent_road' AND std_error IS NOT NULL
        AND NOT EXISTS (
            SELECT 1 FROM parameter AS other
            WHERE other.job_id = parameter.job_id AND other.method = 'output_error'
                AND other.axle = parameter.axle AND other.name = parameter.name
        )
    );
