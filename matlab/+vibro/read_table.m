function columns = read_table(path)
% VIBRO.READ_TABLE  Read a table (CSV) of the program vibro.
%
%   states = vibro.read_table('run/states.csv');
%   plot(states.('time'), states.('box.s'))
%
% The result is a table in MATLAB and a struct in Octave. Its columns have the names of the file, so
% that states.('box.s') is the same in both. A column of numbers is a column vector of doubles with
% every digit of the file; an empty cell is NaN. Any other column is a cell array of texts.
  path = vibro.inner.text(path, 'path of a table');
  if exist(path, 'file') ~= 2
    error('vibro:refused', '%s: no such file; expected a table (CSV)', path);
  end
  cells = vibro.inner.cells(fileread(path), path);
  names = cells(1, :);
  values = cell(1, numel(names));
  for k = 1:numel(names)
    values{k} = vibro.inner.numbers(cells(2:end, k));
  end
  if exist('OCTAVE_VERSION', 'builtin')
    columns = struct();
    for k = 1:numel(names)
      columns.(names{k}) = values{k};
    end
  else
    names = matlab.lang.makeUniqueStrings(names, {}, namelengthmax);
    columns = table(values{:}, 'VariableNames', names);
  end
end
