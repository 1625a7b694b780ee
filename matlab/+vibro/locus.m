function found = locus(file, varargin)
% VIBRO.LOCUS  Follow special points of orbits over two parameters
%
%   all = vibro.orbits('damper.toml', 'tree', true, 'vary', 'stop.steel.gap=1mm:8mm', 'out', 'all');
%   found = vibro.locus('damper.toml', 'from', 'all/special-points.csv:PD', ...
%                       'vary', {'stop.steel.gap=1mm:8mm', 'body.block.mass=0.2kg:0.5kg'});
%
%   The table `found.locus` has the points of all curves.
%
%   Further arguments are options of `vibro locus`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro locus --help` lists all options.
  found = vibro.inner.study('locus', file, varargin{:});
end
