function rows = cells(text, path)
% Cells of a CSV text, a row for each line. A cell in quotation marks may contain commas, line ends
% and doubled quotation marks.
  text = strrep(text, sprintf('\r\n'), sprintf('\n'));
  if isempty(text) || text(end) ~= sprintf('\n')
    text = [text, sprintf('\n')];
  end
  outside = mod(cumsum(text == '"'), 2) == 0;
  ends = find(outside & (text == ',' | text == sprintf('\n')));
  lines = text(ends) == sprintf('\n');
  columns = find(lines, 1);
  count = sum(lines);
  if ~outside(end) || isempty(columns) || numel(ends) ~= count * columns ...
      || ~all(lines(columns:columns:end))
    error('vibro:refused', '%s: the rows have different numbers of cells; expected a table (CSV)', path);
  end
  widths = diff([0, ends]);
  found = mat2cell(text(1:ends(end)), 1, widths);
  found = cellfun(@(cell) cell(1:end - 1), found, 'UniformOutput', false);
  if any(text == '"')
    found = regexprep(found, '^"([\s\S]*)"$', '$1');
    found = strrep(found, '""', '"');
  end
  rows = reshape(found, columns, count).';
end
