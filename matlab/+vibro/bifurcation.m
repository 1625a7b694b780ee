function found = bifurcation(file, varargin)
% VIBRO.BIFURCATION  Local maxima of a quantity over a parameter, in both directions
%
%   found = vibro.bifurcation('damper.toml', 'vary', 'stop.steel.gap=1mm:8mm:50', 'of', 'box.s');
%
%   The table `found.bifurcation` has a row for each maximum.
%
%   Further arguments are options of `vibro bifurcation`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro bifurcation --help` lists all options.
  found = vibro.inner.study('bifurcation', file, varargin{:});
end
