function found = names(columns)
% Names of a table's columns, in the order of its file.
  if isstruct(columns)
    found = fieldnames(columns).';
  else
    found = columns.Properties.VariableNames;
  end
end
