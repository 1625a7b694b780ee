function found = basin(file, varargin)
% VIBRO.BASIN  Basins of attraction over two initial values
%
%   found = vibro.basin('damper.toml', 'start', {'block.s=-4mm:4mm:20', 'block.v=-1:1:20'});
%
%   The table `found.basin` has a row for each cell, `found.basin_attractors` one for each attractor.
%
%   Further arguments are options of `vibro basin`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro basin --help` lists all options.
  found = vibro.inner.study('basin', file, varargin{:});
end
