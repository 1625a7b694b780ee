function dump(found, path)
% Writes all tables of a result: a line "@table column", then a line for each cell. Numbers are
% written as the sixteen hexadecimal digits of their bits.
  file = fopen(path, 'w');
  closer = onCleanup(@() fclose(file));
  tables = setdiff(fieldnames(found), {'command', 'said', 'folder', 'fit'});
  for t = 1:numel(tables)
    columns = found.(tables{t});
    names = fieldnames(columns);
    for c = 1:numel(names)
      fprintf(file, '@%s %s\n', tables{t}, names{c});
      cells = columns.(names{c});
      if ~iscell(cells) && ~isempty(cells)
        cells = cellstr(num2hex(cells));
      end
      if ~isempty(cells)
        fprintf(file, '%s\n', cells{:});
      end
    end
  end
end
