function found = lyapunov(file, varargin)
% VIBRO.LYAPUNOV  Lyapunov exponents of a machine
%
%   found = vibro.lyapunov('damper.toml', 'spectrum', true);
%
%   The numbers are in a table of the result and in `found.said`.
%
%   Further arguments are options of `vibro lyapunov`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro lyapunov --help` lists all options.
  found = vibro.inner.study('lyapunov', file, varargin{:});
end
