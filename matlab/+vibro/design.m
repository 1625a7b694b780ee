function found = design(file, varargin)
% VIBRO.DESIGN  Find the parameters of a machine with the best output
%
%   found = vibro.design('damper.toml', 'minimize', 'amplitude.box.s', 'vary', 'stop.steel.gap=1mm:8mm');
%
%   The table `found.design` has a row for each design; `found.said` has the best one and the verdict.
%
%   Further arguments are options of `vibro design`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro design --help` lists all options.
  found = vibro.inner.study('design', file, varargin{:});
end
