function found = tables(folder)
% Every table of a folder, and the results of a fit: `special-points.csv` is found.special_points,
% `fit.json` is found.fit.
  found = struct();
  entries = dir(folder);
  for k = 1:numel(entries)
    [~, name, ending] = fileparts(entries(k).name);
    field = regexprep(name, '[^A-Za-z0-9_]', '_');
    if entries(k).isdir || ~isvarname(field) || any(strcmp(field, {'command', 'said', 'folder'}))
      continue
    end
    path = fullfile(folder, entries(k).name);
    if strcmp(ending, '.csv')
      found.(field) = vibro.read_table(path);
    elseif strcmp(entries(k).name, 'fit.json')
      found.fit = vibro.inner.json(fileread(path));
    end
  end
end
