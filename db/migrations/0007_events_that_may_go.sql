-- The retention finds the oldest events that may leave without looking at those that stay (parts and runs).
CREATE INDEX events_that_may_go ON events (received_ms) WHERE kind NOT IN ('part', 'run_started', 'run_ended');
