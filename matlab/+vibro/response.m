function found = response(file, varargin)
% VIBRO.RESPONSE  Response curves of a machine with stable and unstable parts
%
%   found = vibro.response('damper.toml', 'vary', 'load.shaker.frequency=8Hz:12Hz', 'of', 'amplitude.box.s');
%   vibro.show(found)
%
%   The table `found.response` has a row for each orbit, `found.special_points` one for each fold,
%   doubling, touch and other special point.
%
%   Further arguments are options of `vibro response`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro response --help` lists all options.
  found = vibro.inner.study('response', file, varargin{:});
end
