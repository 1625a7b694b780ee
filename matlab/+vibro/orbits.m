function found = orbits(file, varargin)
% VIBRO.ORBITS  Follow branches of periodic orbits over a parameter, stable or not
%
%   found = vibro.orbits('damper.toml', 'tree', true, 'vary', 'stop.steel.gap=1mm:8mm');
%
%   The table `found.branches` has a row for each orbit, `found.special_points` one for each fold,
%   doubling, touch and other special point.
%
%   Further arguments are options of `vibro orbits`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro orbits --help` lists all options.
  found = vibro.inner.study('orbits', file, varargin{:});
end
