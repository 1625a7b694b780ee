function found = section(file, varargin)
% VIBRO.SECTION  Poincaré section of the settled motion of a machine
%
%   found = vibro.section('damper.toml', 'section', 'steel', 'keep', 200);
%
%   The table `found.section` has a row for each return.
%
%   Further arguments are options of `vibro section`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro section --help` lists all options.
  found = vibro.inner.study('section', file, varargin{:});
end
