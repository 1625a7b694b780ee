function [words, out] = options(pairs)
% Options of a command: 'name', value, ... as {'--name=value', ...}. A cell repeats its option; true
% gives an option without a value, false leaves the option out. `out` is the folder of the results.
  words = {};
  out = '';
  if mod(numel(pairs), 2) ~= 0
    error('vibro:refused', ['%d arguments after the file is an odd number; expected pairs of a name ', ...
          'and a value, such as ''until'', ''2s'''], numel(pairs));
  end
  for k = 1:2:numel(pairs)
    name = strrep(vibro.inner.text(pairs{k}, 'the name of an option'), '_', '-');
    if isempty(regexp(name, '^[a-z][a-z0-9-]*$', 'once'))
      error('vibro:refused', ['option "%s": expected the name of an option of the command line ', ...
            'without its dashes, such as ''until'''], name);
    end
    values = pairs{k + 1};
    if ~iscell(values)
      values = {values};
    end
    for i = 1:numel(values)
      value = values{i};
      if islogical(value) && isscalar(value)
        if value
          words{end + 1} = ['--', name];
        end
        continue
      end
      value = vibro.inner.text(value, ['option "', name, '"']);
      if strcmp(name, 'out') && isempty(value)
        error('vibro:refused', 'option "out" is empty; expected the name of a folder');
      elseif strcmp(name, 'out')
        out = value;
      else
        words{end + 1} = ['--', name, '=', value];
      end
    end
  end
end
