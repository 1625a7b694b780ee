function said = check(file, varargin)
% VIBRO.CHECK  Summarise a machine: bodies, elements, equilibrium, natural frequencies
%
%   disp(vibro.check('damper.toml'))
%   said = vibro.check('damper.toml', 'set', 'stop.steel.gap=3mm');
%
%   The result is the text that `vibro check` prints.
  said = vibro.inner.written('check', file, varargin{:});
end
