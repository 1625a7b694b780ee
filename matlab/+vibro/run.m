function found = run(file, varargin)
% VIBRO.RUN  Simulate a motion of a machine exactly from event to event
%
%   run = vibro.run('damper.toml', 'until', '2s', 'samples', 1000, 'set', {'stop.steel.gap=3mm'});
%   plot(run.states.('time'), run.states.('block.s'))
%
%   The result has the tables `states`, `events`, `contacts`, and with 'derivatives' also `derivatives`
%   and `event_derivatives`; `run.said` is the account that the program prints.
%
%   Further arguments are options of `vibro run`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro run --help` lists all options.
  found = vibro.inner.study('run', file, varargin{:});
end
