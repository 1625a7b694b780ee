function found = sweep(file, varargin)
% VIBRO.SWEEP  Evaluate many designs of a machine
%
%   found = vibro.sweep('damper.toml', 'vary', {'stop.steel.gap=1mm:8mm:8', 'body.block.mass=0.2kg:0.5kg:4'});
%
%   The table `found.sweep` has a row for each design.
%
%   Further arguments are options of `vibro sweep`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro sweep --help` lists all options.
  found = vibro.inner.study('sweep', file, varargin{:});
end
