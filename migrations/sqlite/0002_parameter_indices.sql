-- The fleet's parameters by verdict, newest first.
CREATE INDEX parameter_verdict ON parameter (verdict, job_id, method, axle, name);

-- Few parameters belong to both axles.
CREATE INDEX parameter_both ON parameter (job_id, method, axle, name) WHERE axle = 'both';
