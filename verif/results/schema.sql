-- The database of results, build/history/results.sqlite: one row of `result` for each file of evidence, and
-- below it what the file holds. Whatever reads SQLite may read it; what was not measured is NULL, never 0.
-- Times are UTC, ISO 8601; `passed`, `flaky` and `silent` are 0 or 1. Another PRAGMA user_version adds
-- to the one before; what is there stays as it is.

CREATE TABLE result (
  id INTEGER PRIMARY KEY,
  -- What tells it from every other: the hash of what is in a file that no repetition would write again.
  key TEXT NOT NULL UNIQUE,
  -- smoke, nightly (or another regression's name, and how many times its seeds), sign-off, mutation, power.
  kind TEXT NOT NULL,
  finished TEXT NOT NULL,
  command TEXT NOT NULL,
  seed INTEGER NOT NULL,
  passed INTEGER NOT NULL,
  summary TEXT NOT NULL,
  seconds REAL NOT NULL,
  -- Checked in all, of runs that left their counts; runs that failed; functional bins hit.
  pairs INTEGER,
  failures INTEGER,
  coverage_percent REAL,
  git_commit TEXT,
  -- What it is valid for, together with the simulator.
  rtl_hash TEXT NOT NULL,
  environment_hash TEXT NOT NULL,
  verilator TEXT NOT NULL,
  python TEXT NOT NULL
);

-- Why it failed, a line each; and what a sign-off was without, such as what it took as recorded.
CREATE TABLE problem (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  said TEXT NOT NULL
);
CREATE TABLE exception (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  said TEXT NOT NULL
);

-- A test that ran once. `said`: what a failed one said, as its bucket; `log`: from the root of the checkout.
CREATE TABLE run (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  test TEXT NOT NULL,
  config TEXT NOT NULL,
  agent TEXT NOT NULL,
  seed INTEGER NOT NULL,
  pairs INTEGER,
  passed INTEGER NOT NULL,
  -- It failed and passed on the same sources, within this result.
  flaky INTEGER NOT NULL,
  -- It left no result of its own (killed, not built), which says nothing of its seed.
  silent INTEGER NOT NULL,
  seconds REAL NOT NULL,
  said TEXT,
  log TEXT NOT NULL,
  replay TEXT NOT NULL
);

-- A part of a sign-off, with its testpoints where it is the testplan.
CREATE TABLE part (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  passed INTEGER,
  seconds REAL,
  summary TEXT
);
CREATE TABLE testpoint (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  stage TEXT NOT NULL,
  passed INTEGER
);

-- Bins that were hit (or waived), of those that are goals. `kind`: functional, with a model and a cover item,
-- or code, with a file of RTL and what is counted: line, branch, expression, toggle, fsm, antecedent.
CREATE TABLE covered (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  kind TEXT NOT NULL,
  place TEXT NOT NULL,
  item TEXT NOT NULL,
  hit INTEGER NOT NULL,
  total INTEGER NOT NULL
);

-- What became of a mutant. Each is tried until a test notices it: of `test` it is known that it does, of no
-- other that it does not. Of results on the same RTL and environment the newest alone keeps them.
CREATE TABLE mutant (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  id TEXT NOT NULL,
  file TEXT NOT NULL,
  line INTEGER NOT NULL,
  original TEXT NOT NULL,
  changed TEXT NOT NULL,
  fate TEXT NOT NULL,
  by TEXT,
  test TEXT,
  target TEXT
);

-- A sample of mutants that met every short test of a model: of each test how many it noticed of those `tried`,
-- how many no other did, whether it is among the fewest that notice all; and which test noticed which.
CREATE TABLE power (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  model TEXT NOT NULL,
  test TEXT NOT NULL,
  tried INTEGER NOT NULL,
  noticed INTEGER NOT NULL,
  alone INTEGER NOT NULL,
  in_fewest INTEGER NOT NULL
);
CREATE TABLE noticed (
  result INTEGER NOT NULL REFERENCES result (id) ON DELETE CASCADE,
  model TEXT NOT NULL,
  mutant TEXT NOT NULL,
  -- NULL: no test of this model.
  test TEXT
);

CREATE INDEX run_of ON run (result);
CREATE INDEX run_by ON run (test, config, agent);
CREATE INDEX covered_of ON covered (result);
CREATE INDEX mutant_of ON mutant (result);
CREATE INDEX noticed_of ON noticed (result);

-- Each test in each configuration: how it fared, and what it took.
CREATE VIEW test AS
SELECT test, config, agent, count(*) AS runs, count(*) - sum(passed) AS failed, sum(pairs) AS pairs,
  avg(seconds) AS mean_seconds, max(seconds) AS most_seconds,
  (SELECT log FROM run AS one WHERE (one.test, one.config, one.agent) = (run.test, run.config, run.agent)
    ORDER BY one.rowid DESC LIMIT 1) AS last_log
FROM run GROUP BY test, config, agent;

-- Seeds that both failed and passed on the same RTL, environment and simulator.
CREATE VIEW flaky AS
SELECT test, config, agent, run.seed, run.pairs, count(*) AS runs, count(*) - sum(run.passed) AS failed,
  max(finished) AS last, max(replay) AS replay
FROM run JOIN result ON result.id = run.result
WHERE NOT silent
GROUP BY rtl_hash, environment_hash, verilator, test, config, agent, run.seed, replay
HAVING max(flaky) OR min(run.passed) < max(run.passed);

-- Which test noticed how many mutants of which file, in each result.
CREATE VIEW kills AS
SELECT result, test, file, count(*) AS mutants FROM mutant WHERE fate = 'killed' GROUP BY result, test, file;
