function found = orbit(file, varargin)
% VIBRO.ORBIT  Compute one periodic orbit of a machine, stable or not
%
%   found = vibro.orbit('damper.toml', 'period', '1T');
%
%   The tables `found.orbit_events`, `found.orbit_multipliers` and `found.orbit_energies` describe the
%   orbit; `found.said` has its stability.
%
%   Further arguments are options of `vibro orbit`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro orbit --help` lists all options.
  found = vibro.inner.study('orbit', file, varargin{:});
end
